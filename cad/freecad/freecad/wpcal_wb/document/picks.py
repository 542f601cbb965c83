# SPDX-License-Identifier: MIT
"""What was clicked in the 3-D view, in the coordinates of the part."""

from __future__ import annotations

from typing import Any, NamedTuple, Sequence

from .kinds import is_ours

AROUND = 0.02
"""Points beside a picked one on an edge, as a share of the edge: near enough to be on the same seam."""


class Pick(NamedTuple):
    """One thing that was clicked.

    Attributes
    ----------
    object : FreeCAD.DocumentObject
    name : str
        Its element: `Vertex3`, `Edge7`, `Face2`; of our own objects `V3` or `W1`.
    shape : Part.Shape or None
        The element in the coordinates of the document; None for our own objects.
    point : FreeCAD.Vector or None
        Where it was clicked, in the document.
    """

    object: Any
    name: str
    shape: Any
    point: Any


def picks_of(selection: Sequence[Any]) -> list[Pick]:
    """Return what is selected, element by element.

    Parameters
    ----------
    selection : sequence of Gui.SelectionObject
        From `Gui.Selection.getSelectionEx(document, 0)`: names from the outermost object on, so that shapes come in the
        coordinates of the document.
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
    """Return the point of an edge that is nearest to another, and one on each side of it, in the part.

    Parameters
    ----------
    edge : Part.Edge
        In the coordinates of the document.
    near : FreeCAD.Vector or None
        Where it was clicked; None means its middle.
    frame : FreeCAD.Placement
        Where the part lies in the document.
    """
    first, last = edge.ParameterRange
    middle = 0.5 * (first + last) if near is None else edge.Curve.parameter(near)
    aside = AROUND * (last - first)
    middle = min(max(middle, first + aside), last - aside)
    return [in_part(edge.valueAt(t), frame) for t in (middle, middle - aside, middle + aside)]


def in_part(point: Any, frame: Any) -> tuple[float, float, float]:
    """Return a point of the document in the coordinates of the part."""
    local = frame.inverse().multVec(point)
    return (local.x, local.y, local.z)
