"""One run of both robots as states with times: approach, weld and retract.

Before and after the weld robot 2 does not move, and robot 1 moves along the wire. The steps are short enough that a
straight line in the joints is nearly straight in space. If part of the approach cannot be reached or is not clear, it
is omitted: the run then begins nearer to the seam.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.core.motion import APPROACH_MM
from wpcal.planning.cell.cell import Cell, joint_speeds
from wpcal.planning.cell.hulls import hull_clearance
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.cell.workplace import back_along_wire
from wpcal.planning.plan.plan import CollisionVerdict, Plan, Schedule
from wpcal.planning.plan.recheck import REFINE, PathCheck, TipMotion, check_path, finer_states, measure_tip

AIR_SPEED_MM_S = 50.0  #: Near a part: half of the speed that `wpcal export` uses for free moves.


class Phase(Enum):
    """What leads to a state."""

    AIR = "air"
    APPROACH = "approach"
    WELD = "weld"
    RETRACT = "retract"


@dataclass(frozen=True, slots=True, eq=False)
class CellRun:
    """States of both robots with times, from the approach to the retract."""

    plan: Plan
    schedule: Schedule
    q: FloatArray  #: shape (N, 12). All axes at the states, rad; rows `first` to `last` are the plan.
    t_s: FloatArray  #: shape (N,). s; 0 at the first state.
    #: `first`, `last`: Rows of the first and the last point of the weld.
    first: int
    last: int
    tip: TipMotion  #: Of the weld.
    check: PathCheck | None = None  #: Of the whole run; None if it was not checked.

    def __len__(self) -> int:
        return len(self.t_s)

    @property
    def verdict(self) -> CollisionVerdict:
        """What is known about collisions on the whole run."""
        return CollisionVerdict.UNCHECKED if self.check is None else self.check.verdict

    @property
    def phases(self) -> tuple[Phase, ...]:
        """The phase of each state; the first state of the weld ends the approach."""
        return tuple(
            Phase.APPROACH if row <= self.first else Phase.WELD if row <= self.last else Phase.RETRACT
            for row in range(len(self))
        )

    def along(self, values: FloatArray) -> FloatArray:
        """Return values at the points of the plan, shape (n,), as shape (N,) with NaN outside the weld."""
        full = np.full(len(self), np.nan)
        full[self.first : self.last + 1] = values
        return full


def build_run(
    plan: Plan,
    cell: Cell,
    schedule: Schedule,
    *,
    approach_mm: float = APPROACH_MM,
    air_speed_mm_s: float = AIR_SPEED_MM_S,
    refine: int | None = REFINE,
) -> CellRun:
    """Add an approach and a retract to a plan, and check the whole run.

    Raises `InputError` when a number is not positive (the distance: negative), or hulls need a package that is not
    installed.
    """
    if not (0.0 <= approach_mm < math.inf and 0.0 < air_speed_mm_s < math.inf):
        raise InputError(f"approach {approach_mm:g} mm at {air_speed_mm_s:g} mm/s: expected positive numbers")
    ends = (away_along_wire(cell, plan.q[row], approach_mm, refine=refine) for row in (0, -1))
    before, after = next(ends)[::-1], next(ends)
    joints1 = np.concatenate([before, plan.q[:, :JOINTS], after])
    rows = np.clip(np.arange(len(joints1)) - len(before), 0, len(plan) - 1)
    q = np.concatenate([joints1, plan.q[rows, JOINTS:]], axis=1)
    first, last = len(before), len(before) + len(plan) - 1
    steps = _air_seconds(cell, joints1, air_speed_mm_s)
    steps[first:last] = np.diff(schedule.t_s)
    t_s = frozen(np.concatenate([[0.0], np.cumsum(steps)]))
    check = None if refine is None else check_path(q, plan.s_mm[rows], cell, refine=refine)
    tip = measure_tip(plan.q, plan.s_mm, schedule.t_s, cell)
    return CellRun(plan, schedule, q, t_s, first, last, tip, check)


def away_along_wire(
    cell: Cell, q: FloatArray, distance_mm: float = APPROACH_MM, *, refine: int | None = REFINE
) -> FloatArray:
    """Return joints of robot 1 at steps away from a pose, against the wire, while robot 2 does not move.

    `q`: shape (12,). All axes at the pose, rad.
    Returns ndarray, shape (k, 6). As far as the steps can be reached and, if checked, are clear.
    """
    every = back_along_wire(cell, q[None, :JOINTS], distance_mm)[0]
    away: FloatArray = every[np.isfinite(every[:, 0])]
    if refine is None or not len(away):
        return away
    steps = np.concatenate([q[None, :JOINTS], away])
    fine = finer_states(np.concatenate([steps, np.repeat(q[None, JOINTS:], len(steps), axis=0)], axis=1), refine=refine)
    blocked = ~hull_clearance(cell, fine).is_clear[1:]  # the check of the weld covers the pose itself
    return away if not blocked.any() else away[: int(np.argmax(blocked)) // refine]


def _air_seconds(cell: Cell, joints1: FloatArray, speed_mm_s: float) -> FloatArray:
    """Return the time of every step, s: at the given speed of the flange, or longer if a joint needs longer."""
    flange = cell.arm.forward(joints1)[:, :3, 3]
    distance = np.linalg.norm(np.diff(flange, axis=0), axis=1)
    slowest = (np.abs(np.diff(joints1, axis=0)) / joint_speeds(cell.arm)).max(axis=1, initial=0.0)
    return np.asarray(np.maximum(distance / speed_mm_s, slowest), dtype=np.float64)
