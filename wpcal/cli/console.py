"""The console on which the commands print their tables."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console
from rich.table import Column, Table

if TYPE_CHECKING:
    from wpcal.core.issue import Issue

FILE_COLUMNS = 120
"""Width of a table in a file or a pipe, which has no width of its own: room for the names of two solids."""
BORDER = 3
"""Characters between two columns of a usual table: a line and a space on both sides."""


class WholeTables(Console):
    """A console that cuts no cell of a table: on a narrow screen words are wrapped, and lines may be longer."""

    def print(self, *objects: Any, **settings: Any) -> None:
        """Print; a table gets columns that hold their longest word."""
        width = self.width
        for table in (each for each in objects if isinstance(each, Table)):
            self.width = max(self.width, _fit(table, width))
        super().print(*objects, **settings)
        self.width = width


def plain_console() -> Console:
    """Return a console on stdout that prints names as they are: ``[b]`` in a solid's name is not markup."""
    wide = not sys.stdout.isatty() and "COLUMNS" not in os.environ
    return WholeTables(markup=False, emoji=False, width=FILE_COLUMNS if wide else None)


def show_notes(issues: Iterable[Issue], console: Console) -> None:
    """Print what is odd, one line each."""
    for issue in issues:
        console.print(f"note: {issue.message}", highlight=False, markup=False)


def _fit(table: Table, width: int) -> int:
    """Give the columns of a table that is too wide their widths. Return the width of the table, 0 if it fits."""
    lines = [[line for text in _texts(column) for line in text.splitlines()] for column in table.columns]
    natural = [max(map(len, column), default=0) for column in lines]
    if not natural or sum(natural) + BORDER * len(natural) + 1 <= width:
        return 0
    least = [max((len(word) for line in column for word in line.split()), default=0) for column in lines]
    table.box, table.padding, table.show_edge = box.SIMPLE_HEAD, (0, 0), False  # one space between two columns
    spaces = len(least) - 1
    spare = max(width - sum(least) - spaces, 0)
    for column, low, high in zip(table.columns, least, natural, strict=True):
        more = min(high - low, spare)
        spare -= more
        column.width, column.no_wrap = low + more, False
    return sum(column.width or 0 for column in table.columns) + spaces


def _texts(column: Column) -> list[str]:
    return [str(column.header), *(str(cell) for cell in column.cells)]
