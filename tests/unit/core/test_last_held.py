"""Bisection of many intervals at once, against thresholds that are known."""

import math

import numpy as np
import pytest

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.last_held import last_held

ROUND_OFF = 1e-3  #: Of an interval that is 3e7 times shorter than its ends are large.


@pytest.mark.parametrize("halvings", [1, 7, 25])
@pytest.mark.parametrize(("count", "inner"), [(1, 15), (31, 15), (32, 7), (63, 3), (125, 3), (126, 1), (1000, 1)])
def test_the_border_lies_between_the_two_ends(count: int, inner: int, halvings: int) -> None:
    """At most 500 values at once, or one for each interval."""
    rng = np.random.default_rng(count)
    good, bad = rng.normal(size=(2, count)) * 7.0
    border = good + rng.uniform(0.02, 0.98, count) * (bad - good)
    asked = list[int]()

    def holds(row: IntArray, at: FloatArray) -> BoolArray:
        asked.append(len(row))
        return np.asarray(np.abs(at - good[row]) < np.abs(border - good)[row])

    held, failed = last_held(good, bad, holds, halvings=halvings)
    share = np.abs(failed - held) / np.abs(bad - good)
    assert share.max() <= 0.5**halvings * (1 + ROUND_OFF)
    assert (np.sign(held - border) != np.sign(failed - border)).all()
    assert ((held - good) * (bad - failed) >= 0).all()
    assert asked == [count * inner] * math.ceil(halvings / math.log2(inner + 1))


def test_a_change_that_comes_back_counts_where_it_is_seen_first() -> None:
    held, failed = last_held(
        np.zeros(1), np.ones(1), lambda _, at: np.asarray((at < 0.3) | (at > 0.6) & (at < 0.9)), halvings=12
    )
    assert held[0] < 0.3 <= failed[0]
