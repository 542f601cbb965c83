"""The lines of a part that are visible from one side.

Hidden lines are removed by the kernel's polygonal algorithm, on triangles. The exact algorithm needs a minute for a
screw thread and seconds for some views along an axis. The polygonal one needs hundredths of a second.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.HLRAlgo import HLRAlgo_Projector
from OCP.HLRBRep import HLRBRep_PolyAlgo, HLRBRep_PolyHLRToShape

from cad.kernel.call import KernelObject, kernel_call
from cad.kernel.geometry import vertex_points
from cad.kernel.topology import EDGE, VERTEX, compound, sub_shapes
from wpcal.core.arrays import FloatArray


def meshed_compound(solids: Sequence[KernelObject], *, chord_mm: float, chord_rad: float) -> KernelObject:
    """Put solids into one compound with triangles: for `visible_lines`.

    `chord_mm`: Largest distance of a triangle from its face.
    `chord_rad`: Largest turn from one chord to the next.
    Raises `KernelError` when the kernel cannot mesh the part.
    """
    shape = compound(list(solids))
    with kernel_call("meshing the part for the views"):
        BRepMesh_IncrementalMesh(shape, chord_mm, False, chord_rad, False)
    return shape


def visible_lines(
    shape: KernelObject, *, right: FloatArray, toward: FloatArray, name: str
) -> tuple[FloatArray, FloatArray]:
    """Project a meshed shape and keep the lines that are visible.

    Returns `sharp`: shape (n, 2, 2). Sharp edges and outlines as segments in the plane of the view, mm.
    Returns `smooth`: shape (k, 2, 2). Edges between faces that join smoothly.
    Raises `KernelError` when the kernel cannot project the part.

    `shape`: Of `meshed_compound`.
    `right`, `toward`: shape (3,). Unit directions in `part`: to the right on paper, and towards the viewer.
    """
    with kernel_call(f"projecting the view {name}"):
        algorithm = HLRBRep_PolyAlgo()
        algorithm.Load(shape)
        place = gp_Ax2(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(*toward.tolist()), gp_Dir(*right.tolist()))
        algorithm.Projector(HLRAlgo_Projector(place))
        algorithm.Update()
        lines = HLRBRep_PolyHLRToShape()
        lines.Update(algorithm)
        sharp = [_segments(found) for found in (lines.VCompound(), lines.OutLineVCompound())]
        return np.concatenate(sharp), _segments(lines.Rg1LineVCompound())


def _segments(shape: KernelObject) -> FloatArray:
    """Return the edges of a projected compound as segments, without repeats."""
    if shape is None or shape.IsNull():
        return np.zeros((0, 2, 2))
    edges = [vertex_points(edge) for edge in sub_shapes(shape, EDGE) if len(sub_shapes(edge, VERTEX)) == 2]
    if not edges:
        return np.zeros((0, 2, 2))
    return np.asarray(np.unique(np.array(edges)[:, :, :2], axis=0), dtype=np.float64)
