"""Where both robots reach the seam: places of the weld point and branches of the inverses to start a search from.

Places between the bases are scanned on a coarse grid, with all directions of travel, all spins of the torch and some
points of the seam, at the target weld position and torch angles. If no place is found, the scan is repeated with other
rotations of the joint.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import GeometryError
from wpcal.planning.cell.clearance import Clearance, capsule_clearance
from wpcal.planning.cell.closed_chain import PLACE, ROTATION, SPIN, YAW, SeamPath, all_joints, flange_poses
from wpcal.planning.cell.workplace import candidate_places, is_usable, least_shortage
from wpcal.planning.search.diagnosis import (
    ROTATIONS_RAD,
    NoFeasiblePlanError,
    Obstacle,
    allowed_rotations,
    clearance_advice,
    obstacle_at,
    too_near,
)
from wpcal.planning.search.objectives import target_coordinates
from wpcal.planning.search.problem import PlanningProblem
from wpcal.robot.kinematics.inverse import TURN
from wpcal.robot.kinematics.opw import BRANCHES

TURNS = 8  #: Number of directions of travel, and number of spins of the torch.
SCANNED_POINTS = 6  #: Points of the seam, from its first to its last.
CHECKED_PLACES, CHECKED = 6, 96
"""Clearance is measured at this many best places of each pair of branches, and at this many best of all these. It takes
some tenths of a second."""


@dataclass(frozen=True, slots=True, eq=False)
class ReachablePlace:
    """A place of the weld point and a pair of branches that have an allowed state at every scanned point."""

    place: FloatArray  #: shape (3,). In `middle`, mm.
    branches: tuple[int, int]  #: Of robot 1 and robot 2.
    allowed: int  #: Number of allowed states at the scanned point that has fewest.


def usable_branches(problem: PlanningProblem, coordinates: FloatArray, path: SeamPath) -> tuple[FloatArray, BoolArray]:
    """Return all joints at N points, and which branches are within limits and away from singular poses.

    `coordinates`: ndarray, shape (N, 9).
    Returns `joints`: ndarray, shape (2, N, 8, 6). Robot 1 and robot 2, rad, in the turn around zero.
    Returns `usable`: ndarray of bool, shape (2, N, 8).
    """
    joints = np.stack(all_joints(problem.cell, path, coordinates))
    usable = [is_usable(arm, q) for arm, q in zip((problem.cell.arm, problem.cell.arm2), joints, strict=True)]
    return joints, np.stack(usable)


def find_reachable_places(problem: PlanningProblem, count: int) -> list[ReachablePlace]:
    """Return the most promising places with their branches, best first; each pair of branches appears once.

    Raises `GeometryError` when a point of the seam is out of reach, or every state at its start is in collision.
    Raises `NoFeasiblePlanError` when no place and branches have an allowed state at every scanned point; it names the
    limit and the place.
    """
    try:
        return _places_of_scan(problem, count, _Scan.of(problem, ROTATIONS_RAD[:1]))
    except (NoFeasiblePlanError, GeometryError):  # perhaps only the target rotation cannot be reached
        return _places_of_scan(problem, count, _Scan.of(problem, ROTATIONS_RAD))


def _places_of_scan(problem: PlanningProblem, count: int, scan: _Scan) -> list[ReachablePlace]:
    places = candidate_places(problem.cell)
    joints, usable = scan.solve(problem, places)
    _require_reach(problem, scan, places, joints)
    # states (place, point, turns) of each pair of branches: products of the two tables of usable ones
    one, two = usable.reshape(2, len(places), SCANNED_POINTS, -1, BRANCHES).astype(np.int64)
    pairs = np.einsum("pkta,pktb->pabk", one, two)
    fewest = pairs.min(axis=3)
    ranked = np.argsort(np.argsort(-fewest, axis=0, kind="stable"), axis=0)  # rank of a place for its branches
    fewest[ranked >= CHECKED_PLACES] = 0
    order = np.argsort(-fewest, axis=None, kind="stable")[:CHECKED]
    states = [
        _states(joints, usable, len(places), *np.unravel_index(i, fewest.shape)) for i in order if fewest.flat[i] > 0
    ]
    if not states:
        raise NoFeasiblePlanError(
            "joint limits and singular poses fail most; nowhere do both robots keep off them at every point of the "
            "seam",
            _limit_obstacle(problem, scan, places, pairs),
        )
    clear = capsule_clearance(problem.cell, np.concatenate(np.concatenate([s.joints for s in states], axis=1), axis=1))
    _require_clear_start(states, clear)
    best = _best(places, states, clear.is_clear, count)
    if not best:
        raise NoFeasiblePlanError(
            "clearance fails most; from no place is every point of the seam clear",
            _clearance_obstacle(problem, scan, places, states, clear),
        )
    return best


def _limit_obstacle(problem: PlanningProblem, scan: _Scan, places: FloatArray, pairs: FloatArray) -> Obstacle | None:
    """Return what closes the place and branches that have usable states at most points of the seam.

    `pairs` has the number of usable states of each place, of the branches of both robots, and of each scanned point.
    """
    place, one, two = np.unravel_index(int(np.argmax((pairs > 0).sum(axis=3))), pairs.shape[:3])
    row = int(np.argmin(pairs[place, one, two]))
    return obstacle_at(problem, places[place], (int(one), int(two)), int(scan.points[row]))


def _clearance_obstacle(
    problem: PlanningProblem, scan: _Scan, places: FloatArray, states: list[_States], clear: Clearance
) -> Obstacle:
    """Return the two bodies that are too near at the worst point of the place that is nearest to a plan."""
    best, start = (-np.inf, 0, states[0]), 0
    for s in states:
        margins = np.full(SCANNED_POINTS, -np.inf)
        np.maximum.at(margins, s.point, clear.margin_mm[start : start + len(s.point)])
        worst = int(np.argmin(margins))
        if margins[worst] > best[0]:
            at = start + np.flatnonzero(s.point == worst)
            best = (float(margins[worst]), int(at[np.argmax(clear.margin_mm[at])]), s)
        start += len(s.point)
    margin, row, s = best
    point = int(scan.points[int(np.concatenate([t.point for t in states])[row])])
    found = obstacle_at(problem, places[s.place], s.branches, point)
    if found is not None:
        return found
    between, distance = clear.nearest(row), float(clear.distance_mm[row])
    advice = clearance_advice(problem, between, distance)
    return too_near(between, float(problem.path.s_mm[point]), distance, distance - margin, advice)


@dataclass(frozen=True, slots=True, eq=False)
class _Scan:
    """Points, rotations and turns that are tried at every place: K rows, point by point."""

    path: SeamPath
    coordinates: FloatArray
    point: IntArray

    @property
    def points(self) -> IntArray:
        """The scanned points of the seam, shape (SCANNED_POINTS,)."""
        rows = len(self.point) // SCANNED_POINTS
        return self.point[::rows]

    @classmethod
    def of(cls, problem: PlanningProblem, rotations_rad: Sequence[float]) -> _Scan:
        turns = TURN * np.arange(TURNS) / TURNS
        points = np.linspace(0, len(problem.path) - 1, SCANNED_POINTS).round().astype(np.int64)
        grid = np.meshgrid(allowed_rotations(problem.targets, rotations_rad), turns, turns, indexing="ij")
        rotation, yaw, spin = (np.tile(values.ravel(), SCANNED_POINTS) for values in grid)
        point = np.repeat(points, grid[0].size)
        coordinates = target_coordinates(problem.targets, len(point))
        coordinates[:, ROTATION], coordinates[:, YAW], coordinates[:, SPIN] = rotation, yaw, spin
        return cls(problem.path.select(point), coordinates, point)

    def solve(self, problem: PlanningProblem, places: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return joints (2, P·K, 8, 6) and usable (2, P·K, 8) at all places."""
        coordinates = np.tile(self.coordinates, (len(places), 1))
        coordinates[:, PLACE] = np.repeat(places, len(self.point), axis=0)
        rows = np.tile(np.arange(len(self.point)), len(places))
        return usable_branches(problem, coordinates, self.path.select(rows))


@dataclass(frozen=True, slots=True, eq=False)
class _States:
    """The usable states of one place and pair of branches."""

    place: int
    branches: tuple[int, int]
    joints: FloatArray  #: (2, k, 6)
    point: IntArray  #: (k,), 0 … SCANNED_POINTS - 1


def _states(joints: FloatArray, usable: BoolArray, places: int, place: np.intp, one: np.intp, two: np.intp) -> _States:
    per_place = joints.shape[1] // places
    rows = slice(int(place) * per_place, (int(place) + 1) * per_place)
    both = np.flatnonzero(usable[0, rows, one] & usable[1, rows, two])
    chosen = np.stack([joints[0, rows, one][both], joints[1, rows, two][both]])
    return _States(int(place), (int(one), int(two)), chosen, both // (per_place // SCANNED_POINTS))


def _require_reach(problem: PlanningProblem, scan: _Scan, places: FloatArray, joints: FloatArray) -> None:
    """Refuse a seam if both arms reach one of its points from no place; name the point, the arm and the distance."""
    reached = np.any(np.isfinite(joints).all(axis=3), axis=2)  # (2, P·K)
    per_point = (reached[0] & reached[1]).reshape(len(places), SCANNED_POINTS, -1).any(axis=(0, 2))
    if per_point.all():
        return
    row = int(np.argmin(per_point))
    point = int(scan.points[row])
    coordinates = np.repeat(scan.coordinates[scan.point == point], len(places), axis=0)
    coordinates[:, PLACE] = np.tile(places, (int((scan.point == point).sum()), 1))
    flanges = flange_poses(problem.cell, problem.path.select(np.full(len(coordinates), point)), coordinates)
    robot, short_mm = least_shortage(problem.cell, flanges)
    name = (problem.cell.arm, problem.cell.arm2)[robot].name
    raise GeometryError(
        f"seam {problem.path.name}, point {point + 1} (s = {problem.path.s_mm[point]:.1f} mm): out of reach of robot "
        f"{robot + 1} ({name}) by {short_mm:.0f} mm at the best place between the robots"
    )


def _require_clear_start(states: list[_States], clear: Clearance) -> None:
    """Refuse a seam whose first point cannot be reached without a collision."""
    start = np.flatnonzero(np.concatenate([s.point for s in states]) == 0)
    if clear.is_clear[start].any():
        return
    best = int(start[np.argmax(clear.margin_mm[start])])
    one, two = clear.nearest(best)
    distance, margin = clear.distance_mm[best], clear.margin_mm[best]
    raise GeometryError(
        f"every state at the start of the seam is in collision; at best {one} and {two} miss their safety distance by "
        f"{-margin:.1f} mm ({distance:.1f} mm, {distance - margin:g} mm asked)"
    )


def _best(places: FloatArray, states: list[_States], clear: BoolArray, count: int) -> list[ReachablePlace]:
    """Keep the best place of each pair of branches; rank them by the allowed states at the point that has fewest."""
    ends = np.cumsum([len(s.point) for s in states])
    found: dict[tuple[int, int], ReachablePlace] = {}
    for s, end in zip(states, ends, strict=True):
        allowed = np.bincount(s.point[clear[end - len(s.point) : end]], minlength=SCANNED_POINTS).min()
        if allowed > 0 and (s.branches not in found or found[s.branches].allowed < allowed):
            found[s.branches] = ReachablePlace(places[s.place], s.branches, int(allowed))
    return sorted(found.values(), key=lambda place: -place.allowed)[:count]
