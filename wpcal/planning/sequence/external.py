"""Where the external axes may be while a seam is welded: the positioner at angles that bring the seam into position.

Mostly the axes stand still along a seam. All angles of a grid are tried at once, since only the directions of the seam
in `world` count. A rail is tried at some places. If no angle brings the whole seam into position, as on a ring, the
last axis of the positioner also turns evenly along the seam, by as much as the joint turns about it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.same_bits import arc_tangent, first_least, length, product
from wpcal.core.tangent import log_rotation
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.sequence.seam_task import SeamTask
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.robot.kinematics.inverse import TURN

GRID_RAD = math.radians(5.0)  #: Half of a step is 2.5 degrees: well within a position tolerance of 10 degrees.
RAIL_PLACES = 7
MOST_TURNING = 24  #: Ways to turn along a seam that are tried.
MOST = 160  #: External axes that are tried per seam, the best ones first.
LEAST_TURN_RAD = math.radians(30.0)
"""A joint that turns less about the axis of the positioner is welded with the axes at rest."""
TILT_STEP_RAD = math.radians(15.0)  #: Of the axes that stand still while the last one turns.
ROUND_RAD = math.radians(5.0)
"""Positions that differ by less are equally good: among them the shorter way of the axes decides."""


@dataclass(frozen=True, slots=True, eq=False)
class ExternalAxes:
    """C positions of the external axes, the most promising first."""

    #: shape (C, 2, k - 6). Rail (mm) and angles (rad) at the start of the seam and at its end; they change evenly along
    #: it.
    values: FloatArray
    off_rad: FloatArray  #: shape (C,). Largest distance of the seam from the asked weld position.

    def __len__(self) -> int:
        return len(self.off_rad)

    def first(self, most: int | None) -> ExternalAxes:
        """Return the most promising ones; None: all."""
        return ExternalAxes(self.values[:most], self.off_rad[:most])


def axes_of(cell: Cell, values: FloatArray) -> FloatArray:
    """Return all axes with the arm at home and external axes of shape (C, k - 6); shape (C, k), rad and mm."""
    arm = np.broadcast_to(cell.home[:JOINTS], (len(values), JOINTS))
    return np.concatenate([arm, values], axis=1)


def values_along(values: FloatArray, task: SeamTask, rows: IntArray) -> FloatArray:
    """Return external axes at points of a seam, shape (C, n, e).

    `values`: shape (C, 2, e). At its start and at its end.
    `rows`: shape (n,). Its points.
    """
    share = ((task.s_mm[rows] - task.s_mm[0]) / task.length_mm)[:, None]
    return np.asarray(values[:, :1] + share * (values[:, 1:] - values[:, :1]), dtype=np.float64)


def external_axes(cell: Cell, task: SeamTask, targets: SequenceTargets) -> ExternalAxes:
    """Return where the external axes may be while a seam is welded."""
    turning = _turning_grid(cell)
    rail = np.zeros((1, 0))
    if cell.rail is not None:
        rail = np.linspace(cell.rail.min_mm, cell.rail.max_mm, RAIL_PLACES)[:, None]
    whole = np.concatenate([np.repeat(rail[:1], len(turning), axis=0), turning], axis=1)
    R_world_part = cell.part_places(axes_of(cell, whole))[:, :3, :3]
    R_seam = task.R[task.rungs()]
    off = targets.off_position(product(R_world_part[:, None], R_seam)).max(axis=1)
    up = np.clip(product(R_world_part, R_seam[:, :, 2].mean(axis=0))[:, 2], -1.0, 1.0)
    upright = arc_tangent(np.sqrt((1.0 - up) * (1.0 + up)), up)
    moved = np.abs(turning - cell.home[cell.first_turning :]).max(axis=1, initial=0.0)
    beyond = np.maximum(off - targets.position_tol_rad, 0.0)
    keep = np.lexsort((moved, np.round(upright / ROUND_RAD), np.round(beyond / (ROUND_RAD / 5))))
    keep = keep[: max(1, MOST // len(rail))]
    values = np.concatenate([np.tile(rail, (len(keep), 1)), np.repeat(turning[keep], len(rail), axis=0)], axis=1)
    at_rest = ExternalAxes(np.repeat(values[:, None], 2, axis=1), np.repeat(off[keep], len(rail)))
    if off.min() <= targets.position_tol_rad:
        return at_rest
    moving = _turning_along(cell, task, targets, rail)
    better = moving.off_rad < off.min() - ROUND_RAD
    return ExternalAxes(
        np.concatenate([moving.values[better], at_rest.values]),
        np.concatenate([moving.off_rad[better], at_rest.off_rad]),
    )


def _turning_along(cell: Cell, task: SeamTask, targets: SequenceTargets, rail: FloatArray) -> ExternalAxes:
    """Return external axes whose last one turns evenly along a seam, the best ones first."""
    count = len(cell.axis_names) - JOINTS
    total = _turn_of_joint(cell, task)
    if total is None:
        return ExternalAxes(np.zeros((0, 2, count)), np.zeros(0))
    grid = _starts(cell, total)
    end = grid.copy()
    end[:, -1] += total
    turned = np.stack([grid, end], axis=1)
    values = np.concatenate([np.repeat(rail[:1, None], len(grid), axis=0).repeat(2, axis=1), turned], axis=2)
    rows = task.rungs()
    along = values_along(values, task, rows)
    R = cell.part_places(axes_of(cell, along.reshape(-1, count)))[:, :3, :3].reshape(*along.shape[:2], 3, 3)
    off = targets.off_position(product(R, task.R[rows])).max(axis=1, initial=0.0)
    moved = np.abs(grid - cell.home[cell.first_turning :]).max(axis=1, initial=0.0)
    keep = np.lexsort((moved, np.round(off / (ROUND_RAD / 5))))[: max(1, MOST_TURNING // len(rail))]
    places = np.tile(np.repeat(rail[:, None], 2, axis=1), (len(keep), 1, 1))
    values = np.concatenate([places, np.repeat(turned[keep], len(rail), axis=0)], axis=2)
    return ExternalAxes(values, np.repeat(off[keep], len(rail)))


def _turn_of_joint(cell: Cell, task: SeamTask) -> float | None:
    """Return how far the last axis of the positioner turns, so that the joint keeps facing the same way, rad.

    None if there is no positioner, the joint turns little about its axis, or faces along it.
    """
    if cell.carrier is None:
        return None
    here = cell.home[None, cell.first_turning :]
    there = here + np.eye(here.shape[1])[-1]  # 1 rad
    R = [cell.carrier.arm.forward(q)[0, :3, :3] for q in (here, there)]
    axis = log_rotation(product(R[0].T, R[1]))
    x = np.cross(np.eye(3)[int(first_least(np.abs(axis)))], axis)
    across = np.array([x, np.cross(axis, x)]) / length(x)
    across[1] /= length(axis)
    out = product(product(task.R[:, :, 2], cell.T_part.R.T), across.T)
    if (np.linalg.norm(out, axis=1) < np.sin(ROUND_RAD)).any():
        return None
    heading = np.unwrap(arc_tangent(out[:, 1], out[:, 0]))
    return float(heading[0] - heading[-1]) if np.ptp(heading) >= LEAST_TURN_RAD else None


def _starts(cell: Cell, total_rad: float) -> FloatArray:
    """Return angles at which turning may begin so that it ends within the limits, shape (g, axes), rad."""
    assert cell.carrier is not None
    low, high = cell.carrier.arm.limits[:, -1]
    grid = _turning_grid(cell, TILT_STEP_RAD)
    begin = np.unique(np.concatenate([grid[:, -1] + turn for turn in (-TURN, 0.0, TURN)]))
    end = begin + total_rad
    begin = begin[(np.minimum(begin, end) >= low) & (np.maximum(begin, end) <= high)]
    tilts = np.unique(grid[:, :-1], axis=0)
    return np.array([[*tilt, start] for tilt in tilts for start in begin]).reshape(-1, grid.shape[1])


def _turning_grid(cell: Cell, step_rad: float = GRID_RAD) -> FloatArray:
    """Return all angles of the positioner on the grid, shape (g, axes), rad."""
    if cell.carrier is None:
        return np.zeros((1, 0))
    home = cell.home[cell.first_turning :]
    columns = []
    for low, high, at in zip(*cell.carrier.arm.limits, home, strict=True):
        low, high = max(low, at - math.pi), min(high, at + math.pi)  # noqa: PLW2901  # a whole turn is enough
        first = math.ceil((low - at) / step_rad - 1e-9)
        last = math.floor((high - at) / step_rad + 1e-9)
        columns.append(at + step_rad * np.arange(first, last + 1))
    return np.stack(np.meshgrid(*columns, indexing="ij"), axis=-1).reshape(-1, len(columns))
