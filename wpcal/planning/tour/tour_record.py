"""The records of a tour: ``plan.json`` with all numbers, ``plan.csv`` with one row per state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from wpcal.core.csv_text import csv_text
from wpcal.planning.cell.station import Station
from wpcal.planning.tour.cuts import Unwelded
from wpcal.planning.tour.plan_tour import TourChoice
from wpcal.planning.tour.timeline import Timeline
from wpcal.planning.tour.tour import Tour, TourValues, WeldPiece
from wpcal.seam.path.position import weld_rotation, weld_slope

TOUR_SCHEMA = "wpcal/tour/1"
CSV_DIGITS = 10
"""Significant digits of the table: 1e-8 degrees."""


def tour_record(choice: TourChoice, line: Timeline, *, no_program: Mapping[str, str]) -> dict[str, Any]:
    """Return the record of ``plan.json``.

    Parameters
    ----------
    choice : TourChoice
    line : Timeline
        Of the chosen tour.
    no_program : mapping of str to str
        Why there is no program, by the language.

    Returns
    -------
    dict
        Angles in degrees, a rail in mm.
    """
    tour = choice.tour
    station = tour.station
    return {
        "schema": TOUR_SCHEMA,
        "cell": station.name,
        "units": {"length": "mm", "angle": "deg", "time": "s"},
        "freedom": "free" if tour.is_free else "not free",
        "checked": checked_text(tour),
        "axes": list(station.axis_names),
        "welded_mm": tour.welded_mm,
        "time_s": float(line.t_s[-1]),
        "position": tour.targets.position.value,
        "position_tol_deg": math.degrees(tour.targets.position_tol_rad),
        "chosen": choice.chosen.value,
        "plans": {preference.value: values_record(values) for preference, values in choice.values.items()},
        "T_carrier_part": station.T_part.to_record(),
        "seams": [_piece(station, piece, tour) for piece in tour.pieces],
        "unwelded": [_unwelded(each) for each in tour.unwelded],
        "no_program": dict(no_program),
        "points": _points(tour, line),
    }


def values_record(values: TourValues) -> dict[str, float]:
    """Return what plans are compared by as plain values."""
    return {
        "position_deg": values.position_deg,
        "torch_deg": values.torch_deg,
        "motion_deg_per_mm": values.motion_deg_per_mm,
        "time_s": values.time_s,
    }


def checked_text(tour: Tour) -> str:
    """Say in one line what was compared with what."""
    checks = [piece.check for piece in tour.pieces] + [path.check for path in tour.air]
    count = sum(len(check.at) for check in checks)
    least = min(float(check.margin_mm.min()) for check in checks)
    return (
        f"{count} states on all moves; between two of them no body moves farther than is free around it; the least "
        f"distance is at least {least:.1f} mm beyond the safety distance"
    )


def position_name(station: Station, piece: WeldPiece) -> tuple[float, float]:
    """Return slope and rotation in the middle of a piece, deg; the rotation is NaN in vertical travel."""
    candidate = piece.candidate
    R = station.part_places(candidate.q[:1])[0, :3, :3] @ candidate.task.R[len(candidate) // 2]
    return float(np.degrees(weld_slope(R[:, 0]))), float(np.degrees(weld_rotation(R[:, 0], R[:, 2])))


def _piece(station: Station, piece: WeldPiece, tour: Tour) -> dict[str, Any]:
    candidate = piece.candidate
    slope, rotation = position_name(station, piece)
    s = candidate.task.s_mm
    off = math.degrees(candidate.off_position_rad)
    return {
        "name": piece.name,
        "seam": candidate.task.name,
        "from_mm": float(s[0]),
        "to_mm": float(s[-1]),
        "is_reversed": candidate.is_reversed,
        "external": _degrees(station, candidate.q[:1])[0][6:],
        "branch": candidate.branch,
        "slope_deg": slope,
        "rotation_deg": None if math.isnan(rotation) else rotation,
        "off_position_deg": off,
        "in_position": candidate.off_position_rad <= tour.targets.position_tol_rad,
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
        "help": [{"text": h.text, "turn_deg": h.turn_deg, "move_mm": list(h.move_mm)} for h in gap.help],
    }


def _degrees(station: Station, q: np.ndarray[Any, Any]) -> list[list[float]]:
    """Return axes as files show them: degrees, and a rail in mm."""
    factors = np.full(q.shape[1], 180.0 / math.pi)
    if station.rail_axis is not None:
        factors[station.rail_axis] = 1.0
    found: list[list[float]] = (q * factors).tolist()
    return found


def _points(tour: Tour, line: Timeline) -> list[dict[str, Any]]:
    axes = _degrees(tour.station, line.q)
    return [
        {
            "t_s": float(line.t_s[row]),
            "phase": line.phase[row].value,
            "seam": None if line.piece[row] < 0 else tour.pieces[line.piece[row]].name,
            "s_mm": None if math.isnan(line.s_mm[row]) else float(line.s_mm[row]),
            "axes": axes[row],
            "margin_mm": None if math.isinf(line.margin_mm[row]) else float(line.margin_mm[row]),
        }
        for row in range(len(line))
    ]


def tour_csv(tour: Tour, line: Timeline) -> str:
    """Return ``plan.csv``: one row per state; an unknown value is an empty cell."""
    units = ["mm" if column == tour.station.rail_axis else "deg" for column in range(len(tour.station.axis_names))]
    names = [f"{name}_{unit}" for name, unit in zip(tour.station.axis_names, units, strict=True)]
    rows: list[list[object]] = [["point", "t_s", "phase", "seam", "s_mm", *names, "margin_mm"]]
    for number, point in enumerate(_points(tour, line), start=1):
        numbers = [point["s_mm"], *point["axes"], point["margin_mm"]]
        cells = ["" if value is None else f"{value:.{CSV_DIGITS}g}" for value in numbers]
        rows.append([number, f"{point['t_s']:.{CSV_DIGITS}g}", point["phase"], point["seam"] or "", *cells])
    return csv_text(rows)
