"""Where two surfaces meet, or where a ball touches both: Newton's method in planes across a curve, many at once.

In the plane through p0 with the normal x, a point p at the height h above both surfaces solves

    n1 · (p − f1) = h,   n2 · (p − f2) = h,   x · (p − p0) = 0,

with f the nearest points of the surfaces and n their normals there. With h = 0 the surfaces meet at p; otherwise p is
the centre of a ball of radius h that touches both from outside.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import Columns, FloatArray, IntArray

NEWTON_ROUNDS = 12  #: Most steps of Newton's method, which squares the distance in each step; analytic surfaces need 5.
SETTLED_MM = 1e-8
"""The search for a point ends when it moves by less: the next step would be below round-off. Each point ends by itself,
so that it does not depend on the others."""

Feet: TypeAlias = "Callable[[IntArray, FloatArray], list[tuple[FloatArray, FloatArray]]]"
"""The nearest points of two surfaces to points in some rows, and the normals there."""


@dataclass(frozen=True, slots=True, eq=False)
class MovedFaces(Columns):
    """Faces that are not where the model has them."""

    face: IntArray  #: shape (n,).
    #: `R`, `t`: shapes (n, 3, 3), (n, 3). From the model to where each face is, mm.
    R: FloatArray
    t: FloatArray

    def feet(self, graph: BrepGraph, p: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the nearest points on the moved surfaces, and their outward normals there, shapes (n, 3)."""
        foot = project_to_faces(graph, self.face, np.einsum("nij,ni->nj", self.R, p - self.t))
        return (np.einsum("nij,nj->ni", self.R, foot.p) + self.t, np.einsum("nij,nj->ni", self.R, foot.normal))


def meet_moved(
    graph: BrepGraph, first: MovedFaces, second: MovedFaces, p0: FloatArray, x: FloatArray, *, least_sin: float
) -> FloatArray:
    """Return the points where moved surfaces meet, in planes through given points.

    `p0`, `x`: shape (n, 3). A point of each plane, where the search starts, and its unit normal, mm.
    Returns ndarray, shape (n, 3). mm; NaN where there is no answer.
    """

    def feet(rows: IntArray, at: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        return [moved.select(rows).feet(graph, at) for moved in (first, second)]

    return _met(feet, p0, x, np.zeros(len(p0)), least_sin)


def meet_surfaces(
    graph: BrepGraph,
    faces: IntArray,
    p0: FloatArray,
    x: FloatArray,
    *,
    height_mm: FloatArray | float = 0.0,
    least_sin: float,
) -> FloatArray:
    """Return points at one height above two surfaces, in planes through given points.

    Returns ndarray, shape (n, 3). In `part`, mm; NaN where there is no answer.

    `faces`: shape (2, n). Two for each point; their whole surfaces count.
    `p0`: shape (n, 3). Where the search starts, in `part`, mm.
    `x`: shape (n, 3). Unit normals of the planes through p0.
    `height_mm`: shape (n,), or float. Above both surfaces, on the outer side.
    """

    def feet(rows: IntArray, at: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        found = [project_to_faces(graph, face[rows], at) for face in faces]
        return [(foot.p, foot.normal) for foot in found]

    return _met(feet, p0, x, np.broadcast_to(height_mm, len(p0)), least_sin)


def _met(feet: Feet, p0: FloatArray, x: FloatArray, height: FloatArray, least_sin: float) -> FloatArray:
    """Newton's method of all points, shape (n, 3); `feet` gives the nearest points and normals of both surfaces."""
    p, rows = p0.copy(), np.arange(len(p0))
    for _ in range(NEWTON_ROUNDS):
        at, normal = p[rows], x[rows]
        first, second = feet(rows, at)
        A = np.stack([first[1], second[1], normal], axis=1)
        lost = np.abs(np.linalg.det(A)) < least_sin
        A[lost] = np.eye(3)
        off = [np.einsum("ki,ki->k", foot - at, n) + height[rows] for foot, n in (first, second)]
        back = np.einsum("ki,ki->k", p0[rows] - at, normal)
        step = np.linalg.solve(A, np.stack([*off, back], axis=1)[..., None])[..., 0]
        step[lost] = np.nan
        p[rows] += step
        rows = rows[(np.abs(step) > SETTLED_MM).any(axis=1)]
        if len(rows) == 0:
            break
    return p
