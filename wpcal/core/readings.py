"""What a robot told when a row of a taught table was read from it: the column `reading`, one JSON text per row.

The coordinates of the row are those of the reading until somebody types others over them; then the reading is not used.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError
from wpcal.core.rotations import rotation_from_zyx, zyx_angles
from wpcal.core.tables import Table
from wpcal.core.transform import RigidTransform

READING = "reading"  #: The column.
AS_READ_MM = 0.00051  #: Half of the last digit with which coordinates are put into the row.
Six = list[float]
"""x, y, z in mm, and angles about x, y, z in degrees, ``R = Rz Ry Rx``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptReading:
    """A position as the controller told it, with what makes it a position."""

    T_base_tool: Six
    tool: str  #: Its number or name; empty if the robot does not tell it.
    frame: str  #: The same of the user frame that was shown.
    T_flange_tool: Six | None  #: Values of the tool; None if the robot does not tell them.
    T_base_frame: Six | None  #: The same of the frame.
    joints_deg: list[float] | None  #: As shown on the pendant.
    configuration: str  #: In the words of the controller; empty if it does not tell.
    read_utc: str  #: When it was read, ISO 8601.
    still_s: float  #: For how long the arm had stood there.

    def to_text(self) -> str:
        """Return the cell."""
        return json.dumps(asdict(self), separators=(",", ":"))


def six_of(T: RigidTransform | None) -> Six | None:
    """Return the numbers of a transform."""
    if T is None:
        return None
    return [round(value, 5) + 0.0 for value in (*T.t_mm.tolist(), *np.degrees(zyx_angles(T.R)).tolist())]


def readings_of_table(table: Table) -> list[KeptReading | None]:
    """Return the reading of each row; None without one, or if its coordinates were typed over.

    Raises `FormatError` when a cell is not a reading.
    """
    found = list[KeptReading | None]()
    places = table.numbers(("x_mm", "y_mm", "z_mm")) if table.has(READING) else np.empty((0, 3))
    for line, cell, place in zip(table.lines, table.columns.get(READING, ()), places, strict=False):
        try:
            read = KeptReading(**json.loads(cell)) if cell else None
            is_own = read is not None and bool(np.abs(_place(read.T_base_tool) - place).max() <= AS_READ_MM)
        except (ValueError, TypeError):
            raise FormatError("is not a reading of a robot", path=table.path, line=line, column=READING) from None
        found.append(read if is_own else None)
    return found


def postures_of_readings(table: Table) -> FloatArray | None:
    """Return the axes of the tool at each row, shape (n, 3, 3), NaN where nothing was read; None without readings."""
    found = readings_of_table(table)
    if not any(found):
        return None
    return np.array(
        [
            np.full((3, 3), np.nan) if each is None else rotation_from_zyx(*np.radians(each.T_base_tool[3:]))
            for each in found
        ]
    )


def _place(values: Any) -> FloatArray:
    if len(values) != 6 or not np.isfinite(values).all():
        raise ValueError
    return np.array(values[:3], dtype=float)
