"""The records of a run: JSON with all digits, CSV with one row per state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from wpcal.core.csv_text import csv_text
from wpcal.core.input_file import sha256_of
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_check import check_cell
from wpcal.planning.plan.coordinated import CoordinatedRun
from wpcal.planning.plan.recheck import PathCheck, TipMotion
from wpcal.planning.plan.run import CellRun
from wpcal.robot.moves import Arc

PLAN_SCHEMA = "wpcal/plan/1"
CSV_DIGITS = 10  #: Significant digits of the table: 1e-8 degrees.


def run_record(
    run: CellRun,
    cell: Cell,
    coordinated: Mapping[str, CoordinatedRun] | None = None,
    *,
    inputs: Mapping[str, bytes] | None = None,
) -> dict[str, Any]:
    """Return the record of ``plan.json``; `inputs` are the files from which the plan was made.

    Returns dict. Angles in degrees. ``points`` has one entry per state. Values that exist only on the weld are null
    elsewhere.
    """
    plan = run.plan
    return {
        "schema": PLAN_SCHEMA,
        "cell": cell.name,
        "seam": plan.seam,
        "found_by": plan.found_by,
        "units": {"length": "mm", "angle": "deg", "time": "s"},
        "objectives": dict(plan.objectives),
        "as_printed": dict(plan.printed),
        **run_verdict(run),
        "issues": [issue.to_record() for issue in check_cell(cell)],
        "robots": [{"arm": arm.name, "joints": [joint.name for joint in arm.joints]} for arm in (cell.arm, cell.arm2)],
        "coordinated": [coordinated_record(language, one) for language, one in (coordinated or {}).items()],
        "points": _points(run),
        "made_from": {name: sha256_of(raw) for name, raw in (inputs or {}).items()},
    }


def coordinated_record(language: str, found: CoordinatedRun) -> dict[str, Any]:
    """Return a coordinated motion as plain values: its moves, and how far it is from the seam and from the plan."""
    moves = found.moves
    arcs = sum(isinstance(move, Arc) for move in moves.moves)
    return {
        "language": language,
        "holder_moves": found.holder.value,
        "lines": len(moves.moves) - arcs,
        "arcs": arcs,
        "s_mm": moves.s_mm[moves.ends].tolist(),
        "wire_off_mm": moves.off_mm,
        "wire_off_deg": float(np.degrees(moves.off_rad)),
        "part_turned_deg": float(np.degrees(found.part_turned_rad)),
        "part_off_mm": found.part_off_mm,
        "freedom": found.check.verdict.value,
        "check": path_check_record(found.check),
    }


def run_verdict(run: CellRun) -> dict[str, Any]:
    """Return what is known of a run as plain values: its speed and time, collisions, and the tip between the points."""
    schedule, limit = run.schedule, run.schedule.limit
    return {
        "speed_mm_s": schedule.speed_mm_s,
        "asked_mm_s": schedule.asked_mm_s,
        "weld_s": float(schedule.t_s[-1]),
        "speed_limit": None if limit is None else asdict(limit),
        "freedom": run.verdict.value,
        "check": None if run.check is None else path_check_record(run.check),
        "between_points": tip_record(run.tip),
    }


def tip_record(tip: TipMotion) -> dict[str, Any]:
    """Return the motion of the tip between the points as plain values."""
    return {
        "largest_tip_error_mm": tip.error_mm,
        "s_mm": tip.s_mm,
        "slowest_mm_s": tip.slowest_mm_s,
        "fastest_mm_s": tip.fastest_mm_s,
    }


def path_check_record(check: PathCheck) -> dict[str, Any]:
    """Return the result of a check as plain values: the step, and the least margin with its place and bodies."""
    row = check.worst
    has_pair = check.clearance.pair[row] >= 0
    return {
        "method": "convex hulls, capsules where a body has none",
        "steps_cut_into": check.refine,
        "states": len(check.s_mm),
        "least_distance_mm": float(check.clearance.distance_mm[row]) if has_pair else None,
        "least_margin_mm": float(check.clearance.margin_mm[row]) if has_pair else None,
        "between": list(check.clearance.nearest(row)) if has_pair else None,
        "s_mm": float(check.s_mm[row]),
        "largest_motion_between_states_mm": check.motion_mm,
        "largest_tip_error_mm": check.tip_error_mm,
    }


def _points(run: CellRun) -> list[dict[str, Any]]:
    plan, check = run.plan, run.check
    nearest = np.full(len(run), np.nan)
    if check is not None and len(check.clearance.pairs):
        nearest = check.clearance.distance_mm[:: check.refine]
    columns = {
        "s_mm": run.along(plan.s_mm),
        "slope_deg": np.degrees(run.along(plan.slope_rad)),
        "rotation_deg": np.degrees(run.along(plan.rotation_rad)),
        "work_deg": np.degrees(run.along(plan.work_rad)),
        "travel_deg": np.degrees(run.along(plan.travel_rad)),
        "clearance_mm": nearest,
    }
    one, two = (np.degrees(q).tolist() for q in np.split(run.q, 2, axis=1))
    return [
        {
            "mark": row + 1,
            "phase": phase.value,
            "t_s": float(run.t_s[row]),
            "robot1_deg": one[row],
            "robot2_deg": two[row],
            **{name: None if np.isnan(values[row]) else float(values[row]) for name, values in columns.items()},
        }
        for row, phase in enumerate(run.phases)
    ]


def run_csv(run: CellRun, cell: Cell) -> str:
    """Return ``plan.csv``: one row per state with the values of `run_record`; an unknown value is an empty cell."""
    joints = [
        f"r{robot}_{joint.name}_deg" for robot, arm in enumerate((cell.arm, cell.arm2), 1) for joint in arm.joints
    ]
    rest = ("s_mm", "slope_deg", "rotation_deg", "work_deg", "travel_deg", "clearance_mm")
    rows = [["mark", "phase", "t_s", *joints, *rest]]
    for point in _points(run):
        numbers = [point["t_s"], *point["robot1_deg"], *point["robot2_deg"], *(point[name] for name in rest)]
        cells = ["" if value is None else f"{value:.{CSV_DIGITS}g}" for value in numbers]
        rows.append([point["mark"], point["phase"], *cells])
    return csv_text(rows)
