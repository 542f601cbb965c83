"""Distances between many line segments at once.

The three coordinates of points are on the first axis, shape (3, ...): every step is then a few sums over long
contiguous rows, as in `wpcal.robot.kinematics.forward`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wpcal.core.arrays import FloatArray

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

    Notes
    -----
    Segments of length zero are points. Parallel segments have many nearest points; any of them is taken. For touching
    segments that are parallel except for round-off, the error is up to 1e-8 of their length.

    References
    ----------
    Ericson, Real-Time Collision Detection, 2005, §5.1.9.
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
