"""Residuals with heavy tails: they are noticed, and the predicted error of minimax covers the true one."""

import numpy as np
import pytest

from wpcal.calibrate import Criterion, TeachingError, calibrate
from wpcal.calibrate.points.heavy_tails import has_heavy_tails
from wpcal.calibrate.points.problem import PointProblem
from wpcal.core.pairs import PointPairs

POINTS = np.random.default_rng(3).uniform(0.0, [400.0, 300.0, 150.0], (20, 3))
SEAM = np.array([[50.0, 100.0, 20.0], [350.0, 250.0, 20.0]])
TRIALS = 60


def noise(kind: str, rng: np.random.Generator) -> np.ndarray:
    return 0.3 * (rng.standard_t(3, POINTS.shape) / 3**0.5 if kind == "t3" else rng.standard_normal(POINTS.shape))


def pairs_of(error: np.ndarray) -> PointPairs:
    return PointPairs(tuple(f"P{i}" for i in range(len(error))), POINTS[: len(error)], POINTS[: len(error)] + error)


@pytest.mark.parametrize(("kind", "least", "most"), [("gaussian", 0.0, 0.1), ("t3", 0.5, 1.0)])
def test_heavy_tails_are_noticed_and_gaussian_errors_seldom_are(kind, least, most):
    rng = np.random.default_rng(0)
    found = np.mean([has_heavy_tails(POINTS, POINTS + noise(kind, rng)) for _ in range(200)])
    assert least <= found <= most


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize("kind", ["gaussian", "t3"])
def test_the_predicted_error_of_minimax_covers_the_true_one(kind, stated):
    rng = np.random.default_rng(1)
    teaching = TeachingError(sigma_mm=0.3) if stated else TeachingError()
    covered = []
    for _ in range(TRIALS):
        fit = PointProblem(pairs_of(noise(kind, rng)), teaching).fit(Criterion.MINIMAX)
        off = np.linalg.norm(fit.T.apply(SEAM) - SEAM, axis=1)
        covered.append(np.mean(off <= fit.error_95_mm(SEAM)))
    assert np.mean(covered) >= 0.9


def test_exact_points_and_three_points_have_no_shape():
    assert not has_heavy_tails(POINTS, POINTS + np.array([900.0, 20.0, -300.0]))
    assert not has_heavy_tails(POINTS[:3], POINTS[:3] + noise("t3", np.random.default_rng(0))[:3])


def test_the_advice_names_the_criterion_and_what_it_gives():
    error = noise("gaussian", np.random.default_rng(2))
    error[4] *= 6.0
    result = calibrate(pairs_of(error), seam_points=SEAM)
    assert result.criterion_advice is not None
    assert "--criterion" in result.criterion_advice
    assert "equal by construction" in result.criterion_advice
    asked = calibrate(pairs_of(error), seam_points=SEAM, criterion=Criterion.LEAST_SQUARES)
    assert asked.criterion_advice is None
