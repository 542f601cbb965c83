"""Where the external axes may be while a seam is welded: the positioner at angles that bring the seam into position.

The axes do not move along a seam. All angles of a grid are tried at once, since only the directions of the seam in
`world` count. A rail is tried at some places.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.planning.cell.one_robot import OneRobotCell
from wpcal.planning.cell.robot_cell import JOINTS
from wpcal.planning.sequence.seam_task import SeamTask
from wpcal.planning.sequence.targets import SequenceTargets

GRID_RAD = math.radians(5.0)
"""Half of a step is 2.5 degrees: well within a position tolerance of 10 degrees."""
RAIL_PLACES = 7
MOST = 160
"""External axes that are tried per seam, the best ones first."""
ROUND_RAD = math.radians(5.0)
"""Positions that differ by less are equally good: among them the shorter way of the axes decides."""


@dataclass(frozen=True, slots=True, eq=False)
class ExternalAxes:
    """C positions of the external axes, the most promising first.

    Parameters
    ----------
    values : ndarray, shape (C, k - 6)
        Rail (mm) and angles (rad).
    off_rad : ndarray, shape (C,)
        Largest distance of the seam from the asked weld position.
    """

    values: FloatArray
    off_rad: FloatArray

    def __len__(self) -> int:
        return len(self.off_rad)


def axes_of(cell: OneRobotCell, values: FloatArray) -> FloatArray:
    """Return all axes with the arm at home and external axes of shape (C, k - 6); shape (C, k), rad and mm."""
    arm = np.broadcast_to(cell.home[:JOINTS], (len(values), JOINTS))
    return np.concatenate([arm, values], axis=1)


def external_axes(cell: OneRobotCell, task: SeamTask, targets: SequenceTargets) -> ExternalAxes:
    """Return where the external axes may be while a seam is welded.

    Parameters
    ----------
    cell : OneRobotCell
    task : SeamTask
    targets : SequenceTargets

    Returns
    -------
    ExternalAxes
        At most `MOST`; those in position first, then by how far they are off.
    """
    turning = _turning_grid(cell)
    rail = np.zeros((1, 0))
    if cell.rail is not None:
        rail = np.linspace(cell.rail.min_mm, cell.rail.max_mm, RAIL_PLACES)[:, None]
    whole = np.concatenate([np.repeat(rail[:1], len(turning), axis=0), turning], axis=1)
    R_world_part = cell.part_places(axes_of(cell, whole))[:, :3, :3]
    R_seam = task.R[task.rungs()]
    off = targets.off_position(R_world_part[:, None] @ R_seam).max(axis=1)
    upright = np.arccos(np.clip((R_world_part @ R_seam[:, :, 2].mean(axis=0))[:, 2], -1.0, 1.0))
    moved = np.abs(turning - cell.home[cell.first_turning :]).max(axis=1, initial=0.0)
    beyond = np.maximum(off - targets.position_tol_rad, 0.0)
    keep = np.lexsort((moved, np.round(upright / ROUND_RAD), np.round(beyond / (ROUND_RAD / 5))))
    keep = keep[: max(1, MOST // len(rail))]
    values = np.concatenate([np.tile(rail, (len(keep), 1)), np.repeat(turning[keep], len(rail), axis=0)], axis=1)
    return ExternalAxes(values, np.repeat(off[keep], len(rail)))


def _turning_grid(cell: OneRobotCell) -> FloatArray:
    """Return all angles of the positioner on the grid, shape (g, axes), rad."""
    if cell.positioner is None:
        return np.zeros((1, 0))
    home = cell.home[cell.first_turning :]
    columns = []
    for low, high, at in zip(*cell.positioner.arm.limits, home, strict=True):
        low, high = max(low, at - math.pi), min(high, at + math.pi)  # noqa: PLW2901  # a whole turn is enough
        first = math.ceil((low - at) / GRID_RAD - 1e-9)
        last = math.floor((high - at) / GRID_RAD + 1e-9)
        columns.append(at + GRID_RAD * np.arange(first, last + 1))
    return np.stack(np.meshgrid(*columns, indexing="ij"), axis=-1).reshape(-1, len(columns))
