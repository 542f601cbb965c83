"""The console on which the commands print their tables."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from typing import IO, TYPE_CHECKING, Any, cast

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from wpcal.cli.streams import PrintableText
from wpcal.core.wording import printable

if TYPE_CHECKING:
    from wpcal.core.issue import Issue

FILE_COLUMNS = 120
"""Width of a table in a file or a pipe, which has no width of its own: room for the names of two solids."""
BORDER = 3  #: Characters between two columns of a usual table: a line and a space on both sides.


class PlainConsole(Console):
    """A console that prints names as they are: ``[b]`` is not markup, and control characters are shown as escapes.

    It cuts no cell of a table: on a narrow screen words are wrapped, and where that is not enough lines are longer.
    """

    def print(self, *objects: Any, **settings: Any) -> None:
        """Print; a table gets columns that hold their longest word."""
        width = self.width
        for table in (each for each in objects if isinstance(each, Table)):
            self.width = max(self.width, _fit(table, width))
        super().print(*objects, **settings)
        self.width = width

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a text, for example a cell of a table, without control characters of its own."""
        return super().render_str(printable(text), **options)


def plain_console(*, stderr: bool = False) -> Console:
    """Return a console for tables on stdout, or for progress on stderr."""
    wide = not stderr and not sys.stdout.isatty() and "COLUMNS" not in os.environ
    return PlainConsole(
        file=cast("IO[str]", _StyledFile(stderr=stderr)),
        markup=False,
        highlight=False,
        emoji=False,
        width=FILE_COLUMNS if wide else None,
    )


def new_table(title: str, headings: str) -> Table:
    """Return a table without rows.

    `headings`: With ``|`` between them, first the marks of a column: ``<`` on the left, ``=`` no cell is wrapped.
    """
    table = Table(title=title)
    for heading in headings.split("|"):
        name = heading.lstrip("<=")
        marks = heading.removesuffix(name)
        table.add_column(name, justify="left" if "<" in marks else "right", no_wrap="=" in marks)
    return table


class _StyledFile:
    """The stream to which a console writes its own escape sequences."""

    def __init__(self, *, stderr: bool) -> None:
        self.stderr = stderr

    @property
    def stream(self) -> Any:
        return sys.stderr if self.stderr else sys.stdout

    def write(self, text: str) -> int:
        stream = self.stream
        return stream.write_styled(text) if isinstance(stream, PrintableText) else stream.write(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


def show_notes(issues: Iterable[Issue], console: Console) -> None:
    """Print what is odd, one line each."""
    for issue in issues:
        console.print(f"note: {issue.message}")


def _fit(table: Table, width: int) -> int:
    """Give the columns of a table that is too wide their widths. Return the width of the table, 0 if it fits."""
    texts = ["\n".join([str(column.header), *map(str, column.cells)]) for column in table.columns]
    natural = [max(map(len, text.splitlines()), default=0) for text in texts]
    if not natural or sum(natural) + BORDER * len(natural) + 1 <= width:
        return 0
    least = [max(map(len, text.split()), default=0) for text in texts]
    table.box, table.padding, table.show_edge = box.SIMPLE_HEAD, (0, 0), False  # one space between two columns
    spaces = len(least) - 1
    spare = max(width - sum(least) - spaces, 0)
    for column, low, high in zip(table.columns, least, natural, strict=True):
        more = min(high - low, spare)
        spare -= more
        column.width, column.no_wrap = low + more, False
    return sum(column.width or 0 for column in table.columns) + spaces
