"""Everything that the picker needs of a STEP file, read once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from cad.workpiece.answer_cache import NO_CACHE, AnswerCache
from cad.workpiece.features import judge_workpiece
from cad.workpiece.seams import SeamChoice, find_seams
from cad.workpiece.step_file import draw_part
from cad.workpiece.workpiece import Workpiece, open_workpiece
from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.progress import Progress, no_progress
from wpcal.seam import Seam, SeamOptions
from wpcal.seam.edit import apply_edits
from wpcal.taught.features import Touchable


@dataclass(frozen=True, slots=True, eq=False)
class PickPart:
    """A part as the picker shows and fits it."""

    file_name: str
    sha256: str  #: Hash of the file.
    workpiece: Workpiece  #: Without kernel objects.
    touchables: tuple[Touchable, ...]  #: Reference features, the easiest to touch first.
    seams: tuple[Seam, ...]  #: With frames in `part`, after the decisions of a person.
    candidates: tuple[Seam, ...]  #: The seams as they were found.
    graph: BrepGraph  #: The part with the curves on which candidates lie.
    seam_options: SeamOptions  #: With which the candidates were found.
    part_glb: bytes | None  #: The part's triangles.
    notes: tuple[str, ...]  #: What is odd in the file.

    @property
    def trimmed(self) -> TrimmedFaces:
        """Boundaries of the faces, for every question about what lies on a face."""
        return replace(self.workpiece.trimmed, graph=self.graph)


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
    graph = with_sections.graph
    trimmed = replace(workpiece.trimmed, graph=graph)
    seams = apply_edits(graph, trimmed, candidates, choice.edits, options) if choice.edits else candidates
    progress(f"drawing the part: {workpiece.size}")
    source = workpiece.file
    part_glb, mesh_issues = draw_part(source)
    notes = tuple(issue.message for issue in (*with_sections.issues, *mesh_issues))
    plain = replace(workpiece, source=None, member_notes=with_sections.member_notes)
    return PickPart(
        file_name=source.file_name,
        sha256=source.sha256,
        workpiece=plain,
        touchables=touchables,
        seams=seams,
        candidates=candidates,
        graph=graph,
        seam_options=options,
        part_glb=part_glb,
        notes=notes,
    )
