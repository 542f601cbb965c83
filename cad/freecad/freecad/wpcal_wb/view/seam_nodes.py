# SPDX-License-Identifier: MIT
"""Nodes of Coin for the directions of seams and for features: a few nodes, however many seams there are."""

from __future__ import annotations

import math
from typing import Any, Sequence

from pivy import coin

from .colours import UNKNOWN, Colour, unit

Point = Sequence[float]

ARROW_SHARE = 0.03  #: Length of an arrow, as a share of the size of all seams together.
ARROWS_APART = 8  #: Arrows along a long seam are this many arrow lengths apart.
ACCEPTED = unit((194, 65, 12))
REFUSED = unit(UNKNOWN)
CHOSEN = unit((29, 95, 168))
EASY = unit((47, 123, 217))  #: A feature with a sharp corner or rim.
HARD = unit((125, 138, 152))  #: The colours of wpcal's pages.


def arrows(seams: Sequence[tuple[dict[str, Any], Colour]], length_mm: float) -> tuple[Any, list[int]]:
    """Return arrowheads along seams as one set of triangles, and to which seam each triangle belongs.

    `seams`: sequence of (frames, colour).
    """
    points: list[Point] = []
    owners: list[int] = []
    for number, (frames, _) in enumerate(seams):
        for place in _arrow_places(frames["s"], length_mm):
            corners = _arrow(frames["p"][place], frames["R"][place], length_mm)
            points += corners
            owners += [number] * (len(corners) // 3)
    root = _unlit()
    root.addChild(_material([seams[owner][1] for owner in owners]))
    root.addChild(_binding(coin.SoMaterialBinding.PER_FACE))
    root.addChild(_coordinates(points))
    faces = coin.SoFaceSet()
    faces.numVertices.setNum(len(owners))
    faces.numVertices.setValues(0, len(owners), [3] * len(owners))
    root.addChild(faces)
    return root, owners


def markers(points: Sequence[Point], colours: Sequence[Colour], marker: int | None = None) -> Any:
    """Return points as one set of markers of constant size on the screen."""
    root = _unlit()
    root.addChild(_material(colours))
    root.addChild(_binding(coin.SoMaterialBinding.PER_VERTEX))
    root.addChild(_coordinates(points))
    marks = coin.SoMarkerSet()
    marks.markerIndex = coin.SoMarkerSet.CIRCLE_FILLED_7_7 if marker is None else marker
    marks.numPoints = len(points)
    root.addChild(marks)
    return root


def size_mm(paths: Sequence[Sequence[Point]]) -> float:
    """Return the diagonal of the box around all points, mm; 0 without points."""
    points = [point for path in paths for point in path]
    if not points:
        return 0.0
    return math.sqrt(sum((max(column) - min(column)) ** 2 for column in zip(*points)))


def transform(placement: Any) -> Any:
    """Return a placement of FreeCAD as a node."""
    node = coin.SoTransform()
    node.translation.setValue(tuple(placement.Base))
    node.rotation.setValue(coin.SbRotation(*placement.Rotation.Q))
    return node


def _unlit() -> Any:
    root = coin.SoSeparator()
    light = coin.SoLightModel()
    light.model = coin.SoLightModel.BASE_COLOR
    root.addChild(light)
    return root


def _material(colours: Sequence[Colour]) -> Any:
    node = coin.SoMaterial()
    if colours:
        node.diffuseColor.setValues(0, len(colours), [tuple(one) for one in colours])
    return node


def _binding(value: int) -> Any:
    node = coin.SoMaterialBinding()
    node.value = value
    return node


def _coordinates(points: Sequence[Point]) -> Any:
    node = coin.SoCoordinate3()
    node.point.setNum(len(points))
    if points:
        node.point.setValues(0, len(points), [tuple(point) for point in points])
    return node


def _arrow_places(s: Sequence[float], length_mm: float) -> list[int]:
    """Return the frames at which a seam gets an arrow: at its middle, and further ones on a long seam."""
    count = max(1, round(s[-1] / (ARROWS_APART * length_mm))) if length_mm else 1
    targets = [s[-1] * (i + 0.5) / count for i in range(count)]
    return sorted({min(range(len(s)), key=lambda k: abs(s[k] - target)) for target in targets})


def _arrow(p: Point, R: Sequence[Point], length_mm: float) -> list[Point]:
    """Return the triangles of a pyramid that points in the direction of travel and stands clear of the faces."""
    x, y, z = ([row[axis] for row in R] for axis in range(3))
    middle = [p[i] + 0.5 * length_mm * z[i] for i in range(3)]
    tip = [middle[i] + 0.5 * length_mm * x[i] for i in range(3)]
    foot = [middle[i] - 0.5 * length_mm * x[i] for i in range(3)]
    wide = 0.3 * length_mm
    ring = [[foot[i] + wide * (a * y[i] + b * z[i]) for i in range(3)] for a, b in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    corners: list[Point] = []
    for one, other in zip(ring, [*ring[1:], ring[0]]):
        corners += [tip, one, other, foot, other, one]
    return corners
