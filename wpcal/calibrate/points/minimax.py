r"""The rigid transform with the least largest distance, and the proof that no other is better.

The problem is Yin 2003, eq. (4) and (5). For weights on the simplex :math:`\min_T (\sum_i w_i d_i^2)^{1/2}` is a lower
bound over all rotations, with a closed form (`least_squares.weighted_rms_bound`). The multipliers of a local optimum
are such weights. If their bound equals the largest distance, the local optimum is the global one.

Clouds of many points are solved on an active subset: at most seven multipliers of an optimum are needed, so a few
points carry it, and the bound of a subset is a bound of the whole.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wpcal.calibrate.points.active_set import refine_optimum
from wpcal.calibrate.points.branch_and_bound import search_rotations
from wpcal.calibrate.points.interior_point import InteriorPointState, solve_interior_point
from wpcal.calibrate.points.least_squares import distances, kabsch, require_spread, weighted_rms
from wpcal.calibrate.points.tie_break import break_ties
from wpcal.core.arrays import FloatArray, IntArray, frozen
from wpcal.core.pairs import PointPairs
from wpcal.core.rotations import cube_rotations, spread_rotations
from wpcal.core.transform import RigidTransform

CERTIFIED_MM = 1e-6
"""Gap at which an answer counts as proved: a thousandth of the finest reading of a controller."""

SUBSET = 64
"""Clouds up to this size are solved whole; larger ones start from this many points."""

ADDED = 24
"""Points added to the subset per round: the most violated ones."""

SUBSET_ROUNDS = 200
"""A bound on the rounds. Each takes in violated points, so the value rises; 5 to 10 are usual."""

STARTS = 192
"""Rotations from which a set of up to 8 points is solved where nothing is proved. With 24 one swapped or
mirrored set of 50 had a better fit. Larger sets get fewer, because a solve costs as much as its points."""

LEAST_STARTS = 96
"""Rotations from which a set of any size is solved."""

MOST_ENDS = 24
"""Ends of the searches that are compared; symmetric sets have as many equal ones as symmetries."""

SAME_ROTATION = 1e-6
"""Ends whose rotation matrices differ by less are one."""

TIED = 1e-11
"""Values that differ by less than this share of the value and the cloud's size are equal."""

SAME_SUM = 1e-9
"""Sums of squares that differ by less than this share are equal."""

ASCENT_STEPS = 300
"""Steps of the ascent that raises the bound if local multipliers prove nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class MinimaxSolution:
    """The best fit found and what is proved about it.

    Parameters
    ----------
    T : RigidTransform
        ``T_target_source``.
    objective_mm : float
        Its largest distance.
    lower_bound_mm : float
        No rigid transform has a smaller largest distance.
    weights : ndarray, shape (n,)
        The multipliers that prove the bound.
    starts : int
        Local solves from different rotations.
    """

    T: RigidTransform
    objective_mm: float
    lower_bound_mm: float
    weights: FloatArray
    starts: int

    @property
    def gap_mm(self) -> float:
        """Objective minus bound, mm; not negative beyond round-off."""
        return max(self.objective_mm - self.lower_bound_mm, 0.0)

    @property
    def certified(self) -> bool:
        """Whether the bound proves the answer globally best."""
        return self.gap_mm <= CERTIFIED_MM


def solve_minimax(pairs: PointPairs, *, start: RigidTransform | None = None, certify: bool = False) -> MinimaxSolution:
    """Find the rigid transform with the least largest distance, with a certificate.

    Parameters
    ----------
    pairs : PointPairs
        At least three pairs that are not collinear, mm.
    start : RigidTransform, optional
        Where to start; the least-squares fit where not given. Where the local optimum is not certified, the search
        goes on from 24 rotations around it and from up to 192 others.

    Returns
    -------
    MinimaxSolution

    Raises
    ------
    GeometryError
        When there are fewer than three pairs or they are collinear or coincident.

    Notes
    -----
    Where several fits have the least largest distance, the one of least sum of squares is returned (`tie_break`).
    One iteration on a subset of m points costs a 7×7 solve and O(m); one round on the cloud costs O(n).
    """
    require_spread(pairs)
    cloud = _Cloud.of(pairs)
    uniform = np.full(len(pairs), 1.0 / len(pairs))
    R, t = kabsch(cloud.p, cloud.q, uniform) if start is None else cloud.inside(start)
    found = cloud.solve(R, t)
    if found.gap > CERTIFIED_MM:
        found = cloud.solve_from_many(found)
    if found.gap > CERTIFIED_MM and certify:
        found = cloud.search_all(found)
    found = cloud.without_ties(found)
    return MinimaxSolution(
        cloud.outside(found.R, found.t, pairs), found.value, found.bound, frozen(found.weights), found.starts
    )


def core_subset(p: FloatArray, q: FloatArray, size: int = SUBSET) -> IntArray:
    """Choose the points that decide the least largest distance.

    Half of them are far out (they hold the rotation). The other half have the largest residuals of the least-squares
    fit.

    Parameters
    ----------
    p, q : ndarray, shape (n, 3)
        Source and target points, mm.
    size : int
        About how many to choose; all are taken if there are not more.

    Returns
    -------
    ndarray of int
        Indices of the chosen points.
    """
    n = len(p)
    if n <= size:
        return np.arange(n)
    R, t = kabsch(p, q, np.full(n, 1.0 / n))
    d = distances(p, q, R, t)
    offsets = p - p.mean(axis=0)
    half = size // 2
    far = np.argpartition(-np.einsum("ij,ij->i", offsets, offsets), half)[:half]
    return np.unique(np.concatenate([far, np.argpartition(-d, half)[:half]]))


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    R: FloatArray
    t: FloatArray
    weights: FloatArray
    value: float
    bound: float
    starts: int = 1

    @property
    def gap(self) -> float:
        return self.value - self.bound


@dataclass(frozen=True, slots=True, eq=False)
class _Cloud:
    """Pairs about their centroids, so that round-off follows the size of the cloud."""

    p: FloatArray
    q: FloatArray
    p_mean: FloatArray
    q_mean: FloatArray

    @classmethod
    def of(cls, pairs: PointPairs) -> _Cloud:
        p_mean, q_mean = pairs.p_source.mean(axis=0), pairs.p_target.mean(axis=0)
        return cls(pairs.p_source - p_mean, pairs.p_target - q_mean, p_mean, q_mean)

    def inside(self, T: RigidTransform) -> tuple[FloatArray, FloatArray]:
        return T.R, np.asarray(T.apply(self.p_mean) - self.q_mean)

    def outside(self, R: FloatArray, t: FloatArray, pairs: PointPairs) -> RigidTransform:
        return RigidTransform(R, t + self.q_mean - R @ self.p_mean, pairs.target, pairs.source)

    def solve(self, R: FloatArray, t: FloatArray) -> _Found:
        """Local optimum from one start, on a growing subset."""
        rows = core_subset(self.p, self.q)
        for _ in range(SUBSET_ROUNDS):
            p, q = self.p[rows], self.q[rows]
            local = _solve_batch(p, q, R[None], t[None])
            R, t, weights = local.R[0], local.t[0], local.weights[0]
            d = distances(self.p, self.q, R, t)
            inside = float(d[rows].max())
            worst = np.argpartition(-d, min(ADDED, len(d) - 1))[:ADDED]
            new = worst[d[worst] > inside * (1.0 + 1e-12)]
            if not len(new) or len(rows) == len(d):
                break
            rows = np.union1d(rows, new)
        whole = np.zeros(len(self.p))
        whole[rows] = weights
        return _Found(R, t, whole, float(d.max()), float(weighted_rms(p, q, weights)))

    def without_ties(self, found: _Found) -> _Found:
        """Take the fit of least sum of squares among those with the same largest distance."""
        exact = refine_optimum(self.p, self.q, found.R, found.t, found.weights)
        if exact is None:
            return found
        R, t = break_ties(self.p[None], self.q[None], exact.R[None], exact.t[None], exact.weights[None])
        value = float(distances(self.p, self.q, R[0], t[0]).max())
        bound = float(weighted_rms(self.p, self.q, exact.weights))
        if bound < found.bound:
            return replace(found, R=R[0], t=t[0], value=value)
        return replace(found, R=R[0], t=t[0], value=value, weights=exact.weights, bound=bound)

    def solve_from_many(self, first: _Found) -> _Found:
        """Solve from 24 rotations about the first answer and from `STARTS` spread evenly; raise the bound by ascent."""
        rows = np.union1d(core_subset(self.p, self.q), np.flatnonzero(first.weights > 0))
        p, q = self.p[rows], self.q[rows]
        spread = spread_rotations(max(LEAST_STARTS, STARTS * 8 // max(len(rows), 8)))
        turns = np.concatenate([cube_rotations() @ first.R, spread])
        local = _solve_batch(p, q, turns, np.broadcast_to(first.t, (len(turns), 3)))
        best = self._best_of(first, local)
        seeds = np.vstack([first.weights[rows], best.weights[rows], local.weights])
        seeds /= seeds.sum(axis=1, keepdims=True)
        weights, bound = raise_bound(p, q, seeds)
        whole = np.zeros(len(self.p))
        whole[rows] = weights
        if bound < best.bound:
            whole, bound = best.weights, best.bound
        return replace(best, weights=whole, bound=bound, starts=1 + len(turns))

    def _best_of(self, first: _Found, local: InteriorPointState) -> _Found:
        """Of all answers the one of least largest distance; of equal ones that of least squares, then least turn.

        Which of them the search met first depends on where it began.
        """
        found = [first]
        for i in np.argsort(local.largest, kind="stable")[:MOST_ENDS]:
            if local.largest[i] > local.largest.min() + CERTIFIED_MM * 10:
                break
            if all(np.abs(local.R[i] - other.R).max() > SAME_ROTATION for other in found):
                found.append(self.solve(local.R[i], local.t[i]))
        least = min(f.value for f in found)
        equal = [self.without_ties(f) for f in found if f.value <= least + TIED * (least + self.size)]
        sums = [float(np.sum(distances(self.p, self.q, f.R, f.t) ** 2)) for f in equal]
        near = [f for f, total in zip(equal, sums, strict=True) if total <= min(sums) * (1.0 + SAME_SUM)]
        return max(near, key=lambda f: tuple(np.concatenate([[np.trace(f.R)], f.R.ravel()]).round(6)))

    @property
    def size(self) -> float:
        """Root mean square distance of the source points from their centroid, mm."""
        return float(np.sqrt(np.mean(np.sum(self.p**2, axis=1))))

    def search_all(self, best: _Found) -> _Found:
        """Branch and bound on the points that carry the answer; every better answer it meets restarts it."""
        while True:
            d = distances(self.p, self.q, best.R, best.t)
            rows = np.argsort(-d, kind="stable")[:SUBSET]
            p, q = self.p[rows], self.q[rows]
            local = _solve_batch(p, q, cube_rotations() @ best.R, np.broadcast_to(best.t, (24, 3)))
            pool = np.vstack([self._on(rows, best.weights), local.weights, np.full(len(rows), 1.0 / len(rows))])
            _, first = np.unique(pool.round(6), axis=0, return_index=True)
            found = search_rotations(p, q, value=best.value, tolerance=CERTIFIED_MM / 2, pool=pool[np.sort(first)])
            starts = found.rotations[:SUBSET]
            better = [f for R in starts if (f := self.solve(R, np.zeros(3))).value < best.value - CERTIFIED_MM / 4]
            bound, tried = max(best.bound, found.lower_bound), best.starts + len(starts)
            if not better:
                return replace(best, bound=bound, starts=tried)
            best = replace(min(better, key=lambda f: f.value), bound=bound, starts=tried)

    @staticmethod
    def _on(rows: IntArray, weights: FloatArray) -> FloatArray:
        chosen = weights[rows] + 1e-12  # all weight may lie on other points
        return np.asarray(chosen / chosen.sum())


def raise_bound(p: FloatArray, q: FloatArray, seeds: FloatArray) -> tuple[FloatArray, float]:
    """Raise the weighted root mean square bound by exponentiated ascent on the simplex.

    The bound's square is concave in the weights with the squared distances as its slope, so steps that shrink as
    1/√k approach its greatest value, also where it has a kink.

    Parameters
    ----------
    p, q : ndarray, shape (n, 3)
        Points about their centroids, mm.
    seeds : ndarray, shape (m, n)
        Weights to start from, rows on the simplex.

    Returns
    -------
    weights : ndarray, shape (n,)
    bound : float
        mm.
    """
    n = len(p)
    bounds = weighted_rms(p, q, seeds)
    best = int(np.argmax(bounds))
    best_weights, best_bound = seeds[best], float(bounds[best])
    w = 0.9 * best_weights + 0.1 / n  # a weight of zero could never grow
    for k in range(1, ASCENT_STEPS + 1):
        R, t = kabsch(p, q, w)
        squares = distances(p, q, R, t) ** 2
        bound = float(np.sqrt(w @ squares))
        if bound > best_bound:
            best_weights, best_bound = w, bound
        w = w * np.exp(squares / squares.max() / np.sqrt(k))
        w = w / w.sum()
    return best_weights, best_bound


def _solve_batch(p: FloatArray, q: FloatArray, R: FloatArray, t: FloatArray) -> InteriorPointState:
    """Solve one cloud from several starts."""
    shape = (len(R), *p.shape)
    return solve_interior_point(np.broadcast_to(p, shape), np.broadcast_to(q, shape), R, t)
