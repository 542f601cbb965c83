"""Find the seams of a workpiece, and apply what a person decided about them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from cad.workpiece.workpiece import Workpiece, open_workpiece
from wpcal.core.issue import Issue
from wpcal.core.progress import Progress, no_progress
from wpcal.seam import Seam, SeamOptions, detect_seams
from wpcal.seam.edit import PlacedEdit, apply_edits
from wpcal.seam.find.bead import add_beads
from wpcal.seam.find.flare_grooves import add_grooves
from wpcal.seam.find.interpenetration import interpenetrating_solids


@dataclass(frozen=True, slots=True)
class SeamChoice:
    """What a person decided about the seams of a part.

    Parameters
    ----------
    edits : tuple of PlacedEdit
        Edits of candidates (`wpcal.seam.edit.read_edits`).
    marked : tuple of str
        Names, layers or colours of the edges in the STEP file that are seams (`marked_edges.find_marked`).
    edges : tuple of str
        Places of edges that are seams.
    """

    edits: tuple[PlacedEdit, ...] = ()
    marked: tuple[str, ...] = ()
    edges: tuple[str, ...] = ()


def find_seams(
    workpiece: Workpiece, options: SeamOptions, choice: SeamChoice | None = None
) -> tuple[tuple[Seam, ...], Workpiece]:
    """Find the seams of a workpiece. For solids that overlap, the kernel first computes the intersection curves.

    Parameters
    ----------
    workpiece : Workpiece
    options : SeamOptions
    choice : SeamChoice, optional
        What a person decided.

    Returns
    -------
    seams : tuple of Seam
        With frames in `part`.
    workpiece : Workpiece
        The same workpiece, with those curves in its graph and with the pairs that failed in its issues.
    """
    trimmed = workpiece.trimmed
    pairs = interpenetrating_solids(workpiece.graph, trimmed)
    sections = None
    if len(pairs):
        from cad.kernel.section import add_sections

        graph, sections, issues = add_sections(workpiece.graph, workpiece.solids, pairs)
        workpiece = replace(workpiece, graph=graph, issues=(*workpiece.issues, *issues))
        trimmed = replace(trimmed, graph=graph)
    choice = choice or SeamChoice()
    graph, beads = add_beads(workpiece.graph, trimmed, options)
    graph, flares = add_grooves(graph, trimmed, options)
    marked = None
    if choice.marked or choice.edges:
        from cad.workpiece.marked_edges import find_marked

        marks = () if workpiece.source is None else workpiece.source.marks
        graph, marked = find_marked(graph, marks, workpiece.features, patterns=choice.marked, places=choice.edges)
    workpiece, trimmed = replace(workpiece, graph=graph), replace(trimmed, graph=graph)
    seams = detect_seams(graph, options, trimmed=trimmed, sections=sections, beads=beads, flares=flares, marked=marked)
    return apply_edits(graph, trimmed, seams, choice.edits, options), workpiece


def list_seams(
    step: Path,
    *,
    options: SeamOptions,
    choice: SeamChoice | None = None,
    picture: bool = False,
    mesh: bool = False,
    progress: Progress = no_progress,
) -> tuple[tuple[Seam, ...], tuple[Issue, ...], bytes | None, bytes | None]:
    """Return the seams of a STEP file, frames in `part`, and what is odd in the file.

    If asked for, also their picture (PNG) and ``part.glb``.
    """
    workpiece = open_workpiece(step, progress=progress)
    progress("finding seams")
    seams, workpiece = find_seams(workpiece, options, choice)
    png, part_glb = None, None
    if picture:
        from cad.draw.picture import seams_png

        progress("drawing")
        png = seams_png(workpiece.graph, seams, Path(step).name)
    if mesh:
        from cad.kernel.tessellate import mesh_part

        progress("drawing the part")
        part_glb, _ = mesh_part(workpiece.source.solids, sha256=workpiece.source.sha256)
    return seams, workpiece.issues, png, part_glb
