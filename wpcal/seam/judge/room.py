"""Where around a part there is room: what is far from all of its triangles need not be compared with them.

The box around the part is divided into cells, and each is as many cells away from one with a triangle in it. A torch on
its way is asked at a few places, wider by as much as it moves until the next of them: on a stretch on which the wider
torch meets nothing, the torch meets nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.tubes import Radius
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.robot.surface_points import surface_points

CELL_MM = 4.0  #: Length of a cell, where the part has not too many.
MOST_CELLS = 500_000  #: Of a part: those of a larger one are longer.
MOST_AWAY = 12  #: Cells are not counted farther.
STRETCH = 8  #: Places on a way of which one is asked for all; most are 1 mm apart.
ALONG_MM = 8.0  #: At most between the points of an axis that are asked.


@dataclass(frozen=True, slots=True, eq=False)
class RoomyMaterial(TriangleMaterial):
    """Triangles with the room around them, for tubes of which neighbours in a list are neighbours in space."""

    low: FloatArray  #: shape (3,). The least corner of the box around the triangles, mm.
    high: FloatArray  #: shape (3,).
    cell_mm: float
    free_mm: FloatArray  #: shape (x, y, z). At least so far is every point of a cell from every triangle.

    def tube_solids(
        self, tips: FloatArray, back: FloatArray, low: FloatArray, high: FloatArray, radius_mm: Radius
    ) -> IntArray:
        """Find the solid of the nearest triangle that each tube meets; shapes as in `Material`."""
        may = self.may_meet(tips + low[:, None] * back, tips + high[:, None] * back, back, float(np.max(radius_mm)))
        rows, solids = np.flatnonzero(may), np.full(len(tips), -1)
        own = tips[rows], back[rows], low[rows], high[rows]
        solids[rows] = TriangleMaterial.tube_solids(self, *own, radius_mm)
        return solids

    def may_meet(self, starts: FloatArray, ends: FloatArray, back: FloatArray, radius_mm: float) -> BoolArray:
        """Tell which tubes may meet a triangle, shape (n,); the answer is one for `STRETCH` tubes.

        `starts`, `ends`: shape (n, 3). Of the axes, mm.
        `back`: shape (n, 3). Unit vectors along the axes.
        """
        of = asked_places(len(starts))
        from_start, from_end, turned = (np.linalg.norm(each - each[of], axis=1) for each in (starts, ends, back))
        moved = np.maximum(from_start, from_end) + radius_mm * turned
        need = np.maximum.reduceat(moved, np.arange(0, len(of), STRETCH)) + np.hypot(radius_mm, ALONG_MM / 2)
        is_near = self.free_along_mm(starts[of[::STRETCH]], ends[of[::STRETCH]]) <= need
        return np.repeat(is_near, STRETCH)[: len(of)]

    def free_along_mm(self, starts: FloatArray, ends: FloatArray) -> FloatArray:
        """Return how far points on segments, at most `ALONG_MM` apart, are at least from every triangle, shape (n,)."""
        axes = (ends - starts)[:, None]
        count = int(np.ceil(np.linalg.norm(axes, axis=2).max(initial=0.0) / ALONG_MM)) + 1
        points = starts[:, None] + np.linspace(0.0, 1.0, count)[:, None] * axes
        inside = np.clip(points, self.low, self.high)
        x, y, z = np.moveaxis(((inside - self.low) / self.cell_mm).astype(np.int64), 2, 0)
        beside = ((points - inside) ** 2).sum(axis=2)
        return np.asarray(np.sqrt(beside + self.free_mm[x, y, z] ** 2).min(axis=1))


def asked_places(count: int) -> IntArray:
    """Return for each of `count` places that one of its stretch that is asked."""
    return np.minimum(np.arange(count) // STRETCH * STRETCH + STRETCH // 2, count - 1)


@lru_cache(maxsize=1)
def with_room(part: TriangleMaterial) -> RoomyMaterial:
    """Return a part, which has triangles, with the room around it."""
    low, high = part.corners.min(axis=(0, 1)), part.corners.max(axis=(0, 1))
    cell_mm = max(CELL_MM, float(np.cbrt(np.prod(high - low) / MOST_CELLS)), float((high - low).max()) / MOST_CELLS)
    near = np.zeros(np.floor((high - low) / cell_mm).astype(np.int64) + 2, dtype=bool)  # one more, for round-off
    for points in surface_points(part.corners, cell_mm):
        near[tuple(((points - low) / cell_mm).astype(np.int64).T)] = True
    away = np.zeros(near.shape, dtype=np.int8)
    for _ in range(MOST_AWAY):
        away += ~near
        for axis in range(3):
            into, out = np.moveaxis(near, axis, 0), np.moveaxis(near.copy(), axis, 0)
            into[1:] |= out[:-1]
            into[:-1] |= out[1:]
    # a triangle is within one cell of its points, and two points are nearer to each other by up to one cell than theirs
    free_mm = np.maximum(away - 2.0, 0.0) * cell_mm
    own = part.corners, part.solid, part.names, part.deflection_mm, part.tree
    return RoomyMaterial(*own, low, high, cell_mm, free_mm)
