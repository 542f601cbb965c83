"""Where rays go through free-form surfaces: Newton's method from the cells whose boxes they meet."""

from dataclasses import dataclass, replace

import numpy as np

from wpcal.brep.surface_cells import SurfaceCells
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray

NEWTON_ROUNDS = 12
"""Most steps; from the middle of a cell, 5 were enough for all but rays that nearly touch the surface."""
EXACT_MM = 1e-9  #: A point of the surface that is this near to the ray is a crossing.
SHALLOW = 0.35
"""A ray whose angle to the surface has a smaller sine may go through a cell twice: it is followed from both ends."""
TOO_FAR = 1.0
"""A ray that is not shallow misses a cell if the first step ends this many widths of the cell beyond it: normals in a
cell turn too little for it to come back."""
SLACK = 1e-6
"""A crossing this far beyond a cell, relative to its width, counts: it may lie on the border of two cells."""
SAME_MM = 1e-5  #: Crossings of one ray and one face in one direction that are this near to each other are one.


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceHits(Columns):
    """Crossings of rays and whole surfaces."""

    row: IntArray  #: shape (h,). The pair of a ray and a surface.
    at_mm: FloatArray  #: shape (h,). Distance from the start of the ray.
    uv: FloatArray  #: shape (h, 2).
    normal: FloatArray  #: shape (h, 3). du × dv, not of length 1.


def meet_rays(
    cells: SurfaceCells, surface: IntArray, origins: FloatArray, rays: FloatArray, low: FloatArray, high: FloatArray
) -> SurfaceHits:
    """Find where rays go through the used parts of surfaces.

    Returns SurfaceHits. A ray that only touches a surface may have none or two that coincide.

    `surface`: ndarray of int, shape (k,)
    `origins`, `rays`: shape (k, 3). Starts (mm) and unit directions in `part`.
    `low`, `high`: shape (k,). Distances between which crossings are looked for, mm.
    """
    o, d = np.ascontiguousarray(origins.T), np.ascontiguousarray(rays.T)
    with np.errstate(divide="ignore", invalid="ignore"):

        def meets(row: IntArray, box_low: FloatArray, box_high: FloatArray) -> BoolArray:
            enter, leave = way_through(o[:, row], d[:, row], low[row], high[row], box_low, box_high)
            return np.asarray(leave >= enter, dtype=bool)

        row, cell = cells.find_near(surface, meets)
        corner_low, corner_high = (
            np.take(corner, cell, axis=1) for corner in (cells.levels[0].low, cells.levels[0].high)
        )
        enter, leave = way_through(o[:, row], d[:, row], low[row], high[row], corner_low, corner_high)
    pair, uv = _starts(cells, surface[row], origins[row], rays[row], cell, (enter, leave))
    row, cell = row[pair], cell[pair]
    found = _follow(cells, surface[row], origins[row], rays[row], cell, uv)
    found = replace(found, row=row[found.row])
    kept = (found.at_mm >= low[found.row]) & (found.at_mm <= high[found.row])
    return _once(found.select(kept), rays)


def way_through(
    o: FloatArray, d: FloatArray, low: FloatArray, high: FloatArray, box_low: FloatArray, box_high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return between which distances rays are in boxes.

    `o`, `d`, `box_low`, `box_high`, `low`, `high`: shape (3, m), a row per coordinate; (m,) for the last two. mm.
    """
    enter, leave = low, high
    for k in range(3):
        a, b = (box_low[k] - o[k]) / d[k], (box_high[k] - o[k]) / d[k]
        enter, leave = np.maximum(enter, np.fmin(a, b)), np.minimum(leave, np.fmax(a, b))
    return enter, leave


def _starts(
    cells: SurfaceCells,
    surface: IntArray,
    origins: FloatArray,
    rays: FloatArray,
    cell: IntArray,
    ends_mm: tuple[FloatArray, FloatArray],
) -> tuple[IntArray, FloatArray]:
    """Return which rays may meet their cells, each with a (u, v) from which it is followed."""
    middle = (cells.low[cell] + cells.high[cell]) / 2
    size = cells.high[cell] - cells.low[cell]
    p, du, dv = cells.surfaces.evaluate(surface, middle)
    step, _, rise = _newton_step(p, du, dv, origins, rays)
    shallow = np.abs(rise) < SHALLOW
    beyond = (np.abs(step) / size).max(axis=1) > 0.5 + TOO_FAR
    steep = np.flatnonzero(~shallow & ~beyond)
    low_rows = np.flatnonzero(shallow)
    starts = [middle[steep] + np.clip(step[steep], -size[steep], size[steep]), middle[low_rows]]
    for at in ends_mm:
        arm = origins[low_rows] + at[low_rows, None] * rays[low_rows] - p[low_rows]
        way = along_surface(arm, du[low_rows], dv[low_rows])
        starts.append(middle[low_rows] + np.clip(way, -size[low_rows] / 2, size[low_rows] / 2))
    which = np.concatenate([steep, low_rows, low_rows, low_rows])
    return which, np.concatenate(starts)


def _follow(
    cells: SurfaceCells, surface: IntArray, origins: FloatArray, rays: FloatArray, cell: IntArray, uv: FloatArray
) -> SurfaceHits:
    """Follow rays to their crossings within cells, by Newton's method; each row is a ray, a surface and a cell."""
    low, high = cells.low[cell], cells.high[cell]
    size = high - low
    at, normal, is_exact = np.full(len(cell), np.nan), np.zeros((len(cell), 3)), np.zeros(len(cell), dtype=bool)
    active = np.arange(len(cell))
    for _ in range(NEWTON_ROUNDS):
        p, du, dv = cells.surfaces.evaluate(surface[active], uv[active])
        step, along, rise = _newton_step(p, du, dv, origins[active], rays[active])
        arm = origins[active] + along[:, None] * rays[active] - p
        done = np.einsum("ki,ki->k", arm, arm) <= EXACT_MM**2
        at[active[done]], is_exact[active[done]] = along[done], True
        normal[active[done]] = np.cross(du[done], dv[done])
        left = np.flatnonzero(~done & (rise != 0))
        active = active[left]
        if len(active) == 0:
            break
        uv[active] = np.clip(uv[active] + step[left], low[active] - size[active], high[active] + size[active])
    inside = ((uv >= low - SLACK * size) & (uv <= high + SLACK * size)).all(axis=1)
    kept = np.flatnonzero(is_exact & inside)
    return SurfaceHits(kept, at[kept], np.clip(uv[kept], low[kept], high[kept]), normal[kept])


def _newton_step(
    p: FloatArray, du: FloatArray, dv: FloatArray, origins: FloatArray, rays: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the step in (u, v) to where rays meet tangent planes, how far along rays, and the sine of the angle."""
    n = np.cross(du, dv)
    length = np.linalg.norm(n, axis=1)
    rise = np.einsum("ki,ki->k", rays, n)
    r = origins - p
    along = -np.einsum("ki,ki->k", r, n) / np.where(rise == 0, 1.0, rise)
    step = along_surface(r + along[:, None] * rays, du, dv)
    return step, along, rise / np.where(length > 0, length, 1.0)


def along_surface(arm: FloatArray, du: FloatArray, dv: FloatArray) -> FloatArray:
    """Return the step in (u, v) that goes along an arm as far as the tangent plane lets it, shape (k, 2)."""
    a, b, c = (np.einsum("ki,ki->k", x, y) for x, y in ((du, du), (du, dv), (dv, dv)))
    f, g = np.einsum("ki,ki->k", du, arm), np.einsum("ki,ki->k", dv, arm)
    det = a * c - b * b
    det = np.where(det == 0, 1.0, det)
    return np.stack([(c * f - b * g) / det, (a * g - b * f) / det], axis=1)


def _once(found: SurfaceHits, rays: FloatArray) -> SurfaceHits:
    """Return the crossings, those that were found from several cells or starts once."""
    way = np.einsum("ki,ki->k", rays[found.row], found.normal) > 0
    order = np.lexsort((found.at_mm, way, found.row))
    row, at, way = found.row[order], found.at_mm[order], way[order]
    is_first = (
        (np.diff(row, prepend=-1) != 0) | (np.diff(way, prepend=False) != 0) | (np.diff(at, prepend=-1e9) > SAME_MM)
    )
    return found.select(order[is_first])
