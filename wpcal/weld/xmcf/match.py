"""Which seam of a part is which weld of an xMCF file, and what the file states about it."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wpcal.brep.trim import distance_to_segments
from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed
from wpcal.seam.seam import Seam
from wpcal.weld.place import StatedWeld, place_of
from wpcal.weld.values import PREPARATIONS, WeldKind, plain
from wpcal.weld.xmcf.read import WeldSide, XmcfSeam

NEAR_MM = 2.0
"""A seam is at a weld of a file if all its points are at most this far from its line, or the thickest sheet if that is
more: a file for finite elements has its lines in the middle of the sheets."""
KINDS = {
    "butt_joint": WeldKind.SQUARE,
    "edge_weld": WeldKind.SQUARE,
    "corner_weld": WeldKind.FILLET,
    "overlap_weld": WeldKind.FILLET,
    "y_joint": WeldKind.FILLET,
    "k_joint": WeldKind.FILLET,
    "cruciform_joint": WeldKind.FILLET,
    "flared_joint": WeldKind.FLARE_V,
}
"""The weld that a type of seam stands for. An I-weld through sheets has none here: it is not welded with a torch."""
GROOVES = {letters: kind for kind, letters in PREPARATIONS.items()} | {
    "Y": WeldKind.SINGLE_V,
    "HY": WeldKind.SINGLE_BEVEL,
}
"""The groove of a butt weld by its letters; Y and HY have a root face."""


@dataclass(frozen=True, slots=True)
class XmcfMatch:
    """What a file states about the seams of a part."""

    stated: tuple[StatedWeld, ...]  #: Of the seams that it names.
    notes: tuple[str, ...]  #: What is not obvious, one line each.
    dropped: tuple[str, ...] = ()  #: Labels of welds at which there is no seam.


def match_xmcf(
    seams: Sequence[Seam], welds: Sequence[XmcfSeam], T_part_frame: RigidTransform, *, file: str
) -> XmcfMatch:
    """Find the weld of a file at every seam that is welded, and take its values.

    A weld that covers a part of a seam counts for the whole seam, and that is said. Others are dropped by name.
    """
    stated, notes, used = [], list[str](), set[int]()
    for seam in seams:
        row, within = _weld_at(T_part_frame.apply(seam.frames.p), welds, used)
        if row is None:
            continue
        used.update([row], within)
        weld = welds[row]
        if within:
            covered = ", ".join(f"{welds[one].label} ({welds[one].length_mm:.0f} mm)" for one in within)
            notes.append(
                f"{seam.name}: {file}: {covered} of {seam.length_mm:.0f} mm; the whole seam is welded with its values "
                "unless it is shortened: range_mm in seams.json"
            )
        values, odd = _values(weld, T_part_frame.R @ seam.frames.R[len(seam.frames) // 2][:, 2])
        notes += [f"{seam.name}: {file}: {weld.label}: {what}" for what in odd]
        own = {name: (value, file) for name, value in values.items()}
        stated.append(StatedWeld(seam.name, place_of(seam, T_part_frame), {}, own))
    lost = tuple(weld.label for row, weld in enumerate(welds) if row not in used)
    if lost:
        notes.append(f"{file}: no seam that is welded is at {listed(lost)}: dropped")
    return XmcfMatch(tuple(stated), tuple(notes), lost)


def _weld_at(points: FloatArray, welds: Sequence[XmcfSeam], used: Collection[int]) -> tuple[int | None, Sequence[int]]:
    """Return the weld at a seam, one that no other seam has if possible, and the welds that cover a part of it only."""
    off = [_distance(points, weld.lines_mm) for weld in welds]
    near = [row for row, weld in enumerate(welds) if off[row] <= _near_mm(weld)]
    within = list[int]()  # welds of which all is on the line through the points
    if not near and len(points) > 1:
        apart = [_distance(np.concatenate(weld.lines_mm), [points]) for weld in welds]
        within = [row for row, weld in enumerate(welds) if apart[row] <= _near_mm(weld)]
    return min(near or within, key=lambda one: (one in used, off[one]), default=None), within


def with_files(stated: Sequence[StatedWeld], more: Sequence[StatedWeld]) -> tuple[StatedWeld, ...]:
    """Add what files state to what was stated before, by the names of seams."""
    own = {weld.name: weld for weld in stated}
    for weld in more:
        old = own.get(weld.name, weld)
        own[weld.name] = replace(old, files={**old.files, **weld.files})
    return tuple(own.values())


def _near_mm(weld: XmcfSeam) -> float:
    return max(NEAR_MM, *weld.thicknesses_mm, NEAR_MM)


def _distance(points: FloatArray, lines: Sequence[FloatArray]) -> float:
    """Return the largest distance of points to polylines."""
    starts = np.concatenate([line[:-1] for line in lines])
    ends = np.concatenate([line[1:] for line in lines])
    k, m = len(points), len(starts)
    off = distance_to_segments(np.repeat(points, m, axis=0), np.tile(starts, (k, 1)), np.tile(ends, (k, 1)))
    return float(off.reshape(k, m).min(axis=1).max())


def _values(weld: XmcfSeam, outward: FloatArray) -> tuple[dict[str, Any], list[str]]:
    """Return names and values as JSON holds them, and what could not be taken."""
    side, kind = _side_towards(weld.sides, outward), KINDS.get(weld.kind)
    kind = GROOVES.get(side.section.upper(), kind) if kind is WeldKind.SQUARE else kind
    values = {
        "thickness_mm": min(weld.thicknesses_mm, default=None),
        "root_gap_mm": max(weld.gaps_mm, default=None),
        "throat_mm": side.throat_mm or None if kind is WeldKind.FILLET else None,
        "groove_angle_deg": side.angle_deg or None if kind in PREPARATIONS else None,
        "stitch": plain(side.stitch),
        "weld": plain(kind),
    }
    odd = ["segments of different lengths or distances are not taken; state stitch"] if side.is_uneven else []
    if weld.technology not in ("", "arc"):
        odd.append(f"is a {weld.technology} weld there")
    return {name: value for name, value in values.items() if value is not None}, odd


def _side_towards(sides: Sequence[WeldSide], outward: FloatArray) -> WeldSide:
    """Return the side whose direction is nearest to that out of the joint; one that states nothing if there is none."""
    if not sides:
        return WeldSide((0.0, 0.0, 0.0), "", None, None, None, None)
    directions = np.array([side.toward for side in sides])
    lengths = np.linalg.norm(directions, axis=1)
    return sides[int(np.argmax(directions @ outward / np.where(lengths > 0.0, lengths, 1.0)))]
