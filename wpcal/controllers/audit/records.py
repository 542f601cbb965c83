"""Audit JSON records: every value that its schema or its reader refuses; and repair what has one answer.

That is rotations and quaternions of ``seams.json`` that lost digits. Which of two points with one name is meant, or
where a point really is, only a person knows.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.controllers.audit.fault import Fault
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError, WpcalError
from wpcal.core.input_file import read_bytes
from wpcal.core.record_check import check_record, find_faults
from wpcal.core.records import parse_json, to_json, write_file
from wpcal.core.rotations import quaternion_from_rotation
from wpcal.core.schemas import has_schema
from wpcal.core.wording import shown
from wpcal.planning.cell.cell_file import read_cell
from wpcal.planning.sequence.kept_plan import require_as_made
from wpcal.results.folder import RECORD_SCHEMAS
from wpcal.robot.kinematics.arm_file import ARM_SCHEMA, read_arm
from wpcal.robot.torch.file import CELL_SCHEMA
from wpcal.seam.record import SEAMS_SCHEMA, seams_from_record
from wpcal.seam.record_check import QUATERNION_ATOL, ROTATION_ATOL, seam_faults
from wpcal.weld.record import WELDS_SCHEMA, read_stated_welds
from wpcal.weld.rules import RuleTable

READERS: Mapping[str, Callable[[Path], object]] = {
    CELL_SCHEMA: read_cell,
    ARM_SCHEMA: read_arm,
    WELDS_SCHEMA: lambda path: read_stated_welds(path, RuleTable((), "any")),
}
"""What a schema cannot say, the reader of the record does."""


def audit_record(raw: bytes, path: Path) -> tuple[str, list[Fault]] | None:
    """Return the kind of a record and its faults; None for a JSON file of another program."""
    expected = RECORD_SCHEMAS.get(path.name)
    try:
        record = parse_json(raw, path=str(path))
    except WpcalError as error:
        return expected or "JSON", [Fault.of(error, str(path))]
    name = record.get("schema") if isinstance(record, dict) else None
    if expected is None and (name is None or (isinstance(name, str) and not name.startswith("wpcal/"))):
        return None
    if what := _wrong_schema(name, expected):
        return expected or "record", [Fault(what, field="schema")]
    return str(name), _faults(record, str(name), path)


def _wrong_schema(name: object, expected: str | None) -> str:
    """Say what is wrong with the name of a schema; empty for one that is known."""
    if expected is not None and name != expected:
        return f"expected a record of schema {expected}, found {name if isinstance(name, str) else 'none'}"
    if not isinstance(name, str):
        return "expected the name of a schema, as wpcal/seams/1"
    return "" if has_schema(name) else f"the schema {shown(name)} is not known here: a newer version wrote the file"


def _faults(record: dict[str, Any], name: str, path: Path) -> list[Fault]:
    """Return what the schema refuses; otherwise what it cannot say, and missing fields that the reader needs."""
    if refused := [Fault(what, field=place or None) for place, what in find_faults(record, name)]:
        return refused
    try:
        if name == SEAMS_SCHEMA:
            seams_from_record(record, path=str(path))
        elif name in READERS:  # people write cells, arms and welds, and may leave fields out
            READERS[name](path)
        else:
            check_record(record, name, path=str(path), is_complete=True)
            if "digest" in record:  # a plan
                require_as_made(record, path.parent)
    except WpcalError as error:
        if name == SEAMS_SCHEMA:
            with suppress(KeyError):  # a field is missing, which the error says
                repairs = repairs_of_seams(record)
                return [Fault(what, field=place, repair=repairs.get(place)) for place, what in seam_faults(record)]
        return [Fault.of(error, str(path))]
    return []


LOST_DIGITS = 2e-3
"""A rotation whose columns are off by less was rounded to three digits or more; the nearest rotation is meant."""


def repairs_of_seams(record: Mapping[str, Any]) -> dict[str, str]:
    """Return what is written instead of wrong values, by their places."""
    return {place: words for place, words, _, _ in _repairs(record)}


def repaired_seams(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of ``seams.json`` with the rotations and quaternions that are meant."""
    fixed = copy.deepcopy(dict(record))
    for _, _, frame, R in _repairs(fixed):
        frame["R"] = R.tolist()
        if "q_xyzw" in frame:
            frame["q_xyzw"] = quaternion_from_rotation(R).tolist()
    return fixed


def _repairs(record: Mapping[str, Any]) -> Iterator[tuple[str, str, dict[str, Any], FloatArray]]:
    """Yield place, words, frame and rotation of each frame that can be repaired."""
    for seam in record["seams"]:
        for number, frame in enumerate(seam["frames"]):
            R = np.array(frame["R"], dtype=np.float64)
            q = np.array(frame["q_xyzw"], dtype=np.float64) if "q_xyzw" in frame else None
            off = float(np.abs(R.T @ R - np.eye(3)).max())
            if not off <= LOST_DIGITS or np.linalg.det(R) < 0.0:
                continue
            u, _, vt = np.linalg.svd(R)
            nearest = np.asarray(u @ vt, dtype=np.float64)
            place = f"seam {seam['name']}: point {number}"
            apart = 0.0 if q is None else 1.0 - abs(float(q @ quaternion_from_rotation(nearest)))
            if not abs(apart) <= LOST_DIGITS:
                continue
            if off > ROTATION_ATOL:
                yield f"{place}: R", "the nearest rotation", frame, nearest
            elif abs(apart) > QUATERNION_ATOL:
                yield f"{place}: q_xyzw", "the quaternion of R", frame, R


def repair_file(path: Path, output: Path, faults: Sequence[Fault], *, overwrite: bool) -> list[str]:
    """Write a repaired copy of a file. Place and words of each repair.

    Raises `InputError` when nothing can be repaired, or the file to write exists.
    """
    if path.is_dir() or (output.exists() and output.resolve() == path.resolve()):
        raise InputError(f"{path}: expected one file, and another one to write")
    done = [f"{fault.place}: {fault.repair}" for fault in faults if fault.repair is not None]
    if not done:
        raise InputError(f"{path}: nothing here has one answer; a person must decide ({len(faults)} faults)")
    record = parse_json(read_bytes(path), path=str(path))
    write_file(output, to_json(repaired_seams(record)), overwrite=overwrite)
    return done
