"""Measure what several texts of one plan have in common once: a way within the digits of one that is free is free."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.planning.sequence.motion_check import MotionChecker

MOST_MM = 0.05  #: Texts of one plan differ less, by their digits.


@dataclass(frozen=True, slots=True, eq=False)
class _Way:
    """States that were measured and are free, shape (n, k), and least margins from each to the next, shape (n,), mm."""

    states: FloatArray
    margin_mm: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class FreeWays:
    """Checks rows of moves, and does not measure again what is nearer to a free row than that is to anything."""

    checker: MotionChecker
    _ways: list[_Way] = field(default_factory=list)

    def is_free(self, states: FloatArray, gaps: BoolArray) -> bool:
        """Tell whether moves are free. `states`, `gaps`: shapes (n, k) and (n - 1,). As of `MotionChecker.check`."""
        gaps = np.append(gaps, True)
        for way in self._ways:
            if way.states.shape == states.shape:
                is_open = ~self._is_within(way, states, gaps)
                kept = is_open | np.append(False, (is_open & ~gaps)[:-1])
                rows = np.flatnonzero(kept)
                apart = (np.diff(rows) > 1) | ~is_open[rows[:-1]] | gaps[rows[:-1]]
                return not len(rows) or self.checker.check(states[rows], gaps=apart).is_free
        found = self.checker.check(states, gaps=gaps[:-1])
        if found.is_free:
            starts = np.searchsorted(found.at, np.arange(len(states)))
            self._ways.append(_Way(states, np.minimum.reduceat(found.margin_mm, starts)))
        return found.is_free

    def _is_within(self, way: _Way, states: FloatArray, gaps: BoolArray) -> BoolArray:
        """Tell of each state and the move to the next whether bodies are nearer to the way than that is to others."""
        off_mm = self.checker.motion_mm(states, way.states)
        after = [np.where(gaps, each, np.append(each[1:], each[-1])) for each in (off_mm, way.margin_mm)]
        return np.asarray(np.maximum(off_mm, after[0]) < np.minimum(np.minimum(way.margin_mm, after[1]), MOST_MM))
