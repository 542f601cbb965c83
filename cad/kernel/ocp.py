"""The CAD kernel (OCP, Open CASCADE in Python) with its odd collections, casts, names and exceptions put straight.

Nothing here knows what a weld is. Importing this module loads the kernel (about 0.5 s) and silences its printer, which
otherwise writes on standard output.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

import numpy as np

from cad.kernel.system_libraries import libgl_explained
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import KernelError
from wpcal.core.transform import RigidTransform

with libgl_explained():
    import OCP.Standard
    from OCP.BRep import BRep_Builder, BRep_Tool
    from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
    from OCP.collections import (
        IndexedDataMap_TopoDS_Shape_List_TopoDS_Shape_TopTools_ShapeMapHasher as AncestorMap,
    )
    from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher as ShapeMap
    from OCP.collections import Sequence_TDF_Label
    from OCP.GCPnts import GCPnts_AbscissaPoint
    from OCP.GeomAbs import GeomAbs_SurfaceType
    from OCP.gp import gp_Trsf
    from OCP.Message import Message, Message_PrinterOStream
    from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
    from OCP.TCollection import TCollection_AsciiString, TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDF import TDF_Label, TDF_Tool
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
    from OCP.TopExp import TopExp, TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS, TopoDS_Compound, TopoDS_Shell
    from OCP.XCAFApp import XCAFApp_Application
    from OCP.XCAFDoc import XCAFDoc_ColorTool, XCAFDoc_ColorType

KernelObject: TypeAlias = Any
"""Any object of the kernel: OCP carries no types."""

Message.DefaultMessenger_s().RemovePrinters(Message_PrinterOStream.get_type_descriptor_s())

SOLID = TopAbs_ShapeEnum.TopAbs_SOLID
SHELL = TopAbs_ShapeEnum.TopAbs_SHELL
FACE = TopAbs_ShapeEnum.TopAbs_FACE
WIRE = TopAbs_ShapeEnum.TopAbs_WIRE
EDGE = TopAbs_ShapeEnum.TopAbs_EDGE
VERTEX = TopAbs_ShapeEnum.TopAbs_VERTEX

KERNEL_EXCEPTIONS: tuple[type[Exception], ...] = tuple(
    value for value in vars(OCP.Standard).values() if isinstance(value, type) and issubclass(value, Exception)
)
"""All of them: the binding keeps no common base, ``Standard_DomainError`` is no ``Standard_Failure`` in Python."""

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
"""Kinds of the kernel in one word each; a face without a surface (tessellated only) is of kind ``mesh``."""

SHAPE_KINDS = {SOLID: "solid", SHELL: "shell", FACE: "face", WIRE: "wire", EDGE: "edge", VERTEX: "vertex"}


@contextmanager
def kernel_call(what: str) -> Iterator[None]:
    """Turn any exception of the kernel into a `KernelError` that says what was being done.

    Parameters
    ----------
    what : str
        For the message: ``reading part.step``.

    Raises
    ------
    KernelError
        When the kernel raises, or runs out of memory.
    """
    try:
        yield
    except MemoryError:
        raise KernelError(f"{what}: the CAD kernel ran out of memory") from None
    except KERNEL_EXCEPTIONS as error:
        raise KernelError(f"{what}: the CAD kernel failed ({type(error).__name__}: {error})") from None


# Shapes --------------------------------------------------------------------------------------------------------------


def sub_shapes(shape: KernelObject, kind: KernelObject) -> list[KernelObject]:
    """Distinct sub-shapes of one kind with their locations, in the kernel's order (the same at every run).

    Two uses of one shape in opposite orientations count once.
    """
    found = ShapeMap()
    TopExp.MapShapes_s(shape, kind, found)
    cast = _CASTS[kind]
    return [cast(found.FindKey(i)) for i in range(1, found.Extent() + 1)]


_CASTS = {
    SOLID: TopoDS.Solid,
    SHELL: TopoDS.Shell,
    FACE: TopoDS.Face,
    WIRE: TopoDS.Wire,
    EDGE: TopoDS.Edge,
    VERTEX: TopoDS.Vertex,
}


def shape_map(shapes: Iterable[KernelObject]) -> KernelObject:
    """Kernel map of shapes: ``FindIndex(shape)`` counts from 1, and is 0 for a shape that is not in it."""
    found = ShapeMap()
    for shape in shapes:
        found.Add(shape)
    return found


def loose_shapes(shape: KernelObject, kind: KernelObject, avoid: KernelObject) -> list[KernelObject]:
    """Distinct sub-shapes of one kind that are in no shape of the kind `avoid`: faces in no solid, edges in no face."""
    found = ShapeMap()
    explorer = TopExp_Explorer(shape, kind, avoid)
    while explorer.More():
        found.Add(explorer.Current())
        explorer.Next()
    cast = _CASTS[kind]
    return [cast(found.FindKey(i)) for i in range(1, found.Extent() + 1)]


def list_items(shapes: KernelObject) -> list[KernelObject]:
    """Items of a kernel list of shapes. Iterating costs 230 µs a list; lists of one and two (the usual) do without."""
    size = shapes.Size()
    if size == 0:
        return []
    if size == 1:
        return [shapes.First()]
    return [shapes.First(), shapes.Last()] if size == 2 else list(shapes)


def ancestors(
    shape: KernelObject, kind: KernelObject, of: KernelObject
) -> list[tuple[KernelObject, list[KernelObject]]]:
    """Sub-shapes of one kind with the shapes of the kind `of` they belong to: edges with their faces."""
    found = AncestorMap()
    TopExp.MapShapesAndAncestors_s(shape, kind, of, found)
    cast, cast_of = _CASTS[kind], _CASTS[of]
    return [
        (cast(found.FindKey(i)), [cast_of(item) for item in list_items(found.FindFromIndex(i))])
        for i in range(1, found.Extent() + 1)
    ]


def is_mesh_face(face: KernelObject) -> bool:
    """Tell whether a face has triangles only and no surface."""
    return BRep_Tool.Surface_s(face) is None


def surface_kind(face: KernelObject) -> str:
    """Kind of a face's surface in one word, `SURFACE_KINDS`; ``mesh`` when it has none."""
    if is_mesh_face(face):
        return "mesh"
    return SURFACE_KINDS[BRepAdaptor_Surface(face, False).GetType()]


def vertex_points(shape: KernelObject) -> FloatArray:
    """Points of all distinct vertices, mm, shape (n, 3), in the kernel's order."""
    rows = []
    for vertex in sub_shapes(shape, VERTEX):
        p = BRep_Tool.Pnt_s(vertex)
        rows.append((p.X(), p.Y(), p.Z()))
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def mesh_points(face: KernelObject) -> FloatArray:
    """Nodes of a face's triangles, mm, shape (n, 3); none when it has no triangles."""
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


def compound(shapes: list[KernelObject]) -> KernelObject:
    """Put shapes into one compound."""
    result, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(result)
    for shape in shapes:
        builder.Add(result, shape)
    return result


def shell_of(face: KernelObject) -> KernelObject:
    """Put one face into a shell of its own."""
    result, builder = TopoDS_Shell(), BRep_Builder()
    builder.MakeShell(result)
    builder.Add(result, face)
    return result


def is_reversed(shape: KernelObject) -> bool:
    """Tell whether a shape is used against its own direction."""
    return bool(shape.Orientation() == TopAbs_Orientation.TopAbs_REVERSED)


def to_trsf(transform: RigidTransform) -> KernelObject:
    """Kernel transformation of a rigid transform."""
    trsf = gp_Trsf()
    trsf.SetValues(*np.column_stack([transform.R, transform.t_mm]).ravel().tolist())
    return trsf


def to_location(transform: RigidTransform) -> KernelObject:
    """Kernel location of a rigid transform."""
    return TopLoc_Location(to_trsf(transform))


# Labels of an XCAF document ------------------------------------------------------------------------------------------


def extended(text: str) -> KernelObject:
    """Kernel string of a text; without the flag the kernel would read UTF-8 as Latin-1."""
    return TCollection_ExtendedString(text, True)


def labels(sequence: KernelObject) -> list[KernelObject]:
    """Items of a kernel sequence of labels."""
    return [sequence.Value(i) for i in range(1, sequence.Length() + 1)]


def filled(fill: Any, *arguments: KernelObject) -> list[KernelObject]:
    """Call a kernel method whose last argument is a sequence of labels that it fills."""
    sequence = Sequence_TDF_Label()
    fill(*arguments, sequence)
    return labels(sequence)


def label_name(label: KernelObject) -> str:
    """Name of a label as written; empty when it has none."""
    guid = TDataStd_Name.GetID_s()
    if not label.IsAttribute(guid):  # FindAttribute on a label without the attribute ends the interpreter
        return ""
    attribute = TDataStd_Name()
    label.FindAttribute(guid, attribute)
    return str(attribute.Get().ToExtString())


def label_entry(label: KernelObject) -> str:
    """Place of a label in its document: ``0:1:1:3``."""
    text = TCollection_AsciiString()
    TDF_Tool.Entry_s(label, text)
    return str(text.ToCString())


def new_document() -> KernelObject:
    """Return an empty XCAF document: the kernel's tree of products, instances and attributes."""
    document = TDocStd_Document(extended("XmlXCAF"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    return document


def new_label() -> KernelObject:
    """Return an empty label, for kernel methods that fill one."""
    return TDF_Label()


_COLOR_TYPES = (
    XCAFDoc_ColorType.XCAFDoc_ColorSurf,
    XCAFDoc_ColorType.XCAFDoc_ColorGen,
    XCAFDoc_ColorType.XCAFDoc_ColorCurv,
)
_COLOR_DIGITS = 4
"""The kernel keeps colours as float32 and linear; the way there and back moves the sixth digit."""


def srgb(linear: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return a linear colour as a file writes it (sRGB, 0…1)."""
    return _srgb(Quantity_Color(*linear, Quantity_TypeOfColor.Quantity_TOC_RGB))


def _srgb(color: KernelObject) -> tuple[float, float, float]:
    r, g, b = (round(float(v), _COLOR_DIGITS) for v in color.Values(Quantity_TypeOfColor.Quantity_TOC_sRGB))
    return r, g, b


def label_color(label: KernelObject) -> tuple[float, float, float] | None:
    """Colour of a label as the file writes it (sRGB, 0…1): of its surface, else in general, else of its curve."""
    color = Quantity_Color()
    for kind in _COLOR_TYPES:
        if XCAFDoc_ColorTool.GetColor_s(label, kind, color):
            return _srgb(color)
    return None
