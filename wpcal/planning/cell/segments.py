"""Distances between many line segments at once.

The three coordinates of points are on the first axis, shape (3, ...): every step is then a few sums over long
contiguous rows, as in `wpcal.robot.kinematics.forward`.

Also here: distances of segments from a part's triangles.

The triangles are within their deflection (`TriangleMaterial.deflection_mm`) of the part; whoever asks for a distance
adds it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.robot.kinematics.forward import cross

LEAST_SQUARED_MM2 = 1e-18
"""Smaller squared lengths are raised to this: a segment of 1e-9 mm counts as a point, and no division is by zero."""


class Segments(NamedTuple):
    """Many segments: starts `p` and spans `u` (end minus start), each of shape (3, ...), mm."""

    p: FloatArray
    u: FloatArray


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the scalar products of vectors of shape (3, ...)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2], dtype=np.float64)


def segment_distances(first: Segments, second: Segments) -> FloatArray:
    r"""Return the smallest distances between segments of two sets, pair by pair, shape (...), mm.

    The squared distance :math:`|p + s u - q - t v|^2` is convex in (s, t). The nearest point on the first line is
    clipped to its segment. Then t is optimised for this s and clipped, then s for this t and clipped. This is exact for
    segments, because at most one of the two clips moves the other point.

    `first`, `second`: Shapes (3, ...) that broadcast, mm.

    Segments of length zero are points. Parallel segments have many nearest points; any of them is taken. For touching
    segments that are parallel except for round-off, the error is up to 1e-8 of their length.

    References: Ericson, Real-Time Collision Detection, 2005, §5.1.9.
    """
    p, u = first
    q, v = second
    r = p - q
    a, e = np.maximum(dot(u, u), LEAST_SQUARED_MM2), np.maximum(dot(v, v), LEAST_SQUARED_MM2)
    b, c, f = dot(u, v), dot(u, r), dot(v, r)
    sine = np.maximum(a * e - b * b, LEAST_SQUARED_MM2)
    s = np.clip((b * f - c * e) / sine, 0.0, 1.0)
    t = np.clip((b * s + f) / e, 0.0, 1.0)
    s = np.clip((b * t - c) / a, 0.0, 1.0)
    gap = r + s * u - t * v
    return np.asarray(np.sqrt(dot(gap, gap)), dtype=np.float64)


CHUNK = 2000  #: Pairs of a segment and a triangle in one array: in a processor's cache, twice as fast.
FLAT = 1e-12  #: A triangle whose area is below this part of its squared edges is a line, and its edges are enough.


def part_distances(
    part: TriangleMaterial, starts: FloatArray, ends: FloatArray, within: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Return the distance of each segment from the part, as far as it is within a bound.

    Returns `distance`: ndarray, shape (n,). mm; infinity where nothing is within the bound.
    Returns `triangle`: ndarray of int, shape (n,). The nearest triangle; -1 where there is none.

    `starts`, `ends`: shape (n, 3). In the frame of the triangles, mm.
    `within`: shape (n,). Beyond this distance, mm, the answer is infinity.
    """
    grow = within[:, None]
    row, triangle = part.tree.meeting(np.minimum(starts, ends) - grow, np.maximum(starts, ends) + grow)
    found = np.empty(len(row))
    for first in range(0, len(row), CHUNK):
        own, which = row[first : first + CHUNK], triangle[first : first + CHUNK]
        found[first : first + CHUNK] = segment_triangle_distances(starts[own], ends[own], part.corners[which])
    best, nearest = np.full(len(starts), np.inf), np.full(len(starts), -1)
    order = np.argsort(-found, kind="stable")  # the nearest of each row is written last
    best[row[order]], nearest[row[order]] = found[order], triangle[order]
    far = best > within
    return np.where(far, np.inf, best), np.where(far, -1, nearest)


def segment_triangle_distances(starts: FloatArray, ends: FloatArray, corners: FloatArray) -> FloatArray:
    """Return the distances of segments from triangles, pair by pair, shape (k,), mm.

    The nearest point is on an edge of the triangle, or at an end of the segment, or where the segment goes through.

    `starts`, `ends`: shape (k, 3). Any frame, mm.
    `corners`: shape (k, 3, 3). Corners of the triangles in the same frame.
    """
    p, q = np.ascontiguousarray(starts.T), np.ascontiguousarray(ends.T)
    a = np.ascontiguousarray(corners.transpose(2, 1, 0))  # (coordinate, corner, k): long rows
    edges = a[:, [1, 2, 0]] - a
    best = segment_distances(Segments(p[:, None], (q - p)[:, None]), Segments(a, edges)).min(axis=0)
    normal = cross(edges[:, 0], -edges[:, 2])
    length = np.sqrt(dot(normal, normal))
    real = length > FLAT * (dot(edges[:, 0], edges[:, 0]) + dot(edges[:, 2], edges[:, 2]))
    normal = np.where(real, normal, 0.0) / np.where(real, length, 1.0)
    inward = cross(normal[:, None], edges)

    def is_over(point: FloatArray) -> BoolArray:
        """Tell whether the projections of points on the planes of triangles are inside the triangles."""
        return np.asarray((dot(inward, point[:, None] - a) >= 0.0).all(axis=0) & real)

    heights = dot(p - a[:, 0], normal), dot(q - a[:, 0], normal)
    for point, height in zip((p, q), heights, strict=True):
        best = np.where(is_over(point), np.minimum(best, np.abs(height)), best)
    span = heights[0] - heights[1]
    crosses = (heights[0] * heights[1] <= 0.0) & (span != 0.0)
    share = heights[0] / np.where(span != 0.0, span, 1.0)
    return np.where(crosses & is_over(p + share * (q - p)), 0.0, best)
