"""Plans for two robots: the deterministic front, what it holds to, and the genetic algorithm beside it."""

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from tests.benchmarks.timing import least_seconds
from tests.chain_error import chain_error
from wpcal.core.arrays import FloatArray
from wpcal.planning.cell.cell_file import read_cell
from wpcal.planning.cell.closed_chain import torch_on_seam
from wpcal.planning.plan.plan import CollisionVerdict
from wpcal.planning.plan.recheck import check_path
from wpcal.planning.plan.seam_file import read_seam_path
from wpcal.planning.search.nsga2 import Nsga2Options, evolve_paths
from wpcal.planning.search.objectives import OBJECTIVES, Weights, WeldTargets
from wpcal.planning.search.pareto import PlanningResult, hypervolume, is_nondominated
from wpcal.planning.search.plan_seam import best_paths, make_plan, plan_seam, sweep_paths, sweep_weights
from wpcal.planning.search.problem import CandidatePath, PlanningProblem

CELLS = Path(__file__).parents[2] / "fixtures" / "cells"
REPEATS = 3
SEEDS = 5
GENERATIONS = 200
"""Of NSGA-II with a population of 100: about a quarter of a minute on a machine at rest, the limit being one."""
FINER = 40  #: Parts into which a step is cut to judge again what was called free at ten.
DENSE_POSITION, DENSE_TORCH = np.logspace(-1, -7, 13), (1e-1, 1e-3, 1e-4, 1e-5, 1e-7)
"""Weights of a denser sweep, which takes the time of some tens of generations."""


def main() -> None:
    """Print the tables."""
    console = Console(width=120)
    cell = read_cell(CELLS / "two-mh6.json")
    problem = PlanningProblem(cell, read_seam_path(CELLS / "saddle-seams.json", "W1", cell), WeldTargets())
    seconds, result = least_seconds(lambda: plan_seam(problem), REPEATS), plan_seam(problem)
    console.print(front_table(problem, seconds, result))
    console.print(methods_table(problem, result))


def front_table(problem: PlanningProblem, seconds: float, result: PlanningResult) -> Table:
    """Return what is asked of the deterministic front and what was measured."""
    plans = result.front.plans
    paths = list(sweep_paths(problem, lambda what, done, of: None))
    chain = np.array([_chain_error(problem, path) for path in paths]).max(axis=0)
    steps = np.array([np.abs(np.diff(plan.q, axis=0)).max() for plan in plans])
    rates = [
        (np.abs(np.diff(plan.q, axis=0)) / np.diff(plan.s_mm)[:, None] * problem.speed_mm_s).max(axis=0)
        for plan in plans
    ]
    share = (np.array(rates) / problem.cell.speeds).max()
    checks = [check_path(plan.q, plan.s_mm, problem.cell, refine=FINER) for plan in plans]
    held = sum(check.verdict is CollisionVerdict.FREE for check in checks)
    table = Table(title=f"The saddle, {len(problem.path)} points, two MH6")
    for heading in ("", "asked", "measured"):
        table.add_column(heading, justify="right" if heading else "left")
    table.add_row("front, every plan checked, s", "≤ 10", f"{seconds:.1f}")
    table.add_row("plans on it", "≥ 8", str(len(plans)))
    table.add_row("closed chain, largest error, mm", "1e-6", f"{chain[0]:.1g}")
    table.add_row("closed chain, largest error, rad", "1e-9", f"{chain[1]:.1g}")
    table.add_row("largest joint step between points, deg", "no wrap", f"{np.degrees(steps.max()):.1f}")
    table.add_row("largest joint speed at 6 mm/s, parts of its limit", "≤ 1", f"{share:.3f}")
    table.add_row(f"plans called free that are free at {FINER} times finer steps", "all", f"{held} of {len(plans)}")
    return table


def _chain_error(problem: PlanningProblem, path: CandidatePath) -> tuple[float, float]:
    plan = make_plan(problem, path, "ladder")
    off_mm, off_rad = chain_error(problem.cell, problem.path, plan.q, torch_on_seam(path.coordinates))
    return float(off_mm.max()), float(off_rad.max())


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One run of a method: its time and the objectives of what it found."""

    seconds: float
    values: FloatArray


def methods_table(problem: PlanningProblem, result: PlanningResult) -> Table:
    """Return the table of methods: the front of each, and its gain over the deterministic front."""
    start = time.perf_counter()
    seeds = best_paths(problem, list(sweep_paths(problem, lambda what, done, of: None)))
    basis = Run(time.perf_counter() - start, _values(problem, seeds))
    table = Table(title=f"Hypervolume; NSGA-II: population 100, {GENERATIONS} generations, {SEEDS} seeds")
    for heading in ("method", "s", "plans", "hypervolume", "with the deterministic front", "gain %"):
        table.add_column(heading, justify="left" if heading == "method" else "right")
    _add(table, "deterministic front", basis, basis, result.reference)
    for seeded in (True, False):
        for seed in range(SEEDS):
            start = time.perf_counter()
            options = Nsga2Options(generations=GENERATIONS, seed=seed, seeded=seeded)
            paths, _ = evolve_paths(problem, seeds, options, lambda what, done, of: None)
            run = Run(time.perf_counter() - start, _values(problem, best_paths(problem, paths)))
            name = f"NSGA-II, {'seeded' if seeded else 'unseeded'}, seed {seed}"
            _add(table, name, run, basis, result.reference)
    start, weights = time.perf_counter(), dense_weights()
    paths = best_paths(problem, list(sweep_paths(problem, lambda what, done, of: None, weights)))
    dense = Run(time.perf_counter() - start, _values(problem, paths))
    _add(table, f"deterministic, {len(weights)} weights", dense, basis, result.reference)
    return table


def dense_weights() -> list[Weights]:
    """Return more weights than the usual sweep has, still each next to the one before."""
    rows = [[sweep_weights(float(weight), torch) for weight in DENSE_POSITION] for torch in DENSE_TORCH]
    return [weights for i, row in enumerate(rows) for weights in (row if i % 2 == 0 else row[::-1])]


def _values(problem: PlanningProblem, paths: list[CandidatePath]) -> FloatArray:
    return np.array([problem.objectives(path.coordinates, path.joints) for path in paths]).reshape(-1, len(OBJECTIVES))


def _add(table: Table, name: str, run: Run, basis: Run, reference: FloatArray) -> None:
    before = hypervolume(basis.values, reference)
    both = np.concatenate([basis.values, run.values])
    after = hypervolume(both[is_nondominated(both)], reference)
    own = hypervolume(run.values, reference)
    gain = 100.0 * (after / before - 1.0)
    table.add_row(name, f"{run.seconds:.1f}", str(len(run.values)), f"{own:.1f}", f"{after:.1f}", f"{gain:.2f}")
