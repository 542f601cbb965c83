"""The nearest points of many NURBS surfaces to many points at once: a grid of seeds, then Gauss-Newton steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wpcal.brep.nurbs import NurbsSurface
from wpcal.brep.spans import SurfaceSet
from wpcal.brep.surface_cells import cell_breaks, divided
from wpcal.brep.surface_rays import along_surface
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

SEEDS_PER_SPAN = 3
"""Grid points per knot span and direction at which the search starts, if the span bends less than half a turn."""
CELLS_PER_SEED = 3
"""A span that bends more, such as that of a thread, has a seed for this many of its cells: about each 50 degrees."""
NEWTON_ROUNDS = 12  #: Most Gauss-Newton steps per point; from a seed within a third of a span, 6 were enough.
SETTLED = 1e-14
"""The search of a point ends when a step is below this share of the parameter range: 1e-11 mm on one metre."""
CLOSED_MM, CLOSED_AT = 1e-4, (0.0, 0.4, 1.0)
"""A surface goes round if its two ends along u are this near to each other at these shares of v."""
APART_MM = 1e9
"""Distance between seeds of neighbouring surfaces along a fourth axis: larger than any distance between points."""


@dataclass(frozen=True, slots=True, eq=False)
class NearestOnSurfaces:
    """Finds nearest points on the bounded parts of surfaces."""

    surfaces: SurfaceSet
    #: `low`, `high`: shape (n, 2). Least and greatest u and v of the used part of each surface.
    low: FloatArray
    high: FloatArray
    is_round: BoolArray  #: shape (n,). Whether a surface is closed along u: its two ends there are one.
    breaks: list[tuple[FloatArray, FloatArray]]  #: Where the cells of each surface begin and end (`cell_breaks`).
    seeds: FloatArray  #: shape (k, 2). Parameters of the seeds of all surfaces.
    tree: cKDTree  #: Of the seeds' points, with `APART_MM` times the surface's number as fourth coordinate.

    @classmethod
    def of(cls, surfaces: Sequence[NurbsSurface]) -> NearestOnSurfaces:
        """Place the seeds."""
        bounds = np.array([surface.bounds for surface in surfaces], dtype=np.float64).reshape(-1, 4)
        taken_apart = SurfaceSet.of(surfaces)
        breaks = cell_breaks(surfaces, taken_apart)
        seeds = [_seeds(surface, own) for surface, own in zip(surfaces, breaks, strict=True)]
        number = np.repeat(np.arange(len(surfaces)), [len(uv) for uv in seeds])
        uv = np.concatenate(seeds)
        p = taken_apart.evaluate(number, uv)[0]
        from scipy.spatial import cKDTree

        tree = cKDTree(np.column_stack([p, APART_MM * number]))
        low, high = bounds[:, 0::2], bounds[:, 1::2]
        return cls(taken_apart, low, high, _is_round(taken_apart, low, high), breaks, uv, tree)

    def project(self, surface: IntArray, points: FloatArray) -> FloatArray:
        """Return the parameters of the nearest points of bounded surfaces, shape (m, 2). u and v.

        `surface`: ndarray of int, shape (m,).
        `points`: shape (m, 3). In `part`, mm.
        """
        uv: FloatArray = self.seeds[self.tree.query(np.column_stack([points, APART_MM * surface]))[1]]
        low, high = self.low[surface], self.high[surface]
        settled = SETTLED * (high - low)
        active = np.arange(len(points))
        for _ in range(NEWTON_ROUNDS):
            before = uv[active]
            step = self._step(surface[active], before, points[active])
            after = np.clip(before + step, low[active], high[active])
            turning = self.is_round[surface[active]]
            own, start = active[turning], low[active[turning], 0]
            after[turning, 0] = start + np.mod((before + step)[turning, 0] - start, high[own, 0] - start)
            uv[active] = after
            active = active[(np.abs(uv[active] - before) > settled[active]).any(axis=1)]
            if len(active) == 0:
                break
        return uv

    def _step(self, surface: IntArray, uv: FloatArray, points: FloatArray) -> FloatArray:
        """Return the Gauss-Newton step towards the nearest point; arrays (m,), (m, 2), (m, 3) and (m, 2)."""
        p, du, dv = self.surfaces.evaluate(surface, uv)
        return along_surface(points - p, du, dv)


def _is_round(surfaces: SurfaceSet, low: FloatArray, high: FloatArray) -> BoolArray:
    every, apart = np.arange(len(low)), np.zeros(len(low))
    for share in CLOSED_AT:
        v = low[:, 1] + share * (high[:, 1] - low[:, 1])
        ends = [surfaces.evaluate(every, np.stack([u, v], axis=1))[0] for u in (low[:, 0], high[:, 0])]
        apart = np.maximum(apart, np.linalg.norm(ends[1] - ends[0], axis=1))
    return np.asarray(apart <= CLOSED_MM, dtype=bool)


def _seeds(surface: NurbsSurface, cells: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Return the parameters of a grid over the used part of a surface, finer where its knots are closer."""
    axes = []
    sides = (surface.knots_u, *surface.bounds[:2]), (surface.knots_v, *surface.bounds[2:])
    for (knots, low, high), ends in zip(sides, cells, strict=True):
        breaks = np.unique(np.clip(knots, low, high))
        count = np.diff(np.searchsorted(ends, breaks))
        axes.append(divided(breaks, np.maximum(SEEDS_PER_SPAN, -(-count // CELLS_PER_SEED))))
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
