"""KUKA status and turn (S, T) from joint angles.

Bits of S: 1 if the wrist centre is behind axis 1 (overhead area); 2 if it is in front of the line through axes 2 and 3;
4 if A5 is negative. Bits of T: bit n is set if axis n + 1 is negative.

Sources disagree on the second bit: a table on the web states the opposite. Taught points in public programs settle it:
S 2 and S 6 go with positive A3 (its bit of T is not set), and S 6 with negative A5 (its bit of T is set), as in
``S 6, T 27`` and ``S 2, T 35``. For the overhead area no source could be checked.

References: KUKA, System Software 8.3: Operating and Programming Instructions for System Integrators (status and turn).
Beckhoff, TF5200 Programming Manual: Status & Turn (IS, IT). visose/Robots and the RoboDK post processor number them
alike.
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.language.jobs import refuse_first
from wpcal.robot.kinematics.inverse import Posture


def status_and_turn(posture: Posture) -> list[tuple[int, int]]:
    """Return S and T of every posture. Raises `InputError` when the wrist centre is behind axis 1."""
    refuse_first(posture.is_behind, "the wrist is in the overhead area, for which no source of S could be checked")
    status = 2 * ~posture.is_behind_lower_arm + 4 * (np.sin(posture.joints[:, 4]) < 0.0)
    turn = (posture.joints < 0.0) @ (1 << np.arange(6))
    return list(zip(status.astype(int).tolist(), turn.astype(int).tolist(), strict=True))
