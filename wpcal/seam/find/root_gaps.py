"""Butt joints with a root gap of up to 3 mm: plates and tubes whose narrow ends face each other.

Such a gap is left on purpose, so that the weld goes through. It is far wider than what is taken for contact elsewhere,
so more is asked of it: two ends of one width, parallel, opposite each other all along, and nothing in between.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.concavity import are_concave, inner_edges
from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.material import ExactMaterial, find_solids_around
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, IntArray
from wpcal.seam.find.contact import find_edge_contacts
from wpcal.seam.find.duplicates import without_duplicates
from wpcal.seam.find.facing import INSET, FacingFaces, find_facing, widths_mm
from wpcal.seam.find.joint import BEVEL_COS, JoinedPieces, join_contacts
from wpcal.seam.find.wide_gaps import is_beside
from wpcal.seam.limits import NEAR_GAPS
from wpcal.seam.seam import JointType, SeamPieces

MOST_ROOT_MM = 3.0
"""Root gaps of butt welds are 1 to 3 mm (ISO 9692-1: up to 4 mm for V-grooves; robots bridge less than a hand)."""
MOST_ROOT_SHARE = 0.5
"""Largest root gap as a share of the width of the ends (ISO 9692-1: about t / 2 for square butts). The root faces of a
prepared groove are narrower: those with a bevel beside them may be as far apart as `MOST_ROOT_MM`."""
MOST_END_MM = 40.0
"""Ends are narrower: thicker plates are rarely welded by robots, and blocks beside each other are not ends."""
LEAST_OPPOSITE = 0.9  #: Share of the boundary of one end that lies opposite the other one.
SAME_WIDTH = 1.5  #: Largest ratio of the widths of two ends.


def find_root_gaps(graph: BrepGraph, trimmed: TrimmedFaces, found: SeamPieces, *, gap_mm: float) -> JoinedPieces:
    """Find butt joints with a gap above the usual one, up to `MOST_ROOT_MM`, beside which nothing else is found.

    `gap_mm`: The gap with which contacts were found, mm.
    """
    ends = _facing_ends(graph, trimmed, gap_mm)
    parts = [_at_gap(graph, trimmed, ends.select(ends.gap_mm == gap), float(gap)) for gap in np.unique(ends.gap_mm)]
    joined = JoinedPieces.together(parts)
    joined = joined.select(np.flatnonzero(~is_beside(graph, joined.pieces, found, NEAR_GAPS * MOST_ROOT_MM)))
    return without_duplicates(graph, joined, gap_mm=MOST_ROOT_MM / NEAR_GAPS)


def find_slits(graph: BrepGraph, trimmed: TrimmedFaces, solids: BoolArray, *, gap_mm: float) -> JoinedPieces:
    """Find the joints at narrow slits inside solids: members that were drawn as one body keep the play between them.

    `solids`: shape (S,). Which solids are searched.
    """
    slits = find_facing(graph, trimmed, most_mm=gap_mm, within=solids)
    contacts = find_edge_contacts(graph, trimmed, gap_mm=gap_mm, pairs=_pairs(graph, slits))
    return without_duplicates(graph, join_contacts(graph, trimmed, contacts, gap_mm=gap_mm), gap_mm=gap_mm)


def _facing_ends(graph: BrepGraph, trimmed: TrimmedFaces, above_mm: float) -> FacingFaces:
    """Return the pairs of narrow planes of one width that lie opposite each other."""
    facing = find_facing(graph, trimmed, most_mm=MOST_ROOT_MM)
    width = np.stack([widths_mm(trimmed, face) for face in (facing.first, facing.second)])
    fits = (graph.face_kind[facing.first] == SurfaceKind.PLANE) & (facing.gap_mm > above_mm)
    fits &= (facing.share >= LEAST_OPPOSITE) & (width.max(axis=0) <= MOST_END_MM)
    same = width.max(axis=0) <= SAME_WIDTH * width.min(axis=0)
    bevelled = np.isin(np.stack([facing.first, facing.second]), bevelled_faces(graph))
    narrower = np.where(width[0] <= width[1], bevelled[0], bevelled[1])  # before a square end, in a half V
    fits &= np.where(same, (facing.gap_mm <= MOST_ROOT_SHARE * width.min(axis=0)) | bevelled.all(axis=0), narrower)
    ends = facing.select(fits)
    return ends.select(~_is_filled(graph, trimmed, ends))


def bevelled_faces(graph: BrepGraph) -> IntArray:
    """Return the faces beside which there is a bevel: planes with bulging corners between 15 and 75 degrees, (k,)."""
    edges = inner_edges(graph)
    edges = edges[(graph.face_kind[graph.edge_faces[edges]] == SurfaceKind.PLANE).all(axis=1)]
    edges = edges[~are_concave(graph, edges)]
    faces = graph.edge_faces[edges]
    n = graph.face_frame[faces, 3] * graph.face_outward[faces][..., None]
    cos = np.einsum("ki,ki->k", n[:, 0], n[:, 1])
    return np.unique(faces[(cos > BEVEL_COS[0]) & (cos < BEVEL_COS[1])])


def _is_filled(graph: BrepGraph, trimmed: TrimmedFaces, ends: FacingFaces) -> BoolArray:
    """Tell in which gaps there is another solid, a shim or a backing bar; shape (k,)."""
    count = np.diff(trimmed.start)[ends.first]
    pair = np.repeat(np.arange(len(count)), count)
    piece = np.concatenate([np.zeros(0, dtype=np.int64), *map(np.arange, *trimmed.start[[ends.first, ends.first + 1]])])
    middle = (trimmed.p0[piece] + trimmed.p1[piece]) / 2
    low, high = trimmed.face_box
    centre = ((low + high) / 2)[ends.first]
    normal = graph.face_frame[ends.first, 3] * (graph.face_outward[ends.first] * ends.gap_mm / 2)[:, None]
    points = middle + INSET * (centre[pair] - middle) + normal[pair]
    filled = np.zeros(len(count), dtype=bool)
    filled[pair[find_solids_around(ExactMaterial(graph, trimmed), points)[0]]] = True
    return filled


def _at_gap(graph: BrepGraph, trimmed: TrimmedFaces, ends: FacingFaces, gap_mm: float) -> JoinedPieces:
    """Return the butt joints between ends that have one gap."""
    contacts = find_edge_contacts(graph, trimmed, gap_mm=gap_mm, pairs=_pairs(graph, ends))
    joined = join_contacts(graph, trimmed, contacts, gap_mm=gap_mm)
    sides, bevelled = np.stack([joined.pieces.wall, joined.pieces.base]), bevelled_faces(graph)
    is_butt = np.array([word is JointType.BUTT for word in joined.joint], dtype=bool)
    return joined.select(np.flatnonzero(is_butt | np.isin(sides, bevelled).any(axis=0)))


def _pairs(graph: BrepGraph, ends: FacingFaces) -> tuple[IntArray, IntArray]:
    """Return the edges of each end with the other one."""
    edges, faces = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for a, b in zip(ends.first.tolist(), ends.second.tolist(), strict=True):
        for own, other in ((a, b), (b, a)):
            edges.append(np.flatnonzero((graph.edge_faces == own).any(axis=1) & ~graph.is_seam_edge))
            faces.append(np.full(len(edges[-1]), other))
    return np.concatenate(edges), np.concatenate(faces)
