"""Places along a run by arc length, and parts of a run between two of them."""

from __future__ import annotations

import numpy as np

from wpcal.brep.curves import arc_length, evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.core.arrays import FloatArray
from wpcal.seam.path.direction import Runs
from wpcal.seam.path.discretise import is_even, run_lengths, speeds
from wpcal.seam.seam import SeamPieces

HALVINGS = 60
"""Bisections of a parameter interval to find the place at a given length: to the last bit."""


def cut_run(graph: BrepGraph, run: SeamPieces, low_mm: float, high_mm: float) -> SeamPieces:
    """Return the part of a run between two lengths, mm, measured from the start of the run."""
    lengths = piece_lengths(graph, run)
    ends = np.cumsum(lengths)
    starts = ends - lengths
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
    edge, t0, t1 = int(run.edge[row]), float(run.t0[row]), float(run.t1[row])
    if is_even(graph, run.edge[row]):
        return t0 + float(np.sign(t1 - t0) * s_mm / speeds(graph, run.edge[row]))
    low, high = t0, t1
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if abs(arc_length(graph, edge, t0, middle)) < s_mm else (low, middle)
    return (low + high) / 2


def points_at(graph: BrepGraph, run: SeamPieces, s_mm: FloatArray) -> FloatArray:
    """Return the points of a run at lengths from its start.

    Parameters
    ----------
    graph : BrepGraph
    run : SeamPieces
    s_mm : ndarray, shape (n,)

    Returns
    -------
    ndarray, shape (n, 3)
        In `part`, mm.
    """
    lengths = piece_lengths(graph, run)
    ends = np.cumsum(lengths)
    row = np.minimum(np.searchsorted(ends, s_mm), len(ends) - 1)
    own = np.clip(s_mm - ends[row] + lengths[row], 0.0, lengths[row])
    t = run.t0[row] + np.sign(run.t1 - run.t0)[row] * own / speeds(graph, run.edge[row])
    for k in np.flatnonzero(~is_even(graph, run.edge[row])).tolist():
        t[k] = parameter_at(graph, run, int(row[k]), float(own[k]))
    return evaluate_edges(graph, run.edge[row], t)[0]


def piece_lengths(graph: BrepGraph, pieces: SeamPieces) -> FloatArray:
    """Return the length of every piece, mm."""
    return run_lengths(graph, Runs(pieces, np.arange(len(pieces) + 1)))


def middles(graph: BrepGraph, runs: Runs) -> FloatArray:
    """Return the point at half the length of every run, shape (n, 3), mm."""
    lengths = piece_lengths(graph, runs.pieces)
    ends = np.cumsum(lengths)
    first = (ends - lengths)[runs.start[:-1]]
    half = (first + ends[runs.start[1:] - 1]) / 2
    row = np.clip(np.searchsorted(ends, half), runs.start[:-1], runs.start[1:] - 1)
    t = [
        parameter_at(graph, runs.pieces, int(at), float(s - ends[at] + lengths[at]))
        for at, s in zip(row, half, strict=True)
    ]
    return evaluate_edges(graph, runs.pieces.edge[row], np.array(t))[0]
