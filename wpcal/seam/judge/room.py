"""Where around a part there is room: what is far from all of its triangles need not be compared with them.

The box around the part is divided into cells, and each is as many cells away from one with a triangle in it. A torch on
its way is asked at a few places, wider by as much as it moves until the next of them: on a stretch on which the wider
torch meets nothing, the torch meets nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.tubes import Radius
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

CELL_MM = 4.0  #: Length of a cell, where the part has not too many.
MOST_CELLS = 500_000  #: Of a part: those of a larger one are longer.
STRETCH = 8  #: Places on a way of which one is asked for all; most are 1 mm apart.
ALONG_MM = 8.0  #: At most between the points of an axis that are asked.


@dataclass(frozen=True, slots=True, eq=False)
class RoomyMaterial(TriangleMaterial):
    """Triangles with the room around them, for tubes of which neighbours in a list are neighbours in space."""

    low: FloatArray  #: shape (3,). The least corner of the box around the triangles, mm.
    high: FloatArray  #: shape (3,).
    cell_mm: float
    free_mm: FloatArray  #: shape (x, y, z). At least this far is every point of a cell from every triangle.

    def tube_solids(
        self, tips: FloatArray, back: FloatArray, low: FloatArray, high: FloatArray, radius_mm: Radius
    ) -> IntArray:
        """Find the solid of the nearest triangle that each tube meets; shapes as in `Material`."""
        may = self.may_meet(tips + low[:, None] * back, tips + high[:, None] * back, back, float(np.max(radius_mm)))
        rows, solids = np.flatnonzero(may), np.full(len(tips), -1)
        solids[rows] = TriangleMaterial.tube_solids(self, tips[rows], back[rows], low[rows], high[rows], radius_mm)
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
        return np.repeat(self.free_along_mm(starts[of[::STRETCH]], ends[of[::STRETCH]]) <= need, STRETCH)[: len(of)]

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
    from scipy.ndimage import distance_transform_cdt

    low, high = part.corners.min(axis=(0, 1)), part.corners.max(axis=(0, 1))
    cell_mm = max(CELL_MM, float(np.cbrt(np.prod(high - low) / MOST_CELLS)), float((high - low).max()) / MOST_CELLS)
    near = np.zeros(np.floor((high - low) / cell_mm).astype(np.int64) + 2, dtype=bool)  # one more, for round-off
    for points in _points(part.corners, cell_mm):
        near[tuple(((points - low) / cell_mm).astype(np.int64).T)] = True
    # a cell that is k away is at least k - 1 cells from every point, and triangles reach at most one cell beyond these
    free_mm = np.maximum(distance_transform_cdt(~near, metric="chessboard") - 2.0, 0.0) * cell_mm
    own = part.corners, part.solid, part.names, part.deflection_mm, part.tree
    return RoomyMaterial(*own, low, high, cell_mm, free_mm)


def _points(corners: FloatArray, near_mm: float) -> Iterator[FloatArray]:
    """Yield points on triangles, shape (k, 3), in rows along their longest sides, within `near_mm` of every place."""
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    a, b, c = (corners[np.arange(len(corners)), (sides.argmax(axis=1) + k) % 3] for k in range(3))
    high = np.linalg.norm(np.cross(b - a, c - a), axis=1) / np.maximum(sides.max(axis=1), np.finfo(float).tiny)
    counts = np.ceil(np.stack([sides.max(axis=1), high / 0.8], axis=1) / near_mm).astype(np.int64) + 1
    for along, rows in np.unique(counts, axis=0).tolist():  # the lower of two rows is beside all places between them
        own = np.flatnonzero((counts == (along, rows)).all(axis=1))
        u, v = np.meshgrid(np.linspace(0.0, 1.0, along), np.linspace(0.0, 1.0, rows))
        weights = np.stack([(1.0 - u) * (1.0 - v), u * (1.0 - v), v]).reshape(3, -1, 1, 1)
        for some in np.array_split(own, len(own) * u.size // MOST_CELLS + 1):
            yield (weights * np.stack([a[some], b[some], c[some]])[:, None]).sum(axis=0).reshape(-1, 3)
