"""The cheapest way over the rungs of a ladder, by dynamic programming."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.same_bits import first_least


def cheapest_way(own: Sequence[FloatArray], step: Callable[[int, IntArray, IntArray], FloatArray]) -> list[int]:
    """Return one state per rung, up to the last rung that can be reached; empty if the first cannot.

    Of ways whose costs differ by round-off alone, the one through the first states is taken.

    `own`: Cost of each state of every rung, shape (m_i,) each; infinite where the state cannot be used.
    `step`: Costs from states of rung i - 1 to states of rung i, shape (now, before): of i and the rows of both.
    """
    cost, back = own[0], list[IntArray]()
    for i in range(1, len(own)):
        now, before = np.flatnonzero(np.isfinite(own[i])), np.flatnonzero(np.isfinite(cost))
        if not len(now) or not len(before):
            break
        total = step(i, now, before) + cost[before]
        best = first_least(total, axis=1)
        found, came = np.full(len(own[i]), np.inf), np.zeros(len(own[i]), dtype=np.int64)
        found[now], came[now] = total[np.arange(len(now)), best] + own[i][now], before[best]
        if not np.isfinite(found).any():
            break
        cost = found
        back.append(came)
    if not np.isfinite(cost).any():
        return []
    way = [int(first_least(cost))]
    for came in reversed(back):
        way.append(int(came[way[-1]]))
    return way[::-1]
