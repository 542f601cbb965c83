"""Which edges of a solid are concave: corners where the outside angle between two faces is below 180 degrees."""

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

LEAST_TURN_SIN = 0.139
"""Sine of 8 degrees: below it the two faces of an edge continue each other (the border of a round, not a corner)."""


def inner_edges(graph: BrepGraph, solids: BoolArray | None = None) -> IntArray:
    """Return the edges with a face on both sides, shape (m,); of all solids, or of those of a mask of shape (S,)."""
    inner = (graph.edge_faces >= 0).all(axis=1) & ~graph.is_seam_edge & (graph.edge_kind != CurveKind.DEGENERATE)
    return np.flatnonzero(inner if solids is None else inner & solids[graph.edge_solid])


def are_concave(graph: BrepGraph, edges: IntArray) -> BoolArray:
    """Tell which edges are concave at their middle: seen from outside, the right face rises above the left one.

    `edges`: shape (m,). Edges with a face on both sides.
    Returns ndarray of bool, shape (m,).
    """
    return np.asarray(corner_turns(graph, edges)[0] < -LEAST_TURN_SIN, dtype=bool)


def corner_turns(graph: BrepGraph, edges: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return sine and cosine of the angle between the normals beside edges, at their middle; concave: negative sine.

    The inside of the left face lies along n × x, with its normal n and the tangent x. The edge is concave if the normal
    of the right face leans that way. Found once for an edge, and kept with the graph.

    `edges`: shape (m,). Edges with a face on both sides.
    """
    known: FloatArray = vars(graph).setdefault("turns", np.full((2, graph.edge_count), np.nan))
    new = edges[np.isnan(known[0, edges])]
    if len(new):
        known[:, new] = _corner_turns(graph, new)
    sine, cosine = known[:, edges]
    return sine, cosine


def _corner_turns(graph: BrepGraph, edges: IntArray) -> tuple[FloatArray, FloatArray]:
    p, slope = evaluate_edges(graph, edges, graph.edge_range[edges].mean(axis=1))
    x = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    left, right = (project_to_faces(graph, graph.edge_faces[edges, k], p).normal for k in (0, 1))
    sine = np.einsum("ki,ki->k", np.cross(left, right), x)
    return np.asarray(sine, dtype=np.float64), np.asarray(np.einsum("ki,ki->k", left, right), dtype=np.float64)
