"""How robot 2 turns the part while the torch makes one move: a few moves near its planned path.

In coordinated motion the torch keeps to its line or arc in the part, whatever robot 2 does. The moves of robot 2 decide
where the weld is in space: they have to keep the weld position, and to stay near the path that was checked.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.same_bits import product
from wpcal.core.tangent import exp_rotation, log_rotation
from wpcal.planning.cell.cell import Cell, part_in_world
from wpcal.robot.kinematics.inverse import nearest_joints
from wpcal.robot.moves.interpolation import turns_between

MOST_POINTS = 15
"""Planned points at which a move is compared: the largest difference is measured everywhere afterwards."""
CHUNK = 200_000  #: Compared points in one array: some 60 MB.


class HolderMove(Enum):
    """How robot 2 moves from mark to mark."""

    JOINTS = "joints"  #: All joints evenly.
    LINE = "line"  #: The origin of the part on a straight line, and the part about one axis.


@dataclass(frozen=True, slots=True)
class HolderTolerance:
    """How far robot 2 may be from its planned path."""

    rad: float = math.radians(1.0)  #: Attitude of the part. 1 degree of slope does not change a weld.
    #: Place of the weld point. The moves are checked for collisions again; more would be another plan.
    mm: float = 10.0


@dataclass(frozen=True, slots=True, eq=False)
class HolderPath:
    """The planned path of robot 2."""

    cell: Cell
    s_mm: FloatArray  #: shape (n,). Length along the seam at the planned points, mm.
    joints: FloatArray  #: shape (n, 6). Shown angles of robot 2 there, rad, unwrapped.
    p_part: FloatArray  #: shape (n, 3). The weld points in `part`, mm.
    kind: HolderMove = HolderMove.JOINTS
    tolerance: HolderTolerance = HolderTolerance()

    def joints_at(self, s_mm: FloatArray) -> FloatArray:
        """Return the planned angles at lengths of shape (m,); shape (m, 6), rad."""
        return np.stack([np.interp(s_mm, self.s_mm, column) for column in self.joints.T], axis=1)

    def joints_between(self, s0: float, s1: float, share: FloatArray) -> FloatArray:
        """Return the angles in the move from s0 to s1 at shares of shape (m,); shape (m, 6), rad.

        Raises `GeometryError` when robot 2 cannot make the move.
        """
        ends = self.joints_at(np.array([s0, s1]))
        even = np.asarray(ends[0] + share[:, None] * (ends[1] - ends[0]), dtype=np.float64)
        if self.kind is HolderMove.JOINTS:
            return even
        start, end = np.split(part_in_world(self.cell, ends), 2)
        T = _on_line(start, end, share)
        flange = product(product(self.cell.T_world_base2.inverse().matrix, T), self.cell.T_part.inverse().matrix)
        return nearest_joints(self.cell.arm2, flange, even)

    def is_near(self, s0: FloatArray, s1: FloatArray) -> BoolArray:
        """Tell for moves between lengths whether robot 2 stays near its planned path.

        `s0`, `s1`: shape (m,). Where the moves begin and end, mm.
        """
        worst = np.zeros(len(s0))
        first, last = np.searchsorted(self.s_mm, s0, side="right"), np.searchsorted(self.s_mm, s1, side="left")
        inner = np.maximum(last - first, 0)
        taken = np.minimum(inner, MOST_POINTS)
        for part in np.array_split(np.arange(len(s0)), max(1, math.ceil(taken.sum() / CHUNK))):
            own = np.repeat(part, taken[part])
            number = np.arange(len(own)) - np.repeat(np.cumsum(taken[part]) - taken[part], taken[part])
            at = first[own] + ((number + 1) * (inner[own] + 1)) // (taken[own] + 1) - 1
            np.maximum.at(worst, own, self._shares(s0[own], s1[own], at))
        return np.asarray(worst <= 1.0, dtype=np.bool_)

    def _shares(self, s0: FloatArray, s1: FloatArray, at: IntArray) -> FloatArray:
        """Return how far moves are from planned points, in shares of the tolerance; to first order for joints."""
        share = (self.s_mm[at] - s0) / (s1 - s0)
        q0, q1 = self.joints_at(s0), self.joints_at(s1)
        if self.kind is HolderMove.JOINTS:
            J = self.cell.arm2.jacobian(self.joints, point=self.cell.T_part.apply(self.p_part).T)
            moved = np.einsum("kij,kj->ki", J[at], q0 + share[:, None] * (q1 - q0) - self.joints[at])
            turned, off = moved[:, :3], moved[:, 3:]
        else:
            T = _on_line(part_in_world(self.cell, q0), part_in_world(self.cell, q1), share)
            turned, off = differences(T, part_in_world(self.cell, self.joints)[at], self.p_part[at])
        return np.asarray(
            np.maximum(
                np.linalg.norm(turned, axis=1) / self.tolerance.rad, np.linalg.norm(off, axis=1) / self.tolerance.mm
            )
        )


def differences(T: FloatArray, T_planned: FloatArray, p_part: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how poses of the part differ from planned ones.

    `T`, `T_planned`: shape (m, 4, 4). In one frame, mm.
    `p_part`: shape (m, 3). A point of the part for each, mm.
    Returns `turned, off`: ndarray, shape (m, 3). Rotation vectors, rad, and what the points are off, mm.
    """
    turned = log_rotation(product(T[:, :3, :3], np.swapaxes(T_planned[:, :3, :3], 1, 2)))
    gap = T - T_planned
    return turned, np.einsum("nij,nj->ni", gap[:, :3, :3], p_part) + gap[:, :3, 3]


def _on_line(T0: FloatArray, T1: FloatArray, share: FloatArray) -> FloatArray:
    """Return poses on the way from T0 to T1, both of shape (m, 4, 4) or (1, 4, 4): a line, and one axis."""
    T = np.zeros((len(share), 4, 4))
    turn = turns_between(T0[:, :3, :3], T1[:, :3, :3])
    T[:, :3, :3] = product(exp_rotation(share[:, None] * turn), T0[:, :3, :3])
    T[:, :3, 3] = T0[:, :3, 3] + share[:, None] * (T1[:, :3, 3] - T0[:, :3, 3])
    T[:, 3, 3] = 1.0
    return T
