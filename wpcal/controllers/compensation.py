"""Programs for an identified robot: targets with which the controller reaches the true poses."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from wpcal.controllers.few_moves import fit_seam
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.reachable_spin import ArmAtTool
from wpcal.controllers.torch import tool_rotations, wire_directions
from wpcal.core.arrays import frozen
from wpcal.core.errors import InputError
from wpcal.core.tangent import exp_rotation
from wpcal.moves.fit import USUAL_TOLERANCE
from wpcal.moves.interpolation import swings_between
from wpcal.robot.kinematics.inverse import follow_path

Poses = TypeVar("Poses", WeldPath, SafePoint)


def compensate_program(program: WeldProgram, arm: ArmAtTool) -> WeldProgram:
    """Return a program with every tool pose replaced by ``FK_nominal(IK_identified(T))``.

    Parameters
    ----------
    program : WeldProgram
        With poses computed with the identified model of the robot, and their joints
        (`wpcal.controllers.followed_program.follow_program`).
    arm : ArmAtTool
        With an identified arm. A nominal one needs no compensation: the program is returned as it is.

    Returns
    -------
    WeldProgram
        With the poses to send to the controller, which computes with its nominal model.

    Raises
    ------
    InputError
        When the poses have no joints.
    """
    if arm.arm.nominal is None:
        return program
    safe = program.safe_point and _as_target(program.safe_point, arm)
    paths = tuple(
        _as_target(path, arm) if path.moves is None else _fitted_again(path, program, arm) for path in program.paths
    )
    return replace(program, paths=paths, safe_point=safe)


def _fitted_again(path: WeldPath, program: WeldProgram, arm: ArmAtTool) -> WeldPath:
    """Return lines and arcs between targets.

    The controller interpolates between the targets, so the lines and arcs are fitted to the targets of all frames of
    the seam. The tool keeps its turn about the wire.
    """
    targets = _as_target(path, arm)
    rows, frames, torch = path.weld_rows, path.seam.frames, program.torch
    _, R, frame, _ = path.stations()
    R = R[np.searchsorted(frame, np.arange(len(frames)))]
    wire = wire_directions(tool_rotations(frames.R, torch, path.seam.lean_rad), torch.tool_axis)
    R = exp_rotation(swings_between(wire_directions(R, torch.tool_axis), wire)) @ R
    T = np.tile(np.eye(4), (len(frames), 1, 1))
    T[:, :3, :3], T[:, :3, 3] = R, frames.p - (torch.stick_out_mm + path.seam.more_wire_mm) * wire
    assert path.joints is not None  # `_as_target` has refused a path without joints
    joints = follow_path(arm.arm, T @ arm.T_flange_tool.inverse().matrix, path.joints[rows.start])
    T = arm.arm.as_nominal().forward(joints) @ arm.T_flange_tool.matrix
    tolerance = program.tolerance or USUAL_TOLERANCE
    p, R = T[:, :3, 3], T[:, :3, :3]
    away = p + torch.stick_out_mm * wire_directions(R, torch.tool_axis) - frames.p
    headings = frames.R[:, :, 0] + np.gradient(away, frames.s_mm, axis=0)
    moves = fit_seam(path.seam, p, R, torch, tolerance, spin_is_free=False, headings=headings)
    along = [np.interp(moves.s_mm, frames.s_mm, column) for column in joints.T]
    new_joints = np.concatenate([path.joints[: rows.start], np.stack(along, axis=1), path.joints[rows.stop :]])
    return replace(
        targets,
        p_base=frozen(np.concatenate([targets.p_base[: rows.start], moves.p, targets.p_base[rows.stop :]])),
        R_base=frozen(np.concatenate([targets.R_base[: rows.start], moves.R, targets.R_base[rows.stop :]])),
        joints=frozen(new_joints),
        moves=moves,
    )


def _as_target(poses: Poses, arm: ArmAtTool) -> Poses:
    if poses.joints is None:
        raise InputError("the poses have no joints; follow the program with the arm first")
    T = arm.arm.as_nominal().forward(poses.joints) @ arm.T_flange_tool.matrix
    return replace(poses, p_base=frozen(T[:, :3, 3]), R_base=frozen(T[:, :3, :3]))
