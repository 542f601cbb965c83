"""Text tables (CSV) with named columns. Errors name file, line and column.

The reader accepts a byte order mark, CRLF line ends, blank lines, and a semicolon or tab as separator. It accepts a
decimal comma if the separator is not a comma and no number of the table has a point.
"""

from __future__ import annotations

import csv
import difflib
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wpcal.core.arrays import LARGEST_MM, FloatArray, frozen
from wpcal.core.csv_text import without_mark
from wpcal.core.errors import FormatError
from wpcal.core.records import read_bytes

SEPARATORS = ";\t,"
"""In order of priority: a header with a semicolon or a tab is not separated by commas."""
MISSPELT = 0.7
"""Similarity above which an unknown column counts as a misspelt one: ``used`` and ``use`` have 0.86."""


@dataclass(frozen=True, slots=True)
class Table:
    """The cells of a table as text, column by column.

    Parameters
    ----------
    path : str
        The file as the user named it.
    columns : dict of str to list of str
        Stripped cells; names in lower case, in the order of the file.
    lines : tuple of int
        Line of each row in the file, counted from 1.
    separator : str
    """

    path: str
    columns: dict[str, list[str]]
    lines: tuple[int, ...]
    separator: str

    def __len__(self) -> int:
        return len(self.lines)

    def has(self, *names: str) -> bool:
        """Tell whether the table has all of these columns."""
        return all(name in self.columns for name in names)

    def require(self, names: Sequence[str]) -> None:
        """Refuse a table that lacks one of these columns.

        Raises
        ------
        FormatError
            When a column is missing; the message also lists those that were found.
        """
        missing = [name for name in names if name not in self.columns]
        if missing:
            what = f"missing column {', '.join(missing)}; found {', '.join(self.columns)}"
            raise FormatError(what, path=self.path, line=1)

    def refuse_misspelt(self, known: Sequence[str]) -> None:
        """Refuse a table with a column that looks like a missing known column. Other columns are ignored.

        Raises
        ------
        FormatError
            When there is such a column; the message names both.
        """
        absent = [name for name in known if name not in self.columns]
        for name in self.columns:
            near = [] if name in known else difflib.get_close_matches(name, absent, n=1, cutoff=MISSPELT)
            if near:
                raise FormatError(f"unknown column {name!r}; did you mean {near[0]}?", path=self.path, line=1)

    def unique_names(self, column: str) -> tuple[str, ...]:
        """Return the cells of a column of names.

        Raises
        ------
        FormatError
            When a cell is empty or appears twice.
        """
        self.require([column])
        seen: dict[str, int] = {}
        for line, name in zip(self.lines, self.columns[column], strict=True):
            if not name:
                raise FormatError("the name is empty", path=self.path, line=line, column=column)
            if name in seen:
                what = f"the name {name!r} appears twice, first in line {seen[name]}"
                raise FormatError(what, path=self.path, line=line, column=column)
            seen[name] = line
        return tuple(seen)

    def choices(self, column: str, allowed: Sequence[str], *, default: str) -> tuple[str, ...]:
        """Return the words of a column in lower case. An empty cell, or a missing column, gives the default.

        Raises
        ------
        FormatError
            When a word is not allowed.
        """
        if column not in self.columns:
            return (default,) * len(self)
        words = tuple((cell or default).lower() for cell in self.columns[column])
        for line, word in zip(self.lines, words, strict=True):
            if word not in allowed:
                what = f"expected {' or '.join(allowed)}, got {word!r}"
                raise FormatError(what, path=self.path, line=line, column=column)
        return words

    def numbers(self, names: Sequence[str]) -> FloatArray:
        """Return columns of finite numbers of at most `LARGEST_MM`.

        Parameters
        ----------
        names : sequence of str
            k columns.

        Returns
        -------
        ndarray, shape (n, k)

        Raises
        ------
        FormatError
            When a column is missing, or a cell is empty, not a number, NaN, infinite or has an ambiguous decimal sign.
        """
        self.require(names)
        values = np.empty((len(self), len(names)))
        comma = self.separator != "," and self._has_decimal_comma_only(names)
        for j, name in enumerate(names):
            cells = [cell.replace(",", ".") for cell in self.columns[name]] if comma else self.columns[name]
            try:
                values[:, j] = np.array(cells, dtype=np.float64)
            except ValueError:
                values[:, j] = math.nan
            if not (np.abs(values[:, j]) <= LARGEST_MM).all():  # NaN is not, either
                self._refuse(name, cells)
        return frozen(values)

    def numbers_where_given(self, names: Sequence[str]) -> FloatArray:
        """Return columns of numbers, NaN in rows whose cells of all these columns are empty; as `numbers` otherwise."""
        self.require(names)
        given = [i for i in range(len(self)) if any(self.columns[name][i] for name in names)]
        columns = {name: [cells[i] for i in given] for name, cells in self.columns.items()}
        values = np.full((len(self), len(names)), math.nan)
        values[given] = Table(self.path, columns, tuple(self.lines[i] for i in given), self.separator).numbers(names)
        return frozen(values)

    def _has_decimal_comma_only(self, names: Sequence[str]) -> bool:
        cells = [cell for name in names for cell in self.columns[name]]
        most = max((cell.count(",") for cell in cells), default=0)
        return most == 1 and not any("." in cell for cell in cells)

    def _refuse(self, name: str, cells: Sequence[str]) -> None:
        for line, cell in zip(self.lines, cells, strict=True):
            what = _fault(cell)
            if what:
                raise FormatError(what, path=self.path, line=line, column=name)


def read_table(path: Path) -> Table:
    """Read a text table with a header line.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Table

    Raises
    ------
    InputError
        When the file cannot be opened.
    FormatError
        When it is not UTF-8 text, is a STEP file or empty, has no rows, has a column twice, or has a row of another
        length than the header.
    """
    return parse_table(read_bytes(path), path=str(path))


def parse_table(raw: bytes, *, path: str) -> Table:
    """Return the table that the bytes of a file hold; errors as in `read_table`.

    Parameters
    ----------
    raw : bytes
    path : str
        Name of the file in messages.
    """
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError(f"is not a UTF-8 text file (byte {error.start})", path=path) from None
    if not text.strip():
        raise FormatError("the file is empty; expected a header line and one row per point", path=path)
    if text.lstrip().startswith("ISO-10303-21"):
        raise FormatError("is a STEP file, expected a table with a header line; are two files swapped?", path=path)
    separator = _separator(text.lstrip().splitlines()[0])
    lines, rows = _rows(text, separator, path)
    header = _header(rows[0], path, lines[0])
    if len(rows) == 1:
        raise FormatError("has a header and no rows", path=path)
    for line, row in zip(lines[1:], rows[1:], strict=True):
        if len(row) != len(header):
            raise FormatError(
                _wrong_length(row, header, separator), path=path, line=line, column=min(len(row), len(header))
            )
    columns = {
        name: [without_mark(cell.strip()) for cell in cells]
        for name, cells in zip(header, zip(*rows[1:], strict=True), strict=True)
    }
    return Table(path, columns, tuple(lines[1:]), separator)


def _separator(header: str) -> str:
    return next((mark for mark in SEPARATORS if mark in header), ",")


def _rows(text: str, separator: str, path: str) -> tuple[list[int], list[list[str]]]:
    reader = csv.reader(io.StringIO(text), delimiter=separator, strict=True)
    lines, rows = [], []
    try:
        for row in reader:
            if any(cell.strip() for cell in row):
                lines.append(reader.line_num)
                rows.append(row)
    except csv.Error as error:
        raise FormatError(f"is not a readable table: {error}", path=path, line=reader.line_num) from None
    return lines, rows


def _header(cells: Sequence[str], path: str, line: int) -> list[str]:
    header = [without_mark(cell.strip()).lower() for cell in cells]
    twice = sorted({name for name in header if header.count(name) > 1})
    if twice:
        raise FormatError(f"column {', '.join(map(repr, twice))} appears twice", path=path, line=line)
    return header


def _wrong_length(row: Sequence[str], header: Sequence[str], separator: str) -> str:
    what = f"expected {len(header)} cells, got {len(row)}"
    if separator == "," and len(row) > len(header):
        what += "; a decimal comma needs ; between the cells, or write 1.5"
    return what


def _fault(cell: str) -> str | None:
    """Say why a cell is not a finite number; None if it is one."""
    if not cell:
        return "the cell is empty, expected a number"
    if "," in cell:
        return f"{cell!r}: it is unclear whether the comma is a decimal sign; write a decimal point in every number"
    try:
        value = float(cell)
    except ValueError:
        return f"expected a number, got {cell!r}"
    if not math.isfinite(value):
        return f"expected a finite number, got {cell!r}"
    return None if abs(value) <= LARGEST_MM else f"expected a number of at most {LARGEST_MM:g}, got {cell!r}"
