"""Why none of the paths that a search found is a plan: the limit that most of them break, and where the best one does.

A path is best at a limit if it is beyond this limit by the least.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from wpcal.planning.cell.cell_check import check_cell
from wpcal.planning.cell.clearance import capsule_clearance
from wpcal.planning.cell.closed_chain import PLACE, ROTATION, SLOPE, TRAVEL, WORK
from wpcal.planning.plan.recheck import PathCheck
from wpcal.planning.search.diagnosis import (
    Constraint,
    NoFeasiblePlanError,
    Obstacle,
    clearance_advice,
    joint_limit_obstacle,
    left_reach,
    obstacle_at,
    singular_obstacle,
    too_near,
)
from wpcal.planning.search.problem import ALLOWED_EXCESS, CandidatePath, PlanningProblem

COORDINATE_NAMES = {SLOPE: "slope", ROTATION: "rotation", WORK: "work angle", TRAVEL: "travel angle"}


def no_plan(
    problem: PlanningProblem, tried: Sequence[CandidatePath], refused: Sequence[PathCheck] = ()
) -> NoFeasiblePlanError:
    """Return the error of a search whose paths are all refused."""
    if refused:
        return NoFeasiblePlanError("clearance fails most, between the points of every path", _between(problem, refused))
    counts: Counter[str] = Counter()
    for path in tried:
        counts.update(name for name, value in problem.excesses(path).items() if value > ALLOWED_EXCESS)
    if not counts:
        return NoFeasiblePlanError("no path was tried")
    name, times = counts.most_common(1)[0]
    return NoFeasiblePlanError(
        f"{name} fails most, on {times} of {len(tried)} paths", path_obstacle(problem, tried, Constraint(name))
    )


def path_obstacle(problem: PlanningProblem, paths: Sequence[CandidatePath], constraint: Constraint) -> Obstacle:
    """Return where the path that breaks a limit by the least breaks it most."""
    broken = [(problem.excesses(path).get(constraint.value, 0.0), path) for path in paths]
    path = min((one for one in broken if one[0] > ALLOWED_EXCESS), key=lambda one: one[0])[1]
    if constraint is Constraint.REACH:
        return left_reach(problem, path)
    if constraint is Constraint.JOINT_LIMITS:
        low, high = problem.cell.limits
        excess = np.maximum(path.joints - high, low - path.joints)
        row, column = (int(i) for i in np.unravel_index(int(np.argmax(excess)), excess.shape))
        return joint_limit_obstacle(problem, column, float(excess[row, column]), float(problem.path.s_mm[row]))
    if constraint is Constraint.SINGULAR_POSES:
        values = problem.regularity(path.joints)
        row = int(np.argmin(values.min(axis=1)))
        return singular_obstacle(values[row], float(problem.path.s_mm[row]))
    if constraint is Constraint.JOINT_SPEEDS:
        return _speed(problem, path)
    if constraint is Constraint.CLEARANCE:
        return _clearance(problem, path)
    return _coordinate(problem, path, constraint)


def _between(problem: PlanningProblem, refused: Sequence[PathCheck]) -> Obstacle:
    """Return the bodies that are too near between the points of the best path."""
    check = max(refused, key=lambda one: float(one.clearance.margin_mm[one.worst]))
    row = check.worst
    s_mm, between = float(check.s_mm[row]), check.clearance.nearest(row)
    distance, margin = float(check.clearance.distance_mm[row]), float(check.clearance.margin_mm[row])
    if margin > 0:
        return Obstacle(
            constraint=Constraint.CLEARANCE,
            says=f"{between[0]} and {between[1]}: {distance:.1f} mm at s = {s_mm:.1f} mm, but bodies move "
            f"{check.motion_mm:.1f} mm between two states, too far to exclude a collision there",
            advice="sample the seam with smaller steps (--max-step-mm)",
            s_mm=s_mm,
            between=between,
            best=distance,
            asked=check.motion_mm,
            unit="mm",
        )
    loose = {name for issue in check_cell(problem.cell) if issue.code == "capsule-and-hull" for name in issue.ids}
    advice = f"{clearance_advice(problem, between, distance)}; or sample the seam with smaller steps (--max-step-mm)"
    for name in between:
        if name in loose:
            advice = (
                f"the capsules of {name} do not hold its hull, so the search sees more room than there is; {advice}"
            )
    return too_near(between, s_mm, distance, distance - margin, advice)


def _speed(problem: PlanningProblem, path: CandidatePath) -> Obstacle:
    allowed = problem.cell.allowed_mm_s(path.joints, problem.path.s_mm)
    row, column = (int(i) for i in np.unravel_index(int(np.argmin(allowed)), allowed.shape))
    robot, name = problem.cell.joint_of(column)
    s_mm, best = float(problem.path.s_mm[row]), float(allowed[row, column])
    return Obstacle(
        constraint=Constraint.JOINT_SPEEDS,
        says=f"joint {name} of robot {robot} allows {best:.1f} mm/s at s = {s_mm:.1f} mm, "
        f"{problem.speed_mm_s:g} mm/s asked",
        advice="use a lower --speed-mm-s",
        s_mm=s_mm,
        robot=robot,
        joint=name,
        best=best,
        asked=problem.speed_mm_s,
        unit="mm/s",
    )


def _clearance(problem: PlanningProblem, path: CandidatePath) -> Obstacle:
    clear = capsule_clearance(problem.cell, path.joints)
    row = int(np.argmin(clear.margin_mm))
    attained = obstacle_at(problem, path.coordinates[row, PLACE], path.branches, row)
    if attained is not None and attained.constraint is Constraint.CLEARANCE:
        return attained
    between, best = clear.nearest(row), float(clear.distance_mm[row])
    asked = best - float(clear.margin_mm[row])
    return too_near(between, float(problem.path.s_mm[row]), best, asked, clearance_advice(problem, between, best))


def _coordinate(problem: PlanningProblem, path: CandidatePath, constraint: Constraint) -> Obstacle:
    """Return the coordinate that is farthest outside its range."""
    low, high = problem.box
    outside = np.maximum(path.coordinates - high, low - path.coordinates)
    columns = {
        Constraint.WELD_POSITION: [SLOPE, ROTATION],
        Constraint.TORCH_ANGLES: [WORK, TRAVEL],
        Constraint.WELD_ZONE: list(range(len(low)))[PLACE],
    }[constraint]
    row, which = (int(i) for i in np.unravel_index(int(np.argmax(outside[:, columns])), (len(outside), len(columns))))
    column, s_mm = columns[which], float(problem.path.s_mm[row])
    if constraint is Constraint.WELD_ZONE:
        beyond, name, unit = float(outside[row, column]), "the weld", "mm"
        advice = "hold the part differently, or move the bases"
    else:
        beyond, name, unit = math.degrees(outside[row, column]), f"the {COORDINATE_NAMES[column]}", "deg"
        is_torch = constraint is Constraint.TORCH_ANGLES
        advice = "use a larger --torch-range-deg" if is_torch else "use another --slope-deg or --rotation-deg"
    return Obstacle(
        constraint=constraint,
        says=f"{name} is {beyond:.1f} {unit} outside its range at s = {s_mm:.1f} mm",
        advice=advice,
        s_mm=s_mm,
        best=beyond,
        asked=0.0,
        unit=unit,
    )
