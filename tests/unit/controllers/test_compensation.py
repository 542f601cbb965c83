"""A program for an identified robot: the controller's own arithmetic takes the real arm to the true poses."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from tests.simulated_poses import XIONG_2015_ERRORS
from wpcal.cli.main import wpcal
from wpcal.controllers.program.compensation import compensate_program
from wpcal.controllers.program.followed_program import follow_program
from wpcal.controllers.program.reachable_spin import ArmAtTool
from wpcal.core.errors import FrameError
from wpcal.results.folder import read_finished
from wpcal.robot.compensation import NO_TOOL
from wpcal.robot.identify.parameters import KinematicModel, link_parameters
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.robot.kinematics.inverse import nearest_joints

SAME_MM = 1e-6  # two inverse solutions and their Newton steps
NOMINAL = find_arm("mh6")
REAL = NOMINAL.as_identified(
    KinematicModel(NOMINAL.chain).moved(link_parameters(NOMINAL.chain), XIONG_2015_ERRORS).chain
)
BRANCH = 0  # wrist in front of axis 1 and of the lower arm, not flipped
HOME = np.array([0.2, 0.3, -0.4, 0.3, 0.7, 0.2])


def test_the_controller_goes_where_the_seam_is(make_program):
    program = make_program(1)
    T = REAL.forward(HOME + np.random.default_rng(0).uniform(-0.2, 0.2, (len(program.paths[0]), 6)))
    path = type(program.paths[0])(program.paths[0].seam, T[:, :3, 3], T[:, :3, :3], None)
    arm = ArmAtTool(REAL, NO_TOOL, HOME)
    followed = follow_program(type(program)((path,), program.T_base_part), arm, branch=BRANCH)
    sent = compensate_program(followed, arm).paths[0]
    target = np.tile(np.eye(4), (len(sent), 1, 1))
    target[:, :3, :3], target[:, :3, 3] = sent.R_base, sent.p_base
    replayed = REAL.forward(nearest_joints(NOMINAL, target, HOME))
    np.testing.assert_allclose(replayed[:, :3, 3], path.p_base, rtol=0, atol=SAME_MM)
    assert np.linalg.norm(sent.p_base - path.p_base, axis=1).min() > 0.5  # and uncompensated it would not


def marked(folder: Path, space: str) -> Path:
    for name in ("calibration.json", "seams.json"):
        record = json.loads((folder / name).read_text())
        record["robot_space"] = space
        (folder / name).write_text(json.dumps(record))
    return folder


@pytest.mark.parametrize(
    ("space", "says"), [("identified", "give the file of that robot"), ("nominal", "give no robot file")]
)
def test_corrected_at_one_end_only_is_refused(finished_folder, space, says):
    from wpcal.core.robot_space import RobotSpace

    other = RobotSpace.NOMINAL if space == "identified" else RobotSpace.IDENTIFIED
    with pytest.raises(FrameError, match=says):
        read_finished(marked(finished_folder(), space), space=other)


def test_the_configuration_is_never_guessed(finished_folder):
    folder = marked(finished_folder(), "identified")
    done = CliRunner().invoke(wpcal, ["export", str(folder), "-f", "rapid", "--robot", "mh6"])
    assert "--robot needs --near-joints" in str(done.exception)
    near = ["--near-joints", "0,0,0,0,60,0"]
    done = CliRunner().invoke(wpcal, ["export", str(folder), "-f", "rapid", "--robot", "mh6", *near])
    assert "--robot needs --tool" in str(done.exception)
    assert not (folder / "rapid").exists()
