"""The box tree finds the pairs that comparing everything with everything finds."""

import numpy as np
import pytest

from wpcal.brep.boxes import BoxTree
from wpcal.core.arrays import FloatArray


def random_boxes(rng: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
    """Boxes from 1 to 1000 mm: long rails beside bolts."""
    low = rng.uniform(0.0, 1000.0, (count, 3))
    return low, low + 10.0 ** rng.uniform(0.0, 3.0, (count, 3))


@pytest.mark.parametrize("count", [0, 1, 8, 9, 700])
def test_pairs_are_those_of_brute_force(count: int) -> None:
    rng = np.random.default_rng(count)
    low, high = random_boxes(rng, count)
    query_low, query_high = random_boxes(rng, 300)
    query, box = BoxTree.of(low, high).meeting(query_low, query_high)
    lap = ((query_low[:, None] <= high[None]) & (query_high[:, None] >= low[None])).all(axis=2)
    expected = np.nonzero(lap)
    np.testing.assert_array_equal(query, expected[0])
    np.testing.assert_array_equal(box, expected[1])


def test_boxes_that_touch_meet_and_empty_ones_never() -> None:
    low = np.array([[0.0, 0, 0], [np.inf] * 3, [2, 0, 0]])
    high = np.array([[1.0, 1, 1], [-np.inf] * 3, [3, 1, 1]])
    query, box = BoxTree.of(low, high).meeting(np.array([[1.0, 1, 1]]), np.array([[2.0, 2, 2]]))
    assert (query.tolist(), box.tolist()) == ([0, 0], [0, 2])
