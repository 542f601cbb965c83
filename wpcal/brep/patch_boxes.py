"""Boxes around faces as tight as they are: around the patches of free-form faces, and around faces on tori.

A long bent tube fills little of the box around the whole face, a rounded corner little of that around its whole ring.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from wpcal.brep.boxes import FAR_MM, BoxTree
from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.nurbs import NurbsSurface
from wpcal.core.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class PatchBoxes:
    """Boxes that together contain each face: one for most faces, one per patch for those with many patches."""

    face: IntArray  #: shape (m,).
    #: `low`, `high`: shape (m, 3). Corners of the boxes, mm.
    low: FloatArray
    high: FloatArray
    tree: BoxTree  #: Of the same boxes.

    @classmethod
    def of(cls, graph: BrepGraph, low: FloatArray, high: FloatArray) -> PatchBoxes:
        """Divide the boxes of free-form faces.

        `low`, `high`: shape (F, 3). Corners of a box around each face, mm. A box of a patch is cut off at the box of
        its face.

        With positive weights a patch is within the box of the poles on which it depends.
        """
        free_form = graph.face_kind == SurfaceKind.NURBS
        whole = np.flatnonzero(~free_form)
        faces, lows, highs = [whole], [low[whole]], [high[whole]]
        for face in np.flatnonzero(free_form).tolist():
            own_low, own_high = patch_corners(graph.nurbs_surfaces[graph.face_nurbs[face]])
            own_low, own_high = np.maximum(own_low, low[face]), np.minimum(own_high, high[face])
            real = (own_low <= own_high).all(axis=1)
            faces.append(np.full(int(real.sum()), face))
            lows.append(own_low[real])
            highs.append(own_high[real])
        every_low, every_high = np.concatenate(lows), np.concatenate(highs)
        return cls(np.concatenate(faces), every_low, every_high, BoxTree.of(every_low, every_high))

    def without(self, left_out: BoolArray) -> PatchBoxes:
        """Return the boxes with those of some faces empty (mask over all faces, shape (F,))."""
        gone = left_out[self.face]
        low, high = np.where(gone[:, None], FAR_MM, self.low), np.where(gone[:, None], -FAR_MM, self.high)
        return PatchBoxes(self.face, low, high, self.tree.without(gone))


def patch_corners(surface: NurbsSurface) -> tuple[FloatArray, FloatArray]:
    """Return the corners of a box around each patch of the used part, two arrays (k, 3), mm."""
    first_u, last_u, first_v, last_v = surface.bounds
    at_u = _spans(surface.knots_u, surface.degrees[0], first_u, last_u)
    at_v = _spans(surface.knots_v, surface.degrees[1], first_v, last_v)
    du, dv = surface.degrees
    low, high = [], []
    for i in at_u:
        rows = surface.poles[i - du : i + 1]
        low_v, high_v = rows.min(axis=0), rows.max(axis=0)
        for j in at_v:
            low.append(low_v[j - dv : j + 1].min(axis=0))
            high.append(high_v[j - dv : j + 1].max(axis=0))
    return np.reshape(low, (-1, 3)), np.reshape(high, (-1, 3))


def _spans(knots: FloatArray, degree: int, first: float, last: float) -> list[int]:
    """Return the numbers of the knot spans that have a length and hold parameters of the used part."""
    inner = range(degree, len(knots) - degree - 1)
    ends = list(pairwise(knots[degree : len(knots) - degree].tolist()))
    return [i for i, (a, b) in zip(inner, ends, strict=True) if a < b and a <= last and b >= first]


TURN = 2.0 * np.pi


def widest_gaps(first: FloatArray, step: FloatArray, owner: IntArray, count: int) -> FloatArray:
    """Return where the widest gap between arcs on a circle begins and ends, shape (count, 2), rad; 0 and 0 for none.

    `first`, `step`: shape (m,). Where arcs begin, and how far they turn (less than half a turn, either way).
    `owner`: shape (m,). Number of the circle of each arc, ascending.
    """
    begin = np.mod(np.minimum(first, first + step), TURN)
    owner, begin, size = np.tile(owner, 2), np.concatenate([begin - TURN, begin]), np.tile(np.abs(step), 2)
    order = np.lexsort((begin, owner))
    owner, begin, size = owner[order], begin[order], size[order]
    base = 4.0 * TURN * owner  # what one circle reaches is before all of the next one
    until = np.maximum.accumulate(base + begin + size) - base
    gap = np.where(owner[1:] == owner[:-1], begin[1:] - until[:-1], 0.0)
    order = np.flatnonzero(gap > 0.0)[np.argsort(gap[gap > 0.0], kind="stable")]
    gaps = np.zeros((count, 2))
    gaps[owner[order]] = np.stack([until[order], begin[order + 1]], axis=1)  # the widest one is written last
    return gaps


def ring_boxes(graph: BrepGraph, faces: IntArray, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the corners of the boxes around parts of tori, two arrays (k, 3), mm.

    Along a direction with the components (x, y, z) in the frame of a torus, a point lies at (R + r cos v) h + r z sin v
    with h = x cos u + y sin u. That is linear in h, so its extremes are at the extremes of h.

    `faces`: shape (k,). `u`, `v`: shape (k, 2). Between which angles the parts lie, rad.
    """
    x, y, z = (graph.face_frame[faces, axis] for axis in (1, 2, 3))
    major, minor = (graph.face_param[faces, column, None] for column in (0, 1))
    heights = -_greatest(-x, -y, u), _greatest(x, y, u)
    middle = graph.face_frame[faces, 0]
    low = np.minimum(*(major * h - minor * _greatest(-h, -z, v) for h in heights))
    return middle + low, middle + np.maximum(*(major * h + minor * _greatest(h, z, v) for h in heights))


def _greatest(a: FloatArray, b: FloatArray, ends: FloatArray) -> FloatArray:
    """Return the greatest value of a cos t + b sin t, shape (k, 3), between two angles, `ends` (k, 2)."""
    first, last = ends[:, :1], ends[:, 1:]
    at_ends = [a * np.cos(t) + b * np.sin(t) for t in (first, last)]
    is_between = np.mod(np.arctan2(b, a) - first, TURN) <= last - first
    return np.asarray(np.where(is_between, np.hypot(a, b), np.maximum(*at_ends)))
