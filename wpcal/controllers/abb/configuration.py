"""ABB `confdata`: cf1, cf4 and cf6 are quadrants of joints 1, 4 and 6; cfx numbers the eight postures.

====  ===================  ===============================  =======
cfx   wrist centre         wrist centre                     joint 5
      relative to axis 1   relative to the lower arm
====  ===================  ===============================  =======
0, 1  in front             in front                         +, -
2, 3  in front             behind                           +, -
4, 5  behind               in front                         +, -
6, 7  behind               behind                           +, -
====  ===================  ===============================  =======

Quadrant 0 is 0° to 90°, quadrant -1 is 0° to -90°. The table is that of arms without a parallel rod; arms with one
(IRB 2400, 4400, 6400 …) have another.

References: ABB, RAPID Instructions, Functions and Data types: confdata. The table is quoted in AXIS_CONFIGURATION.md of
CEAD-group/py-opw-kinematics (commit 2f70958), whose joint angles of an IRB 1660 with cfx 4 and 5 are in the tests here;
hehonglu123/Motion-Primitive-Planning numbers quadrants and cfx alike and runs on real arms.
"""

from __future__ import annotations

import numpy as np

from wpcal.robot.kinematics.inverse import Posture


def confdata(posture: Posture) -> list[str]:
    """Return ``[cf1,cf4,cf6,cfx]`` for every posture."""
    quadrants = np.floor(posture.degrees[:, [0, 3, 5]] / 90.0).astype(int).tolist()
    flips = np.sin(posture.joints[:, 4]) < 0.0
    cfx = (4 * posture.is_behind + 2 * posture.is_behind_lower_arm + flips).astype(int).tolist()
    return [f"[{cf1},{cf4},{cf6},{x}]" for (cf1, cf4, cf6), x in zip(quadrants, cfx, strict=True)]
