"""Work on a part while a waiting user sees the current step: in a child process if it needs the CAD kernel.

What is known of the part already (`cad.workpiece.answer_cache`) needs no kernel. Then there is no child process either.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from cad.cli.options import PART
from wpcal.cli.progress import shown_progress
from wpcal.core.input_file import MOST_STEP_MB, STDIN, read_bytes

if TYPE_CHECKING:
    from cad.workpiece.answer_cache import AnswerCache

FROM_STDIN = "stdin.step"  #: Name of a part that comes from standard input, and so of its results.
STARTING = "starting the CAD kernel"  #: What is done until the first message of the kernel's process.


def run_on_part(
    target: str,
    part_step: Path,
    arguments: Mapping[str, Any],
    *,
    what: str,
    use_cache: bool,
    needs: Sequence[str] = (PART,),
) -> Any:
    """Call a function with a STEP file and show its progress, in a child process unless all that it needs is known.

    A file that cannot be a STEP file is refused here, before the child loads the CAD kernel (about 3 s).

    Raises `InputError` if the file cannot be read or is not a STEP file.
    Raises `WpcalError` as the function raised it.
    """
    from cad.step.open_text import require_step_file
    from cad.work.own_process import function_named
    from cad.workpiece.answer_cache import HERE

    if str(part_step) == STDIN:
        with TemporaryDirectory() as folder:
            copy = Path(folder, FROM_STDIN)
            copy.write_bytes(read_bytes(part_step, most_mb=MOST_STEP_MB))
            return run_on_part(target, copy, arguments, what=what, use_cache=use_cache, needs=needs)
    require_step_file(part_step)
    here = HERE.get()
    if here is not None:
        with shown_progress(f"opening {part_step.name}") as progress:
            return function_named(target)(step=part_step, **arguments, cache=here, progress=progress)
    from cad.work.child import Limits, run_in_child
    from cad.workpiece.answer_cache import NO_CACHE, KernelNeededError, user_cache

    cache, limits = user_cache() if use_cache else NO_CACHE, Limits.from_environment()
    with shown_progress(f"opening {part_step.name}") as progress:
        if _holds(part_step, cache, needs):
            with suppress(KernelNeededError):
                return function_named(target)(
                    step=part_step, **arguments, cache=replace(cache, kernel=False), progress=progress
                )
        progress(STARTING)
        given = {"step": part_step, **arguments, "cache": cache}
        return run_in_child(target, given, what=what, limits=limits, progress=progress)


def _holds(part_step: Path, cache: AnswerCache, needs: Sequence[str]) -> bool:
    """Whether answers about a file are kept."""
    if cache.folder is None or not cache.folder.is_dir():
        return False
    from cad.workpiece.answer_cache import file_identity

    data = read_bytes(part_step, most_mb=MOST_STEP_MB)
    return all(cache.holds(question, file_identity(part_step, data)) for question in needs)
