"""What a waiting user sees: the step under way, on stderr, on a terminal only."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from wpcal.core.progress import Progress, no_progress


@contextmanager
def shown_progress() -> Iterator[Progress]:
    """Yield a function that shows one line of text beside a spinner; it does nothing where nobody looks."""
    if not sys.stderr.isatty():
        yield no_progress
        return
    from rich.console import Console

    with Console(stderr=True).status("starting the CAD kernel") as status:
        yield status.update
