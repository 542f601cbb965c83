"""A lower bound of the distance from a part's surface, looked up in a grid: much faster than a distance.

The cells of the grid that contain surface are marked, and every cell gets its distance from the nearest marked one
(`scipy.ndimage.distance_transform_edt`). Less the diagonals of two cells, this is a lower bound for every place in the
cell. Outside the grid the distance from the part's box is the bound.

Also here: balls over a convex hull. With a grid of distances they settle at many states at once if the hull is clear.

The balls together hold the hull. If each is clear of the surface, the hull is. A point that is farther inside the hull
than it is from the surface proves the opposite. A ball that is neither is replaced by the smaller ones in it. What is
left after the smallest is for an exact distance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import ConvexHull

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.same_bits import product
from wpcal.planning.cell.shape import Shape
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
    slack_mm: float  #: A distance is at most its bound and this.

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
        return cls(low, cell, bound, box, slack + cell * math.sqrt(3.0))

    def between(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return bounds of the distances of points from the surface.

        `points`: shape (n, 3). In the frame of the triangles, mm.
        Returns `least, most`: ndarray, shape (n,). mm; `most` is infinite outside the grid.
        """
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
        grid = self.bound_mm.ravel()[place]
        least = np.maximum(np.sqrt(beside), np.where(inside, grid, 0.0))
        return np.asarray(least, dtype=np.float64), np.where(inside, grid + self.slack_mm, np.inf)


ALONG = 6  #: Largest balls along the longest side of the hull's box: some tens of them.
LEVELS = 3  #: Sizes of balls, each half of the one before: the smallest is 1/24 of the longest side.
APART = 0.4  #: Of faces whose normals are nearer to each other than this, one is compared: some tens of faces.
CENTRES_AT_ONCE = 500  #: Compared with all planes: arrays that stay in the cache.
HALVES = np.array(np.meshgrid(*((-0.25, 0.25),) * 3)).reshape(3, -1).T
"""Centres of the eight parts of a cube, in parts of its side."""


@dataclass(frozen=True, slots=True, eq=False)
class _Level:
    """Balls around cubes of one size; `parts` (m, 8) are rows of the next size, -1 where nothing of the hull is."""

    centres: FloatArray
    inside_mm: FloatArray
    radius_mm: float
    parts: IntArray

    @classmethod
    def of(cls, centres: FloatArray, side_mm: float, planes: FloatArray, above: _Level | None = None) -> _Level:
        """Return the balls around cubes with something of the hull; those of the size above learn their rows."""
        radius = side_mm * math.sqrt(3.0) / 2
        some = np.array_split(centres.T, math.ceil(len(centres) / CENTRES_AT_ONCE), axis=1)
        inside = np.concatenate([-(product(planes[:, :3], x) + planes[:, 3:]).max(axis=0) for x in some])
        near = inside >= -radius  # the cube around another centre has nothing of the hull
        if above is not None:
            above.parts[...] = np.where(near, np.cumsum(near) - 1, -1).reshape(-1, len(HALVES))
        return cls(centres[near], inside[near], radius, np.full((np.count_nonzero(near), len(HALVES)), -1))


@dataclass(frozen=True, slots=True, eq=False)
class HullCover:
    """Balls that hold a hull, in several sizes, each size all of it; and the planes of the hull's faces."""

    levels: list[_Level]  #: As far as they were asked for.
    every: FloatArray  #: shape (f, 4). All planes.
    planes: FloatArray  #: shape (g, 4). Some, of which no two are nearly parallel.
    deepest_mm: float  #: No point of the hull is deeper in it.
    step_mm: float  #: Side of the first cubes.

    @classmethod
    def of_hull(cls, corners: FloatArray) -> HullCover:
        """Cover a hull with balls around the cells of a grid.

        `corners`: shape (n, 3). Of the hull, not in one plane, mm.
        """
        low, high = corners.min(axis=0), corners.max(axis=0)
        step = float((high - low).max()) / ALONG
        count = np.ceil((high - low) / step).astype(int)
        axes = [(low[k] + high[k]) / 2 + step * (np.arange(count[k]) - (count[k] - 1) / 2) for k in range(3)]
        planes = ConvexHull(corners).equations
        _, some = np.unique(np.round(planes[:, :3] / APART), axis=0, return_index=True)
        first = _Level.of(np.array(np.meshgrid(*axes)).reshape(3, -1).T, step, planes)
        few = planes[np.sort(some)]
        thick = -(product(few[:, :3], corners.T) + few[:, 3:]).min(axis=1)
        return cls([first], planes, few, float(thick.min()) / 2, step)

    def _level(self, number: int) -> _Level:
        if number == len(self.levels):
            above, side_mm = self.levels[-1], self.step_mm / 2**number
            centres = (above.centres[:, None] + HALVES * 2 * side_mm).reshape(-1, 3)
            self.levels.append(_Level.of(centres, side_mm, self.every, above))
        return self.levels[number]

    def beyond_a_face(self, outline: FloatArray, T: FloatArray) -> FloatArray:
        """Return lower bounds of the distances of points from the hull: they are all beyond one of its faces by this.

        `outline`: shape (m, 3). Points in the frame of the surface, mm; the bound holds for their convex hull.
        `T`: shape (n, 4, 4). ``T_surface_body``, mm.
        Returns ndarray, shape (n,). mm; 0 where no face has all points beyond it.
        """
        normal = np.einsum("nij,fj->nfi", T[:, :3, :3], self.planes[:, :3])  # in the frame of the surface
        off = self.planes[:, 3] - np.einsum("nfi,ni->nf", normal, T[:, :3, 3])
        out = np.einsum("nfi,mi->mnf", normal, outline).min(axis=0) + off
        return np.asarray(np.maximum(out.max(axis=1), 0.0), dtype=np.float64)

    def settled(self, field: DistanceField, T: FloatArray, needed_mm: float) -> tuple[FloatArray, BoolArray]:
        """Compare the hull with a surface at many states.

        `T`: shape (n, 4, 4). ``T_surface_body``, mm.
        Returns `margin`: ndarray, shape (n,). Lower bounds of distance less `needed_mm`, mm.
        Returns `meets`: ndarray of bool, shape (n,). Whether the surface is surely inside the hull somewhere.
        """
        margin, meets = np.full(len(T), np.inf), np.zeros(len(T), dtype=bool)
        R, p = np.ascontiguousarray(T[:, :3, :3]), T[:, :3, 3]
        count = len(self.levels[0].centres)
        state, ball = np.repeat(np.arange(len(T)), count), np.tile(np.arange(count), len(T))
        for number in range(LEVELS):
            level = self._level(number)
            places = np.einsum("nij,nj->ni", R[state], level.centres[ball]) + p[state]
            bound, most = field.between(places)
            meets[state[most < level.inside_mm[ball]]] = True
            free = bound - level.radius_mm - needed_mm
            wide = (free <= 0.0) & ~meets[state]
            # where the grid says nothing more of a ball, smaller ones are as near; only a deep one may still meet
            deep = np.minimum(level.inside_mm + level.radius_mm, self.deepest_mm) > field.slack_mm
            left = np.bincount(state[wide & (bound <= 0.0)], minlength=len(T)) > 0
            left[state[wide & deep[ball]]] = False
            wide &= ~left[state]
            if number == LEVELS - 1 or not wide.any():
                np.minimum.at(margin, state, free)
                break
            np.minimum.at(margin, state[~wide], free[~wide])
            self._level(number + 1)
            parts = level.parts[ball[wide]]
            state, ball = np.repeat(state[wide], len(HALVES))[parts.ravel() >= 0], parts[parts >= 0]
        return margin, meets


@lru_cache(maxsize=256)
def cover_of(shape: Shape) -> HullCover:
    """Return the cover of a body with a hull; cells that differ in their places have the same bodies."""
    return HullCover.of_hull(shape.hull)
