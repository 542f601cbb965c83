"""Yaskawa RCONF: the ranges of the axes R, T and S from joint angles; the rest as the user gives it.

``///RCONF l,m,n,o,p,q``: 0 flip or 1 no-flip, 0 upper or 1 lower arm, 0 front or 1 rear; then 1 for R, T and S of 180°
or more. The manuals agree on the order. On flip they do not agree with jobs: the NX100's manual says that the R axis
decides (from -90° to 90° is flip), while nearly all public jobs with the R axis near 0° have an RCONF that begins with
1. It also says that the types vary with the model. wpcal therefore takes the first three numbers from a taught job.

References: Yaskawa, NX100 Instructions for Data Transmission Function, 4.1 Job Data Format (HW0481924); DX100, the same
(HW0482494); NX100 Operator's Manual, 3.9 Manipulator Types (RE-CSO-A031).
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.language.jobs import refuse_first
from wpcal.robot.kinematics.inverse import Posture

RANGES = slice(3, 6)  #: The numbers of RCONF for R, T and S.
HALF_TURN_DEG = 180.0


def rconf(posture: Posture, given: str) -> list[str]:
    """Return the RCONF of every posture.

    `given`: The RCONF of a taught job in the same posture: numbers with commas, at least six for the ranges to be
    written.

    Raises `InputError` when R, T or S is beyond ±180°: which of the two ranges a negative angle belongs to is not
    stated.
    """
    beyond = np.abs(posture.degrees[:, [0, 3, 5]]).max(axis=1) > HALF_TURN_DEG
    refuse_first(beyond, "S, R or T is beyond 180 deg, for which the range of RCONF could not be checked")
    numbers = given.split(",")
    numbers[RANGES] = ["0"] * len(numbers[RANGES])
    return [",".join(numbers)] * len(posture)
