"""Where a ball in a flare groove runs off a face: on the exact boundary edge, not on its polyline."""

from __future__ import annotations

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.nearest_on_edges import project_to_edges
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces, distance_to_segments
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.find.flare import FlareSearch
from wpcal.seam.find.flare_sections import FacePairs, ball_centres, find_groove_roots
from wpcal.seam.limits import FLUSH_MM

SECANTS = 12  #: Steps of the secant method from 0.01 mm beside the edge to round-off; 6 were enough.
FIRST_STEP_MM = 1e-3  #: First step along the groove, from which the first slope is computed.
FARTHEST_MM = 0.5
"""An end moves less than this: polylines are within 0.01 mm of their edges, and the ball may reach one at 1 degree."""


def exact_ends(search: FlareSearch, pairs: FacePairs, s: FloatArray, ball_mm: FloatArray) -> FloatArray:
    """Move ends of grooves onto the edges where a foot of the ball leaves its face.

    `s`: shape (n,). Ends, as found on the polylines of the boundaries.
    `ball_mm`: ndarray, shape (n,).
    Returns ndarray, shape (n,). An end at which no foot is on a boundary (the gap is too wide there) stays.
    """
    graph = search.graph
    feet = _feet(search, pairs, s, ball_mm)
    found = [nearest_edges(search.trimmed, face, p) for face, p in zip((pairs.pipe, pairs.other), feet, strict=True)]
    which = np.where(found[0][1] <= found[1][1], 0, 1)
    edge, off = (np.choose(which, [found[0][k], found[1][k]]) for k in (0, 1))
    rows = np.flatnonzero(off <= 2.0 * FLUSH_MM)
    if len(rows) == 0:
        return s
    own, edge, which, ball = pairs.select(rows), edge[rows].astype(np.int64), which[rows], ball_mm[rows]
    face = np.where(which == 0, own.pipe, own.other)

    def beyond(at: FloatArray) -> FloatArray:
        foot = np.stack(_feet(search, own, at, ball))[which, np.arange(len(which))]
        p, tangent = project_to_edges(graph, edge, foot)
        outward = np.cross(project_to_faces(graph, face, foot).normal, tangent)
        return np.asarray(np.einsum("ki,ki->k", foot - p, outward), dtype=np.float64)

    per_mm = 1.0 / _speeds(graph, own)
    a, b = s[rows], s[rows] + FIRST_STEP_MM * per_mm
    ha, hb = beyond(a), beyond(b)
    for _ in range(SECANTS):
        slope = np.where(hb == ha, np.inf, (hb - ha) / np.where(b == a, 1.0, b - a))
        step = np.clip(-hb / np.where(slope == 0, np.inf, slope), -FARTHEST_MM * per_mm, FARTHEST_MM * per_mm)
        a, ha, b = b, hb, b + step
        hb = beyond(b)
    good = np.abs(b - s[rows]) <= FARTHEST_MM * per_mm
    ends = s.copy()
    ends[rows[good]] = b[good]
    return ends


def _speeds(graph: BrepGraph, pairs: FacePairs) -> FloatArray:
    """Return how long a groove is per unit of the place along it, roughly, mm."""
    return np.where(pairs.is_ring(graph), graph.face_param[pairs.pipe, 0], 1.0)


def _feet(search: FlareSearch, pairs: FacePairs, s: FloatArray, ball_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where the ball touches the rounded face and the other face, two arrays (n, 3)."""
    c = ball_centres(search.graph, pairs, find_groove_roots(search.graph, pairs, s), ball_mm)
    first, second = (project_to_faces(search.graph, face, c).p for face in (pairs.pipe, pairs.other))
    return first, second


def nearest_edges(trimmed: TrimmedFaces, face: IntArray, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """Find the edge of each face that is nearest to a point.

    `face`: ndarray of int, shape (n,)
    `points`: shape (n, 3). In `part`, mm.

    Returns
    -------
    edge : ndarray of int, shape (n,)
        -1 for a face without a boundary.
    off_mm : ndarray, shape (n,)
    """
    edge, off = np.full(len(face), -1), np.full(len(face), np.inf)
    for row, (of_face, p) in enumerate(zip(face.tolist(), points, strict=True)):
        own = slice(trimmed.start[of_face], trimmed.start[of_face + 1])
        p0, p1 = trimmed.p0[own], trimmed.p1[own]
        if len(p0):
            away = distance_to_segments(np.broadcast_to(p, p0.shape), p0, p1)
            nearest = int(np.argmin(away))
            edge[row], off[row] = trimmed.piece_edge[own][nearest], away[nearest]
    return edge, off
