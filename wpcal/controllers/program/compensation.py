"""Programs for an identified robot: targets with which the controller reaches the true poses."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TypeVar

import numpy as np

from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.few_moves import AXIS, seam_course
from wpcal.controllers.program.reachable_spin import ArmAtTool
from wpcal.core.arrays import frozen
from wpcal.core.errors import InputError
from wpcal.core.tangent import exp_rotation
from wpcal.robot.kinematics.inverse import follow_path
from wpcal.robot.moves import PathTolerance, fit_moves
from wpcal.robot.moves.fit import USUAL_TOLERANCE
from wpcal.robot.moves.interpolation import swings_between
from wpcal.robot.torch.attitude import wire_directions

TURN_RAD = math.radians(0.1)
"""How far the tool may be turned from the targets: a target that is turned is corrected by another amount, above all
near a straight wrist, where the axes turn fast."""
SHARE = 0.6  #: Of the tolerance, for distances between targets; the rest is for the turns.
STEP_MM = 0.5  #: Near a straight wrist an axis turns by 15 degrees in a millimetre, and the correction with it.
MOST_POINTS = 400  #: Of a seam: on long seams the correction changes more slowly.
Poses = TypeVar("Poses", WeldPath, SafePoint)


def compensate_program(program: WeldProgram, arm: ArmAtTool) -> WeldProgram:
    """Return a program with every tool pose replaced by ``FK_nominal(IK_identified(T))``.

    Raises `InputError` when the poses have no joints.

    `program`: With poses computed with the identified model of the robot, and their joints
    (`wpcal.controllers.program.followed_program.follow_program`).
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

    The controller interpolates between the targets, so the lines and arcs are fitted to the targets of many points of
    the seam. The tool keeps its turn about the wire.
    """
    targets, rows, torch = _as_target(path, arm), path.weld_rows, program.torch
    if path.moves is None or path.joints is None:
        return targets
    tolerance = program.tolerance or USUAL_TOLERANCE
    course = seam_course(path, torch, tolerance, max(STEP_MM, path.seam.length_mm / MOST_POINTS))
    _, R = path.moves.poses_at(course.s_mm)
    T = np.tile(np.eye(4), (len(R), 1, 1))
    T[:, :3, :3] = exp_rotation(swings_between(wire_directions(R, torch.tool_axis), course.wire)) @ R
    T[:, :3, 3] = course.p
    joints = follow_path(arm.arm, T @ arm.T_flange_tool.inverse().matrix, path.joints[rows.start])
    T = arm.arm.as_nominal().forward(joints) @ arm.T_flange_tool.matrix
    p, R = T[:, :3, 3], T[:, :3, :3]
    tip = p + torch.standoff_mm * wire_directions(R, torch.tool_axis)
    moves = fit_moves(
        p,
        R,
        s_mm=course.s_mm,
        headings=np.gradient(tip, course.s_mm, axis=0, edge_order=2),
        axis=AXIS[torch.tool_axis],
        standoff_mm=torch.standoff_mm,
        tolerance=PathTolerance(SHARE * tolerance.mm, TURN_RAD, TURN_RAD),
        spin_is_free=False,
    )
    along = np.stack([np.interp(moves.s_mm, course.s_mm, column) for column in joints.T], axis=1)
    return replace(
        targets,
        p_base=frozen(np.concatenate([targets.p_base[: rows.start], moves.p, targets.p_base[rows.stop :]])),
        R_base=frozen(np.concatenate([targets.R_base[: rows.start], moves.R, targets.R_base[rows.stop :]])),
        joints=frozen(np.concatenate([path.joints[: rows.start], along, path.joints[rows.stop :]])),
        moves=moves,
    )


def _as_target(poses: Poses, arm: ArmAtTool) -> Poses:
    if poses.joints is None:
        raise InputError("the poses have no joints; follow the program with the arm first")
    T = arm.arm.as_nominal().forward(poses.joints) @ arm.T_flange_tool.matrix
    return replace(poses, p_base=frozen(T[:, :3, 3]), R_base=frozen(T[:, :3, :3]))
