"""What is planned: a seam, a cell and wishes; and how far paths are from being allowed, one number a constraint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.planning.cell.clearance import capsule_clearance
from wpcal.planning.cell.closed_chain import COORDINATES, PLACE, ROTATION, SLOPE, TRAVEL, WORK, SeamPath
from wpcal.planning.cell.robot_cell import JOINTS, CellState, RobotCell
from wpcal.planning.cell.singularity import LEAST_REGULARITY, regularity
from wpcal.planning.cell.workplace import weld_zone
from wpcal.planning.plan.schedule import SPEED_MM_S, joint_speeds
from wpcal.planning.search.objectives import (
    ATTITUDE,
    Wishes,
    attitude_box,
    joint_motion,
    position_deviation,
    torch_deviation,
)

ALLOWED_EXCESS = 1e-9
"""Round-off of an angle that stands at the end of its range."""


@dataclass(frozen=True, slots=True, eq=False)
class PlanningProblem:
    """A seam to be welded in a cell.

    Parameters
    ----------
    cell : RobotCell
    path : SeamPath
        n points in `part`.
    wishes : Wishes
    speed_mm_s : float
        Of the torch along the seam: no joint may need more than its largest speed.
    """

    cell: RobotCell
    path: SeamPath
    wishes: Wishes
    speed_mm_s: float = SPEED_MM_S

    @property
    def joint_limits(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper limits of all twelve joints, shape (12,) each, rad."""
        (low1, high1), (low2, high2) = self.cell.arm1.limits, self.cell.arm2.limits
        return np.concatenate([low1, low2]), np.concatenate([high1, high2])

    @property
    def joint_speeds(self) -> FloatArray:
        """Largest speeds of all twelve joints, shape (12,), rad/s; infinite where the arm's file states none."""
        return np.concatenate([joint_speeds(self.cell.arm1), joint_speeds(self.cell.arm2)])

    @property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """Least and largest coordinates, shape (9,) each: the weld zone, and the ranges of the wishes."""
        low, high = np.full(COORDINATES, -np.inf), np.full(COORDINATES, np.inf)
        low[PLACE], high[PLACE] = weld_zone(self.cell)
        low[ATTITUDE], high[ATTITUDE] = attitude_box(self.wishes)
        return low, high

    @property
    def weights(self) -> FloatArray:
        """K_j of all twelve joints (Hou 2018, eq. 4)."""
        return np.concatenate([self.cell.weights1, self.cell.weights2])

    def objectives(self, coordinates: FloatArray, joints: FloatArray) -> FloatArray:
        """Return the three objectives of paths, shape (..., 3), in the order of `OBJECTIVES`."""
        values = (
            position_deviation(coordinates, self.wishes),
            torch_deviation(coordinates, self.wishes),
            joint_motion(self.cell, self.path.s_mm, joints),
        )
        return np.stack(values, axis=-1)

    def margins(self, joints: FloatArray) -> FloatArray:
        """Return the least capsule clearance beyond the safety distances at N states (N, 12); shape (N,), mm."""
        return capsule_clearance(self.cell, CellState(joints[:, :JOINTS], joints[:, JOINTS:])).margin_mm

    def regularity(self, joints: FloatArray) -> FloatArray:
        """Return how far both arms are from singular poses at N states (N, 12); shape (N, 6)."""
        one, _ = regularity(self.cell.arm1, joints[:, :JOINTS])
        two, _ = regularity(self.cell.arm2, joints[:, JOINTS:])
        return np.concatenate([one, two], axis=1)

    def is_allowed(self, coordinates: FloatArray, joints: FloatArray) -> bool:
        """Tell whether one path keeps all limits at its points; arguments as in `excesses`."""
        return max(self.excesses(coordinates, joints).values()) <= ALLOWED_EXCESS

    def excesses(self, coordinates: FloatArray, joints: FloatArray) -> dict[str, float]:
        """Return how far one path is beyond each kind of limit, by name; all zero for an allowed path.

        Parameters
        ----------
        coordinates : ndarray, shape (n, 9)
        joints : ndarray, shape (n, 12)
            Unwrapped, rad; NaN makes ``reach`` one.

        Returns
        -------
        dict
            ``reach`` (share of points out of reach), ``joint limits`` (rad), ``singular
            poses`` (of `regularity`), ``joint speeds`` (parts of the largest),
            ``weld position`` and ``torch angles`` (rad), ``weld zone`` (mm), ``clearance`` (mm).
        """
        missing = ~np.isfinite(joints).all(axis=-1)
        if missing.any():
            return {"reach": float(missing.mean())}
        low, high = self.joint_limits
        least, largest = self.box
        outside = np.maximum(coordinates - largest, least - coordinates).max(axis=0)
        rates = np.abs(np.diff(joints, axis=0)) / np.diff(self.path.s_mm)[:, None] * self.speed_mm_s
        found = {
            "reach": 0.0,
            "joint limits": np.maximum(joints - high, low - joints).max(),
            "singular poses": LEAST_REGULARITY - self.regularity(joints).min(),
            "joint speeds": (rates / self.joint_speeds).max() - 1.0,
            "weld position": outside[[SLOPE, ROTATION]].max(),
            "torch angles": outside[[WORK, TRAVEL]].max(),
            "weld zone": outside[PLACE].max(),
            "clearance": -self.margins(joints).min(),
        }
        return {name: max(float(value), 0.0) for name, value in found.items()}
