"""A home for a new cell: the torch points down in front of the arm, and nothing is in collision."""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import product
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_file import default_home
from wpcal.planning.cell.one_robot_clearance import OneRobotClearance
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.cell.singularity import is_regular, is_within_turns
from wpcal.planning.cell.workplace import reach_mm
from wpcal.robot.kinematics.arm import arm_frames
from wpcal.robot.kinematics.inverse import solve_inverse

HOME_DISTANCES, HOME_HEIGHTS = (0.7, 0.6, 0.8, 0.5), (0.8, 0.6, 1.0)
"""Where the tip of the wire is at home, in front of the base and above the mounting face, in parts of the reach."""
ELBOW = 4.0  #: What an elbow that is higher by the reach counts against a turn of the wrist, rad.
TURNS_DEG = tuple(float(sign * turn) for turn in range(0, 181, 15) for sign in (1, -1) if 0 < turn < 180 or sign > 0)
"""Turns of joint 1 away from the front, the smallest first."""
AT_ONCE = 128  #: States that are compared with the cell together: most cells have a free one among the first.


def choose_home(cell: Cell) -> FloatArray:
    """Return joints of a home, shape (6,), rad.

    The elbow is up and the wrist is turned little. Of these poses the first is taken that keeps all safety distances
    from the bodies of the cell: first in front of the base, then with joint 1 turned. If none does, the first pose is
    returned; `wpcal.planning.cell.cell_check` then tells what it touches.
    """
    poses = _torch_down(cell)
    if not len(poses):
        poses = default_home(cell.arm)[None]
    turned = np.concatenate([poses + np.radians([turn, 0, 0, 0, 0, 0]) for turn in TURNS_DEG])
    low, high = cell.arm.limits
    turned = np.round(np.degrees(turned), 1)  # as it is written
    turned = np.radians(turned[((np.radians(turned) >= low) & (np.radians(turned) <= high)).all(axis=1)])
    clearance = OneRobotClearance(cell, None)
    for start in range(0, len(turned), AT_ONCE):
        some = turned[start : start + AT_ONCE]
        q = np.concatenate([some, np.repeat(cell.home[None, JOINTS:], len(some), axis=0)], axis=1)
        clear = clearance.margins(q).is_clear
        if clear.any():
            return np.asarray(some[int(np.argmax(clear))])
    return np.asarray(turned[0] if len(turned) else poses[0])


def _torch_down(cell: Cell) -> FloatArray:
    """Return joints with the torch pointing down in front of the arm, shape (n, 6), rad, the best first."""
    arm = cell.arm
    reach = reach_mm(arm)
    places = [(x * reach, z * reach + arm.mount_mm[2]) for z in HOME_HEIGHTS for x in HOME_DISTANCES]
    R = np.array([[[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]] for c, s in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0))])
    T = np.repeat(np.eye(4)[None], len(places) * len(R), axis=0)
    T[:, :3, :3] = np.tile(R, (len(places), 1, 1))
    T[:, [0, 2], 3] = np.repeat(places, len(R), axis=0)
    joints = solve_inverse(arm, product(T, cell.T_flange_tool.inverse().matrix)).joints
    good = (is_within_turns(arm, joints) & is_regular(arm, joints)).reshape(-1)
    flat = joints.reshape(-1, joints.shape[-1])[good]
    if not len(flat):
        return flat
    elbow = list(arm_frames(arm, RigidTransform.identity(target="world", source="base"), flat))[2].p[2] / reach
    worth = np.abs(flat)[:, [0, 3, 5]].max(axis=1) - ELBOW * elbow
    return np.asarray(flat[np.argsort(worth, kind="stable")])
