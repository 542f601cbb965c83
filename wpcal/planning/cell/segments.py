"""Distances between many line segments at once.

Points are kept with their three coordinates on the first axis, shape (3, ...): every step is then a few sums over long
contiguous rows, as in `wpcal.robot.kinematics.forward`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wpcal.core.arrays import FloatArray

LEAST_SQUARED_MM2 = 1e-18
"""Squared lengths below this are raised to it: a segment of 1e-9 mm is a point, and nothing is divided by zero."""


class Segments(NamedTuple):
    """Many segments: starts `p` and spans `u` (end minus start), each of shape (3, ...), mm."""

    p: FloatArray
    u: FloatArray


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the scalar products of vectors of shape (3, ...)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2], dtype=np.float64)


def segment_distances(first: Segments, second: Segments) -> FloatArray:
    r"""Return the smallest distances between segments of two sets, pair by pair.

    The squared distance :math:`|p + s u - q - t v|^2` is convex in (s, t). The foot on the first line is cut to its
    segment, then t is the best answer to it, cut, then s the best answer to that t: exact for segments, since at most
    one of the two cuts moves the other foot.

    Parameters
    ----------
    first, second : Segments
        Shapes (3, ...) that broadcast.

    Returns
    -------
    ndarray, shape (...)
        mm.

    Notes
    -----
    Segments of no length are points. Parallel segments have many nearest points, any of which is taken. Segments that
    are parallel to round-off and touch are off by up to 1e-8 of their length.

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
