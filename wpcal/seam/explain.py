"""Why a candidate is taken for a weld or not: every finding with its factor, and the facts behind the joint."""

from __future__ import annotations

from typing import Any

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.wording import counted
from wpcal.seam.judge.evidence import is_judgement
from wpcal.seam.judge.hiding import hiding_words
from wpcal.seam.member.note import MemberNotes
from wpcal.seam.rules import PRIOR, Rule, confidence_of, score_of
from wpcal.seam.seam import Seam, WeldType

THROAT_SHARE = 0.7
"""A fillet weld with a throat of this share of the thinner member, on both sides, is about as strong as the member."""
THICKNESS_KEYS = (("wall", "wall_thickness_mm"), ("base", "base_thickness_mm"))
"""The sides of a joint, and where a section has their thickness."""


def explain_seam(
    graph: BrepGraph, seam: Seam, notes: MemberNotes, thick_mm: tuple[float | None, float | None] = (None, None)
) -> dict[str, Any]:
    """Return everything that decided about a seam.

    `thick_mm`: Thickness of the plates at the sides of +y and -y, mm (`wpcal.weld.thickness.plate_thicknesses`).

    Returns: Plain values. ``chain`` is the decisions in words, in their order. ``findings`` are those against it, each
    with the confidence after it. ``section`` is the joint across the seam, at its middle.
    """
    findings = []
    by_key = {rule.key: rule.value for rule in Rule}
    for k, one in enumerate(seam.findings):
        row = by_key.get(one.rule)
        findings.append(
            {
                "rule": one.rule,
                "factor": round(one.factor, 3),
                "text": one.text,
                "why": "" if row is None else row.why,
                "found_by": "" if row is None else row.evidence,
                "confidence_after": round(confidence_of(seam.source, seam.findings[: k + 1]), 4),
            }
        )
    section = _section(graph, seam, thick_mm)
    others = [str(text) for text in seam.reasons if not is_judgement(text, seam.source)]
    members = [member for member in notes.members if member.solid in seam.solids]
    return {
        "seam": seam.name,
        "accepted": seam.accepted,
        "confidence": round(seam.confidence, 3),
        "least_confidence": notes.judging.level.value,
        "start_confidence": round(confidence_of(seam.source, ()), 4),
        "start_score": PRIOR[seam.source],
        "score": round(score_of(seam.source, seam.findings), 4),
        "section": section,
        "chain": [*_chain(graph, seam), _section_words(section), *others, _verdict(seam, notes)],
        "findings": findings,
        "members": [member.to_record() for member in members],
    }


def _chain(graph: BrepGraph, seam: Seam) -> list[str]:
    """Say in words where a seam comes from, what it joins, and how a torch gets to it."""
    least, mean, largest = seam.gap_mm
    opening = 180.0 - np.degrees(seam.frames.angle_rad)
    faces = [_faces(graph, own) for own in (seam.pieces.wall, seam.pieces.base)]
    run = "closed loop" if seam.closed else "run"
    return [
        f"found as: {seam.source.value}; {run} of {seam.length_mm:.1f} mm in {counted(len(seam.pieces), 'piece')}",
        f"joint: {seam.joint.value}, {seam.weld.value} weld between {faces[0]} and {faces[1]}, which open by "
        f"{_span(float(opening.min()), float(opening.max()), 'degrees')}",
        f"gap: {least:.3f} to {largest:.3f} mm, {mean:.3f} mm on average",
        _reach(seam),
    ]


def _section(graph: BrepGraph, seam: Seam, thick_mm: tuple[float | None, float | None]) -> dict[str, Any]:
    """Return the joint across the middle of a seam: plain values, None for what is not known."""
    row, piece = len(seam.frames) // 2, len(seam.pieces) // 2
    wall, y = int(seam.pieces.wall[piece]), seam.frames.R[row, :, 1]
    faces_minus_y = wall >= 0 and project_to_faces(graph, [wall], seam.frames.p[[row]]).normal[0] @ y < 0
    of_wall, of_base = thick_mm[::-1] if faces_minus_y else thick_mm
    known, is_fillet = [value for value in thick_mm if value is not None], seam.weld is WeldType.FILLET
    return {
        "wall_thickness_mm": None if of_wall is None else round(of_wall, 2),
        "base_thickness_mm": None if of_base is None else round(of_base, 2),
        "gap_mm": round(seam.gap_mm[1], 3),
        "opening_deg": round(180.0 - float(np.degrees(seam.frames.angle_rad[row])), 1),
        "largest_throat_mm": round(THROAT_SHARE * min(known), 1) if known and is_fillet else None,
    }


def _section_words(section: dict[str, Any]) -> str:
    """Say how thick the members are, how they meet, and how large a fillet may be."""
    sides = [f"{side} {'?' if section[key] is None else f'{section[key]:g} mm'}" for side, key in THICKNESS_KEYS]
    throat = section["largest_throat_mm"]
    most = (
        "" if throat is None else f"; throat of a fillet up to {throat:g} mm ({THROAT_SHARE:g} of the thinner member)"
    )
    return f"section: {' and '.join(sides)} thick, opening {section['opening_deg']:g} degrees{most}"


def _faces(graph: BrepGraph, faces: np.ndarray[Any, np.dtype[np.int64]]) -> str:
    """Name the kinds of some faces and their solids: ``plane of web``."""
    known = [face for face in dict.fromkeys(faces.tolist()) if face >= 0]
    words = [
        f"{SurfaceKind(graph.face_kind[f]).name.lower()} of {graph.solid_names[graph.face_solid[f]]}" for f in known
    ]
    return ", ".join(dict.fromkeys(words)) or "none known"


def _span(low: float, high: float, unit: str) -> str:
    return f"{low:.0f} {unit}" if high - low < 1.0 else f"{low:.0f} to {high:.0f} {unit}"


def _reach(seam: Seam) -> str:
    if seam.lean_rad is None:
        return "reach: the whole torch was not felt at this candidate"
    lean = np.degrees(seam.lean_rad)
    none = np.isnan(lean).any(axis=1)
    straight = ~none & (np.abs(np.nan_to_num(lean)).max(axis=1) < 0.5)
    most = float(np.abs(np.nan_to_num(lean)).max())
    words = [f"straight at {int(straight.sum())} of {counted(len(lean), 'place')}"]
    if (~none & ~straight).any():
        words.append(f"leaning by up to {most:.0f} degrees at {int((~none & ~straight).sum())}")
    if none.any():
        words.append(f"not free at {int(none.sum())}")
    if seam.blocked_by:
        other = seam.other_torch
        words.append(
            "none of the shipped torches reaches all of it"
            if other is None
            else f"{other.name} reaches all of it with {other.wire_mm:g} mm of wire (--torch {other.name})"
        )
    return f"reach: the torch is {', '.join(words)}{hiding_words(seam)}"


def _verdict(seam: Seam, notes: MemberNotes) -> str:
    level = notes.judging.level
    if seam.edit is not None and seam.edit.accept is not None:
        return "decided by hand"
    if seam.inside or seam.blocked_by:
        return "refused, whatever the confidence: the torch does not get there"
    sign = "at least" if seam.confidence >= level.value else "less than"
    return f"confidence {seam.confidence:.0%}: {sign} the {level.value:.0%} that are asked ({level.name.lower()})"
