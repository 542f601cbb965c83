r"""The turn of the tool about the wire along a seam: the tool turns as little as the seam allows.

The seam fixes the wire's direction; the turn about it (the spin) is free for a round torch. A tool that follows the
direction of travel turns about the wire by as much as the seam turns. From pose i to i + 1 the tool turns by a swing
:math:`\sigma_i` of the wire and a twist :math:`\tau_i` about it. A spin :math:`e_i - \sum_{j<i}\tau_j` with constant
e takes the whole twist away. Where the range of the spin, or an arm's reach, does not allow one e for the whole seam,
dynamic programming over the points finds the e_i with the least sum of
:math:`\sqrt{\sigma_i^2 + (e_{i+1} - e_i)^2}`.
"""

from __future__ import annotations

import math

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.ladder import cheapest_way
from wpcal.core.rotations import quaternion_from_rotation
from wpcal.core.tangent import exp_rotation
from wpcal.robot.torch.attitude import ToolAxis

STEP_RAD = math.radians(5.0)  #: Step of e: finer steps change the sum by less than the swing does.
START_COST = 1e-3
"""Cost per rad at the start of a seam: of equal profiles the one nearest to the travel is taken, or with an arm the
one nearest to its joints."""


def swing_and_twist(R: FloatArray, axis: ToolAxis) -> tuple[FloatArray, FloatArray]:
    """Split the turn from each pose of a tool to the next.

    `R`: shape (n, 3, 3). Axes of the tool, in any frame.
    Returns `swing, twist`: ndarray, shape (n - 1,). Angle between the wires, and turn about the wire, rad.
    """
    q = quaternion_from_rotation(np.swapaxes(R[:-1], -1, -2) @ R[1:])
    about = q[:, 2] if axis is ToolAxis.Z else q[:, 0]
    twist = 2.0 * np.arctan2(about, q[:, 3])
    swing = 2.0 * np.arccos(np.clip(np.hypot(about, q[:, 3]), 0.0, 1.0))
    return swing, np.remainder(twist + np.pi, 2.0 * np.pi) - np.pi


def spun(R: FloatArray, spin_rad: FloatArray, axis: ToolAxis) -> FloatArray:
    """Turn tools about their wires, shape (..., 3, 3).

    `R`: ndarray, shape (..., 3, 3).
    `spin_rad`: shape (...). rad.
    """
    unit = np.array([0.0, 0.0, 1.0] if axis is ToolAxis.Z else [1.0, 0.0, 0.0])
    return np.asarray(R @ exp_rotation(np.asarray(spin_rad)[..., None] * unit), dtype=np.float64)


def unwinding_spin(R: FloatArray, axis: ToolAxis, range_rad: float) -> FloatArray:
    """Return the spin with which a tool turns least along a seam, shape (n,), rad.

    `R`: shape (n, 3, 3). Axes of the tool that follows the direction of travel.
    `range_rad`: Largest spin either way, rad; 0 keeps the direction of travel.
    """
    swing, twist = swing_and_twist(R, axis)
    free = -np.concatenate([[0.0], np.cumsum(twist)])
    low, high = float((-range_rad - free).max()), float((range_rad - free).min())
    if low <= high:
        return np.asarray(free + min(max(0.0, low), high), dtype=np.float64)
    e = possible_offsets(free, range_rad)
    chosen = least_turn(swing, e)
    return np.asarray(free + e[np.arange(len(e)), chosen], dtype=np.float64)


def possible_offsets(free: FloatArray, range_rad: float) -> FloatArray:
    """Return the values of e that are tried, shape (n, k), rad; none leads the spin out of its range.

    `free`: shape (n,). The spin that takes the whole twist away, rad.
    """
    low = math.floor((-range_rad - float(free.max())) / STEP_RAD)
    high = math.ceil((range_rad - float(free.min())) / STEP_RAD)
    spin = np.clip(free[:, None] + np.arange(low, high + 1) * STEP_RAD, -range_rad, range_rad)
    return np.asarray(spin - free[:, None], dtype=np.float64)


def least_turn(swing: FloatArray, e: FloatArray) -> IntArray:
    """Choose an e per point with the least sum of turns, shape (n,). Columns of `e`.

    `swing`: shape (n - 1,). rad.
    `e`: shape (n, k). rad.
    """
    own = START_COST * np.abs(e) * (np.arange(len(e)) == 0)[:, None]
    return np.array(
        cheapest_way(list(own), lambda i, now, before: np.hypot(swing[i - 1], e[i, now][:, None] - e[i - 1, before]))
    )
