"""Why a point of the seam, a ladder or a set of paths has no allowed state: the limit that is hardest to keep there.

The states of one point are filtered by one limit after another: reach, joint limits, singular poses, clearance. The
first limit that leaves no state is the obstacle, with the best value that any state attains. The torch may lean here
within its range, so that a distance named as the best is not only that of the target torch angles.

Also here: `Obstacle`: what keeps a seam from being planned, where, and by how much; `NoFeasiblePlanError` carries it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from enum import Enum
from typing import Any

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.errors import ConvergenceError
from wpcal.planning.cell.clearance import Clearance, capsule_clearance
from wpcal.planning.cell.closed_chain import PLACE, ROTATION, SPIN, TRAVEL, WORK, YAW, all_joints, flange_poses
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.cell.workplace import LEAST_REGULARITY, least_shortage
from wpcal.planning.search.objectives import WeldTargets, target_coordinates
from wpcal.planning.search.problem import CandidatePath, PlanningProblem
from wpcal.robot.kinematics.inverse import TURN


class Constraint(Enum):
    """A kind of limit, by the name that messages and records give it."""

    REACH = "reach"
    JOINT_LIMITS = "joint limits"
    SINGULAR_POSES = "singular poses"
    CLEARANCE = "clearance"
    TORCH_ANGLES = "torch angles"
    WELD_POSITION = "weld position"
    WELD_ZONE = "weld zone"
    JOINT_SPEEDS = "joint speeds"


@dataclass(frozen=True, slots=True, kw_only=True)
class Obstacle:
    """The limit that is hardest to keep."""

    constraint: Constraint
    says: str  #: What was found, where, and what was asked, for people.
    advice: str = ""  #: The relaxation that would help; empty if none is known.
    s_mm: float | None = None  #: Place along the seam, mm.
    between: tuple[str, str] | None = None  #: Two bodies that are too near to each other.
    robot: int | None = None  #: 1 or 2.
    joint: str | None = None  #: Name on the pendant.
    #: `best`, `asked`: The best value that was attained at this place, and the value that is asked, in `unit`.
    best: float | None = None
    asked: float | None = None
    unit: str = ""  #: ``mm``, ``deg``, ``mm/s``, or empty.

    def describe(self) -> str:
        """Say what was found and what would help."""
        return f"{self.says}; {self.advice}" if self.advice else self.says

    def to_record(self) -> dict[str, Any]:
        """Return plain values for ``pareto.json``."""
        return asdict(self) | {"constraint": self.constraint.value}


class NoFeasiblePlanError(ConvergenceError):
    """The search found no feasible plan."""

    def __init__(self, why: str, obstacle: Obstacle | None = None) -> None:
        self.obstacle = obstacle
        found = "" if obstacle is None else f": {obstacle.describe()}"
        super().__init__(f"no feasible plan: {why}{found}")


def too_near(between: tuple[str, str], s_mm: float, best_mm: float, asked_mm: float, advice: str = "") -> Obstacle:
    """Return the obstacle of two bodies that do not keep their distance.

    `s_mm`: Place along the seam, mm.
    `best_mm`, `asked_mm`: Largest distance that was attained there, and the safety distance, mm. Capsules that overlap
    have a negative distance.
    """
    one, two = between
    found = f"{best_mm:.1f} mm" if best_mm >= 0 else f"overlapping by {-best_mm:.1f} mm"
    return Obstacle(
        constraint=Constraint.CLEARANCE,
        says=f"{one} and {two}: at best {found} at s = {s_mm:.1f} mm, {asked_mm:g} mm asked",
        advice=advice,
        s_mm=s_mm,
        between=between,
        best=best_mm,
        asked=asked_mm,
        unit="mm",
    )


LEANS = (0.0, -1.0, -0.5, 0.5, 1.0)
"""Work and travel angles that are tried, as parts of their range; the targets first."""
YAWS, SPINS = 12, 8
"""Directions of travel and spins of the torch. The steps are coarse; the least squares of the search remove them."""
ROTATIONS_RAD = tuple(np.radians((0.0, -50.0, -25.0, 25.0, 50.0)))
"""Rotations of the joint relative to the target, the target first. A part that cannot turn enough needs the others."""
SINGULAR = ("the wrist is nearly straight", "the elbow is nearly stretched", "the wrist is nearly above axis 1")
"""The three measures of `wpcal.planning.cell.workplace`, in words."""
NEARER = "move the bases nearer, or hold the part differently"  #: Advice where a robot does not reach.
STAGES = tuple(Constraint)
"""Reach, joint limits, singular poses, clearance, torch angles: a later obstacle is nearer to a plan."""


def obstacle_at(
    problem: PlanningProblem,
    place: FloatArray,
    branches: tuple[int, int],
    point: int,
    *,
    leans: Sequence[float] = LEANS,
) -> Obstacle | None:
    """Return what keeps both robots from a point of the seam; None if there is an allowed state at the target angles.

    `place`: shape (3,). Of the weld point, in `middle`, mm.
    """
    coordinates, targets = attitudes_at(problem, place, leans), problem.targets
    leaning = (coordinates[:, WORK] != targets.work_rad) | (coordinates[:, TRAVEL] != targets.travel_rad)
    path = problem.path.select(np.full(len(coordinates), point))
    s_mm = float(problem.path.s_mm[point])
    tables = all_joints(problem.cell, path, coordinates)
    both = np.concatenate([table[:, branch] for table, branch in zip(tables, branches, strict=True)], axis=1)
    reached = np.isfinite(both).all(axis=1)
    if not reached.any():
        return _out_of_reach(problem, flange_poses(problem.cell, path, coordinates), s_mm)
    both, leaning, coordinates = both[reached], leaning[reached], coordinates[reached]
    excess = limit_excess(problem, both)
    within = excess.max(axis=1) <= 0
    if not within.any():
        least = excess[int(np.argmin(excess.max(axis=1)))]
        return joint_limit_obstacle(problem, int(np.argmax(least)), float(least.max()), s_mm)
    both, leaning, coordinates = both[within], leaning[within], coordinates[within]
    values = problem.regularity(both)
    regular = values.min(axis=1) >= LEAST_REGULARITY
    if not regular.any():
        return singular_obstacle(values[int(np.argmax(values.min(axis=1)))], s_mm)
    both, leaning, coordinates = both[regular], leaning[regular], coordinates[regular]
    clear = capsule_clearance(problem.cell, both)
    return _not_clear(problem, clear, leaning, coordinates, s_mm)


def nearest_to_a_plan(obstacles: Sequence[Obstacle | None]) -> Obstacle | None:
    """Return the obstacle of the latest stage with the smallest shortage; None if none is known."""
    return min((obstacle for obstacle in obstacles if obstacle is not None), key=_shortage, default=None)


def farthest_from_a_plan(obstacles: Sequence[Obstacle | None]) -> Obstacle | None:
    """Return the obstacle of the earliest stage with the largest shortage; None if none is known."""
    return max((obstacle for obstacle in obstacles if obstacle is not None), key=_shortage, default=None)


def _shortage(obstacle: Obstacle) -> tuple[int, float]:
    off = 0.0 if obstacle.best is None or obstacle.asked is None else abs(obstacle.asked - obstacle.best)
    return -STAGES.index(obstacle.constraint), off


def limit_excess(problem: PlanningProblem, joints: FloatArray) -> FloatArray:
    """Return how far joints are beyond their limits in the best whole turn, shape (n, 12). rad; zero within the limits.

    `joints`: shape (n, 12). Robot 1, then robot 2, rad.
    """
    low, high = problem.cell.limits
    turned = joints[None] + TURN * np.arange(-2, 3)[:, None, None]
    return np.asarray(np.maximum(np.maximum(turned - high, low - turned), 0.0).min(axis=0), dtype=np.float64)


def clearance_advice(problem: PlanningProblem, between: tuple[str, str], best_mm: float) -> str:
    """Return what would let two bodies keep their distance. `best_mm`: Largest distance that was attained, mm."""
    near = {shape.name for shape in problem.cell.torch if shape.to_part_mm is not None}
    part = {f"robot 2 {shape.name}" for shape in problem.cell.part}
    torch = {f"robot 1 {shape.name}" for shape in problem.cell.torch}
    if not (set(between) & part and set(between) & torch):
        return (
            "hold the part differently (T_flange_part), move the bases, or use a smaller safety_distance_mm if the "
            "bodies allow it"
        )
    most = math.degrees(problem.targets.torch_range_rad)
    other = f"let the torch lean further (--torch-range-deg, now {most:g}), or use a slimmer torch"
    key = "to_part_mm" if {f"robot 1 {name}" for name in near} & set(between) else "safety_distance_mm"
    allowed = math.floor(10 * best_mm - 1e-6) / 10
    return f"a {key} of {allowed:g} mm would do at this place; {other}" if allowed > 0 else other


def allowed_rotations(targets: WeldTargets, offsets_rad: Sequence[float]) -> FloatArray:
    """Return the target rotation plus each offset, without those outside the range; shape (k,), rad."""
    rotations = targets.rotation_rad + np.array(offsets_rad)
    return np.asarray(rotations[np.abs(rotations) <= targets.rotation_range_rad], dtype=np.float64)


def attitudes_at(problem: PlanningProblem, place: FloatArray, leans: Sequence[float] = (0.0,)) -> FloatArray:
    """Return the attitudes that are tried at one place, shape (N, 9).

    `place`: shape (3,). In `middle`, mm.
    `leans`: Work and travel angles, as parts of their range.
    """
    targets = problem.targets
    work, travel = (
        centre + targets.torch_range_rad * np.array(leans) for centre in (targets.work_rad, targets.travel_rad)
    )
    yaw, spin = TURN * np.arange(YAWS) / YAWS, TURN * np.arange(SPINS) / SPINS
    axes = (yaw, spin, allowed_rotations(targets, ROTATIONS_RAD), work, travel)
    grid = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")])
    coordinates = target_coordinates(targets, grid.shape[1])
    coordinates[:, PLACE] = place
    coordinates[:, [YAW, SPIN, ROTATION, WORK, TRAVEL]] = grid.T
    return coordinates


def left_reach(problem: PlanningProblem, path: CandidatePath, before: str = "") -> Obstacle:
    """Return the first point of a path that a robot does not reach; `before` is said in front."""
    missing = ~np.isfinite(path.joints)
    row = int(np.argmax(missing.any(axis=1)))
    robot, s_mm = 1 if missing[row, :JOINTS].any() else 2, float(problem.path.s_mm[row])
    says = f"{before}robot {robot} leaves its reach at s = {s_mm:.1f} mm"
    return Obstacle(constraint=Constraint.REACH, says=says, advice=NEARER, s_mm=s_mm, robot=robot)


def _out_of_reach(problem: PlanningProblem, flanges: tuple[FloatArray, FloatArray], s_mm: float) -> Obstacle:
    robot, short_mm = least_shortage(problem.cell, flanges)
    name = (problem.cell.arm, problem.cell.arm2)[robot].name
    return Obstacle(
        constraint=Constraint.REACH,
        says=f"out of reach of robot {robot + 1} ({name}) by {short_mm:.0f} mm at s = {s_mm:.1f} mm",
        advice=NEARER,
        s_mm=s_mm,
        robot=robot + 1,
        best=short_mm,
        asked=0.0,
        unit="mm",
    )


def joint_limit_obstacle(problem: PlanningProblem, column: int, excess_rad: float, s_mm: float) -> Obstacle:
    """Return the obstacle of one of the twelve joints that is beyond its limit."""
    robot, name = problem.cell.joint_of(column)
    beyond = math.degrees(excess_rad)
    return Obstacle(
        constraint=Constraint.JOINT_LIMITS,
        says=f"joint {name} of robot {robot}: at best {beyond:.1f} deg beyond its limit at s = {s_mm:.1f} mm",
        advice=f"turn or move the base of robot {robot}, or hold the part differently (T_flange_part)",
        s_mm=s_mm,
        robot=robot,
        joint=name,
        best=beyond,
        asked=0.0,
        unit="deg",
    )


def singular_obstacle(values: FloatArray, s_mm: float) -> Obstacle:
    """Return the obstacle of a state that is too near to a singular pose.

    `values`: shape (6,). The three measures of robot 1, then of robot 2.
    `s_mm`: Place along the seam, mm.
    """
    robot, kind = divmod(int(np.argmin(values)), len(SINGULAR))
    return Obstacle(
        constraint=Constraint.SINGULAR_POSES,
        says=f"robot {robot + 1}: {SINGULAR[kind]} at s = {s_mm:.1f} mm "
        f"(measure {values.min():.3f} at best, {LEAST_REGULARITY:g} asked)",
        advice="hold the part differently, or move the bases",
        s_mm=s_mm,
        robot=robot + 1,
        best=float(values.min()),
        asked=LEAST_REGULARITY,
    )


def _not_clear(
    problem: PlanningProblem, clear: Clearance, leaning: BoolArray, coordinates: FloatArray, s_mm: float
) -> Obstacle | None:
    """Return the pair of bodies that is too near at best; the torch angles if only a leaning torch is clear."""
    if (clear.is_clear & ~leaning).any():
        return None
    row = int(np.argmax(clear.margin_mm))
    between, best = clear.nearest(row), float(clear.distance_mm[row])
    if not clear.is_clear[row]:
        asked = best - float(clear.margin_mm[row])
        return too_near(between, s_mm, best, asked, clearance_advice(problem, between, best))
    upright = np.flatnonzero(~leaning)
    if len(upright):
        held = int(upright[np.argmax(clear.margin_mm[upright])])
        between = clear.nearest(held)
        says = f"at the target torch angles {between[0]} and {between[1]} are too near at s = {s_mm:.1f} mm"
    else:
        says = f"at the target torch angles no state is reached within the limits at s = {s_mm:.1f} mm"
    work, travel = _least_lean(problem, coordinates[clear.is_clear])
    return Obstacle(
        constraint=Constraint.TORCH_ANGLES,
        says=f"{says}; a torch at work angle {work:g} and travel angle {travel:g} deg is clear there",
        advice=f"try --work-angle-deg {work:g} --travel-angle-deg {travel:g}",
        s_mm=s_mm,
        between=between if len(upright) else None,
        unit="deg",
    )


def _least_lean(problem: PlanningProblem, coordinates: FloatArray) -> tuple[float, float]:
    """Return work and travel angle of the attitude that leans the torch least, deg."""
    torch = coordinates[:, [WORK, TRAVEL]]
    off = np.abs(torch - [problem.targets.work_rad, problem.targets.travel_rad]).sum(axis=1)
    work, travel = np.degrees(torch[np.argmin(off)])
    return round(float(work), 1) + 0.0, round(float(travel), 1) + 0.0
