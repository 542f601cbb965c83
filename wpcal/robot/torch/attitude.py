"""The torch on a seam: work angle, travel angle and standoff; and both angles measured from given wires.

At zero angles the wire points along -z of the seam frame. z is the bisector of the joint, so at a fillet between square
plates the wire is at 45 degrees to both.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.motion import standoff, travel_angle, work_angle
from wpcal.core.options import opt
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.same_bits import arc_tangent

LARGEST_WORK_RAD = math.radians(60.0)
"""At a square fillet the torch lies on a plate at 45 degrees from the bisector; more than this is a mistake."""
LARGEST_TRAVEL_RAD = math.radians(45.0)
"""Welding uses up to about 25 degrees of push or drag; more than this is a mistake."""


class ToolAxis(Enum):
    """The axis of the controller's tool frame along which the wire leaves the tip."""

    Z = "z"
    X = "x"


@dataclass(frozen=True, slots=True)
class TorchSettings:
    """How the torch is held.

    Raises `InputError` when an angle is outside its range or the standoff is negative or not finite.
    """

    work_rad: float = work_angle()
    travel_rad: float = travel_angle()
    standoff_mm: float = standoff()
    tool_axis: ToolAxis = opt(ToolAxis.Z, "Axis of the tool along the wire.")
    #: How far the tool may turn about the wire, either way, from the direction of travel. Within it the tool turns as
    #: little as possible along a seam; 0 keeps its x (or -z) along the travel. Half a turn allows every orientation of
    #: a round torch and no winding of its cables beyond that.
    spin_range_rad: float = math.pi

    def __post_init__(self) -> None:
        limits = (("work", self.work_rad, LARGEST_WORK_RAD), ("travel", self.travel_rad, LARGEST_TRAVEL_RAD))
        for name, angle, largest in limits:
            if not abs(angle) <= largest:
                most = math.degrees(largest)
                raise InputError(f"{name} angle: expected -{most:g} to {most:g} deg, got {math.degrees(angle):g}")
        if not 0.0 <= self.spin_range_rad <= math.pi:
            got = math.degrees(self.spin_range_rad)
            raise InputError(f"turn about the wire: expected 0 to 180 deg, got {got:g}")
        if not 0.0 <= self.standoff_mm < math.inf:
            raise InputError(f"standoff: expected 0 or more mm, got {self.standoff_mm:g}")

    def angles(self, lean_rad: FloatArray | None) -> FloatArray:
        """Return work and travel angle, shape (2, n), where a seam leans by `lean_rad` (n, 2): not zero, it counts."""
        lean = np.zeros((1, 2)) if lean_rad is None else np.nan_to_num(lean_rad)
        return np.where(lean.any(axis=1), lean.T, [[self.work_rad], [self.travel_rad]])


def tool_rotations(
    R_seam: ArrayLike, torch: TorchSettings, lean_rad: FloatArray | None = None, spin_rad: FloatArray | None = None
) -> FloatArray:
    r"""Return the axes of the tool on every frame of a seam.

    At zero angles the tool is the seam frame rotated by π about x. In general
    :math:`R_{tool} = R_{seam}\,R_x(w)\,R_y(-v)\,R_x(\pi)`, whose z is the wire direction
    :math:`d = (\sin v, \cos v \sin w, -\cos v \cos w)` in the seam frame (work angle w, travel angle v).

    `R_seam`: shape (n, 3, 3). Columns are x (travel), y and z (out of the joint) of the seam, in any frame.
    `lean_rad`: shape (n, 2), optional. Work and travel angle at every frame (`Seam.lean_rad`). They replace those of
    `torch` where they are not zero: there a straight torch meets the part. NaN: unknown.
    `spin_rad`: shape (n,), optional. How far a bent neck is turned about the wire, right-handed from the tip
    (`Seam.spin_rad`). The tool turns with it: the neck always bends towards the same side of the tool
    (`neck_directions`).
    Returns ndarray, shape (n, 3, 3). Columns are the tool's axes in the same frame. With ``ToolAxis.X`` the tool's x is
    the wire direction, y is the same, and z points against the travel.
    """
    work, travel = torch.angles(lean_rad)
    turn = rotation_from_zyx(work, 0.0, 0.0) @ rotation_from_zyx(0.0, -travel, 0.0)
    R = np.asarray(R_seam, dtype=np.float64) @ (turn @ np.diag([1.0, -1.0, -1.0]))
    if spin_rad is not None:
        R = R @ rotation_from_zyx(0.0, 0.0, -np.nan_to_num(spin_rad))
    if torch.tool_axis is ToolAxis.X:
        return np.stack([R[..., 2], R[..., 1], -R[..., 0]], axis=-1)
    return np.asarray(R, dtype=np.float64)


def wire_directions(R_tool: ArrayLike, tool_axis: ToolAxis) -> FloatArray:
    """Return the unit vectors along which the wire leaves the tip, shape (..., 3). In the same frame.

    `R_tool`: shape (..., 3, 3). Columns are the tool's axes, in any frame.
    """
    R = np.asarray(R_tool, dtype=np.float64)
    return R[..., 2] if tool_axis is ToolAxis.Z else R[..., 0]


def neck_directions(R_tool: ArrayLike, tool_axis: ToolAxis) -> FloatArray:
    """Return the unit vectors towards which a bent neck bends: -x of the tool, or its z if the wire is along its x.

    `R_tool`: shape (..., 3, 3). Columns are the tool's axes, in any frame.
    Returns ndarray, shape (..., 3). In the same frame.
    """
    R = np.asarray(R_tool, dtype=np.float64)
    return np.asarray(-R[..., 0] if tool_axis is ToolAxis.Z else R[..., 2], dtype=np.float64)


def measure_torch(R_seam: ArrayLike, wire: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Measure the angles at which wires meet a seam: v = asin(d·x), w = the signed angle about x from -z.

    `R_seam`: shape (n, 3, 3). Columns are x, y and z of the seam frames, in any frame.
    `wire`: shape (n, 3). Unit wire directions in the frame of `R_seam`.
    Returns `work_rad, travel_rad`: ndarray, shape (n,).
    """
    d = np.einsum("nij,ni->nj", np.asarray(R_seam, dtype=np.float64), np.asarray(wire, dtype=np.float64))
    travel = arc_tangent(d[:, 0], np.hypot(d[:, 1], d[:, 2]))  # asin(d·x), exact near ±90° too
    return arc_tangent(d[:, 1], -d[:, 2]), travel
