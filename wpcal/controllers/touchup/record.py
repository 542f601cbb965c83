"""``touchup.json``: what was corrected on the pendant and what follows, as plain values."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.calibrate.corrections import KindOffset
from wpcal.controllers.touchup.study import CorrectedPoint, TouchUp
from wpcal.core.errors import InputError
from wpcal.core.records import read_json

SCHEMA = "wpcal/touchup/1"


def touch_up_record(found: TouchUp) -> dict[str, Any]:
    """Return plain values for a JSON file."""
    explained = found.explanation
    exceptions = {point.row for point in found.exceptions}
    return {
        "schema": SCHEMA,
        "part": found.part.finished.calibration["inputs"]["part"]["sha256"],
        "common": None
        if found.common is None
        else {"what": "tool" if found.common[1] else "frame", "T": found.common[0].tolist()},
        "tools": {"written": sorted(found.written.tools), "changed": sorted(found.changed.tools)},
        "points": [_point(point, found, exceptions) for point in found.points],
        "deleted": [found.written.poses[row].where for row in found.pairs.deleted],
        "unread": list(found.changed.unread),
        "hand_mm": None if explained is None else explained.node.hand_mm,
        "robot_mm": None if explained is None else explained.node.amplitude_mm,
        "bodies": list(found.bodies),
        "offsets": [
            {"kind": kind, "y_mm": float(c.mean_mm[0]), "z_mm": float(c.mean_mm[1]), "sigma_mm": c.sigma_mm.tolist()}
            for kind, c in found.offsets.items()
        ],
        "seams": [
            {
                "seam": each.name,
                "corrected": each.corrected,
                "was_off_mm": each.was_off_mm,
                "error_95_before_mm": each.before_95_mm,
                "error_95_mm": each.after_95_mm,
                "says": each.says,
            }
            for each in found.seams
        ],
        "lines": written_lines(found),
        "not_free": [],
        "sentences": sentences(found),
    }


def _point(point: CorrectedPoint, found: TouchUp, exceptions: set[int]) -> dict[str, Any]:
    return {
        "seam": found.part.seams[point.seam].name,
        "place": point.place,
        "p_base_mm": point.at.tolist(),
        "moved_mm": point.moved.tolist(),
        "in_seam_mm": point.in_seam.tolist(),
        "along_mm": float(point.in_seam[0]),
        "across_mm": float(np.linalg.norm(point.in_seam[1:])),
        "is_added": point.is_added,
        "is_end": point.is_end,
        "is_used": point.is_used,
        "is_exception": point.row in exceptions,
    }


def written_lines(found: TouchUp) -> list[dict[str, Any]]:
    """Return what is written for every pose that differs from the program as wpcal wrote it, line by line."""
    moved = np.linalg.norm(found.shifts, axis=1)
    by_point = {point.row: float(np.linalg.norm(point.moved)) for point in found.points}
    exceptions = {point.row for point in found.exceptions}
    lines = []
    for row, pose in enumerate(found.changed.poses):
        if row in exceptions:
            what = "by hand, an exception: kept"
        elif row in found.by_hand:
            what = "by hand: smoothed" if moved[row] > 0.0 else "by hand: kept"
        elif moved[row] > 0.0:
            what = "moved with its seam"
        else:
            continue
        mm = by_point.get(row, 0.0) if row in found.by_hand and moved[row] == 0.0 else float(moved[row])
        lines.append({"place": pose.where, "seam": found.seam_names[row], "what": what, "mm": mm})
    return lines


def sentences(found: TouchUp) -> list[str]:
    """Return what a person should know, one sentence each."""
    old, new = (", ".join(sorted(program.tools, key=str.lower)) for program in (found.written, found.changed))
    deleted = "; ".join(found.written.poses[row].where for row in found.pairs.deleted)
    return [
        *_common(found),
        *([f"the tool was {old}, now {new}"] if old.lower() != new.lower() else ()),
        *(f"{name} has moved against the other bodies" for name in found.bodies),
        *(_offset(kind, offset) for kind, offset in found.offsets.items()),
        *(
            f"{point.place} ({found.part.seams[point.seam].name}) contradicts the other corrections, moved by "
            f"{np.linalg.norm(point.moved):.2f} mm: kept, but taken for an exception (a clamp, a tack)"
            for point in found.exceptions
        ),
        *([f"deleted on the pendant: {deleted}"] if deleted else ()),
        *(f"NOT READ: {each}" for each in found.changed.unread),
    ]


def _common(found: TouchUp) -> list[str]:
    if found.common is None:
        return []
    T, is_tool = found.common
    turn = np.degrees(np.arccos(np.clip((np.trace(T[:3, :3]) - 1.0) / 2.0, -1.0, 1.0)))
    what, place = ("tool was changed", "tool") if is_tool else ("frame was moved", "place of the part")
    return [
        f"the {what}: all poses by {np.linalg.norm(T[:3, 3]):.2f} mm at its origin and {turn:.2f}°; this counts as the "
        f"{place}, not as corrections"
    ]


def _offset(kind: str, offset: KindOffset) -> str:
    (y, z), (sy, sz) = offset.mean_mm, 2.0 * offset.sigma_mm
    return (
        f"{kind}: corrections are offset by y {y:+.2f} ± {sy:.2f} mm, z {z:+.2f} ± {sz:.2f} mm in the seam's axes, "
        "taken for a preference, not for the part's place (--keep-offset gives it to all such seams)"
    )


LEAST_PARTS = 3  #: Fewer parts show no habit.
MOST_SHARE = 0.8  #: In at least this share of the parts where it could be.
LEAST_MM = 0.2  #: What is smaller is left to the pendant.
SURE = 3.0  #: A mean counts if it is this many of its standard errors.


def earlier_touch_ups(folder: Path, *, must: bool = True) -> list[dict[str, Any]]:
    """Return the records ``touchup.json`` in a folder and in those below it.

    Raises `InputError` when there is none and there must be one.
    """
    found = sorted(folder.rglob("touchup.json")) if folder.is_dir() else []
    if must and not found:
        raise InputError(f"{folder}: no touchup.json is in it; expected a folder of earlier touch-ups")
    return [read_json(path, schema=SCHEMA) for path in found]


def proposals(records: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return one sentence for each thing that was corrected the same way on most parts."""
    return [*_bodies(records), *(list(_offsets(records)) or _seams(records))]


def _bodies(records: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    for name in sorted({body for record in records for body in record["bodies"]}):
        count = sum(name in record["bodies"] for record in records)
        if len(records) >= LEAST_PARTS and count >= MOST_SHARE * len(records):
            yield f"{name} moved on {count} of {len(records)} parts: its place in the model or the fixture is wrong"


def _offsets(records: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    found = defaultdict(list)
    for record in records:
        for each in record["offsets"]:
            found[each["kind"]].append((each["y_mm"], each["z_mm"]))
    for kind, values in sorted(found.items()):
        said = _same(values, len(records))
        if said:
            yield f"{kind}: {said}: a rule of weld data, or the tool"


def _seams(records: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield seams that are corrected alike, where no offset of all seams explains it."""
    found = defaultdict(list)
    for record in records:
        own = defaultdict(list)
        for point in record["points"]:
            if point["is_used"] and not point["is_exception"]:
                own[point["seam"]].append(point["in_seam_mm"][1:])
        for seam, values in own.items():
            found[seam].append(np.mean(values, axis=0))
    for seam, values in sorted(found.items()):
        said = _same(values, len(values))
        if said:
            yield f"{seam}: {said}: its place in the model is wrong"


def _same(values: Sequence[Any], parts: int) -> str:
    """Return what values of parts, y and z in mm, have in common; empty if nothing."""
    n = len(values)
    if n < max(LEAST_PARTS, MOST_SHARE * parts):
        return ""
    mean, error = np.mean(values, axis=0), np.std(values, axis=0, ddof=1) / np.sqrt(n)
    size = float(np.linalg.norm(mean))
    if size < LEAST_MM or size < SURE * float(np.linalg.norm(error)):
        return ""
    return f"corrected by y {mean[0]:+.2f} mm, z {mean[1]:+.2f} mm on average on {n} of {parts} parts"
