"""Distances of segments from a part's triangles.

The triangles are within their deflection (`TriangleMaterial.deflection_mm`) of the part; whoever asks for a distance
adds it.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.planning.cell.segments import Segments, segment_distances

CHUNK = 200_000  #: Pairs of a segment and a triangle in one array: some 50 MB.
FLAT = 1e-12  #: A triangle whose area is below this part of its squared edges is a line, and its edges are enough.


def part_distances(
    part: TriangleMaterial, starts: FloatArray, ends: FloatArray, within: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Return the distance of each segment from the part, as far as it is within a bound.

    Returns `distance`: ndarray, shape (n,). mm; infinity where nothing is within the bound.
    Returns `triangle`: ndarray of int, shape (n,). The nearest triangle; -1 where there is none.

    Parameters
    ----------
    starts, ends : shape (n, 3). In the frame of the triangles, mm.
    within : shape (n,). Beyond this distance, mm, the answer is infinity.
    """
    grow = within[:, None]
    row, triangle = part.tree.meeting(np.minimum(starts, ends) - grow, np.maximum(starts, ends) + grow)
    best, nearest = np.full(len(starts), np.inf), np.full(len(starts), -1)
    for first in range(0, len(row), CHUNK):
        own, which = row[first : first + CHUNK], triangle[first : first + CHUNK]
        found = segment_triangle_distances(starts[own], ends[own], part.corners[which])
        order = np.argsort(-found, kind="stable")  # the nearest of each row is written last
        closer = order[found[order] < best[own[order]]]
        best[own[closer]], nearest[own[closer]] = found[closer], which[closer]
    far = best > within
    return np.where(far, np.inf, best), np.where(far, -1, nearest)


def segment_triangle_distances(starts: FloatArray, ends: FloatArray, corners: FloatArray) -> FloatArray:
    """Return the distances of segments from triangles, pair by pair, shape (k,), mm.

    The nearest point is on an edge of the triangle, or at an end of the segment, or where the segment goes through.

    `starts`, `ends`: shape (k, 3). Any frame, mm.
    `corners`: shape (k, 3, 3). Corners of the triangles in the same frame.
    """
    segments = Segments(starts.T, (ends - starts).T)
    best = np.full(len(starts), np.inf)
    for k in range(3):
        edge = Segments(corners[:, k].T, (corners[:, (k + 1) % 3] - corners[:, k]).T)
        best = np.minimum(best, segment_distances(segments, edge))
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    real = length > FLAT * ((corners - corners[:, :1]) ** 2).sum(axis=(1, 2))
    normal = np.where(real[:, None], normal, 0.0) / np.where(real, length, 1.0)[:, None]
    heights = [np.einsum("ij,ij->i", point - corners[:, 0], normal) for point in (starts, ends)]
    for point, height in zip((starts, ends), heights, strict=True):
        over = real & _is_over(point, corners, normal)
        best = np.where(over, np.minimum(best, np.abs(height)), best)
    span = heights[0] - heights[1]
    crosses = real & (heights[0] * heights[1] <= 0.0) & (span != 0.0)
    share = heights[0] / np.where(span != 0.0, span, 1.0)
    through = crosses & _is_over(starts + share[:, None] * (ends - starts), corners, normal)
    return np.where(through, 0.0, best)


def _is_over(points: FloatArray, corners: FloatArray, normal: FloatArray) -> BoolArray:
    """Tell whether the projections of points on the planes of triangles are inside the triangles."""
    over = np.ones(len(points), dtype=bool)
    for k in range(3):
        edge = corners[:, (k + 1) % 3] - corners[:, k]
        over &= np.einsum("ij,ij->i", np.cross(normal, edge), points - corners[:, k]) >= 0.0
    return over
