"""Along the wire to a weld and from it: a joint move begins where the wire is clear of everything, never in the pool.

A wire that moves along its own line only goes where it, the nozzle and the torch behind it were. So on the way along
the wire the torch is compared with the part, and the wire at its end.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.cell.workplace import AIR_STEP_MM, back_along_wire
from wpcal.planning.sequence.motion_check import MotionChecker


class Withdrawal(NamedTuple):
    """States away from a weld, against the wire, or why there are none."""

    states: FloatArray  #: shape (a, k). In the last one the wire is clear; empty if it cannot be reached.
    why: str | None


def withdraw(
    weld: MotionChecker, air: MotionChecker, q: FloatArray, distance_mm: float, most_mm: float = 0.0
) -> Withdrawal:
    """Go back along the wire from a state of a weld, as far as the torch is free and the wire is clear at the end.

    `weld`, `air`: Without and with the wire as a body.
    `most_mm`: Beyond `distance_mm` the way goes on to the first clear state, up to here.
    `q`: shape (k,). All axes, rad and mm.
    """
    steps = math.ceil(distance_mm / AIR_STEP_MM)
    more = distance_mm / steps * math.ceil(max(most_mm - distance_mm, 0.0) / AIR_STEP_MM)
    back = back_along_wire(weld.cell, q[None, :JOINTS], distance_mm + more)[0]
    found = np.concatenate([q[None, :JOINTS], back[np.isfinite(back[:, 0])]])
    states = np.concatenate([found, np.repeat(q[None, JOINTS:], len(found), axis=0)], axis=1)
    if len(states) == 1:
        return Withdrawal(states[1:], "the arm does not reach the way back along the wire")
    checked = weld.check(states)
    if not checked.is_free:
        states = states[: max(math.ceil(float(checked.at[np.argmax(checked.margin_mm <= 0.0)])), 1)]
    if len(states) == 1:
        return Withdrawal(states[1:], f"the torch cannot go back along the wire: {weld.nearest(checked.states)}")
    margins = air.clearance.margins(states[1:])
    clear = np.flatnonzero(margins.is_clear)
    if not len(clear):
        why = f"it does not come free on its way back along the wire: {air.nearest(states[1:])}"
        return Withdrawal(states[:0], why)
    near = clear[clear < steps]
    return Withdrawal(states[1 : (near[-1] if len(near) else clear[0]) + 2], None)


def withdraws(weld: MotionChecker, air: MotionChecker, q: FloatArray, distance_mm: float) -> BoolArray:
    """Tell from which states of a weld, shape (n, k), the torch is free on the way back until the wire is clear."""
    back = back_along_wire(weld.cell, q[:, :JOINTS], distance_mm)
    can, rows, now = np.zeros(len(q), dtype=bool), np.arange(len(q)), q
    for step in range(back.shape[1]):  # most are clear, or blocked, after the first
        is_reached = np.isfinite(back[rows, step]).all(axis=1)
        rows, now = rows[is_reached], now[is_reached]
        if len(rows) == 0:
            break
        then = np.concatenate([back[rows, step], q[rows, JOINTS:]], axis=1)
        is_free = weld.free_shares(now, then, whole=True) == 1.0
        rows, then = rows[is_free], then[is_free]
        is_clear = air.clearance.margins(then).is_clear
        can[rows[is_clear]] = True
        rows, now = rows[~is_clear], then[~is_clear]
    return can
