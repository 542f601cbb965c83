"""What must be right before planning starts: the part above the floor, and home free of collision."""

from __future__ import annotations

import math

import numpy as np

from wpcal.core.errors import InputError
from wpcal.core.same_bits import product
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.one_robot_clearance import FLOOR, PART, OneRobotClearance
from wpcal.planning.cell.shape import JOINTS

ON_FLOOR_MM = 1.0
"""A part that lies on the floor may be so far in it: corners of triangles, and touched points, are not exact."""
STEP_RAD = math.radians(15.0)  #: Of the axes in which another home is looked for.


def require_sound_start(cell: Cell, clearance: OneRobotClearance) -> None:
    """Refuse a cell that no plan can start from.

    Raises `InputError` when the part is through the floor, or home is in collision: with a change that was tried.
    """
    _require_above_floor(cell, clearance)
    found = clearance.margins(cell.home[None])
    if found.is_clear[0]:
        return
    one, two = clearance.names(int(found.pair[0]))
    what = f"home is in collision: {one} and {two} miss their safety distance by {-found.margin_mm[0]:.0f} mm"
    raise InputError(f"{what}; {_other_home(cell, clearance, (one, two))}")


def _require_above_floor(cell: Cell, clearance: OneRobotClearance) -> None:
    if clearance.part is None or cell.carrier is not None:
        return
    corners = clearance.part.corners.reshape(-1, 3)
    T = cell.part_places(cell.home[None])[0]
    lowest = float((product(corners, T[2, :3]) + T[2, 3]).min())
    if lowest < cell.floor_z_mm - ON_FLOOR_MM:
        raise InputError(
            f"the part is through the floor, by {cell.floor_z_mm - lowest:.0f} mm: its lowest place is at z = "
            f"{lowest:.0f} mm of world, the floor at {cell.floor_z_mm:g} mm; correct T_world_part of the cell, or "
            "T_world_base of torch_robot if the robot found the part"
        )


def _other_home(cell: Cell, clearance: OneRobotClearance, pair: tuple[str, str]) -> str:
    """Return what to do: the nearest home that is free, with other axes of the positioner or another axis 1."""
    columns = list(range(cell.first_turning, len(cell.axis_names)))
    if not columns or set(pair) != {PART, FLOOR}:
        columns = [0, *columns]
    low, high = cell.limits
    grids = [np.arange(-180.0, 180.0, 15.0) * math.pi / 180.0 + cell.home[column] for column in columns]
    turned = np.stack(np.meshgrid(*grids, indexing="ij"), axis=-1).reshape(-1, len(columns))
    order = np.argsort(np.abs(turned - cell.home[columns]).max(axis=1), kind="stable")
    q = np.repeat(cell.home[None], len(order), axis=0)
    q[:, columns] = turned[order]
    q = q[((q >= low) & (q <= high)).all(axis=1)]
    clear = clearance.margins(q).is_clear if len(q) else np.zeros(0, dtype=bool)
    if clear.any():
        shown = np.round(np.degrees(q[int(np.argmax(clear))]), 1) + 0.0
        arm, axes = (
            ", ".join(f"{value:g}" for value in part) for part in (shown[:JOINTS], shown[cell.first_turning :])
        )
        with_positioner = f", and home_deg [{axes}] in positioner" if cell.carrier is not None else ""
        return f"tried, and home is free with home_deg [{arm}] in torch_robot{with_positioner}"
    if set(pair) == {PART, FLOOR}:
        return "at every angle of the positioner: raise the positioner, or correct T_flange_part"
    return "write another home_deg in torch_robot of the cell"
