"""Moves through the air: straight in the axes where that is free, else found by RRT-Connect, shortened and checked.

The planner is OMPL (Sucan, Moll, Kavraki: The Open Motion Planning Library, 2012; BSD), the optional package `ompl`,
imported when the first move needs it. Its random numbers are seeded and it ends after a number of trials, never after a
time, so that the same cell gives the same moves. The axes are scaled by the motion they cause, so that a length is
nearly the way of the outermost body. Every move that is returned was proved by `MotionChecker`.

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
from wpcal.planning.cell.one_robot import OneRobotCell
from wpcal.planning.sequence.motion_check import CheckedMove, MotionChecker

MOST_TRIALS = 3000
"""Trials of the planner before it gives up."""
RANGE = 0.6
"""Longest branch of its trees: 600 mm of motion of the outermost body."""
SCALE_MM = 1000.0
"""One unit of the scaled axes."""
SHORTCUTS = 16
"""Trials to shorten a way."""


@dataclass(frozen=True, slots=True, eq=False)
class AirPath:
    """A free way through the air.

    Parameters
    ----------
    q : ndarray, shape (n, k)
        Straight moves in the axes lead from state to state, rad and mm.
    check : CheckedMove
    found_by : str
        ``straight`` or ``rrt-connect``.
    """

    q: FloatArray
    check: CheckedMove
    found_by: str


class AirPlanner:
    """Finds free ways between states of a cell.

    Parameters
    ----------
    cell : OneRobotCell
    checker : MotionChecker
    seed : int
        Of all random numbers.
    """

    def __init__(self, cell: OneRobotCell, checker: MotionChecker, seed: int = 0) -> None:
        self.cell, self.checker, self.seed = cell, checker, seed
        self._scale = np.maximum(checker.per_axis, 1e-3) / SCALE_MM

    def path(self, start: FloatArray, end: FloatArray) -> AirPath:
        """Return a free way.

        Parameters
        ----------
        start, end : ndarray, shape (k,)
            All axes, rad and mm.

        Returns
        -------
        AirPath

        Raises
        ------
        GeometryError
            When an end is in collision, or no way was found.
        InputError
            When a straight move is not free and `ompl` is not installed.
        """
        self._require_clear(start, end)
        check = self.checker.check(np.stack([start, end]))
        if check.is_free:
            return AirPath(np.stack([start, end]), check, "straight")
        for between in self._by_home(start, end):
            way = np.stack([start, *between, end])
            check = self.checker.check(way)
            if check.is_free:
                return self._shortened(way, "straight")
        return self._shortened(self._planned(start, end), "rrt-connect")

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
        found = self.checker.clearance.margins(np.stack([start, end]))
        for name, row in (("start", 0), ("end", 1)):
            if not found.is_clear[row]:
                one, two = self.checker.clearance.names(int(found.pair[row]))
                raise GeometryError(
                    f"the {name} of a move is in collision: {one} and {two} miss their safety distance by "
                    f"{-found.margin_mm[row]:.1f} mm"
                )

    def _shortened(self, way: FloatArray, found_by: str) -> AirPath:
        """Leave out states, and cut corners at random places, as long as all stays free."""
        rng = np.random.default_rng(self.seed)
        way = self._fewer(way)
        for _ in range(SHORTCUTS if len(way) > 2 else 0):
            length = np.linalg.norm(np.diff(way, axis=0) * self._scale, axis=1)
            along = np.concatenate([[0.0], np.cumsum(length)])
            a, b = np.sort(rng.uniform(0.0, along[-1], 2))
            i, j = (int(np.clip(np.searchsorted(along, x) - 1, 0, len(way) - 2)) for x in (a, b))
            if i == j:
                continue
            p, q = (
                way[row] + (x - along[row]) / max(length[row], 1e-12) * (way[row + 1] - way[row])
                for row, x in ((i, a), (j, b))
            )
            if self.checker.is_free(p, q):
                way = np.concatenate([way[: i + 1], [p, q], way[j + 1 :]])
        way = self._fewer(way)
        return AirPath(way, self.checker.check(way), found_by)

    def _fewer(self, way: FloatArray) -> FloatArray:
        """Leave out states that are not needed, the farthest jump first."""
        kept, row = [way[0]], 0
        while row < len(way) - 1:
            step = next(
                k for k in range(len(way) - 1, row, -1) if k == row + 1 or self.checker.is_free(way[row], way[k])
            )
            kept.append(way[step])
            row = step
        return np.array(kept)

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

    Raises
    ------
    InputError
        When `ompl` is not installed.
    """
    try:
        from ompl import base, geometric, util  # noqa: PLC0415  # an optional package, needed where a way is blocked
    except ImportError:
        raise InputError(
            "a straight move between two seams is blocked, and the search for another needs the package ompl: "
            "pip install 'wpcal[planning]'"
        ) from None
    return base, geometric, util
