"""From contacts to joints: what the joint is called, by how far the faces that meet there go on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray
from wpcal.core.last_held import last_held
from wpcal.seam.find.changes import without_small_changes
from wpcal.seam.find.contact import EdgeContacts
from wpcal.seam.find.sides import (
    SAME_PLANE,
    Sides,
    Stretches,
    divide_contacts,
    faces_around_corner,
    find_sides,
    inward,
    is_on,
    step_mm,
    ways_on,
)
from wpcal.seam.seam import JointType, SeamPieces, WeldType

OTHER_PLACES = (0.19, 0.81)  #: Where else than in its middle a curved piece is looked at, as shares of its parameter.
BEVEL_COS = (0.26, 0.97)  #: Between the normals of a bevel and of the surface beside it: 15 to 75 degrees.
MOST_SIDE_MM = 60.0  #: The sides of a groove are shorter: 50 mm of plate at 30 degrees.
MOST_STEP = 0.1  #: Between the surfaces of two plates in one line, as a share of the side of the groove between them.
EXTENT_HALVINGS = 16  #: Of an extent: from a quarter of it to a few hundred-thousandths.
EXTENT_SAMPLES = 40
EXTENT_TOGETHER = 5  #: Points of each face that are compared at once.
"""Distances at which the extent of a face is tested, in a geometric series: neighbours differ by a factor of 1.25."""


@dataclass(frozen=True, slots=True, eq=False)
class JoinedPieces(Columns):
    """Pieces of seams with the words for their joints."""

    pieces: SeamPieces
    joint: tuple[JointType, ...]
    weld: tuple[WeldType, ...]

    @classmethod
    def together(cls, parts: Iterable[JoinedPieces]) -> JoinedPieces:
        """Return the pieces of all parts, in their order."""
        return cls.joined([cls(SeamPieces.none(), (), ()), *parts])


@dataclass(frozen=True, slots=True)
class JointView:
    """What a cross-section through a contact looks like. The *member* is the solid whose edge is in contact."""

    base_continues: bool  #: The base goes on in front of the wall.
    base_below: bool  #: The base goes on below the member: the two do not only touch along their edges.
    #: The member reaches farther up from the other member than it is thick there: it is not lying on it.
    member_upright: bool
    other_upright: bool  #: The same for the other member, seen from its own flush face.
    base_beyond: bool  #: The base goes on behind the member.
    side_by_side: bool  #: Wall and base face the same way.
    concave: bool  #: Wall and base face each other.

    @property
    def words(self) -> tuple[JointType, WeldType]:
        """The words of ISO 17659 for the joint, and the weld that is laid into it."""
        if self.base_continues:
            if not self.base_below:
                return JointType.CORNER, WeldType.FILLET
            if not self.member_upright:
                return JointType.LAP, WeldType.FILLET
            return (JointType.TEE if self.base_beyond else JointType.CORNER), WeldType.FILLET
        if not self.side_by_side or self.member_upright != self.other_upright:
            return JointType.CORNER, (WeldType.FILLET if self.concave else WeldType.GROOVE)
        return (JointType.BUTT if self.member_upright else JointType.EDGE), WeldType.GROOVE


def join_contacts(graph: BrepGraph, trimmed: TrimmedFaces, contacts: EdgeContacts, *, gap_mm: float) -> JoinedPieces:
    """Find wall, base and joint of every contact; contacts inside a contact area are left out.

    `gap_mm`: The gap with which they were found, mm.
    """
    stretches = divide_contacts(graph, trimmed, contacts, gap_mm=gap_mm)
    stretches = without_small_changes(graph, trimmed, contacts, stretches, gap_mm=gap_mm)
    stretches = stretches.select(stretches.at.has_wall)
    at, rows = stretches.at, stretches.at.contact
    e, f, p = contacts.edge[rows], contacts.face[rows], at.p
    contact_face, wall, base, continues = at.patch, at.wall, at.base, at.continues
    behind, up = inward(at.n_wall, at.slope, -1.0), inward(at.n_face, at.slope, 1.0)
    patch_pair = np.stack([contact_face, f], axis=1)
    width = _width(graph, trimmed, contacts, at, gap_mm)
    thickness = _thickness(patch_pair, width)
    upright = _extent(graph, trimmed, wall, p, up, gap_mm) >= thickness
    low = np.flatnonzero(~upright)
    upright[low] = bevelled_mm(graph, trimmed, at.select(low), gap_mm) >= thickness[low]
    other_thickness = _thickness(patch_pair, _extent(graph, trimmed, f, p, behind, gap_mm))
    flush = np.flatnonzero(~continues)  # only these need the view from the other member
    other_upright = np.zeros(len(e), dtype=bool)
    other_height = _extent(graph, trimmed, base[flush], p[flush], -up[flush], gap_mm)
    other_upright[flush] = other_height >= other_thickness[flush]
    below = is_on(graph, trimmed, f, p + step_mm(gap_mm) * behind)
    beyond = _goes_on_behind(graph, trimmed, contacts, stretches, width, gap_mm)
    columns = {
        "base_continues": continues,
        "base_below": below,
        "member_upright": upright,
        "other_upright": other_upright,
        "base_beyond": beyond,
        "side_by_side": at.side_by_side,
        "concave": at.concave,
    }
    rows_of_views = zip(*(column.tolist() for column in columns.values()), strict=True)
    words = [JointView(**dict(zip(columns, view, strict=True))).words for view in rows_of_views]
    maybe = np.flatnonzero([joint in (JointType.CORNER, JointType.TEE) for joint, _ in words])
    is_tee = np.array([words[row][0] is JointType.TEE for row in maybe.tolist()], dtype=bool)
    for row in maybe[_are_grooves(graph, trimmed, at.select(maybe), is_tee, gap_mm)].tolist():
        words[row] = JointType.BUTT, WeldType.GROOVE
    pieces = SeamPieces(e, stretches.t0, stretches.t1, wall, base, contacts.gap_mm[rows])
    return JoinedPieces(pieces, tuple(joint for joint, _ in words), tuple(weld for _, weld in words))


def _are_grooves(graph: BrepGraph, trimmed: TrimmedFaces, at: Sides, is_tee: BoolArray, gap_mm: float) -> BoolArray:
    """Tell where wall and base are the sides of a groove, of which one at least is bevelled.

    Beyond both, the members have surfaces in one direction; of what else would be a tee, in one plane.
    """
    n_patch = project_to_faces(graph, at.patch, at.p).normal
    away = n_patch, np.where(at.continues[:, None], -at.n_wall, at.n_face)
    (to_wall, *beyond_wall), (to_base, *beyond_base) = (
        _beyond(graph, trimmed, (face, at.p, at.slope), own, behind, gap_mm)
        for face, own, behind in zip((at.wall, at.base), (at.n_wall, at.n_base), away, strict=True)
    )
    lean = beyond_wall[2], beyond_base[2]
    least, most = np.minimum(*lean), np.maximum(*lean)  # a square side has none
    grooves = (least > -BEVEL_COS[0]) & (most > BEVEL_COS[0]) & (most < BEVEL_COS[1])
    wall_mm, base_mm = np.linalg.norm(to_wall, axis=1), np.linalg.norm(to_base, axis=1)
    grooves &= np.maximum(wall_mm, base_mm) <= MOST_SIDE_MM
    step = np.abs(np.einsum("ki,ki->k", to_wall - to_base, beyond_wall[1]))
    grooves &= ~is_tee | (step <= MOST_STEP * wall_mm)
    return np.asarray(grooves & (np.einsum("ki,ki->k", beyond_wall[1], beyond_base[1]) > SAME_PLANE), dtype=bool)


def bevelled_mm(graph: BrepGraph, trimmed: TrimmedFaces, at: Sides, gap_mm: float) -> FloatArray:
    """Measure how far walls go on that are bevels, with the surfaces beyond them, mm; 0 where a wall is none.

    A bevel is narrow, and beyond it the member goes on at an angle of 15 to 75 degrees.
    """
    away = project_to_faces(graph, at.patch, at.p).normal
    side, other, normal, lean = _beyond(graph, trimmed, (at.wall, at.p, at.slope), at.n_wall, away, gap_mm)
    (way,), width_mm = ways_on(at.slope, [normal], [-side]), np.linalg.norm(side, axis=1)
    beyond_mm = _extent(graph, trimmed, np.maximum(other, 0), at.p + side, way, gap_mm)
    is_bevel = (lean > BEVEL_COS[0]) & (lean < BEVEL_COS[1]) & (width_mm <= MOST_SIDE_MM)
    return np.where(is_bevel, width_mm + beyond_mm, 0.0)


def _beyond(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    edge: tuple[IntArray, FloatArray, FloatArray],
    normal: FloatArray,
    away: FloatArray,
    gap_mm: float,
) -> tuple[FloatArray, IntArray, FloatArray, FloatArray]:
    """Return ways over faces from an edge on, what is beyond, its normals, and their cosines with the faces' own.

    `edge`: The faces, and places and directions of the edge. `away`: As in `sides.ways_on`.
    """
    face, p, slope = edge
    (way,) = ways_on(slope, [normal], [away])
    width_mm = _extent(graph, trimmed, face, p, way, gap_mm)
    far = p + width_mm[:, None] * way
    other = faces_around_corner(graph, trimmed, face, far)
    beyond = np.where((other >= 0)[:, None], project_to_faces(graph, np.maximum(other, 0), far).normal, 0.0)
    return far - p, other, beyond, np.asarray(np.einsum("ki,ki->k", beyond, normal), dtype=np.float64)


def _goes_on_behind(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    contacts: EdgeContacts,
    stretches: Stretches,
    width: FloatArray,
    gap_mm: float,
) -> BoolArray:
    """Tell whether the touched face goes on behind the member, at most of three places on curved pieces.

    Behind a ring it may end where the ring is near a border, and nowhere else.
    """

    def is_behind(at: Sides, width: FloatArray) -> BoolArray:
        p = at.p + (width[:, None] + step_mm(gap_mm)) * inward(at.n_wall, at.slope, -1.0)
        return is_on(graph, trimmed, contacts.face[at.contact], p)

    at = stretches.at
    votes = is_behind(at, width).astype(np.int64) * 2 - 1
    curved = np.flatnonzero((graph.edge_kind[contacts.edge[at.contact]] != CurveKind.LINE) & at.continues)
    for share in OTHER_PLACES:
        t = stretches.t0[curved] * (1.0 - share) + stretches.t1[curved] * share
        there = find_sides(graph, trimmed, contacts, at.contact[curved], t, ledge_mm=step_mm(gap_mm))
        own = _width(graph, trimmed, contacts, there, gap_mm)
        votes[curved] += is_behind(there, own).astype(np.int64) * 2 - 1
    return np.asarray(votes > 0, dtype=bool)


def _width(graph: BrepGraph, trimmed: TrimmedFaces, contacts: EdgeContacts, at: Sides, gap_mm: float) -> FloatArray:
    """Measure how far the contact area goes on behind the wall, mm; of members that touch along a line, it has none."""
    if contacts.wall is not None:
        return np.zeros(len(at.t))
    return _extent(graph, trimmed, at.patch, at.p, inward(at.n_wall, at.slope, -1.0), gap_mm)


def _thickness(patch: IntArray, width: FloatArray) -> FloatArray:
    """Return how thick the member is at each piece: the least width of the contact area (pair of faces)."""
    _, group = np.unique(patch, axis=0, return_inverse=True)
    least = np.full(group.max(initial=-1) + 1, np.inf)
    np.minimum.at(least, group.ravel(), width)
    return np.asarray(least[group.ravel()], dtype=np.float64)


def _extent(
    graph: BrepGraph, trimmed: TrimmedFaces, face: IntArray, p: FloatArray, direction: FloatArray, gap_mm: float
) -> FloatArray:
    """Measure how far faces extend from p in a direction, mm: to the first gap between points in a geometric series."""
    steps = np.geomspace(step_mm(gap_mm), max(graph.size_mm, 1.0), EXTENT_SAMPLES)
    first_off = np.full(len(p), len(steps) - 1)
    rows = np.arange(len(p))
    for first in range(0, len(steps), EXTENT_TOGETHER):
        far = steps[first : first + EXTENT_TOGETHER, None]
        at = (p[rows, None] + far * direction[rows, None]).reshape(-1, 3)
        on = is_on(graph, trimmed, np.repeat(face[rows], len(far)), at).reshape(-1, len(far))
        whole = on.all(axis=1)
        first_off[rows[~whole]] = first + on[~whole].argmin(axis=1)
        rows = rows[whole]
    low, high = np.where(first_off > 0, steps[first_off - 1], 0.0), steps[first_off]

    def holds(row: IntArray, far: FloatArray) -> BoolArray:
        return is_on(graph, trimmed, face[row], p[row] + far[:, None] * direction[row])

    return last_held(low, high, holds, halvings=EXTENT_HALVINGS)[1]
