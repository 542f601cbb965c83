"""Triangles of a STEP file for commands of `wpcal`, which do not know the CAD kernel (entry points ``wpcal.parts``)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from cad.cli.options import MESH

if TYPE_CHECKING:
    from cad.workpiece.answer_cache import AnswerCache
    from wpcal.core.progress import Progress


def step_mesh(path: Path) -> bytes:
    """Return a part as ``part.glb``, from the cache if it is known.

    Raises `InputError` if the file cannot be read, is not a STEP file, or has no solid.
    """
    from cad.cli.kernel_work import run_on_part

    found: bytes = run_on_part(
        "cad.cli.part_mesh:mesh_of_step", path, {}, what=f"reading {path}", use_cache=True, needs=(MESH,)
    )
    return found


def mesh_of_step(step: Path, *, cache: AnswerCache, progress: Progress) -> bytes:
    """Return the triangles of the solids of a STEP file (runs where the kernel runs)."""
    from cad.workpiece.step_file import StepFile, draw_part
    from wpcal.core.errors import InputError

    progress("drawing the part")
    glb, issues = draw_part(StepFile.open(step, cache=cache))
    if glb is None:
        why = "; ".join(issue.message for issue in issues)
        raise InputError(f"{step}: there is no solid to compare with{f': {why}' if why else ''}")
    return glb
