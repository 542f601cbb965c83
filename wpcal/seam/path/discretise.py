"""Where along a seam the frames are: limited by the chord error, the largest step and the least step.

Hou 2018, §1.1: the chord tolerance places the points, so that a strong curvature gets more of them; points nearer than
the least step are removed. The largest step is our addition: a straight seam has points to work with. If the limits
conflict, the chord tolerance takes precedence.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.brep.curves import arc_length, cumulative_length, evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.trim import distance_to_segments
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.seam.chain import SAME_POINT_MM
from wpcal.seam.options import StepOptions
from wpcal.seam.path.direction import Runs
from wpcal.seam.seam import SeamPieces

CHORD_SAMPLES = 7  #: Points inside a step at which its distance from the chord is measured.
BASE_STEPS = 64  #: Steps of a curved piece at which its curvature is measured before points are placed.
CHORD_MARGIN = 0.98
"""Points are placed for this share of the chord tolerance, so that the measured chord error stays within it."""
MOST_POINTS = 1_000_000  #: More points on one piece are a mistake in the options.
EXACT_STEPS = 1e-9
"""Step counts within this above an integer are rounded down to it: 100 mm in steps of 10 mm are ten steps."""


@dataclass(frozen=True, slots=True, eq=False)
class Stations:
    """Points along runs of pieces, run after run."""

    start: IntArray  #: shape (runs + 1,). The points of run i are ``start[i]:start[i + 1]``.
    piece: IntArray  #: shape (n,). Row among the pieces of all runs.
    t: FloatArray  #: shape (n,). Edge parameters.
    s_mm: FloatArray  #: shape (n,). Arc length from the start of the run.


def discretise(graph: BrepGraph, runs: Runs, options: StepOptions) -> Stations:
    """Place points along runs.

    Raises `InputError` if a piece would get more than `MOST_POINTS`.

    Returns: For each run from its start to its end, both included. A point where two pieces meet occurs once, on the
    later piece. A bridge between two pieces has a point at either end.
    """
    pieces = runs.pieces
    counts, t, s = _piece_stations(graph, pieces, options)
    piece = np.repeat(np.arange(len(pieces)), counts)
    last = np.cumsum(counts) - 1
    starts, ends = piece_spans(graph, runs)
    s = s + np.repeat(starts, counts)
    kept = np.ones(len(t), dtype=bool)
    kept[last] = False
    kept[last[runs.start[1:] - 1]] = True
    kept[last[:-1][starts[1:] > ends[:-1]]] = True  # both ends of a bridge
    run = np.repeat(runs.run_of_piece, counts)[kept]
    start = np.searchsorted(run, np.arange(len(runs) + 1))
    return _thinned(graph, pieces, Stations(start, piece[kept], t[kept], s[kept]), options)


def run_lengths(graph: BrepGraph, runs: Runs) -> FloatArray:
    """Return the length of every run, mm."""
    return piece_spans(graph, runs)[1][runs.start[1:] - 1]


def piece_spans(graph: BrepGraph, runs: Runs) -> tuple[FloatArray, FloatArray]:
    """Return where each piece starts and ends, as lengths from the start of its run, mm; two arrays (k,).

    A piece starts exactly where the one before it ends, or after the straight bridge between the two. The answer for a
    run does not depend on the other runs.
    """
    pieces, first = runs.pieces, runs.start[:-1]
    length = lengths_between(graph, pieces.edge, pieces.t0, pieces.t1)
    p0, p1 = (evaluate_edges(graph, pieces.edge, t)[0] for t in (pieces.t0, pieces.t1))
    bridge = np.zeros(len(pieces))
    bridge[1:] = np.linalg.norm(p0[1:] - p1[:-1], axis=1)
    bridge[bridge <= SAME_POINT_MM] = 0.0
    bridge[first] = 0.0
    sums = _sums_per_run(np.stack([bridge, length], axis=1), runs.start)
    return sums[:, 0], sums[:, 1]


def _sums_per_run(steps: FloatArray, start: IntArray) -> FloatArray:
    """Return the sums of all steps of a run up to each one, shape (k, 2); they begin anew at every run.

    The sums of a run have the same bits whatever other runs there are: a difference of sums over all runs would not.
    """
    counts, sums = np.diff(start), np.empty(steps.shape)
    for count in np.unique(counts).tolist():
        rows = start[:-1][counts == count, None] + np.arange(count)
        sums[rows] = np.cumsum(steps[rows].reshape(len(rows), -1), axis=1).reshape(*rows.shape, 2)
    return sums


def lengths_between(graph: BrepGraph, edge: IntArray, t0: FloatArray, t1: FloatArray) -> FloatArray:
    """Return the lengths of edges between two parameters, shape (k,), mm; of lines and circles in closed form."""
    lengths = speeds(graph, edge) * np.abs(t1 - t0)
    for row in np.flatnonzero(~is_even(graph, edge)).tolist():
        lengths[row] = abs(arc_length(graph, int(edge[row]), float(t0[row]), float(t1[row])))
    return np.asarray(lengths, dtype=np.float64)


def is_even(graph: BrepGraph, edge: IntArray) -> BoolArray:
    """Tell on which edges, shape (k,), equal steps of the parameter have equal lengths: lines and circles."""
    kind = graph.edge_kind[edge]
    return np.asarray((kind == CurveKind.LINE) | (kind == CurveKind.CIRCLE), dtype=bool)


def speeds(graph: BrepGraph, edge: IntArray) -> FloatArray:
    """Return the length per unit of the parameter on lines and circles, shape (k,), mm; 1 on other curves."""
    return np.where(graph.edge_kind[edge] == CurveKind.CIRCLE, graph.edge_param[edge, 0], 1.0)


def _piece_stations(
    graph: BrepGraph, pieces: SeamPieces, options: StepOptions
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return how many points each piece gets, and their parameters and arc lengths, piece after piece."""
    even = is_even(graph, pieces.edge)
    counts = _even_counts(graph, pieces, options)
    uneven = {
        int(row): _uneven_stations(graph, int(pieces.edge[row]), pieces.t0[row], pieces.t1[row], options)
        for row in np.flatnonzero(~even)
    }
    for at, (own_t, _) in uneven.items():
        counts[at] = len(own_t) - 1
    row = np.repeat(np.arange(len(pieces)), counts + 1)
    first = np.cumsum(counts + 1) - counts - 1
    share = (np.arange(len(row)) - first[row]) / counts[row]
    t = pieces.t0[row] * (1.0 - share) + pieces.t1[row] * share
    s = share * (speeds(graph, pieces.edge) * np.abs(pieces.t1 - pieces.t0))[row]
    for at, (own_t, own_s) in uneven.items():
        own = slice(first[at], first[at] + counts[at] + 1)
        t[own], s[own] = own_t, own_s
    return counts + 1, t, s


def _even_counts(graph: BrepGraph, pieces: SeamPieces, options: StepOptions) -> IntArray:
    """Return into how many steps each piece is cut by the step and by the sag of a circle, ``2 r sin²(turn / 4)``."""
    turn = np.abs(pieces.t1 - pieces.t0)
    length = speeds(graph, pieces.edge) * turn
    sag = 2.0 * graph.edge_param[pieces.edge, 0] * np.sin(turn / BASE_STEPS / 4.0) ** 2
    sag = np.where(graph.edge_kind[pieces.edge] == CurveKind.CIRCLE, sag, 0.0)
    parts = BASE_STEPS * np.sqrt(sag / (CHORD_MARGIN * options.chord_mm))
    counts = np.ceil(np.maximum(parts, length / options.max_step_mm) - EXACT_STEPS)
    worst = int(np.argmax(np.where(is_even(graph, pieces.edge), counts, 0)))
    _refuse_too_many(counts[worst], length[worst])
    return np.asarray(np.clip(counts, 1, MOST_POINTS), dtype=np.int64)


def _refuse_too_many(count: float, length: float) -> None:
    if count > MOST_POINTS:
        raise InputError(f"a piece of {length:.0f} mm would get {count:.0f} points; choose a larger chord or step")


def _uneven_stations(
    graph: BrepGraph, edge: int, t0: float, t1: float, options: StepOptions
) -> tuple[FloatArray, FloatArray]:
    """Return parameters and arc lengths of points on one piece of an ellipse or a NURBS curve."""
    t = np.linspace(t0, t1, BASE_STEPS + 1)
    s = np.abs(cumulative_length(graph, edge, t))
    # the chord error grows with the square of the step: `parts` of each base step stay within the tolerance
    error = chord_errors(graph, np.full(BASE_STEPS, edge), t[:-1], t[1:])
    parts = np.sqrt(error / (CHORD_MARGIN * options.chord_mm))
    load = np.concatenate([[0.0], np.cumsum(np.maximum(parts, np.diff(s) / options.max_step_mm))])
    count = max(1, int(np.ceil(load[-1] - EXACT_STEPS)))
    _refuse_too_many(count, float(s[-1]))
    t = np.interp(np.linspace(0.0, load[-1], count + 1), load, t)
    while (wide := chord_errors(graph, np.full(len(t) - 1, edge), t[:-1], t[1:]) > options.chord_mm).any():
        t = np.insert(t, np.flatnonzero(wide) + 1, ((t[:-1] + t[1:]) / 2)[wide])
    return t, np.abs(cumulative_length(graph, edge, t))


def chord_errors(graph: BrepGraph, edge: IntArray, t0: FloatArray, t1: FloatArray) -> FloatArray:
    """Return the largest distance of each piece of an edge from the chord between its ends, shape (m,), mm.

    `edge`: ndarray of int, shape (m,).
    `t0`, `t1`: shape (m,). Parameters of the ends.
    """
    if (graph.edge_kind[edge] == CurveKind.LINE).all():
        return np.zeros(len(edge))
    share = np.arange(1, CHORD_SAMPLES + 1) / (CHORD_SAMPLES + 1)
    t = t0[:, None] + (t1 - t0)[:, None] * share
    p = evaluate_edges(graph, np.repeat(edge, CHORD_SAMPLES), t.ravel())[0]
    a, b = evaluate_edges(graph, edge, t0)[0], evaluate_edges(graph, edge, t1)[0]
    off = distance_to_segments(p, np.repeat(a, CHORD_SAMPLES, axis=0), np.repeat(b, CHORD_SAMPLES, axis=0))
    return np.asarray(off.reshape(-1, CHORD_SAMPLES).max(axis=1), dtype=np.float64)


def _thinned(graph: BrepGraph, pieces: SeamPieces, stations: Stations, options: StepOptions) -> Stations:
    """Remove points nearer than the least step to the point before, if the chord tolerance allows it."""
    near = np.flatnonzero(np.diff(stations.s_mm) < options.min_step_mm)
    runs = np.searchsorted(stations.start, near, side="right") - 1
    near_runs = np.unique(
        runs[near + 1 < stations.start[runs + 1]]
    )  # not from the end of a run to the start of the next one
    keep = np.ones(len(stations.t), dtype=bool)
    for run in near_runs:
        rows = np.arange(stations.start[run], stations.start[run + 1])
        keep[rows] = _kept(graph, pieces, stations, rows, options)
    start = np.concatenate([[0], np.cumsum(keep)])[stations.start]
    return Stations(start, stations.piece[keep], stations.t[keep], stations.s_mm[keep])


def _kept(graph: BrepGraph, pieces: SeamPieces, stations: Stations, rows: IntArray, options: StepOptions) -> BoolArray:
    """Tell which stations of one run stay."""
    piece, t, s = stations.piece[rows], stations.t[rows], stations.s_mm[rows]
    p = evaluate_edges(graph, pieces.edge[piece], t)[0]
    own = _own_errors(graph, pieces, piece, t)
    keep = np.ones(len(p), dtype=bool)
    before = 0
    for row in range(1, len(p) - 1):
        near = s[row] - s[before] < options.min_step_mm
        if near and s[row + 1] - s[before] <= options.max_step_mm:
            skipped = p[before + 1 : row + 1]
            ends = np.broadcast_to(p[before], skipped.shape), np.broadcast_to(p[row + 1], skipped.shape)
            # the curve is at most its distance from the old chords plus their distance from the new one away
            off = distance_to_segments(skipped, *ends).max() + own[before : row + 1].max()
            if off <= options.chord_mm:
                keep[row] = False
                continue
        before = row
    return keep


def _own_errors(graph: BrepGraph, pieces: SeamPieces, piece: IntArray, t: FloatArray) -> FloatArray:
    """Return the chord error of each step between neighbouring stations of one run, mm, shape (n - 1,)."""
    here = piece[:-1]
    t1 = np.where(piece[1:] == here, t[1:], pieces.t1[here])  # the start of a later piece is the end of this one
    return chord_errors(graph, pieces.edge[here], t[:-1], t1)
