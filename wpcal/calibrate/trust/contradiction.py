r"""Which touches do the others contradict? A touch or a pair is left out in turn (`wpcal.calibrate.trust.left_out`).

With a the residuals of the fit in units of their errors and :math:`Q = I - H` the matrix that leaves of an error what
the residuals show of it beside the pose and errors that all touches share, leaving out the numbers K of one or two
touches lowers the sum of squares by :math:`a_K^\top Q_{KK}^{-1} a_K`. That is exact while nothing turns; the best sets
are therefore fitted again.

References: Baarda (1968), A testing procedure for use in geodetic networks. Cook, Weisberg (1982), chapter 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import ClassVar

import numpy as np

from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.solve.touches import Pose, fit_squares, fit_squares_of, scaled_jacobian
from wpcal.calibrate.trust.blame import Suspect
from wpcal.calibrate.trust.criteria import BLUNDER, NOT_NAMED
from wpcal.calibrate.trust.left_out import Sets, Shares, chances, search
from wpcal.calibrate.trust.residuals import FLOOR_MM, LEAST_SIGMA_MM
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.issue import Issue

MOST_TRIED = 60  #: Touches and pairs are tried among this many touches, those with the largest residuals: 1770 pairs.
FITTED_AGAIN = 12  #: Best sets that are fitted again: the sums of the others are those of the linear formula.
HELD = 1e-3
"""If a motion is free without touches (below this share of the largest singular value), the others cannot judge."""
LEAST_SHOWN = 1e-6  #: Share of an error that must show in the residuals: less is round-off.
MOST_WRONG = 2  #: Touches of a set.
TOUCHES = Shares(0.8, (0.3,), 0.4)


@dataclass(frozen=True, slots=True, eq=False)
class TouchRows:
    """Residuals of the least-squares fit of all touches in units of their errors, one row per observed number."""

    touches: Touches
    pose: Pose
    scaled: bool
    unit: float
    a: FloatArray
    U: FloatArray
    owner: IntArray
    J: FloatArray

    @classmethod
    def of(cls, touches: Touches, start: Pose, sigma_mm: float | None) -> TouchRows:
        """Fit all of them; `sigma_mm` is the error per axis of touches without covariances, if stated."""
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

    shares: ClassVar[Shares] = TOUCHES

    def __len__(self) -> int:
        return len(self.touches)

    @property
    def total(self) -> float:
        """Sum of squares of the fit of all."""
        return float(self.a @ self.a)

    @property
    def freedom(self) -> int:
        """Numbers observed beside those of the pose."""
        return len(self.a) - max(int(self.U.shape[1]), 6)

    def floor(self, freedom: int) -> float:
        """Sum of squares that a controller's last digit alone leaves."""
        return max(freedom, 1) * (FLOOR_MM / self.unit) ** 2 if self.touches.covariances is None else 0.0

    def drop(self, left_out: Sequence[int]) -> tuple[float, int]:
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
            return [max(self.total - self.drop(left_out)[0], 0.0) for left_out in sets]
        kept = np.ones((len(sets), len(self.touches)))
        for k, left_out in enumerate(sets):
            kept[k, list(left_out)] = 0.0
        R, t = (np.repeat(part[None], len(sets), axis=0) for part in (self.pose.R, self.pose.t))
        fits = fit_squares_of(self.touches, R, t, weighted=self.touches.covariances is not None, kept=kept)
        return [float(total) for total in fits.sums / self.unit**2]

    def rest(self, left_out: Sequence[int]) -> TouchRows:
        """Fit again without touches."""
        kept = self.touches.select(np.setdiff1d(np.arange(len(self.touches)), left_out))
        sigma = self.unit if self.scaled and self.touches.covariances is None else None
        return TouchRows.of(kept, self.pose, sigma)

    def without(self, k: int, _: Sets | None) -> Sets:
        """Leave out every touch, or every pair; only sets without which the others hold the part."""
        squares = np.bincount(self.owner, weights=self.a**2, minlength=len(self))
        tried = np.sort(np.argsort(-squares, kind="stable")[:MOST_TRIED])
        found = [(left_out, *self.drop(left_out)) for left_out in combinations(tried.tolist(), k)]
        found = [each for each in found if each[2]]
        drops, gone = (np.array([each[c] for each in found], dtype=kind) for c, kind in ((1, float), (2, np.int64)))
        left_out = np.array([each[0] for each in found], dtype=np.int64).reshape(-1, k)
        sets = Sets(left_out, np.maximum(self.total - drops, 0.0), gone, np.ones(len(found), dtype=np.bool_))
        best = np.argsort(chances(self, sets), kind="stable")[:FITTED_AGAIN]
        sets.sums[best] = self.totals_without(left_out[best].tolist())
        return sets

    def off_mm(self, left_out: Sequence[int]) -> FloatArray:
        """How far touches lie from their targets when the others are fitted without them, mm."""
        pose = self.rest(left_out).pose
        return self.touches.select(left_out).linearised(pose.R, pose.t).distances


def find_contradicted(
    touches: Touches, pose: Pose, sigma_mm: float | None, *, check: Touches | None = None
) -> Suspect | None:
    """Find the touch or the pair that the others contradict.

    `sigma_mm`: Teaching error per axis of touches without covariances, if stated. With stated errors the sums of
    squares are compared with χ², otherwise their ratio with F.

    Returns: None if no touch is contradicted. Without names if touches are wrong and the data cannot tell which.
    """
    seen = touches if check is None else touches.joined(check)
    rows = TouchRows.of(seen, pose, sigma_mm)
    found = search(rows, MOST_WRONG)
    if not found.at_least:
        return None
    off = tuple(rows.off_mm(found.named).tolist()) if found.named else ()
    named, sure = tuple(seen.names[i] for i in found.named), found.probabilities[0] if found.named else None
    return Suspect(named, off, sure, found.at_least, found.rivals(seen.names, found.named), word="touch")


def squares_of(touches: Touches, start: Pose, sigma_mm: float | None) -> tuple[Pose, FloatArray, FloatArray]:
    """Fit touches; return the pose, the weights of the residuals in units of their errors, and their derivative.

    Returns `information`: shape (n, 3, 3).
    Returns `jacobians`: shape (n, 3, 6). By comparable coordinates of the motion of the part.
    """
    stated = touches.covariances is not None
    unit = 1.0 if stated or sigma_mm is None else max(sigma_mm, LEAST_SIGMA_MM)
    pose = fit_squares(touches, start, weighted=stated)
    return pose, pose.at.information(touches.covariances) / unit**2, scaled_jacobian(touches, pose)[0]


def least_without(touches: Touches, pose: Pose, sigma_mm: float | None, names: Sequence[str]) -> float | None:
    """Return the sum of squares without touches, or if none are named the least without a single one.

    None if the rest does not hold the part.
    """
    rows = TouchRows.of(touches, pose, sigma_mm)
    if not names:
        return min(rows.without(1, None).sums.tolist(), default=None)
    wrong = [i for i, name in enumerate(touches.names) if name in names]
    return rows.rest(wrong).total if wrong and rows.drop(wrong)[1] else None


def contradiction_issues(found: Suspect | None) -> tuple[Issue, ...]:
    """Report the touches that are contradicted."""
    if found is None:
        return ()
    if found.names:
        again = "touch it again" if len(found.names) == 1 else "touch them again"
        return (Issue(BLUNDER, f"{found.sentence}: {again}", found.names),)
    ids = tuple(dict.fromkeys(name for names, _ in found.rivals for name in names))
    return (Issue(NOT_NAMED, f"{found.sentence}; add one more touch", ids),)
