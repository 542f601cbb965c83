"""Solids fused, edges filleted, discs whose rim has many arcs: more shapes for test parts. Lengths are mm."""

from __future__ import annotations

import math
from collections.abc import Callable

from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
from OCP.gp import gp_Ax2, gp_Circ, gp_Dir, gp_Pnt, gp_Vec
from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

from cad.kernel.call import KernelObject
from cad.kernel.primitives import Point
from cad.kernel.topology import EDGE, only_solid, sub_shape_uses


def fused(a: KernelObject, b: KernelObject, *, unified: bool = True) -> KernelObject:
    """Return two solids as one; `unified` merges faces that lie in one surface."""
    union = BRepAlgoAPI_Fuse(a, b).Shape()
    if unified:
        merged = ShapeUpgrade_UnifySameDomain(union, True, True, False)
        merged.Build()
        union = merged.Shape()
    return only_solid(union)


def filleted(shape: KernelObject, radius: float, on_edge: Callable[[float, float, float], bool]) -> KernelObject:
    """Return a solid with rounds along the edges whose middle point `on_edge` accepts."""
    fillet = BRepFilletAPI_MakeFillet(shape)
    for edge, _ in sub_shape_uses(shape, EDGE):
        curve = BRepAdaptor_Curve(edge)
        p = curve.Value((curve.FirstParameter() + curve.LastParameter()) / 2)
        if on_edge(p.X(), p.Y(), p.Z()):
            fillet.Add(radius, edge)
    return only_solid(fillet.Shape())


def disc(radius: float, height: float, centre: Point, *, arcs: int) -> KernelObject:
    """Return an upright disc from the centre of its lower face; its rim consists of many equal arcs."""
    circle, wire = gp_Circ(gp_Ax2(gp_Pnt(*centre), gp_Dir(0, 0, 1)), radius), BRepBuilderAPI_MakeWire()
    turn = 2 * math.pi / arcs
    for i in range(arcs):
        wire.Add(BRepBuilderAPI_MakeEdge(circle, i * turn, (i + 1) * turn).Edge())
    face = BRepBuilderAPI_MakeFace(wire.Wire()).Face()
    return only_solid(BRepPrimAPI_MakePrism(face, gp_Vec(0, 0, height)).Shape())
