"""Dynamic programming over a ladder graph: the states of one place and one pair of branches at each rung, on a grid.

A rung is a point of the seam. Its states are attitudes (direction of travel, rotation of the joint, spin of the torch)
with the joints of both arms. If an angle may turn more than once, the state is listed once for each turn within the
limits, so that the robots can drive the cheapest way through the ladder. An edge costs the weighted squared joint steps
and a state the weighted squared deviation from its targets: the sum that `wpcal.planning.search.refine` then minimises.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.ladder import cheapest_way
from wpcal.core.same_bits import product
from wpcal.planning.cell.clearance import capsule_clearance
from wpcal.planning.cell.closed_chain import SPIN, TRAVEL, WORK, YAW, joints_along
from wpcal.planning.search.diagnosis import LEANS, Obstacle, attitudes_at, farthest_from_a_plan, left_reach, obstacle_at
from wpcal.planning.search.objectives import Weights, deviation_weights, deviations, joint_step_weight
from wpcal.planning.search.problem import CandidatePath, PlanningProblem
from wpcal.planning.search.reachable_states import ReachablePlace, usable_branches
from wpcal.robot.kinematics.inverse import with_whole_turns

RUNG_MM = 7.0  #: Target distance of rungs; a path between them is a straight line in the coordinates.
FEWEST_RUNGS, MOST_RUNGS = 8, 40  #: A short seam still has a shape. A long seam need not cost more than a second.
WORST_POINTS = 3  #: Points of a closed ladder that are tried with a leaning torch: each takes some tenths of a second.


@dataclass(frozen=True, slots=True, eq=False)
class Ladder:
    """The allowed states of all rungs."""

    reachable: ReachablePlace  #: Place of the weld point and branches of all states.
    rungs: IntArray  #: shape (r,). Points of the seam.
    coordinates: FloatArray  #: shape (a, 9). Attitudes; the states of any rung may have any of them.
    attitude: tuple[IntArray, ...]  #: Attitude of each state.
    joints: tuple[FloatArray, ...]  #: rad.


def build_ladder(problem: PlanningProblem, reachable: ReachablePlace, *, leaning: bool = False) -> Ladder:
    """Compute the states of a ladder; a rung may be left without any.

    `leaning`: Whether the torch leans at rungs that have no state at the target torch angles: by the least of some
    angles that gives a state.
    """
    count = int(np.clip(round(problem.path.s_mm[-1] / RUNG_MM) + 1, FEWEST_RUNGS, MOST_RUNGS))
    s_mm = problem.path.s_mm
    rungs = np.unique(np.abs(s_mm[:, None] - np.linspace(0.0, s_mm[-1], count)).argmin(axis=0))
    upright = attitudes_at(problem, reachable.place)
    tables, attitude, joints = [upright], *_states_at(problem, reachable, rungs, upright)
    for work, travel in _leans(problem) if leaning else ():
        empty = [row for row, states in enumerate(joints) if not len(states)]
        if not empty:
            break
        leant = upright.copy()
        leant[:, WORK], leant[:, TRAVEL] = work, travel
        first = len(upright) * len(tables)
        tables.append(leant)
        for row, found, states in zip(empty, *_states_at(problem, reachable, rungs[empty], leant), strict=True):
            attitude[row], joints[row] = found + first, states
    return Ladder(reachable, rungs, np.concatenate(tables), tuple(attitude), tuple(joints))


def _states_at(
    problem: PlanningProblem, reachable: ReachablePlace, rungs: IntArray, attitudes: FloatArray
) -> tuple[list[IntArray], list[FloatArray]]:
    """Return the allowed states of some rungs: which attitude each has, and its joints."""
    coordinates, rows = np.tile(attitudes, (len(rungs), 1)), np.repeat(rungs, len(attitudes))
    joints, usable = usable_branches(problem, coordinates, problem.path.select(rows))
    one, two = reachable.branches
    keep = np.flatnonzero(usable[0, :, one] & usable[1, :, two])
    both = np.concatenate([joints[0, keep, one], joints[1, keep, two]], axis=1)
    clear = capsule_clearance(problem.cell, both).is_clear
    keep, both = keep[clear], both[clear]
    state, turned = with_whole_turns(both, *problem.cell.limits)
    rung, attitude = np.divmod(keep[state], len(attitudes))
    split = [rung == i for i in range(len(rungs))]
    return [attitude[rows] for rows in split], [turned[rows] for rows in split]


def _leans(problem: PlanningProblem) -> list[tuple[float, float]]:
    """Return work and travel angles off their targets, rad; the smallest deviation first."""
    targets = problem.targets
    pairs = sorted(itertools.product(LEANS, LEANS), key=lambda pair: np.hypot(*pair))
    step = targets.torch_range_rad
    return [(targets.work_rad + step * a, targets.travel_rad + step * b) for a, b in pairs if (a, b) != (0.0, 0.0)]


def shortest_path(problem: PlanningProblem, ladder: Ladder, weights: Weights) -> CandidatePath | None:
    """Return the cheapest way along a ladder, filled in between the rungs; None if there is no way."""
    if min(len(joints) for joints in ladder.joints) == 0:
        return None
    path = _cheapest_way(problem, ladder, weights)
    return path if np.isfinite(path.joints).all() else None


def ladder_obstacle(problem: PlanningProblem, ladder: Ladder, weights: Weights) -> Obstacle | None:
    """Return what closes a ladder through which there is no way: its worst rung, or the gap between two rungs."""
    place, branches = ladder.reachable.place, ladder.reachable.branches
    empty = [int(rung) for rung, joints in zip(ladder.rungs, ladder.joints, strict=True) if not len(joints)]
    if not empty:
        path = _cheapest_way(problem, ladder, weights)
        return left_reach(
            problem, path, "every place that was tried along the seam is reached, but on the way between them "
        )
    # the worst point may be between two rungs
    near = [point for rung in empty for point in range(*_around(ladder.rungs, rung))]
    upright = {point: obstacle_at(problem, place, branches, point, leans=(0.0,)) for point in near}
    worst = []
    for _ in range(min(WORST_POINTS, len(upright))):
        found = farthest_from_a_plan(list(upright.values()))
        if found is None:
            break
        point = next(point for point, obstacle in upright.items() if obstacle is found)
        del upright[point]
        worst.append(obstacle_at(problem, place, branches, point))
    return farthest_from_a_plan(worst)


def _around(rungs: IntArray, rung: int) -> tuple[int, int]:
    """Return the points between the rungs before and after a rung, as first and end."""
    row = int(np.searchsorted(rungs, rung))
    first = int(rungs[row - 1]) + 1 if row > 0 else int(rungs[0])
    end = int(rungs[row + 1]) if row + 1 < len(rungs) else int(rungs[-1]) + 1
    return first, end


def _cheapest_way(problem: PlanningProblem, ladder: Ladder, weights: Weights) -> CandidatePath:
    """Return the cheapest way along a ladder without empty rungs; joints are NaN where it leaves the reach."""
    s = problem.path.s_mm[ladder.rungs]
    K = problem.cell.joint_weights
    scale = np.sqrt(joint_step_weight(weights) * K / (K.sum() * (s[-1] - s[0])))
    off = np.degrees(deviations(ladder.coordinates, problem.targets))
    state_cost = product(off**2, deviation_weights(weights)) / len(s)
    joints = [np.degrees(states) * scale for states in ladder.joints]
    way = cheapest_way(
        [state_cost[attitude] for attitude in ladder.attitude],
        lambda i, now, before: _squared_distances(joints[i][now], joints[i - 1][before]) / (s[i] - s[i - 1]),
    )
    return _filled_in(problem, ladder, way)


def _squared_distances(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return |a_i - b_j|², shape (len(a), len(b)): one matrix product; round-off is far below a grid step."""
    squares = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2.0 * product(a, b.T)
    return np.asarray(np.maximum(squares, 0.0), dtype=np.float64)


def _filled_in(problem: PlanningProblem, ladder: Ladder, way: list[int]) -> CandidatePath:
    """Draw straight lines in the coordinates between the rungs; joints are NaN where they leave the reach."""
    knots = np.stack([ladder.coordinates[a[i]] for a, i in zip(ladder.attitude, way, strict=True)])
    for column in (YAW, SPIN):
        knots[:, column] = np.unwrap(knots[:, column])
    s, branches = problem.path.s_mm, ladder.reachable.branches
    coordinates = np.stack([np.interp(s, s[ladder.rungs], column) for column in knots.T], axis=1)
    joints = joints_along(problem.cell, problem.path, coordinates, branches, ladder.joints[0][way[0]])
    return CandidatePath(coordinates, branches, joints)
