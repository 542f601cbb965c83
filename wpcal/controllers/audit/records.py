"""Audit JSON records: every value that its schema or its reader refuses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from wpcal.controllers.audit.fault import Fault
from wpcal.controllers.audit.repair import repairs_of_seams
from wpcal.core.errors import WpcalError
from wpcal.core.record_check import check_record, find_faults
from wpcal.core.records import parse_json
from wpcal.core.schemas import has_schema
from wpcal.core.wording import shown
from wpcal.planning.cell.cell_file import read_cell
from wpcal.results.folder import RECORD_SCHEMAS
from wpcal.robot.kinematics.arm_file import ARM_SCHEMA, read_arm
from wpcal.robot.torch.file import CELL_SCHEMA
from wpcal.seam.record import SEAMS_SCHEMA, seams_from_record
from wpcal.seam.record_check import seam_faults
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
    except WpcalError as error:
        if name == SEAMS_SCHEMA:
            with suppress(KeyError):  # a field is missing, which the error says
                repairs = repairs_of_seams(record)
                return [Fault(what, field=place, repair=repairs.get(place)) for place, what in seam_faults(record)]
        return [Fault.of(error, str(path))]
    return []
