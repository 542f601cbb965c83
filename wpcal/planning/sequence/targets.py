"""What a sequence is asked for: weld position, torch angles, speeds, order."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.motion import (
    AIR_CLEARANCE_MM,
    AIR_SPEED_MM_S,
    APPROACH_MM,
    torch_range,
    travel_angle,
    weld_speed,
    work_angle,
)
from wpcal.core.options import opt, opt_deg
from wpcal.seam.path.position import weld_rotation, weld_slope

SIDE_RAD = math.radians(45.0)  #: Rotation of a horizontal fillet (PB).


class WeldPosition(Enum):
    """Which weld position is asked for (ISO 6947)."""

    FLAT = "flat"  #: PA, PB or between.
    PA = "PA"
    PB = "PB"
    ANY = "any"


class WeldOrder(Enum):
    """In which order seams are welded."""

    TIME = "time"  #: The shortest way between them.
    LISTED = "listed"  #: As the file lists them.
    SKIP = "skip"
    """Each seam far from the two before it: heat and shrinkage are spread, and opposite seams follow one another."""
    PAIRS = "pairs"  #: Each seam, then the one opposite: both pull the part the other way.


@dataclass(frozen=True, slots=True)
class SequenceTargets:
    """Targets of all seams. Raises `InputError` when a number is not positive or too large."""

    position: WeldPosition = opt(
        WeldPosition.FLAT,
        "With one robot: the weld position that the positioner brings seams into; flat: PA, PB or between.",
    )
    position_tol_rad: float = opt_deg(
        10.0, "How far from the weld position a seam is still in position.", least=-180.0, most=180.0
    )
    work_rad: float = work_angle()
    travel_rad: float = travel_angle()
    torch_range_rad: float = torch_range()
    order: WeldOrder = opt(
        WeldOrder.TIME,
        "Order of the seams: least time, as listed, each far from the two before it (skip), or each followed by the "
        "one opposite (pairs); the last two for less distortion. Tack welds come first, then bead by bead.",
    )
    speed_mm_s: float = weld_speed()
    air_speed_mm_s: float = AIR_SPEED_MM_S
    approach_mm: float = APPROACH_MM
    air_clearance_mm: float = opt(
        AIR_CLEARANCE_MM,
        "Least distance of the wire from the part on moves through the air, and of the torch where the distances of "
        "the cell leave no way from a seam: above the errors of a calibration and of a path.",
        least=0,
    )
    seam_clearance_mm: float = opt(
        0.0,
        "Least distance of the torch from the part at a seam that the distances of the cell leave no lean for, as at "
        "corners: seams are found with 0.",
        least=0,
    )
    joint_margin_rad: float = opt_deg(
        1.0, "How far joints stay from their limits: an arm stops with a fault at a limit.", least=0, most=90
    )
    seed: int = opt(0, "Seed of all random numbers.", least=0)

    def __post_init__(self) -> None:
        for name in ("speed_mm_s", "air_speed_mm_s", "approach_mm"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"{name}: expected a positive number, got {getattr(self, name):g}")
        if not 0.0 < self.position_tol_rad <= math.radians(90.0):
            got = math.degrees(self.position_tol_rad)
            raise InputError(f"position tolerance: expected above 0 and at most 90 deg, got {got:g}")
        if not 0.0 <= self.torch_range_rad <= math.radians(45.0):
            got = math.degrees(self.torch_range_rad)
            raise InputError(f"torch range: expected 0 to 45 deg, got {got:g}")
        for name, target in (("work", self.work_rad), ("travel", self.travel_rad)):
            if not abs(target) <= math.radians(45.0):
                raise InputError(f"{name} angle: expected -45 to 45 deg, got {math.degrees(target):g}")

    def off_position(self, R_world_seam: FloatArray) -> FloatArray:
        """Return how far seam frames are from the asked weld position.

        `R_world_seam`: shape (..., 3, 3). Columns x (travel), y, z (out of the joint) in `world`.
        Returns ndarray, shape (...). rad; the larger of the slope and of what the rotation is off. 0 if any position is
        asked for.
        """
        travel, outward = R_world_seam[..., 0], R_world_seam[..., 2]
        slope, rotation = weld_slope(travel), weld_rotation(travel, outward)
        if self.position is WeldPosition.ANY:
            return np.zeros_like(slope)
        lean = np.abs(np.nan_to_num(rotation))
        if self.position is WeldPosition.FLAT:
            off = np.maximum(lean - SIDE_RAD, 0.0)
        else:
            off = lean if self.position is WeldPosition.PA else np.abs(lean - SIDE_RAD)
        return np.maximum(np.abs(slope), off)
