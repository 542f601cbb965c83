"""The page of a tour (``plan.html``), and of the cell with one robot (``cell.html``).

Both show the cell in 3-D. The page of a tour also lists all seams, plays the motion, and shows joints and clearance
over time. ``plan.json`` holds the same numbers; here they are rounded to what a screen shows.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.pages.html import build_page, json_blob
from wpcal.pages.plan import ANGLE_DIGITS, BODY, PLACE_DIGITS, TIME_DIGITS, WIRE_MM, body_record
from wpcal.planning.cell.bodies import Owner
from wpcal.planning.cell.robot_cell import JOINTS
from wpcal.planning.cell.station import CARRIER, TOOL, WORLD, Station
from wpcal.planning.cell.station_check import check_station, station_mounts
from wpcal.planning.cell.station_clearance import station_bodies
from wpcal.planning.tour.plan_tour import TourChoice
from wpcal.planning.tour.timeline import Timeline
from wpcal.planning.tour.tour_record import checked_text, position_name, values_record

GROUPS = {Owner.ROBOT: "robot1", Owner.POSITIONER: "robot2", Owner.BENCH: "bench"}


def build_tour_page(choice: TourChoice, line: Timeline, *, part_glb: bytes | None = None) -> str:
    """Return the page of a tour.

    Parameters
    ----------
    choice : TourChoice
    line : Timeline
        Of the chosen tour.
    part_glb : bytes, optional
        The part's triangles, as `wpcal.brep.mesh_glb.write_part_glb` writes them.

    Returns
    -------
    str
        A self-contained HTML file, the same for the same tour.
    """
    tour, station = choice.tour, choice.tour.station
    T_part = station.T_part
    data = {
        **_station_record(station, shows_frames=False),
        "freedom": "free" if tour.is_free else "not free",
        "checked": checked_text(tour),
        "axes": list(station.axis_names),
        "tolerance": round(math.degrees(tour.targets.position_tol_rad), 1),
        "plans": [
            {"name": preference.value, "chosen": preference is choice.chosen, **values_record(values)}
            for preference, values in choice.values.items()
        ],
        "seams": [_seam(choice, row, line) for row in range(len(tour.pieces))],
        "unwelded": [gap.describe() for gap in tour.unwelded],
        "place": T_part.to_record(),
    }
    factors = np.full(line.q.shape[1], 180.0 / math.pi)
    if station.rail_axis is not None:
        factors[station.rail_axis] = 1.0
    curves = {
        "t": np.round(line.t_s, TIME_DIGITS).tolist(),
        "axes": np.round(line.q * factors, ANGLE_DIGITS).tolist(),
        "margin": [None if math.isinf(value) else round(value, PLACE_DIGITS) for value in line.margin_mm.tolist()],
        "phase": [phase.value for phase in line.phase],
        "piece": line.piece.tolist(),
        "s": [None if math.isnan(value) else round(value, PLACE_DIGITS) for value in line.s_mm.tolist()],
    }
    blobs = {} if part_glb is None else {"part": part_glb}
    blobs |= {"curves": json_blob(curves), "frames": _frames(station, line.q).astype("<f4").tobytes()}
    return build_page(title=f"Plan of {station.name}", entry="tour", body=BODY, data=data, blobs=blobs)


def build_station_page(station: Station) -> str:
    """Return the page of a cell with one robot at home: what its file describes, and what is odd in it.

    Parameters
    ----------
    station : Station

    Returns
    -------
    str
        A self-contained HTML file, the same for the same cell.
    """
    arms = [station.arm, *([] if station.positioner is None else [station.positioner.arm])]
    bases = [station.T_world_base, *([] if station.positioner is None else [station.positioner.T_world_base])]
    data = {
        **_station_record(station, shows_frames=True),
        "kind": "cell with one robot",
        "pose": "all axes at home",
        "robots": [
            {"robot": name, "arm": arm.name, "base": T.t_mm.tolist(), "mount": mount.tolist()}
            for (name, _, mount), arm, T in zip(station_mounts(station), arms, bases, strict=True)
        ],
        "carrierNames": _carrier_names(station),
    }
    blobs = {"frames": _frames(station, station.home[None]).astype("<f4").tobytes()}
    return build_page(title=f"Cell {station.name}", entry="cell", body=BODY, data=data, blobs=blobs)


def _carrier_names(station: Station) -> list[str]:
    names = ["base", *(f"link {link}" for link in range(1, JOINTS)), "flange", "tool", "world"]
    if station.positioner is not None:
        names += ["positioner, base", *(f"positioner, axis {row + 1}" for row in range(station.part_row - CARRIER - 1))]
    return [*names, "part"]


def _station_record(station: Station, *, shows_frames: bool) -> dict[str, Any]:
    bases = [station.T_world_base, *([] if station.positioner is None else [station.positioner.T_world_base])]
    return {
        "cell": station.name,
        "issues": [issue.to_record() for issue in check_station(station)],
        "bodies": [
            body_record(body, "torch" if body.carrier == TOOL else GROUPS[body.owner])
            for body in station_bodies(station)
        ],
        "labels": {"robot1": "robot", "robot2": "positioner"},
        "bases": [T.t_mm.tolist() for T in bases],
        "mounts": [
            {"p": p.tolist(), "x": R[:, 0].tolist(), "y": R[:, 1].tolist()} for _, R, p in station_mounts(station)
        ],
        "floor_z_mm": station.floor_z_mm,
        "frames": [0, JOINTS, TOOL, *([] if station.positioner is None else [CARRIER]), station.part_row],
        "showsFrames": shows_frames,
        "carriers": {"count": station.part_row + 1, "tool": TOOL, "part": station.part_row, "world": WORLD},
        "wire_mm": WIRE_MM,
    }


def _seam(choice: TourChoice, row: int, line: Timeline) -> dict[str, Any]:
    tour = choice.tour
    piece = tour.pieces[row]
    slope, rotation = position_name(tour.station, piece)
    rows = np.flatnonzero((line.piece == row) & ~np.isnan(line.s_mm))
    return {
        "name": piece.name,
        "length": round(piece.candidate.task.length_mm, 1),
        "reversed": piece.candidate.is_reversed,
        "slope": round(slope, 1),
        "rotation": None if math.isnan(rotation) else round(rotation, 1),
        "off": round(math.degrees(piece.candidate.off_position_rad), 1),
        "margin": round(float(piece.check.margin_mm.min()), 1),
        "speed": round(piece.speed_mm_s, 2),
        "from_s": float(line.t_s[rows[0]]),
        "to_s": float(line.t_s[rows[-1]]),
        "points": np.round(piece.candidate.task.p, PLACE_DIGITS).tolist(),
    }


def _frames(station: Station, q: FloatArray) -> FloatArray:
    """Return the upper three rows of every carrier's frame at every state, shape (N, carriers, 3, 4)."""
    frames = [np.broadcast_to(frame.matrices(), (len(q), 4, 4)) for frame in station.frames(q)]
    return np.stack(frames, axis=1)[:, :, :3]
