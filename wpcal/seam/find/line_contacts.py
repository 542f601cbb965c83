"""Members that touch along a line only: grooves without a root face, and plates that stand on an edge.

A bevel that goes down to the root leaves a sharp edge. No face of it is opposed to the other member, so there is no
contact area, and on either side of the edge a weld may lie.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wpcal.brep.boxes import BoxTree
from wpcal.brep.concavity import corner_turns, inner_edges
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, IntArray
from wpcal.seam.find.contact import EdgeContacts, find_edge_contacts
from wpcal.seam.find.duplicates import COVER_SHARES, are_near, without_duplicates
from wpcal.seam.find.joint import JoinedPieces, bevelled_mm, join_contacts
from wpcal.seam.find.root_gaps import MOST_ROOT_MM, bevelled_faces
from wpcal.seam.find.sides import find_sides, step_mm
from wpcal.seam.find.wide_gaps import EVEN_SHARE, PLACES, is_filled, pairs_over
from wpcal.seam.limits import FLUSH_MM, GAP_ROUND_OFF_MM, NEAR_GAPS
from wpcal.seam.pieces import sample_pieces, solids_of
from wpcal.seam.seam import SeamPieces

SHARP_COS = 0.94  #: Cosine between the normals beside an edge (20 degrees): above it the faces continue each other.
BLADE_COS = -0.9  #: The same of an edge of 26 degrees: a sharper one is a blade or a wedge, and no prepared edge.
RIGHT_COS = 0.1
"""An edge is square within 6 degrees. At a gap it counts between two bevels only: square edges are beside much that
they are not welded to."""


def with_line_contacts(
    graph: BrepGraph, trimmed: TrimmedFaces, contacts: EdgeContacts, joined: JoinedPieces, *, gap_mm: float
) -> JoinedPieces:
    """Add the joints of members that touch along a line, beside which nothing is joined yet.

    `contacts`, `gap_mm`: Every contact of an edge with a face, and the gap with which they were found, mm.
    """
    sharp = contacts.select(np.isin(contacts.edge, _sharp_edges(graph)[0]))
    sharp = sharp.select(~_are_known(graph, sharp, joined.pieces, NEAR_GAPS * gap_mm))
    return JoinedPieces.together([joined, _lines(graph, trimmed, _even(graph, trimmed, sharp), gap_mm)])


def find_line_gaps(graph: BrepGraph, trimmed: TrimmedFaces, found: SeamPieces, *, gap_mm: float) -> JoinedPieces:
    """Find bevelled edges at a constant gap above the usual one, up to `MOST_ROOT_MM`, beside which nothing is found.

    `gap_mm`: The gap with which contacts were found, mm.
    """
    edges, is_square = _sharp_edges(graph)
    between = np.isin(graph.edge_faces[edges], bevelled_faces(graph)).all(axis=1)
    edges, square = edges[~is_square | between], edges[is_square]
    pairs = pairs_over(graph, trimmed, MOST_ROOT_MM, edges)
    contacts = find_edge_contacts(graph, trimmed, gap_mm=MOST_ROOT_MM, pairs=pairs)
    known = _are_known(graph, contacts, found, NEAR_GAPS * MOST_ROOT_MM)
    contacts = _even(graph, trimmed, contacts.select(~known))
    contacts = contacts.select(
        (contacts.gap_mm[:, 0] > gap_mm) & (contacts.gap_mm[:, 2] <= MOST_ROOT_MM + GAP_ROUND_OFF_MM)
    )
    of_gap = np.round(contacts.gap_mm[:, 1], 1)
    lines = JoinedPieces.together(
        _lines(graph, trimmed, contacts.select(of_gap == gap), float(gap), bevelled=square) for gap in np.unique(of_gap)
    )
    lines = lines.select(np.flatnonzero(~is_filled(graph, trimmed, lines.pieces)))
    return without_duplicates(graph, lines, gap_mm=MOST_ROOT_MM / NEAR_GAPS)


def _sharp_edges(graph: BrepGraph) -> tuple[IntArray, BoolArray]:
    """Return the bulging edges between two faces, and which of them are square."""
    edges = inner_edges(graph)
    sine, cosine = corner_turns(graph, edges)
    rows = np.flatnonzero((sine > 0.0) & (cosine < SHARP_COS) & (cosine > BLADE_COS))
    return edges[rows], np.abs(cosine[rows]) < RIGHT_COS


def _lines(
    graph: BrepGraph, trimmed: TrimmedFaces, contacts: EdgeContacts, gap_mm: float, *, bevelled: IntArray | None = None
) -> JoinedPieces:
    """Join contacts that are lines, with either face of the edge as the wall; of some edges only bevels are walls."""
    found = []
    for side in (0, 1):
        own = replace(contacts, wall=graph.edge_faces[contacts.edge, side])
        middle, rows = (contacts.t0 + contacts.t1) / 2, np.arange(len(contacts.edge))
        at = find_sides(graph, trimmed, own, rows, middle, ledge_mm=step_mm(gap_mm))
        is_wall = at.has_wall.copy()
        asked = np.flatnonzero(is_wall & np.isin(own.edge, [] if bevelled is None else bevelled))
        is_wall[asked] = bevelled_mm(graph, trimmed, at.select(asked), gap_mm) > 0.0
        found.append(join_contacts(graph, trimmed, own.select(is_wall), gap_mm=gap_mm))
    return without_duplicates(graph, JoinedPieces.together(found), gap_mm=gap_mm)


def _even(graph: BrepGraph, trimmed: TrimmedFaces, contacts: EdgeContacts) -> EdgeContacts:
    """Return the contacts that stay at one distance from the trimmed face, with the distance as their gap.

    Two edges beside each other are as far apart as they are, and not as the surfaces behind them.
    """
    t = contacts.t0[:, None] + (contacts.t1 - contacts.t0)[:, None] * PLACES
    edge, face = (np.repeat(of, len(PLACES)) for of in (contacts.edge, contacts.face))
    p = evaluate_edges(graph, edge, t.ravel())[0]
    foot = project_to_faces(graph, face, p)
    beyond = trimmed.boundary_distance(face, foot.p, group=np.repeat(np.arange(len(t)), len(PLACES)))
    beyond[trimmed.contains(face, foot.uv)] = 0.0
    off = np.hypot(np.linalg.norm(foot.p - p, axis=1), beyond).reshape(t.shape)
    gap_mm = np.stack([off.min(axis=1), off.mean(axis=1), off.max(axis=1)], axis=1)
    is_even = gap_mm[:, 2] - gap_mm[:, 0] <= np.maximum(EVEN_SHARE * gap_mm[:, 1], FLUSH_MM)
    return replace(contacts, gap_mm=gap_mm).select(is_even)


def _are_known(graph: BrepGraph, contacts: EdgeContacts, known: SeamPieces, near_mm: float) -> BoolArray:
    """Tell which contacts have something known between the same two solids beside their middle; shape (k,)."""
    is_known = np.zeros(len(contacts.edge), dtype=bool)
    if len(known) == 0:
        return is_known
    middle = evaluate_edges(graph, contacts.edge, (contacts.t0 + contacts.t1) / 2)[0]
    curves = sample_pieces(graph, known, COVER_SHARES)[1]
    low, high = curves.min(axis=1) - 2.0 * near_mm, curves.max(axis=1) + 2.0 * near_mm
    row, other = BoxTree.of(low, high).meeting(middle, middle)
    pair = np.sort(np.stack([graph.edge_solid[contacts.edge], graph.face_solid[contacts.face]], axis=1), axis=1)
    same = (pair[row] == solids_of(graph, known)[other]).all(axis=1)
    row, other = row[same], other[same]
    is_known[row[are_near(graph, known, middle[row, None], other, near_mm)[:, 0]]] = True
    return is_known
