r"""The choice of touches for a weldment whose bodies may move.

With the covariance C of the unknowns, a further touch with the rows H (unit errors) leaves

.. math:: C' = C - C H^\top (I + H C H^\top)^{-1} H C,

so the error of every seam point after every possible touch comes from two products of matrices. Touches are added one
by one, each time the one after which the errors are least, and then exchanged one by one until no exchange helps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from wpcal.calibrate.errors.of_bodies import MOST_POINTS, MeetingPoints, joint_error
from wpcal.calibrate.errors.prediction import COVERAGE, length_quantile
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.touch.advise.design import FREEDOMS, QUANTILES, farthest_rows

LARGEST = 16.0  #: The sum of errors to this power: the largest decides, and below it the next.
MOST_SEAM_POINTS = 160
"""Seam points that the search looks at; the errors reported are those over all points."""
PER_PAIR = 6
"""Of them where the same two bodies meet: the error is largest at the ends of the extent of a seam."""
REDUCIBLE = 0.5  #: Weight of the largest error above its floor, beside the largest error.
OFTEN = 1e4  #: Each possible touch is made so many times to see what no touch can lower.
SWEEPS = 4  #: Each touch is exchanged so many times at most: the second sweep rarely gains a hundredth.
GAIN = 1e-3  #: An exchange counts if it lowers the sum by this share.
NEARLY = 1.05
"""Where a tolerance cannot be reached, touches are added until they leave this times the error that all would leave."""
CHUNK = 400_000  #: Pairs of a touch and a seam point that are judged at once: some tens of megabytes.


@dataclass(frozen=True, slots=True, eq=False)
class MovedSearch:
    """What may be touched, and where errors count."""

    #: shape (n, q, m). Of each possible touch, in units of its error: see `MovedModel.rows`. Rows of zeros measure
    #: nothing.
    rows: FloatArray
    seams: FloatArray  #: shape (k, 3, m). Of the seam points, mm: see `MovedModel.seam_rows`.
    #: shape (k,). The variance of each seam point that no touch can lower, mm²: see `with_floor`.
    floor: FloatArray = field(default_factory=lambda: np.zeros(1))

    @classmethod
    def with_floor(cls, rows: FloatArray, seams: FloatArray, start: FloatArray) -> MovedSearch:
        """Return the search that also judges what touches can lower.

        Where the largest error comes from a motion that no touch sees, every choice leaves nearly the same error. What
        is above the floor then decides.

        Parameters
        ----------
        start : shape (m, m). Information before the first touch.
        """
        H = rows.reshape(-1, rows.shape[2])
        unseen = inverse(start + OFTEN * H.T @ H)
        return cls(rows, seams, np.einsum("kim,mn,kin->k", seams, unseen, seams))

    def information(self, chosen: Sequence[int]) -> FloatArray:
        """Return what touches add to the information, shape (m, m)."""
        H = self.rows[list(chosen)].reshape(-1, self.rows.shape[2])
        return np.asarray(H.T @ H)

    def errors(self, C: FloatArray) -> FloatArray:
        """Return the 95 % errors of the seam points with a covariance of the unknowns, shape (k,), mm."""
        return length_quantile(self.seams @ C @ self.seams.transpose(0, 2, 1), COVERAGE)

    def joint_error(self, C: FloatArray) -> float:
        """Return the length, mm, that no seam point's error exceeds, with 95 % probability; C has the shape (m, m)."""
        worst = np.argsort(-self.errors(C), kind="stable")[:MOST_POINTS]
        return joint_error(self.seams[worst], C)

    def scores(self, C: FloatArray) -> FloatArray:
        """Return how large the errors are after each possible touch, shape (n,), mm."""
        many = max(1, CHUNK // max(len(self.seams), 1))
        S = self.seams @ C @ self.seams.transpose(0, 2, 1)
        parts = [self._scores(C, S, self.rows[first : first + many]) for first in range(0, len(self.rows), many)]
        return np.concatenate(parts)

    def _scores(self, C: FloatArray, S: FloatArray, H: FloatArray) -> FloatArray:
        n, q, m = H.shape
        X = C @ H.reshape(-1, m).T
        A = (self.seams.reshape(-1, m) @ X).reshape(-1, 3, n, q)
        D = np.eye(q) + np.einsum("nqm,mnr->nqr", H, X.reshape(m, n, q))
        values, vectors = np.linalg.eigh((D + D.transpose(0, 2, 1)) / 2.0)
        back = vectors / np.sqrt(np.maximum(values, 1.0))[:, None, :]  # below 1 is round-off
        B = np.einsum("kinr,nrq->ikqn", A, back)
        trace, square = np.zeros((len(S), n)), np.zeros((len(S), n))
        for i in range(3):
            for j in range(i, 3):
                left = S[:, i, j, None] - (B[i] * B[j]).sum(axis=1)
                square += (1.0 if i == j else 2.0) * left**2
                if i == j:
                    trace += np.maximum(left, 0.0)
        m_eff = trace**2 / np.maximum(square, 1e-300)
        factor = np.interp(m_eff, FREEDOMS, QUANTILES)
        above = np.maximum(trace - self.floor[:, None], 0.0)
        return _largest(np.sqrt(trace * factor)) + REDUCIBLE * _largest(np.sqrt(above * factor))

    def added(self, start: FloatArray, chosen: list[int]) -> int | None:
        """Return the touch to add next; None if all are chosen.

        Parameters
        ----------
        start : shape (m, m). Information before the chosen touches.
        """
        if len(chosen) >= len(self.rows):
            return None
        scores = self.scores(inverse(start + self.information(chosen)))
        scores[chosen] = np.inf
        return int(np.argmin(scores))

    def exchanged(self, start: FloatArray, chosen: list[int]) -> list[int]:
        """Exchange chosen touches one by one while that makes the errors smaller.

        `start`, of shape (m, m), is the information before them.
        """
        chosen, M = list(chosen), start + self.information(chosen)
        for _ in range(SWEEPS):
            is_better = False
            for k, own in enumerate(chosen):
                without = M - self.information([own])
                scores = self.scores(inverse(without))
                now = scores[own]
                scores[chosen] = np.inf
                best = int(np.argmin(scores))
                if scores[best] < (1.0 - GAIN) * now:
                    chosen[k], M, is_better = best, without + self.information([best]), True
            if not is_better:
                break
        return chosen

    def chosen(self, start: FloatArray, count: int) -> list[int]:
        """Return the best `count` touches found, or all if there are not more; `start` has the shape (m, m)."""
        chosen = list[int]()
        while len(chosen) < count and (best := self.added(start, chosen)) is not None:
            chosen.append(best)
        return self.exchanged(start, chosen)

    def fewest(
        self, start: FloatArray, tolerance_mm: float, least: int, most: int, usual: int
    ) -> tuple[list[int], float]:
        """Return few touches after which no seam point's error exceeds the tolerance, with 95 % probability.

        Parameters
        ----------
        start : ndarray, shape (m, m)

        Returns
        -------
        chosen : list of int. If no number reaches it, few that are nearly as good as all, `most` at most.
        error_mm : float. What they reach.
        """
        goal = max(tolerance_mm, NEARLY * self._joint(start, range(len(self.rows))))
        least = max(least, min(usual, most)) if goal > tolerance_mm else least
        chosen = self.chosen(start, least)
        error = self._joint(start, chosen)
        while error > goal and len(chosen) < most:
            best = self.added(start, chosen)
            if best is None:
                break
            chosen.append(best)
            error = self._joint(start, chosen)
        while error <= goal and len(chosen) > least:
            fewer = self.exchanged(start, self._without_one(start, chosen))
            reached = self._joint(start, fewer)
            if reached > goal:
                break
            chosen, error = fewer, reached
        return chosen, error

    def _without_one(self, start: FloatArray, chosen: list[int]) -> list[int]:
        """Leave out the touch without which the errors are least."""
        M = start + self.information(chosen)
        left = [self.errors(inverse(M - self.information([own]))).max() for own in chosen]
        k = int(np.argmin(left))
        return chosen[:k] + chosen[k + 1 :]

    def _joint(self, start: FloatArray, chosen: Sequence[int]) -> float:
        return self.joint_error(inverse(start + self.information(chosen)))

    def errors_after(self, start: FloatArray, order: Sequence[int]) -> FloatArray:
        """Return the errors of the seam points before the first touch, and after each in an order.

        Parameters
        ----------
        start : ndarray, shape (m, m)

        Returns
        -------
        ndarray, shape (n + 1, k). mm.
        """
        C = inverse(start)
        S = self.seams @ C @ self.seams.transpose(0, 2, 1)
        found = [length_quantile(S, COVERAGE)]
        for k in order:
            X = C @ self.rows[k].T
            D = np.linalg.inv(np.eye(X.shape[1]) + self.rows[k] @ X)
            A = self.seams @ X
            C, S = C - X @ D @ X.T, S - A @ D @ A.transpose(0, 2, 1)
            found.append(length_quantile(S, COVERAGE))
        return np.stack(found)

    def in_order(self, start: FloatArray, chosen: Sequence[int]) -> list[int]:
        """Return chosen touches in the order in which each lowers the errors most; `start` has the shape (m, m)."""
        some = list(chosen)
        own = MovedSearch(self.rows[some], self.seams, self.floor)
        order = list[int]()
        while (best := own.added(start, order)) is not None:
            order.append(best)
        return [some[k] for k in order]


def _largest(errors: FloatArray) -> FloatArray:
    """Return a smooth largest value of each column, shape (k, n) → (n,)."""
    top = np.maximum(errors.max(axis=0), 1e-300)
    return np.asarray(top * ((errors / top) ** LARGEST).sum(axis=0) ** (1.0 / LARGEST))


def inverse(information: FloatArray) -> FloatArray:
    """Return the covariance of the unknowns that an information leaves, shape (m, m)."""
    found = np.linalg.inv(information)
    return np.asarray((found + found.T) / 2.0, dtype=np.float64)


def deciding_points(points: MeetingPoints) -> IntArray:
    """Return seam points among which the largest error is: far from one another, of every two bodies that meet.

    Returns
    -------
    ndarray of int, shape (k,)
    """
    pairs, which = np.unique(np.column_stack([points.wall_body, points.base_body]), axis=0, return_inverse=True)
    each = max(2, min(PER_PAIR, MOST_SEAM_POINTS // max(len(pairs), 1)))
    if len(pairs) == 1:
        each = MOST_SEAM_POINTS // 10
    found = []
    for pair in range(len(pairs)):
        own = np.flatnonzero(which.ravel() == pair)
        found.append(own[farthest_rows(points.p_part[own], each)])
    return np.sort(np.concatenate(found))
