"""The members of a part as a person reads them: names, what each is, its size and weight, and the faces it has.

A solid that is one member has the name of the solid. The members of one that was several are ``frame/1``, ``frame/2``,
…, the largest first.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.repeats import solid_shapes
from wpcal.brep.solid_facts import facts_of
from wpcal.brep.surfaces import unit
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.core.wording import short
from wpcal.seam.find.built_up import SAME_THICKNESS, Surface, sampled_surface
from wpcal.seam.member.member import ENDS_TOGETHER, Decomposition, Member, MemberKind
from wpcal.seam.member.members import members_of
from wpcal.seam.member.note import NO_MATERIAL_KG_M3, MemberNotes
from wpcal.seam.member.one_piece import why_one_piece
from wpcal.seam.member.words import DENSITY_KG_M3, Kind
from wpcal.seam.rules import Rule
from wpcal.seam.seam import Seam

LEAST_SHARE = 0.5  #: Of a solid that looks made in one piece, members explain this much if they are listed.
MOST_SHARED = 0.5  #: What has more of its surface on a larger member is a part of that, as the wall of a tube.
BOUGHT = {rule.key for rule in (Rule.FASTENER, Rule.STANDARD_PART, Rule.NAMED_PART)}
"""Findings about what is bought, as a fastener or a bearing is: it is not taken apart."""
WIDEST_BAR_MM = 150.0  #: Flat bars are rolled up to this width (EN 10058); what is wider is cut from plate.


@dataclass(frozen=True, slots=True, eq=False)
class Listed:
    """One member, or a solid of several."""

    name: str
    solid: int
    faces: frozenset[int]
    centre_mm: tuple[float, float, float]  #: Of the box around its faces, in `part`, mm.
    kind: str = ""  #: In words; of a solid of several members, empty.
    thickness_mm: float = 0.0
    length_mm: float = 0.0
    share: float = 1.0  #: Of the volume of the solid.
    mass_kg: float = 0.0
    density_kg_m3: float | None = None

    def to_record(self, on: Mapping[int, Sequence[Seam]]) -> dict[str, Any]:
        """Return plain values, with the length of the seams on its faces; `on`: by face."""
        seams = {seam.name: seam.length_mm for face in sorted(self.faces) for seam in on.get(face, ())}
        return {
            "name": self.name,
            "kind": self.kind,
            "thickness_mm": round(self.thickness_mm, 3),
            "length_mm": round(self.length_mm, 2),
            "density_kg_m3": self.density_kg_m3,
            "mass_kg": round(self.mass_kg, 4),
            "weld_mm": round(sum(seams.values()), 2),
            "seams": sorted(seams),
        }


def weighed_members(
    graph: BrepGraph, trimmed: TrimmedFaces, notes: MemberNotes, volumes_mm3: Sequence[float]
) -> MemberNotes:
    """Return the notes with the members of all solids, and weights: as the file states the density, or by the metal.

    The members of one solid weigh together what the solid weighs; what each of them does is an estimate.
    """
    listed, first, known = list[Listed](), solid_shapes(graph, trimmed), dict[int, list[Listed]]()
    for solid, (taken, volume) in enumerate(zip(notes.members, volumes_mm3, strict=True)):
        stated = facts_of(graph.solid_facts, solid).density_kg_m3
        density = DENSITY_KG_M3[taken.metal or Kind.STEEL] if stated in (None, NO_MATERIAL_KG_M3) else stated
        shape, own = int(first[solid]), [replace(_whole(graph, trimmed, solid), kind="bought")]
        if not any(finding.rule in BOUGHT for finding in taken.findings):
            known[shape] = known.get(shape) or list_members(graph, trimmed, shape)
            own = known[shape] if shape == solid else list(_at_copy(graph, trimmed, known[shape], solid))
        for one in own:
            listed.append(replace(one, density_kg_m3=density, mass_kg=one.share * volume * density * 1e-9))
    return replace(notes, listed=tuple(listed))


def _at_copy(graph: BrepGraph, trimmed: TrimmedFaces, listed: Sequence[Listed], solid: int) -> Iterator[Listed]:
    """Yield the members of a solid that is a moved copy of the one that is listed."""
    whole, name = listed[0], graph.solid_names[solid]
    pairs = zip(*(np.flatnonzero(graph.face_solid == each).tolist() for each in (whole.solid, solid)), strict=True)
    face_of = dict(pairs)
    for one in listed:
        faces, own = frozenset(face_of[face] for face in one.faces), name + one.name.removeprefix(whole.name)
        yield replace(one, name=own, solid=solid, faces=faces, centre_mm=_middle(trimmed, faces))


def list_members(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> list[Listed]:
    """Return a solid, then its members if it was several."""
    whole = _whole(graph, trimmed, solid)
    found = members_of(graph, trimmed, solid)
    if not found.members or (found.share < LEAST_SHARE and why_one_piece(graph, trimmed, solid) is not None):
        return [whole]
    surface = sampled_surface(graph, trimmed, solid)
    members, distinct = [], list(_distinct(surface, found))
    if len(distinct) == 1:
        return [replace(_sized(trimmed, surface, whole, distinct[0][0]), share=1.0)]
    for number, (one, known) in enumerate(distinct, 1):
        faces = _own_faces(trimmed, one, known)
        named = replace(whole, name=f"{whole.name}/{number}", faces=faces, centre_mm=_middle(trimmed, faces))
        members.append(_sized(trimmed, surface, named, one))
    total = sum(one.share for one in members)
    return [whole, *(replace(one, share=one.share / total) for one in members if total)]


def _whole(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> Listed:
    own = frozenset(np.flatnonzero(graph.face_solid == solid).tolist())
    return Listed(graph.solid_names[solid], solid, own, _middle(trimmed, own))


def _distinct(surface: Surface, found: Decomposition) -> Iterator[tuple[Member, frozenset[int]]]:
    """Yield members with their faces: both sides of a sheet once, and no part of a larger member."""
    sheets = [row for row, one in enumerate(found.members) if one.kind is MemberKind.SHEET]
    other_side = dict(zip(sheets[::2], sheets[1::2], strict=False))
    for row, (one, faces) in enumerate(zip(found.members, found.explained, strict=True)):
        own = surface.face[np.isin(surface.face, list(one.faces))]
        shared = max((np.isin(own, list(larger.faces)).sum() for larger in found.members[:row]), default=0)
        if row not in other_side.values() and shared <= MOST_SHARED * len(own) and one.section.min() > 0.0:
            other = found.members[other_side[row]].faces if row in other_side else frozenset[int]()
            yield one, faces | one.rims | other


def _own_faces(trimmed: TrimmedFaces, one: Member, faces: frozenset[int]) -> frozenset[int]:
    """Return the faces that do not go on beyond a member: those of others that its section meets do."""
    most_mm = one.thickness_mm if one.kind is MemberKind.PLATE else one.length_mm or np.inf
    extent = {face: _extent(trimmed.heights(face, one.axis)) for face in faces}
    return frozenset(
        face for face in faces if extent[face] <= max((1.0 + ENDS_TOGETHER) * most_mm, min(extent.values()))
    )


def _sized(trimmed: TrimmedFaces, surface: Surface, named: Listed, one: Member) -> Listed:
    """Return a member with its size in words and numbers, and with its volume, mm³, as its share."""
    kind, t, (thin, long) = one.kind, one.thickness_mm, sorted(one.section.tolist())
    rows = np.concatenate([np.arange(*trimmed.start[[face, face + 1]]) for face in sorted(named.faces)])
    p, along = trimmed.p0[rows], trimmed.p1[rows] - trimmed.p0[rows]
    length_mm = one.length_mm or _extent(p @ one.axis)
    if kind is MemberKind.PLATE:
        flat = along - np.outer(along @ one.axis, one.axis)
        x = unit(flat[np.argmax(np.linalg.norm(flat, axis=1))])
        long, length_mm = sorted([_extent(p @ x), _extent(p @ np.cross(one.axis, x))])
    is_solid = {MemberKind.ROUND: t >= long}.get(kind, kind in (MemberKind.BAR, MemberKind.BOX))
    is_flat = kind in (MemberKind.PLATE, MemberKind.SHEET)
    felt = surface.thick[np.isin(surface.face, list(named.faces))]
    felt = felt[(np.abs(felt - t) <= SAME_THICKNESS * t) | (not is_flat)]
    volume = thin * long * length_mm if is_solid else len(felt) * surface.mm2 * t / 2.0
    if kind in (MemberKind.TUBE, MemberKind.PROFILE):
        t = float(np.median(np.append(felt, t)))  # of a wall; that of a member is a mean
    if kind is MemberKind.BAR:
        t, long, length_mm = sorted((thin, long, length_mm))
        kind = MemberKind.PLATE if long > WIDEST_BAR_MM else kind
    sizes = {MemberKind.TUBE: [long, thin, t], MemberKind.PROFILE: [long, thin, t], MemberKind.SHEET: [t]}
    words = " x ".join(map(short, sizes.get(kind, [long, t])))
    word = kind.value.replace(" or tube" if is_solid else "bar or ", "")
    return replace(named, kind=f"{word} {words} mm", thickness_mm=t, length_mm=length_mm, share=volume)


def _extent(heights: FloatArray) -> float:
    return float(np.ptp(heights)) if len(heights) else 0.0


def _middle(trimmed: TrimmedFaces, faces: frozenset[int]) -> tuple[float, float, float]:
    low, high = (corner[sorted(faces)] for corner in trimmed.face_box)
    x, y, z = ((low.min(axis=0) + high.max(axis=0)) / 2.0).tolist() if len(low) else (0.0, 0.0, 0.0)
    return x, y, z
