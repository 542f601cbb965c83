r"""The tool centre point in the flange frame, from touches of one fixed point in several postures.

The tip is at the same place in every posture i: :math:`R_i t + p_i = c`, with the flange poses of the arm, the tool
centre point t in the flange frame and the point c in the base. Six unknowns, three equations per posture: linear least
squares. In an identified arm this also absorbs what no measurement of the arm could show, the last link behind an
unknown tool.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import stdtrit

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError
from wpcal.robot.kinematics.arm import Arm

TOOL_SCHEMA = "wpcal/tool/1"
LEAST_POSTURES = 4  #: Three postures solve for the point and leave no residual worth the name; the fourth shows a slip.
LEAST_SPREAD = 0.1
"""Least singular value of the rotations per posture: below it (about 6 degrees) the postures turn about one axis, and
the tool centre point may lie anywhere along that axis."""

MOST_RMS_MM = 10.0  #: Of touches of one point. A nominal arm is off by a few millimetres, different points by more.


@dataclass(frozen=True, slots=True, eq=False)
class ToolPoint:
    """A tool centre point with its error."""

    t_flange: FloatArray  #: shape (3,). The tip in the flange frame, mm.
    p_base: FloatArray  #: shape (3,). The touched point in the base, mm.
    covariance: FloatArray  #: shape (3, 3). Of `t_flange`, mm².
    residuals: FloatArray  #: shape (n, 3). Of the touches, in the base, mm.
    degrees_of_freedom: int

    @property
    def error_95_mm(self) -> float:
        """Length that the error of the tip stays below in 95 of 100 repetitions, along its least certain direction."""
        sigma = float(np.sqrt(np.linalg.eigvalsh(self.covariance)[-1]))
        return float(stdtrit(self.degrees_of_freedom, 0.975)) * sigma

    @property
    def rms_mm(self) -> float:
        """Root mean square distance of the touches from their common point, mm."""
        return float(np.sqrt(np.mean(np.sum(self.residuals**2, axis=1))))

    @property
    def refusal(self) -> str:
        """Why this is not a tool centre point; empty where it is one."""
        off = f"the touches are {self.rms_mm:.1f} mm (RMS) from one point, expected at most {MOST_RMS_MM:g} mm"
        how = "touch the same point every time, with the arm that --robot names"
        return "" if self.rms_mm <= MOST_RMS_MM else f"no tool centre point: {off}; {how}"

    def to_record(self, arm: Arm, names: Sequence[str]) -> dict[str, Any]:
        """Return the record ``wpcal/tool/1``, mm. `names` are those of the n touches."""
        return {
            "schema": TOOL_SCHEMA,
            "robot": arm.name,
            "robot_space": arm.space.value,
            "names": list(names),
            "xyz_mm": self.t_flange.tolist(),
            "error_95_mm": self.error_95_mm,
            "rms_mm": self.rms_mm,
            "distances_mm": np.linalg.norm(self.residuals, axis=1).tolist(),
            "p_base_mm": self.p_base.tolist(),
        }


def find_tool_point(arm: Arm, joints: ArrayLike) -> ToolPoint:
    """Find the tool centre point from touches of one fixed point.

    `joints`: shape (n, k). Shown joint angles at each touch, rad.
    Raises `GeometryError` when there are fewer than four postures, or they all turn about one axis.
    """
    T = arm.forward(joints)
    n = len(T)
    if n < LEAST_POSTURES:
        raise GeometryError(f"{n} touches of the point: {LEAST_POSTURES} in different postures are the least")
    R, p = T[:, :3, :3], T[:, :3, 3]
    A = (R - R.mean(axis=0)).reshape(3 * n, 3)
    if np.linalg.svd(A, compute_uv=False)[-1] / np.sqrt(n) < LEAST_SPREAD:
        raise GeometryError(
            "all postures turn the tool about one axis: touch the point with the tool tilted in different directions, "
            "by 30 degrees or more"
        )
    b = (p.mean(axis=0) - p).ravel()
    t = np.linalg.lstsq(A, b, rcond=None)[0]
    c = (R @ t + p).mean(axis=0)
    residuals = R @ t + p - c
    freedom = 3 * n - 6
    covariance = np.linalg.inv(A.T @ A) * float(np.sum(residuals**2)) / freedom
    return ToolPoint(np.asarray(t), np.asarray(c), np.asarray(covariance), np.asarray(residuals), freedom)
