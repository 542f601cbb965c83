"""On which side of a contact the weld lies, at many places along it, and where that changes.

At a contact edge three faces meet. The edge bounds two faces of one member: the *contact face*, which is opposed to the
face of the other member, and the *wall*. The face of the other member is the *base*. The weld lies between wall and
base. If the other member ends flush at the edge, its face around the corner is the base. Where the members touch along
a line only, no face is opposed, and either face may be the wall.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.surfaces import part_across, project_to_faces, unit
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray, blocks, numbered_rows
from wpcal.core.last_held import last_held
from wpcal.seam.find.contact import CHUNK, EdgeContacts
from wpcal.seam.limits import OPPOSED_COS

ALONG_COS = 0.5
"""A face along an edge has its normal across the edge; above this cosine between them, the file is damaged."""
SAME_PLANE = 0.99  #: Cosine between normals of faces that continue each other (8 degrees).
FLAT_COS = 0.7
"""Wall and base are side by side (butt or edge joint) if the cosine between their normals is above this (45
degrees)."""
STATION_MM = 8.0
"""Distance between the places of a contact at which its side is decided: a shorter change is not a change."""
LEAST_STATIONS, MOST_STATIONS = 5, 129  #: Places per contact, odd numbers: the middle is one of them.
LENGTH_SAMPLES = 9  #: Points of a curve by whose polyline its length is estimated, to choose the number of places.
INSET_MM, MOST_INSET = 1.0, 0.125
"""How far the outermost places are from the ends of a contact: mm, and as a share of its length."""
OPENING_RAD = (np.radians(20.0), np.radians(200.0))
"""Between wall and base where members touch along a line: less is a slit, and more is the outside of a corner."""
SAME_SINE = 0.1
"""Seen from the wall and from the base, the sine of an opening is the same; with material between them it has the other
sign. Along a curved edge, and across a gap, the two differ by some hundredths."""
HALVINGS = 28  #: Of the place where the side changes: from 8 mm to 3e-8 mm.


CONTINUES = 1
"""The kind of a side on which the touched face, or a face that continues it, goes on in front of the wall."""


@dataclass(frozen=True, slots=True, eq=False)
class Sides(Columns):
    """What meets at places on contacts."""

    contact: IntArray  #: shape (m,). Row of the contact.
    t: FloatArray  #: shape (m,). Parameter on its edge.
    #: `p`, `slope`: shape (m, 3). The place, mm, and the derivative of the edge there.
    p: FloatArray
    slope: FloatArray
    #: `patch`, `wall`, `base`: shape (m,). Faces.
    patch: IntArray
    wall: IntArray
    base: IntArray
    #: `n_face`, `n_wall`, `n_base`: shape (m, 3). Outward normals of the touched face, the wall and the base.
    n_face: FloatArray
    n_wall: FloatArray
    n_base: FloatArray
    #: shape (m,). Whether the contact face is opposed to the touched face and the wall is not: otherwise there is no
    #: joint.
    has_wall: BoolArray
    continues: BoolArray  #: shape (m,). Whether the touched face goes on in front of the wall.

    @property
    def side_by_side(self) -> BoolArray:
        """Whether wall and base face the same way."""
        return np.asarray(np.einsum("ki,ki->k", self.n_wall, self.n_base) > FLAT_COS, dtype=bool)

    @property
    def concave(self) -> BoolArray:
        """Whether wall and base face each other."""
        up = inward(self.n_face, self.slope, 1.0)
        return np.asarray(np.einsum("ki,ki->k", up, self.n_base) > 1 - FLAT_COS, dtype=bool)

    @property
    def kind(self) -> IntArray:
        """A number for the side on which the weld lies: equal numbers, equal joints, whatever the faces."""
        around = 2 * self.side_by_side + 4 * self.concave + 8
        return np.asarray(np.where(self.has_wall, np.where(self.continues, CONTINUES, around), 0), dtype=np.int64)


def step_mm(gap_mm: float) -> float:
    """Return how far a face must go on from a contact edge to be there, mm: beyond the tolerance for a flush edge."""
    return 2.0 * gap_mm + 0.1


def _is_along(normal: FloatArray, slope: FloatArray) -> BoolArray:
    """Tell whether an edge runs along a face with this normal; in a damaged file it may run into it, or nowhere."""
    along = np.abs(np.einsum("ki,ki->k", normal, slope))
    return np.asarray(along < ALONG_COS * np.linalg.norm(slope, axis=1), dtype=bool)


def inward(normal: FloatArray, slope: FloatArray, sign: float) -> FloatArray:
    """Return sign times the part of `normal` across the edge, of unit length. Zero where there is none.

    `normal`, `slope`: shape (m, 3). Normals of a face, and directions of the edge.
    """
    return sign * unit(part_across(normal, unit(slope)))


def stations_of(graph: BrepGraph, contacts: EdgeContacts) -> tuple[IntArray, FloatArray]:
    """Return places along all contacts, the middle of each included.

    The outermost places are `INSET_MM` from the ends: there, at the corners of faces, the side is round-off.

    Returns `contact`: ndarray of int, shape (m,). Rising.
    Returns `t`: ndarray, shape (m,). Parameters on the edges.
    """
    t = contacts.t0[:, None] + (contacts.t1 - contacts.t0)[:, None] * np.linspace(0.0, 1.0, LENGTH_SAMPLES)
    p = evaluate_edges(graph, np.repeat(contacts.edge, LENGTH_SAMPLES), t.ravel())[0].reshape(*t.shape, 3)
    length = np.linalg.norm(np.diff(p, axis=1), axis=2).sum(axis=1)
    steps = np.clip(np.ceil(length / STATION_MM / 2.0).astype(np.int64) * 2, LEAST_STATIONS - 1, MOST_STATIONS - 1)
    contact, number = numbered_rows(steps + 1)
    inset = np.minimum(INSET_MM / np.where(length > 0, length, 1.0), MOST_INSET)[contact]
    share = inset + (1.0 - 2.0 * inset) * number / steps[contact]
    return contact, contacts.t0[contact] * (1.0 - share) + contacts.t1[contact] * share


def find_sides(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    contacts: EdgeContacts,
    contact: IntArray,
    t: FloatArray,
    *,
    ledge_mm: float,
) -> Sides:
    """Decide wall and base at places on contacts.

    `contact`: shape (m,). Rows of `contacts`.
    `t`: shape (m,). Parameters on their edges.
    `ledge_mm`: How far the base must go on in front of the wall, mm.
    """
    edge, face = contacts.edge[contact], contacts.face[contact]
    p, slope = evaluate_edges(graph, edge, t)
    n_face = project_to_faces(graph, face, p).normal
    sides = graph.edge_faces[edge]
    n_sides = np.stack([project_to_faces(graph, np.maximum(sides[:, k], 0), p).normal for k in (0, 1)], axis=1)
    against = np.einsum("kij,kj->ki", n_sides, n_face)
    rows = np.arange(len(edge))
    if contacts.wall is None:
        number = np.argmin(against, axis=1)
        has_wall = (against[rows, number] < OPPOSED_COS) & (against[rows, 1 - number] > OPPOSED_COS)
    else:
        number = np.where(sides[:, 0] == contacts.wall[contact], 1, 0)
        has_wall = np.ones(len(edge), dtype=bool)
        area = np.flatnonzero(against[rows, number] < OPPOSED_COS)  # opposed, but perhaps not opposite each other
        way = ways_on(slope[area], (n_sides[area, number[area]],), (n_sides[area, 1 - number[area]],))[0]
        has_wall[area] = ~is_on(graph, trimmed, face[area], p[area] + ledge_mm * way)
    n_wall = n_sides[rows, 1 - number]
    has_wall &= (sides >= 0).all(axis=1) & _is_along(n_wall, slope) & _is_along(n_face, slope)
    base, n_base, continues = face.copy(), n_face.copy(), np.zeros(len(edge), dtype=bool)
    own = np.flatnonzero(has_wall)
    found = _base(trimmed, face[own], p[own], n_face[own], n_wall[own], ledge_mm)
    base[own], n_base[own], continues[own] = found
    if contacts.wall is not None:
        n_patch = n_sides[rows, number]
        angle = _opening_rad(slope, (n_wall, n_base), (n_patch, np.where(continues[:, None], -n_wall, n_face)))
        has_wall &= (angle >= OPENING_RAD[0]) & (angle <= OPENING_RAD[1])
        flush = np.flatnonzero(against[rows, 1 - number] > SAME_PLANE)
        base[flush], n_base[flush], continues[flush] = face[flush], n_face[flush], False
        step = ledge_mm * inward(n_patch, slope, 1.0)[flush]  # the face is on one side of the edge only
        there, beyond = (is_on(graph, trimmed, face[flush], at) for at in (p[flush] + step, p[flush] - step))
        has_wall[flush] = there & ~beyond
    patch, wall = sides[rows, number], sides[rows, 1 - number]
    return Sides(contact, t, p, slope, patch, wall, base, n_face, n_wall, n_base, has_wall, continues)


def ways_on(slope: FloatArray, normals: Sequence[FloatArray], behind: Sequence[FloatArray]) -> list[FloatArray]:
    """Return the directions in which faces go on from an edge, across it; unit vectors, each shape (m, 3).

    `normals`, `behind`: Of each face, shape (m, 3): the outward normal, and a direction away from which it goes on.
    """
    ways = []
    for normal, away in zip(normals, behind, strict=True):
        way = inward(np.cross(slope, normal), slope, 1.0)
        ways.append(np.where(np.einsum("ki,ki->k", way, away)[:, None] > 0, -way, way))
    return ways


def _opening_rad(slope: FloatArray, normals: Sequence[FloatArray], behind: Sequence[FloatArray]) -> FloatArray:
    """Return the angle in the open between two faces that meet at an edge, shape (m,), rad; NaN with material between.

    Parameters as in `ways_on`.
    """
    ways = ways_on(slope, normals, behind)
    sine, other = (np.einsum("ki,ki->k", n, way) for n, way in zip(normals, ways[::-1], strict=True))
    angle = np.mod(np.arctan2(sine, np.einsum("ki,ki->k", *ways)), 2.0 * np.pi)
    return np.asarray(np.where(np.abs(sine - other) < SAME_SINE, angle, np.nan), dtype=np.float64)


def _base(
    trimmed: TrimmedFaces, face: IntArray, p: FloatArray, n_face: FloatArray, n_wall: FloatArray, ledge_mm: float
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Return the face that the weld is laid on, its normal, and whether it continues beyond the wall."""
    graph = trimmed.graph
    out = part_across(n_wall, n_face)
    continues = is_on(graph, trimmed, face, p + ledge_mm * unit(out))
    base, normal = face.copy(), n_face.copy()
    rows = np.flatnonzero(~continues)
    neighbour = faces_around_corner(graph, trimmed, face[rows], p[rows])
    rows, neighbour = rows[neighbour >= 0], neighbour[neighbour >= 0]
    n = project_to_faces(graph, neighbour, p[rows]).normal
    continues[rows] = np.einsum("ki,ki->k", n, n_face[rows]) > SAME_PLANE
    other = ~continues[rows]
    base[rows[other]], normal[rows[other]] = neighbour[other], n[other]
    return base, normal, continues


def faces_around_corner(graph: BrepGraph, trimmed: TrimmedFaces, face: IntArray, p: FloatArray) -> IntArray:
    """Return the face beyond the boundary of each face that is nearest to its point, or -1.

    `face`, `p`: shape (m,) and (m, 3).
    """
    piece = trimmed.nearest_pieces(face, p)
    left, right = graph.edge_faces[trimmed.piece_edge[np.maximum(piece, 0)]].T
    return np.asarray(np.where(piece < 0, -1, np.where(left == face, right, left)), dtype=np.int64)


def is_on(graph: BrepGraph, trimmed: TrimmedFaces, face: IntArray, points: FloatArray) -> BoolArray:
    """Tell whether the nearest points of surfaces lie inside the trimmed faces, shape (m,).

    `face`: ndarray of int, shape (m,).
    `points`: shape (m, 3). In `part`, mm.
    """
    on = np.zeros(len(face), dtype=bool)
    for own in blocks(len(face), CHUNK):
        foot = project_to_faces(graph, face[own], points[own])
        on[own] = trimmed.contains(face[own], foot.uv)
    return on


@dataclass(frozen=True, slots=True, eq=False)
class Stretches(Columns):
    """Parts of contacts along which the weld lies on one side."""

    #: `t0`, `t1`: shape (k,). Parameters on the edges, t0 < t1.
    t0: FloatArray
    t1: FloatArray
    at: Sides  #: What meets at one place of each part, near its middle.
    is_cut: BoolArray  #: shape (k,). Whether the contact of a part has other parts.


def divide_contacts(graph: BrepGraph, trimmed: TrimmedFaces, contacts: EdgeContacts, *, gap_mm: float) -> Stretches:
    """Divide contacts where the side of the weld, or its base, changes.

    `gap_mm`: The gap with which they were found, mm.
    Returns Stretches. In the order of the contacts, and along each of them.
    """
    contact, t = stations_of(graph, contacts)
    sides = find_sides(graph, trimmed, contacts, contact, t, ledge_mm=step_mm(gap_mm))
    same_contact = contact[1:] == contact[:-1]
    change = np.flatnonzero(
        same_contact & _differ(sides.select(np.arange(len(t) - 1)), sides.select(np.arange(1, len(t))))
    )

    def is_same(row: IntArray, at: FloatArray) -> BoolArray:
        here = find_sides(graph, trimmed, contacts, contact[change[row]], at, ledge_mm=step_mm(gap_mm))
        return ~_differ(sides.select(change[row]), here)

    good, _ = last_held(t[change], t[change + 1], is_same, halvings=HALVINGS)
    first = np.flatnonzero(np.concatenate([[True], ~same_contact])) if len(t) else np.zeros(0, dtype=np.int64)
    begin = np.sort(np.concatenate([first, change + 1]))
    end = np.append(begin[1:], len(t))  # the stations of a stretch are begin:end
    cut_at = np.full(len(t) + 1, np.nan)
    cut_at[change + 1] = good
    t0 = np.where(np.isnan(cut_at[begin]), contacts.t0[contact[begin]], cut_at[begin])
    t1 = np.where(np.isnan(cut_at[end]), contacts.t1[contact[begin]], cut_at[end])
    is_cut = np.bincount(contact[begin], minlength=len(contacts.edge))[contact[begin]] > 1
    return Stretches(t0, t1, sides.select((begin + end) // 2), is_cut)


def _differ(one: Sides, other: Sides) -> BoolArray:
    """Tell at which places the side or the base differs."""
    faces = (one.base != other.base) | (one.wall != other.wall)
    return np.asarray((one.kind != other.kind) | (faces & one.has_wall), dtype=bool)
