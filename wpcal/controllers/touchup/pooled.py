"""What is corrected the same way on every part of one kind: it belongs into the model, the fixture or the weld data."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.controllers.touchup.record import SCHEMA
from wpcal.core.errors import InputError
from wpcal.core.records import read_json

LEAST_PARTS = 3  #: Fewer parts show no habit.
MOST_SHARE = 0.8  #: In at least this share of the parts where it could be.
LEAST_MM = 0.2  #: What is smaller is left to the pendant.
SURE = 3.0  #: A mean counts if it is so many of its standard errors.


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
