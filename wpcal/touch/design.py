r"""Optimal sets of points: the search that minimises the largest predicted error along the seams.

For least squares the covariance of a seam point s is, with the centroid c, u = s - c and the inertia
:math:`N = \operatorname{tr}(M) I - M` of the taught points,

.. math:: C(s) = \sigma^2 \left( \tfrac{1}{n} I + [u]_\times N^{-1} [u]_\times^\top \right),

and its 95 % length follows from tr C and tr C² as in `wpcal.calibrate.errors.prediction.error_95`. Thousands of sets
are judged at once.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, islice, permutations
from typing import Protocol

import numpy as np
from scipy.special import chdtri

from wpcal.calibrate.errors.prediction import COVERAGE
from wpcal.calibrate.solve.least_squares import kabsch
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.progress import Progress, no_progress

MOST_ENUMERATED = 150_000  #: Up to this many sets are all tried, in some seconds. Above it single points are exchanged.
CHUNK = 8_000  #: Sets judged at once: some tens of megabytes.
STARTS = 12
"""Random sets from which the exchange starts. On the sample parts three of four of them end at the same best set."""
KEPT = 200  #: Best sets kept. Those with a symmetric swap are then removed.
FLAT = 1e-9  #: Least ratio of the determinant of N to the cube of its trace; below it the points lie on one line.
MOST_PERMUTED = 6  #: 720 orders. With more points nobody exchanges the names of all of them at once by mistake.
FREEDOMS = np.linspace(1.0, 3.0, 2001)
QUANTILES = chdtri(FREEDOMS, 1.0 - COVERAGE) / FREEDOMS
"""Of a length of 1 to 3 effective dimensions; the table is exact to 1e-7."""


@dataclass(frozen=True, slots=True, eq=False)
class Design:
    """What the sets are judged by."""

    points: FloatArray  #: shape (N, 3). Features that may be taught, in `part`, mm.
    seam_points: FloatArray  #: shape (k, 3). In `part`, mm.

    def largest_errors(self, rows: IntArray) -> FloatArray:
        """Largest 95 % error of the least-squares fit over the seam points, shape (m,). Per unit of sigma.

        `rows`: shape (m, n). m sets of n rows of `points`.
        """
        parts = [self._errors(rows[first : first + CHUNK]).max(axis=1) for first in range(0, len(rows), CHUNK)]
        return np.concatenate(parts) if parts else np.empty(0)

    def _errors(self, rows: IntArray) -> FloatArray:
        p = self.points[rows]
        centre = p.mean(axis=1)
        offsets = p - centre[:, None]
        moments = np.einsum("mni,mnj->mij", offsets, offsets)
        trace = np.trace(moments, axis1=1, axis2=2)
        inertia = trace[:, None, None] * np.eye(3) - moments
        flat = np.linalg.det(inertia) <= FLAT * trace**3
        inertia[flat] = np.eye(3)
        A = np.linalg.inv(inertia)
        # B = [u]× A [u]×ᵀ, and [u]×ᵀ [u]× = |u|² I - u uᵀ
        u = self.seam_points[None] - centre[:, None]
        Au = u @ A
        uu, uAu, uAAu = (np.einsum("mki,mki->mk", x, y) for x, y in ((u, u), (u, Au), (Au, Au)))
        a = 1.0 / rows.shape[1]
        tr_B = uu * np.trace(A, axis1=1, axis2=2)[:, None] - uAu
        tr_B2 = uu**2 * np.einsum("mij,mij->m", A, A)[:, None] - 2.0 * uu * uAAu + uAu**2
        tr_C = 3.0 * a + tr_B
        tr_C2 = 3.0 * a**2 + 2.0 * a * tr_B + tr_B2
        error = np.sqrt(tr_C * np.interp(tr_C**2 / tr_C2, FREEDOMS, QUANTILES))
        error[flat] = np.inf
        return np.asarray(error)

    def best_sets(
        self, n: int, *, held: tuple[int, ...] = (), rng: np.random.Generator, progress: Progress
    ) -> tuple[IntArray, FloatArray]:
        """Return the best sets of n points that hold the rows `held`, the best first, and their errors.

        If there are few sets, all are tried. Otherwise single points are exchanged, each time for the best of all
        features, until no exchange makes the error smaller.
        """
        search = SetSearch(self, len(self.points))
        if math.comb(len(self.points) - len(held), n - len(held)) <= MOST_ENUMERATED:
            progress(f"trying all sets of {n} points")
            return search.enumerated(n, held=held)
        return search.exchanged(n, held=held, rng=rng, progress=progress)


class SetJudge(Protocol):
    """What sets of points or touches are compared by."""

    def largest_errors(self, rows: IntArray, /) -> FloatArray:
        """Return the error of each of m sets, shape (m, n); infinite for a set that fixes nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class SetSearch:
    """The search for sets with the least error, of points or of touches."""

    judge: SetJudge
    count: int  #: Of what the sets are chosen from.

    def enumerated(self, n: int, *, held: tuple[int, ...] = ()) -> tuple[IntArray, FloatArray]:
        """Try all sets of n that hold the rows `held`; return the best, the best first, and their errors."""
        best = _Shortlist(n)
        free = np.setdiff1d(np.arange(self.count), held)
        sets: Iterator[tuple[int, ...]] = combinations(free.tolist(), n - len(held))
        while chunk := list(islice(sets, CHUNK)):
            rows = np.column_stack([np.tile(held, (len(chunk), 1)).astype(np.int64), np.array(chunk, dtype=np.int64)])
            best.take(rows, self.judge.largest_errors(rows))
        return best.rows, best.errors

    def exchanged(
        self,
        n: int,
        *,
        held: tuple[int, ...] = (),
        rng: np.random.Generator,
        progress: Progress = no_progress,
        start: IntArray | None = None,
        starts: int = STARTS,
    ) -> tuple[IntArray, FloatArray]:
        """Exchange single members until none makes the error smaller, from several starts; a given one comes first.

        `start`: shape (n,), optional.
        """
        best = _Shortlist(n)
        free = np.setdiff1d(np.arange(self.count), held)
        for number in range(starts):
            progress(f"exchanging points, start {number + 1} of {starts}")
            added = rng.choice(free, n - len(held), replace=False)
            first = np.concatenate([np.array(held, dtype=np.int64), added])
            self._descend(start if number == 0 and start is not None else first, [free] * n, len(held), best)
        return best.rows, best.errors

    def exchanged_in_slots(
        self, slots: Sequence[IntArray], *, rng: np.random.Generator, starts: int = 2
    ) -> tuple[IntArray, FloatArray]:
        """Exchange within a pattern. `slots`: shape (m,). Member k of a set is one of ``slots[k]``."""
        best = _Shortlist(len(slots))
        for _ in range(starts):
            first = list[int]()
            for slot in slots:
                left = np.setdiff1d(slot, first)
                if len(left) == 0:
                    return best.rows, best.errors
                first.append(int(rng.choice(left)))
            self._descend(np.array(first, dtype=np.int64), list(slots), 0, best)
        return best.rows, best.errors

    def _descend(self, current: IntArray, slots: Sequence[IntArray], held: int, best: _Shortlist) -> None:
        error = np.inf
        while True:
            rows = _neighbours(current, slots, held)
            if len(rows) == 0:
                best.take(current[None], self.judge.largest_errors(current[None]))
                return
            errors = self.judge.largest_errors(rows)
            best.take(rows, errors)
            k = int(np.argmin(errors))
            if not errors[k] < error:
                return
            current, error = rows[k], float(errors[k])


def _neighbours(current: IntArray, slots: Sequence[IntArray], held: int) -> IntArray:
    """Return all sets with one of the members after the first `held` exchanged."""
    found = []
    for k in range(held, len(current)):
        others = np.setdiff1d(slots[k], current)
        rows = np.tile(current, (len(others), 1))
        rows[:, k] = others
        found.append(rows)
    return np.concatenate(found) if found else np.empty((0, len(current)), dtype=np.int64)


class _Shortlist:
    """The best sets met so far, each once."""

    def __init__(self, n: int) -> None:
        self.rows: IntArray = np.empty((0, n), dtype=np.int64)
        self.errors: FloatArray = np.empty(0)

    def take(self, rows: IntArray, errors: FloatArray) -> None:
        """Take the best of further sets."""
        some = np.argsort(errors, kind="stable")[:KEPT]
        some = some[np.isfinite(errors[some])]
        joined = np.concatenate([self.rows, np.sort(rows[some], axis=1)])
        unique, first = np.unique(joined, axis=0, return_index=True)
        errors = np.concatenate([self.errors, errors[some]])[first]
        order = np.argsort(errors, kind="stable")[:KEPT]
        self.rows, self.errors = unique[order], errors[order]


def least_swap(p: FloatArray) -> tuple[float, tuple[int, ...]]:
    """Sum of squares of the best fit of points to themselves in another order, mm², and that order.

    Zero for a symmetric set: its names can be exchanged without a trace in the residuals.

    `p`: shape (n, 3). mm. Up to `MOST_PERMUTED` points all orders are tried; of more, only exchanges of two points.
    """
    n = len(p)
    orders = _other_orders(n)
    q = p[orders]
    source = np.broadcast_to(p, q.shape)
    R, t = kabsch(source, q, np.full(q.shape[:2], 1.0 / n))
    left = q - source @ R.transpose(0, 2, 1) - t[:, None]
    squares = np.einsum("mni,mni->m", left, left)
    k = int(np.argmin(squares))
    return float(squares[k]), tuple(int(v) for v in orders[k])


@lru_cache(maxsize=32)
def _other_orders(n: int) -> IntArray:
    """Return the orders of n points that are tried besides their own, shape (m, n)."""
    orders = np.array([order for order in _orders(n) if order != tuple(range(n))])
    orders.flags.writeable = False
    return orders


def _orders(n: int) -> Iterator[tuple[int, ...]]:
    if n <= MOST_PERMUTED:
        yield from permutations(range(n))
        return
    for i, j in combinations(range(n), 2):
        order = list(range(n))
        order[i], order[j] = j, i
        yield tuple(order)


def farthest_rows(points: FloatArray, most: int) -> IntArray:
    """Pick points far from one another, shape (min(n, most),).

    The first is the farthest from the centroid. Each further one is the farthest from those already picked.

    `points`: shape (n, 3). mm.
    """
    if len(points) <= most:
        return np.arange(len(points))
    picked = [int(np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1)))]
    distance = np.linalg.norm(points - points[picked[0]], axis=1)
    while len(picked) < most:
        picked.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(points - points[picked[-1]], axis=1))
    return np.array(picked)
