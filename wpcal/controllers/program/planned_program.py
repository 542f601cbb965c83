"""The weld program of a plan: paths with the planned joints, and the moves between them.

Approach, weld and retract are lines and arcs to poses, each with the joints and the external axes that the plan has
there. Between them are joint moves, as they were checked against collision.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from wpcal.controllers.program import ControllerSettings, MotionSettings, WeldPath, WeldProgram
from wpcal.controllers.program.arc import ArcSettings
from wpcal.controllers.program.describe import UNCHECKED
from wpcal.controllers.program.planned import ALONE, JointMoves, PlannedMoves
from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.core.same_bits import poses
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.sequence.kept_plan import KeptPiece, KeptPlan
from wpcal.planning.sequence.sequence_input import PlannedSeam
from wpcal.planning.sequence.weld_sequence import AIR_SHARE, Way
from wpcal.robot.kinematics.inverse import TURN, own_branch
from wpcal.robot.moves import PathTolerance, fit_moves
from wpcal.robot.moves.fit import USUAL_TOLERANCE
from wpcal.seam.seam import SeamFrames

WITHOUT_FRAME = 0  #: The number of the user frame that is the base of the robot.
NARROWER = (1.0, 0.25, 0.0625)
"""Shares of the tolerance that are tried: half a degree moves the body of a torch by 3 mm, as much as its room."""


@dataclass(frozen=True, slots=True)
class PlanOutput:
    """How a plan becomes programs."""

    #: Of lines and arcs; None for a line to every point of the seams.
    tolerance: PathTolerance | None = USUAL_TOLERANCE
    controller: ControllerSettings = field(default_factory=ControllerSettings)
    arc: ArcSettings | None = None  #: How the arc is switched; None for a dry run.
    #: The record of ``calibration.json``; empty without a calibration.
    calibration: Mapping[str, Any] = field(default_factory=dict)
    has_part: bool = True  #: Whether the moves were compared with the part.
    #: Where the positioner turns along a seam: whether positions are in the part that it carries, and moves may be arcs
    #: (`PlannedMoves.is_carried`).
    is_carried: bool = True
    #: From poses (m, 4, 4), points on the arcs between them (m - 1, 3) and axes (m, k) to whether the moves are free.
    is_free: Callable[[FloatArray, FloatArray, FloatArray], bool] | None = None
    #: From states of a row of joint moves, shape (m, k), to the zones at their ends: mm and shares, shapes (m,).
    zones: Callable[[FloatArray], tuple[FloatArray, FloatArray]] | None = None


def build_planned_program(
    plan: KeptPlan, seams: Mapping[str, PlannedSeam], output: PlanOutput | None = None
) -> WeldProgram:
    """Return the weld program of a plan. Raises `InputError` when a move is not free."""
    if not plan.is_free:
        raise InputError("no program is written for a plan that is not free of collision")
    output = output or PlanOutput()
    cell = plan.cell
    turning = cell.axis_names[cell.first_turning :]
    controller = replace(output.controller, frame_number=WITHOUT_FRAME) if turning else output.controller
    follows = any(np.ptp(piece.q[:, cell.first_turning :], axis=0).any() for piece in plan.pieces)
    frame = _Frame(cell, follows=follows, is_carried=output.is_carried)
    paths = tuple(_path(plan, piece, seams[piece.task.name], output, frame) for piece in plan.pieces)
    air = tuple(_moves_to(q, output).rows(0 if row == 0 else 1, None) for row, q in enumerate(plan.air))
    ways = tuple(_way(way, output) for way in plan.ways)
    rail = None if cell.rail_axis is None else cell.axis_names[cell.rail_axis]
    about = _about(plan, rail)
    share = 100.0 * AIR_SHARE
    planned = PlannedMoves(air, rail, turning, cell.T_flange_tool, share, about, ways, follows, output.is_carried)
    motion = MotionSettings(plan.approach_mm, plan.approach_mm, plan.speed_mm_s, plan.air_speed_mm_s)
    checked = [f"checked against collision: all moves between home and home: {plan.checked}"]
    checked += [] if output.has_part else [f"{UNCHECKED}: its shape was not beside the seams (part.glb)"]
    return WeldProgram(
        paths,
        frame.T_base_part,
        motion=motion,
        controller=controller,
        calibration=dict(output.calibration),
        checked=tuple(checked),
        arm=cell.arm,
        tolerance=output.tolerance if any(path.moves is not None for path in paths) else None,
        arc=output.arc,
        planned=planned,
    )


def _about(plan: KeptPlan, rail: str | None) -> tuple[str, ...]:
    cell = plan.cell
    tool = cell.T_flange_tool
    place = ", ".join(f"{value:.3f}" for value in tool.t_mm)
    axis = ", ".join(f"{value:.4f}" for value in tool.R[:, 2])
    lines = [
        f"cell {cell.name}, robot {cell.arm.name}; {len(plan.pieces)} runs, {plan.welded_mm:.0f} mm",
        f"tool centre point in the flange: {place} mm; the wire is along z of the tool, {axis} in the flange",
    ]
    lines += [f"NOT WELDED: {seam} from {start:.0f} to {end:.0f} mm" for seam, start, end in plan.not_welded]
    closed = [piece.name for piece, way in zip(plan.pieces, plan.ways, strict=False) if not _is_known(way)]
    lines.append(f"to weld one seam again, run its routine {ALONE}NAME: from home, and home, on checked ways")
    lines += [f"no free way from and to home was found: {', '.join(closed)}"] if closed else []
    lines.append("if this program has no such routines, or not for a seam, run the whole program")
    if rail is not None:
        lines.append("positions count from where the base is at 0 mm of the rail, set up as a coordinated axis")
    return tuple(lines)


def _is_known(way: Way) -> bool:
    return bool(len(way.from_home) and len(way.to_home))


def _way(way: Way, output: PlanOutput) -> tuple[JointMoves, JointMoves]:
    """Return the moves from home on, but the last, and those home from where a seam ends."""
    if not _is_known(way):
        return JointMoves(*_split(way.from_home[:0])), JointMoves(*_split(way.to_home[:0]))
    return _moves_to(way.from_home, output).rows(0, -1), _moves_to(way.to_home, output).rows(1, None)


def _moves_to(q: FloatArray, output: PlanOutput) -> JointMoves:
    return JointMoves(*_split(q), *((None, None) if output.zones is None else output.zones(q)))


def _split(q: FloatArray) -> tuple[FloatArray, FloatArray]:
    return frozen(q[:, :JOINTS]), frozen(q[:, JOINTS:])


class _Frame:
    """In what lines and arcs are found: the base with a rail at 0 mm, or the flange of a positioner that turns.

    A program calls it the base. If its positions are not carried, they are brought into the base of the robot.
    """

    def __init__(self, cell: Cell, *, follows: bool, is_carried: bool) -> None:
        self.cell, self.follows, self.is_carried, self._base = cell, follows, is_carried, cell.T_world_base.matrix

    @property
    def has_arcs(self) -> bool:
        """Whether moves may be arcs."""
        return self.is_carried or not self.follows

    def places(self, q: FloatArray) -> FloatArray:
        """Return its place in `world` for axes (n, k); shape (n, 4, 4), mm."""
        return self.cell.carrier_places(q) if self.follows else np.repeat(self._base[None], len(q), axis=0)

    def written(self, T: FloatArray, q: FloatArray) -> FloatArray:
        """Return poses (n, 4, 4) as positions of a program, for axes (n, k)."""
        return T if self.has_arcs else np.linalg.inv(self._base) @ self.places(q) @ T

    @property
    def T_base_part(self) -> RigidTransform:
        """The frame in which positions are written, in this base."""
        turns = self.cell.carrier is not None
        if turns and not (self.follows and self.is_carried):
            return RigidTransform.identity(target="base", source="part")
        home = self.cell.home[None]
        T = np.linalg.inv(self.places(home)[0]) @ self.cell.part_places(home)[0]
        return RigidTransform.from_matrix(T, target="base", source="part")


def _path(plan: KeptPlan, piece: KeptPiece, of: PlannedSeam, output: PlanOutput, frame: _Frame) -> WeldPath:
    cell, task, q = plan.cell, piece.task, piece.q
    into = np.linalg.inv(frame.places(q))
    T_part, T_tool = into @ cell.part_places(q), into @ cell.tool_places(q)
    R_seam = T_part[:, :3, :3] @ task.R
    p_seam = np.einsum("nij,nj->ni", T_part[:, :3, :3], task.p) + T_part[:, :3, 3]
    moves = None
    tolerance = None if of.run is not None and of.run.is_woven else output.tolerance
    for allowed in () if tolerance is None else map(tolerance.narrowed, NARROWER):
        moves = fit_moves(
            T_tool[:, :3, 3],
            T_tool[:, :3, :3],
            s_mm=task.s_mm,
            headings=R_seam[:, :, 0],
            standoff_mm=task.more_wire_mm,
            tolerance=allowed,
            arcs=frame.has_arcs,
            spin_is_free=False,
        )
        near = np.stack([np.interp(moves.s_mm, task.s_mm, column) for column in q.T], axis=1)
        T = poses(moves.R, moves.p)
        T_base = np.linalg.inv(cell.base_places(near)) @ frame.places(near)
        joints = _joints_at(cell, piece.branch, T_base @ T, near)
        if output.is_free is None or output.is_free(T[moves.ends], moves.vias, joints[moves.ends]):
            break
    if moves is None:  # a line to every point of the seam file, or of a weave
        own_point = task.is_source.copy()
        own_point[[0, -1]] = True  # of a cut
        T, joints = T_tool[own_point], q[own_point]
    ends = piece.states[[0, -1]]
    T_ends = np.linalg.inv(frame.places(ends)) @ cell.tool_places(ends)
    T = np.concatenate([T_ends[:1], T, T_ends[1:]])
    axes = np.concatenate([ends[:1], joints, ends[1:]])
    T = frame.written(T, axes)
    angles, external = _split(axes)
    own = of.seam.frames
    frames = SeamFrames(task.s_mm - task.s_mm[0], p_seam, R_seam, np.interp(task.s_mm, own.s_mm, own.angle_rad), "base")
    seam = replace(
        of.seam, name=piece.name, closed=False, length_mm=task.length_mm, frames=frames, lean_rad=None, spin_rad=None
    )
    u95 = None if of.u95_mm is None else np.interp(task.s_mm, own.s_mm, of.u95_mm)
    return WeldPath(
        seam,
        frozen(T[:, :3, 3]),
        frozen(T[:, :3, :3]),
        u95,
        joints=angles,
        moves=moves,
        run=of.run,
        external=external,
        speed_mm_s=piece.speed_mm_s(cell, plan.speed_mm_s) / (1.0 if of.run is None else of.run.speed_ratio),
    )


def _joints_at(cell: Cell, branch: int, T_base_tool: FloatArray, near: FloatArray) -> FloatArray:
    """Return all axes at poses of the tool in the base, in one branch and in the turns of axes nearby."""
    found = own_branch(cell.arm, T_base_tool @ cell.T_flange_tool.inverse().matrix, branch, near[:, :JOINTS])
    found = found + TURN * np.rint((near[:, :JOINTS] - found) / TURN)
    return np.concatenate([found, near[:, JOINTS:]], axis=1)
