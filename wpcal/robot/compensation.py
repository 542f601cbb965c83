"""True positions from taught joint angles.

The controller teaches and replays with its nominal model. Points taken through the identified model give a true part
pose; the targets of that pose must then be compensated, or the robot's error comes back unseen (`RobotSpace`):
`wpcal.controllers.program.compensation`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm

NO_TOOL = RigidTransform.identity(target="flange", source="tool")


def correct_points(arm: Arm, joints: ArrayLike, *, T_flange_tool: RigidTransform = NO_TOOL) -> FloatArray:
    """Return where the tool tip was for taught joint angles.

    `joints`: shape (N, n). Shown angles, rad.
    Returns ndarray, shape (N, 3). Positions in the base, mm, in the robot space of `arm`.
    """
    T = arm.forward(joints)
    return np.asarray(T[:, :3, :3] @ T_flange_tool.t_mm + T[:, :3, 3], dtype=np.float64)
