"""Concave edges inside one solid: where a part modelled as one piece was welded together from several."""

from __future__ import annotations

import numpy as np

from wpcal.brep.concavity import are_concave
from wpcal.brep.curves import edge_lengths, evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.rays import is_blocked
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.limits import LEAST_SEAM_MM
from wpcal.seam.seam import JointType, SeamPieces, WeldType


def find_concave_edges(
    graph: BrepGraph, solids: BoolArray | None = None, *, min_length_mm: float = LEAST_SEAM_MM
) -> JoinedPieces:
    """Find the concave edges between two faces of one solid.

    `solids`: shape (S,). Only these solids are searched; by default all.
    Returns JoinedPieces. The left face of an edge as wall, the right one as base, gap zero; joint unknown, weld fillet.
    """
    edges = np.flatnonzero((graph.edge_faces >= 0).all(axis=1) & ~graph.is_seam_edge)
    edges = edges[graph.edge_kind[edges] != CurveKind.DEGENERATE]
    if solids is not None:
        edges = edges[solids[graph.edge_solid[edges]]]
    edges = edges[edge_lengths(graph)[edges] >= min_length_mm]
    edges = edges[are_concave(graph, edges)]
    wall, base = graph.edge_faces[edges].T
    t0, t1 = graph.edge_range[edges].T
    pieces = SeamPieces(edges, t0, t1, wall, base, np.zeros((len(edges), 3)))
    return JoinedPieces(pieces, (JointType.UNKNOWN,) * len(edges), (WeldType.FILLET,) * len(edges))


CUT_OUT_STEP_MM = 0.5
"""Distance from the edge at which the depth of the material is tested: clear of the other face, but still inside the
corner of a 1 mm sheet."""


def are_cut_outs(graph: BrepGraph, trimmed: TrimmedFaces, edges: IntArray) -> BoolArray:
    """Tell which concave edges are corners of an opening (a window in a plate) rather than joints of members.

    Such an edge runs through the thickness of one member. The material behind both of its faces is deeper than the edge
    is long, and no other concave edge meets the edge.

    `edges`: shape (k,). Concave edges.
    """
    length = edge_lengths(graph)[edges]
    vertices, counts = np.unique(graph.edge_vertices[edges], return_counts=True)
    shared = vertices[counts > 1]
    alone = ~np.isin(graph.edge_vertices[edges], shared).any(axis=1)
    deep = are_deeper(graph, trimmed, edges, length)
    return np.asarray(alone & deep, dtype=bool)


def are_deeper(graph: BrepGraph, trimmed: TrimmedFaces, edges: IntArray, depth_mm: FloatArray) -> BoolArray:
    """Tell behind which concave edges the material of both faces is deeper than given, shape (k,).

    `edges`: ndarray of int, shape (k,).
    `depth_mm`: ndarray, shape (k,).
    """
    p = evaluate_edges(graph, edges, graph.edge_range[edges].mean(axis=1))[0]
    normals = [project_to_faces(graph, graph.edge_faces[edges, k], p).normal for k in (0, 1)]
    deeper = np.ones(len(edges), dtype=bool)
    for mine, other in (normals, normals[::-1]):
        along = other - np.einsum("ki,ki->k", other, mine)[:, None] * mine  # on the face, away from the edge
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        start = p + CUT_OUT_STEP_MM * (along - mine)
        deeper &= ~is_blocked(graph, trimmed, start, -mine, length_mm=depth_mm)
    return deeper
