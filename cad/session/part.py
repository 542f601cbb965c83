"""Everything that the picker needs of a STEP file, read once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from cad.workpiece.answer_cache import NO_CACHE, AnswerCache
from cad.workpiece.features import judge_workpiece
from cad.workpiece.seams import SeamChoice, decide, find_seams
from cad.workpiece.step_file import draw_part
from cad.workpiece.workpiece import Workpiece, open_workpiece
from wpcal.core.progress import Progress, no_progress
from wpcal.seam import Seam, SeamOptions
from wpcal.seam.edit import PlacedEdit
from wpcal.seam.member.listed import weighed_members
from wpcal.taught.features import Touchable


@dataclass(frozen=True, slots=True, eq=False)
class PickPart:
    """A part as the picker shows and fits it."""

    file_name: str
    sha256: str  #: Hash of the file.
    workpiece: Workpiece  #: Without kernel objects, with the curves on which candidates lie.
    touchables: tuple[Touchable, ...]  #: Reference features, the easiest to touch first.
    seams: tuple[Seam, ...]  #: With frames in `part`, after the decisions of a person.
    candidates: tuple[Seam, ...]  #: The seams as they were found.
    seam_options: SeamOptions  #: With which the candidates were found.
    part_glb: bytes | None  #: The part's triangles.
    notes: tuple[str, ...]  #: What is odd in the file.

    def decided(self, edits: Sequence[PlacedEdit]) -> tuple[Seam, ...]:
        """Return the seams after the decisions of a person; errors as in `wpcal.seam.edit.apply_edits`."""
        return decide(self.workpiece, self.candidates, edits, self.seam_options) if edits else self.candidates


def read_pick_part(
    step: Path,
    *,
    options: SeamOptions,
    choice: SeamChoice,
    cache: AnswerCache = NO_CACHE,
    progress: Progress = no_progress,
) -> PickPart:
    """Read a STEP file, its features and seams, and draw it; parameters and errors as in `cad.workpiece`."""
    workpiece = open_workpiece(step, cache=cache, progress=progress)
    touchables = judge_workpiece(workpiece, progress=progress)
    progress(f"finding seams: {workpiece.size}")
    candidates, with_sections = find_seams(workpiece, options, replace(choice, edits=()))
    progress(f"drawing the part: {workpiece.size}")
    source = workpiece.file
    part_glb, mesh_issues = draw_part(source)
    notes = tuple(issue.message for issue in (*with_sections.issues, *mesh_issues))
    notes_of = with_sections.member_notes
    assert notes_of is not None  # seams were found
    weighed = weighed_members(with_sections.graph, with_sections.trimmed, notes_of, workpiece.volumes_mm3)
    plain = replace(with_sections, member_notes=weighed).without_kernel()
    part = PickPart(
        source.file_name, source.sha256, plain, touchables, candidates, candidates, options, part_glb, notes
    )
    return replace(part, seams=part.decided(choice.edits))
