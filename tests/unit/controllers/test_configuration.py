"""The arm's configuration from joint angles, against what controllers and public sources state."""

from dataclasses import replace

import numpy as np
import pytest

from wpcal.controllers.abb.configuration import confdata
from wpcal.controllers.fanuc.configuration import config
from wpcal.controllers.kuka.configuration import status_and_turn
from wpcal.controllers.yaskawa.configuration import rconf
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm_file import find_arm, shipped_arms
from wpcal.robot.kinematics.inverse import posture, solve_inverse

SHOWN_DEG = 0.005  # a controller's files show two decimals


def fanuc_arm(a1, c2, a2, c3, c4):
    """An arm with FANUC's joints and other lengths, mm."""
    arm = find_arm("m10ia")
    table = arm.chain.table.copy()
    table[1:3] = [[0, 0, 0, -c3, 0, -c4], [a1, c2, a2, 0, 0, 0]]
    return replace(arm, chain=arm.chain.with_table(table))


ARC_MATE = find_arm("m10ia")
R2000 = fanuc_arm(312, 1075, 225, 1280, 235)
FANUC = [  # joint angles and CFG as controllers write them: F number, software, file
    (ARC_MATE, [86.75, -45.63, -10.99, 56.19, -81.55, -94.01], "N U T, 0, 0, 0"),  # E33151, ArcTool V7.70, curpos.dg
    (R2000, [-70.39, -24.78, -0.65, -0.15, -89.38, -19.65], "N U T, 0, 0, 0"),  # F270477, SpotTool+ V9.30, curpos.dg
    (R2000, [-8.01, -59.53, -7.12, 95.18, 54.12, -4.79], "F U T, 0, 0, 0"),  # F268925, HandlingTool V9.30, curpos.dg
    (R2000, [120.0, -56.0, 20.0, 0.0, -20.0, 90.0], "N U T, 0, 0, 0"),  # E157785, HandlingTool V9.30, summary.dg
]


@pytest.mark.parametrize(("arm", "joints_deg", "shown"), FANUC)
def test_fanuc_shows_the_same(arm, joints_deg, shown):
    assert config(posture(arm, np.deg2rad([joints_deg]))) == [shown]


def test_the_joints_of_the_fanuc_arm_are_counted_as_the_controller_does():
    """The tool's orientation in the world, of the second controller: TOOL 1 is turned by (-180, 0, -90)."""
    tool = rotation_from_zyx(*np.deg2rad([-180.0, 0.0, -90.0]))
    R = R2000.forward(np.deg2rad([FANUC[1][1]]))[0, :3, :3] @ tool
    shown = rotation_from_zyx(*np.deg2rad([0.08, -0.13, -0.04]))
    off = RigidTransform(shown.T @ R, np.zeros(3), "base", "tool")
    assert np.rad2deg(np.arccos((np.trace(off.R) - 1) / 2)) <= SHOWN_DEG * np.sqrt(3)


def test_fanuc_counts_turns_of_joints_1_4_and_6_and_is_refused_where_no_source_says():
    """A program states one pose flipped and not flipped with the same first number: it is of no joint of the wrist."""
    turned = [[190, 0, 0, -30, 30, 0], [190, 0, 0, 150, -30, 180], [0, 0, 0, -185, 9, 0], [0, 0, 0, 0, -9, 541]]
    shown = ["F U T, 1, 0, 0", "N U T, 1, 0, 0", "F U T, 0, -1, 0", "N U T, 0, 0, 2"]
    assert config(posture(ARC_MATE, np.deg2rad(turned))) == shown
    for joints_deg, why in (([170, -120, 90, 0, 30, 0], "behind axis 1"), ([0, 0, 0, 0, 190, 0], "joint 5 is beyond")):
        with pytest.raises(InputError, match=f"pose 1 of 1: .*{why}"):
            config(posture(ARC_MATE, np.deg2rad([joints_deg])))


IRB1660 = [  # CEAD-group/py-opw-kinematics: joint angles and cfx
    ([-103.1, -85.03, 19.06, -70.19, -35.87, 185.01], 5),
    ([-116.97, -85.69, 16.82, -63.5, -39.63, 192.76], 5),
    ([-128.14, -86.43, 13.04, -59.66, -40.66, 201.57], 5),
    ([-124.68, -61.16, -20.4, 56.41, -38.79, -24.56], 5),
    ([-127.36, -62.29, -16.83, 59.35, -35.14, -23.42], 5),
    ([-103.1, -85.03, 19.06, 109.81, 35.87, 5.01], 4),
    ([-116.97, -85.69, 16.82, 116.5, 39.63, 12.76], 4),
    ([-128.14, -86.43, 13.04, 120.34, 40.66, 21.57], 4),
    ([-124.68, -61.16, -20.4, -123.59, 38.79, 155.44], 4),
    ([-127.36, -62.29, -16.83, -120.65, 35.14, 156.58], 4),
]


def irb1660():
    arm = find_arm("irb1600_8_145")
    table = arm.chain.table.copy()
    table[2, 0], table[2, 1], table[2, 2], table[1, 3] = 150, 700, 110, np.sign(table[1, 3]) * 678
    return replace(arm, chain=arm.chain.with_table(table))


@pytest.mark.parametrize(("joints_deg", "cfx"), IRB1660)
def test_cfx_of_an_irb_1660(joints_deg, cfx):
    (text,) = confdata(posture(irb1660(), np.deg2rad([joints_deg])))
    assert text.strip("[]").split(",")[3] == str(cfx)


def test_quadrants_are_counted_from_zero_and_below_it_from_minus_one():
    (text,) = confdata(posture(find_arm("irb1600_8_145"), np.deg2rad([[-100, 0, 0, 10, 30, 185]])))
    assert text == "[-2,0,2,0]"


@pytest.mark.parametrize("name", [name for name in shipped_arms() if name.startswith("irb")])
def test_the_eight_solutions_of_a_pose_have_the_eight_numbers(name):
    arm = find_arm(name)
    T = arm.forward(np.deg2rad([[10, 20, 10, 30, 40, 50]]))
    joints = solve_inverse(arm, T).joints[0]
    joints = joints[np.isfinite(joints).all(axis=1)]
    numbers = sorted(text.strip("[]").split(",")[3] for text in confdata(posture(arm, joints)))
    assert numbers == sorted(set(numbers))
    assert len(numbers) >= 4


KUKA = [  # signs of the axes in T, and S, as points in public programs state them
    ([-10, -80, 100, 10, 20, -30], 2, 35),
    ([-10, -80, 100, -20, -40, 30], 6, 27),
    ([10, -90, 90, 0, 60, 0], 2, 2),
    ([10, -80, 100, 30, -40, -30], 6, 50),
    ([10, -80, 100, -30, 40, 30], 2, 10),
]


@pytest.mark.parametrize(("joints_deg", "status", "turn"), KUKA)
def test_status_and_turn(joints_deg, status, turn):
    assert status_and_turn(posture(find_arm("kr5_arc"), np.deg2rad([joints_deg]))) == [(status, turn)]


def test_the_turn_of_a_stated_example():
    arm = replace(find_arm("kr5_arc"), name="KR")  # $AXIS_ACT = {91, -45, 37, 1, -1, 0}: T = 'B010010'
    assert status_and_turn(posture(arm, np.deg2rad([[91, -45, 37, 1, -1, 0]])))[0][1] == 0b010010


def test_the_overhead_area_is_refused():
    with pytest.raises(InputError, match="pose 2 of 2: the wrist is in the overhead area"):
        status_and_turn(posture(find_arm("kr5_arc"), np.deg2rad([[0, -90, 90, 0, 60, 0], [0, -150, 30, 0, 60, 0]])))


def test_rconf_keeps_what_the_user_gives_and_writes_the_ranges():
    poses = posture(find_arm("ma2010"), np.deg2rad([[0, 0, 0, 10, -60, 20]] * 2))
    assert rconf(poses, "1,0,0,1,1,0,0,0") == ["1,0,0,0,0,0,0,0"] * 2
    with pytest.raises(InputError, match="beyond 180 deg"):
        rconf(posture(find_arm("ma2010"), np.deg2rad([[0, 0, 0, 10, -60, 200]])), "1,0,0,0,0,0")


@pytest.mark.parametrize("name", shipped_arms())
def test_postures_are_those_of_the_branches(name):
    """The eight solutions of a pose have eight different postures: a controller finds its one solution again."""
    arm = find_arm(name)
    T = arm.forward(np.deg2rad([[15, 10, 10, 25, 35, 20]]))
    joints = solve_inverse(arm, T).joints[0]
    joints = joints[np.isfinite(joints).all(axis=1)]
    poses = posture(arm, joints)
    flips = np.sin(poses.joints[:, 4]) < 0
    classes = set(zip(poses.is_behind.tolist(), poses.is_behind_lower_arm.tolist(), flips.tolist(), strict=True))
    assert len(classes) == len(joints)


def test_an_arm_whose_zero_does_not_look_along_x_is_refused():
    arm = find_arm("mh6")
    turned = RigidTransform(rotation_from_zyx(0, 0, np.pi / 2), np.zeros(3), "base", "dh0")
    with pytest.raises(GeometryError, match="which side is its front is not known"):
        posture(replace(arm, chain=replace(arm.chain, T_base_dh0=turned)), np.zeros((1, 6)))
