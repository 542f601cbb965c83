"""Arrays from outside: checked once, then read-only float64. Records whose arrays are columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from itertools import chain
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wpcal.core.errors import InputError

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]


class Columns:
    """A dataclass with n rows: its arrays, tuples and `Columns` are columns. All other fields belong to every row."""

    __slots__ = ()

    def select(self, rows: IntArray | BoolArray | slice) -> Self:
        """Return the rows at `rows`: integers, a slice, or a mask of shape (n,)."""
        found = {name: _picked(column, rows) for name, column in self._columns().items()}
        return replace(self, **found)  # type: ignore[type-var]

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return all rows of `parts`, of which there is at least one, in one."""
        names = parts[0]._columns().keys()
        if any(part._columns().keys() != names for part in parts):
            raise ValueError("some parts have columns that others lack")
        found = {name: _together([getattr(part, name) for part in parts]) for name in names}
        return replace(parts[0], **found)  # type: ignore[type-var]

    def _columns(self) -> dict[str, Any]:
        values = {one.name: getattr(self, one.name) for one in fields(self)}  # type: ignore[arg-type]
        return {name: value for name, value in values.items() if isinstance(value, np.ndarray | tuple | Columns)}


def _picked(column: Any, rows: IntArray | BoolArray | slice) -> Any:
    if isinstance(column, tuple):
        return tuple(column[row] for row in np.arange(len(column))[rows].tolist())
    return column.select(rows) if isinstance(column, Columns) else column[rows]


def _together(columns: list[Any]) -> Any:
    if isinstance(columns[0], tuple):
        return tuple(chain(*columns))
    return columns[0].joined(columns) if isinstance(columns[0], Columns) else np.concatenate(columns)


def blocks(count: int, most: int) -> list[slice]:
    """Return slices of at most `most` of `count` rows, in order; one also for no row."""
    return [slice(first, first + most) for first in range(0, max(count, 1), most)]


def numbered_rows(counts: IntArray) -> tuple[IntArray, IntArray]:
    """Return the row of each item, and its number in the row, from 0 on; `counts`, shape (n,): items in each row."""
    row = np.repeat(np.arange(len(counts)), counts)
    return row, np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)


def frozen(values: ArrayLike) -> FloatArray:
    """Return a read-only float64 copy. Returns ndarray, same shape."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


LARGEST_MM = 1e9  #: Largest coordinate: beyond a thousand kilometres, float64 numbers are more than 1e-7 mm apart.


def as_points(values: ArrayLike, *, name: str) -> FloatArray:
    """Check and freeze an array of points, shape (n, 3). A read-only copy.

    `values`: shape (n, 3). Coordinates in one frame, mm.
    Raises `InputError` when the shape is not (n, 3), or a value is NaN, infinite or larger than `LARGEST_MM`.
    """
    try:
        points = frozen(values)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: expected numbers of shape (n, 3): {error}") from None
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"{name}: expected shape (n, 3), got {points.shape}")
    if not np.isfinite(points).all():
        row = int(np.argmin(np.isfinite(points).all(axis=1)))
        raise InputError(f"{name}: row {row + 1} holds a value that is not finite: {points[row].tolist()}")
    if np.abs(points).max(initial=0.0) > LARGEST_MM:
        row = int(np.argmax(np.abs(points).max(axis=1)))
        raise InputError(f"{name}: row {row + 1} is farther away than {LARGEST_MM:g} mm: {points[row].tolist()}")
    return points
