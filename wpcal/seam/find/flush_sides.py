"""Flush sides of members that run into each other: an edge of one lies on the other, and both look the same way there.

Where a channel ends 1.5 mm inside the flange of an angle, the curve in which they meet goes round the channel, but for
the side at which the two are flush: there two faces lie in one plane, and meet in no curve. The seam lies on the edge
of the member through whose face the other one goes.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.material import ExactMaterial, find_solids_around
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import IntArray
from wpcal.seam.find.contact import candidate_pairs, find_edge_contacts
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.find.sides import SAME_PLANE, inward, is_on, step_mm
from wpcal.seam.limits import LEAST_CANDIDATE_MM
from wpcal.seam.pieces import solids_of
from wpcal.seam.seam import JointType, SeamPieces, WeldType

MOST_INSIDE = 0.5
"""The face that ends at the seam is the side of a member, which the other one pierces, if less of its border is inside
the other one; of the end of a bar in a post, all of it is but for the flush side."""
BESIDE_MM = 10.0
"""Members run into each other by less; two lines that are nearer are the two ends of one overlap, and one is welded."""
SQUARE_COS = 0.5  #: The face that ends at the seam is across the flush one within 30 degrees.


def find_flush_sides(graph: BrepGraph, trimmed: TrimmedFaces, sections: SeamPieces, *, gap_mm: float) -> JoinedPieces:
    """Find the flush sides of members that run into each other.

    `gap_mm`: Two faces are flush within this, mm.
    Returns JoinedPieces. Butt joints, grooves; the wall is the flush face of the member that ends there.
    """
    count = len(graph.solid_names)
    edge, face = candidate_pairs(graph, trimmed, gap_mm)
    pair = np.sort(np.stack([graph.edge_solid[edge], graph.face_solid[face]], axis=1), axis=1)
    asked = solids_of(graph, sections)
    meet = np.isin(pair[:, 0] * count + pair[:, 1], asked[:, 0] * count + asked[:, 1])
    touching = find_edge_contacts(graph, trimmed, gap_mm=gap_mm, pairs=(edge[meet], face[meet]))
    p, slope = evaluate_edges(graph, touching.edge, (touching.t0 + touching.t1) / 2)
    n_face = project_to_faces(graph, touching.face, p).normal
    sides = graph.edge_faces[touching.edge]
    n = np.stack([project_to_faces(graph, np.maximum(sides[:, k], 0), p).normal for k in (0, 1)], axis=1)
    cos = np.einsum("kij,kj->ki", n, n_face)
    flush = np.argmax(cos, axis=1)
    rows = np.arange(len(flush))
    ends = n[rows, 1 - flush]
    kept = (cos[rows, flush] > SAME_PLANE) & (np.abs(cos[rows, 1 - flush]) < SQUARE_COS) & (sides >= 0).all(axis=1)
    for sign in (1.0, -1.0):  # the other member goes on in front of the edge, and ends behind it, inside this one
        kept &= is_on(graph, trimmed, touching.face, p + step_mm(gap_mm) * inward(ends, slope, sign))
    wall = sides[rows, flush]
    end = sides[rows, 1 - flush]
    own = np.flatnonzero(kept)
    own = own[np.array([_is_outside(graph, trimmed, end[row], touching.face[row], gap_mm) for row in own], dtype=bool)]
    pieces = SeamPieces(touching.edge, touching.t0, touching.t1, wall, touching.face, touching.gap_mm).select(own)
    pieces = pieces.select(_longest_beside(graph, pieces))
    n_found = len(pieces)
    return JoinedPieces(pieces, (JointType.BUTT,) * n_found, (WeldType.GROOVE,) * n_found)


def _longest_beside(graph: BrepGraph, pieces: SeamPieces) -> IntArray:
    """Return the rows of pieces beside which no longer line runs between the same solids: each member may end there."""
    if len(pieces) == 0:
        return np.zeros(0, dtype=np.int64)
    p = np.stack([evaluate_edges(graph, pieces.edge, t)[0] for t in (pieces.t0, pieces.t1)], axis=1)
    way, middle, pairs = p[:, 1] - p[:, 0], p.mean(axis=1), solids_of(graph, pieces)
    length = np.linalg.norm(way, axis=1)
    way = way / np.where(length > 0, length, 1.0)[:, None]
    arm = middle[:, None] - middle
    along = np.einsum("kji,ji->kj", arm, way)
    off = np.linalg.norm(arm - along[:, :, None] * way, axis=2)
    parallel = (np.abs(way @ way.T) > SAME_PLANE) & (pairs[:, None] == pairs).all(axis=2)
    of_line = np.round(np.where(parallel & (off < LEAST_CANDIDATE_MM), length, 0.0).sum(axis=1), 3)
    beside = parallel & (off < BESIDE_MM) & (np.abs(along) < (length[:, None] + length) / 2 - LEAST_CANDIDATE_MM)
    taken: list[int] = []
    for row in np.argsort(-of_line, kind="stable").tolist():
        if not beside[row, taken].any():
            taken.append(row)
    return np.sort(np.array(taken, dtype=np.int64))


def _is_outside(graph: BrepGraph, trimmed: TrimmedFaces, face: int, other: int, gap_mm: float) -> bool:
    """Tell whether most of the border of a face is outside the solid of another face: it is not an end inside it."""
    border = trimmed.p0[trimmed.start[face] : trimmed.start[face + 1]]
    normal = project_to_faces(graph, np.full(len(border), face), border).normal
    point, solid = find_solids_around(ExactMaterial(graph, trimmed), border + step_mm(gap_mm) * normal)
    inside = len(np.unique(point[solid == graph.face_solid[other]]))
    return inside < MOST_INSIDE * len(border)
