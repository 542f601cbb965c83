"""What a prismatic stretch of a solid is bought or cut as: plate, bar, tube or rolled profile."""

import numpy as np

from wpcal.brep.concavity import are_concave, inner_edges
from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.core.arrays import IntArray
from wpcal.seam.find.built_up import FLATTEST
from wpcal.seam.member.member import ENDS_TOGETHER, ON_COS, ON_MM, Member, MemberKind
from wpcal.seam.member.prisms import Contour, Prism

THIN_SECTION = 0.3  #: A rolled profile is thinner than this share of its height.
NARROWEST = 2.0  #: What is on average thicker than this, in its widths, was not cut from plate: bars on edge.
COPED = 0.6  #: The web alone goes on by less than this share of the length: the flanges are coped.
MOST_WELDED = 4  #: A section with more roots was extruded: nobody welds this many seams along one member.
FOUR_WAYS, FOUR_WAYS_COS = (-1.0, 0.0, 0.0, 1.0), 0.2
"""Cosines, ascending, between one of four roots of an I section and all of them; its flanges may be inclined."""
SMALLEST_PROFILE_MM, THICKEST_PROFILE_MM = 10.0, 40.0
"""The smallest angle that is sold is so high, and the heaviest I section has flanges of so much."""
BOX_MM, BOX_WALL = 150.0, 0.1
"""Hollow sections with sharp corners that are this wide, shorter than wide, and whose wall is thinner than this share
of the shorter side, are boxes of plates."""
STOUT_MM = (20.0, 100.0)  #: A stout piece of bar is a member if it is this long, at most this thick, and whole.


def stock_of(graph: BrepGraph, stretch: Prism, others: tuple[Prism, ...]) -> Member | None:
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
    around = _around_mm(contour) + sum(_around_mm(bore.contour) for bore in bores)
    if stretch.length_mm <= min(FLATTEST * np.sqrt(max(area, 0.0)), NARROWEST * 2.0 * area / around):  # flame-cut
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
    if kind is None:
        return None
    low, high = roots_of(stretch, others)
    return Member(kind, faces, stretch.way, sides, thick, stretch.length_mm, roots, rims, high - low)


def roots_of(stretch: Prism, others: tuple[Prism, ...]) -> tuple[float, float]:
    """Return from where to where one of the roots of a section goes on, also where something else stands on it, mm."""
    own = [stretch, *(one for one in others if one.way is stretch.way and one.roots & stretch.roots)]
    return min(one.low for one in own), max(one.high for one in own)


def _goes_through(bore: Prism, stretch: Prism) -> bool:
    """Tell whether a stretch is a bore inside most of another one."""
    both_mm = min(bore.high, stretch.high) - max(bore.low, stretch.low)
    is_along = bore.contour.is_bore and bore.way is stretch.way and both_mm > 0.5 * stretch.length_mm
    q, outer = bore.contour.corners, stretch.contour.corners
    return is_along and bool(((q.min(axis=0) > outer.min(axis=0)) & (q.max(axis=0) < outer.max(axis=0))).all())


def _around_mm(contour: Contour) -> float:
    step = np.roll(contour.corners, -1, axis=0) - contour.corners
    return float(np.linalg.norm(step, axis=1).sum())


def _profile(graph: BrepGraph, stretch: Prism, others: tuple[Prism, ...]) -> tuple[MemberKind | None, float]:
    """Return how thick a section with roots is on average, and whether it is one that is rolled."""
    thick = 2.0 * stretch.contour.area_mm2 / max(_around_mm(stretch.contour), ON_MM)
    is_size = stretch.sides_mm[1] >= max(SMALLEST_PROFILE_MM, thick / THIN_SECTION)
    is_size = is_size and ON_MM < thick <= THICKEST_PROFILE_MM
    is_whole = is_size and not any(_is_crossed(graph, other, stretch, others) for other in others)
    return MemberKind.PROFILE if is_whole and _is_rolled(graph, stretch, others) else None, thick


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


def _radius(graph: BrepGraph, contour: Contour) -> float | None:
    """Return the radius of a section that is round, mm; None for another one."""
    faces = list(contour.faces)
    radii = graph.face_param[faces, 0]
    is_round = (graph.face_kind[faces] == SurfaceKind.CYLINDER).all() and np.ptp(radii) <= ON_MM
    return float(radii[0]) if is_round else None


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
    return _end_with(graph, [one for one in others if one is not stretch], stretch, set(web.tolist()))


def _is_crossed(graph: BrepGraph, other: Prism, stretch: Prism, others: tuple[Prism, ...]) -> bool:
    """Tell whether a part of a section goes on alone, farther than the section, as one that is bought."""
    is_part = other.way is stretch.way and other.contour.area_mm2 < stretch.contour.area_mm2
    if (
        not is_part
        or other.contour.is_bore
        or other.pieces_mm <= stretch.pieces_mm
        or len(other.faces & stretch.faces) < 2
    ):
        return False
    return not other.contour.roots or _is_rolled(graph, other, others)


def _end_with(graph: BrepGraph, others: list[Prism], stretch: Prism, web: set[int]) -> bool:
    """Tell whether the sides of a stretch end with it; those of a mitred one go on by its height at either end."""
    rest = [other for other in others if not _ends_with(other, stretch, web)]
    most_mm = _mitred_ends(graph, stretch) * stretch.sides_mm[1] + ON_MM if rest else 0.0
    return all(_outside_mm(other, stretch) <= most_mm for other in rest)


def _ends_with(other: Prism, stretch: Prism, web: set[int]) -> bool:
    """Tell whether sides that a stretch shares with another one, more than one, end where the stretch ends.

    They may go on with all their roots: then something stands on the member there.
    """
    both = other.faces & stretch.faces
    if other.way is not stretch.way or len(both) < 2 or stretch.roots <= other.roots:
        return True
    outside = min(_outside_mm(other, stretch), other.length_mm)
    return outside / (COPED if both <= web else ENDS_TOGETHER) <= stretch.length_mm


def _outside_mm(other: Prism, stretch: Prism) -> float:
    """Return how far another stretch along the same direction goes on beyond both ends of a stretch."""
    return max(stretch.low - other.low, 0.0) + max(other.high - stretch.high, 0.0)


def _mitred_ends(graph: BrepGraph, stretch: Prism) -> int:
    """Return at how many ends all roots of a stretch run into other inner corners, as those of a mitred frame do."""
    pairs = np.sort(graph.edge_faces, axis=1)
    root = np.isin(pairs[:, 0] * graph.face_count + pairs[:, 1], [a * graph.face_count + b for a, b in stretch.roots])
    edges = np.flatnonzero(root & (graph.edge_faces >= 0).all(axis=1))
    if len(edges) == 0:
        return 0
    inner = inner_edges(graph, np.arange(len(graph.solid_names)) == graph.edge_solid[edges[0]])
    met = np.unique(graph.edge_vertices[np.setdiff1d(inner[are_concave(graph, inner)], edges)])
    ends = graph.edge_vertices[edges]
    height = graph.vertex_p[ends] @ stretch.way
    middle = (stretch.low + stretch.high) / 2
    return sum(bool(np.isin(ends[far(height, middle)], met).all()) for far in (np.less, np.greater))


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
