"""Text tables (CSV) with named columns. Errors name file, line and column.

The reader accepts what spreadsheets write: a byte order mark, CRLF line ends, blank lines, a semicolon or tab as
separator, empty columns at the right, a row of merged cells above the header, and units in brackets (``X [mm]``). How
numbers may be typed is in `wpcal.core.cells`.
"""

from __future__ import annotations

import csv
import difflib
import io
import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wpcal.core.arrays import LARGEST_MM, FloatArray, frozen
from wpcal.core.cells import UNIT_OF_COLUMN, column_name, decimal_sign, number_in_cell
from wpcal.core.csv_text import without_mark
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes
from wpcal.core.numbers import NUMBER
from wpcal.core.wording import listed, printable, shown

SEPARATORS = ";\t,"  #: In order of priority: a header with a semicolon or a tab is not separated by commas.
MOST_COLUMNS = 1000  #: A table with more columns was not written for wpcal.
_PLAIN = re.compile(r"[0-9.eE+\-\n]*+")
MISSPELT = 0.7  #: Similarity above which an unknown column counts as a misspelt one: ``used`` and ``use`` have 0.86.


@dataclass(frozen=True, slots=True)
class Table:
    """The cells of a table as text, column by column."""

    path: str  #: The file as the user named it.
    #: Stripped cells; names in lower case with their units (`wpcal.core.cells.column_name`), in the order of the file.
    columns: dict[str, list[str]]
    lines: tuple[int, ...]  #: Line of each row in the file, counted from 1.
    separator: str

    def __len__(self) -> int:
        return len(self.lines)

    def has(self, *names: str) -> bool:
        """Tell whether the table has all of these columns."""
        return all(name in self.columns for name in names)

    def require(self, names: Sequence[str]) -> None:
        """Refuse a table that lacks one of these columns.

        Raises `FormatError` when a column is missing; the message also lists those that were found.
        """
        missing = [name for name in names if name not in self.columns]
        if missing:
            what = f"missing column {', '.join(missing)}; found {listed(self.columns)}"
            bare = [name for name in missing if UNIT_OF_COLUMN.sub("", name) in self.columns]
            if bare:
                what += f"; write {bare[0]} instead of {UNIT_OF_COLUMN.sub('', bare[0])}: the unit is part of the name"
            raise FormatError(what, path=self.path, line=1)

    def refuse_misspelt(self, known: Sequence[str]) -> None:
        """Refuse a table with a column that looks like a missing known column. Other columns are ignored.

        Raises `FormatError` when there is such a column; the message names both.
        """
        absent = [name for name in known if name not in self.columns]
        for name in self.columns:
            near = [] if name in known else difflib.get_close_matches(name, absent, n=1, cutoff=MISSPELT)
            if near:
                raise FormatError(f"unknown column {shown(name)}; did you mean {near[0]}?", path=self.path, line=1)

    def unique_names(self, column: str) -> tuple[str, ...]:
        """Return names. Raises `FormatError` when one is empty, appears twice or contains a control character."""
        self.require([column])
        seen: dict[str, int] = {}
        for line, name in zip(self.lines, self.columns[column], strict=True):
            if not name:
                raise FormatError("the name is empty", path=self.path, line=line, column=column)
            if printable(name) != name:
                what = f"the name {shown(name)} contains a control character; type the name again"
                raise FormatError(what, path=self.path, line=line, column=column)
            if name in seen:
                what = f"the name {shown(name)} appears twice, first in line {seen[name]}"
                raise FormatError(what, path=self.path, line=line, column=column)
            seen[name] = line
        return tuple(seen)

    def choices(self, column: str, allowed: Sequence[str], *, default: str) -> tuple[str, ...]:
        """Return the words of a column in lower case. An empty cell, or a missing column, gives the default.

        Raises `FormatError` when a word is not allowed.
        """
        if column not in self.columns:
            return (default,) * len(self)
        words = tuple((cell or default).lower() for cell in self.columns[column])
        for line, word in zip(self.lines, words, strict=True):
            if word not in allowed:
                what = f"expected {' or '.join(allowed)}, got {shown(word)}"
                raise FormatError(what, path=self.path, line=line, column=column)
        return words

    def numbers(self, names: Sequence[str]) -> FloatArray:
        """Return columns of finite numbers of at most `LARGEST_MM`, shape (n, k).

        Raises `FormatError` when a column is missing, or a cell is empty, not a number, NaN, infinite or has an
        ambiguous decimal sign.
        """
        self.require(names)
        values = np.empty((len(self), len(names)))
        slow = [j for j, name in enumerate(names) if not _all_plain(self.columns[name], values[:, j])]
        decimal = self.decimal_sign(names) if slow else "."
        for j in slow if decimal == "." else range(len(names)):
            for i, cell in enumerate(self.columns[names[j]]):
                try:
                    values[i, j] = number_in_cell(cell, column=names[j], decimal=decimal)
                except InputError as error:
                    raise FormatError(str(error), path=self.path, line=self.lines[i], column=names[j]) from None
        return frozen(values)

    def numbers_where_given(self, names: Sequence[str]) -> FloatArray:
        """Return columns of numbers, NaN in rows whose cells of all these columns are empty; as `numbers` otherwise."""
        self.require(names)
        given = [i for i in range(len(self)) if any(self.columns[name][i] for name in names)]
        columns = {name: [cells[i] for i in given] for name, cells in self.columns.items()}
        values = np.full((len(self), len(names)), math.nan)
        values[given] = Table(self.path, columns, tuple(self.lines[i] for i in given), self.separator).numbers(names)
        return frozen(values)

    def decimal_sign(self, names: Sequence[str]) -> str:
        """Return the decimal sign of columns of numbers: a point or a comma."""
        cells = (cell for name in names for cell in self.columns[name])
        return decimal_sign(cells, comma_separates=self.separator == ",")


def read_table(path: Path) -> Table:
    """Read a text table with a header line.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when it is not UTF-8 text, is of another kind or empty, has no rows, has a column twice, or has
    a row of another length than the header.
    """
    return parse_table(read_bytes(path), path=str(path))


#: How a file begins that is not a table.
NULS = 0.25  #: Of UTF-16 text, about half of the characters are NUL when it is read as UTF-8.
OTHER_KINDS = {"ISO-10303-21": "a STEP", "{": "a JSON", "[": "a JSON", "<": "an XML or HTML", "%PDF": "a PDF"}
SPREADSHEET_MARK = b"PK\x03\x04"  #: Spreadsheets of today are ZIP archives.


def _text_of(raw: bytes, path: str) -> str:
    """Return the text of a table; a file of another kind is named."""
    if raw.startswith(SPREADSHEET_MARK):
        raise FormatError("is a spreadsheet (or another ZIP archive): save the sheet as CSV", path=path)
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError(f"is not UTF-8 text (byte {error.start}): save it as CSV UTF-8", path=path) from None
    if not text.strip():
        raise FormatError("the file is empty; expected a header line and rows", path=path)
    if text.count("\0") > NULS * len(text):
        raise FormatError("is UTF-16 text or not a text (it has NUL characters): save it as CSV UTF-8", path=path)
    for start, kind in OTHER_KINDS.items():
        if text.lstrip().startswith(start):
            raise FormatError(f"is {kind} file, expected a table with a header line; are two files swapped?", path=path)
    return text


def parse_table(raw: bytes, *, path: str) -> Table:
    """Return the table that the bytes of a file hold; errors as in `read_table`."""
    text = _text_of(raw, path)
    first = text.lstrip().split("\n", 1)[0]
    separator = next((mark for mark in SEPARATORS if mark in first), ",")
    lines, rows = _rows(text, separator, path)
    if not rows:
        raise FormatError("all cells are empty; expected a header line and rows", path=path)
    lines, rows = _without_merged_cells(lines, _without_empty_columns(rows))
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


def _without_empty_columns(rows: list[list[str]]) -> list[list[str]]:
    """Drop the columns at the right that are empty in every row: a spreadsheet keeps them after a deletion."""
    used = max(next((k for k in range(len(row), 0, -1) if row[k - 1].strip()), 0) for row in rows)
    return [row[:used] if len(row) > used else row for row in rows]


def _without_merged_cells(lines: list[int], rows: list[list[str]]) -> tuple[list[int], list[list[str]]]:
    """Drop the row above the header that merged cells leave: it has empty cells, and the next row names all columns."""
    if len(rows) < 3 or len(rows[0]) < 2 or all(cell.strip() for cell in rows[0]):
        return lines, rows
    names = [cell.strip() for cell in rows[1]]
    if "" in names or len(set(names)) < len(names) or any(NUMBER.fullmatch(name) for name in names):
        return lines, rows
    return lines[1:], rows[1:]


def _header(cells: Sequence[str], path: str, line: int) -> list[str]:
    if len(cells) > MOST_COLUMNS:
        raise FormatError(f"has {len(cells)} columns, expected at most {MOST_COLUMNS}", path=path, line=line)
    header = [column_name(without_mark(cell.strip())) for cell in cells]
    empty = [str(number) for number, name in enumerate(header, start=1) if not name]
    if empty:
        what = f"column {', '.join(empty)} has no name; write one row with a name for each column"
        raise FormatError(what, path=path, line=line)
    twice = [name for name, count in Counter(header).items() if count > 1]
    if twice:
        raise FormatError(f"column {listed(sorted(map(repr, twice)))} appears twice", path=path, line=line)
    return header


def _wrong_length(row: Sequence[str], header: Sequence[str], separator: str) -> str:
    what = f"expected {len(header)} cells, got {len(row)}"
    if separator == "," and len(row) > len(header):
        what += "; a decimal comma needs ; between the cells, or write 1.5"
    if len(row) < len(header):
        what += f"; an empty cell needs its {'tab' if separator == SEPARATORS[1] else separator} too"
    return what


def _all_plain(cells: Sequence[str], values: FloatArray) -> bool:
    """Read cells that hold plain numbers, all at once, into `values`. False if one of them needs a closer look."""
    if not _PLAIN.fullmatch("\n".join(cells)):
        return False
    try:
        values[:] = np.array(cells, dtype=np.float64)
    except ValueError:
        return False
    return bool((np.abs(values) <= LARGEST_MM).all())
