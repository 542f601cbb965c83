"""The table in the page: cells of text, exactly as in the file."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from typing import Any

from wpcal.core.csv_text import csv_text
from wpcal.core.errors import FormatError, InputError
from wpcal.core.tables import Table, parse_table
from wpcal.taught.columns import MODEL_COLUMNS, TAUGHT_COLUMNS
from wpcal.taught.table import TaughtPoints, taught_from_table

NEW_COLUMNS = ("name", *TAUGHT_COLUMNS, "feature", "use")  #: Columns of an empty table.
MOST_ROWS = 10_000  #: A file with more rows is not a list of touched points.
LONGEST_CELL = 1000  #: Characters. Messages repeat the text of a cell.
NO_FILE = ""  #: Rows in the page have no file. Messages about them begin with the row.
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+")


@dataclass(frozen=True, slots=True)
class Rows:
    """A table of taught points while a person edits it: rows may still lack coordinates."""

    #: As in a file of taught points (`wpcal.taught.table.read_taught`). Others are allowed.
    columns: tuple[str, ...] = NEW_COLUMNS
    cells: tuple[tuple[str, ...], ...] = ()  #: Row by row.

    @classmethod
    def from_record(cls, record: Any) -> Rows:
        """Return the rows that a page sent.

        Raises `InputError` when it is not a table of text with the columns of taught points.
        """
        try:
            columns = tuple(record["columns"])
            cells = tuple(tuple(" ".join(cell.split()) for cell in row) for row in record["rows"])
        except (KeyError, TypeError, AttributeError) as error:
            raise InputError(f"expected columns and rows of text: {type(error).__name__} {error}") from None
        _check_columns(columns)
        _check_cells(cells, width=len(columns))
        return cls(columns, cells)

    def to_record(self) -> dict[str, Any]:
        """Return plain values for the page."""
        return {"columns": list(self.columns), "rows": [list(row) for row in self.cells]}

    def complete(self) -> tuple[int, ...]:
        """Return the numbers of the rows that have all three coordinates."""
        places = [self.columns.index(name) for name in TAUGHT_COLUMNS]
        return tuple(i for i, row in enumerate(self.cells) if all(row[place] for place in places))

    def to_csv(self) -> str:
        """Return the complete rows as the file that `wpcal calibrate` reads. The first of them is on line 2."""
        return csv_text([self.columns, *(self.cells[i] for i in self.complete())])

    def to_taught(self) -> TaughtPoints:
        """Return the complete rows as taught points, exactly as `wpcal calibrate` reads them from the saved file.

        Raises `InputError` when no row is complete.
        Raises `FormatError` when a cell cannot be read. Its line is 2 for the first complete row.
        """
        if not self.complete():
            raise InputError("no row has all three coordinates")
        return taught_from_table(parse_table(self.to_csv().encode("utf-8"), path=NO_FILE))


def _check_columns(columns: tuple[object, ...]) -> None:
    is_text = all(isinstance(name, str) and is_shown(name) for name in columns)
    if not is_text or len(set(columns)) < len(columns) or not {"name", *TAUGHT_COLUMNS} <= set(columns):
        raise InputError(f"expected columns with different names, {', '.join(NEW_COLUMNS)} and others")


def is_shown(text: str) -> bool:
    """Tell whether a text has no control characters: NUL, escape and others that a terminal would obey."""
    return not any(unicodedata.category(character) == "Cc" for character in text)


def _check_cells(cells: tuple[tuple[str, ...], ...], *, width: int) -> None:
    for number, row in enumerate(cells, 1):
        for cell in row:
            if not is_shown(cell):
                raise InputError(f"row {number}: {cell!r} contains a control character; type the cell again")
    if any(len(cell) > LONGEST_CELL for row in cells for cell in row):
        raise InputError(f"expected cells of at most {LONGEST_CELL} characters")
    if len(cells) > MOST_ROWS or any(len(row) != width for row in cells):
        raise InputError(f"expected at most {MOST_ROWS} rows of {width} cells each")


def read_rows(raw: bytes, *, path: str) -> Rows:
    """Return the rows of a table of taught points, ready for editing in the page.

    Columns that the page needs are added: `use`, and `feature` if the names of the rows are names of features.

    Raises `FormatError` when it is not a table, or lacks a column of taught points.
    """
    table = parse_table(raw, path=path)
    table.require(("name", *TAUGHT_COLUMNS))
    _check_shown(table)
    if len(table) > MOST_ROWS:
        raise FormatError(f"expected at most {MOST_ROWS} rows, got {len(table)}", path=path)
    columns = {name: [_with_point(cell, table) for cell in cells] for name, cells in table.columns.items()}
    if "feature" not in columns and not table.has(*MODEL_COLUMNS):
        kinds = columns.get("kind", [""] * len(table))
        own = [name if kind.lower() in ("", "point") else "" for name, kind in zip(columns["name"], kinds, strict=True)]
        columns["feature"] = own
    columns.setdefault("use", ["yes"] * len(table))
    return Rows(tuple(columns), tuple(zip(*columns.values(), strict=True)))


def _check_shown(table: Table) -> None:
    for name, cells in table.columns.items():
        if not is_shown(name):
            raise FormatError(f"column {name!r} contains a control character", path=table.path, line=1)
        for line, cell in zip(table.lines, cells, strict=True):
            if not is_shown(" ".join(cell.split())):
                what = f"{cell!r} contains a control character; expected text"
                raise FormatError(what, path=table.path, line=line, column=name)


def _with_point(cell: str, table: Table) -> str:
    """Turn a decimal comma into a point, unless commas separate the cells of the file; they do in the page."""
    cell = " ".join(cell.split())
    return cell.replace(",", ".") if table.separator != "," and _DECIMAL_COMMA.fullmatch(cell) else cell
