"""The smooth errors of an arm: of all lengths and ratios the likeliest, computed with dense matrices."""

import numpy as np
import pytest

from wpcal.robot.identify.error_field import LENGTHS_MM, RATIOS, error_field


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
    assert found is not None
    expected = [np.sqrt(variance * ratio), length if ratio else found.length_mm, np.sqrt(variance)]
    assert list(found.to_record().values()) == pytest.approx(expected, rel=1e-9)
