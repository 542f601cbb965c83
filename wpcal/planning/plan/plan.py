"""`Plan`: one way to weld a seam with two robots.

Also here: the times of a plan: the wire moves along the seam at one constant speed that every joint can follow.

The thickness of a bead depends on the speed, so a seam is welded at one speed. If a joint cannot follow the asked
speed, the whole seam is welded slower, and the report names the joint and the place.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.core.motion import WELD_SPEED_MM_S
from wpcal.planning.cell.cell import Cell


class CollisionVerdict(Enum):
    """What is known about collisions on a path."""

    UNCHECKED = "unchecked"
    FREE = "free"
    NOT_FREE = "not free"


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """One path of both robots along a seam. Raises `InputError` when lengths differ."""

    seam: str  #: Name of the seam in ``seams.json``.
    s_mm: FloatArray  #: shape (n,). Arc length at the points, increasing, mm.
    q: FloatArray  #: shape (n, 12). All axes at the points, rad, unwrapped: neighbours differ by the actual move.
    #: `slope_rad`, `rotation_rad`: shape (n,). Weld position relative to gravity (DESIGN §3); the rotation is NaN in
    #: vertical travel.
    slope_rad: FloatArray
    rotation_rad: FloatArray
    #: `work_rad`, `travel_rad`: shape (n,). Torch angles (DESIGN §3).
    work_rad: FloatArray
    travel_rad: FloatArray
    objectives: Mapping[str, float]  #: By name; smaller is better.
    printed: Mapping[str, float]  #: The paper's functions as printed, by their symbols f1_1, f1_2, f2.
    #: shape (n,). Least distance between bodies at the points, mm; None if the plan was not checked.
    clearance_mm: FloatArray | None = None
    found_by: str = "ladder"  #: ``ladder`` or ``nsga2``.
    verdict: CollisionVerdict = CollisionVerdict.UNCHECKED  #: Result of the check between the points.

    def __post_init__(self) -> None:
        for name in ("s_mm", "slope_rad", "rotation_rad", "work_rad", "travel_rad", "clearance_mm"):
            values = getattr(self, name)
            if values is None:
                continue
            values = frozen(values)
            if values.shape != (len(self.q),):
                raise InputError(f"plan: {name} has shape {values.shape}, the path has {len(self.q)} points")
            object.__setattr__(self, name, values)

    def __len__(self) -> int:
        return len(self.s_mm)


@dataclass(frozen=True, slots=True)
class SpeedLimit:
    """The joint that limits the speed along a seam."""

    robot: int  #: 1 or 2.
    joint: str  #: Name on the pendant.
    s_mm: float  #: Start of the step where the joint is fastest.
    fastest_mm_s: float  #: Speed along the seam at which this joint reaches its limit there.


@dataclass(frozen=True, slots=True, eq=False)
class Schedule:
    """Times along a plan."""

    t_s: FloatArray  #: shape (n,). Time at the points, s; 0 at the first.
    speed_mm_s: float  #: Of the wire along the seam, at every point.
    asked_mm_s: float  #: The asked speed.
    #: The joint that reaches its limit first as the speed grows; None if no arm states a joint speed.
    limit: SpeedLimit | None

    @property
    def is_slowed(self) -> bool:
        """Whether a joint does not allow the asked speed."""
        return self.speed_mm_s < self.asked_mm_s

    def describe(self) -> str:
        """Say in one line how fast the seam is welded, and which joint limits the speed."""
        text = f"{self.speed_mm_s:g} mm/s along the seam, {self.t_s[-1]:.1f} s"
        if self.limit is None:
            return f"{text}; the arms state no joint speeds"
        place = f"joint {self.limit.joint} of robot {self.limit.robot} at s = {self.limit.s_mm:.1f} mm"
        if self.is_slowed:
            return f"{text} ({self.asked_mm_s:g} asked): {place} allows no more"
        return f"{text}; {place} allows {self.limit.fastest_mm_s:.1f} mm/s"


def schedule_plan(plan: Plan, cell: Cell, *, speed_mm_s: float = WELD_SPEED_MM_S) -> Schedule:
    r"""Compute the time of every point of a plan.

    The speed is the asked speed or the largest that every joint allows, whichever is less:
    :math:`v = \min(v_{asked}, \min_{i,j} \dot q_{j,max} \, \Delta s_i / |\Delta q_{ij}|)` and
    :math:`t = (s - s_0) / v`.

    Raises `InputError` when the speed is not positive, or two points of the plan have the same arc length.
    """
    if not 0.0 < speed_mm_s < math.inf:
        raise InputError(f"the speed along the seam must be positive, got {speed_mm_s:g} mm/s")
    step = np.diff(plan.s_mm)
    if not (step > 0).all():
        row = int(np.argmin(step > 0))
        raise InputError(f"seam {plan.seam}: points {row + 1} and {row + 2} have arc lengths that do not increase")
    limit = _first_limit(plan, cell)
    speed = speed_mm_s if limit is None else min(speed_mm_s, limit.fastest_mm_s)
    return Schedule(frozen((plan.s_mm - plan.s_mm[0]) / speed), speed, speed_mm_s, limit)


def _first_limit(plan: Plan, cell: Cell) -> SpeedLimit | None:
    """Return the joint and the step that allow the least speed along the seam."""
    allowed = cell.allowed_mm_s(plan.q, plan.s_mm)
    if not np.isfinite(allowed).any():
        return None
    row, column = np.unravel_index(int(np.argmin(allowed)), allowed.shape)
    return SpeedLimit(*cell.joint_of(int(column)), float(plan.s_mm[row]), float(allowed[row, column]))
