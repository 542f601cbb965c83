import numpy as np
import pytest

from wpcal.core.errors import InputError
from wpcal.planning.search.pareto import hypervolume, is_nondominated, thin_front

ROUND_OFF = 1e-9  #: Sums of some tens of products near a thousand.
SAMPLING = 0.01  #: Three standard deviations of a share of 0.3 in 20 000 random points.


def test_nondominated_rows_by_hand():
    values = np.array([[1, 3], [2, 2], [3, 1], [2, 3], [2, 2], [0.5, 9]], dtype=float)
    assert is_nondominated(values).tolist() == [True, True, True, False, False, True]


def test_hypervolume_is_that_of_boxes_by_hand():
    assert hypervolume(np.array([[1.0, 1.0, 1.0]]), np.array([2.0, 3.0, 4.0])) == 6.0
    two = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    assert hypervolume(two, np.array([2.0, 2.0, 1.0])) == 3.0
    assert hypervolume(np.array([[5.0, 0.0, 0.0]]), np.array([2.0, 2.0, 1.0])) == 0.0


def test_hypervolume_is_the_share_of_random_points_that_some_row_beats():
    rng = np.random.default_rng(0)
    values, points = rng.uniform(0.2, 1.0, (12, 3)), rng.uniform(0.0, 1.0, (20_000, 3))
    share = (values[:, None] <= points).all(axis=2).any(axis=0).mean()
    assert hypervolume(values, np.ones(3)) == pytest.approx(share, rel=0, abs=SAMPLING)


def test_a_dominated_row_adds_nothing_and_another_one_does():
    rng = np.random.default_rng(1)
    values = rng.uniform(0.0, 1.0, (10, 3))
    before = hypervolume(values, np.ones(3))
    assert hypervolume(np.vstack([values, values[3] + 0.01]), np.ones(3)) == pytest.approx(before, rel=0, abs=ROUND_OFF)
    assert hypervolume(np.vstack([values, values.min(axis=0)]), np.ones(3)) > before


def test_a_thinned_front_holds_the_ends_and_leaves_no_gap():
    x = np.linspace(0.0, 1.0, 101)
    rows = thin_front(np.stack([x, 100.0 * (1.0 - x)], axis=1), 5)
    assert rows.tolist() == [0, 25, 50, 75, 100]
    assert thin_front(np.ones((3, 2)), 5).tolist() == [0, 1, 2]


def test_objectives_must_be_as_many_as_the_reference():
    with pytest.raises(InputError, match="expected rows of 2 objectives"):
        hypervolume(np.zeros((3, 3)), np.zeros(2))
