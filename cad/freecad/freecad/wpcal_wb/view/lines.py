# SPDX-License-Identifier: MIT
"""Nodes of Coin for many lines at once: a scene with one node per line would be slow to turn.

Places are triples of mm, in the coordinates of the node that the result is put into.
"""

from __future__ import annotations

import math
from typing import Sequence, Tuple

from pivy import coin

from .colours import Colour

Place = Sequence[float]
Path = Tuple[Sequence[Place], Sequence[Colour]]  #: A polyline: its places, and the colour at each of them.

AXIS_COLOURS: tuple[Colour, ...] = ((0.80, 0.10, 0.10), (0.10, 0.60, 0.15), (0.10, 0.25, 0.85))
"""x, y and z, as FreeCAD draws axes."""
BARB_PART = 0.18  #: Length of the head of an arrow, as a part of the arrow.
FACTORS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000)
"""Residuals are drawn longer than they are, by one of these."""
LONGEST_PART = 0.2  #: No residual is drawn longer than this part of the radius of everything.
NEARER = 0.996
"""Lines and marks are drawn in this share of the depth of the view. A wide line in a corner of faces would sink into
them to half its width."""
NEAREST = 0.994  #: What covers other lines on the same place, such as the errors along a seam.
ZERO_MM = 1e-9  #: A shorter vector has no direction.


def paths_node(paths: Sequence[Path], *, width: float, depth: float = NEARER) -> coin.SoSeparator:
    """Return one node that draws polylines with a colour at every place, in a share of the depth of the view."""
    places: list[Place] = []
    colours: list[Colour] = []
    index: list[int] = []
    for points, shades in paths:
        index += [*range(len(places), len(places) + len(points)), -1]
        places += points
        colours += shades
    node, lines = _line_node(places, colours, index, width, depth)
    lines.materialIndex.setValues(0, len(index), index)
    node.insertChild(_binding(coin.SoMaterialBinding.PER_VERTEX_INDEXED), 0)
    return node


def triads_node(poses: Sequence[tuple[Place, Sequence[Place]]], *, length: float) -> coin.SoSeparator:
    """Return one node that draws frames as three short lines each. `length`: Of an axis, mm."""
    places: list[Place] = []
    index: list[int] = []
    for place, axes in poses:
        first = len(places)
        places.append(place)
        for axis in range(3):
            places.append([value + length * row[axis] for value, row in zip(place, axes)])
            index += [first, first + 1 + axis, -1]
    node, lines = _line_node(places, AXIS_COLOURS, index, 2.0, NEARER)
    lines.materialIndex.setValues(0, 3 * len(poses), list(range(3)) * len(poses))
    node.insertChild(_binding(coin.SoMaterialBinding.PER_PART_INDEXED), 0)
    return node


def arrows_node(
    starts: Sequence[Place], vectors: Sequence[Place], *, factor: float, colour: Colour
) -> coin.SoSeparator:
    """Return one node that draws arrows from places along `factor` times vectors."""
    paths: list[Path] = []
    for start, vector in zip(starts, vectors):
        paths += [(pair, [colour, colour]) for pair in _arrow(start, [factor * value for value in vector])]
    return paths_node(paths, width=3.0)


def fitting_factor(longest_mm: float, radius_mm: float) -> int:
    """Return the largest factor by which a residual can be drawn beside a part of some radius."""
    fitting = [factor for factor in FACTORS if factor * max(longest_mm, ZERO_MM) <= LONGEST_PART * radius_mm]
    return fitting[-1] if fitting else FACTORS[0]


def _arrow(start: Place, vector: Place) -> list[Sequence[Place]]:
    length = math.sqrt(sum(value * value for value in vector))
    if length < ZERO_MM:
        return []
    x = [value / length for value in vector]
    aside = [0.0, 0.0, 0.0]
    aside[min(range(3), key=lambda axis: abs(x[axis]))] = 1.0
    y = _unit(_cross(x, aside))
    z = _cross(x, y)
    end = [a + b for a, b in zip(start, vector)]
    back = BARB_PART * length
    barbs = [
        [e - back * along + sign * 0.4 * back * across for e, along, across in zip(end, x, side)]
        for side in (y, z)
        for sign in (1, -1)
    ]
    return [(start, end), *((end, barb) for barb in barbs)]


def _cross(a: Place, b: Place) -> list[float]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _unit(vector: Place) -> list[float]:
    length = math.sqrt(sum(value * value for value in vector))
    return [value / length for value in vector]


def in_front(depth: float = NEARER) -> coin.SoDepthBuffer:
    """Return a node that draws what follows a little nearer to the viewer: in a share of the depth of the view."""
    node = coin.SoDepthBuffer()
    node.range = (0.0, depth)
    return node


def not_clickable() -> coin.SoPickStyle:
    """Return a node after which nothing is in the way of a click: it is meant for what lies below."""
    node = coin.SoPickStyle()
    node.style = coin.SoPickStyle.UNPICKABLE
    return node


def _binding(value: int) -> coin.SoMaterialBinding:
    binding = coin.SoMaterialBinding()
    binding.value = value
    return binding


def _line_node(
    places: Sequence[Place], colours: Sequence[Colour], index: Sequence[int], width: float, depth: float
) -> tuple[coin.SoSeparator, coin.SoIndexedLineSet]:
    node = coin.SoSeparator()
    node.renderCaching = coin.SoSeparator.ON
    light = coin.SoLightModel()
    light.model = coin.SoLightModel.BASE_COLOR  # lines have no side that could be lit
    style = coin.SoDrawStyle()
    style.lineWidth = width
    shades = coin.SoMaterial()
    shades.diffuseColor.setValues(0, len(colours), [tuple(colour) for colour in colours])
    coordinates = coin.SoCoordinate3()
    coordinates.point.setValues(0, len(places), [tuple(map(float, place)) for place in places])
    lines = coin.SoIndexedLineSet()
    lines.coordIndex.setValues(0, len(index), list(index))
    for child in (light, in_front(depth), style, shades, coordinates, lines):
        node.addChild(child)
    return node, lines
