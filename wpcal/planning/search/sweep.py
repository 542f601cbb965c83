"""The deterministic front: ladders at the best meetings, then least squares for one pair of weights after another."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import ConvergenceError
from wpcal.planning.search.ladder import build_ladder, shortest_path
from wpcal.planning.search.linear_model import Path, linearise
from wpcal.planning.search.problem import PlanningProblem
from wpcal.planning.search.reachable_states import find_meetings
from wpcal.planning.search.refine import refine_path, refine_within_limits

LADDERS = 3
"""Ladders that are built, of different branches: a quarter of a second each."""
TIGHT, LOOSE = 0.1, 1e-4
"""Weights of the torch angles: hardly a degree from their wish, and some degrees."""
SWEEP = (
    *((weight, TIGHT) for weight in (1e-1, 1e-2, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 1e-7)),
    *((weight, LOOSE) for weight in (1e-7, 1e-5, 3e-5, 5e-5, 1e-4, 1e-3, 1e-2)),
)
"""Weights of weld position and torch angles (per deg²) against joint motion (per (deg/mm)²): from a part that lies
perfectly to one that hardly moves, and back. Neighbours are near, so that each path starts from the one before."""
FIRST_WEIGHT = 1e-3
"""Weight of the position with which ladders are compared: in the middle of the sweep."""

Progress = Callable[[str, int, int], None]
"""Called with what is going on, how many steps of it are done, and of how many."""


def weight_vector(position: float, torch: float) -> FloatArray:
    """Return weights of the squared objectives; the motion has 1."""
    return np.array([position, torch, 1.0])


def sweep_paths(
    problem: PlanningProblem, progress: Progress, weights: Sequence[tuple[float, float]] = SWEEP
) -> Iterator[Path]:
    """Find one path for each pair of weights, and give each out as soon as it is there.

    Parameters
    ----------
    problem : PlanningProblem
    progress : callable
    weights : sequence of (float, float)
        Of weld position and torch angles, in an order in which neighbours are near.

    Yields
    ------
    Path
        As the least squares leave it; it may still break a limit.

    Raises
    ------
    GeometryError
        When the seam is out of reach or its start in collision.
    ConvergenceError
        When no ladder has a way through.
    """
    path = _first_path(problem, progress)
    for done, (position, torch) in enumerate(weights):
        progress("sweeping the weights", done, len(weights))
        path = refine_within_limits(problem, path, weight_vector(position, torch))
        yield path
    progress("sweeping the weights", len(weights), len(weights))


def _first_path(problem: PlanningProblem, progress: Progress) -> Path:
    """Return the best refined way through the ladders."""
    weights = weight_vector(FIRST_WEIGHT, TIGHT)
    progress("looking for places where the robots can meet", 0, LADDERS + 1)
    meetings, found = find_meetings(problem, LADDERS), []
    for row, meeting in enumerate(meetings):
        progress("searching ladders", row + 1, LADDERS + 1)
        ladder = build_ladder(problem, meeting)
        path = shortest_path(problem, ladder, weights)
        if path is not None:
            refined = refine_path(problem, path, weights)
            found.append((linearise(problem, refined, weights).cost, refined))
    if not found:
        raise ConvergenceError("no feasible plan: no ladder of allowed states reaches from the start to the end")
    return min(found, key=lambda pair: pair[0])[1]
