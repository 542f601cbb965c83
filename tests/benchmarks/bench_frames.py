"""Frames of seams: microseconds a frame on analytic faces and on B-splines, beside the kernel called from Python.

A frame is point, tangent, the normals of two faces and the axes made of them (`wpcal.seam.path.frames.seam_frames`).
The kernel is asked for the same numbers as it would be without `BrepGraph`: `BRepAdaptor_Curve.D1`, then for each face
the nearest point (`ShapeAnalysis_Surface`, with the point before as start) and `D1` there.
"""

from functools import partial
from typing import Any

import numpy as np
from rich.table import Table

from cad.kernel.to_brep import to_brep
from cad.kernel.topology import EDGE, FACE, sub_shape_uses
from cad.samples.parts import box, cut, cylinder
from tests.benchmarks.timing import least_seconds
from wpcal.brep import BrepGraph, CurveKind, SurfaceKind
from wpcal.seam.path.discretise import Stations
from wpcal.seam.path.frames import seam_frames
from wpcal.seam.seam import SeamPieces

FRAMES = 20_000
KERNEL_FRAMES = 500  #: So many are enough to time the kernel's calls.
REPEATS = 5  #: The least of so many runs counts: other work on the machine only ever adds.
ON_CURVE_MM = 1e-6  #: The kernel's feet are those of the same points.


def main() -> Table:
    table = Table("faces", "asked", "wpcal", "kernel from Python", "ratio", title="Processor time a frame, µs")
    for name, asked, shape, kind in (
        ("plane and cylinder", 10.0, bored_plate(), CurveKind.CIRCLE),
        ("B-spline surfaces", 40.0, wavy_block(), CurveKind.NURBS),
    ):
        graph = to_brep([("part", shape)])
        edge = int(np.flatnonzero(graph.edge_kind == kind)[0])
        faces = faces_beside(graph, edge)
        mine = least_seconds(partial(frames, graph, edge, faces), REPEATS) / FRAMES
        kernel = least_seconds(partial(kernel_frames, shape, graph, edge, faces), REPEATS) / KERNEL_FRAMES
        table.add_row(name, f"≤ {asked:.0f}", f"{mine * 1e6:.2f}", f"{kernel * 1e6:.1f}", f"{mine / kernel:.3f}")
    return table


def bored_plate() -> Any:
    return cut(box(60, 40, 10, (0, 0, 0)), cylinder(8, 10, (20, 20, 0), (0, 0, 1)))


def wavy_block() -> Any:
    """Return a loft through four wavy rings: its side is a B-spline that is no elementary surface."""
    from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections

    loft = BRepOffsetAPI_ThruSections(True, False)
    for height, stretch in ((0.0, 1.0), (10.0, 1.4), (20.0, 0.9), (30.0, 1.2)):
        loft.AddWire(wavy_ring(height, stretch))
    return loft.Shape()


def wavy_ring(height: float, stretch: float) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire
    from OCP.collections import HArray1_gp_Pnt
    from OCP.GeomAPI import GeomAPI_Interpolate
    from OCP.gp import gp_Pnt

    angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    points = HArray1_gp_Pnt(1, len(angles))
    for i, angle in enumerate(angles.tolist(), 1):
        r = stretch * (20 + 3 * np.cos(3 * angle))
        points.SetValue(i, gp_Pnt(float(r * np.cos(angle)), float(r * np.sin(angle)), height))
    curve = GeomAPI_Interpolate(points, True, 1e-9)
    curve.Perform()
    return BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(curve.Curve()).Edge()).Wire()


def faces_beside(graph: BrepGraph, edge: int) -> tuple[int, int]:
    """Return the faces of an edge; where one of them is a B-spline, that one twice."""
    left, right = graph.edge_faces[edge].tolist()
    free = [face for face in (left, right) if graph.face_kind[face] == SurfaceKind.NURBS]
    return (free[0], free[0]) if free else (left, right)


def frames(graph: BrepGraph, edge: int, faces: tuple[int, int]) -> None:
    """Build many frames along one edge."""
    first, last = graph.edge_range[edge]
    wall, base = (np.array([face]) for face in faces)
    span = np.array([first]), np.array([last])
    pieces = SeamPieces(np.array([edge]), *span, wall, base, np.zeros((1, 3)))
    t = np.linspace(first, last, FRAMES)
    seam_frames(graph, pieces, Stations(np.array([0, FRAMES]), np.zeros(FRAMES, dtype=np.int64), t, t))


def kernel_frames(shape: Any, graph: BrepGraph, edge: int, faces: tuple[int, int]) -> None:
    """Ask the kernel for point, tangent and normals along the same edge."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.gp import gp_Pnt, gp_Vec
    from OCP.ShapeAnalysis import ShapeAnalysis_Surface

    from cad.kernel.topology import EdgeMap

    edges, kernel_faces = EdgeMap(), [face for face, _ in sub_shape_uses(shape, FACE)]
    for face in kernel_faces:
        for kernel_edge, _ in sub_shape_uses(face, EDGE):
            edges.add(kernel_edge)
    curve = BRepAdaptor_Curve(list(edges.shapes())[edge])
    surfaces = [BRep_Tool.Surface_s(kernel_faces[face]) for face in faces]
    finders = [ShapeAnalysis_Surface(surface) for surface in surfaces]
    p, slope, foot, du, dv = gp_Pnt(), gp_Vec(), gp_Pnt(), gp_Vec(), gp_Vec()
    uv = [finder.ValueOfUV(curve.Value(curve.FirstParameter()), 1e-7) for finder in finders]
    for t in np.linspace(curve.FirstParameter(), curve.LastParameter(), KERNEL_FRAMES).tolist():
        curve.D1(t, p, slope)
        for k, (finder, surface) in enumerate(zip(finders, surfaces, strict=True)):
            uv[k] = finder.NextValueOfUV(uv[k], p, 1e-7)
            surface.D1(uv[k].X(), uv[k].Y(), foot, du, dv)
            du.Crossed(dv)
            if foot.Distance(p) > ON_CURVE_MM:
                raise RuntimeError(f"a foot {foot.Distance(p):.1e} mm away from its point")
