"""Work on a part in a child process, and what a waiting user sees of it: the current step, on a terminal only."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from wpcal.core.progress import Progress, no_progress


def run_on_part(target: str, part_step: Path, arguments: Mapping[str, Any], *, what: str) -> Any:
    """Call a function with a STEP file in a child process and show its progress.

    A file that cannot be a STEP file is refused here, before the child loads the CAD kernel (about 3 s).

    Parameters
    ----------
    target : str
        ``package.module:function``. The file is its argument `step`.
    part_step : Path
    arguments : mapping
        The other keyword arguments.
    what : str
        For messages: what is done.

    Returns
    -------
    object
        The result of the function.

    Raises
    ------
    InputError
        If the file cannot be read or is not a STEP file.
    WpcalError
        As the function raised it.
    """
    from cad.kernel.child import run_in_child
    from cad.step.open_text import require_step_file

    require_step_file(part_step)
    with shown_progress() as progress:
        return run_in_child(target, {"step": part_step, **arguments}, what=what, progress=progress)


@contextmanager
def shown_progress() -> Iterator[Progress]:
    """Yield a function that shows one line of text beside a spinner; without a terminal it does nothing."""
    if not sys.stderr.isatty():
        yield no_progress
        return
    from wpcal.cli.console import plain_console

    with plain_console(stderr=True).status("starting the CAD kernel") as status:
        yield status.update
