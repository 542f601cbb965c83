"""A part as read: its faces and edges as arrays, its reference features, and what is odd in its file.

Importing this module does not load the CAD kernel: a process without it can hold and fit a `Workpiece`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from cad.kernel.system_libraries import libgl_explained
from wpcal.brep import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.errors import InputError
from wpcal.core.issue import Issue
from wpcal.core.progress import Progress, no_progress
from wpcal.features import ReferenceFeature, find_features
from wpcal.seam.member.note import MemberNotes


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
        The STEP file; None for shapes from a script.
    shapes : tuple
        The shapes from a script, unchanged.
    solids : tuple of kernel shapes
        The solids of the graph, in its order.
    member_notes : MemberNotes or None
        What the solids are taken for; None before seams were found.
    """

    graph: BrepGraph
    features: tuple[ReferenceFeature, ...]
    issues: tuple[Issue, ...] = ()
    source: Any = None
    shapes: tuple[Any, ...] = ()
    solids: tuple[Any, ...] = ()
    member_notes: MemberNotes | None = None

    @cached_property
    def trimmed(self) -> TrimmedFaces:
        """Boundaries of the faces as pieces; computed once, for every question about what lies on a face."""
        return TrimmedFaces.of(self.graph)


def open_workpiece(step: Any, *, progress: Progress = no_progress) -> Workpiece:
    """Read a part and find its reference features.

    Parameters
    ----------
    step : path, build123d shape, iterable of build123d shapes, or Workpiece
        A STEP file, or shapes in mm: the label of a shape becomes the name of its solid. A part that is open already
        is returned as it is.

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
    if isinstance(step, Workpiece):
        return step
    if isinstance(step, str | Path):
        with libgl_explained():
            from cad.kernel.to_brep import to_brep
            from cad.step.read import read_step

        progress(f"reading {Path(step).name}")
        part = read_step(step)
        if not part.solids:
            found = "; ".join(issue.message for issue in part.issues)
            raise InputError(f"{step}: there is nothing to teach or weld on: {found}")
        solids = tuple(solid.shape for solid in part.solids)
        graph = to_brep((solid.name, solid.shape) for solid in part.solids)
        graph = replace(graph, solid_facts=tuple(solid.facts for solid in part.solids))
        return Workpiece(graph, find_features(graph), part.issues, part, solids=solids)
    from cad.kernel.to_brep import to_brep

    shapes = tuple(step) if isinstance(step, Iterable) and not hasattr(step, "wrapped") else (step,)
    named = _named_solids(shapes)
    if not named:
        raise InputError("the shapes given hold no solid")
    graph = to_brep(named)
    return Workpiece(graph, find_features(graph), shapes=shapes, solids=tuple(shape for _, shape in named))


def _named_solids(shapes: Sequence[Any]) -> list[tuple[str, Any]]:
    from cad.kernel.topology import SOLID, sub_shape_uses

    named: list[tuple[str, Any]] = []
    taken: set[str] = set()
    for shape in shapes:
        for solid, _ in sub_shape_uses(shape.wrapped, SOLID):
            base = getattr(shape, "label", "") or f"S{len(named) + 1}"
            name, count = base, 1
            while name in taken:
                count += 1
                name = f"{base}#{count}"
            taken.add(name)
            named.append((name, solid))
    return named
