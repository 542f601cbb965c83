# SPDX-License-Identifier: MIT
"""What was clicked in the 3-D view, in the coordinates of the part."""

from __future__ import annotations

import math
from typing import Any, Callable, Iterable, NamedTuple, Sequence

import FreeCAD

from .kinds import is_ours

AROUND = 0.02  #: Points beside a picked one on an edge, as a share of the edge: near enough to be on the same seam.
MARKER_PX = 6  #: A click so near to the middle of a marker is meant for it: a marker has 7 pixels.
MOST_NEAR = 8  #: This many features around a click are looked at. One far behind it can be at the same pixel.


class Pick(NamedTuple):
    """One thing that was clicked."""

    object: Any
    name: str  #: Its element: `Vertex3`, `Edge7`, `Face2`; of our own objects `V3` or `W1`.
    shape: Any  #: The element in the coordinates of the document; None for our own objects.
    point: Any  #: Where it was clicked, in the document.


def picks_of(selection: Sequence[Any]) -> list[Pick]:
    """Return what is selected, element by element.

    `selection`: From `Gui.Selection.getSelectionEx(document, 0)`: names from the outermost object on, so that shapes
    come in the coordinates of the document.
    """
    import Part

    picks = []
    for one in selection:
        points = list(one.PickedPoints) or [None] * len(one.SubElementNames)
        for name, point in zip(one.SubElementNames, points):
            element = name.split(".")[-1]
            if is_ours(one.Object):
                picks.append(Pick(one.Object, element, None, point))
            elif element.rstrip("0123456789") in ("Vertex", "Edge", "Face"):
                picks.append(Pick(one.Object, element, Part.getShape(one.Object, name, needSubElement=True), point))
    return picks


def edge_points(edge: Any, near: Any, frame: Any) -> list[tuple[float, float, float]]:
    """Return the point of an edge that is nearest to another, and one on each side of it, in the part."""
    first, last = edge.ParameterRange
    at = 0.5 * (first + last) if near is None else min(max(edge.Curve.parameter(near), first), last)
    aside = AROUND * (last - first)
    beside = (max(at - aside, first), min(at + aside, last))
    return [in_part(edge.valueAt(t), frame) for t in (at, *beside)]


def in_part(point: Any, frame: Any) -> tuple[float, float, float]:
    """Return a point of the document in the coordinates of the part."""
    local = frame.inverse().multVec(point)
    return (local.x, local.y, local.z)


def feature_under(
    point: Any, features: Iterable[dict[str, Any]], frame: Any, on_screen: Callable[[Any], Sequence[float]]
) -> str | None:
    """Return the feature whose marker was clicked although FreeCAD took the face or edge before it."""
    place = in_part(point, frame)
    near = sorted(features, key=lambda one: math.dist(one["p_mm"], place))[:MOST_NEAR]
    pixel = on_screen(point)
    found = [(math.dist(on_screen(frame.multVec(FreeCAD.Vector(*one["p_mm"]))), pixel), one["name"]) for one in near]
    distance, name = min(found, default=(math.inf, ""))
    return name if distance <= MARKER_PX else None


class Touch(NamedTuple):
    """What a click means as a taught point, in the part."""

    place: tuple[float, float, float]  #: mm.
    kind: str = ""  #: The kind of the row; empty for a point.
    #: Outward normal of the face; wpcal says which kind of surface it is.
    normal: tuple[float, float, float] | None = None


def touch_of(pick: Pick, frame: Any) -> Touch:
    """Return what a click on the model means: a corner, the centre of a circle, a place on an edge or on a face."""
    shape = pick.shape
    if shape.ShapeType == "Vertex":
        return Touch(in_part(shape.Point, frame))
    if shape.ShapeType == "Edge":
        centre = getattr(shape.Curve, "Center", None)
        if centre is not None:
            return Touch(in_part(centre, frame))
        return Touch(edge_points(shape, pick.point, frame)[0], "edge")
    surface = shape.Surface
    at = shape.CenterOfMass if pick.point is None else pick.point
    u, v = surface.parameter(at)
    normal = frame.inverse().Rotation.multVec(shape.normalAt(u, v))
    return Touch(in_part(surface.value(u, v), frame), "face", (normal.x, normal.y, normal.z))
