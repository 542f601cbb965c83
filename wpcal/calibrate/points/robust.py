"""A fit that is insensitive to mis-taught points, and the test that names such a point.

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

from wpcal.calibrate.outlier_limits import FALSE_ALARM, FLOOR_MM, LEAST_SIGMA_MM
from wpcal.calibrate.points.least_squares import (
    COLLINEAR_RATIO,
    centred,
    distances,
    fit_least_squares,
    kabsch,
    require_spread,
)
from wpcal.calibrate.points.weighted import refine_once
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
"""Each step keeps the nearest points and fits again. The sum stops falling after a few steps."""

ISOTROPIC = 1e-12
"""A covariance counts as isotropic if it differs from a multiple of the identity by less than this (relative)."""


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


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """Pairs about their centroids with what is known of their errors.

    Parameters
    ----------
    p, q : ndarray, shape (n, 3)
    covariances, information : ndarray, shape (n, 3, 3)
        Of the taught points, and inverse, mm² and mm⁻². If nothing is known, multiples of the identity of unit size.
    weights : ndarray, shape (n,)
        One third of the traces of the information: the part of it that a closed-form fit can use.
    scaled : bool
        Whether the covariances are known with their size.
    isotropic : bool
        Whether they are multiples of the identity, so that the closed form is exact.
    """

    p: FloatArray
    q: FloatArray
    covariances: FloatArray
    information: FloatArray
    weights: FloatArray
    scaled: bool
    isotropic: bool

    @classmethod
    def of(cls, pairs: PointPairs, sigma_mm: float | None) -> _Rows:
        unit = 1.0 if sigma_mm is None else max(sigma_mm, LEAST_SIGMA_MM)
        covariances = pairs.covariances
        scaled = covariances is not None or sigma_mm is not None
        if covariances is None:
            covariances = np.tile(unit**2 * np.eye(3), (len(pairs), 1, 1))
        information = np.asarray(np.linalg.inv(covariances))
        weights = np.trace(information, axis1=1, axis2=2) / 3.0
        isotropic = bool(
            np.allclose(information, weights[:, None, None] * np.eye(3), rtol=0, atol=ISOTROPIC * weights.max())
        )
        return cls(
            centred(pairs.p_source), centred(pairs.p_target), covariances, information, weights, scaled, isotropic
        )

    def __len__(self) -> int:
        return len(self.p)

    def select(self, rows: IntArray | BoolArray) -> _Rows:
        """Return the rows at indices or under a mask; any shape of indices makes a batch."""
        covariances, information = self.covariances[rows], self.information[rows]
        return _Rows(
            self.p[rows], self.q[rows], covariances, information, self.weights[rows], self.scaled, self.isotropic
        )

    def fit(self) -> tuple[FloatArray, FloatArray]:
        """Fit in closed form with the weights. Anisotropic covariances take one Gauss-Newton step more."""
        R, t = kabsch(self.p, self.q, self.weights / self.weights.sum(axis=-1, keepdims=True))
        if self.isotropic:
            return R, t
        R, t, _ = refine_once(self.p, self.q, self.information, R, t)
        return R, t

    def squares(self, R: FloatArray, t: FloatArray) -> FloatArray:
        """Squared residuals rᵀ Λ r of a fit."""
        r = self.q - self.p @ np.swapaxes(R, -1, -2) - t[..., None, :]
        return np.asarray(np.einsum("...ni,...nij,...nj->...n", r, self.information, r))


def fit_robust(pairs: PointPairs, *, sigma_mm: float | None = None, seed: int = 0) -> RobustSolution:
    """Fit with least squares on the points that agree.

    Parameters
    ----------
    pairs : PointPairs
        At least three, mm. Covariances, if present, say how far each point may be off.
    sigma_mm : float, optional
        Teaching error per axis of pairs without covariances. By default estimated from the points that agree.
    seed : int
        Of the random triples of more than 16 points.

    Returns
    -------
    RobustSolution
        With three points, or if no test separates a point, this is the least-squares fit of all points.

    Raises
    ------
    GeometryError
        When the points do not fix a rotation.

    Notes
    -----
    With four corners of a plate it cannot be decided which is off the plane: every three of them fit. See
    `diagnose.find_issues`.
    """
    require_spread(pairs)
    everything = np.ones(len(pairs), dtype=bool)
    keep = everything if len(pairs) < 4 else _consistent(_Rows.of(pairs, sigma_mm), seed)
    if not _has_spread(pairs.p_source[keep]):
        keep = everything
    T = fit_least_squares(pairs.select(np.flatnonzero(keep)))
    return RobustSolution(T, keep, distances(pairs.p_source, pairs.p_target, T.R, T.t_mm))


def _has_spread(points: FloatArray) -> bool:
    """Tell whether points fix a rotation; a row of points with the one beside it left out does not."""
    values = np.linalg.svd(centred(points), compute_uv=False)
    return bool(values[1] > COLLINEAR_RATIO * values[0])


def _consistent(rows: _Rows, seed: int) -> BoolArray:
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
    if np.count_nonzero(~keep) == 1 and not _stands_out(rows):
        return np.ones(n, dtype=bool)
    return keep


def _consistent_cloud(rows: _Rows, seed: int) -> BoolArray:
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


def _is_blunder(inside: _Rows, new: _Rows, *, points: int) -> bool:
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


def _stands_out(rows: _Rows) -> bool:
    """Tell whether the points agree without one of them and with every other one left out they do not.

    Four corners of a plate fail this: one off the plane leaves any three of them fitting well.
    """
    n = len(rows)
    others = rows.select(np.array([[i for i in range(n) if i != left_out] for left_out in range(n)]))
    sums = others.squares(*others.fit()).sum(axis=1)
    first, second = np.partition(sums, 1)[:2]
    freedom, level = 3 * (n - 1) - 6, FALSE_ALARM / n
    limit = chdtri(freedom, level) if rows.scaled else fdtri(freedom, freedom, 1.0 - level) * first
    return bool(second > max(float(limit), float(rows.weights.min()) * FLOOR_MM**2))


def _trimmed_set(rows: _Rows, seed: int) -> IntArray:
    """The points of the least trimmed sum of squares; a bare majority, at least three."""
    n = len(rows)
    size = max(3, (n + 4) // 2) if n > 4 else 3
    R, t = rows.select(_triples(n, seed)).fit()
    kept = np.empty((len(R), size), dtype=np.int64)
    before = np.full(len(R), np.inf)
    for _ in range(CONCENTRATION_STEPS):
        squares = rows.squares(R, t)
        kept = np.argpartition(squares, size - 1, axis=1)[:, :size]
        sums = np.sum(np.take_along_axis(squares, kept, axis=1), axis=1)
        if np.array_equal(sums, before):
            break
        R, t = rows.select(kept).fit()
        before = sums
    return np.asarray(kept[int(np.argmin(before))])


def _triples(n: int, seed: int) -> IntArray:
    if comb(n, 3) <= MOST_TRIPLES:
        return np.array(list(combinations(range(n), 3)))
    rng = np.random.default_rng(seed)
    return np.stack([rng.choice(n, 3, replace=False) for _ in range(MOST_TRIPLES)])
