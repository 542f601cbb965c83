"""The four views of a sheet: which lines of the part are visible in each, and which reference points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cad.workpiece.step_file import LINES
from cad.workpiece.workpiece import Workpiece
from wpcal.brep import BrepGraph
from wpcal.brep.hits import is_blocked
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, frozen

CHORD_PART = 2e-4
"""Chord error of the triangles, relative to the diagonal: a tenth of a pen's width on a view of 150 mm."""
CHORD_RAD = 0.05
"""Turn from one chord to the next. With longer chords the outline of a rod has a gap where it passes through a face."""
LOOK_PAST = 2e-3
"""Rays to the viewer start this far beside a point (relative to the diagonal), so that a corner on the outline of the
part counts as visible."""
CLEAR = 3.0
"""Rays also start this many times `LOOK_PAST` towards the viewer, away from the faces that meet at the point."""
EYES = 8  #: Rays around each point. The point is visible when one of them is free.


@dataclass(frozen=True, slots=True, eq=False)
class ViewAxes:
    """The direction of a view."""

    name: str
    #: `right`, `toward`: shape (3,). Unit directions in `part`: to the right on paper, and towards the viewer.
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
VIEWS = (*ORTHOGONAL, ISO)

ViewLines = tuple[tuple[FloatArray, FloatArray], ...]
"""For each view its sharp lines, shape (n, 2, 2), and its smooth lines, shape (k, 2, 2), mm."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """What is visible in one view."""

    axes: ViewAxes
    segments: FloatArray  #: shape (n, 2, 2). Visible sharp edges and outlines in the plane of the view, mm of the part.
    smooth: FloatArray  #: shape (k, 2, 2). Visible edges between faces that join smoothly, mm.
    p: FloatArray  #: shape (m, 2). The reference points in the plane of the view, mm.
    is_seen: BoolArray  #: shape (m,). False for points behind the part.

    @property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """Lower left and upper right corner of everything drawn, shape (2,) each, mm."""
        drawn = np.concatenate([self.segments.reshape(-1, 2), self.smooth.reshape(-1, 2), self.p])
        return drawn.min(axis=0), drawn.max(axis=0)


def part_lines(workpiece: Workpiece) -> ViewLines:
    """Return what is visible of a part in each view: sharp and smooth lines as in `View`.

    Raises `KernelError` when the kernel cannot mesh or project the part.
    """

    def project() -> ViewLines:
        solids = workpiece.solids
        from cad.kernel.visible_lines import meshed_compound, visible_lines

        size_mm = workpiece.graph.size_mm
        shape = meshed_compound(solids, chord_mm=CHORD_PART * size_mm, chord_rad=CHORD_RAD)
        return tuple(visible_lines(shape, right=a.right, toward=a.toward, name=a.name) for a in VIEWS)

    return workpiece.answer(LINES, (), project)


def project_views(graph: BrepGraph, lines: ViewLines, points: FloatArray) -> tuple[View, ...]:
    """Project reference points to the views front, left, top and iso of a part.

    `points`: shape (m, 3). Reference points in `part`, mm.
    """
    trimmed = TrimmedFaces.of(graph)
    views = []
    for axes, (segments, smooth) in zip(VIEWS, lines, strict=True):
        seen = _seen(graph, trimmed, points, axes)
        views.append(View(axes, segments, smooth, frozen(points @ axes.plane.T), seen))
    return tuple(views)


def _seen(graph: BrepGraph, trimmed: TrimmedFaces, points: FloatArray, axes: ViewAxes) -> BoolArray:
    """Tell from which points the viewer is visible, past the faces that the points are on; shape (m,)."""
    angle = np.linspace(0.0, 2.0 * np.pi, EYES, endpoint=False)
    beside = LOOK_PAST * graph.size_mm * (np.stack([np.cos(angle), np.sin(angle)], axis=1) @ axes.plane)
    starts = points[:, None] + beside + CLEAR * LOOK_PAST * graph.size_mm * axes.toward
    rays = np.broadcast_to(axes.toward, starts.shape)
    blocked = is_blocked(trimmed, starts.reshape(-1, 3), rays.reshape(-1, 3), length_mm=2.0 * graph.size_mm)
    return np.asarray(~blocked.reshape(len(points), EYES).all(axis=1))
