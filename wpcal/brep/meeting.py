"""Where two surfaces meet, or where a ball touches both: Newton's method in planes across a curve, many at once.

In the plane through p0 with the normal x, a point p at the height h above both surfaces solves

    n1 · (p − f1) = h,   n2 · (p − f2) = h,   x · (p − p0) = 0,

with f the nearest points of the surfaces and n their normals there. With h = 0 the surfaces meet at p; otherwise p is
the centre of a ball of radius h that touches both from outside.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import FloatArray, IntArray

NEWTON_ROUNDS = 12
"""Most steps of Newton's method, which squares the distance in each step; analytic surfaces need 5."""
SETTLED_MM = 1e-8
"""The search for a point ends when it moves by less: the next step would be below round-off. Each point ends by itself,
so that it does not depend on the others."""


def meet_surfaces(
    graph: BrepGraph,
    first: IntArray,
    second: IntArray,
    p0: FloatArray,
    x: FloatArray,
    *,
    height_mm: FloatArray | float = 0.0,
    least_sin: float,
) -> FloatArray:
    """Return points at one height above two surfaces, in planes through given points.

    Parameters
    ----------
    graph : BrepGraph
    first, second : ndarray of int, shape (n,)
        Faces; their whole surfaces count.
    p0 : ndarray, shape (n, 3)
        Where the search starts, in `part`, mm.
    x : ndarray, shape (n, 3)
        Unit normals of the planes through p0.
    height_mm : ndarray of shape (n,), or float
        Above both surfaces, on the outer side.
    least_sin : float
        Where the surfaces are nearer to parallel than this sine, there is no answer.

    Returns
    -------
    ndarray, shape (n, 3)
        In `part`, mm; NaN where there is no answer.
    """
    p, height = p0.copy(), np.broadcast_to(height_mm, len(p0))
    rows = np.arange(len(p0))
    for _ in range(NEWTON_ROUNDS):
        at, normal = p[rows], x[rows]
        feet = [project_to_faces(graph, face[rows], at) for face in (first, second)]
        A = np.stack([feet[0].normal, feet[1].normal, normal], axis=1)
        lost = np.abs(np.linalg.det(A)) < least_sin
        A[lost] = np.eye(3)
        off = [np.einsum("ki,ki->k", foot.p - at, foot.normal) + height[rows] for foot in feet]
        back = np.einsum("ki,ki->k", p0[rows] - at, normal)
        step = np.linalg.solve(A, np.stack([*off, back], axis=1)[..., None])[..., 0]
        step[lost] = np.nan
        p[rows] += step
        rows = rows[(np.abs(step) > SETTLED_MM).any(axis=1)]
        if len(rows) == 0:
            break
    return p
