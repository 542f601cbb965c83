"""Which points the others contradict: the fit that is insensitive to them is least squares on the rest.

Of up to 40 points, single points, pairs and larger sets are left out in turn (`wpcal.calibrate.trust.left_out`). For
more points, many three-point fits are made; the one whose nearest points agree best is refined on those points (least
trimmed squares), and every other point is tested against it.

References
----------
Rousseeuw, Leroy (1987), Robust Regression and Outlier Detection, ch. 5 (least trimmed squares, concentration steps).
"""

from __future__ import annotations

from functools import lru_cache
from itertools import combinations
from math import comb, inf

import numpy as np
from scipy.special import chdtri, fdtri

from wpcal.calibrate.solve.error_rows import ErrorRows
from wpcal.calibrate.solve.least_squares import distances
from wpcal.calibrate.trust.left_out import NOTHING, Contradiction, find_wrong, weigh_one
from wpcal.calibrate.trust.residuals import FALSE_ALARM, FLOOR_MM
from wpcal.core.arrays import BoolArray, IntArray
from wpcal.core.pairs import PointPairs
from wpcal.core.tangent import point_jacobian

MOST_TRIPLES = 100
"""So many random triples meet three good points with a probability above 1 - 1e-12 when a third of the points is
wrong."""
FIRST_STEPS, MOST_FINALISTS = 2, 10
"""After so many steps only so many fits are refined further (Rousseeuw, Van Driessen 1999, FAST-LTS)."""
MOST_COMPARED = 40
"""Up to this many points, sets of points are left out in turn: 780 pairs. Beyond, a third of wrong points is found by
three-point fits."""
CLOUD = 200  #: Larger sets are tested at once against one fit, found on this many of their points.
CONCENTRATION_STEPS = 20
"""Each step keeps the nearest points and fits again. The sum stops falling after a few steps."""


@lru_cache(maxsize=4)
def contradicted_points(pairs: PointPairs, *, sigma_mm: float | None = None, seed: int = 0) -> Contradiction:
    """Find the points that the others contradict. Without sets for three points.

    `pairs`: At least three, mm.
    """
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
    n = len(rows)
    if n > CLOUD:
        return _consistent_cloud(rows, seed)
    keep = np.zeros(n, dtype=bool)
    keep[_trimmed_set(rows, seed)] = True
    while not keep.all():  # take in the nearest point as long as it passes the test
        inside = rows.select(keep)
        outside = np.flatnonzero(~keep)
        nearest = outside[np.argmin(rows.select(outside).squares(*inside.fit()))]
        if _is_blunder(inside, rows.select(nearest), points=n):
            break
        keep[nearest] = True
    return keep


def _consistent_cloud(rows: ErrorRows, seed: int) -> BoolArray:
    """Points of a large cloud within the limit of one fit; their number makes the fit's own error small."""
    n = len(rows)
    sample = np.random.default_rng(seed).choice(n, CLOUD, replace=False)
    trimmed = sample[_trimmed_set(rows.select(sample), seed)]
    keep = np.zeros(n, dtype=bool)
    keep[trimmed] = True
    for _ in range(CONCENTRATION_STEPS):
        R, t = rows.select(keep).fit()
        squares = rows.squares(R, t)
        # the median of χ² with three degrees of freedom makes the median square a scale
        scale = 1.0 if rows.scaled else float(np.median(squares) / chdtri(3, 0.5))
        near = distances(rows.p, rows.q, R, t) <= FLOOR_MM
        before, keep = keep, near | (squares <= float(chdtri(3, FALSE_ALARM / n)) * scale)
        if keep.sum() < len(trimmed) or np.array_equal(before, keep):
            return before
    return keep


def _is_blunder(inside: ErrorRows, new: ErrorRows, *, points: int) -> bool:
    """Test one further pair against the weighted fit of n others.

    Its deviation from their prediction has the covariance C + J M⁻¹ Jᵀ with M = Σ Jᵢᵀ Λᵢ Jᵢ; its normalised square is
    χ² with three degrees of freedom, or 3 F(3, 3 n - 6) with the scale from the residuals. The false alarm is shared
    among `points` tests.
    """
    R, t = inside.fit()
    moved = inside.p @ R.T + t
    centre = moved.mean(axis=0)
    deviation = new.q - R @ new.p - t
    J, J_new = point_jacobian(moved - centre), point_jacobian((new.q - deviation - centre)[None])[0]
    spread = np.linalg.pinv(np.einsum("nik,nij,njl->kl", J, inside.information, J), hermitian=True)
    square = float(deviation @ np.linalg.solve(new.covariances + J_new @ spread @ J_new.T, deviation))
    freedom, level = 3 * len(inside) - 6, FALSE_ALARM / points
    if inside.scaled:
        limit = float(chdtri(3, level))
    elif freedom > 0:
        limit = 3.0 * float(fdtri(3, freedom, 1.0 - level)) * float(inside.squares(R, t).sum()) / freedom
    else:
        limit = inf
    return square > limit and float(np.linalg.norm(deviation)) > FLOOR_MM


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
