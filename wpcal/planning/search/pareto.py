"""`ParetoSet`: plans to choose from; which vectors of objectives are not dominated, and the volume they dominate.

Also here: `PlanningResult`: the plans that a search found, and how much each method contributed.

And ``pareto.json``: the plans to choose from, the front of each method, and the volume that each front dominates.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.core.same_bits import first_least
from wpcal.planning.cell.cell_check import check_cell
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.plan.plan import Plan
from wpcal.planning.plan.run import CellRun
from wpcal.planning.plan.run_record import run_verdict, tip_record
from wpcal.planning.search.diagnosis import Obstacle
from wpcal.planning.search.objectives import MOTION, OBJECTIVE_NAMES, POSITION
from wpcal.planning.search.problem import PlanningProblem


class Preference(Enum):
    """Which plan of a front is taken."""

    POSITION = "position"  #: The least deviation from the target weld position.
    SMOOTH = "smooth"  #: The least joint motion.
    BALANCED = "balanced"
    """The plan nearest to the best value of every objective, each scaled by its range over the front."""


MINIMISED = {Preference.POSITION: POSITION, Preference.SMOOTH: MOTION}
"""The one objective that decides; BALANCED weighs all of them."""


@dataclass(frozen=True, slots=True, eq=False)
class ParetoSet:
    """Plans none of which is at least as good as another in every objective.

    Raises `InputError` when there is no plan.
    """

    plans: tuple[Plan, ...]  #: With all objectives of `OBJECTIVES`.

    def __post_init__(self) -> None:
        if not self.plans:
            raise InputError("a front needs at least one plan")

    def __len__(self) -> int:
        return len(self.plans)

    @property
    def values(self) -> FloatArray:
        """Objectives, shape (m, k), in the order of `OBJECTIVES`."""
        return np.array([[plan.objectives[name] for name in OBJECTIVE_NAMES] for plan in self.plans])

    def chosen(self, preference: Preference) -> int:
        """Return the row of the plan that a preference takes."""
        if preference in MINIMISED:
            name = MINIMISED[preference].name
            return int(first_least([plan.objectives[name] for plan in self.plans]))
        values = self.values
        low, high = values.min(axis=0), values.max(axis=0)
        scaled = (values - low) / np.where(high > low, high - low, 1.0)
        return int(first_least(np.linalg.norm(scaled, axis=1)))


def is_nondominated(values: FloatArray) -> BoolArray:
    """Tell which rows no other row beats. A row beats another if it is nowhere worse and somewhere better, shape (m,).

    `values`: shape (m, k). Smaller is better. Of equal rows the first stays.
    """
    no_worse = (values[:, None] <= values).all(axis=2)
    better = (values[:, None] < values).any(axis=2)
    earlier = np.tri(len(values), k=-1, dtype=bool).T  # [i, j]: row i comes before row j
    beats = no_worse & (better | earlier)
    return np.asarray(~beats.any(axis=0))


def thin_front(values: FloatArray, count: int) -> IntArray:
    """Choose rows that are far from each other: the best of each objective first, then always the farthest one.

    `values`: shape (m, k). Scaled by the range of each column for the distances.
    """
    span = np.ptp(values, axis=0)
    scaled = values / np.where(span > 0, span, 1.0)
    chosen = list(dict.fromkeys(int(row) for row in scaled.argmin(axis=0)))[:count]
    nearest = np.min([np.linalg.norm(scaled - scaled[row], axis=1) for row in chosen], axis=0)
    nearest[chosen] = -1.0
    while len(chosen) < min(count, len(values)):
        chosen.append(int(nearest.argmax()))
        nearest = np.minimum(nearest, np.linalg.norm(scaled - scaled[chosen[-1]], axis=1))
        nearest[chosen[-1]] = -1.0
    return np.array(sorted(chosen), dtype=np.int64)


def hypervolume(values: FloatArray, reference: FloatArray) -> float:
    """Return the volume of the points that some row beats and that beat the reference.

    `values`: shape (m, k). Smaller is better. Rows that do not beat the reference in every objective add nothing.
    `reference`: shape (k,). In the units of the objectives.
    Raises `InputError` when the numbers of objectives differ.

    Slices along the last objective: m times the volume of one objective less. Meant for tens of rows and few
    objectives.

    Two squares of side 2 and 3 that share one of side 2 by 1:

    >>> hypervolume(np.array([[1.0, 2.0], [2.0, 0.0]]), np.array([4.0, 4.0]))
    10.0
    """
    if values.ndim != 2 or values.shape[1] != len(reference):
        raise InputError(f"expected rows of {len(reference)} objectives, got shape {values.shape}")
    inside = values[(values < reference).all(axis=1)]
    if len(inside) == 0:
        return 0.0
    if inside.shape[1] == 1:
        return float(reference[0] - inside.min())
    inside = inside[np.argsort(inside[:, -1], kind="stable")]
    heights = np.diff(np.append(inside[:, -1], reference[-1]))
    return float(
        sum(
            height * hypervolume(inside[: i + 1, :-1], reference[:-1]) for i, height in enumerate(heights) if height > 0
        )
    )


@dataclass(frozen=True, slots=True, eq=False)
class PlanningResult:
    """What a search found."""

    problem: PlanningProblem
    front: ParetoSet  #: The best plans of all methods. Every plan was checked by hulls between its points.
    #: `ladder`, `genetic`: The front of the deterministic search alone, and of the genetic algorithm alone.
    ladder: ParetoSet | None
    genetic: ParetoSet | None
    reference: FloatArray  #: shape (k,). Corner of the hypervolumes, in the units of the k objectives.
    interrupted: bool  #: Whether the user ended the search early.
    #: Plans that were removed because the check between their points found bodies too near to each other.
    not_free: int

    def hypervolume_of(self, front: ParetoSet | None) -> float:
        """Return the volume that a front dominates; zero for None."""
        return 0.0 if front is None else hypervolume(front.values, self.reference)


PARETO_SCHEMA = "wpcal/pareto/1"


def pareto_record(
    result: PlanningResult, preference: Preference, runs: Sequence[CellRun] = (), *, no_program: Sequence[str] = ()
) -> dict[str, Any]:
    """Return the record of a search that found plans.

    Returns dict. Angles in degrees. ``fronts`` holds the objectives of each method's own front, in the order of
    ``objectives``.
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
        "robot1_deg": np.degrees(plan.q[:, :JOINTS]),
        "robot2_deg": np.degrees(plan.q[:, JOINTS:]),
        "slope_deg": np.degrees(plan.slope_rad),
        "rotation_deg": np.degrees(plan.rotation_rad),
        "work_deg": np.degrees(plan.work_rad),
        "travel_deg": np.degrees(plan.travel_rad),
    }
