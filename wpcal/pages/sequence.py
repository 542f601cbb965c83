"""The page of a sequence (``plan.html``), and of the cell with one robot (``cell.html``).

Both show the cell in 3-D. The page of a sequence also lists all seams, plays the motion, and shows joints and clearance
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
from wpcal.planning.cell.one_robot import CARRIER, TOOL, WORLD, OneRobotCell
from wpcal.planning.cell.one_robot_check import check_one_robot, one_robot_mounts
from wpcal.planning.cell.one_robot_clearance import one_robot_bodies
from wpcal.planning.cell.robot_cell import JOINTS
from wpcal.planning.sequence.plan_sequence import SequenceChoice
from wpcal.planning.sequence.sequence_record import checked_text, position_name, values_record
from wpcal.planning.sequence.timeline import Timeline

GROUPS = {Owner.ROBOT: "robot1", Owner.POSITIONER: "robot2", Owner.BENCH: "bench"}


def build_sequence_page(choice: SequenceChoice, line: Timeline, *, part_glb: bytes | None = None) -> str:
    """Return the page of a sequence. A self-contained HTML file, the same for the same sequence."""
    sequence, cell = choice.sequence, choice.sequence.cell
    T_part = cell.T_part
    data = {
        **_one_robot_record(cell, shows_frames=False),
        "freedom": "free" if sequence.is_free else "not free",
        "checked": checked_text(sequence),
        "axes": list(cell.axis_names),
        "tolerance": round(math.degrees(sequence.targets.position_tol_rad), 1),
        "plans": [
            {"name": preference.value, "chosen": preference is choice.chosen, **values_record(values)}
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
        "margin": [None if math.isinf(value) else round(value, PLACE_DIGITS) for value in line.margin_mm.tolist()],
        "phase": [phase.value for phase in line.phase],
        "piece": line.piece.tolist(),
        "s": [None if math.isnan(value) else round(value, PLACE_DIGITS) for value in line.s_mm.tolist()],
    }
    blobs = {} if part_glb is None else {"part": part_glb}
    blobs |= {"curves": json_blob(curves), "frames": _frames(cell, line.q).astype("<f4").tobytes()}
    return build_page(title=f"Plan of {cell.name}", entry="sequence", body=BODY, data=data, blobs=blobs)


def build_one_robot_page(cell: OneRobotCell) -> str:
    """Return the page of a cell with one robot at home: what its file describes, and what is odd in it.

    Returns str. A self-contained HTML file, the same for the same cell.
    """
    arms = [cell.arm, *([] if cell.positioner is None else [cell.positioner.arm])]
    bases = [cell.T_world_base, *([] if cell.positioner is None else [cell.positioner.T_world_base])]
    data = {
        **_one_robot_record(cell, shows_frames=True),
        "kind": "cell with one robot",
        "pose": "all axes at home",
        "robots": [
            {"robot": name, "arm": arm.name, "base": T.t_mm.tolist(), "mount": mount.tolist()}
            for (name, _, mount), arm, T in zip(one_robot_mounts(cell), arms, bases, strict=True)
        ],
        "carrierNames": _carrier_names(cell),
    }
    blobs = {"frames": _frames(cell, cell.home[None]).astype("<f4").tobytes()}
    return build_page(title=f"Cell {cell.name}", entry="cell", body=BODY, data=data, blobs=blobs)


def _carrier_names(cell: OneRobotCell) -> list[str]:
    names = ["base", *(f"link {link}" for link in range(1, JOINTS)), "flange", "tool", "world"]
    if cell.positioner is not None:
        names += ["positioner, base", *(f"positioner, axis {row + 1}" for row in range(cell.part_row - CARRIER - 1))]
    return [*names, "part"]


def _one_robot_record(cell: OneRobotCell, *, shows_frames: bool) -> dict[str, Any]:
    bases = [cell.T_world_base, *([] if cell.positioner is None else [cell.positioner.T_world_base])]
    return {
        "cell": cell.name,
        "issues": [issue.to_record() for issue in check_one_robot(cell)],
        "bodies": [
            body_record(body, "torch" if body.carrier == TOOL else GROUPS[body.owner])
            for body in one_robot_bodies(cell)
        ],
        "labels": {"robot1": "robot", "robot2": "positioner"},
        "bases": [T.t_mm.tolist() for T in bases],
        "mounts": [
            {"p": p.tolist(), "x": R[:, 0].tolist(), "y": R[:, 1].tolist()} for _, R, p in one_robot_mounts(cell)
        ],
        "floor_z_mm": cell.floor_z_mm,
        "frames": [0, JOINTS, TOOL, *([] if cell.positioner is None else [CARRIER]), cell.part_row],
        "showsFrames": shows_frames,
        "carriers": {"count": cell.part_row + 1, "tool": TOOL, "part": cell.part_row, "world": WORLD},
        "wire_mm": WIRE_MM,
    }


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
        "margin": round(float(piece.check.margin_mm.min()), 1),
        "speed": round(piece.speed_mm_s, 2),
        "from_s": float(line.t_s[rows[0]]),
        "to_s": float(line.t_s[rows[-1]]),
        "points": np.round(piece.candidate.task.p, PLACE_DIGITS).tolist(),
    }


def _frames(cell: OneRobotCell, q: FloatArray) -> FloatArray:
    """Return the upper three rows of every carrier's frame at every state, shape (N, carriers, 3, 4)."""
    frames = [np.broadcast_to(frame.matrices(), (len(q), 4, 4)) for frame in cell.frames(q)]
    return np.stack(frames, axis=1)[:, :, :3]
