"""A fit that a mis-taught point does not move, and the test that names such a point.

Among many three-point fits the one whose nearest points agree best is refined on those points (least trimmed squares),
then every other point is tested against it, and the fit is least squares on the points that pass.

References
----------
Rousseeuw, Leroy (1987), Robust Regression and Outlier Detection, ch. 5 (least trimmed squares, concentration steps).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from math import comb, inf

import numpy as np
from scipy.special import chdtri, fdtri

from wpcal.calibrate.least_squares import distances, fit_least_squares, kabsch, require_spread
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.pairs import PointPairs
from wpcal.core.tangent import point_jacobian
from wpcal.core.transform import RigidTransform

MOST_TRIPLES = 600
"""Up to 16 points every triple is tried (560). Beyond, 600 random ones meet three good points with a probability
above 1 - 1e-12 when a third of the points is wrong."""

CLOUD = 200
"""Larger sets are tested at once against one fit, found on this many of their points."""

CONCENTRATION_STEPS = 20
"""Each step keeps the nearest points and fits again; the sum falls and rests after a few."""

FALSE_ALARM = 0.01
"""Probability, over all points of one fit, of calling a good point wrong."""

FLOOR_MM = 1e-6
"""A deviation below this is no blunder, also where all other points fit exactly."""


@dataclass(frozen=True, slots=True, eq=False)
class RobustSolution:
    """A fit and the points it rests on.

    Parameters
    ----------
    T : RigidTransform
    inlier : ndarray of bool, shape (n,)
        Points that pass the test.
    deviation_mm : ndarray, shape (n,)
        Distance of every point from the fit.
    """

    T: RigidTransform
    inlier: BoolArray
    deviation_mm: FloatArray


def fit_robust(pairs: PointPairs, *, sigma_mm: float | None = None, seed: int = 0) -> RobustSolution:
    """Fit with least squares on the points that agree.

    Parameters
    ----------
    pairs : PointPairs
        At least three, mm.
    sigma_mm : float, optional
        Teaching error per axis. Estimated from the points that agree where not given.
    seed : int
        Of the random triples of more than 16 points.

    Returns
    -------
    RobustSolution
        With three points, and wherever no test separates a point, the least-squares fit of all points.

    Raises
    ------
    GeometryError
        When the points do not fix a rotation.

    Notes
    -----
    Four corners of a plate cannot tell which of them is off the plane: every three of them fit. See
    `diagnose.find_issues`.
    """
    require_spread(pairs)
    everything = np.ones(len(pairs), dtype=bool)
    keep = everything if len(pairs) < 4 else _consistent(pairs, sigma_mm, seed)
    T = fit_least_squares(pairs.select(np.flatnonzero(keep)))
    return RobustSolution(T, keep, distances(pairs.p_source, pairs.p_target, T.R, T.t_mm))


def _consistent(pairs: PointPairs, sigma_mm: float | None, seed: int) -> BoolArray:
    n = len(pairs)
    p, q = pairs.p_source - pairs.p_source.mean(axis=0), pairs.p_target - pairs.p_target.mean(axis=0)
    if n > CLOUD:
        return _consistent_cloud(p, q, sigma_mm, seed)
    keep = np.zeros(n, dtype=bool)
    keep[_trimmed_set(p, q, seed)] = True
    if keep.sum() < 4 and sigma_mm is None and not _stands_out(p, q, keep):
        return np.ones(n, dtype=bool)
    while not keep.all():  # take in the nearest point as long as it passes the test
        R, t = kabsch(p[keep], q[keep], np.full(keep.sum(), 1.0 / keep.sum()))
        outside = np.flatnonzero(~keep)
        nearest = outside[np.argmin(distances(p[outside], q[outside], R, t))]
        if is_blunder(p[keep], q[keep], p[nearest], q[nearest], sigma_mm=sigma_mm, points=n):
            break
        keep[nearest] = True
    return keep


def _consistent_cloud(p: FloatArray, q: FloatArray, sigma_mm: float | None, seed: int) -> BoolArray:
    """Points of a large cloud within the limit of one fit; their number makes the fit's own error small."""
    n = len(p)
    sample = np.random.default_rng(seed).choice(n, CLOUD, replace=False)
    rows = sample[_trimmed_set(p[sample], q[sample], seed)]
    keep = np.zeros(n, dtype=bool)
    keep[rows] = True
    for _ in range(CONCENTRATION_STEPS):
        R, t = kabsch(p[keep], q[keep], np.full(keep.sum(), 1.0 / keep.sum()))
        d = distances(p, q, R, t)
        # the median of χ² with three degrees of freedom makes the median distance a scale
        sigma = float(np.median(d) / np.sqrt(chdtri(3, 0.5))) if sigma_mm is None else sigma_mm
        before, keep = keep, d <= max(np.sqrt(chdtri(3, FALSE_ALARM / n)) * sigma, FLOOR_MM)
        if keep.sum() < len(rows) or np.array_equal(before, keep):
            return before
    return keep


def is_blunder(
    p: FloatArray, q: FloatArray, p_new: FloatArray, q_new: FloatArray, *, sigma_mm: float | None, points: int
) -> bool:
    """Test one further pair against the fit of n others.

    Its deviation from their prediction has the covariance σ² (I + J M⁻¹ Jᵀ); its normalised square is χ² with three
    degrees of freedom, or 3 F(3, 3 n - 6) with σ from the residuals. The false alarm is shared among `points` tests.
    """
    n = len(p)
    R, t = kabsch(p, q, np.full(n, 1.0 / n))
    deviation = q_new - R @ p_new - t
    moved = p @ R.T + t
    centre = moved.mean(axis=0)
    J, new = point_jacobian(moved - centre), point_jacobian((q_new - deviation - centre)[None])[0]
    spread = np.eye(3) + new @ np.linalg.pinv(np.einsum("nik,nil->kl", J, J)) @ new.T
    square = float(deviation @ np.linalg.solve(spread, deviation))
    freedom = 3 * n - 6
    level = FALSE_ALARM / points
    if sigma_mm is not None:
        limit = float(chdtri(3, level)) * sigma_mm**2
    elif freedom > 0:
        residual = float(np.sum(distances(p, q, R, t) ** 2)) / freedom
        limit = 3.0 * float(fdtri(3, freedom, 1.0 - level)) * residual
    else:
        limit = inf
    return square > max(limit, FLOOR_MM**2)


def _stands_out(p: FloatArray, q: FloatArray, keep: BoolArray) -> bool:
    """Tell whether one triple of four points agrees far better than the other three: then the fourth is wrong."""
    sums = []
    for left_out in range(len(p)):
        rows = np.arange(len(p)) != left_out
        R, t = kabsch(p[rows], q[rows], np.full(rows.sum(), 1.0 / rows.sum()))
        sums.append(float(np.sum(distances(p[rows], q[rows], R, t) ** 2)))
    first, second = np.sort(sums)[:2]
    # Two sums of three squares each: the ratio that good points exceed with the probability of a false alarm.
    return bool(second > max(float(fdtri(3, 3, 1.0 - FALSE_ALARM / len(p))) * first, FLOOR_MM**2))


def _trimmed_set(p: FloatArray, q: FloatArray, seed: int) -> IntArray:
    """The points of the least trimmed sum of squares; a bare majority, at least three."""
    n = len(p)
    size = max(3, (n + 4) // 2) if n > 4 else 3
    triples = _triples(n, seed)
    R, t = kabsch(p[triples], q[triples], np.full(triples.shape, 1.0 / 3.0))
    rows = np.empty((len(triples), size), dtype=np.int64)
    before = np.full(len(triples), np.inf)
    for _ in range(CONCENTRATION_STEPS):
        d = distances(p, q, R, t)
        rows = np.argpartition(d, size - 1, axis=1)[:, :size]
        sums = np.sum(np.take_along_axis(d, rows, axis=1) ** 2, axis=1)
        if np.array_equal(sums, before):
            break
        R, t = kabsch(p[rows], q[rows], np.full(rows.shape, 1.0 / size))
        before = sums
    return np.asarray(rows[int(np.argmin(before))])


def _triples(n: int, seed: int) -> IntArray:
    if comb(n, 3) <= MOST_TRIPLES:
        return np.array(list(combinations(range(n), 3)))
    rng = np.random.default_rng(seed)
    return np.stack([rng.choice(n, 3, replace=False) for _ in range(MOST_TRIPLES)])
