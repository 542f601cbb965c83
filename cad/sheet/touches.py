"""Touches on a teach sheet: of a plan, or of a table with the column ``kind``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cad.workpiece.workpiece import Workpiece
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes
from wpcal.core.tables import Table, parse_table
from wpcal.taught.columns import MODEL_COLUMNS, USES
from wpcal.taught.features import feature_named
from wpcal.taught.kinds import KINDS, TouchKind
from wpcal.taught.touched_face import TouchedFace, touched_face
from wpcal.touch.searches import SearchKind, TouchPlan

OFF_PART_MM = 5.0  #: A model point farther from every face was not taken on this part: such points are near the touch.
Xyz = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class SheetTouch:
    """One touch to draw."""

    name: str
    kind: str  #: Word of a taught table.
    feature: str = ""  #: Its name, or empty.
    p_part: Xyz | None = None  #: The point that is touched, mm; None for that of the feature.
    #: Unit vector of the move towards the face; None if the face decides, or on edges and at points.
    way_part: Xyz | None = None
    how: str = ""  #: How it is touched, in words.


@dataclass(frozen=True, slots=True)
class DrawnTouch:
    """One touch with its place."""

    name: str
    kind: str
    where: str
    p_part: Xyz  #: mm.
    way_part: Xyz | None

    def to_record(self) -> dict[str, Any]:
        """Return the touch as the record of a sheet holds it."""
        way = None if self.way_part is None else list(self.way_part)
        return {"name": self.name, "kind": self.kind, "p_mm": list(self.p_part), "way": way, "words": self.where}


def touches_of_plan(plan: TouchPlan) -> tuple[SheetTouch, ...]:
    """Return the touches of a plan on the part, in their order."""
    return tuple(
        SheetTouch(each.name, each.target, each.feature, _xyz(each.contact_part), _xyz(each.direction), how)
        for each in plan.searches
        for how in [f"wire {each.contact.value}, {each.stroke_mm:.0f} mm"]
        if each.kind is SearchKind.PART
    )


def read_touches_to_make(path: Path) -> tuple[SheetTouch, ...] | None:
    """Return the touches of a table, in its order; rows may still lack their coordinates.

    Returns tuple of SheetTouch or None. None for a table without touches on faces or edges.
    Raises `FormatError` when a row has neither a feature nor a model point, or an unknown word.
    """
    table = parse_table(read_bytes(path), path=str(path))
    if not table.has("name", "kind"):
        return None
    kinds = table.choices("kind", tuple(KINDS), default=TouchKind.POINT.value)
    if all(KINDS[word] is TouchKind.POINT for word in kinds):
        return None
    use = table.choices("use", USES, default="yes")
    rows = [row for row, word in enumerate(use) if word != "no"]
    return tuple(_of_row(table, row, kinds[row]) for row in rows)


def _of_row(table: Table, row: int, kind: str) -> SheetTouch:
    name = table.columns["name"][row]
    feature = table.columns["feature"][row] if table.has("feature") else ""
    if table.has(*MODEL_COLUMNS):
        place = table.numbers_where_given(MODEL_COLUMNS)[row]
        if not np.isnan(place).any():
            return SheetTouch(name, kind, feature, _xyz(place))
    if not feature:
        what = "names neither a feature nor a model point, so it cannot be drawn"
        raise FormatError(what, path=table.path, line=table.lines[row])
    return SheetTouch(name, kind, feature)


def drawn_touches(touches: Sequence[SheetTouch], workpiece: Workpiece) -> tuple[DrawnTouch, ...]:
    """Find the place and the way of every touch on a part.

    Raises `InputError` when the part has no feature of a name, or a touch is away from it.
    """
    return tuple(_drawn(touch, workpiece) for touch in touches)


def _drawn(touch: SheetTouch, workpiece: Workpiece) -> DrawnTouch:
    point = touch.p_part
    if point is None:
        point = _xyz(feature_named(workpiece.features, touch.feature).p_mm)
    way, solid = touch.way_part, ""
    if KINDS[touch.kind].surfaces:
        found = face_at(workpiece, point, way, what=f"touch {touch.name}")
        way = _xyz(-found.normal_part) if way is None else way
        solid = f"of {workpiece.graph.solid_names[workpiece.graph.face_solid[found.face]]}"
    words = " ".join(word for word in (touch.kind, touch.feature or solid) if word)
    return DrawnTouch(touch.name, touch.kind, ", ".join(filter(None, (words, touch.how))), point, way)


def face_at(workpiece: Workpiece, point: Xyz, way: Xyz | None, *, what: str) -> TouchedFace:
    """Return the face at a point of a touch or a weld; `InputError` if there is none: it is of another part."""
    found = touched_face(workpiece.trimmed, np.array(point), None if way is None else -np.array(way))
    off_mm = float(np.linalg.norm(found.p_part - np.array(point)))
    if off_mm > OFF_PART_MM:
        raise InputError(f"{what} is {off_mm:.0f} mm from the nearest face of this part; is it of another part?")
    return found


def _xyz(values: Any) -> Xyz:
    x, y, z = (round(float(v), 6) + 0.0 for v in values)
    return x, y, z
