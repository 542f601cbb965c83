"""The turn about the wire that an arm can make: one branch of the arm, within its joint limits, without a jump.

Between two points of a seam the tool moves on a line, and on a line an arm cannot change its branch. For each of the
eight branches, dynamic programming over the points chooses the turn about the wire and the whole turns of the joints:
the tool turns least along the seam. Equal choices differ in how a seam begins (`Begin`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from itertools import product

import numpy as np

from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.controllers.program.few_moves import AXIS, spin_from_travel, with_moves
from wpcal.controllers.program.spin import START_COST, STEP_RAD, possible_offsets, spun, swing_and_twist
from wpcal.core.arrays import FloatArray, IntArray, frozen
from wpcal.core.errors import ErrorCode, GeometryError
from wpcal.core.ladder import cheapest_way
from wpcal.core.same_bits import poses
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import LARGEST_STEP_RAD, solve_inverse, turn_into_limits, with_whole_turns
from wpcal.robot.torch.attitude import ToolAxis, TorchSettings, tool_rotations


class Begin(Enum):
    """Which of the equal turns about the wire a seam begins with, in the order in which they are tried."""

    NEAR = "near the joints that the user states: the seams are then welded alike"
    BEFORE = "near the joints at the end of the seam before"
    TRAVEL = "near the direction of travel"


@dataclass(frozen=True, slots=True, eq=False)
class ArmAtTool:
    """An arm with the tool as set in the controller, and where it starts."""

    arm: Arm
    T_flange_tool: RigidTransform
    near: FloatArray  #: shape (6,). Shown joint angles near the seams, rad.

    def within_one_turn(self) -> ArmAtTool:
        """Return the arm with limits of at most ±180°: cables wind less, and every language can state such joints."""
        joints = [
            replace(joint, min_rad=max(joint.min_rad, -np.pi), max_rad=min(joint.max_rad, np.pi))
            for joint in self.arm.joints
        ]
        return replace(self, arm=replace(self.arm, joints=tuple(joints)))

    def branches(self, p: FloatArray, R: FloatArray) -> FloatArray:
        """Return the angles of all branches for tools at p (..., 3), mm, with axes R (..., 3, 3); shape (..., 8, 6)."""
        flange = poses(R, p).reshape(-1, 4, 4) @ self.T_flange_tool.inverse().matrix
        joints = solve_inverse(self.arm, flange).joints
        return joints.reshape(*R.shape[:-2], *joints.shape[1:])


WRIST_BITS = 1  #: Of the number of a branch the lowest bit is the wrist; the others are elbow and shoulder.
WHOLE_TURNS = 1e-3
"""Share of the move of the joints in the cost where the travel decides: enough to choose between whole turns."""


@dataclass(frozen=True, slots=True, eq=False)
class SpunProgram:
    """A program whose torch an arm can hold along every seam, in one branch."""

    program: WeldProgram
    branch: int  #: As in `wpcal.robot.kinematics.opw.solve_opw`.


@dataclass(frozen=True, slots=True, eq=False)
class _Stop:
    """How far a branch gets: number of the seam, number of the point, and the reason."""

    seam: int
    row: int
    why: str


def spun_programs(program: WeldProgram, arm: ArmAtTool, *, as_near: bool = False) -> Iterator[SpunProgram]:
    """Yield programs per branch that leads along every seam, the nearest branch first.

    Raises `GeometryError` when there is none, with the seam, the point, its place in mm and the reason; its code is
    ``joint-path``.
    """
    seams = [_Seam.of(path, program, arm) for path in program.paths]
    stops, found = [], False
    for branch, begin in product(_nearest_branches(seams[0], arm, as_near=as_near) if seams else (), Begin):
        before, paths = arm.near, []
        for number, seam in enumerate(seams):
            chosen = seam.choose(arm, branch, arm.near if begin is Begin.NEAR else before, begin)
            if isinstance(chosen, _Stop):
                stops.append(replace(chosen, seam=number))
                break
            rows, before = chosen
            paths.append(seam.spun(rows, program.torch.tool_axis))
        else:
            found = True
            yield SpunProgram(replace(program, paths=tuple(paths)), branch)
    if not found and seams:
        furthest = max(stops, key=lambda stop: (stop.seam, stop.row))
        path = program.paths[furthest.seam]
        raise GeometryError(
            f"{point_name(path, furthest.row)}: no turn about the wire is possible for {arm.arm.name}: {furthest.why}",
            code=ErrorCode.JOINT_PATH,
        )


def point_name(path: WeldPath, row: int) -> str:
    """Name a frame of a seam with its place: along the seam and in the base, mm."""
    p, _, frame, _ = path.stations()
    x, y, z = p[np.searchsorted(frame, row)]
    frames = path.seam.frames
    return (
        f"seam {path.seam.name}: point {row}, {frames.s_mm[row] - frames.s_mm[0]:.1f} mm along it, "
        f"base {x:.1f}, {y:.1f}, {z:.1f} mm"
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Seam:
    """Every turn about the wire at every point of a seam, and the joints of all branches there.

    `every` has shape (n, k, 3, 3), `e` (n, k), rad, `joints` (n, k, 8, 6), `ends` (2, k, 8, 6), `swing` (n - 1,), rad,
    `frame` (n,): the seam's frame at each point, or the next one. Lines and arcs turn the tool as they are: they have
    the same turn about the wire, one column, at every point (`is_one_turn`).
    """

    path: WeldPath
    every: FloatArray
    e: FloatArray
    swing: FloatArray
    joints: FloatArray
    ends: FloatArray
    frame: IntArray
    is_one_turn: bool

    @classmethod
    def of(cls, path: WeldPath, program: WeldProgram, arm: ArmAtTool) -> _Seam:
        torch, rows = program.torch, path.weld_rows
        if path.moves is not None:
            return cls._of_moves(path, torch, arm)
        R = tool_rotations(path.seam.frames.R, torch, path.seam.lean_rad, path.seam.spin_rad)
        swing, twist = swing_and_twist(R, torch.tool_axis)
        free = -np.concatenate([[0.0], np.cumsum(twist)])
        e = possible_offsets(free, torch.spin_range_rad)
        every = spun(R[:, None], free[:, None] + e, torch.tool_axis)
        joints = arm.branches(path.p_base[rows][:, None], every)
        ends = arm.branches(path.p_base[[rows.start - 1, rows.stop]][:, None], every[[0, -1]])
        return cls(path, every, e, swing, joints, ends, np.arange(len(R)), is_one_turn=False)

    @classmethod
    def _of_moves(cls, path: WeldPath, torch: TorchSettings, arm: ArmAtTool) -> _Seam:
        p, R, frame, _ = path.stations()
        most, now = torch.spin_range_rad, spin_from_travel(path, torch)
        e = np.arange(-np.pi, np.pi, STEP_RAD)
        e = e[np.argsort(np.abs(e), kind="stable")]
        whole = most >= np.pi
        e = np.concatenate([[0.0], e[1:] if whole else e[np.abs(now[:, None] + e).max(axis=0) <= most]])
        every = spun(R[:, None], np.broadcast_to(e, (len(R), len(e))), torch.tool_axis)
        ends = arm.branches(path.p_base[[path.weld_rows.start - 1, path.weld_rows.stop]][:, None], every[[0, -1]])
        joints = arm.branches(p[:, None], every)
        all_e, swing = np.tile(e, (len(R), 1)), np.zeros(len(R) - 1)
        return cls(path, every, all_e, swing, joints, ends, np.ceil(frame).astype(np.int64), is_one_turn=True)

    def spun(self, columns: IntArray, axis: ToolAxis) -> WeldPath:
        """Return the path with the chosen turns about the wire."""
        if self.path.moves is not None:
            return with_moves(self.path, self.path.moves.turned_about(AXIS[axis], float(self.e[0, columns[0]])))
        along = self.every[np.arange(len(columns)), columns]
        return replace(self.path, R_base=frozen(np.concatenate([along[:1], along, along[-1:]])))

    def choose(
        self, arm: ArmAtTool, branch: int, near: FloatArray, begin: Begin
    ) -> tuple[IntArray, FloatArray] | _Stop:
        """Return the column of `e` per point and the joints at the end; or where the branch stops."""
        ends = turn_into_limits(arm.arm, self.ends[:, :, branch], near)
        held = np.asarray(np.isfinite(ends).all(axis=2), dtype=np.bool_)
        states = [_states(arm.arm, row[:, branch]) for row in self.joints]
        for row, end in ((0, 0), (-1, 1)):
            columns, q = states[row]
            keep = held[end][columns]
            states[row] = columns[keep], q[keep]
        columns, q = states[0]
        away = np.abs(q - near).max(axis=1)
        first = START_COST * (away if begin is not Begin.TRAVEL else np.abs(self.e[0, columns]) + WHOLE_TURNS * away)

        def step(i: int, now: IntArray, before: IntArray) -> FloatArray:
            (at, q), (came, q_before) = (
                (columns[own], q[own]) for (columns, q), own in ((states[i], now), (states[i - 1], before))
            )
            total = np.hypot(self.swing[i - 1], self.e[i, at][:, None] - self.e[i - 1, came])
            is_jump = np.abs(q[:, None] - q_before).max(axis=2) > LARGEST_STEP_RAD
            return np.where(is_jump | (self.is_one_turn & (at[:, None] != came)), np.inf, total)

        way = cheapest_way([first, *(np.zeros(len(columns)) for columns, _ in states[1:])], step)
        if (row := len(way)) < len(states):
            why = "the arm would have to change its branch between this point and the one before"
            if not len(states[row][0]):
                why = _why_not(arm.arm, self.joints[row, :, branch], np.abs(self.e[row]))
            return _Stop(0, int(self.frame[row]), why)
        return np.array([columns[row] for (columns, _), row in zip(states, way, strict=True)]), states[-1][1][way[-1]]


def _states(arm: Arm, q: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the columns that are reached, with every number of whole turns within the limits, and their joints."""
    columns = np.flatnonzero(np.isfinite(q).all(axis=1))
    rows, turned = with_whole_turns(q[columns], *arm.limits)
    return columns[rows], turned


def _why_not(arm: Arm, q: FloatArray, spin_rad: FloatArray) -> str:
    """Say why a branch holds none of the turns at a point: q (k, 6), the nearest to the travel first by `spin_rad`."""
    reached = np.isfinite(q).all(axis=1)
    if not reached.any():
        return "it is out of reach"
    nearest = np.flatnonzero(reached)[np.argmin(spin_rad[reached])]
    turned = turn_into_limits(arm, q[nearest], np.zeros(q.shape[1]))
    names = [joint.name for joint, angle in zip(arm.joints, turned, strict=True) if not np.isfinite(angle)]
    return f"joint {' and '.join(names)} is beyond its limit" if names else "its approach or retract is out of reach"


def _nearest_branches(seam: _Seam, arm: ArmAtTool, *, as_near: bool) -> list[int]:
    """Return the branches: those with shoulder and elbow as at `near` first, then by the move to the first point."""
    q = turn_into_limits(arm.arm, seam.joints[0], arm.near)
    move = np.abs(q - arm.near).max(axis=2)
    least = np.where(np.isfinite(move), move, np.inf).min(axis=0)
    own = turn_into_limits(arm.arm, solve_inverse(arm.arm, arm.arm.forward(arm.near[None])).joints[0], arm.near)
    away = np.where(np.isfinite(own), np.abs(own - arm.near), np.inf).max(axis=1)
    others = np.array([((branch ^ int(np.argmin(away))) >> WRIST_BITS).bit_count() for branch in range(len(own))])
    return [int(branch) for branch in np.lexsort((least, others)) if not (as_near and others[branch])]
