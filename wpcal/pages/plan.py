"""`plan.html`: the plans of a seam: the trade-off chart, the curves of each plan, and the cell moving in 3-D.

``plan.json`` or ``pareto.json`` hold the same numbers; here they are rounded to what a screen shows. The page holds no
clock, path or host name.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.pages.cell import BODY, cell_record, frames_at
from wpcal.pages.html import build_page, json_blob
from wpcal.planning.cell.bodies import body_pairs
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.plan.run import CellRun
from wpcal.planning.plan.run_record import path_check_record, tip_record
from wpcal.planning.search.objectives import Objective

ANGLE_DIGITS, TIME_DIGITS, PLACE_DIGITS = 3, 4, 3  #: The page shows one decimal of a degree, a second and a millimetre.


@dataclass(frozen=True, slots=True, eq=False)
class MethodFront:
    """What one method found by itself."""

    name: str  #: ``ladder`` or ``nsga2``.
    values: FloatArray  #: shape (m, k). Objectives of its m plans, in the order of the page's objectives.
    hypervolume: float  #: Hypervolume that its plans dominate.


def build_plan_page(
    runs: Sequence[CellRun],
    cell: Cell,
    objectives: Sequence[Objective],
    *,
    chosen: int,
    fronts: Sequence[MethodFront] = (),
    part_glb: bytes | None = None,
) -> str:
    """Return the page of the trade-off plans of a seam. A self-contained HTML file, the same for the same runs.

    Raises `InputError` if there is no run, the runs are of different seams, or `chosen` is not one of their rows.

    `part_glb`: The part's triangles, as `wpcal.brep.mesh_glb.write_part_glb` writes them. Without them the page draws
    the part's collision bodies.
    """
    if not 0 <= chosen < len(runs) or len({run.plan.seam for run in runs}) != 1:
        raise InputError(
            f"expected the plans of one seam and one of their rows, got {len(runs)} plans and row {chosen}"
        )
    pairs, names = body_pairs(cell), [objective.name for objective in objectives]
    data = {
        "seam": runs[0].plan.seam,
        "names": names,
        "titles": {objective.name: objective.title for objective in objectives},
        "axes": {"x": names[0], "y": names[-1], "colour": names[1] if len(names) > 2 else None},
        "chosen": chosen,
        "plans": [_plan_record(run) for run in runs],
        "fronts": [_front_record(front, names) for front in fronts],
        "joints": [[joint.name for joint in arm.joints] for arm in (cell.arm, cell.arm2)],
        "pairs": [list(pairs.names(row)) for row in range(len(pairs))],
        **cell_record(cell, shows_frames=False),
    }
    blobs = {} if part_glb is None else {"part": part_glb}
    for row, run in enumerate(runs):
        blobs[f"curves-{row}"] = json_blob(_curves(run, cell))
        blobs[f"frames-{row}"] = frames_at(cell, run.q).astype("<f4").tobytes()
    return build_page(title=f"Plan of seam {runs[0].plan.seam}", entry="plan", body=BODY, data=data, blobs=blobs)


def _front_record(front: MethodFront, names: Sequence[str]) -> dict[str, Any]:
    values = [dict(zip(names, row, strict=True)) for row in front.values.tolist()]
    return {"name": front.name, "hypervolume": front.hypervolume, "values": values}


def _plan_record(run: CellRun) -> dict[str, Any]:
    return {
        "objectives": dict(run.plan.objectives),
        "found_by": run.plan.found_by,
        "freedom": run.verdict.value,
        "check": None if run.check is None else path_check_record(run.check),
        "schedule": run.schedule.describe(),
        "tip": tip_record(run.tip),
        "between_points": run.tip.describe(run.schedule.speed_mm_s),
    }


def _curves(run: CellRun, cell: Cell) -> dict[str, Any]:
    """Return the curves of one run as columns; values of the weld are null outside the weld."""
    plan, rows = run.plan, slice(run.first, run.last + 1)
    return {
        "t": np.round(run.t_s, TIME_DIGITS).tolist(),
        "s": rounded_column(run.along(plan.s_mm), PLACE_DIGITS),
        "first": run.first,
        "last": run.last,
        "joints1": np.round(np.degrees(run.q[:, :JOINTS]), ANGLE_DIGITS).tolist(),
        "joints2": np.round(np.degrees(run.q[:, JOINTS:]), ANGLE_DIGITS).tolist(),
        **{
            name: rounded_column(np.degrees(run.along(getattr(plan, f"{name}_rad"))), ANGLE_DIGITS)
            for name in ("slope", "rotation", "work", "travel")
        },
        "seam": np.round(cell.tool_in_part(run.q[rows])[:, :3, 3], PLACE_DIGITS).tolist(),
        "checked": _checked(run),
    }


def _checked(run: CellRun) -> dict[str, Any] | None:
    check = run.check
    if check is None or not len(check.clearance.pairs):
        return None
    at = np.arange(len(check.s_mm)) / check.refine
    return {
        "t": np.round(np.interp(at, np.arange(len(run)), run.t_s), TIME_DIGITS).tolist(),
        "margin": np.round(check.clearance.margin_mm, PLACE_DIGITS).tolist(),
        "distance": np.round(check.clearance.distance_mm, PLACE_DIGITS).tolist(),
        "pair": check.clearance.pair.tolist(),
    }


def rounded_column(values: FloatArray, digits: int) -> list[float | None]:
    """Return the values of a curve, shape (n,), for a page; null where they are not finite."""
    return [round(value, digits) if math.isfinite(value) else None for value in values.tolist()]
