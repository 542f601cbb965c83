"""A table of boxes that says quickly, for millions of places, whether a point may be near."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray

MOST_BOXES = 2.5e7  #: One byte per box: 25 megabytes.
BOXES_PER_POINT = 1000.0
"""About a hundred boxes are marked around a point: nine of ten places far from all points are then told at once."""


@dataclass(frozen=True, slots=True, eq=False)
class Occupancy:
    """Boxes of one size over the points; those near a point are marked."""

    low: FloatArray  #: shape (3,). Corner of the table, mm.
    size_mm: float  #: Side of a box.
    marked: BoolArray  #: shape (nx, ny, nz).

    @classmethod
    def around(cls, points: FloatArray, reach_mm: float) -> Occupancy:
        """Mark every box that holds a place within reach of a point, and some that only nearly do.

        `points`: shape (N, 3). mm.
        """
        from scipy.ndimage import binary_dilation

        span = np.ptp(points, axis=0) + 4.0 * reach_mm
        boxes = min(MOST_BOXES, BOXES_PER_POINT * len(points))
        size = max(0.5 * reach_mm, float(np.cbrt(np.prod(span) / boxes)))
        low = points.min(axis=0) - 2.0 * reach_mm
        shape = np.ceil(span / size).astype(np.int64) + 1
        marked = np.zeros(shape, dtype=bool)
        marked[tuple(((points - low) / size).astype(np.int64).T)] = True
        return cls(low, size, np.asarray(binary_dilation(marked, _ball(reach_mm / size))))

    def has_points_near(self, places: FloatArray) -> BoolArray:
        """Tell for places, shape (m, 3), whether a point may be within reach; False means that none is."""
        box: IntArray = np.floor((places - self.low) / self.size_mm).astype(np.int64)
        inside = ((box >= 0) & (box < self.marked.shape)).all(axis=1)
        box[~inside] = 0
        return np.asarray(inside & self.marked[tuple(box.T)])


def _ball(reach: float) -> BoolArray:
    """Boxes whose nearest corner is within reach of some place in the middle box; reach in box sides."""
    n = int(np.ceil(reach))
    steps = np.maximum(np.abs(np.arange(-n, n + 1)) - 1, 0)
    square = steps**2
    return np.asarray(square[:, None, None] + square[:, None] + square <= reach**2)
