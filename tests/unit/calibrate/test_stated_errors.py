"""Points that state their own errors: the blunder test, the findings and the predicted errors use them."""

import numpy as np
import pytest

from tests.few import few
from wpcal.calibrate import (
    Criterion,
    PointProblem,
    TeachingError,
    calibrate,
    fit_least_squares,
    fit_weighted,
    solve_minimax,
)
from wpcal.calibrate.errors.linear_fit import LinearFit, isotropic_covariance
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.calibrate.trust.diagnose import diagnose_pairs
from wpcal.core import PointPairs
from wpcal.core.tangent import exp_rotation, log_rotation, point_jacobian, translation_adjoint

BODY = np.array([[0, 0, 0], [600, 0, 20], [580, 400, 0], [10, 390, 60], [300, 200, 300], [100, 350, 210.0]])
NAMES = tuple("abcdef")
SURE_MM, UNSURE_MM = 0.1, 2.0
ALONE = RobotField.none()
R = exp_rotation([0.3, -1.2, 0.4])
SEAM = np.array([[900.0, 0, 0]])
ROUND_OFF = 1e-9  # of covariances about a metre from the origin: mm², rad·mm, rad²


def covariances(row_mm):
    """Per row: one standard deviation, or three along the axes of the base."""
    return np.array([np.diag(np.broadcast_to(np.asarray(mm) ** 2.0, 3)) for mm in row_mm])


def pairs_of(errors_mm, row_mm):
    return PointPairs(NAMES, BODY, BODY @ R.T + [1000, -200, 300] + errors_mm, covariances(row_mm))


def noisy(row_mm, seed):
    draws = np.random.default_rng(seed).normal(size=BODY.shape)
    return pairs_of(np.einsum("nij,nj->ni", np.sqrt(covariances(row_mm)), draws), row_mm)


def distrusted(pairs, **options):
    return [name for issue in diagnose_pairs(pairs, **options).issues if issue.code == "blunder" for name in issue.ids]


def off(row, vector):
    errors = np.random.default_rng(1).normal(size=BODY.shape) * SURE_MM
    errors[row] += vector
    return errors


UNEQUAL = {
    "one unsure point": [SURE_MM, SURE_MM, UNSURE_MM, SURE_MM, SURE_MM, SURE_MM],
    "half of them unsure": [SURE_MM, UNSURE_MM, SURE_MM, UNSURE_MM, SURE_MM, UNSURE_MM],
    "unsure along one axis": [(SURE_MM, SURE_MM, UNSURE_MM)] * 3 + [(UNSURE_MM, SURE_MM, SURE_MM)] * 3,
}


@pytest.mark.parametrize("row_mm", UNEQUAL.values(), ids=UNEQUAL.keys())
def test_errors_as_stated_raise_no_finding(row_mm):
    quiet = sum(not diagnose_pairs(noisy(row_mm, seed)).issues for seed in range(100))
    assert quiet >= 95  # three tests of 1 % each


def test_the_same_deviation_is_a_blunder_of_a_sure_point_and_none_of_an_unsure_one():
    errors = off(3, [0, 0, 4.0])
    assert distrusted(pairs_of(errors, [SURE_MM] * 6)) == ["d"]
    assert distrusted(pairs_of(errors, [UNSURE_MM if i == 3 else SURE_MM for i in range(6)])) == []


def test_a_covariance_tells_along_which_axis_a_deviation_is_a_blunder():
    row_mm = [SURE_MM] * 5 + [(SURE_MM, SURE_MM, UNSURE_MM)]
    assert distrusted(pairs_of(off(5, [0, 0, 4.0]), row_mm)) == []
    assert distrusted(pairs_of(off(5, [4.0, 0, 0]), row_mm)) == ["f"]


def test_a_stated_error_of_the_points_goes_before_the_one_for_all():
    pairs = pairs_of(off(3, [0, 0, 4.0]), [SURE_MM] * 6)
    assert distrusted(pairs, teaching=TeachingError(sigma_mm=UNSURE_MM, robot=ALONE)) == ["d"]


def test_a_row_of_points_with_one_beside_it_keeps_the_one_beside_it():
    model = np.array([[0, 0, 0], [200, 0, 0], [400, 0, 0], [600, 0, 0], [300, 300, 0.0]])
    real = model.copy()
    real[4, 1] += 9.0
    pairs = PointPairs(tuple("abcde"), model, real)
    assert len(PointProblem(pairs, TeachingError(sigma_mm=SURE_MM)).fit(Criterion.ROBUST).rows) == len(pairs)


FITS = {
    Criterion.LEAST_SQUARES: fit_least_squares,
    Criterion.WEIGHTED: fit_weighted,
    Criterion.MINIMAX: lambda pairs: solve_minimax(pairs).T,
}
LINEAR = [(criterion, which) for criterion in (Criterion.LEAST_SQUARES, Criterion.WEIGHTED) for which in UNEQUAL]


@pytest.mark.parametrize("count", few([400, 2000], 1))
@pytest.mark.parametrize(("criterion", "which"), few([*LINEAR, (Criterion.MINIMAX, "one unsure point")], 4))
@pytest.mark.many
def test_the_predicted_error_of_unequal_points_holds_95_percent_of_simulated_fits(criterion, which, count):
    row_mm = UNEQUAL[which]
    exact = pairs_of(np.zeros(BODY.shape), row_mm)
    predicted = PointProblem(exact, TeachingError(robot=RobotField.none())).fit(criterion).error_95_mm(SEAM)[0]
    true = SEAM @ R.T + [1000, -200, 300]
    errors = [np.linalg.norm(FITS[criterion](noisy(row_mm, seed)).apply(SEAM) - true) for seed in range(count)]
    assert 0.92 <= np.mean(np.array(errors) <= predicted) <= 0.98


def propagated_covariance(p, C):
    back = translation_adjoint(p.mean(axis=0))
    return back @ LinearFit.of_points(p, covariances=C).touching @ back.T


@pytest.mark.many
def test_the_propagated_covariance_is_that_of_simulated_fits():
    row_mm = UNEQUAL["half of them unsure"]
    samples = []
    for seed in range(3000):
        pairs = noisy(row_mm, seed)
        T = fit_least_squares(pairs)
        turn = log_rotation(T.R @ R.T)
        samples.append(np.concatenate([turn, T.t_mm - [1000, -200, 300] + np.cross([1000, -200, 300], turn)]))
    seen = np.array(samples).T @ np.array(samples) / len(samples)
    predicted = propagated_covariance(BODY @ R.T + [1000, -200, 300], covariances(row_mm))
    ratios = np.linalg.eigvals(np.linalg.solve(predicted, seen)).real
    assert (np.abs(ratios - 1.0) < 0.12).all()  # 3000 samples: the extreme eigenvalues scatter by ± 2 √(6 / 3000)


def test_equal_errors_propagate_as_one_sigma_does():
    same = propagated_covariance(BODY, covariances([SURE_MM] * 6))
    np.testing.assert_allclose(same, isotropic_covariance(BODY, SURE_MM), rtol=0, atol=ROUND_OFF)


def test_a_calibration_predicts_from_the_errors_its_points_state():
    pairs = noisy(UNEQUAL["one unsure point"], 0)
    result = calibrate(pairs, criterion=Criterion.LEAST_SQUARES, tolerance_mm=10.0)
    expected = propagated_covariance(result.T_base_part.apply(BODY), pairs.covariances)
    assert result.sigma.degrees_of_freedom == np.inf
    seam = result.T_base_part.apply(SEAM)
    own = result.budget.contributions(seam)["touching"]
    J = point_jacobian(seam)
    np.testing.assert_allclose(own, J @ expected @ J.transpose(0, 2, 1), rtol=0, atol=ROUND_OFF)


@pytest.mark.parametrize("row_mm", UNEQUAL.values(), ids=UNEQUAL.keys())
def test_no_other_point_is_named_in_the_place_of_a_mis_taught_one(row_mm):
    rng = np.random.default_rng(0)
    named = []
    for seed in range(60):
        pairs, along = noisy(row_mm, seed), rng.normal(size=3)
        real = pairs.p_target + np.outer([0, 0, 0, 0, 1, 0], 4.0 * along / np.linalg.norm(along))
        named += distrusted(PointPairs(NAMES, BODY, real, pairs.covariances))
    assert set(named) == {"e"}
    assert len(named) >= 40  # of 60: beside three points unsure by 2 mm, 4 mm are not always told
