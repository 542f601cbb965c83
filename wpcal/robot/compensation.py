"""True positions from taught joint angles, and controller targets that a nominal model turns into true ones.

The controller teaches and replays with its nominal model. Points taken through the identified model give a true part
pose; the targets of that pose must then be compensated, or the robot's error comes back unseen (`RobotSpace`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import nearest_joints

NO_TOOL = RigidTransform.identity(target="flange", source="tool")


def correct_points(arm: Arm, joints: ArrayLike, *, T_flange_tool: RigidTransform = NO_TOOL) -> FloatArray:
    """Return where the tool tip was for taught joint angles.

    `joints`: shape (N, n). Shown angles, rad.
    Returns ndarray, shape (N, 3). Positions in the base, mm, in the robot space of `arm`.
    """
    T = arm.forward(joints)
    return np.asarray(T[:, :3, :3] @ T_flange_tool.t_mm + T[:, :3, 3], dtype=np.float64)


def compensate_targets(
    arm: Arm, T_base_tool: ArrayLike, *, near: ArrayLike, T_flange_tool: RigidTransform = NO_TOOL
) -> tuple[FloatArray, FloatArray]:
    """Return the targets to send so that the real robot goes to the true poses: ``FK_nominal(IK_identified(T))``.

    Returns `targets`: ndarray, shape (N, 4, 4). Tool poses for the controller, in nominal robot space, mm.
    Returns `joints`: ndarray, shape (N, n). Shown angles at these targets, rad.
    Raises `InputError` when the arm is not an identified one.
    Raises `GeometryError` when a pose is out of reach or breaks a joint limit.

    `T_base_tool`: shape (N, 4, 4). True tool poses, mm.
    `near`: shape (n,) or (N, n). Shown angles, rad, that say which of the eight configurations the robot will be in;
    the correction differs a little from one to another.
    """
    if arm.nominal is None:
        raise InputError(f"{arm.name} is a nominal arm: compensated targets need an identified one")
    tool = T_flange_tool.matrix
    joints = nearest_joints(arm, np.asarray(T_base_tool, dtype=np.float64) @ T_flange_tool.inverse().matrix, near)
    return np.asarray(arm.as_nominal().forward(joints) @ tool, dtype=np.float64), joints
