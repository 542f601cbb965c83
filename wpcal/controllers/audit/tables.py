"""Audit text tables and other files that are read line by line: every line that a reader refuses."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from wpcal.controllers.audit.fault import Fault
from wpcal.core.errors import FormatError, WpcalError
from wpcal.core.tables import parse_table, read_table
from wpcal.taught.columns import TAUGHT_COLUMNS
from wpcal.taught.pairs import REAL_COLUMNS, read_pairs
from wpcal.taught.table import read_taught
from wpcal.touch.grasp import BASE1_COLUMNS, BASE2_COLUMNS, read_base_points

MOST_FAULTS = 50  #: Faults that are listed per file; with more, the file is of another kind or has another separator.
UNITS = ("_mm", "_deg", "_rad", "_s", "_mm_s", "_mm2")  #: Ends of the names of columns that hold numbers.


class TableKind(NamedTuple):
    """A kind of table: what it is, the columns that tell it, its reader, and whether it may have no rows."""

    kind: str
    columns: Sequence[str]
    read: Callable[[Path], object]
    may_have_no_rows: bool = False


def read_numbers(path: Path) -> None:
    """Read every column whose name ends with a unit; a cell may be empty where wpcal knows no value."""
    table = read_table(path)
    for name in table.columns:
        if name.endswith(UNITS):
            table.numbers_where_given([name])


def read_job_files(path: Path, folder: Path | None = None) -> None:
    """Read a list of jobs: its numbers, and whether the files that its rows name are there.

    `folder`: From which files are named; that of the list if None.
    Raises `FormatError` with the line of the first one that is not.
    """
    read_numbers(path)
    table = read_table(path)
    for row, line in enumerate(table.lines):
        for column in ("part", "taught"):
            name = table.columns[column][row]
            if not name or not ((folder or path.parent) / name).exists():
                what = f"{name}: no such file or directory" if name else "names no file"
                raise FormatError(what, path=str(path), line=line, column=column)


TAUGHT = TableKind("taught points", ("name", *TAUGHT_COLUMNS), read_taught)
TABLES = (
    TableKind("summary of a batch", ("job", "verdict", "seconds", "error"), read_numbers),
    TableKind("jobs of a batch", ("job", "part", "taught"), read_job_files),
    TableKind("point pairs", REAL_COLUMNS, read_pairs),
    TableKind("points touched by two robots", (*BASE1_COLUMNS, *BASE2_COLUMNS), read_base_points),
    TableKind("frames of seams", ("seam", "point", "s_mm"), read_numbers, may_have_no_rows=True),
    TableKind("measured poses or joint angles", ("q1_deg",), read_numbers),
    TAUGHT,
)
"""A table is of the first kind of whose columns it has all, or all but one."""


def audit_table(raw: bytes, path: Path, *, is_named: bool) -> tuple[str, list[Fault]] | None:
    """Return the kind of a table and its faults; None for a table of another program."""
    found = _kind_of(raw) or (TAUGHT if is_named else None)
    if found is not None and found.may_have_no_rows and len(raw.split()) == 1:  # only the header: a part without seams
        return found.kind, []
    if found is TAUGHT and _is_form(raw, path):
        return f"{found.kind}, to be filled in", faults_by_line(raw, path, read_numbers)
    if found is None:
        return None
    read = partial(read_job_files, folder=path.parent) if found.read is read_job_files else found.read
    return found.kind, faults_by_line(raw, path, read)


def _is_form(raw: bytes, path: Path) -> bool:
    """Tell whether no row of a taught table has a coordinate yet, as `wpcal touches` writes it."""
    try:
        table = parse_table(raw, path=str(path))
    except WpcalError:
        return False
    touched = [cell for name in ("x_mm", "y_mm", "z_mm") for cell in table.columns.get(name, ("unknown",))]
    return len(table) > 0 and not any(touched)


def _kind_of(raw: bytes) -> TableKind | None:
    """Return the kind that the names of the columns tell; a table in which one is misspelt is still of its kind."""
    header = next((line for line in raw.decode("utf-8-sig", "replace").split("\n") if line.strip(" ;,\t\r")), "")
    words = {word.strip(' "\r').lower() for word in re.split(r"[;,\t]", header)}
    for kind in TABLES:
        if len(words.intersection(kind.columns)) >= max(1, len(kind.columns) - 1):
            return kind
    return TableKind("numbers", (), read_numbers) if any(word.endswith(UNITS) for word in words) else None


def faults_by_line(raw: bytes, path: Path, read: Callable[[Path], object]) -> list[Fault]:
    """Return what a reader refuses: it reads again without each line that it named, until it names none.

    Returns: At most `MOST_FAULTS`. What names no cell is told only if it is the first: missing lines can cause it.
    """
    lines, faults = raw.split(b"\n"), list[Fault]()
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / path.name
        while len(faults) < MOST_FAULTS:
            copy.write_bytes(b"\n".join(lines))
            try:
                read(copy)
            except WpcalError as error:
                fault = Fault.of(error, str(copy))
            else:
                break
            is_of_a_line = fault.line is not None and fault.line <= len(lines) and lines[fault.line - 1].strip() != b""
            if faults and (not is_of_a_line or fault.column is None):
                break
            faults.append(fault)
            if not is_of_a_line or fault.line is None:
                break
            lines[fault.line - 1] = b""
    return sorted(faults, key=lambda fault: fault.line or 0)
