"""Programs for an identified robot: targets with which the controller reaches the true poses."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.core.errors import GeometryError
from wpcal.core.transform import RigidTransform
from wpcal.robot.compensation import NO_TOOL, compensate_targets
from wpcal.robot.kinematics.arm import Arm


def compensate_program(
    program: WeldProgram, arm: Arm, *, near: ArrayLike, T_flange_tool: RigidTransform = NO_TOOL
) -> WeldProgram:
    """Return a program with every tool pose replaced by ``FK_nominal(IK_identified(T))``.

    Parameters
    ----------
    program : WeldProgram
        With poses computed with the identified model of the robot.
    arm : Arm
        An identified arm.
    near : array_like, shape (n,)
        Shown joint angles near the seam, rad. They select the arm's configuration.
    T_flange_tool : RigidTransform
        The tool as set in the controller.

    Returns
    -------
    WeldProgram
        With the poses to send to the controller, which computes with its nominal model.

    Raises
    ------
    InputError
        When the arm is not identified.
    GeometryError
        When a pose is out of reach or beyond a joint limit.
    """
    paths = [_compensated(path, arm, near, T_flange_tool) for path in program.paths]
    safe = program.safe_point and _compensated(program.safe_point, arm, near, T_flange_tool)
    return replace(program, paths=tuple(paths), safe_point=safe)


Poses = TypeVar("Poses", WeldPath, SafePoint)


def _compensated(path: Poses, arm: Arm, near: ArrayLike, T_flange_tool: RigidTransform) -> Poses:
    T_base_tool = np.tile(np.eye(4), (len(path.p_base), 1, 1))
    T_base_tool[:, :3, :3], T_base_tool[:, :3, 3] = path.R_base, path.p_base
    try:
        targets, _ = compensate_targets(arm, T_base_tool, near=near, T_flange_tool=T_flange_tool)
    except GeometryError as error:
        name = f"seam {path.seam.name}" if isinstance(path, WeldPath) else "the safe point"
        raise GeometryError(
            f"{name}: {error}; the ways to and from a seam count as poses, too (--clearance-mm)"
        ) from None
    return replace(path, p_base=targets[:, :3, 3], R_base=targets[:, :3, :3])
