"""Work on a part in a child process, while a waiting user sees the current step."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from wpcal.cli.progress import shown_progress
from wpcal.core.input_file import MOST_STEP_MB, STDIN, read_bytes

FROM_STDIN = "stdin.step"
"""Name of a part that comes from standard input, and so of its results."""
STARTING = "starting the CAD kernel"
"""What is done until the first message of the kernel's process."""


def run_on_part(target: str, part_step: Path, arguments: Mapping[str, Any], *, what: str) -> Any:
    """Call a function with a STEP file in a child process and show its progress.

    A file that cannot be a STEP file is refused here, before the child loads the CAD kernel (about 3 s).

    Parameters
    ----------
    target : str
        ``package.module:function``. The file is its argument `step`.
    part_step : Path
        ``-`` is standard input.
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
    from cad.step.open_text import require_step_file

    if str(part_step) == STDIN:
        with TemporaryDirectory() as folder:
            copy = Path(folder, FROM_STDIN)
            copy.write_bytes(read_bytes(part_step, most_mb=MOST_STEP_MB))
            return run_on_part(target, copy, arguments, what=what)
    require_step_file(part_step)
    from cad.kernel.child import run_in_child

    with shown_progress(STARTING) as progress:
        return run_in_child(target, {"step": part_step, **arguments}, what=what, progress=progress)
