"""Find the seams of a workpiece, and apply what a person decided about them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from cad.workpiece.answer_cache import NO_CACHE, AnswerCache
from cad.workpiece.step_file import draw_part
from cad.workpiece.workpiece import Openable, Workpiece, open_workpiece
from wpcal.brep import BrepGraph
from wpcal.brep.material import ExactMaterial
from wpcal.brep.repeats import solid_shapes
from wpcal.core.arrays import IntArray
from wpcal.core.errors import InputError
from wpcal.core.issue import Issue
from wpcal.core.process import give_memory_back
from wpcal.core.progress import Progress, no_progress
from wpcal.core.wording import listed
from wpcal.pages.draw.seam import explained_svg
from wpcal.seam import ConcaveEdges, Seam, SeamOptions
from wpcal.seam.edit import PlacedEdit, apply_edits
from wpcal.seam.explain import explain_seam
from wpcal.seam.find.bead_bodies import without_beads
from wpcal.seam.find.covered import covered_issues
from wpcal.seam.find.marked import MarkedEdges
from wpcal.seam.find.play import with_play
from wpcal.seam.judge.doubted import why_none_is_taken, why_nothing_is_found
from wpcal.seam.judge.other_torches import with_other_torches
from wpcal.seam.member.listed import weighed_members
from wpcal.seam.member.note import MemberNotes, take_members
from wpcal.seam.member.one_piece import find_whole_solids, left_out
from wpcal.seam.member.said import said_about
from wpcal.seam.names import seams_named
from wpcal.seam.options import Judging, Reach
from wpcal.seam.seam import SeamPieces
from wpcal.seam.search import find_part_candidates
from wpcal.weld.thickness import plate_thicknesses


@dataclass(frozen=True, slots=True)
class SeamChoice:
    """What a person decided about the seams of a part."""

    edits: tuple[PlacedEdit, ...] = ()  #: Edits of candidates (`wpcal.seam.edit.read_edits`).
    #: Names, layers or colours of the edges in the STEP file that are seams (`marked_edges.find_marked`).
    marked: tuple[str, ...] = ()
    edges: tuple[str, ...] = ()  #: Places of edges that are seams. With them, or with marked ones, nothing else is.
    added_edges: tuple[str, ...] = ()  #: Places of edges that are seams beside those that are found.
    #: What a file of decisions says about solids and members; the options come first.
    judging: Judging = field(default_factory=Judging)

    @property
    def places(self) -> tuple[str, ...]:
        """The places of all edges that are seams; each may be the name of a feature."""
        return (*self.edges, *self.added_edges)


@dataclass(frozen=True, slots=True)
class Explained:
    """Why one seam is taken for a weld or not."""

    record: dict[str, Any]  #: As `wpcal.seam.explain.explain_seam` returns it.
    svg: str  #: A picture of the seam in its part.


def find_seams(
    workpiece: Openable,
    options: SeamOptions | None = None,
    choice: SeamChoice | None = None,
    *,
    keep_shapes: bool = True,
) -> tuple[tuple[Seam, ...], Workpiece]:
    """Find the seams of a workpiece. For solids that overlap, the kernel first computes the intersection curves.

    `workpiece`: What `open_workpiece` takes.
    `keep_shapes`: False where nobody asks for the shapes of the file after this.
    Returns `seams`: tuple of Seam. With frames in `part`.
    Returns `workpiece`: The same workpiece, with those curves in its graph, with the pairs that failed in its issues,
    and with what its solids are taken for.
    """
    workpiece, options, choice = open_workpiece(workpiece), options or SeamOptions(), choice or SeamChoice()
    options = replace(options, judging=options.judging.after(choice.judging))
    of = (options, choice.marked, choice.edges, choice.added_edges, workpiece.features if choice.places else ())
    keep_shapes = keep_shapes or bool(choice.marked or choice.places)
    found = workpiece.answer("seams", of, partial(_find, workpiece, options, choice, keep_shapes))
    workpiece = workpiece.with_sections(found.graph or workpiece.graph, found.notes, found.issues)
    return decide(workpiece, found.seams, choice.edits, options), workpiece


def decide(
    workpiece: Workpiece, candidates: Sequence[Seam], edits: Sequence[PlacedEdit], options: SeamOptions
) -> tuple[Seam, ...]:
    """Carry out decisions as `wpcal.seam.edit.apply_edits` does, past modelled beads and with the play of the part.

    `workpiece`: As `find_seams` returns it, with the seams that it found as `candidates`.
    """
    graph, notes = workpiece.graph, workpiece.member_notes
    measured = options if notes is None else replace(options, play=notes.play, judging=notes.judging)
    return apply_edits(graph, without_beads(graph, workpiece.trimmed), candidates, edits, measured)


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """Seams before the edits of a person, and what belongs to them: the graph only if edges were added to it."""

    seams: tuple[Seam, ...]
    graph: BrepGraph | None
    notes: MemberNotes
    issues: tuple[Issue, ...]


def _find(workpiece: Workpiece, options: SeamOptions, choice: SeamChoice, keep_shapes: bool) -> _Found:
    graph, trimmed = workpiece.graph, workpiece.trimmed
    solid_shapes(graph, trimmed)  # as read: edges that are added later are not the same on every copy
    options = with_play(graph, trimmed, options)
    judging = replace(options.judging, members=tuple(said_about(graph, trimmed, options.judging).members))
    notes = replace(take_members(graph, trimmed, judging).notes, play=options.play or ())
    mark = partial(_mark, workpiece, choice) if choice.marked or choice.places else None
    known = find_part_candidates(graph, trimmed, options, cross=partial(_cross, workpiece, keep_shapes), mark=mark)
    give_memory_back()  # what the search took
    wide, seams = known.trimmed.graph, known.judged(options)
    issues = (*known.issues, *covered_issues(graph, trimmed))
    if notes.unused:
        what = "decides about no solid of this part" if len(notes.unused) == 1 else "decide about no solid of this part"
        issues = (*issues, Issue("pattern-unused", f"{listed(notes.unused)} {what} (--weld, --not)", notes.unused))
    if not seams and options.concave is ConcaveEdges.AUTO:
        whole = find_whole_solids(wide, trimmed.with_graph(wide))
        issues = (*issues, *left_out(wide, trimmed.with_graph(wide), whole))
        notes = notes.with_whole({solid: why for solid, _, why in whole})
    told = why_nothing_is_found(seams, len(graph.solid_names), options.gap_for(graph))
    issues = (*issues, *why_none_is_taken(seams), *told)
    return _Found(seams, wide if wide.edge_count > graph.edge_count else None, notes.with_shapes(seams), issues)


def _cross(
    workpiece: Workpiece, keep_shapes: bool, graph: BrepGraph, pairs: IntArray
) -> tuple[BrepGraph, SeamPieces | None, tuple[Issue, ...]]:
    """Add the curves in which pairs of solids meet; the kernel computes them. Without a pair it is not needed again."""
    if not len(pairs):
        if workpiece.source is not None and not keep_shapes:
            workpiece.source.let_shapes_go()
            give_memory_back()
        return graph, None, ()
    solids = workpiece.solids
    from cad.kernel.section import add_sections

    return add_sections(graph, solids, pairs)


def _mark(workpiece: Workpiece, choice: SeamChoice, graph: BrepGraph) -> tuple[BrepGraph, MarkedEdges]:
    """Add the edges that a person marked."""
    marks = () if workpiece.source is None else workpiece.source.step.marks
    from cad.workpiece.marked_edges import find_marked

    graph, found = find_marked(graph, marks, workpiece.features, patterns=choice.marked, places=choice.places)
    return graph, replace(found, is_added=not (choice.marked or choice.edges))


def list_seams(
    step: Path,
    *,
    options: SeamOptions,
    choice: SeamChoice | None = None,
    picture: bool = False,
    mesh: bool = False,
    members: bool = False,
    explain: str | None = None,
    cache: AnswerCache = NO_CACHE,
    progress: Progress = no_progress,
) -> tuple[tuple[Seam, ...], MemberNotes, tuple[Issue, ...], bytes | None, bytes | None, Explained | None]:
    """Return the seams of a STEP file, frames in `part`, what its solids are taken for, and what is odd in the file.

    If asked for, also their members with weights, their picture (PNG), ``part.glb``, and why the seam of a name is
    taken or refused.
    """
    workpiece = open_workpiece(step, cache=cache, progress=progress)
    progress(f"finding seams: {workpiece.size}")
    volumes_mm3 = workpiece.volumes_mm3 if members else ()
    seams, workpiece = find_seams(workpiece, options, choice, keep_shapes=mesh)
    png, part_glb = None, None
    if picture:
        from cad.draw.picture import seams_png

        progress(f"drawing a picture: {workpiece.size}")
        png = seams_png(workpiece.graph, seams, Path(step).name)
    if mesh:
        progress(f"drawing the part: {workpiece.size}")
        part_glb, _ = draw_part(workpiece.file)
    notes = workpiece.member_notes or MemberNotes(options.judging, ())
    if members:
        notes = weighed_members(workpiece.graph, workpiece.trimmed, notes, volumes_mm3)
    told = None if explain is None else _explained(workpiece, seams, notes, explain, Path(step).name, options.reach)
    return seams, notes, workpiece.issues, png, part_glb, told


def _explained(
    workpiece: Workpiece, seams: tuple[Seam, ...], notes: MemberNotes, name: str, file_name: str, reach: Reach
) -> Explained:
    chosen = seams_named([name], [seam.name for seam in seams])
    if len(chosen) > 1:
        raise InputError(f"{name}: expected the name of one seam")
    seam = next(seam for seam in seams if seam.name == chosen[0])
    if seam.blocked_by and seam.other_torch is None:
        [[seam]] = with_other_torches(workpiece.graph, workpiece.trimmed, [[seam]], reach, least_mm=0.0)
    thick_mm = plate_thicknesses(seam.frames, ExactMaterial(workpiece.graph, workpiece.trimmed))
    record = explain_seam(workpiece.graph, seam, notes, thick_mm)
    title = f"{seam.name} of {file_name}: {seam.joint.value}, {' + '.join(seam.solids)}, {seam.confidence:.0%}"
    return Explained(
        record, explained_svg(workpiece.graph, workpiece.trimmed, seam, title, reach.torch, record["section"])
    )
