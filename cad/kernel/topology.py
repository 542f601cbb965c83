"""The parts of a kernel shape: solids, shells, faces, wires, edges and vertices, found, numbered and put together.

`sub_shapes` gives each part once; `sub_shape_uses` gives every use of a part, with its direction.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.collections import IndexedDataMap_TopoDS_Shape_List_TopoDS_Shape_TopTools_ShapeMapHasher as AncestorMap
from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher as ShapeMap
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS, TopoDS_Compound, TopoDS_Shell

from cad.kernel.call import KernelObject
from wpcal.core.arrays import FloatArray

SOLID = TopAbs_ShapeEnum.TopAbs_SOLID
SHELL = TopAbs_ShapeEnum.TopAbs_SHELL
FACE = TopAbs_ShapeEnum.TopAbs_FACE
WIRE = TopAbs_ShapeEnum.TopAbs_WIRE
EDGE = TopAbs_ShapeEnum.TopAbs_EDGE
VERTEX = TopAbs_ShapeEnum.TopAbs_VERTEX
REVERSED = int(TopAbs_Orientation.TopAbs_REVERSED)  #: As a number: the kernel's own values take 3 µs to compare.

SHAPE_KINDS = {SOLID: "solid", SHELL: "shell", FACE: "face", WIRE: "wire", EDGE: "edge", VERTEX: "vertex"}

_CASTS = {
    SOLID: TopoDS.Solid,
    SHELL: TopoDS.Shell,
    FACE: TopoDS.Face,
    WIRE: TopoDS.Wire,
    EDGE: TopoDS.Edge,
    VERTEX: TopoDS.Vertex,
}


def sub_shapes(shape: KernelObject, kind: KernelObject) -> list[KernelObject]:
    """Distinct sub-shapes of one kind with their locations, in the kernel's order (the same at every run).

    Two uses of one shape in opposite directions count once.
    """
    found = ShapeMap()
    TopExp.MapShapes_s(shape, kind, found)
    return _items(found, kind)


def sub_shape_uses(shape: KernelObject, kind: KernelObject) -> Iterator[tuple[KernelObject, bool]]:
    """Every use of a sub-shape of one kind, and whether it is used forward, in the kernel's order.

    A sub-shape that is used twice (the seam edge of a cylinder) comes twice.
    """
    cast = _CASTS[kind]
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        found = explorer.Current()
        yield cast(found), not is_reversed(found)
        explorer.Next()


def only_solid(shape: KernelObject) -> KernelObject:
    """Return the one solid of a shape that has exactly one."""
    (solid,) = sub_shapes(shape, SOLID)
    return solid


def loose_shapes(shape: KernelObject, kind: KernelObject, avoid: KernelObject) -> list[KernelObject]:
    """Distinct sub-shapes of one kind that are in no shape of the kind `avoid`: faces in no solid, edges in no face."""
    found = ShapeMap()
    explorer = TopExp_Explorer(shape, kind, avoid)
    while explorer.More():
        found.Add(explorer.Current())
        explorer.Next()
    return _items(found, kind)


def _items(shapes: KernelObject, kind: KernelObject) -> list[KernelObject]:
    cast = _CASTS[kind]
    return [cast(shapes.FindKey(i)) for i in range(1, shapes.Extent() + 1)]


def ancestors(
    shape: KernelObject, kind: KernelObject, of: KernelObject
) -> list[tuple[KernelObject, list[KernelObject]]]:
    """Sub-shapes of one kind with the shapes of the kind `of` they belong to: edges with their faces."""
    found = AncestorMap()
    TopExp.MapShapesAndAncestors_s(shape, kind, of, found)
    cast, cast_of = _CASTS[kind], _CASTS[of]
    return [
        (cast(found.FindKey(i)), [cast_of(item) for item in _list_items(found.FindFromIndex(i))])
        for i in range(1, found.Extent() + 1)
    ]


def _list_items(shapes: KernelObject) -> list[KernelObject]:
    """Items of a kernel list. Iterating costs 230 µs per list, so the usual lists of one and two are read without."""
    size = shapes.Size()
    if size == 0:
        return []
    if size == 1:
        return [shapes.First()]
    return [shapes.First(), shapes.Last()] if size == 2 else list(shapes)


def is_reversed(shape: KernelObject) -> bool:
    """Tell whether a shape is used against its own direction."""
    return int(shape.Orientation()) == REVERSED


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


class NumberedShapes:
    """Shapes numbered from 0 in the order of their first use; the direction of use makes no difference."""

    def __init__(self, shapes: Iterable[KernelObject] = ()) -> None:
        self._map = ShapeMap()
        for shape in shapes:
            self._map.Add(shape)

    def add(self, shape: KernelObject) -> int:
        """Return the shape's number; a new one for a shape not seen before."""
        return int(self._map.Add(shape)) - 1

    def number(self, shape: KernelObject) -> int:
        """Return the number of a shape, -1 for one that was not added."""
        return int(self._map.FindIndex(shape)) - 1

    def __len__(self) -> int:
        return int(self._map.Size())

    def __iter__(self) -> Iterator[KernelObject]:
        return (self._map.FindKey(number + 1) for number in range(len(self)))


def numbered_faces(shapes: Iterable[KernelObject]) -> NumberedShapes:
    """Number the faces of shapes as `cad.kernel.to_brep.to_brep` does."""
    return NumberedShapes(face for shape in shapes for face, _ in sub_shape_uses(shape, FACE))


class EdgeMap(NumberedShapes):
    """Edges by number."""

    def shapes(self) -> Iterator[KernelObject]:
        """Yield the edges in the order of their numbers."""
        return map(TopoDS.Edge, self)


class VertexMap(NumberedShapes):
    """Vertices by number."""

    def ends(self, edge: KernelObject) -> tuple[int, int]:
        """Return the numbers of the vertices at an edge's first and last parameter, -1 where there is none."""
        first, last = TopExp.FirstVertex_s(edge, False), TopExp.LastVertex_s(edge, False)
        return (-1 if first.IsNull() else self.add(first)), (-1 if last.IsNull() else self.add(last))

    def points(self) -> FloatArray:
        """Return the points of all vertices, shape (n, 3), mm."""
        points = (BRep_Tool.Pnt_s(TopoDS.Vertex(vertex)) for vertex in self)
        return np.array([(p.X(), p.Y(), p.Z()) for p in points], dtype=np.float64).reshape(-1, 3)
