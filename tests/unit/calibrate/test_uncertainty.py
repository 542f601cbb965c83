import numpy as np
import pytest

from tests.coverage_study import error_95, run_coverage_study
from wpcal.calibrate import Criterion, TeachingError, calibrate
from wpcal.calibrate.errors.linear_fit import isotropic_covariance
from wpcal.calibrate.errors.of_bodies import joint_error
from wpcal.core import InputError, PointPairs
from wpcal.core.tangent import point_jacobian

SIGMA_MM = 0.3
BODY = np.array([[1000, 0, 0], [1600, 0, 20], [1580, 400, 0], [1010, 390, 60], [1300, 200, 300.0]])
TRIANGLES = {"large": (900, 600), "middle": (300, 200), "small": (100, 100)}


@pytest.mark.parametrize("legs", TRIANGLES.values(), ids=TRIANGLES.keys())
@pytest.mark.parametrize("criterion", [Criterion.MINIMAX, Criterion.LEAST_SQUARES])
def test_the_predicted_error_of_a_far_seam_holds_95_percent(legs, criterion):
    triangle = np.array([[0, 0, 0], [legs[0], 0, 0], [0, legs[1], 0.0]])
    study = run_coverage_study(triangle, np.array([1000.0, 0, 0]), sigma_mm=SIGMA_MM, criterion=criterion, trials=2000)
    assert 0.93 <= study.coverage <= 0.97
    assert np.sqrt(np.mean(study.rms_mm**2)) == pytest.approx(SIGMA_MM, rel=0, abs=0.02)  # it says nothing of the seam


def test_the_motion_beyond_least_squares_counts_in_the_minimax_prediction():
    points = np.random.default_rng(3).uniform(0, 1, (10, 3)) * [600, 400, 300]
    study = run_coverage_study(points, np.array([1000.0, 0, 0]), sigma_mm=SIGMA_MM, trials=2000)
    assert 0.93 <= study.coverage <= 0.97
    squares = error_95([[1000.0, 0, 0]], isotropic_covariance(points, SIGMA_MM))[0]
    assert np.mean(study.errors_mm <= squares) < 0.9  # without it the prediction would promise too much


def test_the_error_of_one_point_alone_is_the_quantile_of_the_joint_errors():
    covariance = isotropic_covariance(np.diag([300.0, 200.0, 100.0]), 0.3)
    alone = error_95([[500.0, 0, 0]], covariance)[0]
    assert joint_error(point_jacobian([[500.0, 0, 0]]), covariance) == pytest.approx(alone, rel=0.03)


def test_a_stated_tcp_bias_is_a_contribution_to_every_point_and_gives_the_advice():
    pairs = PointPairs(tuple("abcde"), BODY, BODY + SIGMA_MM * np.random.default_rng(1).normal(size=BODY.shape))
    plain = calibrate(pairs, teaching=TeachingError(sigma_mm=SIGMA_MM))
    biased = calibrate(pairs, teaching=TeachingError(sigma_mm=SIGMA_MM, tcp_bias_mm=1.0))
    more = biased.budget.covariances(BODY) - plain.budget.covariances(BODY)
    # a quarter turn moves a bias of 1 mm in an unknown direction by √2 mm at most: 2/3 mm² along each axis
    assert np.allclose(more, 2.0 / 3.0 * np.eye(3), rtol=0, atol=1e-12)
    assert "posture" in next(issue.message for issue in biased.issues if issue.code == "tcp-bias")


def test_a_bound_is_an_even_spread():
    assert TeachingError(bound_mm=0.5).per_axis_mm == pytest.approx(0.5 / np.sqrt(3), rel=0, abs=1e-15)


@pytest.mark.parametrize(
    "options", [{"sigma_mm": -1.0}, {"bound_mm": np.inf}, {"sigma_mm": 5e-324}, {"sigma_mm": 1.0, "bound_mm": 1.0}]
)
def test_an_impossible_teaching_error_is_refused(options):
    with pytest.raises(InputError, match="teaching error"):
        TeachingError(**options)


def test_a_blunder_makes_robust_the_best_criterion_and_a_quiet_set_least_squares():
    rng = np.random.default_rng(2)
    real = BODY + 0.1 * rng.normal(size=BODY.shape)
    assert calibrate(PointPairs(tuple("abcde"), BODY, real)).criteria.best is Criterion.LEAST_SQUARES
    real[4] += [0, 9, 0]
    comparison = calibrate(PointPairs(tuple("abcde"), BODY, real), teaching=TeachingError(sigma_mm=0.1)).criteria
    assert comparison.best is Criterion.ROBUST
    assert {row["criterion"] for row in comparison.rows} == {"minimax", "least_squares", "robust"}
