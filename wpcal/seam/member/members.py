"""What a solid was made of: plates, bars, tubes, rolled profiles and formed sheets that together explain its surface.

Every plate, stretch, round and formed sheet that can be read from the faces is a hypothesis. Of all of them, those are
chosen that explain most of the surface with the fewest members (a small integer programme). A corner between two
members is a joint, and one inside a member was rolled, bent or cut.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wpcal.brep.concavity import are_concave, inner_edges
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.surfaces import off_axis, project_to_faces, square_to
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.linked import linked_groups
from wpcal.seam.find.built_up import (
    FLATTEST,
    LEAST_BUILT_UP,
    OPPOSITE_COS,
    SAME_THICKNESS,
    SKIN_MM,
    Surface,
    sampled_surface,
)
from wpcal.seam.find.formed import MOULDED_MM
from wpcal.seam.find.tubes import find_tubes
from wpcal.seam.member.heavy_bars import SLAB_MM, SLAB_MM2
from wpcal.seam.member.prisms import FEWEST_EDGES, Contour, Prism, find_prisms

COST_ROOT = 0.02  #: Of two that explain as much, the one with fewer inner corners is taken.
COST_UNEXPLAINED = 0.6  #: A face of which nothing is explained costs as much as so many members.
COST_SURFACE = 20.0  #: The whole surface, unexplained, costs as much as so many members.
ON_MM, ON_COS = 0.02, 0.999
"""A point is on a plane, or in a slab, within this; normals are parallel within 2.6 degrees."""
ON_RIM_MM = 0.5  #: The outline of a plate goes from side to side, but for broken edges.
THIN_SECTION = 0.3  #: A rolled profile is thinner than this share of its height.
ENDS_TOGETHER = 0.2
"""The sides of a profile with sharp roots go on beyond its ends by less than this share of its length: otherwise they
are plates on which others stand."""
COPED = 0.6  #: The web alone goes on by less than this share of the length: the flanges are coped.
MOST_WELDED = 4  #: A section with more roots was extruded: nobody welds so many seams along one member.
FOUR_WAYS, FOUR_WAYS_COS = (-1.0, 0.0, 0.0, 1.0), 0.2
"""Cosines, ascending, between one of four roots of an I section and all of them; its flanges may be inclined."""
SOLID_SHARE = 0.5  #: At least this share of the two faces of a plate has its thickness behind it.
SMALLEST_PROFILE_MM, THICKEST_PROFILE_MM = 10.0, 40.0
"""The smallest angle that is sold is so high, and the heaviest I section has flanges of so much."""
BOX_MM, BOX_WALL = 150.0, 0.1
"""Hollow sections with sharp corners that are so wide, shorter than wide, and whose wall is thinner than this share of
the shorter side, are boxes of plates."""
MOST_COVERED = 1  #: Sides of a tube of which nothing shows how thick its wall is.
SLENDER = 2.0  #: A profile with sharp roots is so many times longer than it is high, or the whole solid.
SLENDER_PLATE, SLENDER_WALL = 0.12, 0.2
"""A slender plate, bar or profile is thinner than this share of the root of its area; a slender tube has a wall thinner
than this share of its height."""
STOUT_MM = (20.0, 100.0)  #: A stout piece of bar is a member if it is so long, at most so thick, and the whole solid.
DRAWN_SOLID_MM = 250.0  #: Bars are rolled up to this thickness; what is thicker was a box, and was drawn solid.
BEVEL_COS, BEVELLED = -0.985, 0.25
"""The sides of a bevelled plate are within 10 degrees of opposite, and its thickness changes by so much."""
LUG = 0.5  #: A lug is thinner than this share of its width.
THINNEST_MM = 1.2  #: An arc burns through sheet that is thinner than the usual wire.
LEAST_OF_FACE = 0.8  #: A member explains a face if it explains more than this share of it.
WHOLE = 0.97  #: A member that explains so much of the surface is the whole solid.
SMOOTH_COS = 0.99  #: Faces run smoothly into each other if their normals are within 8 degrees.
MOST_HYPOTHESES = 400  #: Of a solid; the largest are kept.


class MemberKind(Enum):
    """What a member is, as it is bought or cut."""

    PLATE = "plate"
    BAR = "bar"
    TUBE = "tube"
    ROUND = "round bar or tube"
    PROFILE = "rolled profile"
    SHEET = "formed sheet"
    BOX = "box drawn solid"


COST = dict.fromkeys(MemberKind, 1.0) | {MemberKind.SHEET: 0.5}
"""Members that a hypothesis counts as: a formed sheet has two sides, and each is one."""


@dataclass(frozen=True, slots=True, eq=False)
class Member:
    """One member of a solid."""

    kind: MemberKind
    faces: frozenset[int]  #: Its sides.
    axis: FloatArray  #: shape (3,). Along it; of a plate, across it.
    #: shape (2,). Sides of the box around its section, mm; of a plate, its thickness and the root of its area.
    section: FloatArray
    thickness_mm: float
    length_mm: float
    roots: frozenset[tuple[int, int]] = frozenset()  #: Pairs of faces at corners that are inside the member.
    rims: frozenset[int] = frozenset()  #: Of a plate, the faces of its outline.

    @property
    def is_drawn_solid(self) -> bool:
        """Tell whether it is so thick that it was built up of plates round a hollow, and drawn without it."""
        return self.kind in (MemberKind.PLATE, MemberKind.BOX) and self.thickness_mm >= DRAWN_SOLID_MM

    @property
    def is_slab(self) -> bool:
        """Tell whether it is a thick board of some size."""
        is_board = self.kind in (MemberKind.PLATE, MemberKind.BAR) and not self.is_drawn_solid
        return is_board and self.section[0] >= SLAB_MM and self.section[1] * self.length_mm >= SLAB_MM2

    @property
    def is_stout(self) -> bool:
        """Tell whether it is a bar about as thick as it is long."""
        is_thin = self.thickness_mm <= FLATTEST * np.sqrt(self.length_mm * self.section[1])
        return self.kind is MemberKind.BAR and not is_thin

    @property
    def is_hollow(self) -> bool:
        """Tell whether it is a round tube, a rolled section or a bent plate: nobody makes such things of wood."""
        is_tube = self.kind is MemberKind.ROUND and self.thickness_mm < self.section[0]
        return self.kind is MemberKind.PROFILE or is_tube or (self.kind is MemberKind.SHEET and self.is_slender)

    @property
    def is_slender(self) -> bool:
        """Tell whether it is so thin for its size that it was hardly milled, and too thick to be moulded."""
        if self.thickness_mm <= MOULDED_MM:
            return False
        if self.kind in (MemberKind.TUBE, MemberKind.ROUND):  # a wall
            return bool(self.thickness_mm <= SLENDER_WALL * self.section[0])
        area = max(self.length_mm, self.section[0]) * self.section[1]
        return bool(self.thickness_mm <= SLENDER_PLATE * np.sqrt(area))

    @property
    def in_words(self) -> str:
        """What the member is, with its section: ``rolled profile 100 x 50``."""
        return f"{self.kind.value} {self.section[1]:.3g} x {self.section[0]:.3g}"


@dataclass(frozen=True, slots=True, eq=False)
class Decomposition:
    """The members of a solid."""

    members: tuple[Member, ...]
    share: float  #: Of the surface that they explain.
    straight_share: float  #: That is explained without formed sheets.
    explained: tuple[frozenset[int], ...] = ()  #: Of each member, the faces that it explains.

    @property
    def is_one(self) -> bool:
        """Tell whether one member explains the solid; the two sides of a formed sheet are one."""
        return sum(COST[one.kind] for one in self.members) <= 1.0 and self.share >= LEAST_BUILT_UP

    @property
    def is_box(self) -> bool:
        """Tell whether others stand on a box that was drawn solid: its thickness says nothing."""
        solid = [one.is_drawn_solid for one in self.members]
        return any(solid) and not all(solid)

    @property
    def is_moulded(self) -> bool:
        """Tell whether there are walls so thin that an arc burns through, and no member that is bought or cut."""
        stock = (MemberKind.TUBE, MemberKind.ROUND, MemberKind.PROFILE)
        is_stock = any(one.is_slender or one.is_drawn_solid or one.kind in stock for one in self.members)
        return not is_stock and any(one.thickness_mm < THINNEST_MM for one in self.members)

    def is_between(self, one: int, other: int) -> bool:
        """Tell whether two faces are on different members, both slender."""
        own = [{k for k, faces in enumerate(self.explained) if face in faces} for face in (one, other)]
        slender = [any(self.members[k].is_slender for k in members) for members in own]
        return all(slender) and not own[0] & own[1]

    def is_inside(self, one: int, other: int) -> bool:
        """Tell whether one member explains two faces: a corner between them was rolled, bent or cut with it."""
        return any(one in faces and other in faces for faces in self.explained)

    def around(self, faces: tuple[int, int], way: FloatArray, length_mm: float) -> Member | None:
        """Return the member inside which a straight corner between two faces is.

        `way`: shape (3,). Along the corner, a unit vector. A member holds corners along its axis, hardly longer:
        its section is not followed to its end where others stand on it. A plate holds those of its outline.
        """
        pair = (min(faces), max(faces))
        for one in self.members:
            is_outline = one.rims.issuperset(pair)
            most_mm = (1.0 + ENDS_TOGETHER) * (one.thickness_mm if is_outline else one.length_mm)
            if (is_outline or pair in one.roots) and abs(one.axis @ way) > ON_COS and length_mm <= most_mm:
                return one
        return None


def members_of(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> Decomposition:
    """Take a solid apart; done once, and kept in `trimmed.known`."""
    key = ("members", solid)
    if key not in trimmed.known:
        trimmed.known[key] = _take_apart(graph, trimmed, solid)
    found: Decomposition = trimmed.known[key]
    return found


def _take_apart(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> Decomposition:
    if not (graph.face_solid == solid).any():
        return Decomposition((), 0.0, 0.0)
    surface = sampled_surface(graph, trimmed, solid)
    pairs = [*_hypotheses(graph, trimmed, solid, surface)]
    pairs = sorted((pair for pair in pairs if pair[1].any()), key=lambda pair: -int(pair[1].sum()))[:MOST_HYPOTHESES]
    if not pairs or not len(surface.p):
        return Decomposition((), 0.0, 0.0)
    covers = np.array([cover for _, cover in pairs])
    cost = np.array([COST[member.kind] + COST_ROOT * len(member.roots) for member, _ in pairs])
    chosen = _cheapest(cost, covers, surface.face)
    members = tuple(pairs[row][0] for row in np.flatnonzero(chosen))
    straight = _are_straight(graph, members)
    share, straight_share = (float(own.any(axis=0).mean()) for own in (covers[chosen], covers[chosen][straight]))
    explained = _explained(graph, surface, members, covers[chosen])
    return Decomposition(members, share, straight_share, explained)


def _are_straight(graph: BrepGraph, members: tuple[Member, ...]) -> list[bool]:
    """Tell which members are no formed sheets, or pieces of rings beside slender ones, which others cover in part."""
    has_slender = any(member.is_slender for member in members)  # a ring in a foot as thick was cast with it
    return [member.kind is not MemberKind.SHEET or (has_slender and _is_ring(graph, member)) for member in members]


def _is_ring(graph: BrepGraph, member: Member) -> bool:
    """Tell whether a formed sheet is round about one axis and hollow: a stud is as thick as it is wide."""
    faces = list(member.faces)
    is_hollow = member.thickness_mm < graph.face_param[faces, 0]
    return bool((is_hollow & (graph.face_kind[faces] == SurfaceKind.CYLINDER)).all())


def _explained(
    graph: BrepGraph, surface: Surface, members: tuple[Member, ...], covers: BoolArray
) -> tuple[frozenset[int], ...]:
    """Return, of each member, its sides and the faces of which it explains nearly all points."""
    count = np.bincount(surface.face, minlength=graph.face_count)
    found = []
    for one, own in zip(members, covers, strict=True):
        on = np.bincount(surface.face[own], minlength=len(count))
        faces = one.faces | one.rims
        if one.rims & one.faces:  # it was cut across a body: a face that goes on is not of a plate
            faces = faces.difference(np.flatnonzero(on <= LEAST_OF_FACE * count).tolist())
        found.append(faces.union(np.flatnonzero(on > LEAST_OF_FACE * count).tolist()))
    return tuple(found)


def _cheapest(cost: FloatArray, covers: BoolArray, face: IntArray) -> BoolArray:
    """Return which hypotheses explain the points at least cost; points that the same ones explain count as one."""
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import csr_array, eye_array, hstack

    groups, of = np.unique(covers.T, axis=0, return_inverse=True)
    per_point = COST_UNEXPLAINED / np.bincount(face)[face] + COST_SURFACE / len(face)
    weight = np.bincount(of.ravel(), weights=per_point, minlength=len(groups))
    n, m = len(cost), len(groups)
    matrix = hstack([csr_array(groups.astype(np.float64)), eye_array(m)])
    answer = milp(
        np.concatenate([cost, weight]),
        integrality=np.concatenate([np.ones(n), np.zeros(m)]),
        bounds=Bounds(0.0, 1.0),
        constraints=LinearConstraint(matrix, lb=1.0),
        options={"node_limit": 2000, "mip_rel_gap": 1e-3},
    )
    return np.asarray(answer.x[:n] > 0.5) if answer.x is not None else np.zeros(n, dtype=bool)


def _hypotheses(
    graph: BrepGraph, trimmed: TrimmedFaces, solid: int, surface: Surface
) -> Iterator[tuple[Member, BoolArray]]:
    """Yield every hypothesis with the points of the surface that it explains."""
    yield from _plates(graph, trimmed, solid, surface)
    stretches, convex = find_prisms(graph, trimmed, solid), _convex_faces(graph, solid)
    for stretch in stretches:
        if not stretch.contour.is_bore:
            member = _of_stretch(graph, stretch, stretches)
            if member is not None:
                cover = _on_details(graph, surface, member, convex, _on_stretch(surface, stretch, member))
                is_stub = stretch.contour.sharp > 0 and member.length_mm < SLENDER * member.section[1]
                is_stub |= len(member.faces) > len(stretch.faces)  # a hollow extrusion
                is_stub &= member.kind is MemberKind.PROFILE
                if not (is_stub or member.is_stout) or cover.mean() >= WHOLE:
                    yield member, cover
        else:
            yield from _tube_of_bore(surface, stretch)
    yield from _rounds(graph, trimmed, solid, surface)
    yield from _sheets(graph, _smooth_edges(graph, solid), surface)


def _beside(graph: BrepGraph, faces: frozenset[int] | set[int], edges: IntArray | None = None) -> set[int]:
    """Return the faces that share an edge with some faces, or one of some edges, without these."""
    sides = graph.edge_faces if edges is None else graph.edge_faces[edges]
    own = np.isin(sides, list(faces))
    return set(sides[own.any(axis=1)].ravel().tolist()) - set(faces) - {-1}


def lugs_of(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> list[frozenset[int]]:
    """Return the sides and rims of each thick plate that stands on others: no member by itself, but cut from plate."""
    surface = sampled_surface(graph, trimmed, solid)
    found = []
    for one, _ in _plates(graph, trimmed, solid, surface, flattest=LUG):
        sides = np.array(sorted(one.faces))
        cos = graph.face_outward[sides] * (graph.face_frame[sides, 3] @ one.axis)  # of a wedge, one side is there
        if FLATTEST * one.length_mm < one.thickness_mm < DRAWN_SOLID_MM and cos.min() < 0.0 < cos.max():
            found.append(one.faces | one.rims)
    return found


def _plates(
    graph: BrepGraph, trimmed: TrimmedFaces, solid: int, surface: Surface, *, flattest: float = FLATTEST
) -> Iterator[tuple[Member, BoolArray]]:
    """Yield pairs of parallel planes with material between: much less of it than they are wide, or a box."""
    rows = np.flatnonzero(surface.flat & (graph.face_kind[surface.face] == SurfaceKind.PLANE))
    normal = surface.normal[rows]
    sign = np.where(normal[np.arange(len(rows)), np.abs(normal).argmax(axis=1)] < 0, -1.0, 1.0)
    n = normal * sign[:, None]
    at = np.einsum("ki,ki->k", surface.p[rows], n)
    low = np.where(sign > 0, at - surface.thick[rows], at)
    high = np.where(sign > 0, at, at + surface.thick[rows])
    keys = np.round(np.column_stack([n * 1e3, low / 0.05, high / 0.05]))
    _, first, of = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    planes = np.flatnonzero((graph.face_solid == solid) & (graph.face_kind == SurfaceKind.PLANE))
    hollow = _hollow_edges(graph, solid)
    for number, row in enumerate(first.tolist()):
        own = rows[of.ravel() == number]
        faces = set(surface.face[own].tolist())
        way, t = n[row], float(high[row] - low[row])
        height = graph.face_frame[planes, 0] @ way
        cos = graph.face_outward[planes] * (graph.face_frame[planes, 3] @ way)
        on = (cos < -ON_COS) & (np.abs(height - low[row]) <= 0.05)
        on |= (cos > ON_COS) & (np.abs(height - high[row]) <= 0.05)
        both = frozenset(faces | set(planes[on].tolist()))
        flat = np.isin(surface.face, list(both)) & (np.abs(surface.thick - t) <= SAME_THICKNESS * t + ON_MM)
        wide = float(np.sqrt(flat.sum() * surface.mm2 / 2.0))
        if t > flattest * wide and not DRAWN_SOLID_MM <= t <= wide:
            continue
        beside = np.array(sorted(_beside(graph, both)), dtype=np.int64)
        rim = np.isin(surface.face, beside)
        flat |= np.isin(surface.face, _mostly(surface, flat)) & (surface.thick > t)  # something stands behind it
        at_all = surface.p @ way
        rim &= (np.abs(surface.normal @ way) < 1.0 - ON_COS + 0.02) & (at_all > low[row] - ON_MM)
        rim &= at_all < high[row] + ON_MM
        kind = MemberKind.PLATE if t <= flattest * wide else MemberKind.BOX
        if kind is MemberKind.BOX and not (rim.any() and np.median(surface.thick[rim]) >= DRAWN_SOLID_MM):
            continue
        ends = np.array([np.quantile(trimmed.heights(face, way), (0.0, 1.0)) for face in beside.tolist()])
        is_rim = (np.abs(ends - [low[row], high[row]]) <= ON_RIM_MM).all(axis=1)
        is_rim &= ~np.isin(beside, list(_beside(graph, both, hollow)))  # what stands on it
        yield (
            Member(
                kind,
                both,
                way,
                np.array([t, wide]),
                t,
                wide,
                rims=frozenset(beside[is_rim & (t < DRAWN_SOLID_MM)].tolist()),
            ),
            flat | rim,
        )


def _mostly(surface: Surface, own: BoolArray) -> IntArray:
    """Return the faces of which some points, shape (n,), are at least `SOLID_SHARE` of all points, shape (m,)."""
    hit, count = (np.bincount(surface.face[rows], minlength=surface.face.max() + 1) for rows in (own, ...))
    return np.flatnonzero((hit > 0) & (hit >= SOLID_SHARE * count))


def _of_stretch(graph: BrepGraph, stretch: Prism, others: tuple[Prism, ...]) -> Member | None:
    """Return what a stretch is bought or cut as; None if it is a block, or a section that nobody buys."""
    contour, sides = stretch.contour, stretch.sides_mm
    bores = [other for other in others if _goes_through(other, stretch)]
    faces = frozenset().union(stretch.faces, *(bore.faces for bore in bores))
    roots = frozenset().union(stretch.roots, *(bore.roots for bore in bores))
    radius_mm = _radius(graph, contour)
    area = contour.area_mm2 if radius_mm is None else np.pi * radius_mm**2
    area -= sum(bore.contour.area_mm2 for bore in bores)
    kind: MemberKind | None
    rims: frozenset[int] = frozenset()
    if stretch.length_mm <= FLATTEST * np.sqrt(max(area, 0.0)):  # flame-cut, with whatever outline
        kind, thick, rims = MemberKind.PLATE, stretch.length_mm, stretch.faces
    elif radius_mm is not None:
        sides, thick = np.array([2.0 * radius_mm, 2.0 * radius_mm]), 2.0 * radius_mm
        kind = MemberKind.ROUND if stretch.length_mm > radius_mm and not bores else None
    elif contour.roots:
        kind, thick = _profile(graph, stretch, others)
    elif bores:
        kind, thick = _tube(stretch, bores, area, has_roots=bool(roots))
    else:
        kind, thick = _bar(stretch)
    return None if kind is None else Member(kind, faces, stretch.way, sides, thick, stretch.length_mm, roots, rims)


def _goes_through(bore: Prism, stretch: Prism) -> bool:
    """Tell whether a stretch is a bore inside most of another one."""
    both_mm = min(bore.high, stretch.high) - max(bore.low, stretch.low)
    is_along = bore.contour.is_bore and bore.way is stretch.way and both_mm > 0.5 * stretch.length_mm
    return is_along and _is_within(bore.contour.corners, stretch.contour.corners)


def _around_mm(contour: Contour) -> float:
    step = np.roll(contour.corners, -1, axis=0) - contour.corners
    return float(np.linalg.norm(step, axis=1).sum())


def _profile(graph: BrepGraph, stretch: Prism, others: tuple[Prism, ...]) -> tuple[MemberKind | None, float]:
    """Return how thick a section with roots is on average, and whether it is one that is rolled."""
    thick = 2.0 * stretch.contour.area_mm2 / max(_around_mm(stretch.contour), ON_MM)
    is_size = stretch.sides_mm[1] >= max(SMALLEST_PROFILE_MM, thick / THIN_SECTION)
    is_size = is_size and ON_MM < thick <= THICKEST_PROFILE_MM
    return MemberKind.PROFILE if is_size and _is_rolled(graph, stretch, others) else None, thick


def _tube(stretch: Prism, bores: list[Prism], area: float, *, has_roots: bool) -> tuple[MemberKind | None, float]:
    """Return the wall of a hollow section of an area, mm², and whether it is that of a tube: its bores are one."""
    thick = area / _around_mm(stretch.contour)
    middles = np.array([bore.contour.corners.mean(axis=0) for bore in bores])
    is_thin = 0.0 < thick <= THIN_SECTION * stretch.sides_mm[0] and bool((np.ptp(middles, axis=0) < thick).all())
    return MemberKind.TUBE if is_thin and not (has_roots and _is_box(stretch, thick)) else None, thick


def _bar(stretch: Prism) -> tuple[MemberKind | None, float]:
    """Return the thickness of a full section, and whether it is that of a bar: stout, or flat."""
    thick, wide = float(stretch.sides_mm[0]), stretch.sides_mm[1]
    is_stout = max(stretch.length_mm, wide) >= STOUT_MM[0] and thick <= STOUT_MM[1]
    return MemberKind.BAR if is_stout or thick <= FLATTEST * np.sqrt(stretch.length_mm * wide) else None, thick


def _is_box(stretch: Prism, thick: float) -> bool:
    """Tell whether a hollow section is so wide, short and thin that four plates were rather put together."""
    sides = stretch.sides_mm
    return bool(sides[1] >= BOX_MM and stretch.length_mm < sides[1] and thick <= BOX_WALL * sides[0])


def _tube_of_bore(surface: Surface, bore: Prism) -> Iterator[tuple[Member, BoolArray]]:
    """Yield the tube round a long bore with one wall, whatever covers its outside: nobody drills corners."""
    inside = np.isin(surface.face, list(bore.faces))  # past a mitre, too
    thin = inside & surface.flat
    walls = _commonest(surface.thick[thin], SAME_THICKNESS)
    if len(bore.contour.faces) < FEWEST_EDGES or bore.length_mm < SLENDER * bore.sides_mm[1] or not walls:
        return
    is_wall = [np.abs(surface.thick - wall) <= SAME_THICKNESS * wall for wall in walls]
    most = int(np.argmax([np.count_nonzero(thin & same) for same in is_wall]))
    wall, same = walls[most], is_wall[most]
    sides = bore.sides_mm + 2.0 * wall
    covered = len(np.unique(surface.face[thin])) - len(np.unique(surface.face[thin & same]))
    if wall > THIN_SECTION * sides[0] or covered > MOST_COVERED:
        return
    rows = np.flatnonzero(same & surface.flat & ~inside)
    u = square_to(bore.way)
    behind = surface.p[rows] - (surface.thick[rows, None] - 2.0 * SKIN_MM) * surface.normal[rows]
    behind = behind @ np.column_stack([u, np.cross(bore.way, u)])
    low, high = bore.contour.corners.min(axis=0) - ON_MM, bore.contour.corners.max(axis=0) + ON_MM
    outside = np.zeros_like(inside)
    outside[rows] = ((behind > low) & (behind < high)).all(axis=1)
    outer = _mostly(surface, outside)
    on_outer = np.isin(surface.face, outer)
    cover = inside & (surface.thick > wall * (1.0 - SAME_THICKNESS))
    cover |= on_outer & (outside | (surface.thick > wall))
    faces = bore.faces.union(outer.tolist())
    yield Member(MemberKind.TUBE, faces, bore.way, sides, wall, bore.length_mm, bore.roots), cover


def _radius(graph: BrepGraph, contour: Contour) -> float | None:
    """Return the radius of a section that is round, mm; None for another one."""
    faces = list(contour.faces)
    radii = graph.face_param[faces, 0]
    is_round = (graph.face_kind[faces] == SurfaceKind.CYLINDER).all() and np.ptp(radii) <= ON_MM
    return float(radii[0]) if is_round else None


def _is_within(inner: FloatArray, outer: FloatArray) -> bool:
    return bool((inner.min(axis=0) > outer.min(axis=0)).all() and (inner.max(axis=0) < outer.max(axis=0)).all())


def _is_rolled(graph: BrepGraph, stretch: Prism, others: tuple[Prism, ...]) -> bool:
    """Tell whether a section with roots is that of an angle, a channel, a Z or an I section, or has round roots.

    A T section with sharp roots does not count, nor one whose sides go on beyond its ends.
    """
    contour = stretch.contour
    pairs = np.array(sorted(contour.roots))
    web = np.flatnonzero(np.bincount(pairs.ravel()) > 1)  # that of a channel is beside both roots
    shared = len(pairs) == 1 or len(pairs) > MOST_WELDED or 2 * len(web) >= len(pairs)
    if contour.sharp == 0:  # a T section is rolled if its toes are round, too
        faces = list(contour.faces)
        toes = (graph.face_kind[faces] == SurfaceKind.CYLINDER) & (graph.face_outward[faces] > 0)
        return bool(shared or toes.any())
    if not (shared or (len(pairs) == 2 and _is_zed(graph, pairs)) or _looks_four_ways(graph, pairs)):
        return False
    return all(_ends_with(other, stretch, set(web.tolist())) for other in others if other is not stretch)


def _ends_with(other: Prism, stretch: Prism, web: set[int]) -> bool:
    """Tell whether sides that a stretch shares with another one, more than one, end where the stretch ends."""
    both = other.faces & stretch.faces
    if other.way is not stretch.way or len(both) < 2:
        return True
    outside = max(stretch.low - other.low, 0.0) + max(other.high - stretch.high, 0.0)
    return min(outside, other.length_mm) / (COPED if both <= web else ENDS_TOGETHER) <= stretch.length_mm


def _is_zed(graph: BrepGraph, pairs: IntArray) -> bool:
    """Tell whether two roots look opposite ways over a web: no two of their four faces are in one plane."""
    n = graph.face_frame[pairs.ravel(), 3] * graph.face_outward[pairs.ravel()][:, None]
    o = graph.face_frame[pairs.ravel(), 0]
    apart = np.abs(np.einsum("ijk,ik->ij", o[:, None] - o, n))
    in_one_plane = (np.abs(n @ n.T) > ON_COS) & (apart < 0.5)
    return bool(in_one_plane.sum() == len(n))


def _looks_four_ways(graph: BrepGraph, pairs: IntArray) -> bool:
    """Tell whether four roots open in four directions, as those of an I section do, whatever steps its web has."""
    open_to = (graph.face_frame[pairs, 3] * graph.face_outward[pairs][..., None]).sum(axis=1)
    open_to /= np.linalg.norm(open_to, axis=1, keepdims=True)
    return len(pairs) == len(FOUR_WAYS) and bool(
        np.allclose(np.sort(open_to @ open_to[0]), FOUR_WAYS, atol=FOUR_WAYS_COS)
    )


def _on_stretch(surface: Surface, stretch: Prism, member: Member) -> BoolArray:
    """Tell which points a stretch explains: those on its sides, and on its ends."""
    height = surface.p @ stretch.way
    is_rolled = member.kind is MemberKind.PROFILE and stretch.contour.sharp == 0
    past = ENDS_TOGETHER * stretch.length_mm if is_rolled else ON_MM  # something may stand beside its end
    along = (height >= stretch.low - past) & (height <= stretch.high + past)
    sides = np.isin(surface.face, list(member.faces)) & along
    ends = np.abs(surface.normal @ stretch.way) > ON_COS
    ends &= (np.abs(height - stretch.low) <= 0.05) | (np.abs(height - stretch.high) <= 0.05)
    ends &= _is_inside(surface, stretch)
    if member.kind is MemberKind.PLATE:  # what is hollow, or goes on, is no plate
        solid = ends & (np.abs(surface.thick - member.thickness_mm) <= SAME_THICKNESS * member.thickness_mm)
        return sides | solid if solid.sum() >= SOLID_SHARE * ends.sum() else np.zeros_like(sides)
    return sides | ends


def _on_details(graph: BrepGraph, surface: Surface, member: Member, convex: BoolArray, cover: BoolArray) -> BoolArray:
    """Return what a member explains, with its holes: hollow cylinders that only it and its ends touch.

    With its broken edges and mitred ends as well if that is the whole solid: faces beside it without a hollow corner.
    `convex`: shape (F,). As `_convex_faces` returns them.
    """
    cos = np.abs(graph.face_frame[:, 3] @ member.axis)
    is_plane, is_round = (graph.face_kind == kind for kind in (SurfaceKind.PLANE, SurfaceKind.CYLINDER))
    hollow = is_round & (graph.face_outward < 0)
    known = (is_plane & (cos > ON_COS)) | hollow
    known[list(member.faces)] = True
    cover = cover | (hollow & _are_only_beside(graph, known))[surface.face]
    broken = convex & ~np.where(is_plane, cos < 1.0 - ON_COS, is_round & (cos > ON_COS))
    whole = cover | (broken & _are_only_beside(graph, known | broken))[surface.face]
    return np.asarray(whole if whole.mean() >= WHOLE else cover, dtype=bool)


def _are_only_beside(graph: BrepGraph, known: BoolArray) -> BoolArray:
    """Tell which faces have only some faces beside them, shape (F,)."""
    found = np.ones(graph.face_count, dtype=bool)
    own, other = np.concatenate([graph.edge_faces, graph.edge_faces[:, ::-1]]).T
    found[own[(own >= 0) & (other >= 0) & (own != other) & ~known[other]]] = False
    return found


def _convex_faces(graph: BrepGraph, solid: int) -> BoolArray:
    """Tell which faces belong to a solid that has no hollow corner beside them, shape (F,)."""
    convex = np.asarray(graph.face_solid == solid, dtype=bool)
    convex[graph.edge_faces[_hollow_edges(graph, solid)]] = False
    return convex


def _hollow_edges(graph: BrepGraph, solid: int) -> IntArray:
    edges = inner_edges(graph, np.arange(len(graph.solid_names)) == solid)
    return np.asarray(edges[are_concave(graph, edges)])


def _is_inside(surface: Surface, stretch: Prism) -> BoolArray:
    """Tell which points lie inside the section of a stretch, seen along it (even-odd rule)."""
    u = square_to(stretch.way)
    x, y = surface.p @ u, surface.p @ np.cross(stretch.way, u)
    q0 = stretch.contour.corners
    q1 = np.roll(q0, -1, axis=0)
    inside = np.zeros(len(x), dtype=bool)
    for (x0, y0), (x1, y1) in zip(q0.tolist(), q1.tolist(), strict=True):
        if y0 != y1:
            inside ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) / (y1 - y0) * (x1 - x0))
    return inside


def _rounds(
    graph: BrepGraph, trimmed: TrimmedFaces, solid: int, surface: Surface
) -> Iterator[tuple[Member, BoolArray]]:
    """Yield round tubes, and round bars that are longer than they are thick."""
    tubes = find_tubes(graph, trimmed, solid)
    for axis in np.unique(tubes.axis).tolist():
        own = tubes.axis == axis
        for wall in np.unique(np.round(tubes.wall_mm[own], 2)).tolist():
            faces = frozenset(tubes.face[own & (np.abs(tubes.wall_mm - wall) <= 0.01)].tolist())
            yield _round(graph, surface, faces, float(wall))
    cylinders = np.flatnonzero((graph.face_solid == solid) & (graph.face_kind == SurfaceKind.CYLINDER))
    for face in cylinders[graph.face_outward[cylinders] > 0].tolist():
        radius = float(graph.face_param[face, 0])
        at = trimmed.heights(face, graph.face_frame[face, 3])
        on = (surface.face == face) & (np.abs(surface.thick - 2.0 * radius) <= SAME_THICKNESS * radius)
        if len(at) and np.ptp(at) > radius and on.any():
            yield _round(graph, surface, frozenset([face]), 2.0 * radius)


def _round(graph: BrepGraph, surface: Surface, faces: frozenset[int], thick: float) -> tuple[Member, BoolArray]:
    first = min(faces)
    z, radius = graph.face_frame[first, 3], float(graph.face_param[list(faces), 0].max())
    off = off_axis(surface.p, graph.face_frame[first, 0], z)
    on = np.isin(surface.face, list(faces))
    ends = np.isin(surface.face, list(_beside(graph, faces))) & (np.abs(surface.normal @ z) > ON_COS)
    on |= ends & (off <= radius + ON_MM)
    member = Member(MemberKind.ROUND, faces, z, np.array([2.0 * radius, 2.0 * radius]), thick, 0.0)
    return member, on


def _sheets(graph: BrepGraph, smooth: IntArray, surface: Surface) -> Iterator[tuple[Member, BoolArray]]:
    """Yield one side each of formed sheets: faces that run smoothly into each other, one thickness behind them.

    And of bevelled ones, whose thickness changes by up to `BEVELLED`.
    """
    curved = graph.face_kind[surface.face] != SurfaceKind.PLANE
    for opposite, change, flattest in ((OPPOSITE_COS, SAME_THICKNESS, FLATTEST), (BEVEL_COS, BEVELLED, SLENDER_PLATE)):
        facing, bevelled = surface.facing < opposite, change == BEVELLED
        own = facing & np.where(bevelled, surface.thick > MOULDED_MM, curved)
        for t in _commonest(surface.thick[own], change):
            same = facing & (np.abs(surface.thick - t) <= change * t)
            for faces in _linked(graph, smooth, set(surface.face[same].tolist())):
                on, ruled = same & np.isin(surface.face, list(faces)), _is_ruled(graph, faces)
                wide, thick = float(np.sqrt(on.sum() * surface.mm2)), np.quantile(surface.thick[on], (0.1, 0.9))
                changes = ruled and np.ptp(thick) > SAME_THICKNESS * t
                if (on & own).any() and (changes or not bevelled) and t <= flattest * wide:
                    rims = np.isin(surface.face, list(_beside(graph, faces))) & ~surface.flat
                    section = np.array([t, wide])
                    yield Member(MemberKind.SHEET, faces, np.zeros(3), section, t, wide * ruled), on | rims


def _is_ruled(graph: BrepGraph, faces: frozenset[int]) -> bool:
    """Tell whether faces are planes and cylinders along one direction, as those of a plate that was rolled or bent."""
    own = np.array(sorted(faces))
    kinds, axes = graph.face_kind[own], graph.face_frame[own, 3]
    way = axes[kinds == SurfaceKind.CYLINDER]
    if not np.isin(kinds, (SurfaceKind.PLANE, SurfaceKind.CYLINDER)).all():
        return False
    cos = np.abs(axes @ way[0]) if len(way) else np.zeros(1)
    return bool((np.where(kinds == SurfaceKind.PLANE, 1.0 - cos, cos) > ON_COS).all())


def _linked(graph: BrepGraph, smooth: IntArray, faces: set[int]) -> Iterator[frozenset[int]]:
    """Yield groups of faces that run smoothly into each other."""
    pairs = graph.edge_faces[smooth]
    pairs = pairs[np.isin(pairs, list(faces)).all(axis=1)]
    group = linked_groups(graph.face_count, *pairs.T)
    for number in dict.fromkeys(group[sorted(faces)].tolist()):
        yield frozenset(faces.intersection(np.flatnonzero(group == number).tolist()))


def _smooth_edges(graph: BrepGraph, solid: int) -> IntArray:
    """Return the edges of a solid along which its faces run smoothly into each other."""
    edges = inner_edges(graph, np.arange(len(graph.solid_names)) == solid)
    p = evaluate_edges(graph, edges, graph.edge_range[edges].mean(axis=1))[0]
    left, right = (project_to_faces(graph, graph.edge_faces[edges, k], p).normal for k in (0, 1))
    return np.asarray(edges[np.einsum("ki,ki->k", left, right) > SMOOTH_COS])


def _commonest(thick: FloatArray, same: float) -> list[float]:
    """Return the different thicknesses among many, those that agree within a share once."""
    found: dict[int, list[float]] = defaultdict(list)
    for t in thick[np.isfinite(thick) & (thick > 0)].tolist():
        found[round(np.log(t) / same)].append(t)
    return [float(np.median(own)) for own in found.values() if len(own) > 2]
