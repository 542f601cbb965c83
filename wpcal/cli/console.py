"""The console on which the commands print their tables."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING

from rich.console import Console

if TYPE_CHECKING:
    from wpcal.core.issue import Issue

FILE_COLUMNS = 120
"""Width of a table in a file or a pipe, which has no width of its own: room for the names of two solids."""


def plain_console() -> Console:
    """Return a console on stdout that prints names as they are: ``[b]`` in a solid's name is not markup."""
    wide = not sys.stdout.isatty() and "COLUMNS" not in os.environ
    return Console(markup=False, emoji=False, width=FILE_COLUMNS if wide else None)


def show_notes(issues: Iterable[Issue], console: Console) -> None:
    """Print what is odd, one line each."""
    for issue in issues:
        console.print(f"note: {issue.message}", highlight=False, markup=False)
