"""Walking over a kernel shape: its faces, edges and vertices, each numbered once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, Literal

import numpy as np

from wpcal.core.arrays import FloatArray


def explore(
    shape: Any, kind: Literal["solid", "shell", "face", "wire", "edge", "vertex"]
) -> Iterator[tuple[Any, bool]]:
    """Yield the sub-shapes of one kind with whether they are used forward, in the kernel's order.

    A sub-shape used twice (the seam edge of a cylinder) comes twice.
    """
    from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    wanted = getattr(TopAbs_ShapeEnum, f"TopAbs_{kind.upper()}")
    cast = getattr(TopoDS, kind.capitalize())
    reversed_ = TopAbs_Orientation.TopAbs_REVERSED
    explorer = TopExp_Explorer(shape, wanted)
    while explorer.More():
        found = explorer.Current()
        yield cast(found), found.Orientation() != reversed_
        explorer.Next()


class _NumberedShapes:
    """Shapes numbered from 0 in the order of their first use; orientation makes no difference."""

    def __init__(self) -> None:
        from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher as IndexedMap

        self._map = IndexedMap()

    def add(self, shape: Any) -> int:
        """Return the shape's number; a new one for a shape not seen before."""
        return int(self._map.Add(shape)) - 1

    def __len__(self) -> int:
        return int(self._map.Size())

    def _at(self, number: int) -> Any:
        return self._map.FindKey(number + 1)


class FaceMap(_NumberedShapes):
    """Faces by number."""

    @classmethod
    def of(cls, shapes: Iterable[Any]) -> FaceMap:
        """Number the faces of shapes as `cad.kernel.to_brep.to_brep` does."""
        faces = cls()
        for shape in shapes:
            for face, _ in explore(shape, "face"):
                faces.add(face)
        return faces

    def number(self, face: Any) -> int:
        """Return the number of a face that was added."""
        return int(self._map.FindIndex(face)) - 1


class EdgeMap(_NumberedShapes):
    """Edges by number."""

    def shapes(self) -> Iterator[Any]:
        """Yield the edges in the order of their numbers."""
        from OCP.TopoDS import TopoDS

        for number in range(len(self)):
            yield TopoDS.Edge(self._at(number))


class VertexMap(_NumberedShapes):
    """Vertices by number."""

    def ends(self, edge: Any) -> tuple[int, int]:
        """Return the numbers of the vertices at an edge's first and last parameter, -1 where there is none."""
        from OCP.TopExp import TopExp

        first, last = TopExp.FirstVertex_s(edge, False), TopExp.LastVertex_s(edge, False)
        return (-1 if first.IsNull() else self.add(first)), (-1 if last.IsNull() else self.add(last))

    def points(self) -> FloatArray:
        """Return the points of all vertices, shape (V, 3), mm."""
        from OCP.BRep import BRep_Tool
        from OCP.TopoDS import TopoDS

        points = (BRep_Tool.Pnt_s(TopoDS.Vertex(self._at(number))) for number in range(len(self)))
        return np.array([(p.X(), p.Y(), p.Z()) for p in points], dtype=np.float64).reshape(-1, 3)
