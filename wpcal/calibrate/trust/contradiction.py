r"""Which touches do the others contradict? One touch or a pair is left out in turn, and the fits are compared.

With a the residuals of the fit in units of their errors and :math:`Q = I - H` the matrix that leaves of an error what
the residuals show of it beside the pose and errors that all touches share, leaving out the numbers K of one or two
touches lowers the sum of squares by :math:`a_K^\top Q_{KK}^{-1} a_K`. That is exact while nothing turns; the best sets
are therefore fitted again. The drop is :math:`\chi^2` with as many degrees of freedom as the touches gave numbers, or F
if no error is stated. The level is divided by the number of sets (Bonferroni), and a set is the answer only if the rest
agrees.

References
----------
Baarda (1968), A testing procedure for use in geodetic networks. Cook, Weisberg (1982), chapter 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import comb, log

import numpy as np
from scipy.special import chdtrc, fdtrc

from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.solve.touches import Pose, fit_squares, fit_squares_of, scaled_jacobian
from wpcal.calibrate.trust.blame import Suspect
from wpcal.calibrate.trust.criteria import BLUNDER, NOT_NAMED
from wpcal.calibrate.trust.residuals import FALSE_ALARM, FLOOR_MM, LEAST_SIGMA_MM, NAMED_PROBABILITY
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.issue import Issue

MOST_TRIED = 60
"""Touches and pairs are tried among this many touches, those with the largest residuals: 1770 pairs."""
FITTED_AGAIN = 12  #: Best sets that are fitted again: the sums of the others are those of the linear formula.
HELD = 1e-3
"""If a motion is free without touches (below this share of the largest singular value), the others cannot judge."""
LEAST_SHOWN = 1e-6  #: Share of an error that must show in the residuals: less is round-off.
SINGLE_SHARE, PAIR_SHARE = 0.8, 0.3
"""Shares of the false alarms for single touches and for pairs, together one fit of a hundred."""
REST_SHARE = 0.4  #: Share of the false alarms for the second test, of the touches that remain.


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """Residuals of the least-squares fit of all touches in units of their errors, one row per observed number."""

    touches: Touches
    pose: Pose
    is_scaled: bool
    unit: float
    a: FloatArray
    U: FloatArray
    owner: IntArray
    J: FloatArray

    @classmethod
    def of(cls, touches: Touches, start: Pose, sigma_mm: float | None) -> _Rows:
        stated, shared = touches.covariances is not None, touches.shared
        unit = 1.0 if stated or sigma_mm is None else max(sigma_mm, LEAST_SIGMA_MM)
        own = touches
        if touches.covariances is not None and shared is not None:
            own = replace(touches, covariances=touches.covariances - shared @ shared.swapaxes(1, 2))
        pose, information, jacobians = squares_of(own, start, sigma_mm)
        values, vectors = np.linalg.eigh(information)
        owner, axis = np.nonzero(values > 1e-9 * values.max(axis=1, keepdims=True))
        root = np.sqrt(values[owner, axis])[:, None] * vectors[owner, :, axis]
        J = np.einsum("mi,mik->mk", root, jacobians[owner])
        common = J if shared is None else np.column_stack([J, np.einsum("mi,mik->mk", root, shared[owner])])
        U, S, _ = np.linalg.svd(common / np.maximum(np.linalg.norm(common, axis=0), 1e-300), full_matrices=False)
        U = U[:, HELD * S[0] < S]
        a = np.einsum("mi,mi->m", root, pose.at.d[owner])
        a = a if shared is None else a - U @ (U.T @ a)
        return cls(touches, pose, stated or sigma_mm is not None, unit, a, U, owner, J)

    @property
    def total(self) -> float:
        return float(self.a @ self.a)

    @property
    def freedom(self) -> int:
        return len(self.a) - max(int(self.U.shape[1]), 6)

    def floor(self, freedom: int) -> float:
        """Sum of squares that a controller's last digit alone leaves."""
        return max(freedom, 1) * (FLOOR_MM / self.unit) ** 2 if self.touches.covariances is None else 0.0

    def without(self, left_out: Sequence[int]) -> tuple[float, int]:
        """Return by how much the sum of squares falls without touches, and how many numbers go; 0, 0 if not held."""
        K = np.flatnonzero(np.isin(self.owner, left_out))
        block = np.eye(len(K)) - self.U[K] @ self.U[K].T
        shown = float(np.linalg.eigvalsh(block)[0])
        if self.freedom - len(K) < 1 or shown < LEAST_SHOWN:
            return 0.0, 0
        held = np.linalg.eigvalsh(self.J.T @ self.J - self.J[K].T @ self.J[K])
        if held[0] <= HELD**2 * held[-1]:
            return 0.0, 0
        return float(self.a[K] @ np.linalg.solve(block, self.a[K])), len(K)

    def totals_without(self, sets: Sequence[Sequence[int]]) -> list[float]:
        """Fit again without each of some sets of touches, all fits at once; return the sums of squares."""
        if not sets or self.touches.shared is not None:  # the fit has no unknowns for errors that all touches share
            return [max(self.total - self.without(left_out)[0], 0.0) for left_out in sets]
        kept = np.ones((len(sets), len(self.touches)))
        for k, left_out in enumerate(sets):
            kept[k, list(left_out)] = 0.0
        R, t = (np.repeat(part[None], len(sets), axis=0) for part in (self.pose.R, self.pose.t))
        fits = fit_squares_of(self.touches, R, t, weighted=self.touches.covariances is not None, kept=kept)
        return [float(total) for total in fits.sums / self.unit**2]

    def rest(self, left_out: Sequence[int]) -> _Rows:
        """Fit again without touches."""
        kept = self.touches.select(np.setdiff1d(np.arange(len(self.touches)), left_out))
        sigma = self.unit if self.is_scaled and self.touches.covariances is None else None
        return _Rows.of(kept, self.pose, sigma)


@dataclass(frozen=True, slots=True, eq=False)
class _Set:
    """Touches that are left out, the sum of squares without them, the numbers they gave, the chance of such a drop."""

    rows: tuple[int, ...]
    total: float
    gone: int
    chance: float


def find_contradicted(
    touches: Touches, pose: Pose, sigma_mm: float | None, *, check: Touches | None = None
) -> Suspect | None:
    """Find the touch or the pair that the others contradict.

    `sigma_mm`: Teaching error per axis of touches without covariances, if stated. With stated errors the sums of
    squares are compared with χ², otherwise their ratio with F.

    Returns: None if no touch is contradicted. Without names if touches are wrong and the data cannot tell which.
    """
    seen = touches if check is None else touches.joined(check)
    rows = _Rows.of(seen, pose, sigma_mm)
    stands_out = False
    for k in (1, 2):
        sets = _sets(rows, k)
        if not sets:
            break
        single = SINGLE_SHARE if k == 1 or stands_out else PAIR_SHARE
        here = sets[0].chance < single * FALSE_ALARM and _off(rows, sets[0].rows).max() > FLOOR_MM
        stands_out = stands_out or here
        if here and _agrees(rows.rest(sets[0].rows)):
            return _weighed(rows, sets)
    if not stands_out:
        return None
    return Suspect((), (), None, 2, word="touch")


def squares_of(touches: Touches, start: Pose, sigma_mm: float | None) -> tuple[Pose, FloatArray, FloatArray]:
    """Fit touches; return the pose, the weights of the residuals in units of their errors, and their derivative.

    Returns `information`: ndarray, shape (n, 3, 3).
    Returns `jacobians`: ndarray, shape (n, 3, 6). By comparable coordinates of the motion of the part.
    """
    stated = touches.covariances is not None
    unit = 1.0 if stated or sigma_mm is None else max(sigma_mm, LEAST_SIGMA_MM)
    pose = fit_squares(touches, start, weighted=stated)
    return pose, pose.at.information(touches.covariances) / unit**2, scaled_jacobian(touches, pose)[0]


def least_without(touches: Touches, pose: Pose, sigma_mm: float | None, names: Sequence[str]) -> float | None:
    """Return the sum of squares without touches, or if none are named the least without a single one.

    None if the rest does not hold the part.
    """
    rows = _Rows.of(touches, pose, sigma_mm)
    if not names:
        return min((one.total for one in _sets(rows, 1)), default=None)
    wrong = [i for i, name in enumerate(touches.names) if name in names]
    return rows.rest(wrong).total if wrong and rows.without(wrong)[1] else None


def contradiction_issues(found: Suspect | None) -> tuple[Issue, ...]:
    """Report the touches that are contradicted."""
    if found is None:
        return ()
    if found.names:
        again = "touch it again" if len(found.names) == 1 else "touch them again"
        return (Issue(BLUNDER, f"{found.sentence}: {again}", found.names),)
    ids = tuple(dict.fromkeys(name for names, _ in found.rivals for name in names))
    return (Issue(NOT_NAMED, f"{found.sentence}; add one more touch", ids),)


def _sets(rows: _Rows, k: int) -> list[_Set]:
    """Leave out every touch, or every pair; the set that explains most comes first."""
    n = len(rows.touches)
    squares = np.bincount(rows.owner, weights=rows.a**2, minlength=n)
    tried = np.sort(np.argsort(-squares, kind="stable")[:MOST_TRIED])
    count = comb(n, k)
    linear = []
    for left_out in combinations(tried.tolist(), k):
        drop, gone = rows.without(left_out)
        if gone:
            linear.append(_tested(rows, left_out, max(rows.total - drop, 0.0), gone, count))
    linear.sort(key=lambda one: one.chance)
    best = linear[:FITTED_AGAIN]
    totals = rows.totals_without([one.rows for one in best])
    again = [_tested(rows, one.rows, total, one.gone, count) for one, total in zip(best, totals, strict=True)]
    return sorted(again + linear[FITTED_AGAIN:], key=lambda one: one.chance)


def _tested(rows: _Rows, left_out: tuple[int, ...], total: float, gone: int, count: int) -> _Set:
    drop, left = max(rows.total - total, 0.0), rows.freedom - gone
    if rows.is_scaled:
        return _Set(left_out, total, gone, count * float(chdtrc(gone, drop)))
    ratio = (drop / gone) / ((total + rows.floor(left)) / left)
    return _Set(left_out, total, gone, count * float(fdtrc(gone, left, ratio)))


def _agrees(rest: _Rows) -> bool:
    """Tell whether the touches that remain agree with each other, and with their stated errors."""
    level = REST_SHARE * FALSE_ALARM
    if rest.is_scaled and rest.freedom >= 1 and float(chdtrc(rest.freedom, rest.total)) < level:
        return False
    again = _sets(rest, 1)
    return not (again and again[0].chance < level and _off(rest, again[0].rows).max() > FLOOR_MM)


def _off(rows: _Rows, left_out: Sequence[int]) -> FloatArray:
    """How far touches lie from their targets when the others are fitted without them, mm."""
    pose = rows.rest(left_out).pose
    return rows.touches.select(left_out).linearised(pose.R, pose.t).distances


def _weighed(rows: _Rows, sets: list[_Set]) -> Suspect:
    """Name the first set if it is probable enough among sets of as many touches (Bayesian information criterion)."""
    logs = []
    for one in sets:
        left, gone = rows.freedom - one.gone, one.gone
        fit = -0.5 * one.total if rows.is_scaled else -0.5 * left * log(one.total + rows.floor(left) + 1e-300)
        logs.append(fit - 0.5 * gone * log(len(rows.a)))
    order = np.argsort(-np.array(logs), kind="stable")
    weight = np.exp(np.array(logs)[order] - logs[order[0]])
    weight /= weight.sum()
    names = [tuple(rows.touches.names[i] for i in sets[j].rows) for j in order[:6]]
    listed = [(one, float(p)) for one, p in zip(names, weight, strict=False) if p >= 0.05 * weight[0]]
    first = sets[order[0]]
    if weight[0] < NAMED_PROBABILITY:
        return Suspect((), (), None, len(first.rows), tuple(listed), word="touch")
    off = tuple(float(d) for d in _off(rows, first.rows))
    return Suspect(names[0], off, float(weight[0]), len(first.rows), tuple(listed[1:]), word="touch")
