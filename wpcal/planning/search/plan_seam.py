"""`plan_seam`: from a cell and a seam to the plans between which one chooses.

The deterministic search gives a front by itself. The published genetic algorithm can be run after it, seeded with that
front; what it adds is told by the hypervolumes of both.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import ConvergenceError, GeometryError
from wpcal.planning.cell.clearance import capsule_clearance
from wpcal.planning.cell.closed_chain import ROTATION, SLOPE, TRAVEL, WORK, SeamPath
from wpcal.planning.cell.robot_cell import JOINTS, CellState, RobotCell
from wpcal.planning.plan.plan import Freedom, ParetoSet, Plan
from wpcal.planning.plan.recheck import recheck_clearance
from wpcal.planning.plan.schedule import SPEED_MM_S
from wpcal.planning.search.linear_model import Path
from wpcal.planning.search.nsga2 import GeneticOptions, evolve_paths
from wpcal.planning.search.objectives import OBJECTIVES, Wishes, f1_1, f1_2, f2
from wpcal.planning.search.pareto import hypervolume, is_nondominated
from wpcal.planning.search.problem import ALLOWED_EXCESS, PlanningProblem
from wpcal.planning.search.sweep import Progress, sweep_paths

REFERENCE_MARGIN = 1.5
"""The reference of the hypervolume is this times the largest value of each objective over the deterministic front: its
ends then count, and a plan that is worse than all of it in one objective does not."""


@dataclass(frozen=True, slots=True, eq=False)
class PlanningResult:
    """What a search found.

    Parameters
    ----------
    front : ParetoSet
        All plans worth choosing from, by whichever method; every one checked by hulls between its points.
    ladder, genetic : ParetoSet or None
        The fronts of the deterministic search and of the genetic algorithm, each by itself.
    reference : ndarray, shape (k,)
        Corner of the hypervolumes.
    interrupted : bool
        Whether the user ended the search early.
    not_free : int
        Plans left out because the check between their points found them too near.
    wishes : Wishes
    speed_mm_s : float
    """

    front: ParetoSet
    ladder: ParetoSet | None
    genetic: ParetoSet | None
    reference: FloatArray
    interrupted: bool
    not_free: int
    wishes: Wishes
    speed_mm_s: float

    def hypervolume_of(self, front: ParetoSet | None) -> float:
        """Return what a front dominates; zero for none."""
        return 0.0 if front is None else hypervolume(front.values, self.reference)


def plan_seam(
    cell: RobotCell,
    path: SeamPath,
    *,
    wishes: Wishes | None = None,
    speed_mm_s: float = SPEED_MM_S,
    genetic: GeneticOptions | None = None,
    progress: Progress = lambda what, done, of: None,
) -> PlanningResult:
    """Search for the plans of a seam.

    Parameters
    ----------
    cell : RobotCell
    path : SeamPath
        In `part`.
    wishes : Wishes, optional
    speed_mm_s : float
        Of the torch along the seam.
    genetic : GeneticOptions, optional
        Runs the genetic algorithm, too.
    progress : callable, optional
        Called with what is going on, how many steps of it are done, and of how many.

    Returns
    -------
    PlanningResult
        Ended by the user (KeyboardInterrupt), the best front so far.

    Raises
    ------
    GeometryError
        When the seam is out of reach, the robots stand in each other or the start is in collision.
    ConvergenceError
        When no feasible plan is found; what fails most.
    KeyboardInterrupt
        When the user ends the search before there is any plan.
    """
    problem = PlanningProblem(cell, path, wishes or Wishes(), speed_mm_s)
    require_apart(cell)
    found: list[Path] = []
    interrupted = False
    try:
        found.extend(sweep_paths(problem, progress))
    except KeyboardInterrupt:
        if not found:
            raise
        interrupted = True
    ladder = best_paths(problem, found)
    bred: list[Path] = []
    if genetic is not None and not interrupted:
        bred, interrupted = evolve_paths(problem, ladder, genetic, progress)
        bred = best_paths(problem, bred)
    return _result(problem, found, ladder, bred, interrupted=interrupted)


def require_apart(cell: RobotCell) -> None:
    """Refuse a cell whose fixed bodies (pedestals and bench) are nearer to each other than the safety distance.

    Raises
    ------
    GeometryError
        With the two bodies and what is missing.
    """
    fixed = replace(
        cell,
        links1=tuple(shape for shape in cell.links1 if shape.link == 0),
        links2=tuple(shape for shape in cell.links2 if shape.link == 0),
        torch=(),
        part=(),
    )
    clear = capsule_clearance(fixed, CellState(np.zeros((1, JOINTS)), np.zeros((1, JOINTS))))
    if not clear.is_clear[0]:
        one, two = clear.nearest(0)
        apart = float(np.linalg.norm(cell.T_base1_base2.t_mm))
        raise GeometryError(
            f"the robots stand too close (bases {apart:.0f} mm apart): {one} and {two} miss their safety distance by "
            f"{-clear.margin_mm[0]:.0f} mm, whatever the joints"
        )


def best_paths(problem: PlanningProblem, paths: Sequence[Path]) -> list[Path]:
    """Return the paths that break no limit and that none of the others beats, in their order."""
    allowed = [path for path in paths if problem.is_allowed(path.coordinates, path.joints)]
    if not allowed:
        return []
    values = np.stack([problem.objectives(path.coordinates, path.joints) for path in allowed])
    return [allowed[row] for row in np.flatnonzero(is_nondominated(values))]


def make_plan(problem: PlanningProblem, path: Path, found_by: str) -> Plan:
    """Return a path as a plan, with its objectives; clearances are not yet known."""
    coordinates, joints = path.coordinates, path.joints
    slope, rotation = coordinates[:, SLOPE], coordinates[:, ROTATION]
    work, travel = coordinates[:, WORK], coordinates[:, TRAVEL]
    values = problem.objectives(coordinates, joints)
    return Plan(
        seam=problem.path.name,
        s_mm=problem.path.s_mm,
        state=CellState(joints[:, :JOINTS], joints[:, JOINTS:]),
        slope_rad=slope,
        rotation_rad=rotation,
        work_rad=work,
        travel_rad=travel,
        objectives={name: float(value) for name, value in zip(OBJECTIVES, values, strict=True)},
        printed={
            "f1_1": f1_1(slope, rotation, problem.wishes),
            "f1_2": f1_2(work, travel, problem.wishes),
            "f2": f2(problem.cell, joints),
        },
        found_by=found_by,
    )


def _checked(problem: PlanningProblem, paths: Sequence[Path], found_by: str) -> list[Plan]:
    """Return the plans that are free between their points, too, with their clearances by hulls."""
    plans = []
    for path in paths:
        plan = make_plan(problem, path, found_by)
        check = recheck_clearance(plan, problem.cell)
        if check.freedom is Freedom.FREE:
            plans.append(
                replace(plan, clearance_mm=check.clearance.distance_mm[:: check.refine], freedom=check.freedom)
            )
    return plans


def _result(
    problem: PlanningProblem, tried: list[Path], ladder: list[Path], bred: list[Path], *, interrupted: bool
) -> PlanningResult:
    swept, evolved = _checked(problem, ladder, "ladder"), _checked(problem, bred, "nsga2")
    plans = swept + evolved
    if not plans:
        raise ConvergenceError(f"no feasible plan: {_what_fails(problem, tried, ladder)}")
    sets = [ParetoSet(tuple(group), OBJECTIVES) if group else None for group in (swept, evolved)]
    values = np.array([[plan.objectives[name] for name in OBJECTIVES] for plan in plans])
    basis = values if sets[0] is None else sets[0].values
    kept = [plans[row] for row in np.flatnonzero(is_nondominated(values))]
    return PlanningResult(
        front=ParetoSet(tuple(sorted(kept, key=lambda plan: plan.objectives[OBJECTIVES[0]])), OBJECTIVES),
        ladder=sets[0],
        genetic=sets[1],
        reference=frozen(REFERENCE_MARGIN * basis.max(axis=0)),
        interrupted=interrupted,
        not_free=len(ladder) + len(bred) - len(plans),
        wishes=problem.wishes,
        speed_mm_s=problem.speed_mm_s,
    )


def _what_fails(problem: PlanningProblem, tried: list[Path], allowed: list[Path]) -> str:
    """Say which constraint keeps most of the tried paths from being allowed."""
    if allowed:
        return "clearance fails most: every path comes too near between its points"
    counts: Counter[str] = Counter()
    for path in tried:
        excesses = problem.excesses(path.coordinates, path.joints)
        counts.update(name for name, value in excesses.items() if value > ALLOWED_EXCESS)
    if not counts:
        return "no path was tried"
    name, times = counts.most_common(1)[0]
    return f"{name} fails most, on {times} of {len(tried)} paths"
