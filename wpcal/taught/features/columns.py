"""Features as columns, as the searches find them; how they are named; and tools for such columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.taught.features.reference import FeatureKind, HoleForm, HoleStep, ReferenceFeature

NAMING_MM = 1e-3
"""Positions are compared after rounding to this, so that round-off does not renumber the features of a part."""
AXIS_ROUND = 1e-4  #: Directions of axes are compared after rounding to this (0.006 degrees).


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FeatureColumns:
    """Features of one kind before they have names: one row per feature, NaN or None where a column does not apply."""

    kind: FeatureKind
    p: FloatArray  #: shape (n, 3). In `part`, mm.
    solid: IntArray  #: shape (n,).
    direction: FloatArray | None = None  #: shape (n, 3).
    #: `diameter_mm`, `length_mm`, `depth_mm`, `area_mm2`: shape (n,).
    diameter_mm: FloatArray | None = None
    length_mm: FloatArray | None = None
    depth_mm: FloatArray | None = None
    area_mm2: FloatArray | None = None
    is_through: BoolArray | None = None  #: shape (n,).
    form: Sequence[HoleForm] = ()
    steps: Sequence[tuple[HoleStep, ...]] = ()
    faces: Sequence[IntArray] = ()

    def named(self, graph: BrepGraph) -> Iterator[ReferenceFeature]:
        """Number the rows by position and yield them as features."""
        p = _read_only(self.p)
        direction = None if self.direction is None else _read_only(self.direction)
        names = (*graph.solid_names, "")
        for number, row in enumerate(self.order().tolist(), 1):
            yield ReferenceFeature(
                f"{self.kind.value}{number}",
                self.kind,
                p[row],
                None if direction is None else direction[row],
                _value(self.diameter_mm, row),
                names[self.solid[row]],
                tuple(self.faces[row].tolist()) if self.faces else (),
                _value(self.length_mm, row),
                _value(self.depth_mm, row),
                _value(self.area_mm2, row),
                None if self.is_through is None else bool(self.is_through[row]),
                self.form[row] if self.form else None,
                self.steps[row] if self.steps else (),
            )

    def order(self) -> IntArray:
        """Return the rows by x, y, z, then solid, diameter and direction."""
        keys = [self.solid] if self.diameter_mm is None else [self.solid, np.round(self.diameter_mm, 6)]
        if self.direction is not None:
            keys.extend(np.round(self.direction, 3).T + 0.0)
        places = np.round(self.p / NAMING_MM) + 0.0
        return np.asarray(np.lexsort((*keys[::-1], *places.T[::-1])), dtype=np.int64)


def _read_only(values: FloatArray) -> FloatArray:
    values = np.array(values, dtype=np.float64) + 0.0  # -0 is 0
    values.setflags(write=False)
    return values


def _value(column: FloatArray | None, row: int) -> float | None:
    return None if column is None or np.isnan(column[row]) else float(column[row])


def positive_axes(directions: FloatArray) -> FloatArray:
    """Return unit vectors along lines, with one sense: the last component that is not zero (z, y, x) is positive.

    `directions`: shape (n, 3).
    Returns shape (n, 3).
    """
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    sign = np.ones(len(unit))
    for column in (0, 1, 2):  # y overrides x, and z both
        clear = np.abs(unit[:, column]) > AXIS_ROUND
        sign[clear] = np.sign(unit[clear, column])
    return np.asarray(unit * sign[:, None], dtype=np.float64)


def label_equal(*columns: FloatArray | IntArray | BoolArray) -> IntArray:
    """Number rows so that equal rows have equal numbers, shape (n,). 0 … k - 1.

    `*columns`: ndarray, shape (n,) or (n, m).
    """
    keys = np.column_stack(columns).astype(np.float64) + 0.0  # -0 is 0
    if len(keys) == 0:
        return np.zeros(0, dtype=np.int64)
    return np.asarray(np.unique(keys, axis=0, return_inverse=True)[1].ravel(), dtype=np.int64)


def first_rows(label: IntArray) -> IntArray:
    """Return the first row, shape (k,), of every label 0 … k - 1 in an array of shape (n,)."""
    return np.asarray(np.unique(label, return_index=True)[1], dtype=np.int64)


def sums(label: IntArray, values: FloatArray, count: int) -> FloatArray:
    """Return the sum of the values of every label, shape (count,) or (count, k).

    `label`: shape (n,). 0 … count - 1.
    `values`: shape (n,) or (n, k).
    """
    total = np.zeros((count, *values.shape[1:]))
    np.add.at(total, label, values)
    return total


def members_of(label: IntArray, items: IntArray) -> list[IntArray]:
    """Return the items of every label, length k. Sorted.

    `label`, `items`: shape (n,). Each label 0 … k - 1 occurs at least once.
    """
    if len(label) == 0:
        return []
    order = np.lexsort((items, label))
    return np.split(items[order], np.cumsum(np.bincount(label))[:-1])
