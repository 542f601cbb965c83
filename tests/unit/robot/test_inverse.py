from dataclasses import replace

import numpy as np
import pytest

from tests.samples.offset_wrists import crx10ia, ur5e
from tests.simulated_poses import off_by, random_joints
from wpcal.core.errors import GeometryError, InputError
from wpcal.robot.kinematics.arm_file import arm_record, find_arm, shipped_arms
from wpcal.robot.kinematics.forward import forward_kinematics
from wpcal.robot.kinematics.inverse import (
    family_of,
    follow_path,
    nearest_joints,
    posture,
    solve_inverse,
    turn_into_limits,
)
from wpcal.robot.kinematics.opw import OPWGeometry, forward_opw, solve_opw

POSES = 20_000  # the number
MH6 = find_arm("mh6").chain
IK_MM = 1e-9  # the bound on FK(IK) - pose
IK_ENTRY = 1e-12  # of a rotation matrix: arm's length times it is the bound above
SAME_JOINTS_RAD = 1e-6  # near singular poses angles lose half of the digits, the pose does not


def angle_gap(a, b):
    return np.abs((a - b + np.pi) % (2 * np.pi) - np.pi).max(axis=-1)


CHAINS = {name: find_arm(name).chain for name in shipped_arms()}
for beside in (60.0, -35.0):  # no shipped arm has its shoulder beside its first axis
    CHAINS[f"mh6, b = {beside:g}"] = replace(MH6, d=MH6.d + beside * np.eye(len(MH6.d))[1])


@pytest.mark.parametrize("chain", CHAINS.values(), ids=CHAINS)
def test_every_random_pose_is_recovered_by_every_branch(chain):
    theta = np.random.default_rng(0).uniform(-np.pi, np.pi, (POSES, 6))
    T = forward_kinematics(chain, theta)
    found = solve_opw(OPWGeometry.of_chain(chain), T)
    reached = np.isfinite(found).all(axis=2)
    assert np.array_equal(reached, np.isfinite(found).any(axis=2))
    gap = np.where(reached, angle_gap(found, theta[:, None]), np.inf).min(axis=1)
    np.testing.assert_allclose(gap, 0, rtol=0, atol=SAME_JOINTS_RAD)
    again = forward_kinematics(chain, found[reached])
    wanted = np.broadcast_to(T[:, None], (POSES, 8, 4, 4))[reached]
    np.testing.assert_allclose(again[:, :3, 3], wanted[:, :3, 3], rtol=0, atol=IK_MM)
    np.testing.assert_allclose(again[:, :3, :3], wanted[:, :3, :3], rtol=0, atol=IK_ENTRY)


@pytest.mark.parametrize("chain", CHAINS.values(), ids=CHAINS)
def test_geometry_gives_the_same_forward_kinematics_as_the_chain(chain):
    theta = np.random.default_rng(1).uniform(-np.pi, np.pi, (50, 6))
    g = OPWGeometry.of_chain(chain)
    T = g.T_base_opw @ forward_opw(g, theta) @ g.T_wrist_flange
    np.testing.assert_allclose(T, forward_kinematics(chain, theta), rtol=0, atol=IK_MM)


@pytest.mark.parametrize(
    "theta", [[0.1, 0.2, 0.3, 0.4, 0.0, 0.5], [0.1, 0.2, 0.3, 0.4, 1e-9, 0.5], [0.1, 0.2, 0.3, 0.4, np.pi, 0.5]]
)
def test_a_straight_wrist_is_met(theta):
    arm = find_arm("mh6")
    T = forward_kinematics(arm.chain, [theta])
    solutions = solve_inverse(arm, T)
    again = arm.forward(solutions.joints[0][solutions.reached[0]])
    np.testing.assert_allclose(again - T, 0, rtol=0, atol=IK_MM)


def test_a_stretched_arm_and_a_wrist_over_the_shoulder_are_met():
    arm = find_arm("irb1600_6_12")
    stretched = arm.forward([[0.2, 0.3, np.deg2rad(-90), 0.4, 0.5, 0.6]])  # its forearm has no offset: -90° is straight
    T = np.array([stretched[0], np.eye(4)])
    T[1, :3, 3] = [0, 0, 486.5 + 700 - 65]  # wrist on axis 1
    T[1, :3, :3] = np.eye(3)
    solutions = solve_inverse(arm, T)
    assert solutions.reached[0].any()
    for pose, joints, reached in zip(T, solutions.joints, solutions.reached, strict=True):
        np.testing.assert_allclose(
            arm.forward(joints[reached]), np.broadcast_to(pose, (reached.sum(), 4, 4)), rtol=0, atol=IK_MM
        )


def test_out_of_reach_is_nan_for_that_pose_only():
    arm = find_arm("mh6")
    T = np.repeat(arm.forward([[0.3, 0.2, -0.4, 0.5, 0.6, 0.7]]), 2, axis=0)
    T[1, 0, 3] = 5000
    solutions = solve_inverse(arm, T)
    assert solutions.reached[0].any()
    assert not solutions.reached[1].any()
    with pytest.raises(GeometryError, match="pose 2 of 2: is out of reach"):
        nearest_joints(arm, T, np.zeros(6))


def test_newton_meets_the_pose_of_an_identified_arm():
    arm = off_by(find_arm("mh6"))
    q = random_joints(arm, 300, rng=np.random.default_rng(5))
    T = arm.forward(q)
    solutions = solve_inverse(arm, T)
    again = arm.forward(solutions.joints[solutions.reached])
    wanted = np.broadcast_to(T[:, None], (300, 8, 4, 4))[solutions.reached]
    np.testing.assert_allclose(again, wanted, rtol=0, atol=10 * IK_MM)  # ten: the product after the last Newton step
    gap = np.where(solutions.reached, angle_gap(solutions.joints, q[:, None]), np.inf).min(axis=1)
    assert (gap > SAME_JOINTS_RAD).mean() < 0.01  # with the wrist over axis 1 the nominal start may be another branch


def test_newton_reaches_what_only_the_longer_real_arm_reaches():
    nominal = find_arm("mh6")
    table = nominal.chain.table.copy()
    table[2, 1] += 3.0  # an upper arm 3 mm longer
    arm = nominal.as_identified(nominal.chain.with_table(table))
    T = arm.forward([[0.3, 0.2, np.arctan2(155, 640) - np.pi / 2 + 0.03, 0.5, 0.6, 0.7]])
    assert not solve_inverse(nominal, T).reached[0, :4].any()
    assert solve_inverse(arm, T).reached[0, :4].any()


@pytest.mark.parametrize("arm", [*map(find_arm, shipped_arms()), ur5e(), crx10ia()], ids=lambda arm: arm.name)
def test_every_value_of_an_arm(arm, golden):
    q = np.array([[0.31, -0.42, 0.53, 0.64, -0.75, 0.86], [-0.9, 0.33, -0.21, -1.4, 0.97, 2.2]])
    T, way = arm.forward(q), q[0] + np.linspace(0.0, 0.1, 7)[:, None]
    told = [arm_record(arm), T, arm.jacobian(q, point=(11.0, -7, 203)), family_of(arm.chain), solve_inverse(arm, T)]
    told += [arm.shown_angles(q), arm.model_angles(q), arm.within_limits(1.9 * q), nearest_joints(arm, T, q + 0.2)]
    told += [arm, follow_path(arm, arm.forward(way), q[0] + 0.01)]
    golden([*told, posture(arm, q) if isinstance(told[3], OPWGeometry) else None])


def test_a_multi_turn_axis_is_unwrapped_along_a_path():
    arm = find_arm("mh6")
    q = np.tile([0.3, 0.2, -0.4, 0.5, 0.6, 0.0], (40, 1))
    q[:, 5] = np.linspace(np.deg2rad(-340), np.deg2rad(340), 40)
    path = follow_path(arm, arm.forward(q), q[0])
    np.testing.assert_allclose(path, q, rtol=0, atol=SAME_JOINTS_RAD)


def test_turns_stay_within_limits():
    arm = find_arm("mh6")
    q = turn_into_limits(arm, np.deg2rad([0, 0, -110, 0, 0, 100]), np.deg2rad([0, 0, 240, 0, 0, -300]))
    np.testing.assert_allclose(np.rad2deg(q), [0, 0, 250, 0, 0, -260], rtol=0, atol=SAME_JOINTS_RAD)
    assert np.isnan(turn_into_limits(arm, np.deg2rad([0, -100, 0, 0, 0, 0]), np.zeros(6))[1])


def test_a_broken_limit_is_told_from_out_of_reach():
    arm = find_arm("mh6")
    tight = replace(arm, joints=tuple(replace(j, min_rad=-0.01, max_rad=0.01) for j in arm.joints))
    with pytest.raises(GeometryError, match="breaks a joint limit"):
        nearest_joints(tight, arm.forward([[0.3, 0.2, -0.4, 0.5, 0.6, 0.7]]), np.zeros(6))


def test_an_arm_of_another_family_is_refused():
    chain = find_arm("mh6").chain
    table = chain.table.copy()
    table[2, 4] = 30.0  # an offset between axes 5 and 6
    with pytest.raises(GeometryError, match="axis 6 misses the wrist centre"):
        OPWGeometry.of_chain(chain.with_table(table))


def test_poses_of_a_wrong_shape_or_nan_are_refused():
    arm = find_arm("mh6")
    with pytest.raises(InputError, match=r"shape \(N, 4, 4\)"):
        solve_inverse(arm, np.eye(4))
    with pytest.raises(InputError, match="pose 1 holds"):
        solve_inverse(arm, np.full((1, 4, 4), np.nan))


def test_eaik_finds_the_same_solutions():
    eaik = pytest.importorskip("eaik.IK_DH", reason="EAIK, an independent solver, is not installed (extra: oracles)")
    arm = find_arm("mh6")
    theta, d, a, alpha, _ = arm.chain.table
    oracle = eaik.DhRobot(alpha, a, d)
    T = arm.forward(np.random.default_rng(6).uniform(-1, 1, (50, 6)))
    for pose, joints in zip(T, solve_inverse(arm, T).joints, strict=True):
        solution = oracle.IK(pose)
        exact = ~np.array(solution.is_LS)  # the others are nearest poses of branches that do not reach
        theirs = np.array(solution.Q)[exact] - theta
        ours = joints[np.isfinite(joints).all(axis=1)]
        assert len(theirs) == len(ours)
        gaps = angle_gap(ours[:, None], theirs[None]).min(axis=1)
        np.testing.assert_allclose(gaps, 0, rtol=0, atol=SAME_JOINTS_RAD)


def test_geometry_of_the_mh6_has_the_published_lengths():
    g = OPWGeometry.of_chain(find_arm("mh6").chain)
    np.testing.assert_allclose(
        [g.a1, g.a2, g.b, g.c1, g.c2, g.c3, g.T_wrist_flange[2, 3]],
        [150, -155, 0, 450, 614, 640, 95],
        rtol=0,
        atol=IK_MM,
    )
