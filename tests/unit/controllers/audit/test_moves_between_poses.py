"""The audit follows the moves of a program: a post beside neither of two poses, but between them, is found."""

import numpy as np
import pytest

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh import PartMesh, SolidMesh
from wpcal.controllers.audit.programs import Surroundings, executed, executed_faults
from wpcal.controllers.program import ControllerSettings, build_program
from wpcal.controllers.program.few_moves import fit_program
from wpcal.controllers.registry import controller_named
from wpcal.core.transform import RigidTransform
from wpcal.results.folder import FinishedCalibration
from wpcal.robot.moves import Arc

WRITERS = ("rapid", "krl", "fanuc", "inform", "urscript", "val3", "as", "pdl2")
CONFIGURATIONS = {"fanuc": "N U T, 0, 0, 0", "inform": "1,0,0,0,0,0,0,0"}
T = RigidTransform.identity(target="base", source="part")
CORNERS = np.array([[x, y, z] for x in (-2, 2) for y in (-2, 2) for z in (0, 1)], dtype=float)
TRIANGLES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
     [1, 5, 7], [1, 7, 3]]
)  # fmt: skip


def post_at(place, low=2.0, high=60.0):
    corners = CORNERS * [1, 1, high - low] + [*place, low]
    return TriangleMaterial.of(PartMesh((SolidMesh("post", corners, TRIANGLES, np.zeros((0, 2), int)),), 0.01, 0.5), T)


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
