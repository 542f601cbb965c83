"""The annealer beside SciPy's two global searches: the time until 0.005 mm above the optimum of Table 1.

All three search the same box (±180° and the size of the cloud about the centroid) for the same cost function. The peers
run with their default options and with chance seeded; `differential_evolution` may call the cost with its whole
population at once, as the annealer does. A run is over when the cost has been within the goal once.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rich.table import Table
from scipy.optimize import differential_evolution, dual_annealing

from wpcal.calibrate.solve.annealed import SearchProblem, about_centroid
from wpcal.optim import anneal
from wpcal.taught.pairs import read_pairs

TABLE1 = Path(__file__).parents[2] / "fixtures" / "yin2003" / "table1.csv"
OPTIMUM_MM = 0.2198230047896
GOAL_MM = OPTIMUM_MM + 0.005
PEER_SEEDS = 20
OWN_SEEDS = 100
REPEATS = 5
QUICK_SECONDS = 0.2  #: Longer runs are timed once: a disturbance of milliseconds does not show in them.


class GoalReachedError(Exception):
    """Ends a run as soon as one state is good enough."""


class Watch:
    """A cost that counts its states, keeps its least value and ends the run at the goal."""

    def __init__(self, cost: Callable[[np.ndarray], np.ndarray], goal: float) -> None:
        self.cost, self.goal, self.evaluations, self.least = cost, goal, 0, np.inf

    def __call__(self, states: np.ndarray) -> np.ndarray:
        costs = self.cost(states)
        self.evaluations += len(states)
        self.least = min(self.least, float(costs.min()))
        if self.least <= self.goal:
            raise GoalReachedError
        return costs


def main() -> Table:
    pairs, _ = read_pairs(TABLE1)
    problem = about_centroid(pairs.p_source, pairs.p_target)
    table = Table(title=f"Time until {GOAL_MM:.6f} mm, median of {PEER_SEEDS} seeds", caption=_alone(problem))
    for heading in ("solver", "reached", "median ms", "median evaluations", "median least mm", "ours is faster by"):
        table.add_column(heading, justify="left" if heading == "solver" else "right")
    own = None
    for name, solve in SOLVERS.items():
        runs = [_least_of(problem, solve, seed) for seed in range(PEER_SEEDS)]
        reached = [run for run in runs if run[0]]
        seconds = float(np.median([run[1] for run in runs]))
        own = own or seconds
        ratio = f"{seconds / own:.1f}" if len(reached) > PEER_SEEDS / 2 else f"> {seconds / own:.1f} (it ended without)"
        middle = [float(np.median([run[k] for run in runs])) for k in (2, 3)]
        table.add_row(
            name,
            f"{len(reached)} of {PEER_SEEDS}",
            f"{1e3 * seconds:.1f}",
            f"{middle[0]:.0f}",
            f"{middle[1]:.4f}",
            ratio,
        )
    return table


def _alone(problem: SearchProblem) -> str:
    excess = np.sort([_anneal(problem, problem.cost, seed).cost - OPTIMUM_MM for seed in range(OWN_SEEDS)])
    return (
        f"The annealer alone, {OWN_SEEDS} seeds to the end: largest excess {excess[-1]:.5f} mm (asked ≤ 0.02), "
        f"{np.count_nonzero(excess <= 0.005)} within 0.005 mm (asked ≥ 95)"
    )


def _least_of(problem: SearchProblem, solve: Callable[..., object], seed: int) -> tuple[bool, float, int, float]:
    """One seed's run, again while it is quick: a seed's work is always the same, so the shortest time is its time."""
    first = _timed(problem, solve, seed)
    again = [_timed(problem, solve, seed) for _ in range(REPEATS - 1 if first[1] < QUICK_SECONDS else 0)]
    return min([first, *again], key=lambda run: run[1])


def _timed(problem: SearchProblem, solve: Callable[..., object], seed: int) -> tuple[bool, float, int, float]:
    watch = Watch(problem.cost, GOAL_MM)
    start = time.perf_counter()
    try:
        solve(problem, watch, seed)
        reached = False
    except GoalReachedError:
        reached = True
    return reached, time.perf_counter() - start, watch.evaluations, watch.least


def _anneal(problem: SearchProblem, cost: Callable[[np.ndarray], np.ndarray], seed: int):
    rng = np.random.default_rng(seed)
    return anneal(cost, problem.lower, problem.upper, rng=rng, periodic=problem.periodic)


def _dual_annealing(problem: SearchProblem, cost: Watch, seed: int) -> object:
    bounds = list(zip(problem.lower, problem.upper, strict=True))
    return dual_annealing(lambda x: float(cost(x[None])[0]), bounds, rng=np.random.default_rng(seed))


def _differential_evolution(problem: SearchProblem, cost: Watch, seed: int) -> object:
    bounds = list(zip(problem.lower, problem.upper, strict=True))
    rng = np.random.default_rng(seed)
    return differential_evolution(
        lambda x: cost(x.T) if x.ndim == 2 else float(cost(x[None])[0]),
        bounds,
        rng=rng,
        vectorized=True,
        updating="deferred",  # what `vectorized` implies; stated, or SciPy warns
    )


SOLVERS = {
    "wpcal.optim.anneal": _anneal,
    "scipy dual_annealing": _dual_annealing,
    "scipy differential_evolution, vectorised": _differential_evolution,
}
