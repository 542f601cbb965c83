import numpy as np
import pytest

from wpcal.core.errors import GeometryError, InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.robot.compensation import compensate_targets, correct_points
from wpcal.robot.identify.identifiability import XIONG_2015_ERRORS
from wpcal.robot.identify.parameters import KinematicModel, link_parameters
from wpcal.robot.identify.poses_file import parse_tool
from wpcal.robot.kinematics.arm_file import find_arm

SAME_MM = 1e-7  # two closed forms and a few Newton steps
NOMINAL = find_arm("mh6")
REAL = NOMINAL.as_identified(
    KinematicModel(NOMINAL.chain).moved(link_parameters(NOMINAL.chain), XIONG_2015_ERRORS).chain
)
TORCH = RigidTransform(rotation_from_zyx(0.1, 0.6, 0.0), [20.0, 0.0, 350.0], "flange", "tool")
HOME = np.array([0.2, 0.3, -0.4, 0.3, 0.7, 0.2])


def poses(count=20):
    return REAL.forward(HOME + np.random.default_rng(0).uniform(-0.3, 0.3, (count, 6))) @ TORCH.matrix


def test_the_controller_takes_the_real_robot_to_the_true_poses():
    wished = poses()
    targets, joints = compensate_targets(REAL, wished, near=HOME, T_flange_tool=TORCH)
    # the controller: targets to joint angles by its nominal model; the real robot: joint angles to a pose
    np.testing.assert_allclose(NOMINAL.forward(joints) @ TORCH.matrix, targets, rtol=0, atol=SAME_MM)
    np.testing.assert_allclose(REAL.forward(joints) @ TORCH.matrix, wished, rtol=0, atol=SAME_MM)
    assert np.linalg.norm(targets[:, :3, 3] - wished[:, :3, 3], axis=1).min() > 0.5  # and without it, it does not


def test_corrected_points_are_where_the_real_tool_was():
    q = HOME + np.random.default_rng(1).uniform(-0.3, 0.3, (5, 6))
    true = (REAL.forward(q) @ TORCH.matrix)[:, :3, 3]
    np.testing.assert_allclose(correct_points(REAL, q, T_flange_tool=TORCH), true, rtol=0, atol=SAME_MM)
    shown = correct_points(NOMINAL, q, T_flange_tool=TORCH)
    assert np.linalg.norm(true - shown, axis=1).min() > 0.5


def test_one_end_only_is_worse_than_both_or_neither():
    """Why `RobotSpace` exists: taught through the nominal model, replayed compensated, the robot's error comes back."""
    q = HOME + np.random.default_rng(2).uniform(-0.05, 0.05, (10, 6))
    taught = REAL.forward(q)
    shown = NOMINAL.forward(q)
    compensated, joints = compensate_targets(REAL, shown, near=HOME)
    assert np.linalg.norm((REAL.forward(joints) - taught)[:, :3, 3], axis=1).min() > 0.5
    assert np.abs(NOMINAL.forward(joints) - compensated).max() < SAME_MM


def test_a_nominal_arm_and_a_far_pose_are_refused():
    with pytest.raises(InputError, match="need an identified one"):
        compensate_targets(NOMINAL, poses(), near=HOME)
    far = poses(3)
    far[1, 0, 3] = 9000
    with pytest.raises(GeometryError, match="pose 2 of 3"):
        compensate_targets(REAL, far, near=HOME, T_flange_tool=TORCH)


def test_a_tool_is_three_or_six_numbers():
    np.testing.assert_allclose(parse_tool("1,2,3")[0].t_mm, [1, 2, 3], rtol=0, atol=0)
    turned = parse_tool("1,2,3,0,90,0")[0]
    np.testing.assert_allclose(turned.R @ [0, 0, 1], [1, 0, 0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(parse_tool(None)[0].matrix, np.eye(4), rtol=0, atol=0)
    for wrong in ("1,2", "1,2,x", "1,2,nan", "1,2,3,4"):
        with pytest.raises(InputError, match="three or six"):
            parse_tool(wrong)
