"""The joints of an arm along a whole program: in one branch, within the limits, also on the ways between the seams.

All moves of a program but the first are linear. The arm therefore stays in one branch from the safe point to the safe
point, and its whole turns count on. Between two poses the tool is followed at small steps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.controllers.reachable_spin import ArmAtTool, point_name, spun_programs
from wpcal.core.arrays import FloatArray, IntArray, frozen
from wpcal.core.errors import ErrorCode, GeometryError
from wpcal.core.tangent import exp_rotation, log_rotation
from wpcal.robot.kinematics.branch_path import Broken, continue_branch

STEP_MM = 20.0
"""On a way of the torch an arm of a metre turns its joints by a degree or two per step."""
STEP_RAD = np.radians(5.0)
"""Turns of the tool are followed at this step for the same reason."""


@dataclass(frozen=True, slots=True, eq=False)
class _Leg:
    """Poses that are passed in linear moves, and what each of them is, for messages."""

    p: FloatArray
    R: FloatArray
    names: list[str]


def program_for_arm(
    program: WeldProgram, arm: ArmAtTool, *, check: Callable[[WeldProgram], WeldProgram]
) -> WeldProgram:
    """Return a program that an arm follows from start to end.

    Shoulder and elbow are as at the joints that the user states, and every joint is within one turn, where that is
    possible. Otherwise more turns are used, and other branches.

    Parameters
    ----------
    program : WeldProgram
        As `wpcal.controllers.program.build_program` made it.
    arm : ArmAtTool
    check : callable
        Adds the ways between the seams, as `wpcal.controllers.checked_program.check_program` does.

    Raises
    ------
    GeometryError
        When the arm cannot follow it in any branch (code ``joint-path``), or `check` refuses it.
    """
    try:
        return _first_branch(program, arm.within_one_turn(), check, as_near=True)
    except GeometryError as error:
        if error.code != ErrorCode.JOINT_PATH:
            raise
    return _first_branch(program, arm, check, as_near=False)


def _first_branch(
    program: WeldProgram, arm: ArmAtTool, check: Callable[[WeldProgram], WeldProgram], *, as_near: bool
) -> WeldProgram:
    refused: GeometryError | None = None
    for spun in spun_programs(program, arm, as_near=as_near):
        try:
            return follow_program(check(spun.program), arm, spun.branch)
        except GeometryError as error:
            if error.code != ErrorCode.JOINT_PATH:
                raise
            refused = refused or error
    raise refused or GeometryError("there is no seam to follow")


def follow_program(program: WeldProgram, arm: ArmAtTool, branch: int) -> WeldProgram:
    """Give every pose of a program the joints of the arm.

    Parameters
    ----------
    program : WeldProgram
        With the spin of `wpcal.controllers.reachable_spin`, and with or without the ways between the seams.
    arm : ArmAtTool
    branch : int
        As in `wpcal.robot.kinematics.opw.solve_opw`.

    Returns
    -------
    WeldProgram
        With `joints` at every pose.

    Raises
    ------
    GeometryError
        Where the arm cannot follow: at a joint limit, out of reach, or at a singularity. Its code is ``joint-path``.
    """
    joints, before = [], arm.near
    for leg in _legs(program):
        joints.append(_follow(leg, arm, branch, before))
        before = joints[-1][-1]
    if program.safe_point is None:
        return replace(
            program,
            arm=arm.arm,
            paths=tuple(replace(path, joints=frozen(q)) for path, q in zip(program.paths, joints, strict=True)),
        )
    (whole,) = joints
    ends = 1 + np.cumsum([len(path) for path in program.paths])
    parts = np.split(whole[1:-1], ends[:-1] - 1)
    return replace(
        program,
        arm=arm.arm,
        safe_point=replace(program.safe_point, joints=frozen(whole[:1])),
        paths=tuple(replace(path, joints=frozen(q)) for path, q in zip(program.paths, parts, strict=True)),
    )


def _legs(program: WeldProgram) -> Iterator[_Leg]:
    """Yield one leg per joint move: to each seam, or with a safe point to that only."""
    paths = [_Leg(path.p_base, path.R_base, _names(path)) for path in program.paths]
    safe = program.safe_point
    if safe is None:
        yield from paths
        return
    yield _Leg(
        np.concatenate([safe.p_base, *(leg.p for leg in paths), safe.p_base]),
        np.concatenate([safe.R_base, *(leg.R for leg in paths), safe.R_base]),
        ["the safe point", *(name for leg in paths for name in leg.names), "the way back to the safe point"],
    )


def _names(path: WeldPath) -> list[str]:
    rows = path.weld_rows
    name = path.seam.name
    along = [point_name(path, row) for row in range(path.weld_count)]
    return [*[f"the way to seam {name}"] * rows.start, *along, *[f"the way from seam {name}"] * (len(path) - rows.stop)]


def _follow(leg: _Leg, arm: ArmAtTool, branch: int, near: ArrayLike) -> FloatArray:
    p, R, rows = _densely(leg.p, leg.R)
    path = continue_branch(arm.arm, arm.branches(p, R)[:, branch], near)
    if isinstance(path, Broken):
        to = int(np.searchsorted(rows, path.row))
        x, y, z = p[path.row]
        place = f"{leg.names[to]}: " if rows[to] == path.row else f"{leg.names[to]}, on the move there: "
        raise GeometryError(
            f"{place}{arm.arm.name} cannot hold the torch at base {x:.1f}, {y:.1f}, {z:.1f} mm: {path.why}; all moves "
            "between the seams are linear, so the arm stays in one branch",
            code=ErrorCode.JOINT_PATH,
        )
    return np.asarray(path[rows], dtype=np.float64)


def _densely(p: FloatArray, R: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return poses at small steps, and the rows of the given ones in them."""
    turn = log_rotation(np.swapaxes(R[:-1], -1, -2) @ R[1:])
    steps = np.maximum(np.linalg.norm(np.diff(p, axis=0), axis=1) / STEP_MM, np.linalg.norm(turn, axis=1) / STEP_RAD)
    counts = np.maximum(np.ceil(steps), 1.0).astype(int)
    first = np.repeat(np.arange(len(counts)), counts)
    rows = np.concatenate([[0], np.cumsum(counts)])
    share = ((np.arange(len(first)) - rows[first]) / counts[first])[:, None]
    dense_p = p[first] + share * (p[first + 1] - p[first])
    dense_R = R[first] @ exp_rotation(share * turn[first])
    return np.concatenate([dense_p, p[-1:]]), np.concatenate([dense_R, R[-1:]]), rows
