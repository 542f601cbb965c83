"""The deterministic front: ladders at the best places, then least squares for one set of weights after another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from wpcal.core.same_bits import first_least
from wpcal.planning.search.diagnosis import nearest_to_a_plan
from wpcal.planning.search.ladder import build_ladder, ladder_obstacle, shortest_path
from wpcal.planning.search.linear_model import linearise
from wpcal.planning.search.objectives import MOTION, POSITION, TORCH, Weights
from wpcal.planning.search.obstacle import Constraint, NoFeasiblePlanError, Obstacle
from wpcal.planning.search.problem import CandidatePath, PlanningProblem, SearchProgress
from wpcal.planning.search.reachable_states import ReachablePlace, find_reachable_places
from wpcal.planning.search.refine import refine_path, refine_within_limits

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
