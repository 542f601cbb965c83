"""The exact search against trying everything, and what it must not depend on."""

from itertools import product

import numpy as np
import pytest

from tests.unit.taught.match.random_parts import pattern_points, random_points, touched
from wpcal.calibrate.solve.least_squares import kabsch
from wpcal.core.errors import GeometryError, InputError
from wpcal.taught.match import find_assignments
from wpcal.taught.match.search import squares_limit
from wpcal.taught.match.triangle import Triangle, fit_triangles

ROUND_OFF_MM2 = 1e-7  #: Sums of squares of numbers of 1e6 mm² keep nine digits.


def sums_of_squares(points: np.ndarray, rows: np.ndarray, taught: np.ndarray) -> np.ndarray:
    p = points[rows]
    q = np.broadcast_to(taught, p.shape)
    R, t = kabsch(p, q, np.full(p.shape[:2], 1.0 / p.shape[1]))
    left = q - p @ R.transpose(0, 2, 1) - t[:, None]
    return np.einsum("mni,mni->m", left, left)


@pytest.mark.parametrize(("seed", "n"), [(0, 3), (1, 3), (2, 4), (3, 4), (4, 5)])
def test_it_finds_what_trying_everything_finds(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    lattice = np.array(list(product((0.0, 50.0), (0.0, 50.0), (0.0, 70.0))))  # symmetric: many equal distances
    points = lattice if n == 5 else np.concatenate([lattice, random_points(rng, 3) / 10.0])
    _, taught = touched(rng, lattice, n, 0.5)
    sigma = 1.0
    everything = np.array(list(product(range(len(points)), repeat=n)))
    sums = sums_of_squares(points, everything, taught)
    accepted = everything[sums <= squares_limit(n, sigma)]
    found = find_assignments(points, taught, sigma_mm=sigma)
    assert len(accepted) > 1
    assert sorted(map(tuple, found.rows)) == sorted(map(tuple, accepted))
    np.testing.assert_allclose(found.squares_mm2, np.sort(sums)[: len(accepted)], rtol=0, atol=ROUND_OFF_MM2)


@pytest.mark.parametrize("n", [4, 5, 8])
def test_the_true_features_are_found_among_hundreds(n: int) -> None:
    rng = np.random.default_rng(n)
    points = random_points(rng, 400)
    rows, taught = touched(rng, points, n, 0.3)
    found = find_assignments(points, taught, sigma_mm=0.3)
    np.testing.assert_array_equal(found.rows[0], rows)


def test_a_mirrored_part_is_no_answer() -> None:
    rng = np.random.default_rng(5)
    points = random_points(rng, 60)
    rows, _ = touched(rng, points, 5, 0.0)
    assert len(find_assignments(points, points[rows] * [1, 1, -1], sigma_mm=0.1).rows) == 0


def test_rows_that_are_known_stay() -> None:
    rng = np.random.default_rng(6)
    points = pattern_points(rng)
    rows, taught = touched(rng, points, 4, 0.1)
    free = find_assignments(points, taught, sigma_mm=0.1)
    held = find_assignments(points, taught, sigma_mm=0.1, allowed=[None, rows[1:2], None, None])
    expected = free.rows[free.rows[:, 1] == rows[1]]
    assert sorted(map(tuple, held.rows)) == sorted(map(tuple, expected))


def test_one_feature_touched_twice_is_an_answer() -> None:
    points = np.array([[0, 0, 0], [100, 0, 0], [0, 70, 0], [0, 0, 40.0]])
    taught = points[[0, 1, 1, 2, 3]] + [10.0, 20, 30]
    np.testing.assert_array_equal(find_assignments(points, taught, sigma_mm=0.1).rows, [[0, 1, 1, 2, 3]])


def test_the_order_of_the_taught_points_does_not_matter() -> None:
    rng = np.random.default_rng(7)
    points = random_points(rng, 100)
    _, taught = touched(rng, points, 5, 0.3)
    order = rng.permutation(5)
    first = find_assignments(points, taught, sigma_mm=0.3).rows
    np.testing.assert_array_equal(find_assignments(points, taught[order], sigma_mm=0.3).rows, first[:, order])


def test_the_fit_of_triangles_is_the_least_squares_fit() -> None:
    rng = np.random.default_rng(8)
    points, taught = random_points(rng, 30), random_points(rng, 4)
    rows = rng.permuted(np.tile(np.arange(30), (50, 1)), axis=1)[:, :3]
    fit = fit_triangles(points, rows, Triangle.of(taught, (0, 1, 2)))
    expected = sums_of_squares(points, rows, taught[:3])
    np.testing.assert_allclose(fit.squares_mm2, expected, rtol=1e-12, atol=ROUND_OFF_MM2)
    R, t = kabsch(np.broadcast_to(taught[:3], (50, 3, 3)), points[rows], np.full((50, 3), 1 / 3))
    np.testing.assert_allclose(fit.carry(taught[3]), R @ taught[3] + t, rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    ("taught", "says"),
    [([[0, 0, 0], [100, 0, 0]], "at least 3"), ([[0, 0, 0], [100, 0, 0], [200, 0.5, 0]], "nearly on one line")],
)
def test_points_that_cannot_be_told(taught: list[list[float]], says: str) -> None:
    with pytest.raises(GeometryError, match=says):
        find_assignments(random_points(np.random.default_rng(0), 20), taught, sigma_mm=0.3)


def test_a_negative_error_is_refused() -> None:
    with pytest.raises(InputError, match="not negative"):
        find_assignments(np.eye(3), np.eye(3), sigma_mm=-1.0)
