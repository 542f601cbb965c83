"""The tables of `wpcal plan`."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from wpcal.cli.console import new_table
from wpcal.planning.plan.run import CellRun
from wpcal.planning.search.objectives import OBJECTIVES
from wpcal.planning.search.pareto import ParetoSet, PlanningResult, Preference


def _plans_table(front: ParetoSet, chosen: int, runs: Sequence[CellRun]) -> Table:
    objectives = "|".join(f"{objective.label} {objective.unit}" for objective in OBJECTIVES)
    headings = f"|<found by|{objectives}|least clearance mm|tip error mm|tip speed mm/s"
    table = new_table(f"Plans of seam {front.plans[0].seam}", headings)
    for row, (plan, tip) in enumerate(zip(front.plans, (run.tip for run in runs), strict=True)):
        values = [f"{plan.objectives[objective.name]:.3f}" for objective in OBJECTIVES]
        least = "" if plan.clearance_mm is None else f"{plan.clearance_mm.min():.1f}"
        mark = f"{row + 1} *" if row == chosen else f"{row + 1}"
        speed = f"{tip.slowest_mm_s:.1f} to {tip.fastest_mm_s:.1f}"
        table.add_row(mark, plan.found_by, *values, least, f"{tip.error_mm:.2f}", speed)
    return table


def show_plans(result: PlanningResult, preference: Preference, runs: Sequence[CellRun], console: Console) -> None:
    """Print the front, the volume that each method dominates, and what is known of the chosen plan."""
    front = result.front
    chosen = front.chosen(preference)
    run = runs[chosen]
    console.print(_plans_table(front, chosen, runs))
    for name, group in (("ladder and least squares", result.ladder), ("NSGA-II", result.genetic)):
        if group is not None:
            console.print(f"{name}: {len(group)} plans, hypervolume {result.hypervolume_of(group):.4g}")
    console.print(f"together: {len(front)} plans, hypervolume {result.hypervolume_of(front):.4g}")
    if result.interrupted:
        console.print("the search was interrupted; these are the best plans so far")
    console.print(f"chosen (*, {preference.value}): {run.schedule.describe()}; {run.verdict.value}")
    if run.check is not None:
        console.print(run.check.describe())
