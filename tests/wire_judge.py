"""How deep points are inside a part, by its triangles alone: nothing of the planner is used here.

A point is inside where the winding number of the triangles says so (Van Oosterom, Strackee, The solid angle of a plane
triangle, 1983).
"""

from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]
AT_ONCE = 200


def winding(points: Array, corners: Array) -> Array:
    """Return the winding numbers of points (n, 3) about triangles (m, 3, 3): 1 inside a solid, 0 outside."""
    found = np.empty(len(points))
    for first in range(0, len(points), AT_ONCE):
        a, b, c = (corners[None, :, k] - points[first : first + AT_ONCE, None] for k in range(3))
        la, lb, lc = (np.linalg.norm(x, axis=2) for x in (a, b, c))
        triple = np.einsum("nmi,nmi->nm", a, np.cross(b, c))
        dots = [np.einsum("nmi,nmi->nm", x, y) for x, y in ((a, b), (b, c), (c, a))]
        found[first : first + AT_ONCE] = np.arctan2(
            triple, la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
        ).sum(axis=1) / (2.0 * np.pi)
    return found


def off_surface(points: Array, corners: Array) -> Array:
    """Return the distances of points (n, 3) from triangles (m, 3, 3)."""
    found = np.empty(len(points))
    for first in range(0, len(points), AT_ONCE):
        p = points[first : first + AT_ONCE, None]
        best = np.full((p.shape[0], len(corners)), np.inf)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        over = np.ones(best.shape, dtype=bool)
        for k in range(3):
            a, edge = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
            t = np.clip(((p - a) * edge).sum(axis=2) / np.maximum((edge * edge).sum(axis=1), 1e-18), 0.0, 1.0)
            best = np.minimum(best, np.linalg.norm(p - a - t[..., None] * edge, axis=2))
            over &= np.einsum("nmi,mi->nm", p - a, np.cross(normal, edge)) >= 0.0
        height = np.abs(np.einsum("nmi,mi->nm", p - corners[:, 0], normal))
        found[first : first + AT_ONCE] = np.where(over, np.minimum(best, height), best).min(axis=1)
    return found
