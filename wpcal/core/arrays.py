"""Arrays from outside: checked once, then read-only float64."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wpcal.core.errors import InputError

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]


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
