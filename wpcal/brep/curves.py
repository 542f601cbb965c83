"""Points and exact tangents on edges, many at once."""

import numpy as np
from numpy.typing import ArrayLike

from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.core.arrays import FloatArray, IntArray, blocks

CHORD_MM = 0.01
"""Sag of the polylines that replace curved edges in searches; ends found on them are refined on the exact curve."""
MOST_PER_TURN = 256  #: A polyline needs no more pieces per turn: at a radius of 100 mm the sag is then 0.0075 mm.
LEAST_PER_TURN = 32  #: With fewer pieces per turn, normals of neighbouring pieces would differ by more than 11 degrees.
CHUNK = 50_000  #: Points evaluated in one array: about 20 MB.
PER_NURBS_SPAN = 8  #: Pieces per knot span of a NURBS edge.


def evaluate_edges(graph: BrepGraph, edges: ArrayLike, t: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return points and derivatives on edges.

    Returns `points`: ndarray, shape (m, 3). In `part`, mm.
    Returns `slopes`: ndarray, shape (m, 3). Derivatives with respect to t, mm per unit of t.

    `edges`: array_like of int, shape (m,)
    `t`: shape (m,). Parameters on those edges.
    """
    e, t = np.asarray(edges, dtype=np.int64), np.asarray(t, dtype=np.float64)
    kind = graph.edge_kind[e]
    if len(e) and (kind == CurveKind.NURBS).all():
        return graph.curve_set.evaluate(graph.edge_nurbs[e], t)
    o, x, y = graph.edge_frame[e, 0], graph.edge_frame[e, 1], graph.edge_frame[e, 2]
    ab = graph.edge_param[e]
    is_line = (kind == CurveKind.LINE)[:, None]
    cos, sin = np.cos(t)[:, None], np.sin(t)[:, None]
    ax, by = ab[:, :1] * x, ab[:, 1:] * y
    points = np.where(is_line, o + t[:, None] * x, o + cos * ax + sin * by)
    slopes = np.where(is_line, x, cos * by - sin * ax)
    free = np.flatnonzero(kind == CurveKind.NURBS)
    if len(free):
        points[free], slopes[free] = graph.curve_set.evaluate(graph.edge_nurbs[e[free]], t[free])
    return points, slopes


def piece_counts(graph: BrepGraph) -> IntArray:
    """Return into how many pieces each edge is cut for a polyline within `CHORD_MM`; shape (E,)."""
    kind, turn = graph.edge_kind, np.ptp(graph.edge_range, axis=1)
    radius = graph.edge_param.max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        angle = 2.0 * np.arccos(np.clip(1.0 - CHORD_MM / radius, -1.0, 1.0))
    per_turn = np.clip(2 * np.pi / np.where(angle > 0, angle, 1.0), LEAST_PER_TURN, MOST_PER_TURN)
    counts = np.ones(graph.edge_count, dtype=np.int64)
    round_ = (kind == CurveKind.CIRCLE) | (kind == CurveKind.ELLIPSE)
    counts[round_] = np.maximum(np.ceil(turn * per_turn / (2 * np.pi)), 2).astype(np.int64)[round_]
    for edge in np.flatnonzero(kind == CurveKind.NURBS):
        curve = graph.nurbs_curves[graph.edge_nurbs[edge]]
        counts[edge] = PER_NURBS_SPAN * max(curve.span_count, 2)
    return counts


def edge_polylines(graph: BrepGraph) -> tuple[IntArray, FloatArray, FloatArray]:
    """Sample every edge once as a polyline.

    Returns `start`: shape (E + 1,). The samples of edge e are ``start[e]:start[e + 1]``; a degenerate edge has none.
    Returns `t`: shape (m,). Their parameters.
    Returns `points`: shape (m, 3). In `part`, mm.
    """
    samples = np.where(graph.edge_kind == CurveKind.DEGENERATE, 0, piece_counts(graph) + 1)
    start = np.concatenate([[0], np.cumsum(samples)])
    edges = np.repeat(np.arange(graph.edge_count), samples)
    fraction = (np.arange(start[-1]) - start[edges]) / np.maximum(samples[edges] - 1, 1)
    first, last = graph.edge_range[edges].T
    t = first * (1.0 - fraction) + last * fraction
    points = np.empty((len(t), 3))
    for own in blocks(len(t), CHUNK):
        points[own] = evaluate_edges(graph, edges[own], t[own])[0]
    return start, t, points


def edge_lengths(graph: BrepGraph) -> FloatArray:
    """Return the length of every edge, mm, shape (E,): closed form, or Gauss-Legendre on the pieces of a polyline.

    Found once, and kept with the graph.
    """
    if "lengths" not in vars(graph):
        vars(graph)["lengths"] = _edge_lengths(graph)
    lengths: FloatArray = vars(graph)["lengths"]
    return lengths


def _edge_lengths(graph: BrepGraph) -> FloatArray:
    first, last = graph.edge_range.T
    lengths = np.zeros(graph.edge_count)
    line, circle = graph.edge_kind == CurveKind.LINE, graph.edge_kind == CurveKind.CIRCLE
    lengths[line] = (last - first)[line]
    lengths[circle] = ((last - first) * graph.edge_param[:, 0])[circle]
    for edge in np.flatnonzero((graph.edge_kind == CurveKind.ELLIPSE) | (graph.edge_kind == CurveKind.NURBS)):
        lengths[edge] = arc_length(graph, int(edge), first[edge], last[edge])
    return lengths


LENGTH_ROUNDS = 60
"""Most steps in the search for the parameter at a length: bisection alone needs that many for the last bit."""
PARAMETER_ROUND_OFF = 1e-15  #: The search for a parameter ends when it moves by less than this share.
GAUSS_X, GAUSS_W = np.polynomial.legendre.leggauss(8)
"""Nodes and weights. Eight nodes integrate the speed along an eighth of a knot span to about 1e-12."""


def arc_length(graph: BrepGraph, edge: int, t0: float, t1: float) -> float:
    """Return the length of one edge between two parameters, mm. Found once, and kept with the graph."""
    known: dict[tuple[int, float, float], float] = vars(graph).setdefault("arcs", {})
    if (edge, t0, t1) not in known:
        known[edge, t0, t1] = float(cumulative_length(graph, edge, np.array([t0, t1]))[-1])
    return known[edge, t0, t1]


def cumulative_length(graph: BrepGraph, edge: int, t: FloatArray) -> FloatArray:
    """Return the length of one edge from t[0] to each t, shape (m,). mm, negative where t is below t[0].

    No piece of the integral reaches across a knot: a higher derivative jumps there, and Gauss-Legendre loses its order.

    `t`: shape (m,). Parameters.
    """
    cuts = np.unique(np.concatenate([t, _knots_between(graph, edge, t.min(), t.max())]))
    whole = graph.edge_range[edge, 1] - graph.edge_range[edge, 0]
    share = float(np.diff(cuts).max(initial=0.0)) / whole if whole > 0 else 0.0
    pieces = max(1, int(np.ceil(share * piece_counts_of(graph, edge))))
    step = np.diff(cuts) / pieces
    left = cuts[:-1, None] + step[:, None] * np.arange(pieces)
    nodes = left[..., None] + step[:, None, None] * (GAUSS_X + 1.0) / 2.0
    slopes = evaluate_edges(graph, np.full(nodes.size, edge), nodes.ravel())[1]
    speed = np.linalg.norm(slopes, axis=1).reshape(nodes.shape)
    along = np.concatenate([[0.0], np.cumsum((speed @ GAUSS_W).sum(axis=1) * step / 2.0)])
    at = along[np.searchsorted(cuts, t)]
    return np.asarray(at - at[0], dtype=np.float64)


def _knots_between(graph: BrepGraph, edge: int, t0: float, t1: float) -> FloatArray:
    """Return the knots of one edge inside an interval of its parameter, ascending; none on a curve without knots."""
    if graph.edge_kind[edge] != CurveKind.NURBS:
        return np.zeros(0)
    knots = graph.nurbs_curves[graph.edge_nurbs[edge]].knots
    return np.unique(knots[(knots > min(t0, t1)) & (knots < max(t0, t1))])


def parameters_at_length(graph: BrepGraph, edge: int, t0: float, t1: float, s_mm: FloatArray) -> FloatArray:
    """Return the parameters of one edge at lengths from t0 towards t1, shape (n,).

    A table of lengths brackets each parameter. Inside its bracket, Newton's method on the arc length finds it; a step
    that leaves the bracket is replaced by a bisection. A parameter does not depend on the other lengths.

    `s_mm`: shape (n,). Lengths from t0, mm; clipped to the length between t0 and t1.
    """
    nodes = np.unique([*np.linspace(t0, t1, 2 + piece_counts_of(graph, edge)), *_knots_between(graph, edge, t0, t1)])
    nodes = nodes if t1 > t0 else nodes[::-1]
    along = np.abs(cumulative_length(graph, edge, nodes))
    s = np.clip(s_mm, 0.0, along[-1])
    k = np.clip(np.searchsorted(along, s, side="right") - 1, 0, len(nodes) - 2)
    low, high, t, start = nodes[k], nodes[k + 1], nodes[k].copy(), nodes[k]
    left, way = np.arange(len(s)), np.sign(t1 - t0)
    for _ in range(LENGTH_ROUNDS):
        now = t[left]
        length, speed = _lengths_from(graph, edge, start[left], now)
        over = along[k[left]] + length - s[left]
        low[left], high[left] = np.where(over <= 0, now, low[left]), np.where(over > 0, now, high[left])
        with np.errstate(divide="ignore", invalid="ignore"):
            better = now - way * over / speed
        inside = (better - low[left]) * (better - high[left]) <= 0
        better = np.where(inside, better, (low + high)[left] / 2)
        moves = np.abs(better - now) > PARAMETER_ROUND_OFF * (1.0 + np.abs(now))
        if not moves.any():
            break
        left = left[moves]
        t[left] = better[moves]
    return t


def _lengths_from(graph: BrepGraph, edge: int, start: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the lengths of short intervals of one edge, and the speeds at their ends; two arrays (n,)."""
    step = (t - start)[:, None]
    at = np.concatenate([start[:, None] + step * (GAUSS_X + 1.0) / 2.0, t[:, None]], axis=1)
    slopes = evaluate_edges(graph, np.full(at.size, edge), at.ravel())[1]
    speed = np.linalg.norm(slopes, axis=1).reshape(at.shape)
    return np.abs(speed[:, :-1] @ GAUSS_W * step[:, 0] / 2.0), speed[:, -1]


def piece_counts_of(graph: BrepGraph, edge: int) -> int:
    """Return into how many pieces one edge is cut for its length: enough for eight Gauss nodes each."""
    if graph.edge_kind[edge] == CurveKind.NURBS:
        return PER_NURBS_SPAN * int(graph.nurbs_curves[graph.edge_nurbs[edge]].span_count)
    return 1 if graph.edge_kind[edge] == CurveKind.LINE else PER_NURBS_SPAN
