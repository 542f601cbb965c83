"""Everything that the picker needs of a STEP file, read once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from cad.workpiece.features import judge_workpiece
from cad.workpiece.seams import SeamChoice, find_seams
from cad.workpiece.workpiece import Workpiece, open_workpiece
from wpcal.core.progress import Progress, no_progress
from wpcal.features import Touchable
from wpcal.seam import Seam, SeamOptions


@dataclass(frozen=True, slots=True, eq=False)
class PickPart:
    """A part as the picker shows and fits it.

    Parameters
    ----------
    file_name : str
    sha256 : str
        Hash of the file.
    workpiece : Workpiece
        Without kernel objects.
    touchables : tuple of Touchable
        Reference features, the easiest to touch first.
    seams : tuple of Seam
        With frames in `part`.
    part_glb : bytes or None
        The part's triangles.
    notes : tuple of str
        What is odd in the file.
    """

    file_name: str
    sha256: str
    workpiece: Workpiece
    touchables: tuple[Touchable, ...]
    seams: tuple[Seam, ...]
    part_glb: bytes | None
    notes: tuple[str, ...]


def read_pick_part(
    step: Path, *, options: SeamOptions, choice: SeamChoice, progress: Progress = no_progress
) -> PickPart:
    """Read a STEP file, its features and seams, and draw it; parameters and errors as in `cad.workpiece`."""
    from cad.kernel.tessellate import mesh_part

    workpiece = open_workpiece(step, progress=progress)
    touchables = judge_workpiece(workpiece, progress=progress)
    progress("finding seams")
    seams, with_sections = find_seams(workpiece, options, choice)
    progress("drawing the part")
    source = workpiece.source
    part_glb, mesh_issues = mesh_part(source.solids, sha256=source.sha256)
    notes = tuple(issue.message for issue in (*with_sections.issues, *mesh_issues))
    plain = replace(workpiece, source=None, solids=())
    return PickPart(source.file_name, source.sha256, plain, touchables, seams, part_glb, notes)
