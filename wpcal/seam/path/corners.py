"""Round the corners of a run: the torch turns smoothly, while the tip follows the edges into the corner and out of it.

Seams are not joined at corners by themselves; runs round a member are (`judge.wrapping`), and what a person joins. At a
corner the direction of travel and the faces change at once. A torch cannot, so its frame turns at a constant rate over
`CORNER_MM` before and after the corner: one rotation from the frame before to the frame after. On the corner of a
plate that is a turn about the normal of the base, at a constant angle to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.path.cut import parameters_at, spans_of
from wpcal.seam.path.direction import Runs
from wpcal.seam.path.discretise import EXACT_STEPS, Stations
from wpcal.seam.path.frames import seam_frames
from wpcal.seam.seam import SeamFrames, SeamPieces

CORNER_MM = 5.0
"""Length before and after a corner on which the torch turns: at 10 mm/s a turn of 90 degrees then takes a second, which
robots do without slowing down."""
CORNER_SHARE = 0.5  #: Largest share of the way to the next corner, or to the end of the run, that is used for it.
SHARP_RAD = float(np.radians(30.0))
"""The direction of travel turns by more at a corner. A seam ends where it turns by more, unless a person says otherwise
(`SeamOptions.split_rad`). Smaller turns stay as they are."""
NEAR_MM = 0.01  #: A station nearer than this to one at a corner is the same.
CORNER_STEP_RAD = float(np.radians(15.0))  #: Largest turn from one station to the next at a corner.


@dataclass(frozen=True, slots=True, eq=False)
class Corners:
    """The corners of one run."""

    #: `low_mm`, `high_mm`: shape (c,). Lengths from the start of the run: where one side ends and the next one begins.
    #: They differ where a straight bridge is between the two.
    low_mm: FloatArray
    high_mm: FloatArray

    def reaches(self, length_mm: float) -> list[tuple[float, float]]:
        """Return the lengths between which the torch turns at each corner of a run of this length."""
        ends = np.concatenate([[0.0], self.high_mm, self.low_mm, [length_mm]])
        count = len(self.low_mm)
        before = np.minimum(CORNER_MM, CORNER_SHARE * (self.low_mm - ends[:count]))
        after = np.minimum(CORNER_MM, CORNER_SHARE * (ends[count + 2 :] - self.high_mm))
        return list(zip((self.low_mm - before).tolist(), (self.high_mm + after).tolist(), strict=True))


def find_corners(graph: BrepGraph, run: SeamPieces) -> Corners:
    """Return the corners of a run: where it turns by more than `SHARP_RAD` from one piece to the next."""
    inner = np.arange(len(run) - 1)
    corner = np.flatnonzero(turns(graph, run, inner, inner + 1) > SHARP_RAD)
    starts, ends = spans_of(graph, run)
    return Corners(ends[corner], starts[corner + 1])


def turns(graph: BrepGraph, pieces: SeamPieces, before: IntArray, after: IntArray) -> FloatArray:
    """Return the angles by which the direction of travel turns from the ends of pieces to the starts of others.

    `before`, `after`: shape (n,). Rows of `pieces`.
    Returns ndarray, shape (n,). rad.
    """
    end, begin = (
        evaluate_edges(graph, pieces.edge[rows], t[rows])[1] * np.sign(pieces.t1 - pieces.t0)[rows, None]
        for rows, t in ((before, pieces.t1), (after, pieces.t0))
    )
    across = np.linalg.norm(np.cross(end, begin), axis=1)
    return np.asarray(np.arctan2(across, np.einsum("ki,ki->k", end, begin)), dtype=np.float64)


def turn_corners(graph: BrepGraph, runs: Runs, stations: Stations, frames: SeamFrames) -> tuple[Stations, SeamFrames]:
    """Let frames turn smoothly round the corners of runs.

    Returns `frames`: Unchanged where there is no corner. Near a corner x is not the tangent of the edge, but turns with
    the torch.
    """
    inner = np.setdiff1d(np.arange(len(runs.pieces)), runs.start[1:] - 1)
    sharp = inner[turns(graph, runs.pieces, inner, inner + 1) > SHARP_RAD]
    bent = set(runs.run_of_piece[sharp].tolist())
    if not bent:
        return stations, frames
    piece, t, own_frames = [], [], []
    for number, (first, end) in enumerate(pairwise(stations.start.tolist())):
        rows = slice(first, end)
        own = Stations(np.array([0, end - first]), stations.piece[rows], stations.t[rows], stations.s_mm[rows])
        of_own = frames.select(slice(first, end))
        if number in bent:
            own, of_own = _turned(graph, runs, number, own, of_own)
        piece.append(own.piece)
        t.append(own.t)
        own_frames.append(of_own)
    start = np.cumsum([0, *(len(rows) for rows in piece)])
    frames = SeamFrames.joined(own_frames)
    return Stations(start, np.concatenate(piece), np.concatenate(t), frames.s_mm), frames


def _turned(
    graph: BrepGraph, runs: Runs, number: int, stations: Stations, frames: SeamFrames
) -> tuple[Stations, SeamFrames]:
    """Return the stations and the frames of one run with smooth corners; its pieces are rows of those of all runs."""
    run, first = runs.run(number), int(runs.start[number])
    corners = find_corners(graph, run)
    reaches = corners.reaches(float(stations.s_mm[-1]))
    kept = np.ones(len(stations.s_mm), dtype=bool)
    places: list[FloatArray] = []
    for (low, high), a, b in zip(reaches, corners.low_mm, corners.high_mm, strict=True):
        kept &= (stations.s_mm < low - NEAR_MM) | (stations.s_mm > high + NEAR_MM)
        places.append(_places(graph, run, low, high, float(a), float(b)))
    s = np.unique(np.concatenate([stations.s_mm[kept], *places]))
    row, t = _on_pieces(graph, run, s)
    along = Stations(np.array([0, len(s)]), row, t, s)
    exact = seam_frames(graph, run, along)
    from scipy.spatial.transform import Rotation

    R = exact.R.copy()
    for low, high in reaches:
        rows = np.flatnonzero((s >= low) & (s <= high))
        before, after = Rotation.from_matrix(exact.R[[rows[0], rows[-1]]])
        share = (s[rows] - low) / (high - low)
        R[rows] = (Rotation.from_rotvec(share[:, None] * (after * before.inv()).as_rotvec()) * before).as_matrix()
    return Stations(along.start, row + first, t, s), SeamFrames(s, exact.p, R, exact.angle_rad, frames.frame)


def _places(graph: BrepGraph, run: SeamPieces, low: float, high: float, a: float, b: float) -> FloatArray:
    """Return lengths between `low` and `high` at which the torch turns by equal steps, with both ends of the corner."""
    row, t = _on_pieces(graph, run, np.array([low, high]))
    ends = seam_frames(graph, run, Stations(np.array([0, 2]), row, t, np.array([low, high])))
    from scipy.spatial.transform import Rotation

    turn = float((Rotation.from_matrix(ends.R[1]) * Rotation.from_matrix(ends.R[0]).inv()).magnitude())
    before, after = (
        max(1, int(np.ceil(turn * side / (high - low) / CORNER_STEP_RAD - EXACT_STEPS))) for side in (a - low, high - b)
    )
    return np.concatenate([np.linspace(low, a, before + 1), np.linspace(b, high, after + 1)])


def _on_pieces(graph: BrepGraph, run: SeamPieces, s_mm: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the piece and the parameter at lengths from the start of a run; on a bridge, the end of the piece."""
    starts, ends = spans_of(graph, run)
    row = np.minimum(np.searchsorted(ends, s_mm), len(ends) - 1)
    row = np.where((s_mm < starts[row]) & (row > 0), row - 1, row)
    return row, parameters_at(graph, run, row, np.clip(s_mm - starts[row], 0.0, (ends - starts)[row]))
