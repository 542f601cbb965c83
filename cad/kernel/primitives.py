"""Boxes, cylinders, prisms and tubes, and one shape without others: what sample parts are made of. Lengths are mm."""

from __future__ import annotations

import math
from collections.abc import Sequence

from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakePolygon,
    BRepBuilderAPI_MakeWire,
)
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakePrism, BRepPrimAPI_MakeTorus
from OCP.GC import GC_MakeArcOfCircle
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt, gp_Vec
from OCP.TopoDS import TopoDS

from cad.kernel.call import KernelObject
from cad.kernel.topology import only_solid

Point = tuple[float, float, float]


def box(x: float, y: float, z: float, corner: Point) -> KernelObject:
    """Return a box along the axes from its least corner, mm."""
    return BRepPrimAPI_MakeBox(gp_Pnt(*corner), x, y, z).Solid()


def cylinder(radius: float, length: float, origin: Point, axis: Point) -> KernelObject:
    """Return a cylinder from the centre of one end along an axis, mm."""
    return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(*origin), gp_Dir(*axis)), radius, length).Solid()


def ring(radius: float, bar: float, centre: Point, *, turn: float = 2.0 * math.pi) -> KernelObject:
    """Return a ring of a round bar round an axis along z, or a part of it; radii of centre line and bar, mm."""
    return BRepPrimAPI_MakeTorus(gp_Ax2(gp_Pnt(*centre), gp_Dir(0, 0, 1)), radius, bar, turn).Solid()


def prism(corners: Sequence[Point], along: Point) -> KernelObject:
    """Return a polygon extruded by a vector, mm."""
    polygon = BRepBuilderAPI_MakePolygon()
    for corner in corners:
        polygon.Add(gp_Pnt(*corner))
    polygon.Close()
    return only_solid(BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(polygon.Wire()).Face(), gp_Vec(*along)).Shape())


def cut(shape: KernelObject, *tools: KernelObject) -> KernelObject:
    """Return the one solid that is left of `shape` without `tools`."""
    for tool in tools:
        shape = BRepAlgoAPI_Cut(shape, tool).Shape()
    return only_solid(shape)


def square_tube(
    side: float, length: float, corner: Point, axis: str, *, wall: float, corner_radius: float
) -> KernelObject:
    """Return a square tube with rounded edges, from the corner of its start along ``x``, ``y`` or ``z``, mm."""
    way = "xyz".index(axis)
    profile = BRepBuilderAPI_MakeFace(_round_square(side, corner_radius, 0.0, corner, way), True)
    bore = _round_square(side, corner_radius, wall, corner, way)
    profile.Add(TopoDS.Wire(bore.Reversed()))
    along = gp_Vec(*(length if k == way else 0.0 for k in range(3)))
    return only_solid(BRepPrimAPI_MakePrism(profile.Face(), along).Shape())


def _round_square(side: float, corner_radius: float, inset: float, corner: Point, way: int) -> KernelObject:
    """Return a square wire with rounded corners in the plane normal to an axis, `inset` inside the tube's outline."""

    def at(u: float, v: float) -> KernelObject:
        p = list(corner)
        p[(way + 1) % 3] += u
        p[(way + 2) % 3] += v
        return gp_Pnt(*p)

    wire = BRepBuilderAPI_MakeWire()
    near, far = corner_radius, side - corner_radius
    centres = [(near, near), (far, near), (far, far), (near, far)]
    radius, half = corner_radius - inset, math.sqrt(0.5)
    directions = [(0, -1), (1, 0), (0, 1), (-1, 0)]
    for k, (u, v) in enumerate(centres):
        (au, av), (bu, bv) = directions[k - 1], directions[k]
        start, end = at(u + radius * au, v + radius * av), at(u + radius * bu, v + radius * bv)
        middle = at(u + radius * half * (au + bu), v + radius * half * (av + bv))
        wire.Add(BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(start, middle, end).Value()).Edge())
        nu, nv = centres[(k + 1) % 4]
        wire.Add(BRepBuilderAPI_MakeEdge(end, at(nu + radius * bu, nv + radius * bv)).Edge())
    return wire.Wire()
