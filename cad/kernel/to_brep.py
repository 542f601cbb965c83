"""Turn kernel shapes into a `BrepGraph` in one pass. The graph holds numbers only, no kernel objects."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.Geom import Geom_RectangularTrimmedSurface, Geom_TrimmedCurve
from OCP.GeomAbs import GeomAbs_CurveType as Curve
from OCP.GeomAbs import GeomAbs_Shape, GeomAbs_SurfaceType
from OCP.GeomAdaptor import GeomAdaptor
from OCP.GeomConvert import GeomConvert, GeomConvert_ApproxCurve
from OCP.gp import gp_Pnt, gp_Vec

from cad.kernel.call import kernel_call
from cad.kernel.canonical import SAME_SHAPE_MM, recognise_curve, recognise_surface
from cad.kernel.geometry import has_triangles_only
from cad.kernel.topology import EDGE, FACE, EdgeMap, VertexMap, sub_shape_uses
from wpcal.brep import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.extent import require_finite
from wpcal.brep.nurbs import NurbsCurve, NurbsSurface
from wpcal.brep.surfaces import surface_normals
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import KernelError

Row = tuple[int, list[list[float]], tuple[float, float]]
"""Kind, frame (origin, x, y, z) and parameters of one surface or curve."""
NO_FRAME = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
_ELEMENTARY = {
    GeomAbs_SurfaceType.GeomAbs_Plane: (SurfaceKind.PLANE, BRepAdaptor_Surface.Plane),
    GeomAbs_SurfaceType.GeomAbs_Cylinder: (SurfaceKind.CYLINDER, BRepAdaptor_Surface.Cylinder),
    GeomAbs_SurfaceType.GeomAbs_Cone: (SurfaceKind.CONE, BRepAdaptor_Surface.Cone),
    GeomAbs_SurfaceType.GeomAbs_Sphere: (SurfaceKind.SPHERE, BRepAdaptor_Surface.Sphere),
    GeomAbs_SurfaceType.GeomAbs_Torus: (SurfaceKind.TORUS, BRepAdaptor_Surface.Torus),
}
_LINE, _CIRCLE, _ELLIPSE = map(int, (Curve.GeomAbs_Line, Curve.GeomAbs_Circle, Curve.GeomAbs_Ellipse))

MOST_SPANS_AND_DEGREE = 200, 9  #: Of the spline that an offset curve is approximated with.
MOST_OFF_MM = 0.01  #: It is no farther from the curve.


@dataclass
class _Rows:
    """The rows of the graph's arrays, as the pass collects them."""

    face_solid: list[int] = field(default_factory=list)
    faces: list[Row] = field(default_factory=list)
    face_outward: list[float] = field(default_factory=list)
    face_nurbs: list[int] = field(default_factory=list)
    edges: list[Row] = field(default_factory=list)
    edge_range: list[tuple[float, float]] = field(default_factory=list)
    edge_vertices: list[tuple[int, int]] = field(default_factory=list)
    edge_nurbs: list[int] = field(default_factory=list)
    coedges: list[tuple[int, int, bool]] = field(default_factory=list)
    surfaces: list[NurbsSurface] = field(default_factory=list)
    curves: list[NurbsCurve] = field(default_factory=list)


def to_brep(solids: Iterable[tuple[str, Any]]) -> BrepGraph:
    """Turn placed kernel shapes into one `BrepGraph`.

    Raises `GeometryError` when a solid has geometry at infinity.
    Raises `KernelError` when the kernel fails on a face or an edge.

    `solids`: Name and shape of each solid (or open shell), located in `part`, mm.

    Returns: Faces, edges and vertices in the kernel's order, which is the same at every run. B-splines that are planes,
    cylinders, cones, spheres, lines or circles are stored as such.
    """
    rows, names = _Rows(), []
    edge_map, vertex_map = EdgeMap(), VertexMap()
    for index, (name, shape) in enumerate(solids):
        names.append(name)
        with kernel_call(f"reading the faces of {name!r}"):
            for face, is_forward in sub_shape_uses(shape, FACE):
                _add_face(rows, index, face, is_forward, edge_map)
    with kernel_call("reading the edges of the part"):
        for edge in edge_map.shapes():
            _add_edge(rows, edge, vertex_map)
    graph = _graph(names, rows, vertex_map.points())
    require_finite(graph)
    return graph


def _add_face(rows: _Rows, solid: int, face: Any, is_forward: bool, edge_map: EdgeMap) -> None:
    number = len(rows.faces)
    row, handed, nurbs = _surface(face)
    rows.face_solid.append(solid)
    rows.faces.append(row)
    rows.face_outward.append(handed if is_forward else -handed)
    rows.face_nurbs.append(-1 if nurbs is None else len(rows.surfaces))
    if nurbs is not None:
        rows.surfaces.append(nurbs)
    for edge, runs_forward in sub_shape_uses(face, EDGE):
        rows.coedges.append((number, edge_map.add(edge), runs_forward))


def _surface(face: Any) -> tuple[Row, float, NurbsSurface | None]:
    """Return a face's surface, the sign of its own normal du × dv against the graph's, and its NURBS, if it is one."""
    if has_triangles_only(face):
        return (SurfaceKind.NONE, NO_FRAME, (0.0, 0.0)), 1.0, None
    adaptor = BRepAdaptor_Surface(face, False)
    elementary = _ELEMENTARY.get(adaptor.GetType())
    if elementary is not None:
        kind, surface_of = elementary
        return _elementary(kind, surface_of(adaptor))
    adaptor, found = BRepAdaptor_Surface(face, True), recognise_surface(face)
    if found is not None:
        row, _, _ = _elementary(SurfaceKind(found[0]), found[1])
        return row, _hand_of(row, adaptor), None
    nurbs, row = _nurbs_surface(face, adaptor), (SurfaceKind.NURBS, NO_FRAME, (0.0, 0.0))
    if adaptor.IsVClosed() and not adaptor.IsUClosed():  # a tube: the graph counts round it with u
        return row, -1.0, nurbs.transposed
    return row, 1.0, nurbs


def _frame(position: Any) -> list[list[float]]:
    o, x, y, z = position.Location(), position.XDirection(), position.YDirection(), position.Direction()
    return [[v.X(), v.Y(), v.Z()] for v in (o, x, y, z)]


def _elementary(kind: SurfaceKind, surface: Any) -> tuple[Row, float, None]:
    if kind == SurfaceKind.PLANE:
        param = (0.0, 0.0)
    elif kind == SurfaceKind.CONE:
        param = (surface.RefRadius(), surface.SemiAngle())
    elif kind == SurfaceKind.TORUS:
        param = (surface.MajorRadius(), surface.MinorRadius())
    else:
        param = (surface.Radius(), 0.0)
    position = surface.Position()
    frame, is_direct = _frame(position), position.Direct()
    if not is_direct:  # a mirrored surface: the graph's frames are right-handed, and its angles follow them
        frame[2] = [-v for v in frame[2]]
    return (kind, frame, param), 1.0 if is_direct else -1.0, None


def _hand_of(row: Row, adaptor: Any) -> float:
    """Compare the normal of a recognised surface with du × dv of its B-spline, at the middle of the face; 1 or -1."""
    u = (adaptor.FirstUParameter() + adaptor.LastUParameter()) / 2
    v = (adaptor.FirstVParameter() + adaptor.LastVParameter()) / 2
    p, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    adaptor.D1(u, v, p, du, dv)
    own = du.Crossed(dv)
    kind, frame, param = row
    normal = surface_normals(np.array([kind]), np.array([frame]), np.array([param]), np.array([[p.X(), p.Y(), p.Z()]]))
    return 1.0 if float(normal[0] @ (own.X(), own.Y(), own.Z())) >= 0 else -1.0


def _nurbs_surface(face: Any, adaptor: Any) -> NurbsSurface:
    spline, bounds = _as_bspline(face, adaptor)
    m, n = spline.NbUPoles(), spline.NbVPoles()
    poles = np.array([[_xyz(spline.Pole(i + 1, j + 1)) for j in range(n)] for i in range(m)])
    weights = np.array([[spline.Weight(i + 1, j + 1) for j in range(n)] for i in range(m)])
    knots_u = _knots([(spline.UKnot(i), spline.UMultiplicity(i)) for i in range(1, spline.NbUKnots() + 1)])
    knots_v = _knots([(spline.VKnot(i), spline.VMultiplicity(i)) for i in range(1, spline.NbVKnots() + 1)])
    return NurbsSurface((spline.UDegree(), spline.VDegree()), knots_u, knots_v, poles, weights, bounds)


def _as_bspline(face: Any, adaptor: Any) -> tuple[Any, tuple[float, float, float, float]]:
    """Return a face's surface as a B-spline that is not periodic, and the bounds (u, u, v, v) of the used part."""
    u0, u1 = adaptor.FirstUParameter(), adaptor.LastUParameter()
    v0, v1 = adaptor.FirstVParameter(), adaptor.LastVParameter()
    if adaptor.GetType() == GeomAbs_SurfaceType.GeomAbs_BSplineSurface:
        spline = adaptor.BSpline()
    else:
        whole = BRep_Tool.Surface_s(face)
        spline = GeomConvert.SurfaceToBSplineSurface_s(Geom_RectangularTrimmedSurface(whole, u0, u1, v0, v1))
    if spline.IsUPeriodic():
        spline.SetUNotPeriodic()
    if spline.IsVPeriodic():
        spline.SetVNotPeriodic()
    low_u, high_u, low_v, high_v = spline.Bounds()
    return spline, (max(u0, low_u), min(u1, high_u), max(v0, low_v), min(v1, high_v))


def _xyz(point: Any) -> tuple[float, float, float]:
    return point.X(), point.Y(), point.Z()


def _knots(pairs: Sequence[tuple[float, int]]) -> FloatArray:
    values, counts = zip(*pairs, strict=True)
    return np.repeat(np.array(values, dtype=np.float64), counts)


def _add_edge(rows: _Rows, edge: Any, vertex_map: VertexMap) -> None:
    row, span, nurbs = curve_row(edge)
    rows.edges.append(row)
    rows.edge_range.append(span)
    rows.edge_vertices.append(vertex_map.ends(edge))
    rows.edge_nurbs.append(-1 if nurbs is None else len(rows.curves))
    if nurbs is not None:
        rows.curves.append(nurbs)


def curve_row(edge: Any) -> tuple[Row, tuple[float, float], NurbsCurve | None]:
    """Return an edge's curve as a row of a `BrepGraph`, its first and last parameter, and its NURBS, if it is one."""
    if BRep_Tool.Degenerated_s(edge):
        return (CurveKind.DEGENERATE, NO_FRAME, (0.0, 0.0)), (0.0, 0.0), None
    adaptor = BRepAdaptor_Curve(edge)
    kind, span = int(adaptor.GetType()), (adaptor.FirstParameter(), adaptor.LastParameter())
    if kind == _LINE:
        line = adaptor.Line()
        frame = [list(_xyz(line.Location())), list(_xyz(line.Direction())), [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
        return (CurveKind.LINE, frame, (0.0, 0.0)), span, None
    if kind == _CIRCLE:
        circle = adaptor.Circle()
        return (CurveKind.CIRCLE, _frame(circle.Position()), (circle.Radius(),) * 2), span, None
    if kind == _ELLIPSE:
        ellipse = adaptor.Ellipse()
        param = (ellipse.MajorRadius(), ellipse.MinorRadius())
        return (CurveKind.ELLIPSE, _frame(ellipse.Position()), param), span, None
    found = recognise_curve(adaptor)
    if found is not None:
        return (int(found.kind), found.frame.tolist(), (found.radius, found.radius)), found.span, None
    curve = _nurbs_curve(adaptor, span)
    return (CurveKind.NURBS, NO_FRAME, (0.0, 0.0)), span, curve


def _nurbs_curve(adaptor: Any, span: tuple[float, float]) -> NurbsCurve:
    if adaptor.GetType() in (Curve.GeomAbs_OffsetCurve, Curve.GeomAbs_OtherCurve):
        found = GeomConvert_ApproxCurve(adaptor, SAME_SHAPE_MM, GeomAbs_Shape.GeomAbs_C1, *MOST_SPANS_AND_DEGREE)
        if not found.HasResult() or found.MaxError() > MOST_OFF_MM:
            raise KernelError(f"an offset curve has no spline within {MOST_OFF_MM:g} mm")
        curve = found.Curve()
    else:
        curve = GeomConvert.CurveToBSplineCurve_s(Geom_TrimmedCurve(GeomAdaptor.MakeCurve_s(adaptor), *span))
    if curve.IsPeriodic():
        curve.SetNotPeriodic()
    poles = np.array([_xyz(curve.Pole(i)) for i in range(1, curve.NbPoles() + 1)])
    weights = np.array([curve.Weight(i) for i in range(1, curve.NbPoles() + 1)])
    knots = _knots([(curve.Knot(i), curve.Multiplicity(i)) for i in range(1, curve.NbKnots() + 1)])
    return NurbsCurve(curve.Degree(), knots, poles, weights)


def _graph(names: Sequence[str], rows: _Rows, vertex_p: FloatArray) -> BrepGraph:
    coedges = np.array(rows.coedges, dtype=np.int64).reshape(-1, 3)
    return BrepGraph(
        solid_names=tuple(names),
        face_solid=np.array(rows.face_solid, dtype=np.int64),
        face_kind=np.array([row[0] for row in rows.faces], dtype=np.int64),
        face_frame=np.array([row[1] for row in rows.faces], dtype=np.float64).reshape(-1, 4, 3),
        face_param=np.array([row[2] for row in rows.faces], dtype=np.float64).reshape(-1, 2),
        face_outward=np.array(rows.face_outward, dtype=np.float64),
        face_nurbs=np.array(rows.face_nurbs, dtype=np.int64),
        edge_kind=np.array([row[0] for row in rows.edges], dtype=np.int64),
        edge_frame=np.array([row[1] for row in rows.edges], dtype=np.float64).reshape(-1, 4, 3),
        edge_param=np.array([row[2] for row in rows.edges], dtype=np.float64).reshape(-1, 2),
        edge_nurbs=np.array(rows.edge_nurbs, dtype=np.int64),
        edge_range=np.array(rows.edge_range, dtype=np.float64).reshape(-1, 2),
        edge_vertices=np.array(rows.edge_vertices, dtype=np.int64).reshape(-1, 2),
        vertex_p=vertex_p,
        coedge_face=coedges[:, 0].copy(),
        coedge_edge=coedges[:, 1].copy(),
        coedge_forward=coedges[:, 2].astype(bool),
        nurbs_surfaces=tuple(rows.surfaces),
        nurbs_curves=tuple(rows.curves),
    )
