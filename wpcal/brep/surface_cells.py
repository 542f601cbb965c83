"""Free-form surfaces in cells that bend little, with a box around each cell: where a ray can meet the surface.

A cell is a rectangle of (u, v) inside one knot span. With positive weights it lies within the box of its Bézier poles,
so no crossing is outside of all boxes. Four neighbouring cells share a box one level higher, up to one box around the
whole surface.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import comb

import numpy as np

from wpcal.brep.boxes import Meets
from wpcal.brep.nurbs import NurbsSurface
from wpcal.brep.spans import SurfaceSet
from wpcal.core.arrays import FloatArray, IntArray, numbered_rows

TURN_RAD = 0.35
"""A cell is so small that its surface turns by at most this along u and along v: Newton's method then needs few steps
from its middle. Control polygons turn more than their surface, so most cells turn less."""
MOST_PARTS = 32  #: Most cells of one knot span along each parameter: six turns of a screw thread, or poles that zigzag.
SHORTEST_MM = 1e-6  #: Legs of a control polygon that are shorter have no direction.
ROUND_OFF_MM = 1e-6  #: Boxes grow by this: poles are computed from polynomials.


@dataclass(frozen=True, slots=True, eq=False)
class _Level:
    """Boxes of one level: for surface i, row by row from ``start[i]`` on, ``columns[i]`` in a row; corners (3, m)."""

    start: IntArray
    rows: IntArray
    columns: IntArray
    low: FloatArray
    high: FloatArray

    @classmethod
    def of(cls, grids: Sequence[tuple[FloatArray, FloatArray]]) -> _Level:
        rows, columns = (np.array([own.shape[axis] for own, _ in grids], dtype=np.int64) for axis in (0, 1))
        low, high = (np.concatenate([np.zeros((0, 3)), *(pair[k].reshape(-1, 3) for pair in grids)]) for k in (0, 1))
        start = np.cumsum(rows * columns) - rows * columns
        return cls(start, rows, columns, np.ascontiguousarray(low.T), np.ascontiguousarray(high.T))


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceCells:
    """The cells of many surfaces."""

    surfaces: SurfaceSet  #: The same surfaces.
    #: `low`, `high`: shape (c, 2). Where each cell begins and ends, in u and v.
    low: FloatArray
    high: FloatArray
    levels: tuple[_Level, ...]  #: Boxes, the cells first.

    @classmethod
    def of(cls, polynomials: SurfaceSet, breaks: Sequence[tuple[FloatArray, FloatArray]]) -> SurfaceCells:
        """Put boxes around the cells of surfaces with positive weights.

        `breaks`: Where the cells of each surface begin and end along u and along v, shapes (m,) and (n,)
        (`cell_breaks`).
        """
        number, low, high, shapes = _rectangles(breaks)
        corner_low, corner_high = np.zeros((len(number), 3)), np.zeros((len(number), 3))
        for rows, poles in _bezier_poles(polynomials, number, low, high):
            corner_low[rows] = poles.min(axis=(1, 2)) - ROUND_OFF_MM
            corner_high[rows] = poles.max(axis=(1, 2)) + ROUND_OFF_MM
        return cls(polynomials, low, high, _levels(shapes, corner_low, corner_high))

    def find_near(self, surface: IntArray, meets: Meets) -> tuple[IntArray, IntArray]:
        """Find all cells whose box is met.

        `surface`: shape (k,). The surface of each query.
        `meets`: Tells which queries (numbers) meet which boxes (corners of shape (3, m)).
        Returns `query, cell`: ndarray of int, shape (m,).
        """
        query = np.arange(len(surface))
        row, column = np.zeros((2, len(query)), dtype=np.int64)
        for number, level in reversed(list(enumerate(self.levels))):
            inside = np.flatnonzero((row < level.rows[surface[query]]) & (column < level.columns[surface[query]]))
            query, row, column = query[inside], row[inside], column[inside]
            box = level.start[surface[query]] + row * level.columns[surface[query]] + column
            met = np.flatnonzero(meets(query, np.take(level.low, box, axis=1), np.take(level.high, box, axis=1)))
            query, row, column, box = query[met], row[met], column[met], box[met]
            if number:
                query = np.repeat(query, 4)
                row = (2 * row[:, None] + np.array([0, 0, 1, 1])).ravel()
                column = (2 * column[:, None] + np.array([0, 1, 0, 1])).ravel()
        return query, box


def cell_breaks(surfaces: Sequence[NurbsSurface], polynomials: SurfaceSet) -> list[tuple[FloatArray, FloatArray]]:
    """Divide the used parts of surfaces (`NurbsSurface.bounds`) into cells that bend little.

    Returns list of (ndarray, ndarray). Where cells begin and end along u and along v; knots are among them.
    """
    spans = [_breaks(surface) for surface in surfaces]
    number, low, high, shapes = _rectangles(spans)
    parts = np.ones((len(number), 2), dtype=np.int64)
    for rows, poles in _bezier_poles(polynomials, number, low, high):
        parts[rows] = np.clip(np.ceil(_turns(poles) / TURN_RAD), 1, MOST_PARTS)
    found, first = [], 0
    for (u, v), (rows_u, columns_v) in zip(spans, shapes, strict=True):
        own = parts[first : first + rows_u * columns_v].reshape(rows_u, columns_v, 2)
        found.append((divided(u, own[..., 0].max(axis=1)), divided(v, own[..., 1].max(axis=0))))
        first += rows_u * columns_v
    return found


def _breaks(surface: NurbsSurface) -> tuple[FloatArray, FloatArray]:
    """Return the knots within the used part of a surface, with its ends, along u and along v."""
    u0, u1, v0, v1 = surface.bounds
    return np.unique(np.clip(surface.knots_u, u0, u1)), np.unique(np.clip(surface.knots_v, v0, v1))


def divided(breaks: FloatArray, parts: IntArray) -> FloatArray:
    """Divide each step of an ascending sequence of shape (n + 1,) into this many equal parts, shape (n,)."""
    step, number = numbered_rows(parts)
    inner = breaks[step] + np.diff(breaks)[step] * number / parts[step]
    return np.append(inner, breaks[-1])


def _rectangles(
    breaks: Sequence[tuple[FloatArray, FloatArray]],
) -> tuple[IntArray, FloatArray, FloatArray, list[tuple[int, int]]]:
    """Return the surface, the least and the greatest (u, v) of all rectangles between breaks, and how many there are.

    They are sorted by surface, then row (u), then column (v).
    """
    shapes = [(len(u) - 1, len(v) - 1) for u, v in breaks]
    low = [np.stack(np.meshgrid(u[:-1], v[:-1], indexing="ij"), axis=-1).reshape(-1, 2) for u, v in breaks]
    high = [np.stack(np.meshgrid(u[1:], v[1:], indexing="ij"), axis=-1).reshape(-1, 2) for u, v in breaks]
    surface = np.repeat(np.arange(len(breaks)), [rows * columns for rows, columns in shapes])
    none = np.zeros((0, 2))
    return surface, np.concatenate([none, *low]), np.concatenate([none, *high]), shapes


def _levels(shapes: Sequence[tuple[int, int]], low: FloatArray, high: FloatArray) -> tuple[_Level, ...]:
    """Join boxes by fours until there is one for each surface; corners of shape (c, 3)."""
    grids, first = [], 0
    for rows, columns in shapes:
        own = slice(first, first + rows * columns)
        grids.append((low[own].reshape(rows, columns, 3), high[own].reshape(rows, columns, 3)))
        first += rows * columns
    levels = [_Level.of(grids)]
    while any(own.shape[:2] != (1, 1) for own, _ in grids):
        grids = [(_by_fours(np.minimum, own), _by_fours(np.maximum, other)) for own, other in grids]
        levels.append(_Level.of(grids))
    return tuple(levels)


def _by_fours(which: np.ufunc, corners: FloatArray) -> FloatArray:
    for axis in (0, 1):
        corners = which.reduceat(corners, np.arange(0, corners.shape[axis], 2), axis=axis)
    return corners


def _turns(poles: FloatArray) -> FloatArray:
    """Return how far the legs of control nets (k, m, n, 3) turn along u and along v, rad, shape (k, 2)."""
    legs = [np.diff(poles, axis=axis) for axis in (1, 2)]
    turns = [[_turn(own, axis) for own in legs] for axis in (1, 2)]
    return np.stack([np.maximum(*both) for both in turns], axis=1)


def _turn(legs: FloatArray, axis: int) -> FloatArray:
    """Return by how much the directions of legs (k, m, n, 3) turn along an axis, the most of all rows, rad."""
    length = np.linalg.norm(legs, axis=-1, keepdims=True)
    unit = np.where(length > SHORTEST_MM, legs / np.where(length > 0, length, 1.0), 0.0)
    before, after = (np.delete(unit, row, axis=axis) for row in (-1, 0))
    cosine = np.einsum("kmni,kmni->kmn", before, after)
    turn = np.where((before.any(axis=-1)) & (after.any(axis=-1)), np.arccos(np.clip(cosine, -1.0, 1.0)), 0.0)
    return np.asarray(turn.sum(axis=axis).max(axis=1, initial=0.0), dtype=np.float64)


def _bezier_poles(
    polynomials: SurfaceSet, surface: IntArray, low: FloatArray, high: FloatArray
) -> Iterator[tuple[IntArray, FloatArray]]:
    """Yield rows of rectangles inside knot spans and their Bézier poles (k, degree u + 1, degree v + 1, 3), mm."""
    for rows, coefficients in polynomials.moved_coefficients(surface, low, high):
        of_u, of_v = (_to_bernstein(count - 1) for count in coefficients.shape[1:3])
        h = np.einsum("ia,kabc->kibc", of_u, coefficients)
        h = np.einsum("jb,kibc->kijc", of_v, h)
        yield rows, h[..., :3] / h[..., 3:]


def _to_bernstein(degree: int) -> FloatArray:
    """Return the matrix from the coefficients of the powers of x to the Bernstein poles on [0, 1]."""
    return np.array([[comb(i, a) / comb(degree, a) for a in range(degree + 1)] for i in range(degree + 1)])
