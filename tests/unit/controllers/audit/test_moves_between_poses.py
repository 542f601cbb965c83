"""The audit follows the moves of a program: a post beside neither of two poses, but between them, is found."""

import numpy as np
import pytest

from tests.unit.conftest import CONFIGURATIONS, box_mesh
from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh import PartMesh
from wpcal.controllers.audit.programs import Surroundings, executed, executed_faults
from wpcal.controllers.program import ControllerSettings, build_program
from wpcal.controllers.program.few_moves import fit_program
from wpcal.controllers.registry import controller_named
from wpcal.core.transform import RigidTransform
from wpcal.results.folder import FinishedCalibration
from wpcal.robot.moves import Arc

WRITERS = ("rapid", "krl", "fanuc", "inform", "urscript", "val3", "as", "pdl2")
T = RigidTransform.identity(target="base", source="part")


def post_at(place, low=2.0, high=60.0):
    post = box_mesh("post", [*np.subtract(place, 2.0), low], [*np.add(place, 2.0), high])
    return TriangleMaterial.of(PartMesh((post,), 0.01, 0.5), T)


def half_circle(t):
    a = np.pi * t
    x = np.stack([-np.sin(a), np.cos(a), 0 * a], axis=1)
    return 80 * np.stack([np.cos(a), np.sin(a), 0 * a], axis=1), np.stack([x, np.cross(UP, x), 0 * x + UP], axis=2)


UP = np.array([0.0, 0.0, 1.0])


def straight(t):
    return np.outer(t, [160.0, 0, 0]), np.tile(np.eye(3), (len(t), 1, 1))


CURVES = {"straight": (straight, (80.0, 0.0)), "arc": (half_circle, (80 * np.cos(0.3), 80 * np.sin(0.3)))}


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("name", WRITERS)
def test_a_post_between_two_poses_is_found(name, curve, make_seam):
    points, place = CURVES[curve]
    p, R = points(np.linspace(0, 1, 33))
    finished = FinishedCalibration(T, (make_seam("W1", p, R, frame="base"),), (None,), {})
    program = fit_program(build_program(finished, controller=ControllerSettings(configurations=CONFIGURATIONS)))
    moves = program.paths[0].weld_moves
    files = {file: str(text).encode() for file, text in controller_named(name).write(program).items()}
    clean, blocked = (Surroundings(T, post_at(at)) for at in ((400.0, 400.0), place))
    trace, refused = executed(files, clean)
    assert (refused, list(executed_faults(trace, clean))) == ({}, [])
    ((_, fault),) = executed_faults(trace, blocked)
    assert "on the move there" in fault.message
    assert "inside 'post'" in fault.message
    assert sum(motion.kind == "C" for motion in trace.motions) == sum(isinstance(move, Arc) for move in moves)
