"""A sequence as one row of states with times: what the table, the page and the trajectories show.

Also here: states between those of a weld, so that straight moves in the joints keep the wire on lines in the part.

A seam is sampled coarsely, and a controller moves the wire on lines and arcs. A trajectory in the joints leaves these
lines between two states, most where the torch turns quickly. There it gets more states, solved by Newton's method.

And the records of a sequence: ``plan.json`` with all numbers, ``plan.csv`` with one row per state.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from wpcal.core.arrays import FloatArray, IntArray, numbered_rows
from wpcal.core.csv_text import csv_text
from wpcal.core.input_file import sha256_of
from wpcal.core.result_files import PART_FILE
from wpcal.core.same_bits import inverse_pose, product, solve
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.plan.run import Phase
from wpcal.planning.plan.run_record import CSV_DIGITS
from wpcal.planning.sequence.kept_plan import PLAN_SCHEMA, KeptPlan, shown_units
from wpcal.planning.sequence.order import axis_seconds
from wpcal.planning.sequence.plan_sequence import SequenceChoice
from wpcal.planning.sequence.weld_sequence import WeldPiece, WeldSequence, air_seconds
from wpcal.seam.path.position import weld_rotation, weld_slope
from wpcal.weld.runs import RunChoice

ON_LINE_MM = 0.02  #: How far the wire may leave a line: less than half of the usual tolerance of a path.
STEPS = 4  #: Of Newton's method: it starts within some tenths of a millimetre, and doubles its digits with each.
SOLVED = 1e-6  #: mm and rad: what is left where Newton's method found the place.


def states_on_lines(cell: Cell, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return states between which straight moves in the axes keep the tip of the wire on lines in the part.

    `q`: shape (n, k). Neighbouring states of a weld with its approach and retract, rad and mm.
    Returns `q`: ndarray, shape (m, k). The given states and those between them; a place that Newton's method does not
    find within the limits is on the straight move in the axes.
    Returns `at`: ndarray, shape (m,). Their places, in steps from the first.
    """
    tool = cell.tool_in_part(q)
    middle = cell.tool_in_part((q[:-1] + q[1:]) / 2)[:, :3, 3]
    off = np.linalg.norm(middle - (tool[:-1, :3, 3] + tool[1:, :3, 3]) / 2, axis=1)
    parts = np.maximum(np.ceil(np.sqrt(off / ON_LINE_MM)), 1.0).astype(int)  # the distance shrinks with the square
    row, number = numbered_rows(parts)
    share = number / parts[row]
    between = np.flatnonzero(share > 0.0)
    found = q[row] + share[:, None] * (q[row + 1] - q[row])
    if len(between):
        one, t = row[between], share[between]
        p = tool[one, :3, 3] + t[:, None] * (tool[one + 1, :3, 3] - tool[one, :3, 3])
        turn = Rotation.from_matrix(tool[one, :3, :3])
        by = (turn.inv() * Rotation.from_matrix(tool[one + 1, :3, :3])).as_rotvec()
        found[between] = _solved(cell, found[between], p, turn * Rotation.from_rotvec(t[:, None] * by))
    return np.concatenate([found, q[-1:]]), np.append(row + share, float(len(parts)))


def _solved(cell: Cell, start: FloatArray, p_part: FloatArray, R_part: Rotation) -> FloatArray:
    """Return states with the tool at places in the part, near given states of shape (n, k)."""
    q = start.copy()
    T_base_part = product(inverse_pose(cell.base_places(q)), cell.part_places(q))
    goal = np.einsum("nij,nj->ni", T_base_part[:, :3, :3], p_part) + T_base_part[:, :3, 3]
    attitude = Rotation.from_matrix(T_base_part[:, :3, :3]) * R_part
    left = np.full((len(q), 6), np.inf)
    for _ in range(STEPS):
        tool = product(cell.arm.forward(q[:, :JOINTS]), cell.T_flange_tool.matrix)
        turn = (attitude * Rotation.from_matrix(tool[:, :3, :3]).inv()).as_rotvec()
        left = np.concatenate([turn, goal - tool[:, :3, 3]], axis=1)
        J = cell.arm.jacobian(q[:, :JOINTS], point=cell.T_flange_tool.t_mm)
        step = solve(J, left[:, :, None])[0][:, :, 0]
        q[:, :JOINTS] += np.where(np.isfinite(step), step, 0.0)
    low, high = cell.limits
    good = (np.abs(left).max(axis=1) < SOLVED) & ((q >= low) & (q <= high)).all(axis=1)
    return np.where(good[:, None], q, start)


@dataclass(frozen=True, slots=True, eq=False)
class Timeline:
    """All states of a sequence."""

    q: FloatArray  #: shape (N, k). All axes, rad and mm.
    t_s: FloatArray  #: shape (N,). Increasing, 0 at home.
    phase: tuple[Phase, ...]
    piece: IntArray  #: shape (N,). Row of the piece, -1 in the air.
    s_mm: FloatArray  #: shape (N,). Arc length along the seam of the file; NaN off the weld.
    margin_mm: FloatArray  #: shape (N,). Lower bounds of the least distance less the safety distance.

    def __len__(self) -> int:
        return len(self.t_s)


def build_timeline(sequence: WeldSequence) -> Timeline:
    """Return all states of a sequence with their times."""
    blocks = []
    for row, path in enumerate(sequence.air):
        first = 0 if row == 0 else 1
        blocks.append(_air(sequence, path.q, first, _at_states(path.check.at, path.check.margin_mm, len(path.q))))
        if row < len(sequence.pieces):
            blocks.append(_weld(sequence, sequence.pieces[row], row))
    q, seconds, phase, piece, s, margin = (list(itertools.chain(*column)) for column in zip(*blocks, strict=True))
    rows = np.flatnonzero([True, *(np.array(seconds[1:]) > 0.0)])  # a move that is no move has no time
    return Timeline(
        np.array(q)[rows],
        np.cumsum(np.array(seconds)[rows]),
        tuple(phase[row] for row in rows),
        np.array(piece)[rows],
        np.array(s)[rows],
        np.array(margin)[rows],
    )


Block = tuple[list[FloatArray], list[float], list[Phase], list[int], list[float], list[float]]


def _air(sequence: WeldSequence, q: FloatArray, first: int, margin: FloatArray) -> Block:
    seconds = np.concatenate([[0.0], air_seconds(sequence.cell, q)])[first:]
    n = len(q) - first
    return list(q[first:]), seconds.tolist(), [Phase.AIR] * n, [-1] * n, [np.nan] * n, margin[first:].tolist()


def _weld(sequence: WeldSequence, piece: WeldPiece, row: int) -> Block:
    states, a, n = piece.states, len(piece.before), len(piece.candidate)
    task = piece.candidate.task
    tip = sequence.cell.tool_places(states)[:, :3, 3]
    air = np.linalg.norm(np.diff(tip, axis=0), axis=1) / sequence.targets.air_speed_mm_s
    steps = np.maximum(air, axis_seconds(states[:-1], states[1:], sequence.cell.speeds))
    steps[a : a + n - 1] = np.diff(task.s_mm) / piece.speed_mm_s
    margin = _at_states(piece.check.at, piece.check.margin_mm, len(states))
    q, at = states_on_lines(sequence.cell, states)
    along = (task.s_mm[0] + task.s_mm[-1] - task.s_mm) if piece.candidate.is_reversed else task.s_mm
    is_weld = (at >= a) & (at <= a + n - 1)
    phase = [
        Phase.WELD if weld else Phase.APPROACH if place < a else Phase.RETRACT
        for place, weld in zip(at.tolist(), is_weld.tolist(), strict=True)
    ]
    s = np.where(is_weld, np.interp(at - a, np.arange(n), along), np.nan)
    t = np.interp(at, np.arange(len(states)), np.concatenate([[0.0], np.cumsum(steps)]))
    # the first state is the end of the way through the air
    return (
        list(q[1:]),
        np.diff(t).tolist(),
        phase[1:],
        [row] * (len(q) - 1),
        s[1:].tolist(),
        margin[at[1:].astype(int)].tolist(),
    )


def _at_states(at: FloatArray, margin: FloatArray, count: int) -> FloatArray:
    """Return the least margin from each state to the next, shape (count,), mm."""
    rows = np.minimum(at.astype(int), count - 1)
    least = np.full(count, np.inf)
    np.minimum.at(least, rows, margin)
    return least


def sequence_record(
    choice: SequenceChoice, line: Timeline, *, inputs: Mapping[str, bytes], planned: Sequence[str], runs: RunChoice
) -> dict[str, Any]:
    """Return the record of ``plan.json``. Angles in degrees, a rail in mm.

    `inputs`: What it was planned from: names and contents of files.
    `planned`: Names of the seams that were asked for.
    `runs`: Which runs their weld data became.
    """
    sequence = choice.sequence
    cell = sequence.cell
    return {
        "schema": PLAN_SCHEMA,
        "cell": cell.name,
        "units": {"length": "mm", "angle": "deg", "time": "s"},
        "freedom": "free" if sequence.is_free else "not free",
        "checked": sequence.checked,
        "open": list(sequence.open_points(has_part=PART_FILE in inputs)),
        "axes": list(cell.axis_names),
        "welded_mm": sequence.welded_mm,
        "time_s": float(line.t_s[-1]),
        "position": sequence.targets.position.value,
        "position_tol_deg": math.degrees(sequence.targets.position_tol_rad),
        "chosen": choice.chosen.value,
        "plans": {preference.value: asdict(values) for preference, values in choice.values.items()},
        "T_carrier_part": cell.T_part.to_record(),
        "seams": [_piece(cell, piece, sequence) for piece in sequence.pieces],
        "unwelded": [asdict(gap) for gap in sequence.unwelded],
        "no_program": {},
        "made_from": {name: sha256_of(data) for name, data in inputs.items()},
        "planned": list(planned),
        "runs": {"tacks": runs.tacks.value, "weave": runs.weave.value, "overlap_mm": runs.overlap_mm},
        "kept": KeptPlan.of(sequence).record(),
        "points": _points(sequence, line),
    }


def position_name(cell: Cell, piece: WeldPiece) -> tuple[float, float]:
    """Return slope and rotation in the middle of a piece, deg; the rotation is NaN in vertical travel."""
    candidate = piece.candidate
    R = product(cell.part_places(candidate.q[:1])[0, :3, :3], candidate.task.R[len(candidate) // 2])
    return float(np.degrees(weld_slope(R[:, 0]))), float(np.degrees(weld_rotation(R[:, 0], R[:, 2])))


def _piece(cell: Cell, piece: WeldPiece, sequence: WeldSequence) -> dict[str, Any]:
    candidate = piece.candidate
    slope, rotation = position_name(cell, piece)
    s, external = candidate.task.s_mm, (candidate.q * shown_units(cell))[:, JOINTS:]
    off = math.degrees(candidate.off_position_rad)
    return {
        "name": piece.name,
        "seam": candidate.task.name,
        "from_mm": float(s[0]),
        "to_mm": float(s[-1]),
        "is_reversed": candidate.is_reversed,
        "external": external[0].tolist(),
        "external_end": external[-1].tolist(),
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


def _points(sequence: WeldSequence, line: Timeline) -> list[dict[str, Any]]:
    axes = (line.q * shown_units(sequence.cell)).tolist()
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
