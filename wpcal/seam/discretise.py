"""Where along a seam the frames stand: bounded by the chord error, the largest and the least step.

Hou 2018, §1.1: points are placed by the chord tolerance, so that a strong curvature gets more of them, and those nearer
than the step are taken out. The largest step is ours: a straight seam has points to work with. The chord bound wins.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.brep.curves import cumulative_length, evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.trim import distance_to_segments
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.seam.seam import SeamPieces

CHORD_SAMPLES = 7
"""Points inside a step at which its distance from the chord is measured."""
BASE_STEPS = 64
"""Steps of a curved piece by which its curvature is felt before points are placed."""
CHORD_MARGIN = 0.98
"""Points are placed for a slightly smaller chord error, so that the measured one keeps the bound."""
MOST_POINTS = 1_000_000
"""More points on one seam are a slip in the options."""


@dataclass(frozen=True, slots=True)
class StepOptions:
    """How a seam is cut into steps.

    Parameters
    ----------
    chord_mm : float
        Largest distance of the seam from the chord between neighbouring points, mm.
    min_step_mm : float
        Points nearer than this to their neighbour are taken out where the chord bound allows it, mm.
    max_step_mm : float
        Largest distance along the seam between neighbours, mm.

    Raises
    ------
    InputError
        When one is not positive, or the least step is larger than the largest.
    """

    chord_mm: float = 0.1
    min_step_mm: float = 1.0
    max_step_mm: float = 10.0

    def __post_init__(self) -> None:
        for name in ("chord_mm", "max_step_mm"):
            if not getattr(self, name) > 0:
                raise InputError(f"{name} must be positive, got {getattr(self, name)}")
        if not 0 <= self.min_step_mm <= self.max_step_mm:
            raise InputError(f"min_step_mm must be between 0 and max_step_mm, got {self.min_step_mm}")


@dataclass(frozen=True, slots=True, eq=False)
class Stations:
    """Points along a run of pieces.

    Parameters
    ----------
    piece : ndarray of int, shape (n,)
    t : ndarray, shape (n,)
        Edge parameters.
    s_mm : ndarray, shape (n,)
        Arc length from the start.
    """

    piece: IntArray
    t: FloatArray
    s_mm: FloatArray


def discretise(graph: BrepGraph, run: SeamPieces, options: StepOptions) -> Stations:
    """Place points along a run.

    Parameters
    ----------
    graph : BrepGraph
    run : SeamPieces
        In order and direction.
    options : StepOptions

    Returns
    -------
    Stations
        From the start to the end, both included; a point where two pieces meet stands once, on the later piece.
    """
    piece, t, s = [], [], []
    offset = 0.0
    for row in range(len(run)):
        tk, sk = _piece_stations(graph, int(run.edge[row]), float(run.t0[row]), float(run.t1[row]), options)
        last = row == len(run) - 1
        count = len(tk) if last else len(tk) - 1
        piece.append(np.full(count, row, dtype=np.int64))
        t.append(tk[:count])
        s.append(sk[:count] + offset)
        offset += float(sk[-1])
    stations = Stations(np.concatenate(piece), np.concatenate(t), np.concatenate(s))
    return _thinned(graph, run, stations, options)


def run_length(graph: BrepGraph, run: SeamPieces) -> float:
    """Return the length of a run, mm."""
    spans = zip(run.edge, run.t0, run.t1, strict=True)
    return float(sum(abs(cumulative_length(graph, int(e), np.array([a, b]))[-1]) for e, a, b in spans))


def _piece_stations(
    graph: BrepGraph, edge: int, t0: float, t1: float, options: StepOptions
) -> tuple[FloatArray, FloatArray]:
    """Return parameters and arc lengths of points on one piece."""
    steps = 1 if graph.edge_kind[edge] == CurveKind.LINE else BASE_STEPS
    t = np.linspace(t0, t1, steps + 1)
    s = np.abs(cumulative_length(graph, edge, t))
    # the chord error grows with the square of the step: so many parts of each base step keep the bound
    error = chord_errors(graph, np.full(steps, edge), t[:-1], t[1:])
    parts = np.sqrt(error / (CHORD_MARGIN * options.chord_mm))
    load = np.concatenate([[0.0], np.cumsum(np.maximum(parts, np.diff(s) / options.max_step_mm))])
    count = max(1, int(np.ceil(load[-1] - 1e-9)))
    if count > MOST_POINTS:
        raise InputError(f"a seam of {s[-1]:.0f} mm would get {count} points; give a larger chord or step")
    t = np.interp(np.linspace(0.0, load[-1], count + 1), load, t)
    t = _split_until_bound(graph, edge, t, options.chord_mm)
    return t, np.abs(cumulative_length(graph, edge, t))


def _split_until_bound(graph: BrepGraph, edge: int, t: FloatArray, chord_mm: float) -> FloatArray:
    while True:
        wide = chord_errors(graph, np.full(len(t) - 1, edge), t[:-1], t[1:]) > chord_mm
        if not wide.any():
            return t
        t = np.insert(t, np.flatnonzero(wide) + 1, ((t[:-1] + t[1:]) / 2)[wide])


def chord_errors(graph: BrepGraph, edge: IntArray, t0: FloatArray, t1: FloatArray) -> FloatArray:
    """Return the largest distance of each piece of an edge from the chord between its ends, mm, shape (m,)."""
    if (graph.edge_kind[edge] == CurveKind.LINE).all():
        return np.zeros(len(edge))
    share = np.arange(1, CHORD_SAMPLES + 1) / (CHORD_SAMPLES + 1)
    t = t0[:, None] + (t1 - t0)[:, None] * share
    p = evaluate_edges(graph, np.repeat(edge, CHORD_SAMPLES), t.ravel())[0]
    a, b = evaluate_edges(graph, edge, t0)[0], evaluate_edges(graph, edge, t1)[0]
    off = distance_to_segments(p, np.repeat(a, CHORD_SAMPLES, axis=0), np.repeat(b, CHORD_SAMPLES, axis=0))
    return np.asarray(off.reshape(-1, CHORD_SAMPLES).max(axis=1), dtype=np.float64)


def _thinned(graph: BrepGraph, run: SeamPieces, stations: Stations, options: StepOptions) -> Stations:
    """Take out points nearer than the least step to the one before, where the chord without them keeps the bound."""
    if (np.diff(stations.s_mm) >= options.min_step_mm).all():
        return stations
    p = evaluate_edges(graph, run.edge[stations.piece], stations.t)[0]
    own = _own_errors(graph, run, stations)
    keep = np.ones(len(p), dtype=bool)
    before = 0
    for row in range(1, len(p) - 1):
        near = stations.s_mm[row] - stations.s_mm[before] < options.min_step_mm
        if near and stations.s_mm[row + 1] - stations.s_mm[before] <= options.max_step_mm:
            skipped = p[before + 1 : row + 1]
            ends = np.broadcast_to(p[before], skipped.shape), np.broadcast_to(p[row + 1], skipped.shape)
            # the curve is no farther from the new chord than the old chords are, and it from them
            off = distance_to_segments(skipped, *ends).max() + own[before : row + 1].max()
            if off <= options.chord_mm:
                keep[row] = False
                continue
        before = row
    return Stations(stations.piece[keep], stations.t[keep], stations.s_mm[keep])


def _own_errors(graph: BrepGraph, run: SeamPieces, stations: Stations) -> FloatArray:
    """Return the chord error of each step between neighbouring stations, mm, shape (n - 1,)."""
    piece = stations.piece[:-1]
    t1 = np.where(stations.piece[1:] == piece, stations.t[1:], run.t1[piece])  # a later piece's start is this one's end
    return chord_errors(graph, run.edge[piece], stations.t[:-1], t1)
