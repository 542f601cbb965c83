"""FANUC CONFIG: flip, up and front, as ``N U T, 0, 0, 0``, from joint angles.

* F (flip) if J5 is positive, N if it is negative. Forums say the opposite. Controllers say so: positions that four of
  them show with their joint angles (``curpos.dg``, ``summary.dg``) are in the tests; Tesseract has the same sign.
* U (up) if the wrist centre is in front of the line through axes 2 and 3, D (down) if it is behind.
* T (front) if the wrist centre is in front of axis 1. For B (back) no public source says which elbow is up.
* The three numbers count the turns of joints 1, 4 and 6: 0 from -180° to 180°, 1 from there to 540°, -1 below -180°.
  Controllers say so: a program states one pose flipped and not flipped, with 1, 0, 0 both times, where a joint of the
  wrist would turn by 180°; two others state 0, -1, 0 with arms whose joint 5 cannot turn so far. The remote motion
  interface calls the numbers Turn4, Turn5 and Turn6.

References: FANUC, R-30iB HandlingTool Operator's Manual (position data). Diagnostic files of controllers in the public
repositories WILDER-SYSTEMS-LLC/git-ftp, irbzavalagit/UB10200_RBT01 and Hamood564/FanucTransmissionLine. Tesseract
Planning, ``robot_config.h``.
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.language.jobs import refuse_first
from wpcal.robot.kinematics.inverse import Posture


def config(posture: Posture) -> list[str]:
    """Return the CONFIG of every posture.

    Raises `InputError` when the wrist centre is behind axis 1, or joint 5 is beyond ±180°.
    """
    refuse_first(posture.is_behind, "the wrist is behind axis 1 (B), for which no public source defines U and D")
    refuse_first(np.abs(posture.degrees[:, 4]) > 180.0, "joint 5 is beyond 180 deg: CONFIG has no turns of it")
    flips = np.sin(posture.joints[:, 4]) > 0.0
    turns = np.rint(posture.degrees[:, [0, 3, 5]] / 360.0).astype(int).tolist()
    return [
        f"{'F' if flip else 'N'} {'D' if down else 'U'} T, {', '.join(map(str, turn))}"
        for flip, down, turn in zip(flips.tolist(), posture.is_behind_lower_arm.tolist(), turns, strict=True)
    ]
