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
from wpcal.seam.find.contact import candidate_pairs, find_contacts
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.find.sides import SAME_PLANE, inward, is_on, step_mm
from wpcal.seam.pieces import solids_of
from wpcal.seam.seam import JointType, SeamPieces, WeldType

MOST_INSIDE = 0.5
"""The face that ends at the seam is the side of a member, which the other one pierces, if less of its border is inside
the other one; of the end of a bar in a post, all of it is but for the flush side."""
SQUARE_COS = 0.5
"""The face that ends at the seam is across the flush one within 30 degrees."""


def find_flush_sides(graph: BrepGraph, trimmed: TrimmedFaces, sections: SeamPieces, *, gap_mm: float) -> JoinedPieces:
    """Find the flush sides of members that run into each other.

    Parameters
    ----------
    graph, trimmed :
        The part.
    sections : SeamPieces
        The curves in which members run into each other.
    gap_mm : float
        Two faces are flush within this, mm.

    Returns
    -------
    JoinedPieces
        Butt joints, grooves; the wall is the flush face of the member that ends there.
    """
    count = len(graph.solid_names)
    edge, face = candidate_pairs(graph, trimmed, gap_mm)
    pair = np.sort(np.stack([graph.edge_solid[edge], graph.face_solid[face]], axis=1), axis=1)
    asked = solids_of(graph, sections)
    meet = np.isin(pair[:, 0] * count + pair[:, 1], asked[:, 0] * count + asked[:, 1])
    touching = find_contacts(graph, trimmed, gap_mm=gap_mm, pairs=(edge[meet], face[meet]))
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
    pieces = SeamPieces(touching.edge, touching.t0, touching.t1, wall, touching.face, touching.gap_mm)
    return JoinedPieces(pieces.select(own), (JointType.BUTT,) * len(own), (WeldType.GROOVE,) * len(own))


def _is_outside(graph: BrepGraph, trimmed: TrimmedFaces, face: int, other: int, gap_mm: float) -> bool:
    """Tell whether most of the border of a face is outside the solid of another face: it is not an end inside it."""
    border = trimmed.p0[trimmed.start[face] : trimmed.start[face + 1]]
    normal = project_to_faces(graph, np.full(len(border), face), border).normal
    point, solid = find_solids_around(ExactMaterial(graph, trimmed), border + step_mm(gap_mm) * normal)
    inside = len(np.unique(point[solid == graph.face_solid[other]]))
    return inside < MOST_INSIDE * len(border)
