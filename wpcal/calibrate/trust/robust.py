"""Which points the others contradict: the fit that is insensitive to them is least squares on the rest.

Of up to 40 points, single points, pairs and larger sets are left out in turn (`wpcal.calibrate.trust.left_out`). For
more points, many three-point fits are made; the one whose nearest points agree best is refined on those points (least
trimmed squares), and all points are tested against the fit of those that pass, until these stay the same.

References: Rousseeuw, Leroy (1987), Robust Regression and Outlier Detection, ch. 5 (least trimmed squares,
concentration steps).
"""

from __future__ import annotations

from functools import lru_cache
from itertools import combinations
from math import comb

import numpy as np
from scipy.special import chdtri, fdtri

from wpcal.calibrate.solve.error_rows import ErrorRows
from wpcal.calibrate.solve.least_squares import distances
from wpcal.calibrate.trust.left_out import NOTHING, Contradiction, find_wrong, weigh_one
from wpcal.calibrate.trust.residuals import FALSE_ALARM, FLOOR_MM
from wpcal.core.arrays import BoolArray, IntArray
from wpcal.core.pairs import PointPairs

MOST_TRIPLES = 100
"""This many random triples meet three good points with a probability above 1 - 1e-12 when a third of the points is
wrong."""
FIRST_STEPS, MOST_FINALISTS = 2, 10
"""After this many steps only this many fits are refined further (Rousseeuw, Van Driessen 1999, FAST-LTS)."""
MOST_COMPARED = 40
"""Up to this many points, sets of points are left out in turn: 780 pairs. Beyond, a third of wrong points is found by
three-point fits."""
CLOUD = 200  #: Of larger sets, the first fit is found on this many points.
CONCENTRATION_STEPS = 20  #: Each step keeps the nearest points and fits again. The sum stops falling after a few steps.


@lru_cache(maxsize=4)
def contradicted_points(pairs: PointPairs, *, sigma_mm: float | None = None, seed: int = 0) -> Contradiction:
    """Find the points that the others contradict. Without sets for three points. `pairs`: At least three, mm."""
    n = len(pairs)
    if n < 4:
        return NOTHING
    rows = ErrorRows.of(pairs, sigma_mm)
    if n <= MOST_COMPARED:
        return find_wrong(rows)
    wrong = tuple(int(i) for i in np.flatnonzero(~_consistent(rows, seed)))
    if not wrong or not rows.select(np.setdiff1d(np.arange(n), wrong)).fixes_rotation():
        return NOTHING
    if n > CLOUD:
        return Contradiction((wrong,), (1.0,), len(wrong), remains=False)
    return weigh_one(rows, wrong)


def _consistent(rows: ErrorRows, seed: int) -> BoolArray:
    """Points within the limit of one fit; their number makes the fit's own error small."""
    n = len(rows)
    sample = np.arange(n) if n <= CLOUD else np.random.default_rng(seed).choice(n, CLOUD, replace=False)
    keep = np.zeros(n, dtype=bool)
    keep[sample[_trimmed_set(rows.select(sample), seed)]] = True
    least, scale = int(keep.sum()), None
    for _ in range(CONCENTRATION_STEPS):
        R, t = rows.select(keep).fit()
        squares, freedom = rows.squares(R, t), 3 * int(keep.sum()) - 6
        limit = float(chdtri(3, FALSE_ALARM / n))
        if not rows.scaled:
            # the median of χ² with three degrees of freedom makes the median square a scale, to begin with
            scale = float(np.median(squares) / chdtri(3, 0.5) if scale is None else squares[keep].sum() / freedom)
            limit = 3.0 * float(fdtri(3, freedom, 1.0 - FALSE_ALARM / n)) * scale
        before, keep = keep, (squares <= limit) | (distances(rows.p, rows.q, R, t) <= FLOOR_MM)
        if keep.sum() < least or np.array_equal(before, keep):
            return before
    return keep


def _trimmed_set(rows: ErrorRows, seed: int) -> IntArray:
    """The points of the least trimmed sum of squares; a bare majority, at least three."""
    n = len(rows)
    size = max(3, (n + 4) // 2) if n > 4 else 3
    R, t = rows.select(_triples(n, seed)).fit()
    kept = np.empty((len(R), size), dtype=np.int64)
    before = np.full(len(R), np.inf)
    for step in range(CONCENTRATION_STEPS):
        squares = rows.squares(R, t)
        kept = np.argpartition(squares, size - 1, axis=1)[:, :size]
        sums = np.sum(np.take_along_axis(squares, kept, axis=1), axis=1)
        if np.array_equal(sums, before):
            break
        if step == FIRST_STEPS:
            best = np.argsort(sums, kind="stable")[:MOST_FINALISTS]
            kept, sums = kept[best], sums[best]
        R, t = rows.select(kept).fit()
        before = sums
    return np.asarray(kept[int(np.argmin(before))])


def _triples(n: int, seed: int) -> IntArray:
    if comb(n, 3) <= MOST_TRIPLES:
        return np.array(list(combinations(range(n), 3)))
    rng = np.random.default_rng(seed)
    return np.stack([rng.choice(n, 3, replace=False) for _ in range(MOST_TRIPLES)])
