"""The table in the page: cells of text, exactly as they go into the file and come out of it."""

from __future__ import annotations

import csv
import io
import re
from dataclasses import dataclass
from typing import Any

from wpcal.core.errors import FormatError, InputError
from wpcal.core.tables import Table, parse_table
from wpcal.taught.columns import MODEL_COLUMNS, TAUGHT_COLUMNS

NEW_COLUMNS = ("name", *TAUGHT_COLUMNS, "feature", "use")
"""Of a table that begins empty."""
MOST_ROWS = 10_000
"""More is no list of touched points, but another file."""
LONGEST_CELL = 1000
"""Characters; a name or a remark is no text, and messages repeat it."""
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+")


@dataclass(frozen=True, slots=True)
class Rows:
    """A table of taught points under the hands of a person: a row may still lack its coordinates.

    Parameters
    ----------
    columns : tuple of str
        As in a file of taught points (`wpcal.match.read_taught`), others as well.
    cells : tuple of tuple of str
        Row by row.
    """

    columns: tuple[str, ...] = NEW_COLUMNS
    cells: tuple[tuple[str, ...], ...] = ()

    @classmethod
    def from_record(cls, record: Any) -> Rows:
        """Return the rows that a page sent.

        Raises
        ------
        InputError
            When it is no table of texts with the columns of taught points.
        """
        try:
            columns = tuple(record["columns"])
            cells = tuple(tuple(" ".join(cell.split()) for cell in row) for row in record["rows"])
        except (KeyError, TypeError, AttributeError) as error:
            raise InputError(f"expected columns and rows of text: {type(error).__name__} {error}") from None
        missing = [name for name in ("name", *TAUGHT_COLUMNS) if name not in columns]
        if missing or any(not isinstance(name, str) for name in columns) or len(set(columns)) < len(columns):
            raise InputError(f"expected columns with different names, {', '.join(NEW_COLUMNS)} and others")
        if any(len(cell) > LONGEST_CELL for row in cells for cell in row):
            raise InputError(f"expected cells of at most {LONGEST_CELL} characters")
        if len(cells) > MOST_ROWS or any(len(row) != len(columns) for row in cells):
            raise InputError(f"expected at most {MOST_ROWS} rows of {len(columns)} cells each")
        return cls(columns, cells)

    def to_record(self) -> dict[str, Any]:
        """Return plain values for the page."""
        return {"columns": list(self.columns), "rows": [list(row) for row in self.cells]}

    def complete(self) -> tuple[int, ...]:
        """Return the rows that have all three coordinates."""
        places = [self.columns.index(name) for name in TAUGHT_COLUMNS]
        return tuple(i for i, row in enumerate(self.cells) if all(row[place] for place in places))

    def to_csv(self) -> str:
        """Return the complete rows as the file that `wpcal calibrate` reads; line 2 is the first of them."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows(self.cells[i] for i in self.complete())
        return text.getvalue()


def read_rows(raw: bytes, *, path: str) -> Rows:
    """Return the rows of a table of taught points, ready for a person to go on with.

    Columns that the page works with are added: `use`, and `feature` where the names of the rows are those of features.

    Parameters
    ----------
    raw : bytes
        Of a file.
    path : str
        What messages call it.

    Raises
    ------
    FormatError
        When it is no table, or lacks a column of taught points.
    """
    table = parse_table(raw, path=path)
    table.require(("name", *TAUGHT_COLUMNS))
    if len(table) > MOST_ROWS:
        raise FormatError(f"expected at most {MOST_ROWS} rows, got {len(table)}", path=path)
    columns = {name: [_with_point(cell, table) for cell in cells] for name, cells in table.columns.items()}
    if "feature" not in columns and not table.has(*MODEL_COLUMNS):
        kinds = columns.get("kind", [""] * len(table))
        own = [name if kind.lower() in ("", "point") else "" for name, kind in zip(columns["name"], kinds, strict=True)]
        columns["feature"] = own
    columns.setdefault("use", ["yes"] * len(table))
    return Rows(tuple(columns), tuple(zip(*columns.values(), strict=True)))


def _with_point(cell: str, table: Table) -> str:
    """Write a decimal comma as a point where the cells were not separated by commas: in the page they are."""
    return cell.replace(",", ".") if table.separator != "," and _DECIMAL_COMMA.fullmatch(cell) else cell
