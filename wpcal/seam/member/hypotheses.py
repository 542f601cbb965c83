"""Every plate, bar, tube, rolled profile and formed sheet that can be read from the faces of a solid."""

from collections.abc import Iterator

import numpy as np

from wpcal.brep.concavity import are_concave, corner_turns, inner_edges
from wpcal.brep.curves import edge_lengths
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.surfaces import off_axis, square_to
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.linked import linked_groups
from wpcal.seam.find.built_up import FLATTEST, OPPOSITE_COS, SAME_THICKNESS, SKIN_MM, Surface, sampled_surface
from wpcal.seam.find.formed import MOULDED_MM
from wpcal.seam.find.tubes import find_tubes
from wpcal.seam.member.member import (
    DRAWN_SOLID_MM,
    ENDS_TOGETHER,
    ON_COS,
    ON_MM,
    SLENDER_PLATE,
    THICKEST_BAR_MM,
    Member,
    MemberKind,
)
from wpcal.seam.member.prisms import FEWEST_EDGES, Prism, find_prisms
from wpcal.seam.member.sections import NARROWEST, THIN_SECTION, roots_of, stock_of

ON_RIM_MM = 0.5  #: The outline of a plate goes from side to side, but for broken edges.
SOLID_SHARE = 0.5  #: At least this share of the two faces of a plate has its thickness behind it.
MOST_COVERED = 1  #: Sides of a tube of which nothing shows how thick its wall is.
SLENDER = 2.0  #: A profile with sharp roots is this many times longer than it is high, or the whole solid.
BEVEL_COS, BEVELLED = -0.985, 0.25
"""The sides of a bevelled plate are within 10 degrees of opposite, and its thickness changes by this much."""
OVERHANGS = 0.8  #: Sides of a tube do not go on beyond each other for this much of its length.
LUG = 0.5  #: A lug is thinner than this share of its width.
LEAST_OF_SIDE = 0.05  #: Behind this much of the side of a lug there is its thickness.
WHOLE = 0.97  #: A member that explains this much of the surface is the whole solid.
WIDEST_RIM = 1.5  #: A round outline of a formed sheet is narrower than this, in thicknesses: it may be cut aslant.
SMOOTH_COS = 0.99  #: Faces run smoothly into each other if their normals are within 8 degrees.


def find_hypotheses(
    graph: BrepGraph, trimmed: TrimmedFaces, solid: int, surface: Surface
) -> Iterator[tuple[Member, BoolArray]]:
    """Yield every hypothesis with the points of the surface that it explains."""
    yield from _plates(graph, trimmed, solid, surface)
    stretches, convex = find_prisms(graph, trimmed, solid), _convex_faces(graph, solid)
    for stretch in stretches:
        if not stretch.contour.is_bore:
            member = stock_of(graph, stretch, stretches)
            if member is not None:
                cover = _on_details(
                    graph, surface, member, convex, _on_stretch(graph, surface, stretch, stretches, member)
                )
                is_stub = stretch.contour.sharp > 0 and member.length_mm < SLENDER * member.section[1]
                is_stub |= len(member.faces) > len(stretch.faces)  # a hollow extrusion
                is_stub &= member.kind is MemberKind.PROFILE
                if not (is_stub or member.is_stout) or cover.mean() >= WHOLE:
                    yield member, cover
        else:
            yield from _tube_of_bore(graph, surface, stretch)
    yield from _rounds(graph, trimmed, solid, surface)
    yield from _sheets(graph, _smooth_edges(graph, solid), surface)


def _beside(graph: BrepGraph, faces: frozenset[int] | set[int], edges: IntArray | None = None) -> set[int]:
    """Return the faces that share an edge with some faces, or one of some edges, without these."""
    sides = graph.edge_faces if edges is None else graph.edge_faces[edges]
    own = np.isin(sides, list(faces))
    return set(sides[own.any(axis=1)].ravel().tolist()) - set(faces) - {-1}


def lugs_of(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> list[frozenset[int]]:
    """Return the sides and rims of each thick plate: not slender, but cut from plate where others are.

    A face of which less than `LEAST_OF_SIDE` has the thickness behind it is no side: a pad stands behind it there.
    """
    surface = sampled_surface(graph, trimmed, solid)
    found = []
    for one, cover in _plates(graph, trimmed, solid, surface, flattest=LUG):
        faces = one.faces.intersection(np.flatnonzero(_share_of_faces(surface, cover) >= LEAST_OF_SIDE).tolist())
        sides = np.array(sorted(faces), dtype=np.int64)
        cos = graph.face_outward[sides] * (graph.face_frame[sides, 3] @ one.axis)  # of a wedge, one side is there
        is_thick = SLENDER_PLATE * one.length_mm < one.thickness_mm < THICKEST_BAR_MM
        if is_thick and (cos < 0.0).any() and (cos > 0.0).any():
            found.append(faces | one.rims)
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
    hollow, narrow = _hollow_edges(graph, solid), _widths_mm(graph, surface)
    for number, row in enumerate(first.tolist()):
        own = rows[of.ravel() == number]
        faces = set(surface.face[own].tolist())
        way, t = n[row], float(high[row] - low[row])
        height = graph.face_frame[planes, 0] @ way
        cos = graph.face_outward[planes] * (graph.face_frame[planes, 3] @ way)
        below = (cos < -ON_COS) & (np.abs(height - low[row]) <= 0.05)
        above = (cos > ON_COS) & (np.abs(height - high[row]) <= 0.05)
        both = frozenset(faces | set(planes[below | above].tolist()))
        flat = np.isin(surface.face, list(both)) & (np.abs(surface.thick - t) <= SAME_THICKNESS * t + ON_MM)
        wide = float(np.sqrt(flat.sum() * surface.mm2 / 2.0))
        is_box, has_sides = t > flattest * wide, below.any() & above.any()
        are_bars = flattest < LUG and (NARROWEST * narrow[surface.face[flat]] < t).mean() > SOLID_SHARE  # on edge
        if not (DRAWN_SOLID_MM <= t <= wide and has_sides) if is_box else are_bars:
            continue
        beside = np.array(sorted(_beside(graph, both)), dtype=np.int64)
        rim = np.isin(surface.face, beside)
        flat |= np.isin(surface.face, _mostly(surface, flat)) & (surface.thick > t)  # something stands behind it
        at_all = surface.p @ way
        rim &= (np.abs(surface.normal @ way) < 1.0 - ON_COS + 0.02) & (at_all > low[row] - ON_MM)
        rim &= at_all < high[row] + ON_MM
        kind = MemberKind.BOX if is_box else MemberKind.PLATE
        if is_box and not (rim.any() and np.median(surface.thick[rim]) >= min(t, THICKEST_BAR_MM)):
            continue
        ends = np.array([np.quantile(trimmed.heights(face, way), (0.0, 1.0)) for face in beside.tolist()])
        is_rim = (np.abs(ends - [low[row], high[row]]) <= ON_RIM_MM).all(axis=1)
        is_rim &= ~np.isin(beside, list(_beside(graph, both, hollow)))  # what stands on it
        rims = frozenset(beside[is_rim & (t < THICKEST_BAR_MM)].tolist())
        yield Member(kind, both, way, np.array([t, wide]), t, wide, rims=rims), flat | rim


def _mostly(surface: Surface, own: BoolArray) -> IntArray:
    """Return the faces of which some points, shape (n,), are at least `SOLID_SHARE` of all points, shape (m,)."""
    return np.flatnonzero(_share_of_faces(surface, own) >= SOLID_SHARE)


def _share_of_faces(surface: Surface, own: BoolArray) -> FloatArray:
    """Return which share of the points on each face some are, shape (F,); 0 if it has none."""
    hit, count = (np.bincount(surface.face[rows], minlength=surface.face.max() + 1) for rows in (own, ...))
    return np.asarray(hit / np.maximum(count, 1))


def _tube_of_bore(graph: BrepGraph, surface: Surface, bore: Prism) -> Iterator[tuple[Member, BoolArray]]:
    """Yield the tube round a long bore with one wall, whatever covers its outside: nobody drills corners.

    Its corners are welded where two of its sides go on beyond the others for `OVERHANGS` of its length.
    """
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
    plane = np.column_stack([u, np.cross(bore.way, u)])
    behind = (surface.p[rows] - (surface.thick[rows, None] - 2.0 * SKIN_MM) * surface.normal[rows]) @ plane
    low, high = bore.contour.corners.min(axis=0) - ON_MM, bore.contour.corners.max(axis=0) + ON_MM
    outside = np.zeros_like(inside)
    outside[rows] = ((behind > low) & (behind < high)).all(axis=1)
    off = surface.p @ plane  # a plate that is flush with a side goes on beyond the section
    within = ((off > low - wall) & (off < high + wall)).all(axis=1) & np.isin(surface.face, surface.face[outside])
    outer = _mostly(surface, within)
    edges = np.flatnonzero((graph.edge_kind == CurveKind.LINE) & np.isin(graph.edge_faces, outer).any(axis=1))
    start, way = graph.edge_frame[edges, 0] @ plane, graph.edge_frame[edges, 1]
    is_beyond = ((start < low - wall) | (start > high + wall)).any(axis=1) & (np.abs(way @ bore.way) > ON_COS)
    is_girder = (is_beyond & (edge_lengths(graph)[edges] > OVERHANGS * bore.length_mm)).sum() > 1
    on_outer = np.isin(surface.face, outer)
    cover = inside & (surface.thick > wall * (1.0 - SAME_THICKNESS))
    cover |= on_outer & (outside | (surface.thick > wall))
    faces = bore.faces.union(outer.tolist())
    roots: frozenset[tuple[int, int]] = frozenset() if is_girder else bore.roots
    yield Member(MemberKind.TUBE, faces, bore.way, sides, wall, bore.length_mm, roots), cover


def _on_stretch(
    graph: BrepGraph, surface: Surface, stretch: Prism, stretches: tuple[Prism, ...], member: Member
) -> BoolArray:
    """Tell which points a stretch explains: those on its sides and ends; of a long profile, also where it was cut."""
    height = surface.p @ stretch.way
    is_long = member.kind is MemberKind.PROFILE and stretch.length_mm >= SLENDER * member.section[1]
    low, high = _coped(stretch, stretches) if is_long else (stretch.low, stretch.high)
    if is_long:
        first, last = roots_of(stretch, stretches)
        low, high = min(low, first), max(high, last)
    is_rolled = member.kind is MemberKind.PROFILE and stretch.contour.sharp == 0
    past = ENDS_TOGETHER * stretch.length_mm if is_rolled else ON_MM  # something may stand beside its end
    sides = np.isin(surface.face, list(member.faces)) & (height >= low - past) & (height <= high + past)
    if is_long and len(member.faces) == len(stretch.faces):  # no bore
        cuts = np.isin(surface.face, list(_beside(graph, member.faces))) & _is_inside(surface, stretch)
        return sides | (cuts & (height >= low) & (height <= high))
    ends = np.abs(surface.normal @ stretch.way) > ON_COS
    ends &= (np.abs(height - stretch.low) <= 0.05) | (np.abs(height - stretch.high) <= 0.05)
    ends &= _is_inside(surface, stretch)
    if member.kind is MemberKind.PLATE:  # what is hollow, or goes on, is no plate
        solid = ends & (np.abs(surface.thick - member.thickness_mm) <= SAME_THICKNESS * member.thickness_mm)
        return sides | solid if solid.sum() >= SOLID_SHARE * ends.sum() else np.zeros_like(sides)
    return sides | ends


def _coped(stretch: Prism, stretches: tuple[Prism, ...]) -> tuple[float, float]:
    """Return from where to where a profile goes, coped ends included: there, a part of its section goes on."""
    low, high, round_mm = stretch.low, stretch.high, stretch.sides_mm[0] / 2.0  # the corner of a cope may be round
    box = stretch.contour.corners.min(axis=0) - ON_MM, stretch.contour.corners.max(axis=0) + ON_MM
    for other in stretches:
        q = other.contour.corners
        if (
            other.way is stretch.way
            and len(other.faces & stretch.faces) > 1
            and (q > box[0]).all()
            and (q < box[1]).all()
        ):
            low = min(low, other.low) if -ON_MM <= stretch.low - other.high <= round_mm else low
            high = max(high, other.high) if -ON_MM <= other.low - stretch.high <= round_mm else high
    return low, high


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
    curved, wide_mm = graph.face_kind[surface.face] != SurfaceKind.PLANE, _widths_mm(graph, surface)
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
                    rims = np.isin(surface.face, list(_beside(graph, faces)))
                    rims &= ~surface.flat | (curved & (wide_mm <= WIDEST_RIM * t)[surface.face])
                    section = np.array([t, wide])
                    yield Member(MemberKind.SHEET, faces, np.zeros(3), section, t, wide * ruled), on | rims


def _widths_mm(graph: BrepGraph, surface: Surface) -> FloatArray:
    """Return how wide each face is on average, shape (F,): its area over half of its outline."""
    mm = np.where(graph.edge_faces < 0, 0.0, edge_lengths(graph)[:, None])
    around = np.bincount(np.maximum(graph.edge_faces, 0).ravel(), mm.ravel(), graph.face_count)
    area = np.bincount(surface.face, minlength=graph.face_count) * surface.mm2
    return np.asarray(2.0 * area / np.maximum(around, ON_MM))


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
    return np.asarray(edges[corner_turns(graph, edges)[1] > SMOOTH_COS])


def _commonest(thick: FloatArray, same: float) -> list[float]:
    """Return the different thicknesses among many, those that agree within a share once."""
    own = thick[np.isfinite(thick) & (thick > 0)]
    _, first, of, count = np.unique(
        np.round(np.log(own) / same), return_index=True, return_inverse=True, return_counts=True
    )
    return [float(np.median(own[of == k])) for k in np.argsort(first).tolist() if count[k] > 2]
