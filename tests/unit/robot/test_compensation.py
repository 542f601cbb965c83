"""What an identified arm corrects, and the smooth errors that are left, computed with dense matrices."""

import numpy as np
import pytest

from tests.simulated_poses import off_by
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.robot.compensation import correct_points
from wpcal.robot.identify.error_field import LENGTHS_MM, RATIOS, error_field
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


def scored(places: np.ndarray, errors: np.ndarray, length: float, ratio: float) -> tuple[float, float]:
    """Return the logarithm of the likelihood of differences to the first pose, and the variance of the rest."""
    n = len(places)
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    D = np.hstack([-np.ones((n - 1, 1)), np.eye(n - 1)])
    V = D @ (np.eye(n) + ratio * np.exp(-0.5 * (apart / length) ** 2)) @ D.T
    y = D @ errors
    variance = float(np.sum(y * np.linalg.solve(V, y))) / y.size
    return -1.5 * np.linalg.slogdet(V)[1] - 0.5 * y.size * np.log(variance), variance


@pytest.mark.parametrize(("seed", "smooth_mm"), [(0, 0.0), (1, 0.3), (2, 0.7), (5, 2.0)])
def test_the_field_has_the_largest_likelihood(seed: int, smooth_mm: float) -> None:
    rng = np.random.default_rng(seed)
    places = rng.uniform([700.0, -500, 100], [1500.0, 600, 900], (17, 3))
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    L = np.linalg.cholesky(np.exp(-0.5 * (apart / 450.0) ** 2) + 1e-9 * np.eye(17))
    errors = [0.4, -0.2, 0.1] + smooth_mm * L @ rng.normal(size=(17, 3)) + rng.normal(0.0, 0.2, (17, 3))
    tried = {(length, ratio): scored(places, errors, length, ratio) for length in LENGTHS_MM for ratio in RATIOS}
    (length, ratio), (_, variance) = max(tried.items(), key=lambda item: item[1][0])
    found = error_field(places, errors)
    expected = [np.sqrt(variance * ratio), length if ratio else found.length_mm, np.sqrt(variance)]
    assert list(found.to_record().values()) == pytest.approx(expected, rel=1e-9)
