"""The console on which the commands print their tables."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from typing import IO, TYPE_CHECKING, Any, cast

from rich.console import Console
from rich.text import Text

from wpcal.cli.streams import PrintableText
from wpcal.printable import printable

if TYPE_CHECKING:
    from wpcal.core.issue import Issue

FILE_COLUMNS = 120
"""Width of a table in a file or a pipe, which has no width of its own: room for the names of two solids."""


class PlainConsole(Console):
    """A console that prints names as they are: ``[b]`` is not markup, and control characters are shown as escapes."""

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a text, for example a cell of a table, without control characters of its own."""
        return super().render_str(printable(text), **options)


def plain_console(*, stderr: bool = False) -> Console:
    """Return a console for tables on stdout, or for progress on stderr."""
    wide = not stderr and not sys.stdout.isatty() and "COLUMNS" not in os.environ
    return PlainConsole(
        file=cast("IO[str]", _StyledFile(stderr=stderr)),
        markup=False,
        emoji=False,
        width=FILE_COLUMNS if wide else None,
    )


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
        console.print(f"note: {issue.message}", highlight=False, markup=False)
