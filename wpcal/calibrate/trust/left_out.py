r"""Which observations do the others contradict? One, a pair or more are left out in turn, and the fits are compared.

Leaving out observations that gave g numbers lowers the sum of squares from :math:`S` to :math:`S_K`. Under normal
errors of known size :math:`S - S_K` is :math:`\chi^2(g)`; if the size is not known, and f numbers are left beside the
pose,

.. math:: F = \frac{(S - S_K) / g}{S_K / f} \sim F(g, f).

The level is divided by the number of sets (Bonferroni). A set is the answer only if the rest agrees by the same test.
Then all sets of as many observations are weighed by their likelihoods and the numbers that they take (Bayesian
information criterion): the share of the best set is its probability, if all were equally likely before. Four corners of
a plate show why this is needed: one of them off the plane is detected, but each of them explains it equally well.

References: Cook, Weisberg (1982), Residuals and Influence in Regression, chapter 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtrc, fdtrc

from wpcal.calibrate.solve.error_rows import ErrorRows
from wpcal.calibrate.trust.residuals import FALSE_ALARM, FLOOR_MM, NAMED_PROBABILITY
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

if TYPE_CHECKING:
    from wpcal.calibrate.trust.contradiction import TouchRows

    Rows: TypeAlias = "PointRows | TouchRows"

MOST_SETS, EXTENDED = 4000, 40
"""Up to this many sets of points all are tried: pairs of 89 points. Of more, the best sets of one less are extended."""
LIKELY, MOST_LIKELY = 0.05, 6  #: Sets are told that are so probable against the best one, and this many.


@dataclass(frozen=True, slots=True)
class Shares:
    """Shares of the false alarms, simulated so that all tests together raise one in a hundred fits."""

    single: float  #: For single observations, where pairs are tried as well.
    several: tuple[float, ...]  #: For pairs, triples, … that are tried where no smaller set stands out.
    rest: float  #: For the second test, of the observations that remain.
    least_left: int = 1  #: This many numbers must be left for the second test.


POINTS, POINTS_UNSTATED = Shares(0.8, (0.4, 0.05), 0.05), Shares(0.8, (0.4, 0.05), 0.4, 4)
"""Of points. If no error is stated, the second of two wrong points stands out less, and a smaller share for the rest
names the first one as the only one."""


@dataclass(frozen=True, slots=True, eq=False)
class Contradiction:
    """What the search for wrong observations found."""

    #: Rows that may be wrong together, the most probable set first. Empty if nothing is contradicted.
    sets: tuple[tuple[int, ...], ...]
    probabilities: tuple[float, ...]  #: Of these sets.
    at_least: int  #: The least number of observations that must be wrong. 0 if none is contradicted.
    remains: bool  #: Whether those that remain still contradict each other or the stated errors.

    @property
    def named(self) -> tuple[int, ...]:
        """Rows of the observations that are named as wrong."""
        clear = bool(self.sets) and self.probabilities[0] >= NAMED_PROBABILITY
        return self.sets[0] if clear and len(self.sets[0]) >= self.at_least else ()

    def rivals(self, names: Sequence[str], named: Sequence[int]) -> tuple[tuple[tuple[str, ...], float], ...]:
        """Return the sets besides the one that is named, with their probabilities."""
        listed = [(tuple(names[i] for i in rows), p) for rows, p in zip(self.sets, self.probabilities, strict=True)]
        return tuple(listed[1:] if named else listed)


NOTHING = Contradiction((), (), 0, remains=False)  #: Nothing is contradicted.


@dataclass(frozen=True, slots=True, eq=False)
class Sets:
    """m sets of k observations that were left out."""

    left_out: IntArray  #: shape (m, k).
    sums: FloatArray  #: shape (m,). Sums of squares without them.
    gone: IntArray  #: shape (m,). How many numbers they gave.
    fixed: BoolArray  #: shape (m,). Whether the rest holds the part.

    def ordered(self, *keys: FloatArray) -> Sets:
        """Return the sets by keys, the last one first in importance."""
        order = np.lexsort(keys)
        return Sets(self.left_out[order], self.sums[order], self.gone[order], self.fixed[order])


def search(rows: Rows, most: int) -> Contradiction:
    """Find the observations that the others contradict, up to `most` of them."""
    sets, stands_out, shares = None, False, rows.shares
    single = 1.0 if most == 1 else shares.single
    for k in range(1, most + 1):
        sets = rows.without(k, sets)
        if not len(sets.sums):
            break
        chance = chances(rows, sets)
        sets = sets.ordered(sets.sums, chance)
        share = single if k == 1 or stands_out else shares.several[k - 2]
        here = chance.min() < share * FALSE_ALARM and rows.off_mm(sets.left_out[0]).max() > FLOOR_MM
        stands_out = stands_out or bool(here)
        if here and _agrees(rows.rest(sets.left_out[0])):
            return weigh_sets(rows, sets)
        if not stands_out and k > len(shares.several):
            break
    if not stands_out:
        return NOTHING
    return Contradiction((), (), 2 if most > 1 else 1, remains=True)


def chances(rows: Rows, sets: Sets) -> FloatArray:
    """Probability that good observations show a set as extreme as each, shape (k,) for k sets."""
    drop, left = np.maximum(rows.total - sets.sums, 0.0), rows.freedom - sets.gone
    count = comb(len(rows), sets.left_out.shape[1])
    if rows.scaled:
        return np.asarray(count * chdtrc(sets.gone, drop))
    floor = np.array([rows.floor(each) for each in left.tolist()])
    held = np.maximum(left, 1)
    ratio = (drop / sets.gone) / ((sets.sums + floor) / held)
    return np.where(left > 0, count * fdtrc(sets.gone, held, ratio), 1.0)


def weigh_sets(rows: Rows, sets: Sets) -> Contradiction:
    """Weigh sets of wrong observations, if one of them is the set of the wrong ones."""
    left = rows.freedom - sets.gone
    floor = np.array([rows.floor(each) for each in left.tolist()])
    log = -0.5 * sets.sums if rows.scaled else -0.5 * left * np.log(sets.sums + floor + 1e-300)
    log = log - 0.5 * sets.gone * np.log(rows.freedom + 6)
    order = np.argsort(-log, kind="stable")
    probability = np.exp(log[order] - log[order[0]])
    probability /= probability.sum()
    if not sets.fixed[order[0]]:  # the others do not hold the part, so they cannot judge
        return Contradiction((), (), sets.left_out.shape[1], remains=False)
    likely = np.flatnonzero(probability >= LIKELY * probability[0])[:MOST_LIKELY]
    told = tuple(tuple(sets.left_out[order[j]].tolist()) for j in likely)
    return Contradiction(told, tuple(probability[likely].tolist()), sets.left_out.shape[1], remains=False)


def _agrees(rest: Rows) -> bool:
    """Tell whether observations agree with each other, and with their stated errors."""
    level = FALSE_ALARM * rest.shares.rest
    if rest.scaled and rest.freedom >= 1 and float(chdtrc(rest.freedom, rest.total)) < level:
        return False
    sets = rest.without(1, None)
    tested = rest.freedom - sets.gone >= rest.shares.least_left
    if not tested.all() or not len(tested):
        return True
    chance = chances(rest, sets)
    best = sets.ordered(sets.sums, chance)
    return not (chance.min() < level and rest.off_mm(best.left_out[0]).max() > FLOOR_MM)


@dataclass(frozen=True, slots=True, eq=False)
class PointRows:
    """Points that can be left out."""

    rows: ErrorRows
    scaled: bool  #: Whether their errors are known with their size.
    shares: Shares
    freedom: int  #: Numbers observed beside those of the pose.
    total: float  #: Sum of squares of the fit of all.

    @classmethod
    def of(cls, rows: ErrorRows) -> PointRows:
        """Fit all of them."""
        shares = POINTS if rows.scaled else POINTS_UNSTATED
        return cls(rows, rows.scaled, shares, 3 * len(rows) - 6, rows.sum_of_squares())

    def __len__(self) -> int:
        return len(self.rows)

    def floor(self, freedom: int) -> float:
        """Sum of squares that a controller's last digit alone leaves in this many numbers."""
        return self.rows.floor(freedom)

    def without(self, k: int, smaller: Sets | None) -> Sets:
        """Leave out sets of k; `smaller` are those of k - 1."""
        n = len(self)
        if smaller is None or comb(n, k) <= MOST_SETS:
            return self.left_out(np.array(list(combinations(range(n), k))))
        first = np.repeat(smaller.left_out[:EXTENDED], n, axis=0)
        new = np.tile(np.arange(n), len(smaller.left_out[:EXTENDED]))
        fresh = ~(first == new[:, None]).any(axis=1)
        return self.left_out(np.unique(np.sort(np.column_stack([first, new])[fresh], axis=1), axis=0))

    def left_out(self, sets: IntArray) -> Sets:
        """Fit without each of some sets, shape (m, k)."""
        n, (m, k) = len(self), sets.shape
        keep = np.ones((m, n), dtype=bool)
        np.put_along_axis(keep, sets, False, axis=1)
        rest = self.rows.select(np.nonzero(keep)[1].reshape(m, n - k))
        sums = rest.squares(*rest.fit()).sum(axis=1)
        return Sets(sets, sums, np.full(m, 3 * k), rest.fixes_rotation())

    def rest(self, left_out: ArrayLike) -> PointRows:
        """Return all others; `left_out`: shape (k,)."""
        return PointRows.of(self.rows.select(np.delete(np.arange(len(self)), np.asarray(left_out))))

    def off_mm(self, left_out: ArrayLike) -> FloatArray:
        """How far points, shape (k,), lie from the fit of the others, mm; `left_out`: shape (k,)."""
        out = np.asarray(left_out)
        R, t = self.rows.select(np.delete(np.arange(len(self)), out)).fit()
        return np.asarray(np.linalg.norm(self.rows.q[out] - self.rows.p[out] @ R.T - t, axis=1))


def find_wrong(rows: ErrorRows) -> Contradiction:
    """Find the points that the others contradict."""
    most = max(1, min((len(rows) - 1) // 2, len(rows) - 4))
    found = search(PointRows.of(rows), most)
    if found.remains and rows.scaled:
        # the stated errors are too small: is there still a point that the residuals themselves name?
        relative = search(PointRows.of(rows.without_scale()), most)
        if relative.named and not relative.remains:
            return Contradiction(relative.sets, relative.probabilities, relative.at_least, remains=True)
    return found


def weigh_one(rows: ErrorRows, left_out: tuple[int, ...]) -> Contradiction:
    """Weigh a set of wrong points that was found in another way against sets that differ from it in one point."""
    n, out = len(rows), np.array(left_out, dtype=np.int64)
    keep = np.delete(np.arange(n), out)
    least = int(np.argmin(rows.select(out).squares(*rows.select(keep).fit())))
    sets = np.vstack([out, *(np.where(np.arange(len(out)) == least, other, out) for other in keep)])
    points = PointRows.of(rows)
    return weigh_sets(points, points.left_out(sets))
