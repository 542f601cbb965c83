"""A sequence as one row of states with times: what the table, the page and the trajectories show."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.planning.sequence.on_line import states_on_lines
from wpcal.planning.sequence.order import axis_seconds
from wpcal.planning.sequence.weld_sequence import WeldPiece, WeldSequence, air_seconds


class SequencePhase(Enum):
    """What leads to a state."""

    AIR = "air"
    APPROACH = "approach"
    WELD = "weld"
    RETRACT = "retract"


@dataclass(frozen=True, slots=True, eq=False)
class Timeline:
    """All states of a sequence."""

    q: FloatArray  #: shape (N, k). All axes, rad and mm.
    t_s: FloatArray  #: shape (N,). Increasing, 0 at home.
    phase: tuple[SequencePhase, ...]
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
    keep = np.concatenate([[True], np.array(seconds[1:]) > 0.0])  # a move that is no move has no time
    rows = np.flatnonzero(keep)
    return Timeline(
        np.array(q)[rows],
        np.cumsum(np.array(seconds)[rows]),
        tuple(phase[row] for row in rows),
        np.array(piece)[rows],
        np.array(s)[rows],
        np.array(margin)[rows],
    )


Block = tuple[list[FloatArray], list[float], list[SequencePhase], list[int], list[float], list[float]]


def _air(sequence: WeldSequence, q: FloatArray, first: int, margin: FloatArray) -> Block:
    seconds = np.concatenate([[0.0], air_seconds(sequence.cell, q)])[first:]
    n = len(q) - first
    return list(q[first:]), seconds.tolist(), [SequencePhase.AIR] * n, [-1] * n, [np.nan] * n, margin[first:].tolist()


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
        SequencePhase.WELD if weld else SequencePhase.APPROACH if place < a else SequencePhase.RETRACT
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
