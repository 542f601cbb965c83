"""The console on which the commands print their tables."""

import os
import sys

from rich.console import Console

FILE_COLUMNS = 120
"""Width of a table in a file or a pipe, which has no width of its own: room for the names of two solids."""


def plain_console() -> Console:
    """Return a console on stdout that prints names as they are: ``[b]`` in a solid's name is not markup."""
    wide = not sys.stdout.isatty() and "COLUMNS" not in os.environ
    return Console(markup=False, emoji=False, width=FILE_COLUMNS if wide else None)
