"""Moves through the air: straight in the axes where that is free, else found in a roadmap, shortened and proved.

The roadmap (`roadmap.Roadmap`) is kept for all moves of a plan. What is not found there is searched by RRT-Connect of
OMPL (Sucan, Moll, Kavraki: The Open Motion Planning Library, 2012; BSD), the optional package `ompl`. All random
numbers are seeded, and a search ends after a number of trials, never after a time, so that the same cell gives the same
moves. The axes are scaled by the motion they cause, so that a length is nearly the way of the outermost body. Every
move that is returned was proved by `MotionChecker`.

References
----------
Kuffner, LaValle, RRT-Connect: an efficient approach to single-query path planning, 2000.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError, InputError
from wpcal.planning.cell.cell import Cell
from wpcal.planning.sequence.motion_check import CheckedMove, MotionChecker
from wpcal.planning.sequence.order import LEAST_GAIN_S, axis_seconds
from wpcal.planning.sequence.roadmap import TRUST, Roadmap

MOST_TRIALS = 800  #: Trials of the planner before it gives up.
RANGE = 0.6  #: Longest branch of its trees: 600 mm of motion of the outermost body.
SCALE_MM = 1000.0  #: One unit of the scaled axes.
ROUNDS, SHORTCUTS = 5, 10
"""Rounds in which a way is shortened, and shortcuts of each kind per round: between its states, and between places on
it that are drawn at random."""


@dataclass(frozen=True, slots=True, eq=False)
class AirPath:
    """A free way through the air."""

    q: FloatArray  #: shape (n, k). Straight moves in the axes lead from state to state, rad and mm.
    check: CheckedMove
    found_by: str  #: ``straight``, ``roadmap`` or ``rrt-connect``.


class AirPlanner:
    """Finds free ways between states of a cell."""

    def __init__(self, cell: Cell, checker: MotionChecker, seed: int = 0) -> None:
        self.cell, self.checker, self.seed = cell, checker, seed
        self._roadmap = Roadmap(cell, checker, seed)
        self._scale = np.maximum(checker.per_axis, 1e-3) / SCALE_MM

    def path(self, start: FloatArray, end: FloatArray) -> AirPath:
        """Return a free way.

        `start`, `end`: shape (k,). All axes, rad and mm.
        Raises `GeometryError` when an end is in collision, or no way was found.
        Raises `InputError` when nothing is found in the roadmap and `ompl` is not installed.
        """
        self._require_clear(start, end)
        for between in ([], *self._by_home(start, end)):
            states = np.stack([start, *between, end])
            if (self.checker.free_shares(states[:-1], states[1:], whole=True, trust=TRUST) == 1.0).all():
                check = self.checker.check(states)
                if check.is_free:
                    return AirPath(states, check, "straight") if not between else self._shortened(states, "straight")
        way = self._roadmap.way(start, end)
        if way is not None:
            return self._shortened(way, "roadmap")
        return self._shortened(self._planned(start, end), "rrt-connect")

    def ways_from_home(self, ends: FloatArray) -> list[FloatArray]:
        """Return a free way from home to each of n states, shapes (m, k): straight, or over the roadmap; else empty.

        `ends`: shape (n, k). All axes, rad and mm.
        """
        home = self.cell.home
        straight = self.checker.free_shares(np.repeat(home[None], len(ends), axis=0), ends, whole=True) == 1.0
        ways = [
            np.stack([home, end]) if is_free else self._roadmap.way(home, end)
            for end, is_free in zip(ends, straight.tolist(), strict=True)
        ]
        return [np.zeros((0, len(home))) if way is None else self._fewest(way) for way in ways]

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

    def _require_clear(self, start: FloatArray, end: FloatArray) -> None:
        for name, q in (("start", start[None]), ("end", end[None])):
            if not self.checker.clearance.margins(q).is_clear[0]:
                raise GeometryError(f"the {name} of a move is in collision: {self.checker.nearest(q)}")

    def _shortened(self, way: FloatArray, found_by: str) -> AirPath:
        """Cut corners as long as all stays free: of many shortcuts that are checked together, those that save most."""
        rng = np.random.default_rng(self.seed)
        check = self.checker.check(way, again=True)
        for _ in range(ROUNDS if len(way) > 2 else 0):
            along = np.concatenate([[0.0], np.cumsum(self._seconds(way))])
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
        return AirPath(way, check, found_by)

    def _seconds(self, way: FloatArray) -> FloatArray:
        return axis_seconds(way[:-1], way[1:], self.cell.speeds)

    def _planned(self, start: FloatArray, end: FloatArray) -> FloatArray:
        base, geometric, util = import_ompl()
        util.setLogLevel(util.LOG_NONE)  # it complains when it is seeded again
        util.RNG.setSeed(self.seed + 1)
        k = len(start)
        space = base.RealVectorStateSpace(k)
        bounds = base.RealVectorBounds(k)
        low, high = self.cell.limits
        for axis in range(k):
            bounds.setLow(axis, float(low[axis] * self._scale[axis]))
            bounds.setHigh(axis, float(high[axis] * self._scale[axis]))
        space.setBounds(bounds)
        information = base.SpaceInformation(space)
        scale, checker = self._scale, self.checker

        def values(state: Any) -> FloatArray:
            return np.array([state[axis] for axis in range(k)]) / scale

        class Motions(base.MotionValidator):  # type: ignore[misc,name-defined]  # OMPL has no types
            def checkMotion(self, one: Any, other: Any, *_: Any) -> bool:  # OMPL's name
                return checker.is_free(values(one), values(other))

        information.setStateValidityChecker(
            lambda state: bool(checker.clearance.margins(values(state)[None]).is_clear[0])
        )
        motions = Motions(information)
        information.setMotionValidator(motions)
        information.setup()
        problem = base.ProblemDefinition(information)
        ends = space.allocState(), space.allocState()
        for state, q in zip(ends, (start, end), strict=True):
            for axis in range(k):
                state[axis] = float(q[axis] * scale[axis])
        problem.setStartAndGoalStates(*ends)
        planner = geometric.RRTConnect(information)
        planner.setRange(RANGE)
        planner.setProblemDefinition(problem)
        planner.setup()
        trials = iter(range(MOST_TRIALS))
        planner.solve(base.PlannerTerminationCondition(lambda: next(trials, None) is None))
        if not problem.hasExactSolution():
            raise GeometryError(f"no free way was found in {MOST_TRIALS} trials")
        found = problem.getSolutionPath()
        between = [values(found.getState(row)) for row in range(1, found.getStateCount() - 1)]
        return np.array([start, *between, end])


def import_ompl() -> tuple[Any, Any, Any]:
    """Return the modules `base`, `geometric` and `util` of OMPL.

    Raises `InputError` when `ompl` is not installed.
    """
    try:
        from ompl import base, geometric, util  # noqa: PLC0415  # an optional package, needed where a way is blocked
    except ImportError:
        raise InputError(
            "no free way was found in the roadmap, and the search for another needs the package ompl: "
            "pip install 'wpcal[planning]'"
        ) from None
    return base, geometric, util
