import numpy as np
import pytest

from wpcal.planning.cell.workplace import regularity
from wpcal.robot.kinematics.arm_file import find_arm

SLOPE_ATOL = 1e-8  #: Round-off of a central difference quotient with steps of 1e-6.
SAME_RATIO = 1e-9  #: Round-off of a determinant of a 6 × 6 matrix.


@pytest.mark.parametrize("name", ["mh6", "m10ia", "irb1600_6_12"])
def test_the_product_of_the_measures_is_the_determinant_of_the_jacobian(name):
    arm = find_arm(name)
    q = np.random.default_rng(0).uniform(-2.0, 2.0, (200, 6))
    values, _ = regularity(arm, q)
    determinant = np.abs(np.linalg.det(arm.jacobian(q)))
    ratio = determinant / values.prod(axis=1)
    assert np.ptp(ratio) <= SAME_RATIO * ratio.mean()


@pytest.mark.parametrize("name", ["mh6", "m10ia"])
def test_derivatives_are_those_of_difference_quotients(name):
    arm = find_arm(name)
    q = np.random.default_rng(1).uniform(-2.0, 2.0, (50, 6))
    _, slopes = regularity(arm, q)
    for joint, step in enumerate(1e-6 * np.eye(6)):
        quotient = (regularity(arm, q + step)[0] - regularity(arm, q - step)[0]) / 2e-6
        np.testing.assert_allclose(slopes[:, :, joint], quotient, rtol=0, atol=SLOPE_ATOL)
