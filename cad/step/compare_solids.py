"""Whether a written file has every solid where its own motion puts it, and nothing else has changed."""

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from cad.kernel.geometry import surface_kind, vertex_points
from cad.kernel.topology import FACE, sub_shapes
from cad.step.compare import VERTEX_ATOL_MM, StepInventory, nearest_mm, take_inventory
from cad.step.read import StepPart
from wpcal.core.arrays import FloatArray
from wpcal.core.issue import Issue
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import counted, short


@dataclass(frozen=True, slots=True, eq=False)
class SolidsBefore:
    """What the solids of a file were, without their shapes."""

    #: Name, colour and layers of each. A solid that was called by its number has no name.
    looks: tuple[tuple[Any, ...], ...]
    surfaces: tuple[Counter[str], ...]  #: Faces of each by kind of surface.
    vertices: tuple[FloatArray, ...]  #: shape (k, 3). Of each, in `part`, mm.
    marks: Counter[tuple[Any, ...]]  #: Faces, wires and edges with a name, a colour or a layer of their own.


def take_solids(part: StepPart, *, without: str = "") -> SolidsBefore:
    """Count what a file's solids hold; `without` is the name of an assembly whose marks are left out."""
    return SolidsBefore(
        tuple(
            ("" if solid.name == f"S{number}" else solid.name, solid.color_rgb, solid.layers)
            for number, solid in enumerate(part.solids, 1)
        ),
        tuple(Counter(surface_kind(face) for face in sub_shapes(solid.shape, FACE)) for solid in part.solids),
        tuple(vertex_points(solid.shape) for solid in part.solids),
        Counter((m.kind, m.name, m.color_rgb, m.layers) for m in part.marks if not without or without not in m.path),
    )


@dataclass(frozen=True, slots=True, eq=False)
class OwnMotions:
    """Motions of a part's solids, and what the solids were."""

    T_part_moved: FloatArray  #: shape (n, 4, 4).
    before: SolidsBefore

    def compare(
        self, again: StepPart, T_base_part: RigidTransform, inventory: StepInventory, *, without: str
    ) -> list[Issue]:
        """Differences between what should be in a file and what was read again; empty if there is none."""
        before, after = self.before, take_solids(again, without=without)
        if len(after.vertices) != len(before.vertices):
            what = f"{counted(len(before.vertices), 'solid')} before, {len(after.vertices)} after"
            return [Issue("moved-solids-differ", f"the written file differs in solids: {what}")]
        worst, which = max(
            (_off(T_base_part.matrix @ motion, old, new), look[0])
            for motion, old, new, look in zip(
                self.T_part_moved, before.vertices, after.vertices, before.looks, strict=True
            )
        )
        issues = []
        if worst > VERTEX_ATOL_MM:
            message = f"the written file has solid {which} off by {short(worst)} mm (allowed {VERTEX_ATOL_MM:g})"
            issues.append(Issue("moved-solids-differ", message))
        if before.surfaces != after.surfaces:
            issues.append(Issue("moved-faces-differ", "the written file differs in the faces of its solids"))
        return issues + self._other_differences(after, take_inventory(again.document, without=without), inventory)

    def _other_differences(self, after: SolidsBefore, now: StepInventory, inventory: StepInventory) -> list[Issue]:
        looks = [
            (old, new)
            for old, new in zip(self.before.looks, after.looks, strict=True)
            if old != (old[0] and new[0], *new[1:])
        ]
        lost = sorted(set(inventory.names) - set(now.names))
        found = [
            ("names", f"{looks[0][0]} before, {looks[0][1]} after" if looks else ""),
            ("products", ", ".join(lost[:5])),
            ("marks", _first(self.before.marks - after.marks)),
            ("annotations", _first(inventory.annotations - now.annotations)),
        ]
        return [
            Issue(f"moved-{what}-differ", f"the written file differs in {what}: {difference}")
            for what, difference in found
            if difference
        ]


def _first(lost: Counter[Any]) -> str:
    return ", ".join(f"{count} of {key}" for key, count in list(lost.items())[:3])


def _off(T: FloatArray, old: FloatArray, new: FloatArray) -> float:
    """Largest distance of a vertex from where it should be, mm; their order does not matter."""
    if len(old) != len(new):
        return float("inf")
    if not len(old):
        return 0.0
    expected = old @ T[:3, :3].T + T[:3, 3]
    worst = float(np.abs(expected - new).max())
    if worst <= VERTEX_ATOL_MM:
        return worst
    return nearest_mm(expected, new)
