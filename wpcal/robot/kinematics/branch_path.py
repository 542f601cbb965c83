"""Joint angles along a path in one branch of the inverse kinematics: continuous, and within the limits.

A linear move cannot change the branch: the arm would have to pass a singularity. Whole turns of an axis with more than
one turn are counted on along the path.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import TURN

LARGEST_STEP_RAD = math.radians(45.0)
"""Between two poses some millimetres and degrees apart, a joint that turns by more swings through a singularity. Arms
stop there, or leave the path."""


@dataclass(frozen=True, slots=True, eq=False)
class Broken:
    """Where a path cannot go on."""

    row: int  #: The first pose that the arm does not get to.
    why: str


def continue_branch(arm: Arm, joints: ArrayLike, near: ArrayLike) -> FloatArray | Broken:
    """Count whole turns along a path, shape (N, n). Shown angles, rad; or where the path breaks, and why.

    Parameters
    ----------
    joints : array_like, shape (N, n)
        Shown angles of one branch, each in the turn around zero, rad; NaN where the branch does not reach.
    near : shape (n,). The first angles are as near as possible to these.
    """
    q = np.asarray(joints, dtype=np.float64)
    out = ~np.isfinite(q).all(axis=1)
    if out.any():
        return Broken(int(np.argmax(out)), "is out of reach")
    steps = np.diff(q, axis=0)
    steps -= TURN * np.rint(steps / TURN)
    path = np.concatenate([q[:1], q[:1] + np.cumsum(steps, axis=0)])
    broken = [_limit(arm, path, joint, np.asarray(near)) for joint in range(q.shape[1])]
    jumps = np.abs(steps) > LARGEST_STEP_RAD
    if jumps.any():
        row, joint = (int(index[0]) for index in np.nonzero(jumps))
        degrees = math.degrees(steps[row, joint])
        broken.append(Broken(row + 1, f"joint {arm.joints[joint].name} would swing by {degrees:.0f} deg to get there"))
    found = [each for each in broken if each is not None]
    return min(found, key=lambda each: each.row) if found else path


def _limit(arm: Arm, path: FloatArray, joint: int, near: FloatArray) -> Broken | None:
    """Move one column of `path` by whole turns into the limits, in place; where it breaks them, if it does."""
    low, high = arm.limits[:, joint]
    column = path[:, joint]
    nearest = int(np.rint((near[joint] - column[0]) / TURN))
    turns = sorted(range(nearest - 3, nearest + 4), key=lambda turn: abs(turn - nearest))
    outside = [(column + TURN * turn < low) | (column + TURN * turn > high) for turn in turns]
    held = [int(np.argmax(rows)) if rows.any() else len(column) for rows in outside]
    best = held.index(max(held))
    path[:, joint] = column + TURN * turns[best]
    if held[best] == len(column):
        return None
    name, degrees = arm.joints[joint].name, math.degrees(path[held[best], joint])
    limits = f"{math.degrees(low):g} and {math.degrees(high):g} deg"
    return Broken(held[best], f"joint {name} would be at {degrees:.0f} deg, its limits are {limits}")
