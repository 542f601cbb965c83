r"""Which points do the others contradict? One, a pair or more are left out in turn, and the fits are compared.

Leaving out k points lowers the sum of squares from :math:`S` to :math:`S_K` and takes 3 k numbers with it. Under normal
errors of known size :math:`S - S_K` is :math:`\chi^2(3k)`; if the size is not known,

.. math:: F = \frac{(S - S_K) / 3k}{S_K / (3n - 6 - 3k)} \sim F(3k, 3n - 6 - 3k).

The level is divided by the number of sets of k points (Bonferroni). A set is the answer only if the points that remain
agree: they are tested again in the same way. Then every set of k points is weighed by its likelihood,
:math:`\exp(-S_K / 2)` or :math:`S_K^{-(3n-6-3k)/2}`. The share of the best set is its probability, if k points are
wrong and all sets were equally likely before. Four corners of a plate show why this is needed: one of them off the
plane is detected, but each of them explains it equally well.

References
----------
Cook, Weisberg (1982), Residuals and Influence in Regression, chapter 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np
from scipy.special import chdtrc, fdtrc

from wpcal.calibrate.solve.error_rows import ErrorRows
from wpcal.calibrate.trust.residuals import FALSE_ALARM, FLOOR_MM, NAMED_PROBABILITY
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

MOST_SETS = 4000
"""Up to this many sets of points all are tried: pairs of 89 points, triples of 29. Of more, the best sets of one point
less are extended."""
EXTENDED = 40  #: Best sets of k - 1 points that are extended to k points if there are more than `MOST_SETS`.
SINGLE_SHARE = 0.8  #: Share of the false alarms for single points where pairs are tried as well.
SEVERAL_SHARES = (0.4, 0.05)
"""Shares for pairs and for triples where no smaller set stands out. A good set of points that raises an alarm as a pair
often does so as a single point, and pairs overlap: simulated, all three together raise the alarm in one fit of a
hundred."""
MOST_HIDDEN = 1 + len(SEVERAL_SHARES)
"""Sets of up to this many points are tried where no smaller set stands out: wrong points can hide each other."""
REST_SHARE = 0.05
"""Share of the false alarms for the second test, of the points that remain after a point was left out."""
REST_SHARE_UNSTATED = 0.4
"""The same if no error is stated. The second of two wrong points then stands out less, and a smaller share names the
first one as the only one."""


@dataclass(frozen=True, slots=True, eq=False)
class Contradiction:
    """What the search for wrong points found."""

    #: Rows that may be wrong together, the most probable set first. Empty if no point is contradicted.
    sets: tuple[tuple[int, ...], ...]
    probabilities: tuple[float, ...]  #: Of these sets.
    at_least: int  #: The least number of points that must be wrong. 0 if no point is contradicted.
    remains: bool  #: Whether the points that remain still contradict each other or the stated errors.

    @property
    def named(self) -> tuple[int, ...]:
        """Rows of the points that are named as wrong."""
        clear = bool(self.sets) and self.probabilities[0] >= NAMED_PROBABILITY
        return self.sets[0] if clear and len(self.sets[0]) >= self.at_least else ()


NOTHING = Contradiction((), (), 0, remains=False)  #: No point is contradicted.


@dataclass(frozen=True, slots=True, eq=False)
class _Sets:
    """Sets of k points, the sums of squares without them (best first), and whether the rest fixes a rotation."""

    left_out: IntArray
    sums: FloatArray
    fixed: BoolArray

    @property
    def k(self) -> int:
        return int(self.left_out.shape[1])

    def freedom(self, n: int) -> int:
        """Degrees of freedom of the points that remain."""
        return 3 * (n - self.k) - 6

    def chance(self, rows: ErrorRows, total: float) -> float:
        """Probability that good points show a set as extreme as the best one."""
        n, rest = len(rows), float(self.sums[0])
        drop, freedom, count = max(total - rest, 0.0), self.freedom(len(rows)), comb(n, self.k)
        if rows.scaled:
            return count * float(chdtrc(3 * self.k, drop))
        if freedom <= 0:
            return 1.0
        ratio = (drop / (3 * self.k)) / ((rest + rows.floor(freedom)) / freedom)
        return count * float(fdtrc(3 * self.k, freedom, ratio))

    def weigh(self, rows: ErrorRows) -> FloatArray:
        """Probability of each set, if one of them is the set of the wrong points."""
        freedom = self.freedom(len(rows))
        log = -0.5 * self.sums if rows.scaled else -0.5 * freedom * np.log(self.sums + rows.floor(freedom))
        weight = np.exp(log - log.max())
        return np.asarray(weight / weight.sum())


def find_wrong(rows: ErrorRows) -> Contradiction:
    """Find the points that the others contradict."""
    found = _search(rows)
    if found.remains and rows.scaled:
        # the stated errors are too small for the rest, too: is there still a point that the residuals themselves name?
        relative = _search(rows.without_scale())
        if relative.named and not relative.remains:
            return Contradiction(relative.sets, relative.probabilities, relative.at_least, remains=True)
    return found


def _search(rows: ErrorRows) -> Contradiction:
    n, total = len(rows), rows.sum_of_squares()
    most = max(1, min((n - 1) // 2, n - 4))
    sets, stands_out = None, False
    single = 1.0 if most == 1 else SINGLE_SHARE
    for k in range(1, most + 1):
        sets = _sets_of(rows, k, sets)
        share = single if k == 1 or stands_out else SEVERAL_SHARES[k - 2]
        here = sets.chance(rows, total) < share * FALSE_ALARM and _is_off(rows, sets.left_out[0])
        stands_out = stands_out or here
        if here and _agrees(rows.select(np.delete(np.arange(n), sets.left_out[0]))):
            return _weighed(rows, sets)
        if not stands_out and k >= MOST_HIDDEN:
            break
    if not stands_out or sets is None:
        return NOTHING
    return Contradiction((), (), 2 if most > 1 else 1, remains=True)


def _weighed(rows: ErrorRows, sets: _Sets) -> Contradiction:
    probability = sets.weigh(rows)
    likely = np.flatnonzero(probability >= 0.05 * probability[0])[:6]
    if not sets.fixed[0]:  # the others do not fix a rotation, so they cannot judge
        return Contradiction((), (), sets.k, remains=False)
    named = tuple(tuple(int(i) for i in sets.left_out[j]) for j in likely)
    return Contradiction(named, tuple(float(probability[j]) for j in likely), sets.k, remains=False)


def _agrees(rest: ErrorRows) -> bool:
    """Tell whether points agree with each other, and with their stated errors."""
    n, total = len(rest), rest.sum_of_squares()
    level = FALSE_ALARM * (REST_SHARE if rest.scaled else REST_SHARE_UNSTATED)
    if rest.scaled and float(chdtrc(3 * n - 6, total)) < level:
        return False
    if n < 4 or (n < 5 and not rest.scaled):
        return True
    again = _sets_of(rest, 1, None)
    return not (again.chance(rest, total) < level and _is_off(rest, again.left_out[0]))


def _is_off(rows: ErrorRows, left_out: IntArray) -> bool:
    """Tell whether a point of a set lies further from the fit of the others than a controller's last digit."""
    keep = np.delete(np.arange(len(rows)), left_out)
    R, t = rows.select(keep).fit()
    off = rows.q[left_out] - rows.p[left_out] @ R.T - t
    return bool(np.linalg.norm(off, axis=1).max() > FLOOR_MM)


def _sets_of(rows: ErrorRows, k: int, smaller: _Sets | None) -> _Sets:
    """Leave out sets of k points; best first."""
    n = len(rows)
    if smaller is None or comb(n, k) <= MOST_SETS:
        left_out = np.array(list(combinations(range(n), k)))
    else:
        first = np.repeat(smaller.left_out[:EXTENDED], n, axis=0)
        new = np.tile(np.arange(n), len(smaller.left_out[:EXTENDED]))
        fresh = ~(first == new[:, None]).any(axis=1)
        left_out = np.unique(np.sort(np.column_stack([first, new])[fresh], axis=1), axis=0)
    return _of(rows, left_out)


def _of(rows: ErrorRows, left_out: IntArray) -> _Sets:
    """Fit without each of the sets, shape (m, k)."""
    n, k = len(rows), left_out.shape[1]
    keep = np.ones((len(left_out), n), dtype=bool)
    np.put_along_axis(keep, left_out, False, axis=1)
    rest = rows.select(np.nonzero(keep)[1].reshape(len(left_out), n - k))
    sums = rest.squares(*rest.fit()).sum(axis=1)
    order = np.argsort(sums, kind="stable")
    return _Sets(left_out[order], sums[order], rest.fixes_rotation()[order])


def weigh_one(rows: ErrorRows, left_out: tuple[int, ...]) -> Contradiction:
    """Weigh a set of wrong points that was found in another way against sets that differ from it in one point."""
    n, out = len(rows), np.array(left_out, dtype=np.int64)
    keep = np.delete(np.arange(n), out)
    least = int(np.argmin(rows.select(out).squares(*rows.select(keep).fit())))
    sets = np.vstack([out, *(np.where(np.arange(len(out)) == least, other, out) for other in keep)])
    found = _of(rows, sets)
    return _weighed(rows, found)
