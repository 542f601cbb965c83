"""A part as read: its faces and edges as arrays, its reference features, and what is odd in its file.

Importing this module does not load the CAD kernel: a process without it can hold and fit a `Workpiece`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from cad.workpiece.answer_cache import NO_CACHE, AnswerCache
from cad.workpiece.script_shapes import ScriptShapes, script_shapes
from cad.workpiece.step_file import StepFile
from wpcal.brep import BrepGraph
from wpcal.brep.repeats import solid_shapes
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.errors import InputError
from wpcal.core.issue import Issue
from wpcal.core.progress import Progress, no_progress
from wpcal.core.wording import counted, listed
from wpcal.seam.member.note import MemberNotes
from wpcal.taught.features import ReferenceFeature, Touchable, find_features, judge_features

Answer = TypeVar("Answer")


@dataclass(frozen=True, eq=False, repr=False)
class Workpiece:
    """A part as read, and what can be taught and welded on it."""

    graph: BrepGraph
    issues: tuple[Issue, ...] = ()  #: What is odd in the file.
    source: StepFile | None = None  #: The STEP file; None for shapes from a script.
    shapes: tuple[Any, ...] = ()  #: The shapes from a script, unchanged.
    member_notes: MemberNotes | None = None  #: What the solids are taken for; None before seams were found.
    as_read: BrepGraph | None = None  #: The graph before curves of seams were added to it; None where none were.

    def __repr__(self) -> str:
        """Say how large the part is."""
        name = "" if self.source is None else f"{self.source.file_name}: "
        return f"Workpiece({name}{self.size})"

    @property
    def file(self) -> StepFile:
        """The STEP file. Raises `InputError` for shapes from a script."""
        if self.source is None:
            raise InputError("expected a STEP file, got shapes from a script")
        return self.source

    @property
    def solids(self) -> tuple[Any, ...]:
        """The solids of the graph, in its order, as kernel shapes. For them the kernel reads the file."""
        if self.source is not None:
            return tuple(solid.shape for solid in self.source.step.solids)
        return tuple(shape for _, shape in _named_solids(self.shapes))

    @property
    def volumes_mm3(self) -> tuple[float, ...]:
        """The volume of each solid, mm³; computed by the kernel when it is asked for first."""

        def compute() -> tuple[float, ...]:
            solids, first = self.solids, solid_shapes(self.graph, self.trimmed).tolist()
            from cad.kernel.geometry import volume_mm3

            known = {one: volume_mm3(solids[one]) for one in set(first)}
            return tuple(known[one] for one in first)

        return compute() if self.source is None else self.source.answer("volumes", (), compute)

    @property
    def size(self) -> str:
        """How large the part is, for progress messages: ``5 solids, 31 faces``."""
        return f"{counted(len(self.graph.solid_names), 'solid')}, {counted(self.graph.face_count, 'face')}"

    @cached_property
    def features(self) -> tuple[ReferenceFeature, ...]:
        """The reference features of the part as read; found when they are asked for."""
        return find_features(self.as_read or self.graph) if self.source is None else self.source.features

    @cached_property
    def trimmed(self) -> TrimmedFaces:
        """Boundaries of the faces as pieces; computed once, for every question about what lies on a face."""
        file = self.source
        if file is not None and self.graph is file.content.graph:
            return file.trimmed
        return TrimmedFaces.of(self.graph)

    @cached_property
    def judged(self) -> tuple[Touchable, ...]:
        """How well each feature can be touched; computed once."""
        return tuple(judge_features(self.graph, self.features, trimmed=self.trimmed))

    def with_sections(self, graph: BrepGraph, notes: MemberNotes, issues: Sequence[Issue]) -> Workpiece:
        """Return the workpiece with the curves on which its seams lie, and what its solids are taken for."""
        read = self.as_read or self.graph
        found = replace(self, graph=graph, issues=(*self.issues, *issues), member_notes=notes, as_read=read)
        vars(found).update(trimmed=self.trimmed.with_graph(graph))
        return found

    def without_kernel(self) -> Workpiece:
        """Return the workpiece as another process can hold it: without its file and its shapes."""
        found = replace(self, source=None, shapes=())
        vars(found).update(trimmed=self.trimmed, features=self.features)
        return found

    def answer(self, what: str, of: Sequence[object], make: Callable[[], Answer]) -> Answer:
        """Return an answer that is kept, or find it; parameters as in `AnswerCache.answer`.

        Only answers about a file as it was read are kept, not about a workpiece that a script changed.
        """
        file = self.source
        if file is None or self.graph is not file.content.graph or self.issues is not file.content.issues:
            return make()
        return file.answer(what, of, make)


Openable: TypeAlias = Workpiece | Path | str | ScriptShapes
"""A part: opened, or what `open_workpiece` opens."""


def open_workpiece(step: Openable, *, cache: AnswerCache = NO_CACHE, progress: Progress = no_progress) -> Workpiece:
    """Read a part.

    Raises `InputError` when the file cannot be read, a shape holds no solid, or a solid has geometry at infinity.
    Raises `KernelError` when the kernel fails.

    `step`: A STEP file, or shapes in mm: the label of a shape becomes the name of its solid, in an assembly that of
    each part. A `BuildPart` and CadQuery's `Workplane` or `Assembly` are taken too. An open part is returned as it is.
    `cache`: Where answers about STEP files are kept: `user_cache` returns that of the commands. By default nothing is
    kept.
    """
    if isinstance(step, Workpiece):
        return step
    if isinstance(step, str | Path):
        progress(f"reading {Path(step).name}{_megabytes(Path(step))}")
        file = StepFile.open(step, cache)
        return Workpiece(file.content.graph, file.content.issues, file)
    from cad.kernel.to_brep import to_brep

    shapes = script_shapes(step)
    bare = [type(shape).__name__ for shape in shapes if not labelled_solids(shape)]
    if bare or not shapes:
        raise InputError(f"expected shapes with solids, got {listed(bare) or 'no shape'} without one")
    return Workpiece(to_brep(_named_solids(shapes)), shapes=shapes)


def _megabytes(path: Path) -> str:
    """Return how large a file is, for a progress message; nothing where the reader will say what is wrong."""
    try:
        return f": {path.stat().st_size / 1e6:.1f} MB"
    except (OSError, ValueError):
        return ""


def _named_solids(shapes: Sequence[Any]) -> list[tuple[str, Any]]:
    from cad.step.read import unique_name

    named: list[tuple[str, Any]] = []
    taken: set[str] = set()
    for shape in shapes:
        for label, solid in labelled_solids(shape):
            named.append((unique_name(label or f"S{len(named) + 1}", taken), solid))
    return named


def labelled_solids(shape: Any) -> list[tuple[str, Any]]:
    """Return label and kernel shape of each solid of a build123d shape; in an assembly the label of its own part."""
    from cad.kernel.topology import SOLID, sub_shape_uses

    solids = [solid for solid, _ in sub_shape_uses(shape.wrapped, SOLID)]
    own = getattr(shape, "label", "")
    labels = [label or own for child in getattr(shape, "children", ()) for label, _ in labelled_solids(child)]
    return list(zip(labels if len(labels) == len(solids) else [own] * len(solids), solids, strict=True))
