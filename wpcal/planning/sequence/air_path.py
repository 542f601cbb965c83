"""Moves through the air: straight in the axes where that is free, else found in a roadmap, shortened and proved.

The roadmap (`roadmap.Roadmap`) is kept for all moves of a plan. All random numbers are seeded, so that the same cell
gives the same moves. Every move that is returned was proved by `MotionChecker`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.errors import GeometryError
from wpcal.planning.cell.cell import Cell
from wpcal.planning.sequence.motion_check import CheckedMove, MotionChecker
from wpcal.planning.sequence.order import LEAST_GAIN_S, axis_seconds
from wpcal.planning.sequence.roadmap import MOST_ROUNDS, TRUST, Roadmap

ROUNDS, SHORTCUTS = 5, 10
"""Rounds in which a way is shortened, and shortcuts of each kind per round: between its states, and between places on
it that are drawn at random."""


@dataclass(frozen=True, slots=True, eq=False)
class AirPath:
    """A free way through the air."""

    q: FloatArray  #: shape (n, k). Straight moves in the axes lead from state to state, rad and mm.
    check: CheckedMove


class AirPlanner:
    """Finds free ways between states of a cell; with `closer`, of smaller distances, those of states too near."""

    def __init__(self, cell: Cell, checker: MotionChecker, seed: int = 0, closer: AirPlanner | None = None) -> None:
        self.cell, self.checker, self.seed, self.closer = cell, checker, seed, closer
        self._roadmap = Roadmap(cell, checker, seed)

    def path(self, start: FloatArray, end: FloatArray) -> AirPath:
        """Return a free way.

        `start`, `end`: shape (k,). All axes, rad and mm.
        Raises `GeometryError` when an end is in collision, or no way was found.
        """
        if self.closer is not None and not self._clear(np.stack([start, end])).all():
            return self.closer.path(start, end)
        self._require_clear(start, end)
        for between in ([], *self._by_home(start, end)):
            states = np.stack([start, *between, end])
            if (self.checker.free_shares(states[:-1], states[1:], whole=True, trust=TRUST) == 1.0).all():
                check = self.checker.check(states)
                if check.is_free:
                    return self._shortened(states) if between else AirPath(states, check)
        way = self._roadmap.way(start, end)
        if way is None:
            raise GeometryError(f"no free way was found in {MOST_ROUNDS} rounds of the roadmap")
        return self._shortened(way)

    def ways_from_home(self, ends: FloatArray) -> list[FloatArray]:
        """Return a free way from home to each of n states, shapes (m, k): straight, or over the roadmap; else empty.

        `ends`: shape (n, k). All axes, rad and mm.
        """
        if self.closer is not None and not (clear := self._clear(ends)).all():
            by_room = {
                True: iter(self.ways_from_home(ends[clear])),
                False: iter(self.closer.ways_from_home(ends[~clear])),
            }
            return [next(by_room[has_room]) for has_room in clear.tolist()]
        home = self.cell.home
        straight = self.checker.free_shares(np.repeat(home[None], len(ends), axis=0), ends, whole=True) == 1.0
        ways = [
            np.stack([home, end]) if is_free else self._roadmap.way(home, end)
            for end, is_free in zip(ends, straight.tolist(), strict=True)
        ]
        return [np.zeros((0, len(home))) if way is None else self._fewest(way) for way in ways]

    def shuts(self, q: FloatArray) -> bool:
        """Tell whether a state, shape (k,), is shut in: a way between its surroundings and those of home was sought."""
        own = self if self.closer is None or self._clear(q[None]).all() else self.closer
        return own._roadmap.is_shut_in(q, self.cell.home)

    def _fewest(self, way: FloatArray) -> FloatArray:
        """Return the states of a free way that are needed: the first, and then always the farthest straight on."""
        pairs = np.array([(i, j) for i in range(len(way)) for j in range(i + 2, len(way))], dtype=int).reshape(-1, 2)
        free = self.checker.free_shares(way[pairs[:, 0]], way[pairs[:, 1]], whole=True) == 1.0
        farthest = np.arange(1, len(way))
        np.maximum.at(farthest, *pairs[free].T)
        kept = [0]
        while kept[-1] < len(farthest):
            kept.append(int(farthest[kept[-1]]))
        return way[kept]

    def _by_home(self, start: FloatArray, end: FloatArray) -> list[list[FloatArray]]:
        """Return states that a way may go through: the arm half-way home, and at home, while the part turns."""
        arm, home = slice(0, 6), self.cell.home
        found = []
        for share in (0.4, 1.0):
            at = [q.copy() for q in (start, end)]
            for q in at:
                q[arm] += share * (home[arm] - q[arm])
            found.append(at)
        return found

    def _clear(self, q: FloatArray) -> BoolArray:
        return self.checker.clearance.margins(q).is_clear

    def _require_clear(self, start: FloatArray, end: FloatArray) -> None:
        for name, q in (("start", start[None]), ("end", end[None])):
            if not self._clear(q)[0]:
                raise GeometryError(f"the {name} of a move is in collision: {self.checker.nearest(q)}")

    def _shortened(self, way: FloatArray) -> AirPath:
        """Cut corners as long as all stays free: of many shortcuts that are checked together, those that save most."""
        rng = np.random.default_rng(self.seed)
        check = self.checker.check(way, again=True)
        for _ in range(ROUNDS if len(way) > 2 else 0):
            along = np.concatenate([[0.0], np.cumsum(axis_seconds(way[:-1], way[1:], self.cell.speeds))])
            from_to = np.sort(rng.uniform(0.0, along[-1], (SHORTCUTS, 2)), axis=1)
            jumps = [(along[i], along[j]) for i in range(len(way)) for j in range(i + 2, len(way))]
            jumps.sort(key=lambda jump: jump[0] - jump[1])  # the farthest first
            from_to = np.concatenate([np.reshape(jumps[:SHORTCUTS], (-1, 2)), from_to])
            a, b = (np.stack([np.interp(t, along, axis) for axis in way.T], axis=1) for t in from_to.T)
            saved = from_to[:, 1] - from_to[:, 0] - axis_seconds(a, b, self.cell.speeds)
            rows = np.flatnonzero(saved > LEAST_GAIN_S)
            rows = rows[self.checker.free_shares(a[rows], b[rows], whole=True, trust=TRUST) == 1.0]
            if not len(rows):
                continue
            taken: list[int] = []
            for row in rows[np.argsort(-saved[rows], kind="stable")].tolist():
                if all(from_to[row, 0] >= from_to[k, 1] or from_to[row, 1] <= from_to[k, 0] for k in taken):
                    taken.append(row)
            taken = [k for k in taken if self.checker.is_free(a[k], b[k])]
            if not taken:
                continue
            inside = [((along > from_to[k, 0]) & (along < from_to[k, 1])) for k in taken]
            keep = ~np.any(inside, axis=0)
            t = np.concatenate([along[keep], from_to[taken].ravel()])
            q = np.concatenate([way[keep], *([a[k], b[k]] for k in taken)])
            _, first = np.unique(np.round(t, 9), return_index=True)
            found = self.checker.check(q[first], again=True)
            if not found.is_free:  # what is left of a move is divided at other places
                break
            way, check = q[first], found
            if len(way) == 2:
                break
        return AirPath(way, check)
