"""What kernel shapes measure: kinds of surfaces, points, lengths; and rigid transforms as the kernel takes them."""

from __future__ import annotations

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepGProp import BRepGProp
from OCP.GCPnts import GCPnts_AbscissaPoint
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.gp import gp_Trsf
from OCP.GProp import GProp_GProps
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS

from cad.kernel.call import KernelObject
from cad.kernel.topology import VERTEX, sub_shapes
from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform

SURFACE_KINDS = {
    GeomAbs_SurfaceType.GeomAbs_Plane: "plane",
    GeomAbs_SurfaceType.GeomAbs_Cylinder: "cylinder",
    GeomAbs_SurfaceType.GeomAbs_Cone: "cone",
    GeomAbs_SurfaceType.GeomAbs_Sphere: "sphere",
    GeomAbs_SurfaceType.GeomAbs_Torus: "torus",
    GeomAbs_SurfaceType.GeomAbs_BezierSurface: "bezier",
    GeomAbs_SurfaceType.GeomAbs_BSplineSurface: "bspline",
    GeomAbs_SurfaceType.GeomAbs_SurfaceOfRevolution: "revolution",
    GeomAbs_SurfaceType.GeomAbs_SurfaceOfExtrusion: "extrusion",
    GeomAbs_SurfaceType.GeomAbs_OffsetSurface: "offset",
    GeomAbs_SurfaceType.GeomAbs_OtherSurface: "other",
}
"""The kernel's kinds of surfaces in one word each."""


def has_triangles_only(face: KernelObject) -> bool:
    """Tell whether a face has no exact surface, only triangles (tessellated AP242 files)."""
    return BRep_Tool.Surface_s(face) is None


def surface_kind(face: KernelObject) -> str:
    """Kind of a face's surface in one word, `SURFACE_KINDS`; ``mesh`` for a face that has triangles only."""
    if has_triangles_only(face):
        return "mesh"
    return SURFACE_KINDS[BRepAdaptor_Surface(face, False).GetType()]


def vertex_points(shape: KernelObject) -> FloatArray:
    """Points of all distinct vertices, mm, shape (n, 3), in the kernel's order."""
    points = map(BRep_Tool.Pnt_s, sub_shapes(shape, VERTEX))
    return np.array([(p.X(), p.Y(), p.Z()) for p in points], dtype=np.float64).reshape(-1, 3)


def mesh_points(face: KernelObject) -> FloatArray:
    """Nodes of a face's triangles, mm, shape (n, 3); n = 0 when it has no triangles."""
    location = TopLoc_Location()
    mesh = BRep_Tool.Triangulation_s(face, location)
    if mesh is None:
        return np.zeros((0, 3))
    trsf = location.Transformation()
    nodes = (mesh.Node(i).Transformed(trsf) for i in range(1, mesh.NbNodes() + 1))
    return np.array([(p.X(), p.Y(), p.Z()) for p in nodes], dtype=np.float64).reshape(-1, 3)


def edge_length(edge: KernelObject) -> float:
    """Length of an edge, mm."""
    return float(GCPnts_AbscissaPoint.Length_s(BRepAdaptor_Curve(TopoDS.Edge(edge))))


def volume_mm3(shape: KernelObject) -> float:
    """Return the volume of a solid, mm³."""
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return abs(float(properties.Mass()))


def to_location(transform: RigidTransform) -> KernelObject:
    """Kernel location of a rigid transform."""
    trsf = gp_Trsf()
    trsf.SetValues(*np.column_stack([transform.R, transform.t_mm]).ravel().tolist())
    return TopLoc_Location(trsf)


def location_matrix(location: KernelObject) -> FloatArray:
    """Kernel location as a matrix, shape (4, 4), mm."""
    trsf, matrix = location.Transformation(), np.eye(4)
    matrix[:3] = [[trsf.Value(i, j) for j in range(1, 5)] for i in range(1, 4)]
    return matrix
