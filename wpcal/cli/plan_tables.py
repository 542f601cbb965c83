"""The tables of `wpcal plan`."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from wpcal.planning.plan.run import CellRun
from wpcal.planning.search.objectives import OBJECTIVES
from wpcal.planning.search.pareto import Preference
from wpcal.planning.search.planning_result import PlanningResult


def show_plans(result: PlanningResult, preference: Preference, run: CellRun, console: Console) -> None:
    """Print the front, the volume that each method dominates, and what is known of the chosen plan.

    Parameters
    ----------
    result : PlanningResult
    preference : Preference
    run : CellRun
        The chosen plan with approach and retract.
    console : Console
    """
    front = result.front
    chosen = front.chosen(preference)
    table = Table(title=f"Plans of seam {front.plans[0].seam}")
    objectives = [f"{objective.label} {objective.unit}" for objective in OBJECTIVES]
    for heading in ("", "found by", *objectives, "least clearance mm"):
        table.add_column(heading, justify="left" if heading == "found by" else "right")
    for row, plan in enumerate(front.plans):
        values = [f"{plan.objectives[objective.name]:.3f}" for objective in OBJECTIVES]
        least = "" if plan.clearance_mm is None else f"{plan.clearance_mm.min():.1f}"
        mark = f"{row + 1} *" if row == chosen else f"{row + 1}"
        table.add_row(mark, plan.found_by, *values, least)
    console.print(table)
    for name, group in (("ladder and least squares", result.ladder), ("NSGA-II", result.genetic)):
        if group is not None:
            console.print(f"{name}: {len(group)} plans, hypervolume {result.hypervolume_of(group):.4g}")
    console.print(f"together: {len(front)} plans, hypervolume {result.hypervolume_of(front):.4g}")
    if result.interrupted:
        console.print("the search was interrupted; these are the best plans so far")
    console.print(f"chosen (*, {preference.value}): {run.schedule.describe()}; {run.verdict.value}")
    if run.check is not None:
        console.print(run.check.describe())
