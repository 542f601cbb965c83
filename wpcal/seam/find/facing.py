"""Faces of two solids that face each other at a constant distance: planes, and a cylinder in a hole around it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.strips import items_of
from wpcal.brep.surfaces import part_across, project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray
from wpcal.seam.limits import FLUSH_MM, GAP_ROUND_OFF_MM

OPPOSED = -1.0 + 1e-6
"""Cosine between the normals of planes that are parallel, or the axes of cylinders: within 0.08 degrees, which changes
a gap by 0.1 mm over 70 mm."""
INSET = 0.02
"""Points of a boundary are moved inwards by this share before they are compared with another face: two plates of one
thickness end on the same line."""
LEAST_SHARE = 0.25  #: Share of the boundary of one of two planes that lies opposite the other one.


@dataclass(frozen=True, slots=True, eq=False)
class FacingFaces(Columns):
    """Pairs of faces of different solids."""

    #: `first`, `second`: shape (k,). Faces.
    first: IntArray
    second: IntArray
    gap_mm: FloatArray  #: shape (k,). The constant distance between them.
    #: shape (k,). Which share of the boundary of one of them lies opposite the other one, the larger of the two; 1 for
    #: cylinders.
    share: FloatArray


def find_facing(
    graph: BrepGraph, trimmed: TrimmedFaces, *, most_mm: float, within: BoolArray | None = None
) -> FacingFaces:
    """Find the planes and cylinders that face another solid at a constant distance of at most `most_mm`.

    `within`: shape (S,). Instead, those that face another face of their own solid, of these solids.

    Returns FacingFaces. Gaps below `FLUSH_MM` are left out: those faces touch.
    """
    low, high = trimmed.face_box
    is_even = np.isin(graph.face_kind, (SurfaceKind.PLANE, SurfaceKind.CYLINDER))
    even = np.flatnonzero(is_even if within is None else is_even & within[graph.face_solid])
    row, second = trimmed.box_tree.meeting(low[even] - most_mm, high[even] + most_mm)
    first = even[row]
    pairs = (first < second) & ((graph.face_solid[first] == graph.face_solid[second]) == (within is not None))
    pairs &= graph.face_kind[first] == graph.face_kind[second]
    first, second = first[pairs], second[pairs]
    axes = np.einsum("ki,ki->k", graph.face_frame[first, 3], graph.face_frame[second, 3])
    flat = graph.face_kind[first] == SurfaceKind.PLANE
    out = graph.face_outward[first] * graph.face_outward[second]
    opposed = np.where(flat, axes * out <= OPPOSED, (np.abs(axes) >= -OPPOSED) & (out < 0))
    first, second, flat = first[opposed], second[opposed], flat[opposed]
    gap = np.where(flat, _between_planes(graph, first, second), _between_cylinders(graph, first, second))
    near = (gap > FLUSH_MM) & (gap <= most_mm + GAP_ROUND_OFF_MM)
    first, second, gap, flat = first[near], second[near], gap[near], flat[near]
    share = np.ones(len(first))
    rows = np.flatnonzero(flat)
    ways = [_opposite(graph, trimmed, a[rows], b[rows]) for a, b in ((first, second), (second, first))]
    share[rows] = np.maximum(*ways)
    found = FacingFaces(first, second, gap, share)
    return found.select(share >= LEAST_SHARE)


def _between_planes(graph: BrepGraph, first: IntArray, second: IntArray) -> FloatArray:
    """Return how far the second plane is in front of the first one, mm; negative behind it."""
    normal = graph.face_frame[first, 3] * graph.face_outward[first][:, None]
    return np.asarray(
        np.einsum("ki,ki->k", graph.face_frame[second, 0] - graph.face_frame[first, 0], normal), dtype=np.float64
    )


def _between_cylinders(graph: BrepGraph, first: IntArray, second: IntArray) -> FloatArray:
    """Return how much wider the hole is than the cylinder in it, mm on the radius; -1 if they are not coaxial."""
    o, axis = graph.face_frame[first, 0], graph.face_frame[first, 3]
    off = np.linalg.norm(part_across(graph.face_frame[second, 0] - o, axis), axis=1)
    wider = (graph.face_param[second, 0] - graph.face_param[first, 0]) * graph.face_outward[first]
    return np.where(off <= FLUSH_MM, wider, -1.0)


def _opposite(graph: BrepGraph, trimmed: TrimmedFaces, own: IntArray, other: IntArray) -> FloatArray:
    """Return the share of the boundary of each plane that lies opposite the other one of its pair, shape (k,)."""
    pair, piece = items_of(trimmed.start, own)
    length = np.linalg.norm(trimmed.p1[piece] - trimmed.p0[piece], axis=1)
    middle = (trimmed.p0[piece] + trimmed.p1[piece]) / 2
    total = np.bincount(pair, length, len(own))
    sums = [np.bincount(pair, length * middle[:, k], len(own)) for k in range(3)]
    centre = np.stack(sums, axis=1) / np.where(total > 0, total, 1.0)[:, None]
    points = middle + INSET * (centre[pair] - middle)
    on = trimmed.contains(other[pair], project_to_faces(graph, other[pair], points).uv)
    return np.asarray(np.bincount(pair, length * on, len(own)) / np.where(total > 0, total, 1.0), dtype=np.float64)


def widths_mm(trimmed: TrimmedFaces, faces: IntArray) -> FloatArray:
    """Return about how wide narrow planes are: twice the area by the length of the boundary, shape (k,), mm.

    A rectangle of t by w gives t w / (t + w), a flat ring the width of the ring.

    `faces`: ndarray of int, shape (k,).
    """
    count = trimmed.graph.face_count
    of_face = np.repeat(np.arange(count), np.diff(trimmed.start))
    (u0, v0), (u1, v1) = trimmed.uv0.T, trimmed.uv1.T
    area = np.abs(np.bincount(of_face, (u0 * v1 - u1 * v0) / 2, count))
    around = np.bincount(of_face, np.linalg.norm(trimmed.p1 - trimmed.p0, axis=1), count)
    return np.asarray((2.0 * area / np.where(around > 0, around, 1.0))[faces], dtype=np.float64)
