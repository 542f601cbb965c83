"""The four views of a sheet: what of the part is seen in each, as line segments in the plane of the view.

Hidden lines are taken away by the kernel's polygonal algorithm, on triangles. The exact one needs a minute for a screw
thread and seconds for some views along an axis; the polygonal one needs hundredths of a second, and its chords are
finer than a pen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cad.kernel.ocp import EDGE, VERTEX, compound, kernel_call, sub_shapes, vertex_points
from wpcal.brep import BrepGraph
from wpcal.brep.rays import is_blocked
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, frozen

CHORD_PART = 2e-4
"""Chord error of the triangles as a part of the diagonal: a tenth of a pen's width on a view of 150 mm."""
CHORD_RAD = 0.05
"""Turn from one chord to the next. With longer chords the outline of a rod that goes through a face is broken there."""
LOOK_PAST = 2e-3
"""Rays to the viewer start so far (part of the diagonal) beside a point: a corner on a silhouette is seen past it."""
CLEAR = 3.0
"""And so many times that towards the viewer, clear of the faces that meet at the point."""
EYES = 8
"""Rays around each point; the point is seen when one of them is free."""


@dataclass(frozen=True, slots=True, eq=False)
class ViewAxes:
    """From where the part is looked at.

    Parameters
    ----------
    name : str
    right, toward : ndarray, shape (3,)
        Unit directions in `part`: to the right on paper, and towards the viewer.
    """

    name: str
    right: FloatArray
    toward: FloatArray

    @property
    def plane(self) -> FloatArray:
        """Right and up on paper, shape (2, 3): ``uv = plane @ p``."""
        return np.array([self.right, np.cross(self.toward, self.right)])


FRONT = ViewAxes("front", frozen([1.0, 0.0, 0.0]), frozen([0.0, -1.0, 0.0]))
LEFT = ViewAxes("left side", frozen([0.0, -1.0, 0.0]), frozen([-1.0, 0.0, 0.0]))
TOP = ViewAxes("top", frozen([1.0, 0.0, 0.0]), frozen([0.0, 0.0, 1.0]))
ISO = ViewAxes("from the front, left and above", frozen(np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)),
               frozen(np.array([-1.0, -1.0, 1.0]) / np.sqrt(3.0)))  # fmt: skip
ORTHOGONAL = (FRONT, LEFT, TOP)


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """What is seen.

    Parameters
    ----------
    axes : ViewAxes
    segments : ndarray, shape (n, 2, 2)
        Visible sharp edges and outlines in the plane of the view, mm of the part.
    smooth : ndarray, shape (k, 2, 2)
        Visible edges between faces that go over into each other.
    p : ndarray, shape (m, 2)
        The reference points.
    is_seen : ndarray of bool, shape (m,)
        False for points behind the part.
    """

    axes: ViewAxes
    segments: FloatArray
    smooth: FloatArray
    p: FloatArray
    is_seen: BoolArray

    @property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """Lower left and upper right corner of all that is drawn."""
        drawn = np.concatenate([self.segments.reshape(-1, 2), self.smooth.reshape(-1, 2), self.p])
        return drawn.min(axis=0), drawn.max(axis=0)


def project_views(graph: BrepGraph, solids: Sequence[Any], points: FloatArray) -> tuple[View, ...]:
    """Return the views front, left, top and iso of a part.

    Parameters
    ----------
    graph : BrepGraph
    solids : sequence of kernel shapes
        Those of the graph.
    points : ndarray, shape (m, 3)
        Reference points in `part`, mm.

    Raises
    ------
    KernelError
        When the kernel cannot mesh or project the part.
    """
    shape = _meshed(solids, graph.size_mm)
    trimmed = TrimmedFaces.of(graph)
    views = []
    for axes in (*ORTHOGONAL, ISO):
        segments, smooth = _visible_lines(shape, axes)
        seen = _seen(graph, trimmed, points, axes)
        views.append(View(axes, segments, smooth, frozen(points @ axes.plane.T), seen))
    return tuple(views)


def _meshed(solids: Sequence[Any], size_mm: float) -> Any:
    from OCP.BRepMesh import BRepMesh_IncrementalMesh

    shape = compound(list(solids))
    with kernel_call("meshing the part for the views"):
        BRepMesh_IncrementalMesh(shape, CHORD_PART * size_mm, False, CHORD_RAD, False)
    return shape


def _visible_lines(shape: Any, axes: ViewAxes) -> tuple[FloatArray, FloatArray]:
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
    from OCP.HLRAlgo import HLRAlgo_Projector
    from OCP.HLRBRep import HLRBRep_PolyAlgo, HLRBRep_PolyHLRToShape

    with kernel_call(f"projecting the view {axes.name}"):
        algorithm = HLRBRep_PolyAlgo()
        algorithm.Load(shape)
        place = gp_Ax2(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(*axes.toward.tolist()), gp_Dir(*axes.right.tolist()))
        algorithm.Projector(HLRAlgo_Projector(place))
        algorithm.Update()
        lines = HLRBRep_PolyHLRToShape()
        lines.Update(algorithm)
        sharp = [_segments(found) for found in (lines.VCompound(), lines.OutLineVCompound())]
        return np.concatenate(sharp), _segments(lines.Rg1LineVCompound())


def _segments(shape: Any) -> FloatArray:
    """Return the edges of a projected compound as segments, without repeats."""
    if shape is None or shape.IsNull():
        return np.zeros((0, 2, 2))
    edges = [vertex_points(edge) for edge in sub_shapes(shape, EDGE) if len(sub_shapes(edge, VERTEX)) == 2]
    if not edges:
        return np.zeros((0, 2, 2))
    return np.asarray(np.unique(np.array(edges)[:, :, :2], axis=0), dtype=np.float64)


def _seen(graph: BrepGraph, trimmed: TrimmedFaces, points: FloatArray, axes: ViewAxes) -> BoolArray:
    """Tell which points have a free way to the viewer, past the faces that they are on."""
    angle = np.linspace(0.0, 2.0 * np.pi, EYES, endpoint=False)
    beside = LOOK_PAST * graph.size_mm * (np.stack([np.cos(angle), np.sin(angle)], axis=1) @ axes.plane)
    starts = points[:, None] + beside + CLEAR * LOOK_PAST * graph.size_mm * axes.toward
    rays = np.broadcast_to(axes.toward, starts.shape)
    blocked = is_blocked(graph, trimmed, starts.reshape(-1, 3), rays.reshape(-1, 3), length_mm=2.0 * graph.size_mm)
    return np.asarray(~blocked.reshape(len(points), EYES).all(axis=1))
