"""Boxes around faces on tori: a rounded corner fills little of the box around its whole ring."""

from __future__ import annotations

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.core.arrays import FloatArray, IntArray

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
