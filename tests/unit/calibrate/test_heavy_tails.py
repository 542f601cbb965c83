"""Residuals with heavy tails: they are noticed, and the predicted error of minimax covers the true one."""

import numpy as np
import pytest

from tests.few import few
from wpcal.calibrate import Criterion, TeachingError, calibrate
from wpcal.calibrate.observe.points import PointProblem, points_have_heavy_tails
from wpcal.calibrate.solve.least_squares import fit_least_squares
from wpcal.calibrate.solve.weighted import fit_weighted
from wpcal.core.pairs import PointPairs

POINTS = np.random.default_rng(3).uniform(0.0, [400.0, 300.0, 150.0], (20, 3))
SEAM = np.array([[50.0, 100.0, 20.0], [350.0, 250.0, 20.0]])
TRIALS = 60


def noise(kind: str, rng: np.random.Generator) -> np.ndarray:
    return 0.3 * (rng.standard_t(3, POINTS.shape) / 3**0.5 if kind == "t3" else rng.standard_normal(POINTS.shape))


SIZES = np.linalg.qr(np.random.default_rng(5).normal(size=(20, 3, 3)))[0] * [0.5, 1.0, 2.0]
"""Square roots of covariances of points that state an error of their own in every direction, in units of the error."""


def pairs_of(error: np.ndarray, covariances: np.ndarray | None = None) -> PointPairs:
    n = len(error)
    return PointPairs(tuple(f"P{i}" for i in range(n)), POINTS[:n], POINTS[:n] + error, covariances)


def taught(kind: str, rng: np.random.Generator, *, of_each: bool) -> PointPairs:
    if not of_each:
        return pairs_of(noise(kind, rng))
    covariances = 0.09 * SIZES @ SIZES.transpose(0, 2, 1)
    return pairs_of(np.einsum("nij,nj->ni", SIZES, noise(kind, rng)), covariances)


def has_heavy_tails(pairs: PointPairs) -> bool:
    return points_have_heavy_tails(
        pairs, fit_least_squares(pairs) if pairs.covariances is None else fit_weighted(pairs)
    )


@pytest.mark.parametrize("of_each", few([True, False], 1))
@pytest.mark.parametrize(("kind", "least", "most"), [("gaussian", 0.0, 0.1), ("t3", 0.5, 1.0)])
@pytest.mark.many
def test_heavy_tails_are_noticed_and_gaussian_errors_seldom_are(kind, least, most, of_each):
    rng = np.random.default_rng(0)
    found = np.mean([has_heavy_tails(taught(kind, rng, of_each=of_each)) for _ in range(200)])
    assert least <= found <= most


@pytest.mark.parametrize("stated", few(["of each", "none", "one for all"], 1))
@pytest.mark.parametrize("kind", few(["t3", "gaussian"], 1))
@pytest.mark.many
def test_the_predicted_error_of_minimax_covers_the_true_one(kind, stated):
    rng = np.random.default_rng(1)
    teaching = TeachingError(sigma_mm=0.3) if stated == "one for all" else TeachingError()
    covered = []
    for _ in range(TRIALS):
        fit = PointProblem(taught(kind, rng, of_each=stated == "of each"), teaching).fit(Criterion.MINIMAX)
        off = np.linalg.norm(fit.T.apply(SEAM) - SEAM, axis=1)
        covered.append(np.mean(off <= fit.error_95_mm(SEAM)))
    assert np.mean(covered) >= 0.9


def test_exact_points_and_three_points_have_no_shape():
    assert not has_heavy_tails(pairs_of(np.tile([900.0, 20.0, -300.0], (20, 1))))
    rng = np.random.default_rng(0)
    assert not any(has_heavy_tails(pairs_of(noise("t3", rng)[:3])) for _ in range(60))


def test_the_advice_names_the_criterion_and_what_it_gives():
    error = noise("gaussian", np.random.default_rng(2))
    error[4] *= 6.0
    result = calibrate(pairs_of(error), seam_points=SEAM, criterion=Criterion.MINIMAX)
    assert result.criterion_advice is not None
    assert "--criterion" in result.criterion_advice
    assert "equal by construction" in result.criterion_advice
    asked = calibrate(pairs_of(error), seam_points=SEAM, criterion=Criterion.LEAST_SQUARES)
    assert asked.criterion_advice is None
