"""Orientations in a table: a unit quaternion, or angles about x, y and z."""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError
from wpcal.core.rotations import rotation_from_quaternion, rotation_from_zyx
from wpcal.core.tables import Table

QUATERNION_COLUMNS = ("qx", "qy", "qz", "qw")
ANGLE_COLUMNS = ("rx_deg", "ry_deg", "rz_deg")  #: Angles about the fixed axes x, y, z in this order: ``R = Rz Ry Rx``.

UNIT_LENGTH_ATOL = 1e-3
"""A quaternion printed with four digits is this near to length one; further off it is something else."""


def orientations_of_table(table: Table, *, is_optional: bool = False) -> FloatArray | None:
    """Return the orientations of a table's rows, shape (n, 3, 3); None if it has no such columns.

    `table`: With the columns ``qx, qy, qz, qw`` or ``rx_deg, ry_deg, rz_deg``.
    Raises `FormatError` when both forms are there, columns are missing, a cell is not a finite number, or a quaternion
    does not have length one.
    """
    quaternions, angles = (
        table.has(columns[0]) or table.has(columns[-1]) for columns in (QUATERNION_COLUMNS, ANGLE_COLUMNS)
    )
    if quaternions and angles:
        raise FormatError("orientations are given twice, as qx … qw and as rx_deg …; keep one", path=table.path, line=1)
    if not (quaternions or angles):
        return None
    read = table.numbers_where_given if is_optional else table.numbers
    values = read(QUATERNION_COLUMNS if quaternions else ANGLE_COLUMNS)
    if angles:
        return rotation_from_zyx(*np.deg2rad(values).T)
    _require_unit(values, table)
    return rotation_from_quaternion(values)


def _require_unit(quaternions: FloatArray, table: Table) -> None:
    lengths = np.linalg.norm(quaternions, axis=1)
    off = np.abs(lengths - 1.0) > UNIT_LENGTH_ATOL
    if off.any():
        row = int(np.argmax(off))
        what = f"a unit quaternion has length 1, this one {lengths[row]:.4g}"
        raise FormatError(what, path=table.path, line=table.lines[row], column="qx")
