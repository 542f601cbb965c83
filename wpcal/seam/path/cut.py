"""Places along a run by arc length, and parts of a run between two of them."""

from __future__ import annotations

import numpy as np

from wpcal.brep.curves import evaluate_edges, parameters_at_length
from wpcal.brep.graph import BrepGraph
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.path.direction import Runs
from wpcal.seam.path.discretise import is_even, piece_spans, speeds
from wpcal.seam.seam import SeamPieces


def cut_run(graph: BrepGraph, run: SeamPieces, low_mm: float, high_mm: float) -> SeamPieces:
    """Return the part of a run between two lengths, mm, measured from the start of the run.

    A part that ends on a bridge between two pieces ends with the piece.
    """
    starts, ends = spans_of(graph, run)
    rows = np.flatnonzero((ends > low_mm) & (starts < high_mm))
    part = run.select(rows)
    t0, t1 = part.t0.copy(), part.t1.copy()
    for i, row in enumerate(rows.tolist()):
        if starts[row] < low_mm:
            t0[i] = parameter_at(graph, run, row, low_mm - starts[row])
        if ends[row] > high_mm:
            t1[i] = parameter_at(graph, run, row, high_mm - starts[row])
    return SeamPieces(part.edge, t0, t1, part.wall, part.base, part.gap_mm)


def parameter_at(graph: BrepGraph, run: SeamPieces, row: int, s_mm: float) -> float:
    """Return the parameter of the edge of a piece at a length from the start of the piece."""
    return float(parameters_at(graph, run, np.array([row]), np.array([s_mm]))[0])


def parameters_at(graph: BrepGraph, run: SeamPieces, row: IntArray, s_mm: FloatArray) -> FloatArray:
    """Return the parameters of edges of pieces at lengths from the starts of these pieces, shape (n,).

    `row`: shape (n,). The piece of each length.
    `s_mm`: ndarray, shape (n,).
    """
    t = np.empty(len(row))
    even = is_even(graph, run.edge[row])
    own = row[even]
    t[even] = run.t0[own] + np.sign(run.t1 - run.t0)[own] * s_mm[even] / speeds(graph, run.edge[own])
    for piece in np.unique(row[~even]).tolist():
        here = row == piece
        t[here] = parameters_at_length(
            graph, int(run.edge[piece]), float(run.t0[piece]), float(run.t1[piece]), s_mm[here]
        )
    return t


def points_at(graph: BrepGraph, run: SeamPieces, s_mm: FloatArray) -> FloatArray:
    """Return the points of a run at lengths from its start, shape (n, 3). In `part`, mm.

    `s_mm`: ndarray, shape (n,).
    """
    starts, ends = spans_of(graph, run)
    row = np.minimum(np.searchsorted(ends, s_mm), len(ends) - 1)
    own = np.clip(s_mm - starts[row], 0.0, (ends - starts)[row])
    p = evaluate_edges(graph, run.edge[row], parameters_at(graph, run, row, own))[0]
    on_bridge = np.flatnonzero((s_mm < starts[row]) & (row > 0))
    before = row[on_bridge] - 1
    p0 = evaluate_edges(graph, run.edge[before], run.t1[before])[0]
    share = (s_mm[on_bridge] - ends[before]) / (starts[row[on_bridge]] - ends[before])
    p[on_bridge] = p0 + share[:, None] * (p[on_bridge] - p0)
    return p


def spans_of(graph: BrepGraph, run: SeamPieces) -> tuple[FloatArray, FloatArray]:
    """Return where each piece of one run starts and ends, as lengths from its start, mm (`piece_spans`)."""
    return piece_spans(graph, Runs(run, np.array([0, len(run)])))


def middles(graph: BrepGraph, runs: Runs) -> FloatArray:
    """Return the point at half the length of every run, or the end of the bridge there, shape (n, 3), mm."""
    starts, ends = piece_spans(graph, runs)
    half = ends[runs.start[1:] - 1] / 2
    row = runs.start[:-1] + np.add.reduceat((ends < half[runs.run_of_piece]).astype(np.int64), runs.start[:-1])
    t = parameters_at(graph, runs.pieces, row, np.maximum(half - starts[row], 0.0))
    return evaluate_edges(graph, runs.pieces.edge[row], t)[0]
