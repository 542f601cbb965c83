"""The search for the best sets against trying everything, and its figure against that of `calibrate`."""

from itertools import combinations

import numpy as np
import pytest

from tests.coverage_study import error_95
from wpcal.calibrate.errors.linear_fit import isotropic_covariance
from wpcal.core.progress import no_progress
from wpcal.core.tangent import exp_rotation
from wpcal.touch.design import Design, farthest_rows, least_swap

TABLE = 1e-6  #: The quantile is read from a table of 2001 values.
ROUND_OFF_MM2 = 1e-8


def design(seed: int, features: int = 12) -> Design:
    rng = np.random.default_rng(seed)
    return Design(rng.uniform(0, 1, (features, 3)) * [300, 200, 80], rng.uniform(0, 1, (9, 3)) * [300, 200, 80])


def test_the_figure_is_that_of_the_calibration() -> None:
    d = design(0)
    rows = np.array([[0, 3, 5, 9], [1, 2, 6, 11]])
    expected = [error_95(d.seam_points, isotropic_covariance(d.points[row], 0.3)).max() for row in rows]
    np.testing.assert_allclose(0.3 * d.largest_errors(rows), expected, rtol=0, atol=TABLE)


def test_points_on_a_line_are_never_the_best() -> None:
    d = Design(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [1, 1, 0.0]]) * 100, np.array([[150.0, 20, 5]]))
    rows, errors = d.best_sets(3, rng=np.random.default_rng(0), progress=no_progress)
    assert np.isinf(d.largest_errors(np.array([[0, 1, 2]]))).all()
    assert (rows == 4).any(axis=1).all()
    assert np.isfinite(errors).all()


@pytest.mark.parametrize("seed", range(4))
def test_exchange_finds_the_best_of_all_sets(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    d = design(seed, features=16)
    every = np.array(list(combinations(range(16), 4)))
    errors = d.largest_errors(every)
    rng = np.random.default_rng(0)
    tried, tried_errors = d.best_sets(4, rng=rng, progress=no_progress)
    np.testing.assert_array_equal(tried[0], every[np.argmin(errors)])
    monkeypatch.setattr("wpcal.touch.design.MOST_ENUMERATED", 0)
    exchanged, exchanged_errors = d.best_sets(4, rng=rng, progress=no_progress)
    np.testing.assert_array_equal(exchanged[0], tried[0])
    assert exchanged_errors[0] == pytest.approx(tried_errors[0], rel=1e-12)


@pytest.mark.parametrize("most", [0, 150_000])
def test_held_points_stay(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("wpcal.touch.design.MOST_ENUMERATED", most)
    d = design(5)
    rows, errors = d.best_sets(4, held=(2, 7), rng=np.random.default_rng(0), progress=no_progress)
    assert (rows == 2).any(axis=1).all()
    assert (rows == 7).any(axis=1).all()
    others = [(2, 7, *pair) for pair in combinations([k for k in range(12) if k not in (2, 7)], 2)]
    assert errors[0] == pytest.approx(d.largest_errors(np.array(others)).min(), rel=1e-12)


def test_the_figure_does_not_depend_on_the_frame() -> None:
    d = design(6)
    R = exp_rotation([0.3, -1.0, 0.7])
    moved = Design(d.points @ R.T + [500, -20, 30], d.seam_points @ R.T + [500, -20, 30])
    rows = np.array(list(combinations(range(8), 4)))
    np.testing.assert_allclose(moved.largest_errors(rows), d.largest_errors(rows), rtol=0, atol=TABLE)


def test_a_symmetric_set_has_a_hidden_swap() -> None:
    rectangle = np.array([[0, 0, 0], [100, 0, 0], [100, 60, 0], [0, 60, 0.0]])
    squares, order = least_swap(rectangle)
    assert squares == pytest.approx(0.0, abs=ROUND_OFF_MM2)
    assert sorted(order) == [0, 1, 2, 3]
    odd, _ = least_swap(rectangle + np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0], [30, 0, 0.0]]))
    assert odd > 100.0


def test_a_mirrored_order_is_no_swap() -> None:
    corner = np.array([[0, 0, 0], [100, 0, 0], [0, 100, 0], [30, 30, 80.0]])  # its one symmetry is a mirror
    assert least_swap(corner)[0] > 100.0


def test_farthest_rows_reach_the_ends() -> None:
    line = np.linspace([0, 0, 0], [100.0, 0, 0], 101)
    assert set(farthest_rows(line, 3)) == {0, 50, 100}
