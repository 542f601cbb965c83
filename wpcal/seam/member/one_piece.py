"""Whether a solid is a member, was built up of members, or was cast, moulded, printed or milled as one piece.

This is asked in one way of a solid with inner corners and of one that touches others. A solid that is round about one
axis, or that one member explains, is that member. One that several members explain was built up. All others were made
as one piece: they are rather bolted or clamped. A clevis that was milled from a block is welded now and then.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from wpcal.brep.boxes import BoxTree
from wpcal.brep.curves import edge_lengths
from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.surfaces import off_axis
from wpcal.brep.trim import TrimmedFaces, once_per_solid
from wpcal.core.arrays import BoolArray, IntArray
from wpcal.core.issue import Issue
from wpcal.core.wording import counted
from wpcal.seam.find.built_up import (
    LEAST_BUILT_UP,
    are_round,
    built_up_share,
    filled_share,
    is_turned,
    sample_surfaces,
    sampled_surface,
)
from wpcal.seam.find.concave import find_concave_edges
from wpcal.seam.find.covered import count_solids
from wpcal.seam.find.formed import MOULDED_MM
from wpcal.seam.find.strips import drawn_beads, find_strips
from wpcal.seam.limits import LEAST_SEAM_MM
from wpcal.seam.member.fasteners import screw_faces
from wpcal.seam.member.heavy_bars import THIN_MM
from wpcal.seam.member.hypotheses import lugs_of
from wpcal.seam.member.member import ON_COS, ON_MM, Decomposition, MemberKind
from wpcal.seam.member.members import members_of

LEAST_EXPLAINED = 0.94  #: Members explain this much of the surface of a weldment, if thicknesses alone do not tell.
LEAST_BETWEEN, LEAST_PARTLY_MM = 0.25, 350.0
"""A solid that members explain in part was welded if this much of its inner corners is between slender members, and its
diagonal is longer: pumps and gear cases that nobody welds have up to 332 mm."""
LEAST_TOUCHED = 0.75
"""Of a solid of several members that touches others, at least this much of the surface is on plates, bars and tubes;
what is drawn apart is rather one member than several, and holders and forks that were milled have up to 0.72."""
COMPACT_MM, UNEXPLAINED, LOOSE = 115.0, 1300.0, 16.0
FULL, STOUTEST = 0.7, 11.0
"""A solid is one piece if its diagonal is below ``COMPACT_MM √(1 + UNEXPLAINED u v + LOOSE w + f)``: u is the share of
the surface that no member explains, v that on no plate, bar or tube of few thicknesses, w the share of inner corners
neither between two members nor inside one. ``f = (FULL + STOUTEST s) (V / (H - V))²``, at most `LOOSE`: V and H are the
volumes of the solid and its hull, s the share of stout members. Fitted to 220 bodies of weldments and 160 others."""
STOUT, MOST_LOOSE = 0.85, 0.8
"""A member is stout from this `stoutness` on; how full the hull is does not count if more of the corners are neither
between two members nor inside one: a bar fills its hull by itself."""
MANY_WALLS = 8  #: This many thin walls of one thickness, round corners among them, were moulded.
LEAST_STRAIGHT = 0.3  #: A body of which straight members explain less is a pressed sheet, if it is free-form.
DETAIL = 0.3  #: A solid is small if its box has less than this share of the diagonal of the part.
DRAWN_APART, MOST_ASKED = 4, 40
"""This many larger bodies that are one member each say that members were drawn apart; how many bodies are asked."""
MOST_TOLD = 3  #: Most solids that are told of.
VESSEL_WALL = 0.03  #: A vessel that was drawn or blown has a wall thinner than this share of its width.
MOST_ROOTS, SQUARE_COS = 8, 0.5  #: Sections with more square inner corners are extruded, with slots for clamps.
SAME_LENGTH_MM = 0.01  #: Edges whose lengths agree within this are equal; solids of equal edges and faces are one.


@dataclass(slots=True, eq=False)
class OnePieces:
    """Which solids were made as one piece, found when somebody asks; equal solids are looked at once."""

    #: `graph`, `trimmed`: The part.
    graph: BrepGraph
    trimmed: TrimmedFaces
    _equal: dict[bytes, str | None] = field(default_factory=dict)

    def look_at(self, solids: Iterable[int]) -> None:
        """Feel the surfaces of all solids together that `why` will ask for."""
        new = {signature(self.graph, self.trimmed, solid): solid for solid in sorted(solids, reverse=True)}
        asked = [solid for key, solid in new.items() if key not in self._equal]
        sample_surfaces(self.graph, self.trimmed, asked)

    def why(self, solid: int) -> str | None:
        """Tell why a solid looks as if made as one piece; None if it is a member, or built up of members."""
        key = signature(self.graph, self.trimmed, solid)
        if key not in self._equal:
            self._equal[key] = self._look(solid)
        return self._equal[key]

    def _look(self, solid: int) -> str | None:
        if _is_vessel(self.graph, self.trimmed, solid):
            return "it is a thin cup, deeper than wide: it looks drawn, blown or moulded"
        found = members_of(self.graph, self.trimmed, solid)
        if found.is_one or self._is_turned(solid):
            return _why_extruded(self.graph, self.trimmed, solid)
        why = why_one_piece(self.graph, self.trimmed, solid)
        if why is None and (share := built_up_share(self.graph, self.trimmed, solid)) < LEAST_TOUCHED:
            words = "of its surface is on plates, bars or tubes: it looks cast, moulded or milled"
            return f"several members explain it, but only {share:.0%} {words}"
        return why or _why_ribbed(self.graph, self.trimmed, solid)

    def _is_turned(self, solid: int) -> bool:
        """Tell whether nearly the whole surface is round about one axis, holes and keyways left out."""
        graph = self.graph
        hollow = np.isin(graph.face_kind, (SurfaceKind.CYLINDER, SurfaceKind.CONE)) & (graph.face_outward < 0)
        faces = np.flatnonzero(graph.face_solid == solid)
        round_ = are_round(graph, faces)
        points = sampled_surface(graph, self.trimmed, solid).face
        fits = np.isin(points, faces[round_ | hollow[faces]])
        return bool(round_.any() and len(fits) and fits.mean() >= LEAST_BUILT_UP)


@once_per_solid
def signature(graph: BrepGraph, _: TrimmedFaces, solid: int) -> bytes:
    """Return what equal solids have in common: the kinds of their faces, and the lengths of their edges."""
    kinds = np.bincount(graph.face_kind[graph.face_solid == solid], minlength=len(SurfaceKind))
    lengths = np.sort(np.round(edge_lengths(graph)[graph.edge_solid == solid] / SAME_LENGTH_MM))
    return kinds.astype(np.int64).tobytes() + lengths.astype(np.int64).tobytes()


def _is_vessel(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> bool:
    """Tell whether a turned solid is a cup deeper than wide, with a wall thinner than `VESSEL_WALL` of its width."""
    faces = np.flatnonzero((graph.face_solid == solid) & (graph.face_kind == SurfaceKind.CYLINDER))
    bores, radius = faces[graph.face_outward[faces] < 0], graph.face_param[faces, 0]
    if len(bores) == 0 or not is_turned(graph, trimmed, solid):
        return False
    o, z = graph.face_frame[bores[0], 0], graph.face_frame[bores[0], 3]
    inner, surface = float(graph.face_param[bores, 0].max()), sampled_surface(graph, trimmed, solid)
    closed = (off_axis(surface.p, o, z) < inner / 2) & (np.abs(surface.normal @ z) > ON_COS)
    is_deep = np.ptp(np.concatenate([trimmed.heights(face, z) for face in bores.tolist()])) > 2.0 * inner
    return bool(closed.any() and is_deep and radius.max() - inner < VESSEL_WALL * 2.0 * inner)


@once_per_solid
def why_one_piece(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> str | None:
    """Tell why a solid looks cast, turned or of timber; None if it may be a weldment, or was cut, bent or milled."""
    return next(filter(None, (why(graph, trimmed, solid) for why in CAST)), None)


@once_per_solid
def _why_formed(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> str | None:
    """Tell why no corner of a solid was welded, not even one between slender members; None if one may be."""
    return next(filter(None, (why(graph, trimmed, solid) for why in FORMED)), None)


def _why_turned(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> str | None:
    return "all its faces are round about one axis: it looks turned" if is_turned(graph, trimmed, solid) else None


def _why_extruded(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> str | None:
    n = graph.face_frame[:, 3] * graph.face_outward[:, None]
    plane, most = np.round(np.column_stack([n, np.einsum("fi,fi->f", n, graph.face_frame[:, 0])]), 1), 0
    for one in members_of(graph, trimmed, solid).members:
        roots = {(*plane[a], *plane[b]) for a, b in one.roots if abs(float(n[a] @ n[b])) < SQUARE_COS}
        most = max(most, len(roots) if one.kind is MemberKind.PROFILE else 0)
    return f"its section has {most} inner corners: it is an extrusion" if most > MOST_ROOTS else None


def _why_unexplained(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> str | None:
    """Tell which share of a solid is on plates, bars and tubes, if that is too little; strips may be beads."""
    members = members_of(graph, trimmed, solid)
    if members.straight_share >= LEAST_EXPLAINED and not members.is_moulded:
        return None
    found = find_strips(graph, trimmed, solid)
    strips = drawn_beads(graph, found)
    strips[[strip.face for strip in found]] = True
    share = built_up_share(graph, trimmed, solid, but=strips)
    if share >= LEAST_BUILT_UP:
        return None
    if members.straight_share >= LEAST_EXPLAINED:
        words = f"it has walls of {min(members.thick_mm):.1f} mm and no slender plate, bar or tube"
    else:
        words = f"{share:.0%} of its surface is on plates, bars or tubes; a weldment has {LEAST_BUILT_UP:.0%} or more"
    return f"{words}: it looks cast, moulded or milled"


def _why_timber(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> str | None:
    found = members_of(graph, trimmed, solid)
    slab = next((one for one in found.members if one.is_slab), None)
    if slab is None or found.is_box or any(one.thickness_mm < THIN_MM or one.is_hollow for one in found.members):
        return None
    words = f"it has a slab {slab.thickness_mm:.0f} mm thick, heavy bars, and nothing under {THIN_MM:g} mm"
    return f"{words}: it looks like timber" if any(one.is_beam for one in found.members) else None


def _why_pressed(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> str | None:
    """Tell whether a formed sheet has a free-form face that does not close on itself, as those of bent tubes do."""
    found = members_of(graph, trimmed, solid)
    sheets = [face for one in found.members if one.kind is MemberKind.SHEET for face in one.faces]
    wall_mm, count = min(found.thick_mm, default=0.0), len(found.members)
    is_round = sheets and count >= MANY_WALLS and wall_mm <= MOULDED_MM + ON_MM
    if found.is_of_one_wall and (is_round or found.is_moulded):
        return f"its {count} walls are {wall_mm:.2g} mm thick: it looks moulded"
    closed = graph.edge_faces[graph.is_seam_edge]
    if not ((graph.face_kind[sheets] == SurfaceKind.NURBS) & ~np.isin(sheets, closed)).any():
        return None
    if found.straight_share < LEAST_STRAIGHT:
        return "it is mostly free-form sheet: it looks pressed or moulded"
    return "it is of one thickness, with free-form sheet: it looks pressed or moulded" if found.is_of_one_wall else None


def _why_ribbed(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> str | None:
    is_case = members_of(graph, trimmed, solid).has_ribs
    return "many of its members are small: it looks moulded or printed" if is_case else None


@once_per_solid
def _why_compact(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> str | None:
    size, found = float(np.linalg.norm(trimmed.solid_sides_mm[solid])), members_of(graph, trimmed, solid)
    if (size / COMPACT_MM) ** 2 >= 1.0 + 2.0 * LOOSE + UNEXPLAINED * (1.0 - found.share):
        return None
    corners = _inner_corners(graph, trimmed, solid)
    loose_mm = sum(mm for *faces, mm in corners if not found.is_joint(*faces) and not found.is_inside(*faces))
    loose, filled = loose_mm / max(sum(mm for *_, mm in corners), ON_MM), filled_share(graph, trimmed, solid)
    left = ((size / COMPACT_MM) ** 2 - 1.0 - LOOSE * loose - _packed(found, corners, loose, filled)) / UNEXPLAINED
    if left >= 1.0 - found.share or left >= (1.0 - found.share) * (1.0 - built_up_share(graph, trimmed, solid)):
        return None
    words = f"members explain {found.share:.0%} of its surface and {1.0 - loose:.0%} of its inner corners"
    words = f"{words}, it fills {filled:.0%} of its hull, and it is {size:.0f} mm from corner to corner"
    return f"{words}: it was rather cast, printed or milled"


def _packed(found: Decomposition, corners: Sequence[tuple[int, int, float]], loose: float, filled: float) -> float:
    """Return what a full hull adds; nothing where no corner tells, and where plates lie on each other."""
    if loose >= MOST_LOOSE or found.are_parallel_plates or all(found.is_inside(a, b) for a, b, _ in corners):
        return 0.0
    stout = sum(one.stoutness > STOUT for one in found.members) / max(len(found.members), 1)
    return min((FULL + STOUTEST * stout) * (filled / (1.0 - filled)) ** 2, LOOSE)


def _why_stepped(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> str | None:
    is_stepped = members_of(graph, trimmed, solid).is_stepped_plate
    return "it is one plate with steps or pads: it looks milled or printed" if is_stepped else None


CAST = (_why_turned, _why_unexplained, _why_timber)  #: Reasons why a solid is not built up, as they are asked.
FORMED = (_why_extruded, _why_pressed, _why_ribbed, _why_stepped)  #: Reasons why its own corners are no welds.


def are_welded_corners(
    graph: BrepGraph, trimmed: TrimmedFaces, wall: IntArray, base: IntArray, gap_mm: float
) -> BoolArray:
    """Tell which inner corners between two faces of one solid may have been welded, shape (n,).

    All corners of a solid that was built up; of a solid that members explain in part, those between slender members.
    Not those round bolts and screws that are one body with more.
    `wall`, `base`: shape (n,). Faces beside the corners.
    """
    solids, of = np.unique(graph.face_solid[wall], return_inverse=True)
    found = are_weldments(graph, trimmed, solids, gap_mm)[of.ravel()]
    rest = np.flatnonzero(~found)
    apart = are_apart(graph, trimmed, np.unique(graph.face_solid[wall[rest]]), gap_mm)
    pairs = set().union(*(_slender_pairs(graph, trimmed, solid) for solid in apart.tolist()))
    found[rest] = [
        (min(pair), max(pair)) in pairs for pair in zip(wall[rest].tolist(), base[rest].tolist(), strict=True)
    ]
    screwed = [screw_faces(graph, trimmed, solid) for solid in solids[np.unique(of.ravel()[found])].tolist()]
    bolts = list(frozenset().union(*screwed))
    return np.asarray(found & ~np.isin(wall, bolts) & ~np.isin(base, bolts))


@once_per_solid
def _slender_pairs(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> frozenset[tuple[int, int]]:
    """Return the pairs of faces at corners between two slender members; none if most of its other corners are not.

    Corners inside members do not count. None of a solid that members explain either: it is too small for a weldment.
    """
    found, size = members_of(graph, trimmed, solid), np.linalg.norm(trimmed.solid_sides_mm[solid])
    corners, pairs, between_mm, other_mm = _inner_corners(graph, trimmed, solid), set(), 0.0, 0.0
    for wall, base, mm in corners:
        if found.is_between(wall, base):
            pairs.add((min(wall, base), max(wall, base)))
            between_mm += mm
        elif not found.is_inside(wall, base):
            other_mm += mm
    is_welded = between_mm >= LEAST_BETWEEN * (between_mm + other_mm) and size >= LEAST_PARTLY_MM
    if not pairs or not is_welded or why_one_piece(graph, trimmed, solid) is None:
        return frozenset()
    lugs = lugs_of(graph, trimmed, solid)
    at_lugs = {(min(a, b), max(a, b)) for a, b, _ in corners if any((a in lug) != (b in lug) for lug in lugs)}
    return frozenset(pairs | at_lugs)


def _inner_corners(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> list[tuple[int, int, float]]:
    """Return the two faces beside each inner corner of a solid, sharp or filled, and its length, mm; none at bolts."""
    own = np.arange(len(graph.solid_names)) == solid
    strips, length, bolts = find_strips(graph, trimmed, solid), edge_lengths(graph), screw_faces(graph, trimmed, solid)
    edges = find_concave_edges(graph, own, but=drawn_beads(graph, strips)).pieces
    corners = [*zip(edges.wall.tolist(), edges.base.tolist(), length[edges.edge].tolist(), strict=True)]
    corners += [(*strip.sides, float(length[list(strip.edges[0])].sum())) for strip in strips]
    return [corner for corner in corners if bolts.isdisjoint(corner[:2])]


def are_weldments(graph: BrepGraph, trimmed: TrimmedFaces, solids: IntArray, gap_mm: float) -> BoolArray:
    """Tell which solids may have been welded from several members, shape (n,)."""
    sample_surfaces(graph, trimmed, [solid for solid in solids.tolist() if not is_turned(graph, trimmed, solid)])
    whys = [why_one_piece(graph, trimmed, solid) or _why_compact(graph, trimmed, solid) for solid in solids.tolist()]
    found = np.array([why is None for why in whys], dtype=bool)
    found[found] = np.isin(solids[found], are_apart(graph, trimmed, solids[found], gap_mm))
    return found


def are_apart(graph: BrepGraph, trimmed: TrimmedFaces, solids: IntArray, gap_mm: float) -> IntArray:
    """Return the solids that are not milled, pressed or forged members among others, shape (m,).

    `solids`: shape (n,).

    Of those that others touch, plates that lie on each other are left out, and small ones with others drawn apart.
    """
    found = count_solids(graph, trimmed, solids)
    touched = _are_touched(graph, trimmed, gap_mm)
    for row in np.flatnonzero(found).tolist():
        solid = int(solids[row])
        found[row] = not any(why(graph, trimmed, solid) for why in (_why_turned, _why_timber, _why_formed))
        if found[row] and touched[solid]:
            is_stepped = members_of(graph, trimmed, solid).are_parallel_plates
            found[row] = not is_stepped and not _is_detail(graph, trimmed, solid)
    return solids[found]


def _are_touched(graph: BrepGraph, trimmed: TrimmedFaces, gap_mm: float) -> BoolArray:
    """Tell which solids have boxes that are near those of others, crumbs left out, shape (S,)."""
    low, high = trimmed.solid_boxes
    own, other = BoxTree.of(low, high).meeting(low - gap_mm, high + gap_mm)
    near = own[(own != other) & ~are_crumbs(graph, trimmed)[other] & count_solids(graph, trimmed, other)]
    return np.asarray(np.bincount(near, minlength=len(low)) > 0, dtype=bool)


def _is_detail(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> bool:
    """Tell whether a solid is small beside a part of which several larger bodies are one member each."""
    size = np.linalg.norm(trimmed.solid_sides_mm, axis=1)
    if size[solid] >= DETAIL * graph.size_mm:
        return False
    larger = [other for other in np.argsort(-size, kind="stable").tolist() if size[other] > size[solid]]
    single = 0
    for other in larger[:MOST_ASKED]:
        members = members_of(graph, trimmed, other)
        single += len(members.members) == 1 and members.share >= LEAST_BUILT_UP
        if single >= DRAWN_APART:
            return True
    return False


def left_out(graph: BrepGraph, trimmed: TrimmedFaces, whole: Sequence[tuple[int, int, str]]) -> list[Issue]:
    """Tell in which solids concave edges are not taken for welds, and why, for a part without a candidate.

    `whole`: As `find_whole_solids` returns them, each of which gets an issue.
    """
    told = []
    for solid, count, why in whole:
        name, corners = graph.solid_names[solid], counted(count, "inner corner")
        text = f"{name} has {corners}, none taken for a weld: {why}. If they are welds: --concave always"
        told.append(Issue("one-piece", text, (name,)))
    if not told and len(graph.solid_names) == 1 and not _inner_corners(graph, trimmed, 0):
        name = graph.solid_names[0]
        return [Issue("no-seam", f"no seam: {name} is one solid without an inner corner", (name,))]
    return told


def find_whole_solids(graph: BrepGraph, trimmed: TrimmedFaces) -> list[tuple[int, int, str]]:
    """Find the solids with concave edges that look as if made as one piece, at most `MOST_TOLD`.

    Returns list of tuple. Number of the solid, how many concave edges it has, and why it is not a weldment.
    """
    solid_of = graph.face_solid[find_concave_edges(graph).pieces.wall]
    solids, counts = np.unique(solid_of, return_counts=True)
    most = np.argsort(-counts, kind="stable")[:MOST_TOLD]
    found = []
    for solid, count in zip(solids[most].tolist(), counts[most].tolist(), strict=True):
        screwed = "" if _inner_corners(graph, trimmed, solid) else "those that may be welds are round bolts or screws"
        of = (graph, trimmed, solid)
        why = why_one_piece(*of) or _why_formed(*of) or _why_compact(*of) or screwed
        found += [(solid, count, why)] if why else []
    return found


def are_crumbs(graph: BrepGraph, trimmed: TrimmedFaces) -> BoolArray:
    """Tell which solids are crumbs: the diagonal of their box is shorter than the shortest seam, shape (S,).

    A cut or a failed union leaves them behind. A solid that touches crumbs only is searched for welds inside it.
    """
    return np.asarray(np.linalg.norm(trimmed.solid_sides_mm, axis=1) < LEAST_SEAM_MM, dtype=bool)
