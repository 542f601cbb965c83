import numpy as np
import pytest

from tests.simulated_poses import random_joints, simulate_poses
from wpcal.core.tangent import exp_rotation
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.pose_residuals import pose_errors
from wpcal.robot.identify.registration import register
from wpcal.robot.kinematics.arm_file import find_arm

MET_MM = 1e-8  # linear equations of positions four metres away
NEAR_MM = 1.0  # of the rounds in turns only a start is wanted
MH6 = find_arm("mh6")
TURN, SHIFT = exp_rotation([0.4, -2.0, 1.0]), np.array([3000.0, -500.0, 200.0])
TOOL, OFFSET = exp_rotation([2.5, 0.3, -0.8]), np.array([40.0, -30.0, 120.0])


def seen(*, base, tool, poses=True):
    rng = np.random.default_rng(0)
    exact = simulate_poses(MH6, np.zeros(24), random_joints(MH6, 25, rng=rng), rng=rng)
    R = exact.R_base_flange
    p = exact.p_base + (R @ OFFSET if tool else 0.0)
    if base:
        p, R = p @ TURN.T + SHIFT, TURN @ R
    return PoseObservations(exact.joints, p, (R @ TOOL if tool else R) if poses else None)


@pytest.mark.parametrize(("base", "tool"), [(True, True), (True, False), (False, True), (False, False)])
def test_full_poses_are_met_at_once(base, tool):
    observations = seen(base=base, tool=tool)
    theta = MH6.model_angles(observations.joints)
    model = register(MH6.chain, theta, observations, free_base=base, free_tool=tool)
    np.testing.assert_allclose(pose_errors(model, theta, observations), 0, rtol=0, atol=MET_MM)


@pytest.mark.parametrize(("base", "tool"), [(True, True), (True, False), (False, True)])
def test_positions_alone_give_a_start(base, tool):
    observations = seen(base=base, tool=tool, poses=False)
    theta = MH6.model_angles(observations.joints)
    model = register(MH6.chain, theta, observations, free_base=base, free_tool=tool)
    np.testing.assert_allclose(pose_errors(model, theta, observations), 0, rtol=0, atol=NEAR_MM)
