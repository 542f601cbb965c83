"""A program whose joints are known: one branch from start to end, within the limits, and its configuration written."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from wpcal.controllers.abb.write import write_rapid
from wpcal.controllers.fanuc.write import write_fanuc
from wpcal.controllers.kuka.write import write_krl
from wpcal.controllers.program import ControllerSettings, build_program
from wpcal.controllers.program.checked_program import check_program
from wpcal.controllers.program.followed_program import follow_program, program_for_arm
from wpcal.controllers.program.reachable_spin import ArmAtTool
from wpcal.controllers.registry import controller_named
from wpcal.controllers.yaskawa.write import write_inform
from wpcal.core.errors import ErrorCode, GeometryError, InputError
from wpcal.core.tangent import exp_rotation, log_rotation
from wpcal.results.folder import read_finished
from wpcal.robot.identify.poses_file import parse_tool
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.robot.kinematics.inverse import LARGEST_STEP_RAD, Broken, continue_branch, posture, solve_inverse

TEE = Path(__file__).parents[3] / "fixtures" / "tee" / "golden"
SAME = 1e-9  # round-off of forward and inverse kinematics of a metre
FINER = 10  # poses between two that the program was followed at
ARMS = {"irb1600_8_145": "0,0,0,0,-40,0", "m10ia": "0,0,0,0,-40,0", "kr5_arc": "0,-90,90,0,60,0"}


@cache
def unchecked():
    return build_program(read_finished(TEE).select())


def at_tool(name, near="0,0,0,0,60,0"):
    return ArmAtTool(find_arm(name), parse_tool("0,0,350,0,30,0")[0], np.deg2rad([float(q) for q in near.split(",")]))


@cache
def followed(name):
    return program_for_arm(unchecked(), at_tool(name, ARMS[name]), check=check_program)


def whole(program):
    """All poses and joints in the order in which they are passed."""
    groups = [*program.groups, program.safe_point]
    return tuple(np.concatenate([getattr(each, field) for each in groups]) for field in ("p_base", "R_base", "joints"))


@pytest.mark.parametrize("name", ARMS)
def test_the_joints_hold_the_torch_within_the_limits_in_one_posture(name, golden):
    program, arm = followed(name), at_tool(name)
    p, R, q = whole(replace(program, safe_point=program.safe_point))
    T = arm.arm.forward(q) @ arm.T_flange_tool.matrix
    np.testing.assert_allclose(T[:, :3, 3], p, rtol=0, atol=1e3 * SAME)
    np.testing.assert_allclose(T[:, :3, :3], R, rtol=0, atol=SAME)
    assert arm.arm.within_limits(q).all()
    poses = posture(arm.arm, q)
    classes = np.stack([poses.is_behind, poses.is_behind_lower_arm, np.sin(q[:, 4]) < 0], axis=1)
    assert (classes == classes[0]).all()
    golden(program)


@pytest.mark.parametrize("name", ARMS)
def test_the_arm_also_follows_between_the_poses(name):
    """Ten poses on every line between two: the nearest solution to the joints before leads to the joints after."""
    program, arm = followed(name), at_tool(name)
    p, R, q = whole(program)
    share = np.linspace(0, 1, FINER + 1)[None, :, None]
    p_fine = p[:-1, None] + share * (p[1:] - p[:-1])[:, None]
    turn = log_rotation(np.swapaxes(R[:-1], 1, 2) @ R[1:])
    R_fine = R[:-1, None] @ exp_rotation(share * turn[:, None])
    T = np.tile(np.eye(4), (*p_fine.shape[:2], 1, 1))
    T[..., :3, :3], T[..., :3, 3] = R_fine, p_fine
    solutions = solve_inverse(arm.arm, T.reshape(-1, 4, 4) @ arm.T_flange_tool.inverse().matrix).joints
    solutions = solutions.reshape(len(q) - 1, FINER + 1, 8, 6)
    for row, start in enumerate(q[:-1]):
        now = start
        for each in solutions[row]:
            step = each - now
            step -= 2 * np.pi * np.rint(step / (2 * np.pi))
            best = np.argmin(np.where(np.isnan(step), np.inf, np.abs(step)).max(axis=1))
            assert np.abs(step[best]).max() <= LARGEST_STEP_RAD
            now = now + step[best]
        np.testing.assert_allclose(now, q[row + 1], rtol=0, atol=1e3 * SAME)


def test_rapid_states_the_configuration_and_lets_the_controller_check_it():
    (text,) = write_rapid(followed("irb1600_8_145")).values()
    targets = re.findall(r"robtarget (\w+):=\[\[.*?\],\[.*?\],(\[[-\d,]+\])", text)
    assert len(targets) == sum(len(group.p_base) for group in followed("irb1600_8_145").groups)
    assert {conf for _, conf in targets} != {"[0,0,0,0]"}
    assert "ConfL" not in text
    assert "confdata is computed from the joints" in text


def test_krl_states_status_and_turn_and_they_are_read_back():
    files = write_krl(followed("kr5_arc"))
    assert re.search(r"DECL E6POS WP_SAFE=\{.*,S \d,T \d+\}", files["WPCAL.dat"])
    assert len(re.findall(r",S \d,T \d+\}", files["WPCAL.dat"])) == len(re.findall("DECL E6POS", files["WPCAL.dat"]))
    reader = controller_named("krl").load_reader()
    assert reader.read(files["WPCAL.dat"], "WPCAL.dat").points


def test_fanuc_needs_no_config_with_an_arm_and_the_users_own_still_counts():
    program = followed("m10ia")
    assert set(re.findall(r"CONFIG : '(.*)'", write_fanuc(program)["W1.ls"])) <= {"N U T, 0, 0, 0", "F U T, 0, 0, 0"}
    assert "CONFIG computed from the" in write_fanuc(program)["WPCAL.ls"]
    own = replace(program, controller=ControllerSettings(configurations={"fanuc": "F D B, 0, 0, 1"}))
    assert set(re.findall(r"CONFIG : '(.*)'", write_fanuc(own)["W1.ls"])) == {"F D B, 0, 0, 1"}


def test_inform_needs_the_users_posture_and_fills_in_the_ranges():
    program = followed("irb1600_8_145")
    with pytest.raises(InputError, match=r"inform: every position needs .*RCONF"):
        write_inform(program)
    given = replace(program, controller=ControllerSettings(configurations={"inform": "1,0,0,1,1,1,0,0"}))
    assert set(re.findall("///RCONF (.*)\r", write_inform(given)["W2.jbi"])) == {"1,0,0,0,0,0,0,0"}


def test_a_limit_on_a_way_between_two_seams_is_named_with_its_place():
    program, arm = followed("irb1600_8_145"), at_tool("irb1600_8_145", ARMS["irb1600_8_145"])
    _, _, q = whole(program)
    limited = float(q[:, 0].max()) - 1e-3
    joints = (replace(arm.arm.joints[0], max_rad=limited), *arm.arm.joints[1:])
    tight = replace(arm, arm=replace(arm.arm, joints=joints))
    spun = replace(program, paths=tuple(replace(path, joints=None) for path in program.paths))
    branch = next(
        number
        for number in range(8)
        if np.allclose(arm.branches(program.safe_point.p_base, program.safe_point.R_base)[0, number], q[0], atol=1e-6)
    )
    with pytest.raises(GeometryError, match=r"W\d.* base .* mm: joint 1 would be at .* deg, its limits are") as error:
        follow_program(spun, tight, branch)
    assert error.value.code == ErrorCode.JOINT_PATH


def test_whole_turns_are_counted_along_a_path_and_a_jump_breaks_it():
    arm = find_arm("irb1600_8_145")
    last = np.linspace(0, 1.9 * np.pi, 40)
    q = np.zeros((40, 6))
    q[:, 5] = last - 2 * np.pi * np.rint(last / (2 * np.pi))
    path = continue_branch(arm, q, np.zeros(6))
    np.testing.assert_allclose(path[:, 5], last, rtol=0, atol=SAME)
    shifted = continue_branch(arm, q, np.array([0, 0, 0, 0, 0, -2 * np.pi]))
    np.testing.assert_allclose(shifted[:, 5], last - 2 * np.pi, rtol=0, atol=SAME)
    q[20:, 3] += 1.0
    broken = continue_branch(arm, q, np.zeros(6))
    assert isinstance(broken, Broken)
    assert (broken.row, broken.why) == (20, "joint 4 would swing by 57 deg to get there")
    q[5] = np.nan
    assert continue_branch(arm, q, np.zeros(6)).why == "is out of reach"


def test_a_urdf_is_an_arm_too(tmp_path):
    joint = '<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>'
    (tmp_path / "one.urdf").write_text(f'<robot name="one"><link name="a"/><link name="b"/>{joint}</robot>')
    assert find_arm(str(tmp_path / "one.urdf")).name == "one"
