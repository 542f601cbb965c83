"""The records of a sequence: ``plan.json`` with all numbers, ``plan.csv`` with one row per state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from wpcal.core.csv_text import csv_text
from wpcal.core.same_bits import product
from wpcal.planning.cell.cell import Cell
from wpcal.planning.sequence.cuts import Unwelded
from wpcal.planning.sequence.plan_sequence import SequenceChoice
from wpcal.planning.sequence.remedies import Help
from wpcal.planning.sequence.timeline import Timeline
from wpcal.planning.sequence.weld_sequence import SequenceValues, WeldPiece, WeldSequence
from wpcal.seam.path.position import weld_rotation, weld_slope

SEQUENCE_SCHEMA = "wpcal/weld-sequence/1"
CSV_DIGITS = 10  #: Significant digits of the table: 1e-8 degrees.


def sequence_record(choice: SequenceChoice, line: Timeline, *, no_program: Mapping[str, str]) -> dict[str, Any]:
    """Return the record of ``plan.json``. Angles in degrees, a rail in mm."""
    sequence = choice.sequence
    cell = sequence.cell
    return {
        "schema": SEQUENCE_SCHEMA,
        "cell": cell.name,
        "units": {"length": "mm", "angle": "deg", "time": "s"},
        "freedom": "free" if sequence.is_free else "not free",
        "checked": checked_text(sequence),
        "axes": list(cell.axis_names),
        "welded_mm": sequence.welded_mm,
        "time_s": float(line.t_s[-1]),
        "position": sequence.targets.position.value,
        "position_tol_deg": math.degrees(sequence.targets.position_tol_rad),
        "chosen": choice.chosen.value,
        "plans": {preference.value: values_record(values) for preference, values in choice.values.items()},
        "T_carrier_part": cell.T_part.to_record(),
        "seams": [_piece(cell, piece, sequence) for piece in sequence.pieces],
        "unwelded": [_unwelded(each) for each in sequence.unwelded],
        "no_program": dict(no_program),
        "points": _points(sequence, line),
    }


def values_record(values: SequenceValues) -> dict[str, float]:
    """Return what plans are compared by as plain values."""
    return {
        "position_deg": values.position_deg,
        "torch_deg": values.torch_deg,
        "motion_deg_per_mm": values.motion_deg_per_mm,
        "time_s": values.time_s,
    }


def checked_text(sequence: WeldSequence) -> str:
    """Say in one line what was compared with what."""
    checks = [piece.check for piece in sequence.pieces] + [path.check for path in sequence.air]
    count = sum(len(check.at) for check in checks)
    least = min(float(check.margin_mm.min()) for check in checks)
    return (
        f"{count} states on all moves; between two of them no body moves farther than is free around it; the least "
        f"distance is at least {least:.1f} mm beyond the safety distance"
    )


def position_name(cell: Cell, piece: WeldPiece) -> tuple[float, float]:
    """Return slope and rotation in the middle of a piece, deg; the rotation is NaN in vertical travel."""
    candidate = piece.candidate
    R = product(cell.part_places(candidate.q[:1])[0, :3, :3], candidate.task.R[len(candidate) // 2])
    return float(np.degrees(weld_slope(R[:, 0]))), float(np.degrees(weld_rotation(R[:, 0], R[:, 2])))


def _piece(cell: Cell, piece: WeldPiece, sequence: WeldSequence) -> dict[str, Any]:
    candidate = piece.candidate
    slope, rotation = position_name(cell, piece)
    s = candidate.task.s_mm
    off = math.degrees(candidate.off_position_rad)
    return {
        "name": piece.name,
        "seam": candidate.task.name,
        "from_mm": float(s[0]),
        "to_mm": float(s[-1]),
        "is_reversed": candidate.is_reversed,
        "external": _degrees(cell, candidate.q[:1])[0][6:],
        "external_end": _degrees(cell, candidate.q[-1:])[0][6:],
        "branch": candidate.branch,
        "slope_deg": slope,
        "rotation_deg": None if math.isnan(rotation) else rotation,
        "off_position_deg": off,
        "in_position": candidate.off_position_rad <= sequence.targets.position_tol_rad,
        "off_torch_deg": math.degrees(candidate.off_torch_rad),
        "speed_mm_s": piece.speed_mm_s,
        "slowed_by": piece.slowed_by,
        "least_margin_mm": float(piece.check.margin_mm.min()),
    }


def _unwelded(gap: Unwelded) -> dict[str, Any]:
    return {
        "seam": gap.seam,
        "from_mm": gap.from_mm,
        "to_mm": gap.to_mm,
        "why": gap.why,
        "help": [_help(each) for each in gap.help],
        "is_searched": gap.is_searched,
    }


def _help(each: Help) -> dict[str, Any]:
    return {
        "text": each.text,
        "turn_deg": each.turn_deg,
        "move_mm": list(each.move_mm),
        "raise_mm": each.raise_mm,
        "from_table_mm": each.from_table_mm,
        "torch_range_deg": each.torch_range_deg,
        "torch_scale": each.torch_scale,
    }


def _degrees(cell: Cell, q: np.ndarray[Any, Any]) -> list[list[float]]:
    """Return axes as files show them: degrees, and a rail in mm."""
    factors = np.full(q.shape[1], 180.0 / math.pi)
    if cell.rail_axis is not None:
        factors[cell.rail_axis] = 1.0
    found: list[list[float]] = (q * factors).tolist()
    return found


def _points(sequence: WeldSequence, line: Timeline) -> list[dict[str, Any]]:
    axes = _degrees(sequence.cell, line.q)
    return [
        {
            "t_s": float(line.t_s[row]),
            "phase": line.phase[row].value,
            "seam": None if line.piece[row] < 0 else sequence.pieces[line.piece[row]].name,
            "s_mm": None if math.isnan(line.s_mm[row]) else float(line.s_mm[row]),
            "axes": axes[row],
            "margin_mm": None if math.isinf(line.margin_mm[row]) else float(line.margin_mm[row]),
        }
        for row in range(len(line))
    ]


def sequence_csv(sequence: WeldSequence, line: Timeline) -> str:
    """Return ``plan.csv``: one row per state; an unknown value is an empty cell."""
    units = ["mm" if column == sequence.cell.rail_axis else "deg" for column in range(len(sequence.cell.axis_names))]
    names = [f"{name}_{unit}" for name, unit in zip(sequence.cell.axis_names, units, strict=True)]
    rows: list[list[object]] = [["point", "t_s", "phase", "seam", "s_mm", *names, "margin_mm"]]
    for number, point in enumerate(_points(sequence, line), start=1):
        numbers = [point["s_mm"], *point["axes"], point["margin_mm"]]
        cells = ["" if value is None else f"{value:.{CSV_DIGITS}g}" for value in numbers]
        rows.append([number, f"{point['t_s']:.{CSV_DIGITS}g}", point["phase"], point["seam"] or "", *cells])
    return csv_text(rows)
