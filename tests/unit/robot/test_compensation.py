import numpy as np
import pytest

from tests.simulated_poses import off_by
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.robot.compensation import correct_points
from wpcal.robot.identify.poses_file import parse_tool
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.robot.kinematics.inverse import nearest_joints

SAME_MM = 1e-7  # two closed forms and a few Newton steps
NOMINAL = find_arm("mh6")
REAL = off_by(NOMINAL)
TORCH = RigidTransform(rotation_from_zyx(0.1, 0.6, 0.0), [20.0, 0.0, 350.0], "flange", "tool")
HOME = np.array([0.2, 0.3, -0.4, 0.3, 0.7, 0.2])


def test_corrected_points_are_where_the_real_tool_was():
    q = HOME + np.random.default_rng(1).uniform(-0.3, 0.3, (5, 6))
    true = (REAL.forward(q) @ TORCH.matrix)[:, :3, 3]
    np.testing.assert_allclose(correct_points(REAL, q, T_flange_tool=TORCH), true, rtol=0, atol=SAME_MM)
    shown = correct_points(NOMINAL, q, T_flange_tool=TORCH)
    assert np.linalg.norm(true - shown, axis=1).min() > 0.5


def test_a_far_pose_is_refused_by_its_number():
    far = REAL.forward(np.tile(HOME, (3, 1)))
    far[1, 0, 3] = 9000
    with pytest.raises(GeometryError, match="pose 2 of 3"):
        nearest_joints(REAL, far, HOME)


def test_a_tool_is_three_or_six_numbers():
    np.testing.assert_allclose(parse_tool("1,2,3")[0].t_mm, [1, 2, 3], rtol=0, atol=0)
    turned = parse_tool("1,2,3,0,90,0")[0]
    np.testing.assert_allclose(turned.R @ [0, 0, 1], [1, 0, 0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(parse_tool(None)[0].matrix, np.eye(4), rtol=0, atol=0)
    for wrong in ("1,2", "1,2,x", "1,2,nan", "1,2,3,4"):
        with pytest.raises(InputError, match="three or six"):
            parse_tool(wrong)
