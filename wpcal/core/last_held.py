"""Where something last holds between two values: bisection of many intervals at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray

POINTS = 500  #: This many values at once cost about as much as one: few intervals are divided into more parts.
MOST_BITS = 4  #: Parts of an interval in one round, as power of two.


def last_held(
    good: FloatArray, bad: FloatArray, holds: Callable[[IntArray, FloatArray], BoolArray], *, halvings: int
) -> tuple[FloatArray, FloatArray]:
    """Narrow intervals between a value for which something is taken to hold and one for which it is taken not to.

    `good`, `bad`: shape (n,).
    `holds`: Takes rows of these (m,) and values (m,), and tells for which of them it holds.
    `halvings`: The intervals become at least 2^halvings times shorter.
    Returns `good, bad`: shape (n,). The first change seen in each round; up to `good` nothing seen there failed.
    """
    if len(good) == 0:
        return good, bad
    bits = min(max((POINTS // len(good)).bit_length() - 1, 1), MOST_BITS)
    share = np.arange(1, 2**bits) / 2**bits
    rows = np.arange(len(good))
    for _ in range(-(-halvings // bits)):
        inner = good[:, None] + share * (bad - good)[:, None]
        held = holds(np.repeat(rows, len(share)), inner.ravel()).reshape(inner.shape)
        at = np.where(held.all(axis=1), len(share), held.argmin(axis=1))
        ends = np.column_stack([good, inner, bad])
        good, bad = ends[rows, at], ends[rows, at + 1]
    return good, bad
