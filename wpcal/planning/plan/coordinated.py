"""A run of both robots in coordinated motion: the torch on few lines and arcs in the part, the part in few moves.

A controller that coordinates two robots keeps the torch on its line or arc in the frame of the part while robot 2 moves
the part. Both robots begin and end a move together, and are at the same share of it at the same time. The deviation
from the seam is therefore that of the lines and arcs alone. The joints between the marks are others than those of the
plan: they are computed here as the controller computes them, and checked again.

Also here: how robot 2 turns the part while the torch makes one move: a few moves near its planned path.

In coordinated motion the torch keeps to its line or arc in the part, whatever robot 2 does. The moves of robot 2 decide
where the weld is in space: they have to keep the weld position, and to stay near the path that was checked.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray, frozen, numbered_rows
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.same_bits import poses, product
from wpcal.core.tangent import exp_rotation, log_rotation
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.closed_chain import SeamPath
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.plan.plan import CollisionVerdict
from wpcal.planning.plan.recheck import PathCheck, check_path
from wpcal.planning.plan.run import CellRun, away_along_wire
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import TURN, follow_path, nearest_joints
from wpcal.robot.moves import Arc, MovePath, PathTolerance, fit_moves
from wpcal.robot.moves.interpolation import turns_between

MOST_POINTS = 15
"""Planned points at which a move is compared: the largest difference is measured everywhere afterwards."""
CHUNK = 200_000  #: Compared points in one array: some 60 MB.


class HolderMove(Enum):
    """How robot 2 moves from mark to mark."""

    JOINTS = "joints"  #: All joints evenly.
    LINE = "line"  #: The origin of the part on a straight line, and the part about one axis.


@dataclass(frozen=True, slots=True)
class HolderTolerance:
    """How far robot 2 may be from its planned path."""

    rad: float = math.radians(1.0)  #: Attitude of the part. 1 degree of slope does not change a weld.
    #: Place of the weld point. The moves are checked for collisions again; more would be another plan.
    mm: float = 10.0


@dataclass(frozen=True, slots=True, eq=False)
class HolderPath:
    """The planned path of robot 2."""

    cell: Cell
    s_mm: FloatArray  #: shape (n,). Length along the seam at the planned points, mm.
    joints: FloatArray  #: shape (n, 6). Shown angles of robot 2 there, rad, unwrapped.
    p_part: FloatArray  #: shape (n, 3). The weld points in `part`, mm.
    kind: HolderMove = HolderMove.JOINTS
    tolerance: HolderTolerance = HolderTolerance()

    def joints_at(self, s_mm: FloatArray) -> FloatArray:
        """Return the planned angles at lengths of shape (m,); shape (m, 6), rad."""
        return np.stack([np.interp(s_mm, self.s_mm, column) for column in self.joints.T], axis=1)

    def joints_between(self, s0: float, s1: float, share: FloatArray) -> FloatArray:
        """Return the angles in the move from s0 to s1 at shares of shape (m,); shape (m, 6), rad.

        Raises `GeometryError` when robot 2 cannot make the move.
        """
        ends = self.joints_at(np.array([s0, s1]))
        even = np.asarray(ends[0] + share[:, None] * (ends[1] - ends[0]), dtype=np.float64)
        if self.kind is HolderMove.JOINTS:
            return even
        start, end = np.split(self.cell.held_places(ends), 2)
        T = _on_line(start, end, share)
        flange = product(product(self.cell.T_world_base2.inverse().matrix, T), self.cell.T_part.inverse().matrix)
        return nearest_joints(self.cell.arm2, flange, even)

    def is_near(self, s0: FloatArray, s1: FloatArray) -> BoolArray:
        """Tell for moves between lengths whether robot 2 stays near its planned path.

        `s0`, `s1`: shape (m,). Where the moves begin and end, mm.
        """
        worst = np.zeros(len(s0))
        first, last = np.searchsorted(self.s_mm, s0, side="right"), np.searchsorted(self.s_mm, s1, side="left")
        inner = np.maximum(last - first, 0)
        taken = np.minimum(inner, MOST_POINTS)
        for part in np.array_split(np.arange(len(s0)), max(1, math.ceil(taken.sum() / CHUNK))):
            row, number = numbered_rows(taken[part])
            own = part[row]
            at = first[own] + ((number + 1) * (inner[own] + 1)) // (taken[own] + 1) - 1
            np.maximum.at(worst, own, self._shares(s0[own], s1[own], at))
        return np.asarray(worst <= 1.0, dtype=np.bool_)

    def _shares(self, s0: FloatArray, s1: FloatArray, at: IntArray) -> FloatArray:
        """Return how far moves are from planned points, in shares of the tolerance; to first order for joints."""
        share = (self.s_mm[at] - s0) / (s1 - s0)
        q0, q1 = self.joints_at(s0), self.joints_at(s1)
        if self.kind is HolderMove.JOINTS:
            J = self.cell.arm2.jacobian(self.joints, point=self.cell.T_part.apply(self.p_part).T)
            moved = np.einsum("kij,kj->ki", J[at], q0 + share[:, None] * (q1 - q0) - self.joints[at])
            turned, off = moved[:, :3], moved[:, 3:]
        else:
            T = _on_line(self.cell.held_places(q0), self.cell.held_places(q1), share)
            turned, off = differences(T, self.cell.held_places(self.joints)[at], self.p_part[at])
        return np.asarray(
            np.maximum(
                np.linalg.norm(turned, axis=1) / self.tolerance.rad, np.linalg.norm(off, axis=1) / self.tolerance.mm
            )
        )


def differences(T: FloatArray, T_planned: FloatArray, p_part: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how poses of the part differ from planned ones.

    `T`, `T_planned`: shape (m, 4, 4). In one frame, mm.
    `p_part`: shape (m, 3). A point of the part for each, mm.
    Returns `turned, off`: ndarray, shape (m, 3). Rotation vectors, rad, and what the points are off, mm.
    """
    turned = log_rotation(product(T[:, :3, :3], np.swapaxes(T_planned[:, :3, :3], 1, 2)))
    gap = T - T_planned
    return turned, np.einsum("nij,nj->ni", gap[:, :3, :3], p_part) + gap[:, :3, 3]


def _on_line(T0: FloatArray, T1: FloatArray, share: FloatArray) -> FloatArray:
    """Return poses on the way from T0 to T1, both of shape (m, 4, 4) or (1, 4, 4): a line, and one axis."""
    turn = turns_between(T0[:, :3, :3], T1[:, :3, :3])
    R = product(exp_rotation(share[:, None] * turn), T0[:, :3, :3])
    return poses(R, T0[:, :3, 3] + share[:, None] * (T1[:, :3, 3] - T0[:, :3, 3]))


STEP_MM = 1.0
"""Between computed states of the torch along the seam: joints interpolated between them are off by micrometres."""
STEP_RAD = math.radians(2.0)  #: The same for turns of the part or the torch.
REFINE = 2  #: Parts into which these steps are divided for the check, which halves them further where bodies move far.
LARGEST_STEP_RAD = math.radians(20.0)
"""Of a joint in one step: more is a change of the branch, or a pose that is nearly singular."""


@dataclass(frozen=True, slots=True, eq=False)
class CoordinatedRun:
    """A run in coordinated motion."""

    run: CellRun  #: The planned run.
    cell: Cell
    moves: MovePath  #: The torch in `part`, k poses.
    holder: HolderMove  #: How robot 2 moves from mark to mark.
    #: `joints1`, `joints2`: shape (k, 6). Shown angles at the poses, rad.
    joints1: FloatArray
    joints2: FloatArray
    #: `approach`, `retract`: shape (6,). Angles of robot 1 where the straight way to the seam begins and that from it
    #: ends; robot 2 does not move there. None: the run begins or ends on the seam.
    approach: FloatArray | None
    retract: FloatArray | None
    q: FloatArray  #: shape (N, 12). All axes at states with small steps, from the approach to the retract.
    check: PathCheck  #: Of these states.
    #: `part_turned_rad`, `part_off_mm`: Largest difference of the part from its planned path: its attitude, and the
    #: place of the weld point.
    part_turned_rad: float
    part_off_mm: float


@dataclass(frozen=True, slots=True)
class _Attempt:
    """What may be different from the plan: the turn of the torch about the wire, and the path of robot 2."""

    spin_is_free: bool
    holder: HolderTolerance


ATTEMPTS = (
    _Attempt(True, HolderTolerance()),
    _Attempt(False, HolderTolerance()),
    _Attempt(False, HolderTolerance(HolderTolerance().rad / 4.0, HolderTolerance().mm / 10.0)),
)
"""In the order of the number of moves: the first that is free is taken."""


def coordinate_run(
    run: CellRun,
    cell: Cell,
    path: SeamPath,
    *,
    holder: HolderMove = HolderMove.JOINTS,
    arcs: bool = True,
    tolerance: PathTolerance | None = None,
) -> CoordinatedRun:
    """Return a run with the fewest common moves of both robots that keep to the seam and to the planned positions.

    Raises `InputError` when no such motion is free, within the joint limits and within the joint speeds.
    """
    reason = ""
    for attempt in ATTEMPTS:
        part = HolderPath(cell, run.plan.s_mm, run.plan.q[:, JOINTS:], path.p, holder, attempt.holder)
        try:
            found = _coordinated(run, path, part, tolerance or PathTolerance(), attempt.spin_is_free, arcs=arcs)
        except GeometryError as error:
            reason = str(error)
            continue
        if found.check.verdict is CollisionVerdict.FREE:
            return found
        reason = found.check.describe()
    raise InputError(f"seam {run.plan.seam}: no coordinated motion near the plan is free: {reason}")


def _coordinated(
    run: CellRun, path: SeamPath, part: HolderPath, tolerance: PathTolerance, spin_is_free: bool, *, arcs: bool
) -> CoordinatedRun:
    plan, cell = run.plan, part.cell
    T = cell.tool_in_part(plan.q)
    moves = fit_moves(
        T[:, :3, 3],
        T[:, :3, :3],
        s_mm=plan.s_mm,
        headings=path.R[:, :, 0],
        tolerance=tolerance,
        spin_is_free=spin_is_free,
        arcs=arcs,
        also=part.is_near,
    )
    places = _Places.along(moves, part)
    joints2 = places.holder_joints(moves, part)
    joints1 = places.torch_joints(moves, cell, joints2, plan.q[0, :JOINTS])
    _require_speeds(run, cell, np.concatenate([joints1, joints2], axis=1), places.s_mm)
    T_planned = cell.held_places(part.joints_at(places.s_mm))
    p_part = np.stack([np.interp(places.s_mm, plan.s_mm, column) for column in path.p.T], axis=1)
    turned, off = differences(cell.held_places(joints2), T_planned, p_part)
    before = away_along_wire(cell, np.concatenate([joints1[0], joints2[0]]))[::-1]
    after = away_along_wire(cell, np.concatenate([joints1[-1], joints2[-1]]))
    rows = np.clip(np.arange(len(before) + len(joints1) + len(after)) - len(before), 0, len(joints1) - 1)
    turns = [
        _whole_turns(arm, q) for arm, q in ((cell.arm, np.concatenate([before, joints1, after])), (cell.arm2, joints2))
    ]
    joints1, joints2, before, after = joints1 + turns[0], joints2 + turns[1], before + turns[0], after + turns[0]
    q = np.concatenate([np.concatenate([before, joints1, after]), joints2[rows]], axis=1)
    return CoordinatedRun(
        run=run,
        cell=cell,
        moves=moves,
        holder=part.kind,
        joints1=frozen(joints1[places.stated]),
        joints2=frozen(joints2[places.stated]),
        approach=before[0] if len(before) else None,
        retract=after[-1] if len(after) else None,
        q=q,
        check=check_path(q, places.s_mm[rows], cell, refine=REFINE),
        part_turned_rad=float(np.linalg.norm(turned, axis=1).max()),
        part_off_mm=float(np.linalg.norm(off, axis=1).max()),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Places:
    """Where the states of a run are: the move of each, the share of it, the length along the seam."""

    move: IntArray  #: shape (m,).
    #: `share`, `s_mm`: shape (m,).
    share: FloatArray
    s_mm: FloatArray
    stated: IntArray  #: shape (k,). The states at the poses of the moves.

    @classmethod
    def along(cls, moves: MovePath, part: HolderPath) -> _Places:
        """Return the ends of all moves, the middles of arcs, and small steps between them."""
        ends = moves.s_mm[moves.ends]
        turn = np.linalg.norm(moves.arrays.turn, axis=1) + np.abs(np.diff(part.joints_at(ends), axis=0)).sum(axis=1)
        counts = np.maximum(np.ceil(np.maximum(np.diff(ends) / STEP_MM, turn / STEP_RAD)), 2).astype(np.int64)
        own: list[FloatArray] = []
        stated = [0]
        for number, (move, count) in enumerate(zip(moves.moves, counts.tolist(), strict=True)):
            share = np.arange(count) / count
            begin = sum(len(one) for one in own)
            if isinstance(move, Arc):
                middle = moves.arrays.select(np.array([number])).shares(moves.p[move.via][None])
                share = np.union1d(share, middle)
                stated.append(begin + int(np.searchsorted(share, middle[0])))
            own.append(share)
            stated.append(begin + len(share))
        row = np.concatenate([*(np.full(len(one), number) for number, one in enumerate(own)), [len(own) - 1]])
        share = np.concatenate([*own, [1.0]])
        s = ends[row] + share * (ends[row + 1] - ends[row])
        return cls(row, share, s, np.array(stated, dtype=np.int64))

    def holder_joints(self, moves: MovePath, part: HolderPath) -> FloatArray:
        """Return the angles of robot 2 at all states, shape (m, 6), rad."""
        ends = moves.s_mm[moves.ends]
        found = [
            part.joints_between(ends[number], ends[number + 1], self.share[self.move == number])
            for number in range(len(moves.moves))
        ]
        return np.concatenate(found)

    def torch_joints(self, moves: MovePath, cell: Cell, joints2: FloatArray, near: FloatArray) -> FloatArray:
        """Return the angles of robot 1 at all states, shape (m, 6), rad.

        Raises `GeometryError` when the arm does not reach a state, or changes its branch.
        """
        at = moves.arrays.select(self.move)
        T = poses(at.rotations(self.share), at.positions(self.share))
        tool = product(cell.T_world_base.inverse().matrix, product(cell.held_places(joints2), T))
        joints1 = follow_path(cell.arm, product(tool, cell.T_flange_tool.inverse().matrix), near)
        steps = np.abs(np.diff(joints1, axis=0))
        if steps.max(initial=0.0) > LARGEST_STEP_RAD:
            row, joint = np.unravel_index(int(np.argmax(steps)), steps.shape)
            what = f"joint {cell.arm.joints[joint].name} of robot 1 jumps by {math.degrees(steps.max()):.0f} deg"
            raise GeometryError(f"{what} at s = {self.s_mm[row]:.1f} mm")
        return joints1


def _whole_turns(arm: Arm, joints: FloatArray) -> FloatArray:
    """Return whole turns to be added to joints so that they are as near to zero as possible: the poses stay the same.

    `joints`: shape (m, 6). Shown angles along a run, rad.
    Returns ndarray, shape (6,). Multiples of a turn, rad; 0 where the limits do not allow it for the whole run.
    """
    low, high = arm.limits
    least, most = joints.min(axis=0), joints.max(axis=0)
    turn = -TURN * np.rint((least + most) / (2.0 * TURN))
    if len(arm.couplings):  # a turn of one shown joint is not a turn of one axis
        return np.zeros(joints.shape[1])
    return np.where((least + turn >= low) & (most + turn <= high), turn, 0.0)


def _require_speeds(run: CellRun, cell: Cell, joints: FloatArray, s_mm: FloatArray) -> None:
    """Refuse a motion in which a joint would be faster than it can be.

    Raises `GeometryError` with the joint and the place.
    """
    step = np.diff(s_mm)
    rate = np.abs(np.diff(joints, axis=0)) * (run.schedule.speed_mm_s / np.where(step > 0.0, step, np.inf))[:, None]
    share = rate / cell.speeds
    if share.max(initial=0.0) > 1.0:
        row, column = np.unravel_index(int(np.argmax(share)), share.shape)
        robot, name = cell.joint_of(int(column))
        what = f"joint {name} of robot {robot} would need {100.0 * share.max():.0f} % of its speed"
        raise GeometryError(f"{what} at s = {s_mm[row]:.1f} mm")
