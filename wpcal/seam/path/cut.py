"""Places along a run by arc length, and parts of a run between two of them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wpcal.brep.curves import evaluate_edges, parameters_at_length
from wpcal.brep.graph import BrepGraph
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.path.direction import Runs
from wpcal.seam.path.discretise import is_even, piece_spans, run_lengths, speeds
from wpcal.seam.seam import SeamPieces


def cut_run(graph: BrepGraph, run: SeamPieces, low_mm: float, high_mm: float) -> SeamPieces:
    """Return the part of a run between two lengths, mm, measured from the start of the run.

    A part that ends on a bridge between two pieces ends with the piece.
    """
    starts, ends = spans_of(graph, run)
    rows = np.flatnonzero((ends > low_mm) & (starts < high_mm))
    part = run.select(rows)
    t0, t1 = part.t0.copy(), part.t1.copy()
    for t, mm, is_cut in ((t0, low_mm, starts[rows] < low_mm), (t1, high_mm, ends[rows] > high_mm)):
        t[is_cut] = parameters_at(graph, run, rows[is_cut], mm - starts[rows[is_cut]])
    return SeamPieces(part.edge, t0, t1, part.wall, part.base, part.gap_mm)


def parameters_at(graph: BrepGraph, run: SeamPieces, row: IntArray, s_mm: FloatArray) -> FloatArray:
    """Return the parameters of edges of pieces at lengths from the starts of these pieces, shape (n,).

    `row`: shape (n,). The piece of each length.
    `s_mm`: ndarray, shape (n,).
    """
    t = np.empty(len(row))
    even = is_even(graph, run.edge[row])
    own = row[even]
    t[even] = run.t0[own] + np.sign(run.t1 - run.t0)[own] * s_mm[even] / speeds(graph, run.edge[own])
    uneven = np.flatnonzero(~even)
    for piece, here in by_number(row[uneven]):
        at = uneven[here]
        t[at] = parameters_at_length(graph, int(run.edge[piece]), float(run.t0[piece]), float(run.t1[piece]), s_mm[at])
    return t


def by_number(numbers: IntArray) -> Iterator[tuple[int, IntArray]]:
    """Yield every number in `numbers`, shape (n,), and the rows that have it, both ascending."""
    order = np.argsort(numbers, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(numbers[order])) + 1) if len(order) else ():
        yield int(numbers[rows[0]]), rows


def places_at(graph: BrepGraph, runs: Runs, run: IntArray | int, s_mm: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return pieces at lengths from the starts of runs, shape (n,), and parameters; on a bridge, those after it."""
    starts, ends = piece_spans(graph, runs)
    row = np.searchsorted(runs.run_of_piece + 1j * ends, run + 1j * s_mm)  # by run, then length
    row = np.minimum(row, runs.start[run + 1] - 1)
    return row, parameters_at(graph, runs.pieces, row, np.clip(s_mm - starts[row], 0.0, (ends - starts)[row]))


def points_at(graph: BrepGraph, runs: Runs, run: IntArray, s_mm: FloatArray) -> FloatArray:
    """Return the points of runs at lengths from their starts, shape (n, 3). In `part`, mm.

    `run`: shape (n,). The run of each length.
    `s_mm`: ndarray, shape (n,).
    """
    (starts, ends), edge = piece_spans(graph, runs), runs.pieces.edge
    row, t = places_at(graph, runs, run, s_mm)
    p = evaluate_edges(graph, edge[row], t)[0]
    on_bridge = np.flatnonzero((s_mm < starts[row]) & (row > runs.start[run]))
    before = row[on_bridge] - 1
    p0 = evaluate_edges(graph, edge[before], runs.pieces.t1[before])[0]
    share = (s_mm[on_bridge] - ends[before]) / (starts[row[on_bridge]] - ends[before])
    p[on_bridge] = p0 + share[:, None] * (p[on_bridge] - p0)
    return p


def spans_of(graph: BrepGraph, run: SeamPieces) -> tuple[FloatArray, FloatArray]:
    """Return where each piece of one run starts and ends, as lengths from its start, mm (`piece_spans`)."""
    return piece_spans(graph, Runs.of([run]))


def middles(graph: BrepGraph, runs: Runs) -> FloatArray:
    """Return the point at half the length of every run, or the end of the bridge there, shape (n, 3), mm."""
    row, t = places_at(graph, runs, np.arange(len(runs)), run_lengths(graph, runs) / 2)
    return evaluate_edges(graph, runs.pieces.edge[row], t)[0]
