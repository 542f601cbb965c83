"""The table of rules that gives a weld its values where nobody states them: by joint, weld, thickness and position.

The table is a TOML file (`rules.toml`); a file of the user replaces it as a whole. Every row has a source or a reason.
"""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes
from wpcal.core.record_check import check_record
from wpcal.seam.seam import JointType, WeldType
from wpcal.weld.values import VALUE_NAMES, refuse_unknown

RULES_SCHEMA = "wpcal/weld-rules/1"
SHIPPED = "rules.toml"
_ROW_NAMES = ("name", "source", "joint", "weld", "position", "thickness_mm", "values", "bead_mm2", "most_bead_mm2")


@dataclass(frozen=True, slots=True)
class Case:
    """What the rules ask of a seam."""

    joint: JointType
    weld: WeldType
    thickness_mm: float | None  #: Of the thinner plate; None if it is not known.
    position: str | None  #: ``PA`` … ``PG``.


@dataclass(frozen=True, slots=True)
class Row:
    """One row of the table."""

    name: str
    source: str
    #: `joint`, `weld`, `position`: Empty: any.
    joint: tuple[str, ...] = ()
    weld: tuple[str, ...] = ()
    position: tuple[str, ...] = ()
    #: Above the first and up to the second; None: any, also one that is not known.
    thickness_mm: tuple[float, float] | None = None
    values: Mapping[str, Any] = field(default_factory=dict)  #: Names of `WeldValues` and what they are.
    bead_mm2: float | None = None  #: Section of the bead for which the speed of the row holds.
    most_bead_mm2: float | None = None  #: Largest section of one bead.

    def applies_to(self, case: Case) -> bool:
        """Tell whether all conditions of the row hold."""
        if self.thickness_mm is not None:
            low, high = self.thickness_mm
            if case.thickness_mm is None or not low < case.thickness_mm <= high:
                return False
        pairs = ((self.joint, case.joint.value), (self.weld, case.weld.value), (self.position, case.position))
        return all(not allowed or value in allowed for allowed, value in pairs)


@dataclass(frozen=True, slots=True)
class RuleTable:
    """Rows in the order of priority."""

    rows: tuple[Row, ...]
    file: str = ""  #: As the user named it; empty for the table of wpcal.

    def values_for(self, case: Case) -> dict[str, tuple[Any, Row]]:
        """Return every value that a row states for a case, with the first row that applies and states it."""
        found: dict[str, tuple[Any, Row]] = {}
        for row in self.rows:
            if row.applies_to(case):
                for name, value in row.values.items():
                    found.setdefault(name, (value, row))
        return found

    def most_bead(self, case: Case) -> tuple[float, Row] | None:
        """Return the largest section of one bead, mm², and the row that states it."""
        rows = (row for row in self.rows if row.most_bead_mm2 is not None and row.applies_to(case))
        return next(((row.most_bead_mm2, row) for row in rows if row.most_bead_mm2 is not None), None)


@cache
def shipped_rules() -> RuleTable:
    """Return the table of wpcal."""
    return _parsed(shipped_text().encode(), path=SHIPPED, file="")


def shipped_text() -> str:
    """Return the text of the table of wpcal, for users who change a copy of it."""
    return files(__package__).joinpath(SHIPPED).read_text(encoding="utf-8")


def read_rules(path: Path) -> RuleTable:
    """Read a table of the user.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when it is not TOML, a value is not what its name says, a name is unknown, or a row has no
    source.
    """
    return _parsed(read_bytes(path), path=str(path), file=str(path))


def _parsed(raw: bytes, *, path: str, file: str) -> RuleTable:
    try:
        record = tomllib.loads(raw.decode("utf-8-sig"))
    except UnicodeDecodeError:
        raise FormatError("is not a UTF-8 text file", path=path) from None
    except (ValueError, RecursionError) as error:  # also of a number with thousands of digits
        raise FormatError(f"is not TOML: {error}", path=path) from None
    if record.get("schema") != RULES_SCHEMA:
        raise FormatError(f'expected schema = "{RULES_SCHEMA}" in the first lines', path=path)
    check_record(record, RULES_SCHEMA, path=path, is_complete=True)
    try:
        refuse_unknown(record, ("schema", "rules"), what="the table")
        rows = tuple(_row(row) for row in record["rules"])
        _refuse_twice(rows)
    except InputError as error:
        raise FormatError(str(error), path=path) from None
    return RuleTable(rows, file)


def _row(record: Mapping[str, Any]) -> Row:
    what = f"rule {record['name']}"
    refuse_unknown(record, _ROW_NAMES, what=what)
    values = record.get("values", {})
    refuse_unknown(values, VALUE_NAMES, what=what)
    if {"throat_mm", "leg_mm"} <= values.keys():
        raise InputError(f"{what}: gives throat_mm and leg_mm; expected one of the two")
    limits = record.get("thickness_mm")
    if limits is not None and not limits[0] < limits[1]:
        raise InputError(f"{what}: thickness_mm: expected two numbers that rise, got {limits}")
    return Row(
        record["name"],
        record["source"],
        tuple(record.get("joint", ())),
        tuple(record.get("weld", ())),
        tuple(record.get("position", ())),
        None if limits is None else (float(limits[0]), float(limits[1])),
        values,
        record.get("bead_mm2"),
        record.get("most_bead_mm2"),
    )


def _refuse_twice(rows: Sequence[Row]) -> None:
    seen: set[str] = set()
    for row in rows:
        if row.name in seen:
            raise InputError(f"two rules are named {row.name!r}; expected a name per rule")
        seen.add(row.name)
