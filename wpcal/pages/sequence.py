"""The page of a sequence (``plan.html``).

The page shows the cell in 3-D, lists all seams, plays the motion, and shows joints and clearance
over time. ``plan.json`` holds the same numbers; here they are rounded to what a screen shows.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from wpcal.pages.cell import BODY, cell_record, frames_at
from wpcal.pages.html import build_page, json_blob
from wpcal.pages.plan import ANGLE_DIGITS, PLACE_DIGITS, TIME_DIGITS, rounded_column
from wpcal.planning.sequence.plan_sequence import SequenceChoice
from wpcal.planning.sequence.timeline import Timeline, position_name


def build_sequence_page(choice: SequenceChoice, line: Timeline, *, part_glb: bytes | None = None) -> str:
    """Return the page of a sequence. A self-contained HTML file, the same for the same sequence."""
    sequence, cell = choice.sequence, choice.sequence.cell
    T_part = cell.T_part
    data = {
        **cell_record(cell, shows_frames=False),
        "freedom": "free" if sequence.is_free else "not free",
        "checked": sequence.checked,
        "open": list(sequence.open_points(has_part=part_glb is not None)),
        "axes": list(cell.axis_names),
        "tolerance": round(math.degrees(sequence.targets.position_tol_rad), 1),
        "plans": [
            {"name": preference.value, "chosen": preference is choice.chosen, **asdict(values)}
            for preference, values in choice.values.items()
        ],
        "seams": [_seam(choice, row, line) for row in range(len(sequence.pieces))],
        "unwelded": [gap.describe() for gap in sequence.unwelded],
        "place": T_part.to_record(),
    }
    factors = np.full(line.q.shape[1], 180.0 / math.pi)
    if cell.rail_axis is not None:
        factors[cell.rail_axis] = 1.0
    curves = {
        "t": np.round(line.t_s, TIME_DIGITS).tolist(),
        "axes": np.round(line.q * factors, ANGLE_DIGITS).tolist(),
        "margin": rounded_column(line.margin_mm, PLACE_DIGITS),
        "phase": [phase.value for phase in line.phase],
        "piece": line.piece.tolist(),
        "s": rounded_column(line.s_mm, PLACE_DIGITS),
    }
    blobs = {} if part_glb is None else {"part": part_glb}
    blobs |= {"curves": json_blob(curves), "frames": frames_at(cell, line.q).astype("<f4").tobytes()}
    return build_page(title=f"Plan of {cell.name}", entry="sequence", body=BODY, data=data, blobs=blobs)


def _seam(choice: SequenceChoice, row: int, line: Timeline) -> dict[str, Any]:
    sequence = choice.sequence
    piece = sequence.pieces[row]
    slope, rotation = position_name(sequence.cell, piece)
    rows = np.flatnonzero((line.piece == row) & ~np.isnan(line.s_mm))
    return {
        "name": piece.name,
        "length": round(piece.candidate.task.length_mm, 1),
        "reversed": piece.candidate.is_reversed,
        "slope": round(slope, 1),
        "rotation": None if math.isnan(rotation) else round(rotation, 1),
        "off": round(math.degrees(piece.candidate.off_position_rad), 1),
        "alone": [len(way) - 1 for way in (sequence.ways[row].from_home, sequence.ways[row].to_home)],
        "margin": round(float(piece.check.margin_mm.min()), 1),
        "speed": round(piece.speed_mm_s, 2),
        "from_s": float(line.t_s[rows[0]]),
        "to_s": float(line.t_s[rows[-1]]),
        "points": np.round(piece.candidate.task.p, PLACE_DIGITS).tolist(),
    }
