"""A part as read: what can be taught and what can be welded on it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from cad.kernel.system_libraries import libgl_explained
from cad.kernel.to_brep import to_brep
from wpcal.brep import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.errors import InputError
from wpcal.core.issue import Issue
from wpcal.core.progress import Progress, no_progress
from wpcal.features import ReferenceFeature, Touchable, find_features, judge_features
from wpcal.seam import Seam, SeamOptions, detect_seams
from wpcal.seam.edit import PlacedEdit, apply_edits
from wpcal.seam.find.bead import add_beads
from wpcal.seam.find.interpenetration import interpenetrating_solids


@dataclass(frozen=True, slots=True)
class SeamChoice:
    """What a person decided about the seams of a part.

    Parameters
    ----------
    edits : tuple of PlacedEdit
        About candidates (`wpcal.seam.edit.read_edits`).
    marked : tuple of str
        Names, layers or colours of edges in the STEP file that are the seams (`marked_edges.find_marked`).
    edges : tuple of str
        Places of edges that are seams.
    """

    edits: tuple[PlacedEdit, ...] = ()
    marked: tuple[str, ...] = ()
    edges: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Workpiece:
    """A part as read, and what can be taught and welded on it.

    Parameters
    ----------
    graph : BrepGraph
    features : tuple of ReferenceFeature
    issues : tuple of Issue
        What is odd in the file.
    source : StepPart or None
        The STEP file; None for shapes handed over from a script.
    shapes : tuple
        The shapes handed over, as they came.
    solids : tuple of kernel shapes
        The solids of the graph, in its order.
    """

    graph: BrepGraph
    features: tuple[ReferenceFeature, ...]
    issues: tuple[Issue, ...] = ()
    source: Any = None
    shapes: tuple[Any, ...] = ()
    solids: tuple[Any, ...] = ()

    @cached_property
    def trimmed(self) -> TrimmedFaces:
        """Boundaries of the faces as pieces; made once, for touches, seams and all that asks what lies on a face."""
        return TrimmedFaces.of(self.graph)


def open_workpiece(step: Any, *, progress: Progress = no_progress) -> Workpiece:
    """Read a part and find its reference features.

    Parameters
    ----------
    step : path, build123d shape, or iterable of build123d shapes
        A STEP file, or shapes in mm; a shape's label becomes its solid's name.

    Returns
    -------
    Workpiece

    Raises
    ------
    InputError
        When the file cannot be read, or there is no solid.
    KernelError
        When the kernel fails.
    """
    if isinstance(step, str | Path):
        with libgl_explained():
            from cad.step.read import read_step

        progress(f"reading {Path(step).name}")
        part = read_step(step)
        if not part.solids:
            found = "; ".join(issue.message for issue in part.issues)
            raise InputError(f"{step}: there is nothing to teach or weld on: {found}")
        solids = tuple(solid.shape for solid in part.solids)
        graph = to_brep((solid.name, solid.shape) for solid in part.solids)
        return Workpiece(graph, find_features(graph), part.issues, part, solids=solids)
    shapes = tuple(step) if isinstance(step, Iterable) and not hasattr(step, "wrapped") else (step,)
    named = _named_solids(shapes)
    if not named:
        raise InputError("the shapes handed over hold no solid")
    graph = to_brep(named)
    return Workpiece(graph, find_features(graph), shapes=shapes, solids=tuple(shape for _, shape in named))


def _named_solids(shapes: Sequence[Any]) -> list[tuple[str, Any]]:
    from cad.kernel.topology import explore

    named: list[tuple[str, Any]] = []
    taken: set[str] = set()
    for shape in shapes:
        for solid, _ in explore(shape.wrapped, "solid"):
            base = getattr(shape, "label", "") or f"S{len(named) + 1}"
            name, count = base, 1
            while name in taken:
                count += 1
                name = f"{base}#{count}"
            taken.add(name)
            named.append((name, solid))
    return named


def find_seams(
    workpiece: Workpiece, options: SeamOptions, choice: SeamChoice | None = None
) -> tuple[tuple[Seam, ...], Workpiece]:
    """Find the seams of a workpiece; solids that run into each other are cut by the kernel first.

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
        With the section curves in its graph, and what went wrong with them among its issues.
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
    marked = None
    if choice.marked or choice.edges:
        from cad.workpiece.marked_edges import find_marked

        marks = () if workpiece.source is None else workpiece.source.marks
        graph, marked = find_marked(graph, marks, workpiece.features, patterns=choice.marked, places=choice.edges)
    workpiece, trimmed = replace(workpiece, graph=graph), replace(trimmed, graph=graph)
    seams = detect_seams(graph, options, trimmed=trimmed, sections=sections, beads=beads, marked=marked)
    return apply_edits(graph, trimmed, seams, choice.edits, options), workpiece


def list_features(step: Path, *, progress: Progress = no_progress) -> tuple[Touchable, ...]:
    """Return the reference features of a STEP file, those that are easiest to touch first."""
    return judge_workpiece(open_workpiece(step, progress=progress), progress=progress)


def judge_workpiece(workpiece: Workpiece, *, progress: Progress = no_progress) -> tuple[Touchable, ...]:
    """Return the reference features of a workpiece, those that are easiest to touch first."""
    progress("judging features")
    judged = judge_features(workpiece.graph, workpiece.features, trimmed=workpiece.trimmed)
    return tuple(sorted(judged, key=lambda item: item.ease))


def list_seams(
    step: Path,
    *,
    options: SeamOptions,
    choice: SeamChoice | None = None,
    picture: bool = False,
    mesh: bool = False,
    progress: Progress = no_progress,
) -> tuple[tuple[Seam, ...], bytes | None, bytes | None]:
    """Return the seams of a STEP file, frames in `part`, and where asked a picture of them (PNG) and ``part.glb``."""
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
    return seams, png, part_glb
