"""Curves of a `BrepGraph` as shapes of the kernel: the way back from `to_brep`."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_int
from OCP.Geom import Geom_BSplineCurve, Geom_Circle, Geom_Ellipse, Geom_Line
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt
from OCP.TopoDS import TopoDS_Vertex, TopoDS_Wire

from cad.kernel.call import KernelObject, kernel_call
from wpcal.brep import BrepGraph
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import CurveKind
from wpcal.brep.nurbs import NurbsCurve
from wpcal.core.arrays import FloatArray, IntArray

VERTEX_MARGIN_MM = 1e-7
"""Tolerance of a vertex where two pieces meet, beyond half their gap: the kernel's own tolerance of a point."""


def make_wire(
    graph: BrepGraph, edge: IntArray, t0: FloatArray, t1: FloatArray, *, closed: bool, what: str
) -> KernelObject:
    """Return a wire of the kernel through pieces of edges of a graph, one edge per piece, in the order given.

    Raises `KernelError` when the kernel fails.

    `edge`: shape (k,). Edges of the graph; each piece begins where the one before ends.
    `t0`, `t1`: shape (k,). Parameters at the start and the end of each piece; t1 < t0 runs against the edge.

    Returns: In `part`, mm. Every edge runs forward. If two pieces do not meet exactly, their vertex is as large as the
    gap.
    """
    starts, ends = (evaluate_edges(graph, edge, t)[0] for t in (t0, t1))
    rows = zip(edge.tolist(), t0.tolist(), t1.tolist(), strict=True)
    with kernel_call(f"making the wire of {what}"):
        vertices = _vertices(starts, ends, closed=closed)
        builder, wire = BRep_Builder(), TopoDS_Wire()
        builder.MakeWire(wire)
        for (own, first, last), ends_of in zip(rows, pairwise(vertices), strict=True):
            curve, begin, end = _curve(graph, own, first, last)
            builder.Add(wire, BRepBuilderAPI_MakeEdge(curve, *ends_of, begin, end).Edge())
        wire.Closed(closed)
    return wire


def _vertices(starts: FloatArray, ends: FloatArray, *, closed: bool) -> list[KernelObject]:
    """Return the vertices before, between and after the pieces; of a closed seam the last is the first."""
    after = np.concatenate([starts[1:], starts[:1] if closed else ends[-1:]])
    between = [
        _vertex((end + start) / 2.0, float(np.linalg.norm(start - end)) / 2.0)
        for end, start in zip(ends, after, strict=True)
    ]
    return [between[-1] if closed else _vertex(starts[0], 0.0), *between]


def _vertex(point: FloatArray, gap_mm: float) -> KernelObject:
    vertex = TopoDS_Vertex()
    BRep_Builder().MakeVertex(vertex, gp_Pnt(*point.tolist()), gap_mm + VERTEX_MARGIN_MM)
    return vertex


def _curve(graph: BrepGraph, edge: int, t0: float, t1: float) -> tuple[KernelObject, float, float]:
    """Return the kernel's curve of an edge that runs with the seam, and the parameters of the piece's ends."""
    origin, x, y, _ = graph.edge_frame[edge]
    a, b = graph.edge_param[edge].tolist()
    kind = graph.edge_kind[edge]
    if kind == CurveKind.NURBS:
        curve = _nurbs(graph.nurbs_curves[graph.edge_nurbs[edge]])
    elif kind == CurveKind.LINE:
        curve = Geom_Line(gp_Ax1(gp_Pnt(*origin.tolist()), gp_Dir(*x.tolist())))
    else:
        axes = gp_Ax2(gp_Pnt(*origin.tolist()), gp_Dir(*np.cross(x, y).tolist()), gp_Dir(*x.tolist()))
        curve = Geom_Circle(axes, a) if kind == CurveKind.CIRCLE else Geom_Ellipse(axes, a, b)
    if t1 >= t0:
        return curve, t0, t1
    return curve.Reversed(), curve.ReversedParameter(t0), curve.ReversedParameter(t1)


def _nurbs(curve: NurbsCurve) -> KernelObject:
    knots, counts = np.unique(curve.knots, return_counts=True)
    poles, weights = Array1_gp_Pnt(1, len(curve.poles)), Array1_double(1, len(curve.poles))
    for i, (pole, weight) in enumerate(zip(curve.poles.tolist(), curve.weights.tolist(), strict=True), 1):
        poles.SetValue(i, gp_Pnt(*pole))
        weights.SetValue(i, weight)
    values, repeated = Array1_double(1, len(knots)), Array1_int(1, len(knots))
    for i, (knot, count) in enumerate(zip(knots.tolist(), counts.tolist(), strict=True), 1):
        values.SetValue(i, knot)
        repeated.SetValue(i, count)
    return Geom_BSplineCurve(poles, weights, values, repeated, curve.degree)
