"""`plan_seam`: from a planning problem to a set of trade-off plans to choose from.

The deterministic search gives a front by itself. The published genetic algorithm can run after it and starts from that
front. The hypervolumes of both fronts show what it adds.

Also here: the deterministic front: ladders at the best places, then least squares for one set of weights after another.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from wpcal.core.arrays import frozen
from wpcal.core.same_bits import first_least
from wpcal.planning.cell.clearance import require_bases_apart
from wpcal.planning.plan.plan import CollisionVerdict, Plan
from wpcal.planning.plan.recheck import PathCheck, check_path
from wpcal.planning.search.diagnosis import Constraint, NoFeasiblePlanError, Obstacle, nearest_to_a_plan
from wpcal.planning.search.ladder import build_ladder, ladder_obstacle, shortest_path
from wpcal.planning.search.nsga2 import Nsga2Options, evolve_paths
from wpcal.planning.search.objectives import (
    ATTITUDE,
    MOTION,
    OBJECTIVE_NAMES,
    OBJECTIVES,
    POSITION,
    TORCH,
    Weights,
    printed_values,
)
from wpcal.planning.search.pareto import ParetoSet, PlanningResult, is_nondominated
from wpcal.planning.search.path_diagnosis import no_plan
from wpcal.planning.search.problem import CandidatePath, PlanningProblem, SearchProgress
from wpcal.planning.search.reachable_states import ReachablePlace, find_reachable_places
from wpcal.planning.search.refine import linearise, refine_path, refine_within_limits

LADDERS = 3  #: Ladders that are built, of different branches; each takes a quarter of a second.
TIGHT, LOOSE = 0.1, 1e-4  #: Weights of the torch angles: within about a degree of their targets, or some degrees off.


def sweep_weights(position: float, torch: float) -> Weights:
    """Return weights of the squared deviations (per deg²) against the joint motion (per (deg/mm)²), which has 1."""
    return {POSITION: position, TORCH: torch, MOTION: 1.0}


SWEEP = (
    *(sweep_weights(weight, TIGHT) for weight in (1e-1, 1e-2, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 1e-7)),
    *(sweep_weights(weight, LOOSE) for weight in (1e-7, 1e-5, 3e-5, 5e-5, 1e-4, 1e-3, 1e-2)),
)
"""From a part that is at the target weld position to a part that hardly moves, and back. Neighbours are near, so that
each path starts from the one before."""
FIRST = sweep_weights(1e-3, TIGHT)  #: Weights with which ladders are compared: in the middle of the sweep.


def sweep_paths(
    problem: PlanningProblem, progress: SearchProgress, weights: Sequence[Weights] = SWEEP
) -> Iterator[CandidatePath]:
    """Find one path for each set of weights and yield each as soon as it is found.

    Raises `GeometryError` when the seam is out of reach or its start is in collision.
    Raises `NoFeasiblePlanError` when no ladder has a way through; it names the place and the limit.
    """
    path = _first_path(problem, progress)
    for done, one in enumerate(weights):
        progress("sweeping the weights", done, len(weights))
        path = refine_within_limits(problem, path, one)
        yield path
    progress("sweeping the weights", len(weights), len(weights))


def _first_path(problem: PlanningProblem, progress: SearchProgress) -> CandidatePath:
    """Return the best refined way through the ladders; if there is none, through ladders with a leaning torch."""
    progress("looking for places where the robots can meet", 0, LADDERS + 1)
    places = find_reachable_places(problem, LADDERS)
    paths, obstacles = _climb(problem, places, progress, leaning=False)
    if not paths and any(one is not None and one.constraint is Constraint.TORCH_ANGLES for one in obstacles):
        paths, obstacles = _climb(problem, places, progress, leaning=True)
    if not paths:
        raise NoFeasiblePlanError("no way leads from the start of the seam to its end", nearest_to_a_plan(obstacles))
    return paths[int(first_least([linearise(problem, path, FIRST).cost for path in paths]))]


def _climb(
    problem: PlanningProblem, places: Sequence[ReachablePlace], progress: SearchProgress, *, leaning: bool
) -> tuple[list[CandidatePath], list[Obstacle | None]]:
    """Return the refined ways through the ladders of some places, and what closes the ladders that have no way."""
    paths: list[CandidatePath] = []
    obstacles: list[Obstacle | None] = []
    for row, place in enumerate(places):
        progress("searching ladders", row + 1, LADDERS + 1)
        ladder = build_ladder(problem, place, leaning=leaning)
        path = shortest_path(problem, ladder, FIRST)
        if path is None:
            obstacles.append(ladder_obstacle(problem, ladder, FIRST))
        else:
            paths.append(refine_path(problem, path, FIRST))
    return paths, obstacles


REFERENCE_MARGIN = 1.5
"""The reference of the hypervolume is this times the largest value of each objective over the deterministic front. The
ends of that front then count; a plan that is worse than all of that front in one objective hardly counts."""


def plan_seam(
    problem: PlanningProblem,
    *,
    weights: Sequence[Weights] = SWEEP,
    genetic: Nsga2Options | None = None,
    progress: SearchProgress = lambda what, done, of: None,
) -> PlanningResult:
    """Search for plans of a seam. If the user ends the search (KeyboardInterrupt), the best front so far.

    Raises `GeometryError` when the seam is out of reach, the bases are too close to each other or the start is in
    collision.
    Raises `NoFeasiblePlanError` when no feasible plan is found; it names the limit that is hardest to keep, and where.
    Raises `KeyboardInterrupt` when the user ends the search before there is any plan.
    """
    require_bases_apart(problem.cell)
    found: list[CandidatePath] = []
    interrupted = False
    try:
        found.extend(sweep_paths(problem, progress, weights))
    except KeyboardInterrupt:
        if not found:
            raise
        interrupted = True
    bred: list[CandidatePath] = []
    if genetic is not None and not interrupted:
        bred, interrupted = evolve_paths(problem, best_paths(problem, found), genetic, progress)
    return judge_paths(problem, found, bred, interrupted=interrupted)


def best_paths(problem: PlanningProblem, paths: Sequence[CandidatePath]) -> list[CandidatePath]:
    """Return the paths that break no limit and that no other path beats, in their order."""
    allowed = [path for path in paths if problem.is_allowed(path)]
    if not allowed:
        return []
    values = np.stack([problem.objectives(path.coordinates, path.joints) for path in allowed])
    return [allowed[row] for row in np.flatnonzero(is_nondominated(values))]


def make_plan(problem: PlanningProblem, path: CandidatePath, found_by: str) -> Plan:
    """Return a path as a plan with its objectives; clearances are not measured."""
    slope, rotation, work, travel = path.coordinates[:, ATTITUDE].T
    values = problem.objectives(path.coordinates, path.joints)
    return Plan(
        seam=problem.path.name,
        s_mm=problem.path.s_mm,
        q=path.joints,
        slope_rad=slope,
        rotation_rad=rotation,
        work_rad=work,
        travel_rad=travel,
        objectives={name: float(value) for name, value in zip(OBJECTIVE_NAMES, values, strict=True)},
        printed=printed_values(problem.path_values(path.coordinates, path.joints)),
        found_by=found_by,
    )


def judge_paths(
    problem: PlanningProblem,
    swept: Sequence[CandidatePath],
    bred: Sequence[CandidatePath] = (),
    *,
    interrupted: bool = False,
) -> PlanningResult:
    """Check the best paths for collisions between their points and compare those that are free.

    Raises `NoFeasiblePlanError` when no path is allowed and free; it names the limit that most paths break, and where.
    """
    best, evolved = best_paths(problem, swept), best_paths(problem, bred)
    (ladder, refused), (genetic, also) = (
        _free_plans(problem, group, name) for group, name in ((best, "ladder"), (evolved, "nsga2"))
    )
    plans = ladder + genetic
    if not plans:
        raise no_plan(problem, swept, (*refused, *also))
    sets = [ParetoSet(tuple(group)) if group else None for group in (ladder, genetic)]
    every = ParetoSet(tuple(plans))
    basis = every if sets[0] is None else sets[0]
    kept = [plans[row] for row in np.flatnonzero(is_nondominated(every.values))]
    return PlanningResult(
        problem=problem,
        front=ParetoSet(tuple(sorted(kept, key=lambda plan: plan.objectives[OBJECTIVES[0].name]))),
        ladder=sets[0],
        genetic=sets[1],
        reference=frozen(REFERENCE_MARGIN * basis.values.max(axis=0)),
        interrupted=interrupted,
        not_free=len(best) + len(evolved) - len(plans),
    )


def _free_plans(
    problem: PlanningProblem, paths: Sequence[CandidatePath], found_by: str
) -> tuple[list[Plan], list[PathCheck]]:
    """Return the plans that are free between their points too, with clearances by hulls, and the checks of the rest."""
    plans, refused = [], []
    for path in paths:
        plan = make_plan(problem, path, found_by)
        check = check_path(plan.q, plan.s_mm, problem.cell)
        if check.verdict is CollisionVerdict.FREE:
            clearance_mm = check.clearance.distance_mm[:: check.refine]
            plans.append(replace(plan, clearance_mm=clearance_mm, verdict=check.verdict))
        else:
            refused.append(check)
    return plans, refused
