"""FANUC CONFIG: flip, up and front, as ``N U T, 0, 0, 0``, from joint angles.

* F (flip) if J5 is positive, N if it is negative. Forums say the opposite. Controllers say so: positions that four of
  them show with their joint angles (``curpos.dg``, ``summary.dg``) are in the tests; Tesseract has the same sign.
* U (up) if the wrist centre is in front of the line through axes 2 and 3, D (down) if it is behind.
* T (front) if the wrist centre is in front of axis 1. For B (back) no public source says which elbow is up.
* The three numbers count turns. They are 0 from -180° to 180°. For angles beyond that the public sources do not agree
  which joints they count.

References: FANUC, R-30iB HandlingTool Operator's Manual (position data). Diagnostic files of controllers in the public
repositories WILDER-SYSTEMS-LLC/git-ftp, irbzavalagit/UB10200_RBT01 and Hamood564/FanucTransmissionLine. Tesseract
Planning, ``robot_config.h``.
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.language.jobs import refuse_first
from wpcal.robot.kinematics.inverse import Posture

ONE_TURN_DEG = 180.0


def config(posture: Posture) -> list[str]:
    """Return the CONFIG of every posture.

    Raises `InputError` when the wrist centre is behind axis 1, or a joint is beyond ±180°.
    """
    refuse_first(posture.is_behind, "the wrist is behind axis 1 (B), for which no public source defines U and D")
    beyond = np.abs(posture.degrees[:, [0, 3, 4, 5]]).max(axis=1) > ONE_TURN_DEG
    refuse_first(
        beyond,
        "joint 1, 4, 5 or 6 is beyond 180 deg, and public sources do not agree on the turn numbers (the joints from "
        "which the program starts decide whether they stay within it)",
    )
    flips = np.sin(posture.joints[:, 4]) > 0.0
    return [
        f"{'F' if flip else 'N'} {'D' if down else 'U'} T, 0, 0, 0"
        for flip, down in zip(flips.tolist(), posture.is_behind_lower_arm.tolist(), strict=True)
    ]
