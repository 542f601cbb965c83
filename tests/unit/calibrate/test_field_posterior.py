"""What residuals of touches tell of the robot's error at other places."""

import numpy as np
import pytest

from wpcal.calibrate.errors.robot_field import RobotField, correlation, field_posterior
from wpcal.core.tangent import point_jacobian

NUMERICAL_MM = 1e-6  #: Of solves with condition numbers up to 1e8.
FIELD = RobotField(0.3, 400.0, rest_mm=0.05)
CENTRE = np.array([900.0, -300.0, 400.0])
PLACES = np.random.default_rng(1).uniform(-500.0, 500.0, (8, 3)) + CENTRE
AT = np.random.default_rng(2).uniform(-600.0, 600.0, (5, 3)) + CENTRE
SIGMA2 = np.tile(0.1**2 * np.eye(3), (8, 1, 1))


@pytest.mark.parametrize("spread", [1e-3, 0.0])
def test_it_is_the_conditional_distribution_of_the_joint_gaussian(spread: float) -> None:
    pose, d = np.diag([spread**2] * 3 + [(1e3 * spread) ** 2] * 3), np.random.default_rng(3).normal(0.0, 0.4, (8, 3))
    everywhere = np.concatenate([PLACES, AT])
    J = point_jacobian(everywhere).reshape(-1, 6)
    K = np.kron(0.3**2 * correlation(everywhere, everywhere, 400.0) + 0.05**2 * np.eye(13), np.eye(3))
    K += J @ pose @ J.T
    K[:24, :24] += 0.1**2 * np.eye(24)
    weights = np.linalg.solve(K[:24, :24], K[:24, 24:]).T
    mean, covariance = field_posterior(PLACES, d, AT, FIELD, covariances=SIGMA2, pose=pose)
    np.testing.assert_allclose(mean, (weights @ d.ravel()).reshape(5, 3), rtol=0, atol=NUMERICAL_MM)
    full = K[24:, 24:] - weights @ K[:24, 24:]
    expected = np.stack([full[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] for i in range(5)])
    np.testing.assert_allclose(covariance, expected, rtol=0, atol=NUMERICAL_MM)


def test_an_unknown_pose_follows_any_rigid_motion_and_leaves_what_was_touched() -> None:
    xi = np.array([1e-3, -2e-3, 5e-4, 3.0, -2.0, 1.0])
    moved = point_jacobian(PLACES) @ xi
    mean, covariance = field_posterior(PLACES, moved, AT, FIELD, covariances=SIGMA2)
    np.testing.assert_allclose(mean, point_jacobian(AT) @ xi, rtol=0, atol=NUMERICAL_MM)
    d = moved + np.random.default_rng(4).normal(0.0, 0.3, (8, 3))
    same, own = field_posterior(PLACES, d, PLACES, FIELD, covariances=1e-12 * SIGMA2)
    np.testing.assert_allclose(same, d, rtol=0, atol=1e-4)
    assert own.max() < covariance.min(axis=0).max()


def test_its_error_is_as_stated_over_simulated_fields() -> None:
    rng = np.random.default_rng(5)
    everywhere = np.concatenate([PLACES, AT])
    K = 0.3**2 * correlation(everywhere, everywhere, 400.0) + 0.05**2 * np.eye(13)
    squares = []
    for _ in range(300):
        f = rng.multivariate_normal(np.zeros(13), K, 3).T
        xi = rng.normal(0.0, np.repeat([1e-3, 1.0], 3))
        d = f[:8] + rng.normal(0.0, 0.1, (8, 3)) + point_jacobian(PLACES) @ xi
        mean, covariance = field_posterior(PLACES, d, AT, FIELD, covariances=SIGMA2)
        e = mean - f[8:] - point_jacobian(AT) @ xi
        squares.append(np.einsum("ki,kij,kj->k", e, np.linalg.inv(covariance), e))
    # a normalised square of three freedoms: 3 ± 3 · sqrt(6 / 300) at each place
    np.testing.assert_allclose(np.mean(squares, axis=0), 3.0, rtol=0, atol=0.45)
