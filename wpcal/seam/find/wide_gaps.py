"""Joints with a constant gap that is wider than the usual one: a pipe cut 0.8 mm short, a butt with a root gap of 1 mm.

Contacts are searched with the usual gap first. A second search with a wider gap would move their ends and join what is
apart, so it only adds: pieces beside which nothing has been found, at a distance that stays the same.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.material import ExactMaterial, find_solids_around
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces, distance_to_segments
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.contact import EdgeContacts, candidate_pairs, clipped_range, find_edge_contacts
from wpcal.seam.find.duplicates import SAME_SIDE_COS, outward, without_duplicates
from wpcal.seam.find.joint import JoinedPieces, join_contacts
from wpcal.seam.find.play import is_play
from wpcal.seam.limits import GAP_ROUND_OFF_MM, NEAR_GAPS, WIDE_GAPS
from wpcal.seam.options import Play
from wpcal.seam.pieces import sample_pieces, solids_of
from wpcal.seam.seam import SeamPieces

EVEN_SHARE = 0.1  #: A gap is constant if it differs along the edge by at most this share of itself.
PLACES = np.linspace(0.1, 0.9, 5)
"""Where along an edge its gap is measured first, and where a piece is compared with what has been found: not at its
ends, where others begin."""
SAMPLES = np.linspace(0.0, 1.0, 65)
"""Points of what has been found: on a circle of 500 mm radius it is 0.6 mm from its chords."""

SAME_WAY_COS = 0.9  #: Cosine between the directions of one gap (26 degrees).
LEAST_GAPS = 4.0  #: A solid smaller than this many gaps in all directions has a gap to all that is near.
DEPTHS = (1.0, 2.0, 4.0)  #: How many gaps deep another solid is looked for in a gap.


def find_wide_gaps(
    graph: BrepGraph, trimmed: TrimmedFaces, found: SeamPieces, *, gap_mm: float, play: tuple[Play, ...] = ()
) -> JoinedPieces:
    """Find joints at a constant gap between the usual one and `WIDE_GAPS` times as much, or the play of the assembly.

    `gap_mm`: The gap with which contacts were found, mm.
    """
    wide_mm = max(WIDE_GAPS * gap_mm, *(one.most_mm for one in play), 0.0)
    pairs = pairs_over(graph, trimmed, wide_mm)
    parallel = _is_parallel(graph, trimmed, *pairs, gap_mm, wide_mm)
    contacts = find_edge_contacts(graph, trimmed, gap_mm=wide_mm, pairs=(pairs[0][parallel], pairs[1][parallel]))
    least, mean, most = contacts.gap_mm.T
    even = contacts.select((most - least <= EVEN_SHARE * mean) & (most > gap_mm + GAP_ROUND_OFF_MM))
    touched = np.isin(_touches(graph, *pairs), _touches(graph, even.edge, even.face))
    near = find_edge_contacts(graph, trimmed, gap_mm=wide_mm, pairs=(pairs[0][touched], pairs[1][touched]))
    even = even.select(_is_most(graph, even, near))
    even = even.select(is_play(play, even.gap_mm[:, 1]) | ~_is_clearance(graph, even))
    joined = join_contacts(graph, trimmed, even, gap_mm=wide_mm)
    joined = joined.select(np.flatnonzero(~is_beside(graph, joined.pieces, found, NEAR_GAPS * wide_mm)))
    joined = joined.select(np.flatnonzero(~is_filled(graph, trimmed, joined.pieces)))
    return without_duplicates(graph, joined, gap_mm=float(joined.pieces.gap_mm.max(initial=0.0)))


def pairs_over(
    graph: BrepGraph, trimmed: TrimmedFaces, gap_mm: float, edges: IntArray | None = None
) -> tuple[IntArray, IntArray]:
    """Return the `candidate_pairs` over a wide gap of edges, shape (n,); solids below `LEAST_GAPS` are left out."""
    edge, face = candidate_pairs(graph, trimmed, gap_mm, edges=edges)
    low, high = trimmed.solid_boxes
    is_large = (high - low).max(axis=1) >= LEAST_GAPS * gap_mm
    both = is_large[graph.edge_solid[edge]] & is_large[graph.face_solid[face]]
    return edge[both], face[both]


def _touches(graph: BrepGraph, edge: IntArray, face: IntArray) -> IntArray:
    """Return a number for the solid of each edge and the face that it is near."""
    return graph.edge_solid[edge] * graph.face_count + face


def _is_most(graph: BrepGraph, even: EdgeContacts, near: EdgeContacts) -> BoolArray:
    """Tell which contacts belong to a solid that is near their face at a constant gap with most of its edges there.

    A rib that stands at an angle is near the plate at either end, and its short edges there are parallel to the plate.
    """
    keys = [_touches(graph, contacts.edge, contacts.face) for contacts in (even, near)]
    length = [_length_mm(graph, contacts) for contacts in (even, near)]
    own, of = np.unique(keys[0], return_inverse=True)
    total = np.zeros(len(own))
    at = np.searchsorted(own, keys[1])
    np.add.at(total, at, length[1])
    return np.asarray((np.bincount(of, length[0], len(own)) > total / 2)[of], dtype=bool)


def _is_clearance(graph: BrepGraph, even: EdgeContacts) -> BoolArray:
    """Tell which contacts are of two solids that keep such a gap to flat faces of several directions.

    That is the clearance of a tray in a box or of a tab in a slot. A fit-up gap is across one plane or one cylinder.
    """
    p = evaluate_edges(graph, even.edge, (even.t0 + even.t1) / 2)[0]
    normal = project_to_faces(graph, even.face, p).normal
    pair = np.sort(np.stack([graph.edge_solid[even.edge], graph.face_solid[even.face]], axis=1), axis=1)
    _, of = np.unique(pair, axis=0, return_inverse=True)
    flat = graph.face_kind[even.face] == SurfaceKind.PLANE
    outside = graph.edge_solid[even.edge] == pair[:, 0]
    way = np.where(outside[:, None], normal, -normal)  # from the second solid of the pair to the first
    turned = (way @ way.T < SAME_WAY_COS) & (of[:, None] == of) & flat[:, None] & flat
    several = np.zeros(len(even.edge), dtype=bool)
    several[np.isin(of, of[turned.any(axis=1)])] = True
    return several


def _length_mm(graph: BrepGraph, contacts: EdgeContacts) -> FloatArray:
    t = contacts.t0[:, None] + (contacts.t1 - contacts.t0)[:, None] * SAMPLES
    p = evaluate_edges(graph, np.repeat(contacts.edge, len(SAMPLES)), t.ravel())[0].reshape(*t.shape, 3)
    return np.asarray(np.linalg.norm(np.diff(p, axis=1), axis=2).sum(axis=1), dtype=np.float64)


def _is_parallel(
    graph: BrepGraph, trimmed: TrimmedFaces, edge: IntArray, face: IntArray, gap_mm: float, wide_mm: float
) -> IntArray:
    """Return the pairs, by number, whose edge stays at a distance between the two gaps from the surface of the face.

    The surface is compared beyond its trimmed face, too: planes and cylinders go on, and so does a constant gap.
    """
    low, high = clipped_range(graph, trimmed, edge, face, wide_mm)
    rows = np.flatnonzero(high > low)
    for share in PLACES:
        p = evaluate_edges(graph, edge[rows], (low * (1.0 - share) + high * share)[rows])[0]
        off = np.linalg.norm(project_to_faces(graph, face[rows], p).p - p, axis=1)
        rows = rows[(off > (1.0 - EVEN_SHARE) * gap_mm) & (off <= wide_mm + GAP_ROUND_OFF_MM)]
    return rows


def is_beside(graph: BrepGraph, pieces: SeamPieces, found: SeamPieces, near_mm: float) -> BoolArray:
    """Tell which pieces run, anywhere, beside something found between the same solids on the same side; shape (k,)."""
    own, known = solids_of(graph, pieces), solids_of(graph, found)
    beside = np.zeros(len(pieces), dtype=bool)
    for row in range(len(pieces)):
        same = np.flatnonzero((known == own[row]).all(axis=1))
        if len(same) == 0:
            continue
        t, p = (values[0] for values in sample_pieces(graph, pieces.select(np.array([row])), PLACES))
        one = outward(graph, pieces.select(np.full(len(t), row)), t)
        others = found.select(same)
        at, curve = sample_pieces(graph, others, SAMPLES)
        a, b = curve[:, :-1].reshape(-1, 3), curve[:, 1:].reshape(-1, 3)
        off = np.stack([distance_to_segments(np.broadcast_to(place, a.shape), a, b) for place in p])
        nearest = np.argmin(off, axis=1)
        piece, segment = np.divmod(nearest, len(SAMPLES) - 1)
        other = outward(graph, others.select(piece), (at[piece, segment] + at[piece, segment + 1]) / 2)
        facing = (np.einsum("ki,ki->k", one, other) > SAME_SIDE_COS) | ~one.any(axis=1) | ~other.any(axis=1)
        beside[row] = bool(((off[np.arange(len(p)), nearest] <= near_mm) & facing).any())
    return beside


def is_filled(graph: BrepGraph, trimmed: TrimmedFaces, pieces: SeamPieces) -> BoolArray:
    """Tell in which gaps another solid lies, a shim or a gasket; shape (k,)."""
    if len(pieces) == 0:
        return np.zeros(0, dtype=bool)
    p, along = evaluate_edges(graph, pieces.edge, (pieces.t0 + pieces.t1) / 2)
    normal, gap = project_to_faces(graph, pieces.wall, p).normal, pieces.gap_mm[:, 1:2]
    across = np.cross(normal, along / np.linalg.norm(along, axis=1, keepdims=True)) * gap / 2  # in a butt, over the gap
    middles = ((p + project_to_faces(graph, pieces.base, p).p) / 2, p + across, p - across)
    points = np.concatenate([middle - depth * normal * gap for middle in middles for depth in DEPTHS])
    row, solid = find_solids_around(ExactMaterial(graph, trimmed), points)
    row %= len(pieces)
    filled = np.zeros(len(pieces), dtype=bool)
    filled[row[(solids_of(graph, pieces)[row] != solid[:, None]).all(axis=1)]] = True
    return filled
