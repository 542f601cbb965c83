"""`WeldTargets`: the weld position and torch angles that a plan should have, and how far it may be from them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.motion import torch_range, travel_angle, work_angle
from wpcal.core.options import opt_deg
from wpcal.planning.cell.closed_chain import COORDINATES, ROTATION, SLOPE, TRAVEL, WORK

ATTITUDE = [SLOPE, ROTATION, WORK, TRAVEL]  #: The coordinates that have a target and a range.


@dataclass(frozen=True, slots=True)
class WeldTargets:
    """The target weld position and torch angles, and how far from them a plan may go.

    Raises `InputError` when a target is outside its range, or a range is not positive or too large.
    """

    slope_rad: float = opt_deg(10.0, "Target slope of the weld, uphill.", least=-180.0, most=180.0)
    rotation_rad: float = opt_deg(0.0, "Target rotation of the joint.", least=-180.0, most=180.0)
    slope_range_rad: float = math.radians(30.0)
    rotation_range_rad: float = math.radians(90.0)
    work_rad: float = work_angle()
    travel_rad: float = travel_angle()
    torch_range_rad: float = torch_range()

    def __post_init__(self) -> None:
        ranges = (
            ("slope", self.slope_rad, self.slope_range_rad, 80.0),
            ("rotation", self.rotation_rad, self.rotation_range_rad, 180.0),
        )
        for name, target, largest, most_deg in ranges:
            if not 0 < largest <= math.radians(most_deg):
                what = f"{name}: its range must be above 0 and at most {most_deg:g} deg"
                raise InputError(f"{what}, got {math.degrees(largest):g}")
            if not abs(target) <= largest:
                raise InputError(f"{name}: {math.degrees(target):g} deg is outside its range {math.degrees(largest):g}")
        if not 0 < self.torch_range_rad <= math.radians(45.0):
            got = math.degrees(self.torch_range_rad)
            raise InputError(f"torch range: expected above 0 and at most 45 deg, got {got:g}")
        for name, target in (("work", self.work_rad), ("travel", self.travel_rad)):
            if not abs(target) <= math.radians(45.0):
                raise InputError(f"{name} angle: expected -45 to 45 deg, got {math.degrees(target):g}")

    @property
    def attitude_rad(self) -> FloatArray:
        """Target slope, rotation, work and travel, shape (4,), rad."""
        return np.array([self.slope_rad, self.rotation_rad, self.work_rad, self.travel_rad])

    @property
    def attitude_box_rad(self) -> tuple[FloatArray, FloatArray]:
        """Least and largest slope, rotation, work and travel, shape (4,) each, rad."""
        centre = np.where([False, False, True, True], self.attitude_rad, 0.0)
        range_ = np.array([self.slope_range_rad, self.rotation_range_rad, *(self.torch_range_rad,) * 2])
        return centre - range_, centre + range_


def target_coordinates(targets: WeldTargets, count: int) -> FloatArray:
    """Return coordinates of `count` points with the target weld position and torch angles, shape (count, 9).

    Place, yaw and spin are zero.
    """
    coordinates = np.zeros((count, COORDINATES))
    coordinates[:, ATTITUDE] = targets.attitude_rad
    return coordinates


def deviations(coordinates: FloatArray, targets: WeldTargets) -> FloatArray:
    """Return how far slope, rotation, work and travel are from their targets, rad.

    `coordinates`: ndarray, shape (..., 9).
    Returns ndarray, shape (..., 4). In the order of `ATTITUDE`.
    """
    return np.asarray(coordinates[..., ATTITUDE] - targets.attitude_rad, dtype=np.float64)
