"""``pareto.json``: the plans to choose from, the front of each method, and the volume that each front dominates."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from wpcal.planning.cell.cell_check import check_cell
from wpcal.planning.plan.plan import Plan
from wpcal.planning.plan.run import CellRun
from wpcal.planning.plan.run_record import run_verdict, tip_record
from wpcal.planning.search.objectives import OBJECTIVE_NAMES
from wpcal.planning.search.obstacle import Obstacle
from wpcal.planning.search.pareto import Preference
from wpcal.planning.search.planning_result import PlanningResult
from wpcal.planning.search.problem import PlanningProblem

PARETO_SCHEMA = "wpcal/pareto/1"


def pareto_record(
    result: PlanningResult, preference: Preference, runs: Sequence[CellRun] = (), *, no_program: Sequence[str] = ()
) -> dict[str, Any]:
    """Return the record of a search that found plans.

    Returns
    -------
    dict. Angles in degrees. ``fronts`` holds the objectives of each method's own front, in the order of ``objectives``.
    """
    front = result.front
    chosen = front.chosen(preference)
    return {
        **_head(result.problem),
        "interrupted": result.interrupted,
        "not_free": result.not_free,
        "failed": None,
        "obstacle": None,
        "issues": [issue.to_record() for issue in check_cell(result.problem.cell)],
        "preference": preference.value,
        "chosen": chosen + 1,
        **({"run": run_verdict(runs[chosen])} if runs else {}),
        "no_program": list(no_program),
        "reference": result.reference,
        "hypervolume": result.hypervolume_of(front),
        "fronts": {
            name: {"hypervolume": result.hypervolume_of(group), "values": group.values}
            for name, group in (("ladder", result.ladder), ("nsga2", result.genetic))
            if group is not None
        },
        "plans": [_plan(row, plan, runs[row] if runs else None) for row, plan in enumerate(front.plans)],
    }


def failed_record(problem: PlanningProblem, why: str, obstacle: Obstacle | None = None) -> dict[str, Any]:
    """Return the record of a search that found no feasible plan."""
    return {
        **_head(problem),
        "failed": why,
        "obstacle": None if obstacle is None else obstacle.to_record(),
        "issues": [issue.to_record() for issue in check_cell(problem.cell)],
        "plans": [],
    }


def _head(problem: PlanningProblem) -> dict[str, Any]:
    cell, targets = problem.cell, problem.targets
    return {
        "schema": PARETO_SCHEMA,
        "cell": cell.name,
        "seam": problem.path.name,
        "units": {"length": "mm", "angle": "deg"},
        "speed_mm_s": problem.speed_mm_s,
        "safety_distance_mm": cell.d1_mm,
        "wishes": {
            "slope_deg": math.degrees(targets.slope_rad),
            "rotation_deg": math.degrees(targets.rotation_rad),
            "work_deg": math.degrees(targets.work_rad),
            "travel_deg": math.degrees(targets.travel_rad),
            "slope_range_deg": math.degrees(targets.slope_range_rad),
            "rotation_range_deg": math.degrees(targets.rotation_range_rad),
            "torch_range_deg": math.degrees(targets.torch_range_rad),
        },
        "objectives": list(OBJECTIVE_NAMES),
    }


def _plan(row: int, plan: Plan, run: CellRun | None) -> dict[str, Any]:
    clearance = plan.clearance_mm
    return {
        "plan": row + 1,
        "found_by": plan.found_by,
        "freedom": plan.verdict.value,
        "objectives": dict(plan.objectives),
        "as_printed": dict(plan.printed),
        "least_clearance_mm": None if clearance is None else float(clearance.min()),
        **({} if run is None else {"between_points": tip_record(run.tip)}),
        "s_mm": plan.s_mm,
        "robot1_deg": np.degrees(plan.state.joints1),
        "robot2_deg": np.degrees(plan.state.joints2),
        "slope_deg": np.degrees(plan.slope_rad),
        "rotation_deg": np.degrees(plan.rotation_rad),
        "work_deg": np.degrees(plan.work_rad),
        "travel_deg": np.degrees(plan.travel_rad),
    }
