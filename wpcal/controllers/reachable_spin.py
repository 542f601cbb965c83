"""The turn about the wire that an arm can make: within its joint limits at every point of a seam."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.controllers.spin import least_turn, possible_offsets, spun, swing_and_twist
from wpcal.controllers.torch import tool_rotations
from wpcal.core.arrays import BoolArray, FloatArray, frozen
from wpcal.core.errors import GeometryError
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import solve_inverse, turn_into_limits


def choose_reachable_spin(
    program: WeldProgram, arm: Arm, *, near: ArrayLike, T_flange_tool: RigidTransform
) -> WeldProgram:
    """Turn the tool about the wire so that an arm reaches every pose within its limits and the tool turns least.

    Parameters
    ----------
    program : WeldProgram
        As `build_program` made it.
    arm : Arm
    near : array_like, shape (n,)
        Shown joint angles near the seams, rad.
    T_flange_tool : RigidTransform
        The tool as set in the controller.

    Raises
    ------
    GeometryError
        When at a point of a seam no turn about the wire brings the arm within its limits; it names both.
    """
    paths = [_path(path, program, arm, near, T_flange_tool) for path in program.paths]
    return replace(program, paths=tuple(paths))


def _path(path: WeldPath, program: WeldProgram, arm: Arm, near: ArrayLike, T_flange_tool: RigidTransform) -> WeldPath:
    torch = program.torch
    R = tool_rotations(path.seam.frames.R, torch, path.seam.lean_rad)
    swing, twist = swing_and_twist(R, torch.tool_axis)
    free = -np.concatenate([[0.0], np.cumsum(twist)])
    e = possible_offsets(free, torch.spin_range_rad)
    every = spun(R[:, None], free[:, None] + e, torch.tool_axis)
    rows = path.weld_rows
    allowed = _is_reached(arm, path.p_base[rows], every, near, T_flange_tool)
    ends = path.p_base[[rows.start - 1, rows.stop]]
    allowed[[0, -1]] &= _is_reached(arm, ends, every[[0, -1]], near, T_flange_tool)
    try:
        chosen = least_turn(swing, e, allowed)
    except GeometryError as error:
        raise GeometryError(
            f"seam {path.seam.name}: {error}: {arm.name} is out of reach or beyond a joint limit with every turn of "
            "the torch within --spin-range-deg"
        ) from None
    along = every[np.arange(len(e)), chosen]
    return replace(path, R_base=frozen(np.concatenate([along[:1], along, along[-1:]])))


def _is_reached(arm: Arm, p: FloatArray, R: FloatArray, near: ArrayLike, T_flange_tool: RigidTransform) -> BoolArray:
    """Tell for tools at p (n, 3), mm, with orientations R (n, k, 3, 3) whether the arm holds them; shape (n, k)."""
    T = np.tile(np.eye(4), (*R.shape[:2], 1, 1))
    T[..., :3, :3], T[..., :3, 3] = R, p[:, None]
    flange = T.reshape(-1, 4, 4) @ T_flange_tool.inverse().matrix
    q = turn_into_limits(arm, solve_inverse(arm, flange).joints, np.asarray(near, dtype=np.float64))
    is_held = np.asarray(np.isfinite(q).all(axis=2), dtype=np.bool_)
    return np.asarray(np.any(is_held, axis=1), dtype=np.bool_).reshape(R.shape[:2])
