"""Text tables that are safe in a spreadsheet: no cell of text is taken for a formula.

A spreadsheet runs a cell that begins with ``=``, ``+``, ``-`` or ``@``, and a name from a STEP file or a robot program
may begin so. Such a text gets an apostrophe in front, the mark of a text in every spreadsheet. Numbers stay as they
are. `wpcal.core.tables` takes the apostrophe away again, so what is read is what was written.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

_FORMULA = re.compile(r"'*[=+\-@\t\r\n＝＋－＠]")
"""How a formula begins, also in the wide letters of Japanese spreadsheets; or a text that already got apostrophes."""
_MARKED = re.compile(r"'+[=+\-@\t\r\n＝＋－＠]")
_SPECIAL = re.compile(r'[",\r\n]')
_NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?")


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as the text of a CSV file, the header first."""
    return "".join(f"{','.join(map(cell_text, row))}\n" for row in rows)


def cell_text(cell: object) -> str:
    """Return a number or a text as a cell of a CSV file."""
    text = "" if cell is None else str(cell)
    if isinstance(cell, str) and _FORMULA.match(cell) and not _NUMBER.fullmatch(cell):
        text = f"'{cell}"
    return '"{}"'.format(text.replace('"', '""')) if _SPECIAL.search(text) else text


def without_mark(cell: str) -> str:
    """Return the text of a cell as it was given to `csv_text`.

    >>> without_mark("'=V2"), without_mark("-2.5"), without_mark("'s")
    ('=V2', '-2.5', "'s")
    """
    return cell[1:] if _MARKED.match(cell) else cell
