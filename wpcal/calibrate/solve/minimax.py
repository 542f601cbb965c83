r"""The rigid transform with the least largest distance, and the proof that no other is better.

The problem is Yin 2003, eq. (4) and (5). For weights on the simplex :math:`\min_T (\sum_i w_i d_i^2)^{1/2}` is a lower
bound over all rotations, with a closed form (`least_squares.weighted_rms`). The multipliers of a local optimum
are such weights. If their bound equals the largest distance, the local optimum is the global one.

Clouds of many points are solved on an active subset: at most seven multipliers of an optimum are needed, so a few
points carry it, and the bound of a subset is a bound of the whole.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wpcal.calibrate.solve.active_set import refine_optimum
from wpcal.calibrate.solve.branch_and_bound import search_rotations
from wpcal.calibrate.solve.dual_bound import raise_bound
from wpcal.calibrate.solve.free_turns import free_axes, least_squares_among_best, on_line
from wpcal.calibrate.solve.interior_point import InteriorPointState, solve_interior_point
from wpcal.calibrate.solve.least_squares import distances, kabsch, require_spread, weighted_rms
from wpcal.calibrate.solve.ties import break_ties, distinct_fits, nearest_fit, with_copies
from wpcal.core.arrays import FloatArray, IntArray, frozen
from wpcal.core.pairs import PointPairs
from wpcal.core.rotations import cube_rotations, spread_rotations
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform

CERTIFIED_MM = 1e-6  #: Gap at which an answer counts as proved: a thousandth of the finest reading of a controller.
SUBSET = 64  #: Clouds up to this size are solved whole; larger ones start from this many points.
ADDED = 24  #: Points added to the subset per round: the most violated ones.
SUBSET_ROUNDS = 200  #: A bound on the rounds. Each takes in violated points, so the value rises; 5 to 10 are usual.
STARTS = 192
"""Rotations from which a set of up to 8 points is solved where nothing is proved. With 24 one swapped or
mirrored set of 50 had a better fit. Larger sets get fewer, because a solve costs as much as its points."""
LEAST_STARTS = 96  #: Rotations from which a set of any size is solved.
MOST_ENDS = 48
"""Ends of the searches that are compared. Copies by symmetry are computed, so that one of each kind is enough."""
TWISTS = 24
"""Turns of the first answer about the longest axis of the points. Noise hides the turn of points nearly on a line,
which then has many valleys."""
EXACT = 1e-12
"""A largest distance below this share of the size of the points is round-off: the fit is exact and the only one."""
TIED = 1e-11  #: Values that differ by less than this share of the value and the cloud's size are equal.
SAME_VALLEY = 1e-4  #: Ends whose rotation matrices differ by less lie in one flat valley: the lowest is the answer.
TIED_EXACT = 1e-13  #: The same for fits that satisfy the optimality conditions to round-off.
SAME_SUM = 1e-9  #: Sums of squares that differ by less than this share are equal.


@dataclass(frozen=True, slots=True, eq=False)
class MinimaxSolution:
    """The best fit found and what is proved about it."""

    T: RigidTransform  #: ``T_target_source``.
    objective_mm: float  #: Its largest distance.
    lower_bound_mm: float  #: No rigid transform has a smaller largest distance.
    weights: FloatArray  #: shape (n,). The multipliers that prove the bound.
    starts: int  #: Local solves from different rotations.
    #: Other fits with the same largest distance and the same sum of squares. The points do not prefer `T` to them.
    equal: tuple[RigidTransform, ...] = ()

    @property
    def gap_mm(self) -> float:
        """Objective minus bound, mm; not negative beyond round-off."""
        return max(self.objective_mm - self.lower_bound_mm, 0.0)

    @property
    def certified(self) -> bool:
        """Whether the bound proves the answer globally best."""
        return self.gap_mm <= CERTIFIED_MM


def solve_minimax(
    pairs: PointPairs,
    *,
    start: RigidTransform | None = None,
    certify: bool = False,
    nominal: RigidTransform | None = None,
) -> MinimaxSolution:
    """Find the rigid transform with the least largest distance, with a certificate.

    Raises `GeometryError` when there are fewer than three pairs or they are collinear or coincident.

    `pairs`: At least three pairs that are not collinear, mm.
    `start`: Where to start; the least-squares fit where not given. Where the local optimum is not certified, the search
    goes on from 24 rotations around it and from up to 192 others.

    Note: Where several fits have the least largest distance, the one of least sum of squares is returned (`tie_break`).
    Where several of these are equal as well, `equal_fits` chooses one and the others are listed.
    One iteration on a subset of m points costs a 7×7 solve and O(m); one round on the cloud costs O(n).
    """
    require_spread(pairs)
    cloud = _Cloud.of(pairs)
    uniform = np.full(len(pairs), 1.0 / len(pairs))
    R, t = kabsch(cloud.p, cloud.q, uniform) if start is None else cloud.inside(start)
    found = cloud.solve(R, t)
    equal = [found]
    if found.gap > CERTIFIED_MM or cloud.may_have_equals(found):
        equal = cloud.solve_from_many(found)
    if equal[0].gap > CERTIFIED_MM and certify:
        better = cloud.search_all(equal[0])
        is_new = better.value < equal[0].value
        equal = [better] if is_new else [replace(each, bound=better.bound, starts=better.starts) for each in equal]
    best, others = cloud.chosen(equal, np.eye(3) if nominal is None else nominal.R)
    return MinimaxSolution(
        cloud.outside(best.R, best.t, pairs),
        best.value,
        best.bound,
        frozen(best.weights),
        best.starts,
        tuple(cloud.outside(R, t, pairs) for R, t in others),
    )


def core_subset(p: FloatArray, q: FloatArray) -> IntArray:
    """Choose the points that decide the least largest distance. Indices of the chosen points.

    Half of them are far out (they hold the rotation). The other half have the largest residuals of the least-squares
    fit.

    `p`, `q`: shape (n, 3). Source and target points, mm.
    """
    n = len(p)
    if n <= SUBSET:
        return np.arange(n)
    R, t = kabsch(p, q, np.full(n, 1.0 / n))
    d = distances(p, q, R, t)
    offsets = p - p.mean(axis=0)
    half = SUBSET // 2
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
    is_exact: bool = False
    """Whether the optimality conditions hold to round-off."""

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
        freed = least_squares_among_best(self.p, self.q, exact.R, exact.weights)
        if freed is None:
            R, t = break_ties(self.p[None], self.q[None], exact.R[None], exact.t[None], exact.weights[None])
        else:
            R, t = freed[0][None], freed[1][None]
        value = float(distances(self.p, self.q, R[0], t[0]).max())
        bound = float(weighted_rms(self.p, self.q, exact.weights))
        if bound < found.bound:
            return replace(found, R=R[0], t=t[0], value=value, is_exact=True)
        return replace(found, R=R[0], t=t[0], value=value, weights=exact.weights, bound=bound, is_exact=True)

    def may_have_equals(self, found: _Found) -> bool:
        """Whether a proved fit may have equals: other rotations fit the carrying points as well.

        If only a turn about the line of the carrying points is free, `without_ties` knows all of them.
        """
        if found.value <= EXACT * self.size:
            return False
        exact = refine_optimum(self.p, self.q, found.R, found.t, found.weights)
        w = found.weights if exact is None else exact.weights
        axes = free_axes(self.p, self.q, found.R if exact is None else exact.R, w).shape[1]
        return axes > 1 or (axes == 1 and not on_line(self.p, w))

    def solve_from_many(self, first: _Found) -> list[_Found]:
        """Solve from rotations about the first answer and from `STARTS` spread evenly; raise the bound by ascent.

        Returns: The fits of least largest distance, all with the bound.
        """
        rows = np.union1d(core_subset(self.p, self.q), np.flatnonzero(first.weights > 0))
        p, q = self.p[rows], self.q[rows]
        spread = spread_rotations(max(LEAST_STARTS, STARTS * 8 // max(len(rows), 8)))
        axis = np.linalg.svd(p - p.mean(axis=0), full_matrices=False)[2][0]
        twists = first.R @ exp_rotation(np.linspace(0.0, 2.0 * np.pi, TWISTS, endpoint=False)[1:, None] * axis)
        turns = np.concatenate([cube_rotations() @ first.R, twists, spread])
        local = _solve_batch(p, q, turns, np.broadcast_to(first.t, (len(turns), 3)))
        equal = self._best_of(first, local)
        best, starts = equal[0], 1 + len(turns)
        if best.gap <= CERTIFIED_MM:
            return [replace(each, starts=starts) for each in equal]
        seeds = np.vstack([first.weights[rows], best.weights[rows], local.weights])
        seeds /= seeds.sum(axis=1, keepdims=True)
        weights, bound = raise_bound(p, q, seeds)
        if bound < best.bound:
            return [replace(each, starts=starts) for each in equal]
        whole = np.zeros(len(self.p))
        whole[rows] = weights
        return [replace(each, weights=whole, bound=bound, starts=starts) for each in equal]

    def _best_of(self, first: _Found, local: InteriorPointState) -> list[_Found]:
        """Return the answers of least largest distance, the best proved first."""
        near = np.argsort(local.largest, kind="stable")
        near = near[local.largest[near] <= local.largest.min() + CERTIFIED_MM * 10]
        near = near[distinct_fits(local.R[near])][:MOST_ENDS]
        if len(self.p) == local.weights.shape[1]:
            bounds = weighted_rms(self.p, self.q, local.weights[near])
            ends = [
                _Found(local.R[i], local.t[i], local.weights[i], float(local.largest[i]), float(bound))
                for i, bound in zip(near, bounds, strict=True)
            ]
        else:
            ends = [self.solve(local.R[i], local.t[i]) for i in near]
        found = [first, *ends]
        exact = [self.without_ties(each) for each in found if each.value <= min(f.value for f in found) + CERTIFIED_MM]
        unit = min(f.value for f in exact) + self.size
        equal = [f for f in exact if f.value + self.size <= unit * (1.0 + TIED)]
        if any(f.is_exact for f in equal):
            equal = [f for f in equal if f.is_exact]
            least = min(f.value for f in equal)
            equal = sorted((f for f in equal if f.value <= least + TIED_EXACT * unit), key=lambda f: f.value)
            equal = [equal[i] for i in distinct_fits(np.array([f.R for f in equal]), same=SAME_VALLEY)]
        return sorted(equal, key=lambda f: -f.bound)

    def chosen(self, equal: list[_Found], towards: FloatArray) -> tuple[_Found, list[tuple[FloatArray, FloatArray]]]:
        """Of equally good fits and their copies by symmetry, choose one of least sum of squares; return the others."""
        if len(equal) == 1:
            equal = [self.without_ties(equal[0])]
        R, t = np.array([f.R for f in equal]), np.array([f.t for f in equal])
        if len(self.p) <= SUBSET and equal[0].value > EXACT * self.size:
            R, t = with_copies(self.p, self.q, R, t)
        d = distances(self.p, self.q, R, t)
        sums = np.sum(d**2, axis=1)
        near = np.flatnonzero(sums <= sums.min() * (1.0 + SAME_SUM))
        row = near[nearest_fit(R[near], towards)]
        others = [(R[k], t[k]) for k in near if k != row]
        return replace(equal[0], R=R[row], t=t[row], value=float(d[row].max())), others

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


def _solve_batch(p: FloatArray, q: FloatArray, R: FloatArray, t: FloatArray) -> InteriorPointState:
    """Solve one cloud from several starts."""
    shape = (len(R), *p.shape)
    return solve_interior_point(np.broadcast_to(p, shape), np.broadcast_to(q, shape), R, t)
