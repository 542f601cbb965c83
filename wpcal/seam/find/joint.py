"""From contacts to joints: which faces meet, on which side the weld lies, and what the joint is called.

At a contact edge three faces meet. The edge bounds two faces of one member: the *contact face*, which is opposed to the
face of the other member, and the *wall*. The face of the other member is the *base*. The weld lies between wall and
base. If the other member ends flush at the edge, its face around the corner is the base.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces, distance_to_segments
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.contact import CHUNK, Contacts
from wpcal.seam.limits import OPPOSED_COS
from wpcal.seam.seam import JointType, SeamPieces, WeldType

SAME_PLANE = 0.99
"""Cosine between normals of faces that continue each other (8 degrees)."""
FLAT_COS = 0.7
"""Wall and base are side by side (butt or edge joint) if the cosine between their normals is above this (45
degrees)."""
EXTENT_BISECTIONS = 16
"""Bisections of an extent: from a quarter of it to a few hundred-thousandths."""
EXTENT_SAMPLES = 40
"""Distances at which the extent of a face is tested, in a geometric series: neighbours differ by a factor of 1.25."""


@dataclass(frozen=True, slots=True, eq=False)
class JoinedPieces:
    """Pieces of seams with the words for their joints.

    Parameters
    ----------
    pieces : SeamPieces
    joint : tuple of JointType
    weld : tuple of WeldType
    """

    pieces: SeamPieces
    joint: tuple[JointType, ...]
    weld: tuple[WeldType, ...]

    def select(self, rows: IntArray) -> JoinedPieces:
        """Return the pieces at `rows`, shape (m,)."""
        joint, weld = tuple(self.joint[i] for i in rows), tuple(self.weld[i] for i in rows)
        return JoinedPieces(self.pieces.select(rows), joint, weld)


@dataclass(frozen=True, slots=True)
class JointView:
    """What a cross-section through a contact looks like. The *member* is the solid whose edge is in contact.

    Parameters
    ----------
    base_continues : bool
        The base goes on in front of the wall.
    member_upright : bool
        The member reaches farther up from the other member than it is thick there: it is not lying on it.
    other_upright : bool
        The same for the other member, seen from its own flush face.
    base_beyond : bool
        The base goes on behind the member.
    side_by_side : bool
        Wall and base face the same way.
    concave : bool
        Wall and base face each other.
    """

    base_continues: bool
    member_upright: bool
    other_upright: bool
    base_beyond: bool
    side_by_side: bool
    concave: bool

    @property
    def words(self) -> tuple[JointType, WeldType]:
        """The words of ISO 17659 for the joint, and the weld that is laid into it."""
        if self.base_continues:
            if not self.member_upright:
                return JointType.LAP, WeldType.FILLET
            return (JointType.TEE if self.base_beyond else JointType.CORNER), WeldType.FILLET
        if not self.side_by_side or self.member_upright != self.other_upright:
            return JointType.CORNER, (WeldType.FILLET if self.concave else WeldType.GROOVE)
        return (JointType.BUTT if self.member_upright else JointType.EDGE), WeldType.GROOVE


def join_contacts(graph: BrepGraph, trimmed: TrimmedFaces, contacts: Contacts, *, gap_mm: float) -> JoinedPieces:
    """Find wall, base and joint of every contact; contacts inside a contact area are left out.

    Parameters
    ----------
    graph, trimmed :
        The part.
    contacts : Contacts
    gap_mm : float
        The gap with which they were found, mm.

    Returns
    -------
    JoinedPieces
    """
    e, f = contacts.edge, contacts.face
    p, slope = evaluate_edges(graph, e, (contacts.t0 + contacts.t1) / 2)
    n_face = project_to_faces(graph, f, p).normal
    sides = graph.edge_faces[e]
    n_sides = np.stack([project_to_faces(graph, np.maximum(sides[:, k], 0), p).normal for k in (0, 1)], axis=1)
    against = np.einsum("kij,kj->ki", n_sides, n_face)
    patch = np.argmin(against, axis=1)
    rows = np.arange(len(e))
    has_wall = (against[rows, patch] < OPPOSED_COS) & (against[rows, 1 - patch] > OPPOSED_COS)
    has_wall &= (sides >= 0).all(axis=1)
    e, f, p, n_face, rows = e[has_wall], f[has_wall], p[has_wall], n_face[has_wall], np.flatnonzero(has_wall)
    contact_face, wall = sides[rows, patch[rows]], sides[rows, 1 - patch[rows]]
    n_wall = n_sides[rows, 1 - patch[rows]]
    base, n_base, continues = _base(graph, trimmed, f, p, n_face, n_wall, gap_mm)
    slope = slope[has_wall]
    inward, up = _inward(n_wall, slope, -1.0), _inward(n_face, slope, 1.0)
    patch_pair = np.stack([contact_face, f], axis=1)
    width = _extent(graph, trimmed, contact_face, p, inward, gap_mm)
    upright = _extent(graph, trimmed, wall, p, up, gap_mm) >= _thickness(patch_pair, width)
    other_thickness = _thickness(patch_pair, _extent(graph, trimmed, f, p, inward, gap_mm))
    flush = np.flatnonzero(~continues)  # only these need the view from the other member
    other_upright = np.zeros(len(e), dtype=bool)
    other_height = _extent(graph, trimmed, base[flush], p[flush], -up[flush], gap_mm)
    other_upright[flush] = other_height >= other_thickness[flush]
    beyond = _is_on(graph, trimmed, f, p + (width[:, None] + 2.0 * gap_mm + 0.1) * inward)
    columns = {
        "base_continues": continues,
        "member_upright": upright,
        "other_upright": other_upright,
        "base_beyond": beyond,
        "side_by_side": np.einsum("ki,ki->k", n_wall, n_base) > FLAT_COS,
        "concave": np.einsum("ki,ki->k", up, n_base) > 1 - FLAT_COS,
    }
    rows_of_views = zip(*(column.tolist() for column in columns.values()), strict=True)
    words = [JointView(**dict(zip(columns, view, strict=True))).words for view in rows_of_views]
    pieces = SeamPieces(e, contacts.t0[rows], contacts.t1[rows], wall, base, contacts.gap_mm[rows])
    return JoinedPieces(pieces, tuple(joint for joint, _ in words), tuple(weld for _, weld in words))


def _thickness(patch: IntArray, width: FloatArray) -> FloatArray:
    """Return how thick the member is at each piece: the least width of the contact area (pair of faces)."""
    _, group = np.unique(patch, axis=0, return_inverse=True)
    least = np.full(group.max(initial=-1) + 1, np.inf)
    np.minimum.at(least, group.ravel(), width)
    return np.asarray(least[group.ravel()], dtype=np.float64)


def _inward(normal: FloatArray, slope: FloatArray, sign: float) -> FloatArray:
    """Return sign times the part of `normal` across the edge, of unit length."""
    x = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    across = normal - np.einsum("ki,ki->k", normal, x)[:, None] * x
    return np.asarray(sign * across / np.linalg.norm(across, axis=1, keepdims=True), dtype=np.float64)


def _base(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    face: IntArray,
    p: FloatArray,
    n_face: FloatArray,
    n_wall: FloatArray,
    gap_mm: float,
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Return the face that the weld is laid on, its normal, and whether it continues beyond the wall."""
    out = n_wall - np.einsum("ki,ki->k", n_wall, n_face)[:, None] * n_face
    length = np.linalg.norm(out, axis=1, keepdims=True)
    step = 2.0 * gap_mm + 0.1  # beyond the tolerance for a flush edge
    continues = _is_on(graph, trimmed, face, p + step * out / np.where(length > 0, length, 1.0))
    base, normal = face.copy(), n_face.copy()
    for row in np.flatnonzero(~continues):
        neighbour = _face_around_corner(graph, trimmed, int(face[row]), p[row])
        if neighbour < 0:
            continue
        n = project_to_faces(graph, [neighbour], p[row][None]).normal[0]
        continues[row] = bool(n @ n_face[row] > SAME_PLANE)
        base[row], normal[row] = neighbour, n
    return base, normal, continues


def _face_around_corner(graph: BrepGraph, trimmed: TrimmedFaces, face: int, p: FloatArray) -> int:
    """Return the face beyond the boundary of `face` that is nearest to p, or -1."""
    pieces = slice(trimmed.start[face], trimmed.start[face + 1])
    p0, p1 = trimmed.p0[pieces], trimmed.p1[pieces]
    if len(p0) == 0:
        return -1
    nearest = int(np.argmin(distance_to_segments(np.broadcast_to(p, p0.shape), p0, p1)))
    left, right = graph.edge_faces[trimmed.piece_edge[pieces][nearest]]
    return int(right if left == face else left)


def _is_on(graph: BrepGraph, trimmed: TrimmedFaces, face: IntArray, points: FloatArray) -> BoolArray:
    """Tell whether the nearest points of surfaces lie inside the trimmed faces."""
    on = np.zeros(len(face), dtype=bool)
    for first in range(0, len(face), CHUNK):
        own = slice(first, first + CHUNK)
        foot = project_to_faces(graph, face[own], points[own])
        on[own] = trimmed.contains(face[own], foot.uv)
    return on


def _extent(
    graph: BrepGraph, trimmed: TrimmedFaces, face: IntArray, p: FloatArray, direction: FloatArray, gap_mm: float
) -> FloatArray:
    """Measure how far faces extend from p in a direction, mm: to the first gap between points in a geometric series."""
    steps = np.geomspace(2.0 * gap_mm + 0.1, max(graph.size_mm, 1.0), EXTENT_SAMPLES)
    first_off = np.full(len(p), len(steps) - 1)
    rows = np.arange(len(p))
    for number, step in enumerate(steps):
        on = _is_on(graph, trimmed, face[rows], p[rows] + step * direction[rows])
        first_off[rows[~on]] = number
        rows = rows[on]
    low, high = np.where(first_off > 0, steps[first_off - 1], 0.0), steps[first_off]
    for _ in range(EXTENT_BISECTIONS):
        middle = (low + high) / 2
        holds = _is_on(graph, trimmed, face, p + middle[:, None] * direction)
        low, high = np.where(holds, middle, low), np.where(holds, high, middle)
    return np.asarray(high, dtype=np.float64)
