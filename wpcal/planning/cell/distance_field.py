"""A lower bound of the distance from a part's surface, looked up in a grid: much faster than a distance.

The cells of the grid that contain surface are marked, and every cell gets its distance from the nearest marked one
(`scipy.ndimage.distance_transform_edt`). Less the diagonals of two cells, this is a lower bound for every place in the
cell. Outside the grid the distance from the part's box is the bound.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt

from wpcal.core.arrays import FloatArray
from wpcal.robot.surface_points import surface_points

CELLS = 120  #: Cells along the longest side of the grid: 2 million at most, filled in 0.2 s.
FINEST_MM = 2.0  #: Smaller cells show nothing that matters to a robot.
AROUND_MM = 120.0  #: The grid reaches this far beyond the part's box: a torch outside of it sees more than the box.


@dataclass(frozen=True, slots=True, eq=False)
class DistanceField:
    """The grid of a part."""

    low: FloatArray  #: shape (3,). Corner of the grid, mm.
    cell_mm: float
    bound_mm: FloatArray  #: shape (a, b, c). Lower bounds, mm, not negative.
    box: FloatArray  #: shape (2, 3). The part's own box, mm.

    @classmethod
    def of_triangles(cls, corners: FloatArray) -> DistanceField:
        """Fill a grid. `corners`: shape (m, 3, 3). Corners of triangles in any frame, mm; at least one triangle."""
        box = np.stack([corners.min(axis=(0, 1)), corners.max(axis=(0, 1))])
        low = box[0] - AROUND_MM
        size = box[1] + AROUND_MM - low
        cell = max(FINEST_MM, float(size.max()) / CELLS)
        shape = np.ceil(size / cell).astype(int) + 1
        empty = np.ones(shape, dtype=bool)
        for points in surface_points(corners, cell / 2):
            empty[tuple(((points - low) / cell).astype(int).T)] = False
        # half a diagonal from the place to its centre, half one and a sample from the marked centre to the surface
        slack = cell * math.sqrt(3.0) + cell / 2
        bound = np.asarray(np.maximum(distance_transform_edt(empty) * cell - slack, 0.0), dtype=np.float64)
        return cls(low, cell, bound, box)

    def least(self, points: FloatArray) -> FloatArray:
        """Return lower bounds of the distances of points (n, 3) from the surface, shape (n,), mm."""
        place = np.zeros(len(points), dtype=np.int64)
        inside = np.ones(len(points), dtype=bool)
        beside = np.zeros(len(points))
        for axis, count in enumerate(self.bound_mm.shape):  # long rows: three times as fast as rows of three
            x = points[:, axis]
            index = np.floor((x - self.low[axis]) / self.cell_mm)
            inside &= (index >= 0.0) & (index < count)
            place *= count
            place += np.clip(index, 0.0, count - 1.0).astype(np.int64)
            off = np.maximum(np.maximum(self.box[0, axis] - x, x - self.box[1, axis]), 0.0)
            beside += off * off
        grid = np.where(inside, self.bound_mm.ravel()[place], 0.0)
        return np.asarray(np.maximum(np.sqrt(beside), grid), dtype=np.float64)
