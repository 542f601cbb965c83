"""A seam for scripts of build123d: its frames as locations and planes, its curve as a wire.

The wire holds the edges of the part themselves (lines, circles, ellipses, NURBS curves), cut to the seam, and not a
polyline through the frames.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from wpcal.brep import BrepGraph
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import CurveKind
from wpcal.brep.nurbs import NurbsCurve
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.seam import Seam
from wpcal.seam.seam import SeamFrames

if TYPE_CHECKING:
    from build123d import Location, Plane, Wire

VERTEX_MARGIN_MM = 1e-7
"""Tolerance of a vertex where two pieces meet, beyond half their gap: the kernel's own tolerance of a point."""


def seam_locations(frames: SeamFrames) -> list[Location]:
    """Return the frames of a seam as locations of build123d.

    Parameters
    ----------
    frames : SeamFrames
        n frames, mm; for example ``seam.frames`` in `part`, or ``seam.frames.moved(T_base_part)`` in `base`.

    Returns
    -------
    list of build123d.Location, length n
        x along the seam, z out of the joint, in the frame of `frames`.
    """
    from build123d import Location

    from cad.kernel.ocp import to_location

    poses = (RigidTransform(R, p, target=frames.frame, source="seam") for p, R in zip(frames.p, frames.R, strict=True))
    return [Location(to_location(pose)) for pose in poses]


def seam_planes(frames: SeamFrames) -> list[Plane]:
    """Return the frames of a seam as planes of build123d: ``x_dir`` along the seam, ``z_dir`` out of the joint.

    Parameters
    ----------
    frames : SeamFrames
        n frames, mm, as for `seam_locations`.

    Returns
    -------
    list of build123d.Plane, length n
        In the frame of `frames`.
    """
    from build123d import Plane

    rows = zip(frames.p.tolist(), frames.R[:, :, 0].tolist(), frames.R[:, :, 2].tolist(), strict=True)
    return [Plane(origin=p, x_dir=x, z_dir=z) for p, x, z in rows]


def seam_wire(graph: BrepGraph, seam: Seam, T_base_part: RigidTransform | None = None) -> Wire:
    """Return the curve of a seam as a wire of build123d, in the direction of travel.

    Parameters
    ----------
    graph : BrepGraph
        The graph in which the seam was found: ``found.workpiece.graph`` after `calibrate_workpiece`, the graph of the
        second result of `find_seams`, or that given to `detect_seams`.
    seam : Seam
        One that was found in that graph.
    T_base_part : RigidTransform, optional
        When given, the wire is in `base`; otherwise in `part`.

    Returns
    -------
    build123d.Wire
        One edge per piece of the seam, mm. Where two pieces end up to 0.01 mm apart, they share a vertex of that size.

    Raises
    ------
    InputError
        When the seam has no pieces: it was read from a file.
    KernelError
        When the kernel fails.
    """
    from build123d import Location, Wire
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Wire

    from cad.kernel.ocp import kernel_call, to_location

    pieces = seam.pieces
    if len(pieces) == 0:
        raise InputError(f"seam {seam.name} has no curve: it was read from a file; find it on the part")
    starts, ends = (evaluate_edges(graph, pieces.edge, t)[0] for t in (pieces.t0, pieces.t1))
    with kernel_call(f"making the wire of seam {seam.name}"):
        vertices = _vertices(starts, ends, closed=seam.closed)
        builder, wire = BRep_Builder(), TopoDS_Wire()
        builder.MakeWire(wire)
        for row, (first, last) in enumerate(pairwise(vertices)):
            curve, t0, t1 = _curve(graph, int(pieces.edge[row]), float(pieces.t0[row]), float(pieces.t1[row]))
            builder.Add(wire, _edge(curve, t0, t1, first, last))
        wire.Closed(seam.closed)
    found = Wire(wire)
    return found if T_base_part is None else found.moved(Location(to_location(T_base_part)))


def _vertices(starts: FloatArray, ends: FloatArray, *, closed: bool) -> list[Any]:
    """Return the vertices before, between and after the pieces; of a closed seam the last is the first."""
    after = np.concatenate([starts[1:], starts[:1] if closed else ends[-1:]])
    between = [
        _vertex((end + start) / 2.0, np.linalg.norm(start - end) / 2.0) for end, start in zip(ends, after, strict=True)
    ]
    return [between[-1] if closed else _vertex(starts[0], 0.0), *between]


def _vertex(point: FloatArray, gap_mm: float) -> Any:
    from OCP.BRep import BRep_Builder
    from OCP.gp import gp_Pnt
    from OCP.TopoDS import TopoDS_Vertex

    vertex = TopoDS_Vertex()
    BRep_Builder().MakeVertex(vertex, gp_Pnt(*point.tolist()), float(gap_mm) + VERTEX_MARGIN_MM)
    return vertex


def _edge(curve: Any, t0: float, t1: float, first: Any, last: Any) -> Any:
    """Return the stretch of a curve from t0 to t1 > t0 between two vertices."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge

    return BRepBuilderAPI_MakeEdge(curve, first, last, t0, t1).Edge()


def _curve(graph: BrepGraph, edge: int, t0: float, t1: float) -> tuple[Any, float, float]:
    """Return the kernel's curve of an edge that runs with the seam, and the parameters of the piece's ends."""
    from OCP.Geom import Geom_Circle, Geom_Ellipse, Geom_Line
    from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt

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


def _nurbs(curve: NurbsCurve) -> Any:
    from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_int
    from OCP.Geom import Geom_BSplineCurve
    from OCP.gp import gp_Pnt

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
