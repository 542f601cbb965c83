"""Where flare grooves end, and where their seam is: on the exact boundary edge of a face, or along the rim of one.

A ball in a groove runs off a face on its edge, not on the polyline of that. Where the mouth is narrower than a wire,
the seam is a fillet along the rim: the straight edge of a plate along a pipe touches the pipe in the middle of the edge
only. At its two rims there is a gap that is closed behind. The wire does not enter it: it is between the side of the
plate and the pipe, as in a tee.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import CurveKind
from wpcal.brep.nearest_on_edges import project_to_edges
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces, distance_to_segments
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.find.flare import BALLS_MM, FlareSearch, Grooves
from wpcal.seam.find.flare_sections import FacePairs, ball_centres, find_groove_roots
from wpcal.seam.find.flare_shape import GrooveShapes
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.find.sides import FLAT_COS
from wpcal.seam.limits import FLUSH_MM
from wpcal.seam.seam import JointType, SeamPieces, WeldType

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

    per_mm = 1.0 / np.where(own.is_ring(graph), graph.face_param[own.pipe, 0], 1.0)  # a place on a torus is an angle
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


def _feet(search: FlareSearch, pairs: FacePairs, s: FloatArray, ball_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where the ball touches the rounded face and the other face, two arrays (n, 3)."""
    c = ball_centres(search.graph, pairs, find_groove_roots(search.graph, pairs, s), ball_mm)
    first, second = (project_to_faces(search.graph, face, c).p for face in (pairs.pipe, pairs.other))
    return first, second


def nearest_edges(trimmed: TrimmedFaces, face: IntArray, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the edge of each face, shape (n,), that is nearest to a point, -1 without a boundary, and how far it is.

    The points have shape (n, 3), in `part`, mm.
    """
    edge, off, piece = np.full(len(face), -1), np.full(len(face), np.inf), trimmed.nearest_pieces(face, points)
    own = np.flatnonzero(piece >= 0)
    edge[own] = trimmed.piece_edge[piece[own]]
    off[own] = distance_to_segments(points[own], trimmed.p0[piece[own]], trimmed.p1[piece[own]])
    return edge, off


RIM_MM = 0.1
"""A ball that just fits touches the face this near to its rim, or nearer: it is 1 % smaller than it could be."""


def along_rims(search: FlareSearch, found: Grooves, joined: JoinedPieces, shapes: GrooveShapes) -> JoinedPieces:
    """Return pieces of grooves, those with a mouth narrower than a wire moved to the rim of the other face.

    `shapes`: Their cross-sections.
    """
    graph, (rows, edge, t) = search.graph, _rims(search, found, shapes.opening_mm)
    if len(rows) == 0:
        return joined
    pieces = joined.pieces
    moved = SeamPieces(
        pieces.edge.copy(), pieces.t0.copy(), pieces.t1.copy(), pieces.wall.copy(), pieces.base.copy(), pieces.gap_mm
    )
    left, right = graph.edge_faces[edge].T
    wall = np.where(left == found.pairs.other[rows], right, left)
    moved.edge[rows], moved.t0[rows], moved.t1[rows] = edge, t[:, 0], t[:, 1]
    moved.wall[rows], moved.base[rows] = wall, found.pairs.pipe[rows]
    p = evaluate_edges(graph, edge, t.mean(axis=1))[0]
    n_wall, n_pipe = (project_to_faces(graph, face, p).normal for face in (wall, found.pairs.pipe[rows]))
    joint, weld = list(joined.joint), list(joined.weld)
    for row, cosine in zip(rows.tolist(), np.einsum("ki,ki->k", n_wall, n_pipe).tolist(), strict=True):
        if cosine <= FLAT_COS:  # otherwise the two sides are flush, and the weld is a groove still
            joint[row], weld[row] = (JointType.TEE if shapes.pipe_continues[row] else JointType.CORNER), WeldType.FILLET
    return JoinedPieces(moved, tuple(joint), tuple(weld))


def _rims(search: FlareSearch, found: Grooves, opening_mm: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the grooves with a straight rim and a narrow mouth, the edges of the rims, and from where to where."""
    graph = search.graph
    rows = np.flatnonzero((found.ball_mm < BALLS_MM[0]) & (opening_mm < 2.0 * BALLS_MM[0]))
    own, ball = found.pairs.select(rows), found.ball_mm[rows]
    feet = []
    for s in (found.s0, (found.s0 + found.s1) / 2, found.s1):
        c = ball_centres(graph, own, find_groove_roots(graph, own, s[rows]), ball)
        feet.append([project_to_faces(graph, face, c).p for face in (own.pipe, own.other)])
    beside = nearest_edges(search.trimmed, own.pipe, feet[1][0])[1]
    edge, off = nearest_edges(search.trimmed, own.other, feet[1][1])
    narrow = (off <= RIM_MM) & (off < beside) & (edge >= 0)
    narrow[narrow] = (graph.edge_kind[edge[narrow]] == CurveKind.LINE) & (graph.edge_faces[edge[narrow]] >= 0).all(
        axis=1
    )
    rows, own, edge = rows[narrow], own.select(narrow), edge[narrow]
    o, x = graph.edge_frame[edge, 0], graph.edge_frame[edge, 1]
    first, last = (np.einsum("ki,ki->k", feet[at][1][narrow] - o, x) for at in (0, 2))
    low, high = graph.edge_range[edge].T
    t = np.stack([np.clip(np.minimum(first, last), low, high), np.clip(np.maximum(first, last), low, high)], axis=1)
    kept = t[:, 1] > t[:, 0]
    return rows[kept], edge[kept], t[kept]
