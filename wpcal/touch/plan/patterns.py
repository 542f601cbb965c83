"""The best set of touches of a pattern: any set, 3-2-1, or three points."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import GeometryError
from wpcal.touch.design import SetSearch, farthest_rows
from wpcal.touch.plan.choose import TouchDesign, best_set
from wpcal.touch.plan.options import Pattern, TouchOptions

SAME_SIDE_COS = 0.97  #: Faces within 14 degrees are one side of the part.
ACROSS_COS = 0.5  #: Two sides of a pattern are 60 degrees or more apart.
MOST_SIDES = 6  #: Sides that are tried, those with the most places to touch: six of a box.
MOST_PER_SIDE = 40  #: Touches of a side, far from one another: all choices of three sides are tried.
PLACE_MM = 120.0  #: Touches of one place of the three-point pattern are at most this far apart.
MOST_PARTNERS = 3  #: For each touch of a place so many of the other sides are tried, the nearest.


def choose_touches(design: TouchDesign, p: FloatArray, normal: FloatArray, options: TouchOptions) -> IntArray:
    """Return the touches of the pattern that is asked for, with the least predicted error, shape (k,).

    `p`, `normal`: shape (n, 3). Of the touches, in `part`.
    Raises `GeometryError` when the part has no set of the pattern that holds all six freedoms.
    """
    rng = np.random.default_rng(options.seed)
    if options.pattern is Pattern.BEST:
        return best_set(design, min(options.count(), len(design)), slots=None, rng=rng)[0]
    if options.pattern is Pattern.THREE_TWO_ONE:
        found = _three_two_one(design, p, normal, rng)
    else:
        found = _three_point(design, p, normal, rng)
    if len(found) == 0:
        raise GeometryError(
            f"the part has no touches of the pattern {options.pattern} that hold all six freedoms; leave the pattern "
            "away"
        )
    return found


def _sides(p: FloatArray, normal: FloatArray) -> list[IntArray]:
    """Return touches by sides of the part, those with most of them first."""
    left, sides = np.arange(len(normal)), list[IntArray]()
    while len(left) and len(sides) < MOST_SIDES:
        near = normal[left] @ normal[left].T >= SAME_SIDE_COS
        best = int(np.argmax(near.sum(axis=1)))
        side = left[near[best]]
        sides.append(side[np.sort(farthest_rows(p[side], MOST_PER_SIDE))])
        left = left[~near[best]]
    return sides


def _three_two_one(design: TouchDesign, p: FloatArray, normal: FloatArray, rng: np.random.Generator) -> IntArray:
    sides = _sides(p, normal)
    best, least = np.zeros(0, dtype=np.int64), np.inf
    for a, b, c in permutations(range(len(sides)), 3):
        ways = [normal[sides[k]].mean(axis=0) for k in (a, b, c)]
        if max(abs(ways[0] @ ways[1]), abs(ways[0] @ ways[2]), abs(ways[1] @ ways[2])) > ACROSS_COS:
            continue
        if len(sides[a]) < 3 or len(sides[b]) < 2:
            continue
        slots = [sides[a]] * 3 + [sides[b]] * 2 + [sides[c]]
        rows, error = best_set(design, 6, slots=slots, rng=rng)
        if error < least:
            best, least = rows, error
    return best


@dataclass(frozen=True, slots=True, eq=False)
class _Places:
    """Pairs of touches at one place: the judge of sets of places."""

    design: TouchDesign
    pairs: IntArray

    def largest_errors(self, rows: IntArray, /) -> FloatArray:
        """Return the error of sets of places, shape (m, n); a touch may not be in two of them."""
        touches = self.pairs[rows].reshape(len(rows), -1)
        error = self.design.largest_errors(touches)
        ordered = np.sort(touches, axis=1)
        error[(np.diff(ordered, axis=1) == 0).any(axis=1)] = np.inf
        return error


def _three_point(design: TouchDesign, p: FloatArray, normal: FloatArray, rng: np.random.Generator) -> IntArray:
    across = np.abs(normal @ normal.T) <= ACROSS_COS
    distance = np.linalg.norm(p[:, None] - p[None], axis=2)
    pairs = list[tuple[int, int]]()
    for i in range(len(p)):
        partners = np.flatnonzero(across[i] & (distance[i] <= PLACE_MM))
        near = partners[np.argsort(distance[i, partners], kind="stable")[:MOST_PARTNERS]]
        pairs += [(min(i, int(j)), max(i, int(j))) for j in near]
    unique = np.unique(np.array(pairs, dtype=np.int64).reshape(-1, 2), axis=0)
    if len(unique) < 3:
        return np.zeros(0, dtype=np.int64)
    rows, _ = SetSearch(_Places(design, unique), len(unique)).exchanged(3, rng=rng, starts=4)
    return np.zeros(0, dtype=np.int64) if len(rows) == 0 else unique[rows[0]].ravel()
