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
from wpcal.controllers.program.few_moves import fit_program
from wpcal.controllers.program.reachable_spin import ArmAtTool, point_name, spun_programs
from wpcal.core.arrays import BoolArray, FloatArray, frozen
from wpcal.core.errors import ErrorCode, GeometryError
from wpcal.robot.kinematics.inverse import Broken, continue_branch
from wpcal.robot.moves import PathTolerance
from wpcal.robot.moves.sweep import poses_between

STEP_MM = 20.0  #: On a way of the torch an arm of a metre turns its joints by a degree or two per step.
STEP_RAD = np.radians(5.0)  #: Turns of the tool are followed at this step for the same reason.


@dataclass(frozen=True, slots=True, eq=False)
class _Leg:
    """Places that are passed one after another, what each of them is, for messages, and which of them are poses."""

    p: FloatArray
    R: FloatArray
    names: list[str]
    is_pose: BoolArray


def program_for_arm(
    program: WeldProgram,
    arm: ArmAtTool,
    *,
    check: Callable[[WeldProgram], WeldProgram],
    tolerance: PathTolerance | None = None,
) -> WeldProgram:
    """Return a program that an arm follows from start to end.

    Shoulder and elbow are as at the joints that the user states, and every joint is within one turn, where that is
    possible. Otherwise more turns are used, and other branches. With a tolerance the seams become lines and arcs: the
    fewest if the arm can turn the torch as they need it, else the fewest with a turn about the wire that the arm can
    make.

    Raises `GeometryError` when the arm cannot follow it in any branch (code ``joint-path``), or `check` refuses it.
    """

    def fit_and_check(spun: WeldProgram) -> WeldProgram:
        return check(fit_program(spun, tolerance, spin_is_free=False))

    ways = [(program, check if tolerance is None else fit_and_check)]
    if tolerance is not None:
        ways.insert(0, (fit_program(program, tolerance), check))
    tries = [(way, as_near) for way in ways for as_near in (True, False)]
    for (spun, finish), as_near in tries[:-1]:
        try:
            return _first_branch(spun, arm.within_one_turn() if as_near else arm, finish, as_near=as_near)
        except GeometryError as error:
            if error.code != ErrorCode.JOINT_PATH:
                raise
    (spun, finish), as_near = tries[-1]
    return _first_branch(spun, arm, finish, as_near=as_near)


def _first_branch(
    program: WeldProgram, arm: ArmAtTool, finish: Callable[[WeldProgram], WeldProgram], *, as_near: bool
) -> WeldProgram:
    refused: GeometryError | None = None
    for spun in spun_programs(program, arm, as_near=as_near):
        try:
            return follow_program(finish(spun.program), arm, spun.branch)
        except GeometryError as error:
            if error.code != ErrorCode.JOINT_PATH:
                raise
            refused = refused or error
    raise refused or GeometryError("there is no seam to follow")


def follow_program(program: WeldProgram, arm: ArmAtTool, branch: int) -> WeldProgram:
    """Give every pose of a program the joints of the arm. With `joints` at every pose.

    `program`: With the spin of `wpcal.controllers.program.reachable_spin`, and with or without the ways between the
    seams.

    Raises `GeometryError` where the arm cannot follow: at a joint limit, out of reach, or at a singularity. Its code is
    ``joint-path``.
    """
    joints, before = [], arm.near
    for leg in _legs(program):
        joints.append(_follow(leg, arm, branch, before))
        before = joints[-1][-1]
    safe = program.safe_point
    if safe is not None:
        (whole,) = joints
        joints = np.split(whole[1:-1], np.cumsum([len(path) for path in program.paths])[:-1])
        safe = replace(safe, joints=frozen(whole[:1]))
    paths = tuple(replace(path, joints=frozen(q)) for path, q in zip(program.paths, joints, strict=True))
    return replace(program, arm=arm.arm, safe_point=safe, paths=paths)


def _legs(program: WeldProgram) -> Iterator[_Leg]:
    """Yield one leg per joint move: to each seam, or with a safe point to that only."""
    paths = [_leg(path) for path in program.paths]
    safe = program.safe_point
    if safe is None:
        yield from paths
        return
    yield _Leg(
        np.concatenate([safe.p_base, *(leg.p for leg in paths), safe.p_base]),
        np.concatenate([safe.R_base, *(leg.R for leg in paths), safe.R_base]),
        ["the safe point", *(name for leg in paths for name in leg.names), "the way back to the safe point"],
        np.concatenate([[True], *(leg.is_pose for leg in paths), [True]]),
    )


def _leg(path: WeldPath) -> _Leg:
    rows, name = path.weld_rows, path.seam.name
    p, R, frame, is_pose = path.stations()
    before, after = rows.start, len(path) - rows.stop
    points = [point_name(path, row) for row in range(len(path.seam.frames))]
    along = [points[row] for row in np.ceil(frame).astype(int)]
    return _Leg(
        np.concatenate([path.p_base[: rows.start], p, path.p_base[rows.stop :]]),
        np.concatenate([path.R_base[: rows.start], R, path.R_base[rows.stop :]]),
        [*[f"the way to seam {name}"] * before, *along, *[f"the way from seam {name}"] * after],
        np.concatenate([np.ones(before, dtype=bool), is_pose, np.ones(after, dtype=bool)]),
    )


def _follow(leg: _Leg, arm: ArmAtTool, branch: int, near: ArrayLike) -> FloatArray:
    p, R, rows = poses_between(leg.p, leg.R, STEP_MM, STEP_RAD)
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
    return np.asarray(path[rows[leg.is_pose]], dtype=np.float64)
