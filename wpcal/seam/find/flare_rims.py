"""Grooves whose mouth is narrower than a wire: the seam is a fillet along the rim, not a path inside the groove.

The straight edge of a plate along a pipe touches the pipe in the middle of the edge only. At its two rims there is a
gap that is closed behind. The wire does not enter it: it is between the side of the plate and the pipe, as in a tee.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import CurveKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.find.flare import BALLS_MM, FlareSearch, Grooves
from wpcal.seam.find.flare_ends import nearest_edges
from wpcal.seam.find.flare_sections import ball_centres, find_groove_roots
from wpcal.seam.find.flare_shape import GrooveShapes
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.find.sides import FLAT_COS
from wpcal.seam.seam import JointType, SeamPieces, WeldType

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
