"""Solids that run into each other, such as an untrimmed branch pipe: no edge lies on a face, but edges pierce faces."""

from __future__ import annotations

from functools import partial

import numpy as np

from wpcal.brep.crossing import find_crossings, heights
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray, blocks
from wpcal.seam.find.contact import CHUNK, CONTACT_SAMPLES, candidate_pairs, clipped_range

DEEP_MM = 0.5
"""To pierce a face, an edge must extend this far on both sides of it: members in contact overlap by less."""


def interpenetrating_solids(graph: BrepGraph, trimmed: TrimmedFaces) -> IntArray:
    """Find pairs of solids where an edge of one pierces a face of the other.

    Returns ndarray of int, shape (k, 2). Numbers of solids, the smaller first, sorted.

    Edges that close a face onto itself are included: of two crossing pipes, only these edges pierce the other wall.
    """
    edge, face = candidate_pairs(graph, trimmed, 0.0, seam_edges=True)
    low, high = clipped_range(graph, trimmed, edge, face, 2.0 * DEEP_MM)
    keep = high > low
    keep[keep] = _may_pierce(graph, edge[keep], face[keep], low[keep], high[keep])
    edge, face, low, high = edge[keep], face[keep], low[keep], high[keep]
    found = [np.zeros((0, 2), dtype=np.int64)]
    for own in blocks(len(edge), CHUNK // CONTACT_SAMPLES):
        pierced = _pierced(graph, trimmed, edge[own], face[own], low[own], high[own])
        found.append(np.stack([graph.edge_solid[edge[own][pierced]], graph.face_solid[face[own][pierced]]], axis=1))
    return np.unique(np.sort(np.concatenate(found), axis=1), axis=0)


def _may_pierce(graph: BrepGraph, edge: IntArray, face: IntArray, low: FloatArray, high: FloatArray) -> BoolArray:
    """Tell which edges may pierce their face: a straight edge and a plane only if the ends are on both sides."""
    may = np.ones(len(edge), dtype=bool)
    flat = (graph.edge_kind[edge] == CurveKind.LINE) & (graph.face_kind[face] == SurfaceKind.PLANE)
    e, frame = edge[flat], graph.face_frame[face[flat]]
    a, b = (np.einsum("ki,ki->k", evaluate_edges(graph, e, t[flat])[0] - frame[:, 0], frame[:, 3]) for t in (low, high))
    may[flat] = (np.minimum(a, b) < -DEEP_MM) & (np.maximum(a, b) > DEEP_MM)
    return may


def _pierced(
    graph: BrepGraph, trimmed: TrimmedFaces, edge: IntArray, face: IntArray, low: FloatArray, high: FloatArray
) -> IntArray:
    """Return the rows of edges that pierce their face between the parameters low and high."""
    t = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, CONTACT_SAMPLES)
    height = _heights(graph, np.repeat(edge, CONTACT_SAMPLES), np.repeat(face, CONTACT_SAMPLES), t.ravel()).reshape(
        t.shape
    )
    row, column = np.nonzero((height[:, :-1] > 0) != (height[:, 1:] > 0))
    deep = (height.max(axis=1)[row] > DEEP_MM) & (height.min(axis=1)[row] < -DEEP_MM)
    row, column = row[deep], column[deep]
    edge, face = edge[row], face[row]
    at = find_crossings(partial(_heights, graph, edge, face), t[row, column], t[row, column + 1])
    points = evaluate_edges(graph, edge, at)[0]
    hit = project_to_faces(graph, face, points)
    # the height also changes sign where the nearest point jumps from one part of a surface to another
    meets = np.linalg.norm(hit.p - points, axis=1) <= DEEP_MM
    inside = meets & trimmed.contains(face, hit.uv)
    clear = trimmed.boundary_distance(face, hit.p, within_mm=DEEP_MM) > DEEP_MM
    return np.asarray(row[inside & clear], dtype=np.int64)


def _heights(graph: BrepGraph, edge: IntArray, face: IntArray, t: FloatArray) -> FloatArray:
    return heights(graph, face, evaluate_edges(graph, edge, t)[0])
