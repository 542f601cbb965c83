"""Shapes that the generated parts are made of, by build123d; each is one kernel solid, mm."""

from collections.abc import Sequence
from typing import Any

from build123d import Align, Axis, Box, Cylinder, Face, Plane, Pos, Rot, Solid, Vector, Wire, extrude

STEEL, DARK, BRIGHT = (0.45, 0.5, 0.55), (0.2, 0.3, 0.45), (0.75, 0.75, 0.78)
WOOD, BLACK, CAST = (0.7, 0.5, 0.25), (0.05, 0.05, 0.05), (0.3, 0.32, 0.3)


def block(low: Sequence[float], high: Sequence[float]) -> Any:
    """Return a box between two corners."""
    size = [b - a for a, b in zip(low, high, strict=True)]
    return Pos(*low) * Box(*size, align=(Align.MIN, Align.MIN, Align.MIN))


def rod(radius: float, start: Sequence[float], axis: Sequence[float], length: float) -> Any:
    """Return a cylinder from the centre of one end."""
    plane = Plane(origin=tuple(start), z_dir=tuple(axis))
    return plane * Cylinder(radius, length, align=(Align.CENTER, Align.CENTER, Align.MIN))


def pipe(radius: float, wall: float, start: Sequence[float], axis: Sequence[float], length: float) -> Any:
    """Return a round tube from the centre of one end."""
    return rod(radius, start, axis, length) - rod(radius - wall, start, axis, length)


def plate(outline: Sequence[Sequence[float]], along: Sequence[float]) -> Any:
    """Return a polygon in space, extruded by a vector."""
    way = Vector(*along)
    face = Face(Wire.make_polygon([Vector(*point) for point in outline], close=True))
    return extrude(face, way.length, dir=way.normalized())


def turned(shape: Any, degrees: float) -> Any:
    """Return a shape turned about the z axis."""
    return Rot(0, 0, degrees) * shape


def rolled(low: Sequence[float], high: Sequence[float], axis: str, *, wall: float, radius: float) -> Any:
    """Return a rectangular tube along an axis; its edges have `radius` outside and `radius - wall` inside."""
    way = "xyz".index(axis)
    along = (Axis.X, Axis.Y, Axis.Z)[way]
    outer = block(low, high)
    inner = block(*([c + s * wall * (k != way) for k, c in enumerate(corner)] for corner, s in ((low, 1), (high, -1))))
    outer = outer.fillet(radius, outer.edges().filter_by(along))
    inner = inner.fillet(radius - wall, inner.edges().filter_by(along))
    return outer - inner


def solid_of(shape: Any) -> Any:
    """Return the kernel's solid of a shape that is one."""
    solids: list[Solid] = list(shape.solids())
    assert len(solids) == 1, f"{len(solids)} solids"
    return solids[0].wrapped
