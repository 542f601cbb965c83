"""Programs for an identified robot: targets with which the controller reaches the true poses."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.reachable_spin import ArmAtTool
from wpcal.core.arrays import frozen
from wpcal.core.errors import InputError

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
    return replace(program, paths=tuple(_as_target(path, arm) for path in program.paths), safe_point=safe)


def _as_target(poses: Poses, arm: ArmAtTool) -> Poses:
    if poses.joints is None:
        raise InputError("the poses have no joints; follow the program with the arm first")
    T = arm.arm.as_nominal().forward(poses.joints) @ arm.T_flange_tool.matrix
    return replace(poses, p_base=frozen(T[:, :3, 3]), R_base=frozen(T[:, :3, :3]))
