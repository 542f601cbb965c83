"""Lines and arcs with an arm: its joints hold the torch all along them, also where the robot is an identified one."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial import KDTree

from tests.few import few
from tests.simulated_poses import off_by
from wpcal.cli.main import wpcal
from wpcal.controllers.program import build_program
from wpcal.controllers.program.checked_program import check_program
from wpcal.controllers.program.compensation import compensate_program
from wpcal.controllers.program.followed_program import follow_program, program_for_arm
from wpcal.controllers.program.reachable_spin import ArmAtTool
from wpcal.core.errors import FrameError
from wpcal.results.folder import read_finished
from wpcal.robot.compensation import NO_TOOL
from wpcal.robot.identify.poses_file import parse_tool
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.robot.kinematics.inverse import LARGEST_STEP_RAD, follow_path, nearest_joints
from wpcal.robot.moves import Arc, PathTolerance

FIXTURES = Path(__file__).parents[3] / "fixtures"
SAME = 1e-6  # of joints that are followed to a pose, and those that were computed for it
PLACES = 400  # along a seam
BETWEEN_MM = 0.01  # a seam is known at its frames; between them the chord is up to 0.1 mm off, the curve much less
NEAR = {"m10ia": [0, 0, 0, 0, -40, 0], "irb1600_8_145": [0, 0, 0, 0, -40, 0]}


def at_tool(name, *, identified=False):
    arm = off_by(find_arm(name)) if identified else find_arm(name)
    return ArmAtTool(arm, parse_tool("0,0,350,0,30,0")[0], np.deg2rad(NEAR[name]))


@cache
def programs(part, name, identified):
    """The program with the poses of the torch, and that with the targets for the controller."""
    arm = at_tool(name, identified=identified)
    dense = build_program(read_finished(FIXTURES / part / "golden").select())
    program = program_for_arm(dense, arm, check=check_program, tolerance=PathTolerance())
    return program, compensate_program(program, arm)


def flanges(arm, p, R):
    T = np.tile(np.eye(4), (len(p), 1, 1))
    T[:, :3, :3], T[:, :3, 3] = R, p
    return T @ arm.T_flange_tool.inverse().matrix


@pytest.mark.parametrize(("part", "name", "identified"), [("saddle", "m10ia", False), ("tee", "irb1600_8_145", False)])
def test_the_arm_makes_every_move_in_one_branch(part, name, identified):
    program, _ = programs(part, name, identified)
    arm = at_tool(name)
    for path in program.paths:
        rows = path.weld_rows
        T = arm.arm.forward(path.joints) @ arm.T_flange_tool.matrix
        np.testing.assert_allclose(T[:, :3, 3], path.p_base, rtol=0, atol=SAME)
        np.testing.assert_allclose(T[:, :3, :3], path.R_base, rtol=0, atol=SAME)
        s = np.linspace(*path.moves.s_mm[[0, -1]], PLACES)
        followed = follow_path(arm.arm, flanges(arm, *path.moves.poses_at(s)), path.joints[rows.start])
        assert np.abs(np.diff(followed, axis=0)).max() < LARGEST_STEP_RAD
        assert arm.arm.within_limits(followed).all()
        np.testing.assert_allclose(followed[-1], path.joints[rows.stop - 1], rtol=0, atol=SAME)
    if part == "saddle":
        (path,) = program.paths
        assert len(path.weld_moves) == 13
        assert all(isinstance(move, Arc) for move in path.weld_moves)


@pytest.mark.parametrize("part", few(["tee", "saddle"], 1))
def test_an_identified_arm_is_on_the_seam_between_its_targets_too(part):
    """The controller interpolates with its nominal model; the real arm is then within the tolerance of the seam."""
    program, sent = programs(part, "m10ia", True)
    arm = at_tool("m10ia", identified=True)
    nominal = arm.arm.as_nominal()
    for true, path in zip(program.paths, sent.paths, strict=True):
        assert np.linalg.norm(path.p_base - true.p_base[[0, -1]].mean(axis=0), axis=1).min() > 0.1  # it is corrected
        s = np.linspace(*path.moves.s_mm[[0, -1]], PLACES)
        q = follow_path(nominal, flanges(arm, *path.moves.poses_at(s)), path.joints[path.weld_rows.start])
        T = arm.arm.forward(q) @ arm.T_flange_tool.matrix
        fine, _ = exact(true)
        off, _ = KDTree(fine).query(T[:, :3, 3])
        assert off.max() <= 0.05 + BETWEEN_MM
        np.testing.assert_allclose(path.joints[path.weld_rows][[0, -1]], q[[0, -1]], rtol=0, atol=1e-3)


def exact(path):
    """Points of the seam at small steps: cubic curves through its frames with their directions of travel."""
    from scipy.interpolate import CubicHermiteSpline

    frames = path.seam.frames
    s = np.linspace(*frames.s_mm[[0, -1]], 20_000)
    return CubicHermiteSpline(frames.s_mm, frames.p, frames.R[:, :, 0])(s), s


SAME_MM = 1e-6  # two inverse solutions and their Newton steps
NOMINAL = find_arm("mh6")
REAL = off_by(NOMINAL)
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
