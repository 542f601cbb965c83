# SPDX-License-Identifier: MIT
"""How each solid of the model moved, if bodies moved.

The solids of wpcal are found in the document by their corners and the centres of their circles. Names do not tell: one
object can have several solids, and wpcal numbers equal names.
"""

from __future__ import annotations

from typing import Any, Iterator, Mapping, NamedTuple, Sequence

import FreeCAD
import Part

SAME_MM = 1e-3  #: Corners this near are one: both come from the same STEP file, with about 13 digits.


class MovedSolid(NamedTuple):
    """A solid and its motion, both in the coordinates of the part."""

    shape: Any
    move: Any  #: T_part_moved.


def moved_solids(
    objects: Sequence[Any], features: Sequence[Mapping[str, Any]], bodies: Sequence[Mapping[str, Any]]
) -> dict[str, list[MovedSolid] | None]:
    """Return how the solids of each object moved.

    Returns dict. By the name of the object. None if a solid of the object is not found, or was cut into several bodies.
    """
    moves = {name: body["T_part_moved"] for body in bodies for name in body["solids"]}
    solids = [(obj.Name, solid) for obj in objects for solid in Part.getShape(obj).Solids]
    names = _names_of([solid for _, solid in solids], features)
    found: dict[str, list[MovedSolid] | None] = {obj.Name: [] for obj in objects}
    for (owner, solid), name in zip(solids, names):
        own = found[owner]
        if name not in moves:
            found[owner] = None
        elif own is not None:
            matrix = FreeCAD.Matrix(*(value for row in moves[name] for value in row))
            own.append(MovedSolid(solid, FreeCAD.Placement(matrix)))
    return found


def _names_of(solids: Sequence[Any], features: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the name that wpcal gave to each solid; empty if it is not found."""
    places: dict[str, list[Any]] = {}
    for feature in features:
        if feature["kind"] in ("vertex", "circle"):
            places.setdefault(feature["solid"], []).append(FreeCAD.Vector(*feature["p_mm"]))
    names = [""] * len(solids)
    free = set(range(len(solids)))
    for name in sorted(places, key=lambda each: -len(places[each])):  # a bolt is in a hole with the same circles
        row = next((k for k in sorted(free) if _has_all(solids[k], places[name])), None)
        if row is not None:
            names[row] = name
            free.remove(row)
    return names


def _has_all(solid: Any, places: Sequence[Any]) -> bool:
    box = solid.BoundBox
    box.enlarge(SAME_MM)
    if not all(box.isInside(place) for place in places):
        return False
    own = list(_places_of(solid))
    return all(any(place.distanceToPoint(each) < SAME_MM for each in own) for place in places)


def _places_of(solid: Any) -> Iterator[Any]:
    yield from (vertex.Point for vertex in solid.Vertexes)
    for edge in solid.Edges:
        if isinstance(getattr(edge, "Curve", None), Part.Circle):
            yield edge.Curve.Center
