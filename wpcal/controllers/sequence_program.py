"""A program of one robot over all seams before it is written in a language: joint moves in the air, lines and arcs.

Moves through the air are joint moves to joint targets, between which the controller moves as the plan was checked.
Approach, weld and retract are lines and arcs to poses, each with the joints that the plan has there: the configuration
is known, and nothing is left to the controller.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from wpcal import __version__
from wpcal.controllers.program import ControllerSettings
from wpcal.controllers.registry import controllers
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.moves import Arc, PathTolerance, fit_moves
from wpcal.planning.cell.one_robot import OneRobotCell
from wpcal.planning.cell.robot_cell import JOINTS
from wpcal.planning.sequence.sequence_record import checked_text
from wpcal.planning.sequence.weld_sequence import AIR_SHARE, WeldPiece, WeldSequence
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import TURN, solve_inverse
from wpcal.robot.kinematics.posture import Posture, posture

BLEND_MM = 1.0
"""Distance from a corner at which a move along a seam may leave it."""


class StepKind(Enum):
    """How the robot gets to a target."""

    JOINT = "joint"
    LINE = "line"
    ARC = "arc"


class ArcChange(Enum):
    """What the arc does at a target."""

    ON = "on"
    OFF = "off"


@dataclass(frozen=True, slots=True, eq=False)
class SequenceStep:
    """One move.

    Parameters
    ----------
    kind : StepKind
    target : int
        Row of `SequenceProgram.joints`.
    via : int or None
        Row of the target in the middle of an arc.
    speed_mm_s : float or None
        Of the wire's tip; None for a joint move.
    stops : bool
        Whether the robot stops at the target.
    arc : ArcChange or None
        What the arc does there.
    seam : str or None
        The piece that begins with this move.
    """

    kind: StepKind
    target: int
    via: int | None = None
    speed_mm_s: float | None = None
    stops: bool = True
    arc: ArcChange | None = None
    seam: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class SequenceProgram:
    """All targets and moves.

    Parameters
    ----------
    arm : Arm
    joints : ndarray, shape (n, 6)
        Shown angles at the targets, rad.
    external : ndarray, shape (n, e)
        Axes of the positioner, rad.
    external_names : tuple of str
    p, R : ndarray, shapes (n, 3) and (n, 3, 3)
        The tool in the base of the robot, mm.
    steps : tuple of SequenceStep
    T_flange_tool : RigidTransform
        z is the wire.
    joint_percent : float
        Of the largest joint speeds, in joint moves.
    notes : tuple of str
        For a person to read first.
    controller : ControllerSettings
    """

    arm: Arm
    joints: FloatArray
    external: FloatArray
    external_names: tuple[str, ...]
    p: FloatArray
    R: FloatArray
    steps: tuple[SequenceStep, ...]
    T_flange_tool: RigidTransform
    joint_percent: float
    notes: tuple[str, ...]
    controller: ControllerSettings = field(default_factory=ControllerSettings)

    @property
    def postures(self) -> Posture:
        """Postures of the arm at all targets."""
        return posture(self.arm, self.joints)


def build_sequence_program(sequence: WeldSequence, *, controller: ControllerSettings | None = None) -> SequenceProgram:
    """Return the program of a sequence.

    Parameters
    ----------
    sequence : WeldSequence
    controller : ControllerSettings, optional

    Returns
    -------
    SequenceProgram

    Raises
    ------
    InputError
        When a move is not free, or the robot is on a rail.
    """
    cell = sequence.cell
    if not sequence.is_free:
        raise InputError("no program is written for a plan that is not free of collision")
    if cell.rail is not None:
        raise InputError("programs of a robot on a rail are not written; plan.csv has all axes with their times")
    made = _Maker(cell)
    for row, path in enumerate(sequence.air):
        for q in path.q if row == 0 else path.q[1:]:
            made.add(StepKind.JOINT, q)
        if row < len(sequence.pieces):
            _weld(made, sequence, sequence.pieces[row])
    q = np.array(made.states)
    T = np.linalg.inv(cell.base_places(q)) @ cell.tool_places(q)
    tool = ", ".join(f"{value:.3f}" for value in cell.T_flange_tool.t_mm)
    notes = (
        f"written by wpcal {__version__} from plan.json",
        f"{len(sequence.pieces)} pieces, {sequence.welded_mm:.0f} mm; cell {cell.name}",
        f"checked against collision: all moves; {checked_text(sequence)}",
        "NOT CHECKED: cables, hoses, clamps that the cell does not have. RUN IT DRY FIRST",
        f"tool centre point in the flange, mm: {tool}; the wire is along z of the tool",
        "targets are in the base of the robot; the external axes stand still along every seam",
    )
    return SequenceProgram(
        cell.arm,
        q[:, :JOINTS],
        q[:, JOINTS:],
        cell.axis_names[JOINTS:],
        T[:, :3, 3],
        T[:, :3, :3],
        tuple(made.steps),
        cell.T_flange_tool,
        100.0 * AIR_SHARE,
        notes,
        controller or ControllerSettings(),
    )


class _Maker:
    """Collects targets and steps."""

    def __init__(self, cell: OneRobotCell) -> None:
        self.cell = cell
        self.states: list[FloatArray] = []
        self.steps: list[SequenceStep] = []

    def add(self, kind: StepKind, q: FloatArray, **more: object) -> None:
        self.states.append(q)
        self.steps.append(SequenceStep(kind, len(self.states) - 1, **more))  # type: ignore[arg-type]  # fields of the step


def _weld(made: _Maker, sequence: WeldSequence, piece: WeldPiece) -> None:
    air = sequence.targets.air_speed_mm_s
    candidate, cell = piece.candidate, sequence.cell
    T = np.linalg.inv(cell.base_places(candidate.q)) @ cell.tool_places(candidate.q)
    s = candidate.task.s_mm
    way = fit_moves(T[:, :3, 3], T[:, :3, :3], s_mm=s, tolerance=PathTolerance(), spin_is_free=False)
    joints = _joints_at(cell, candidate.branch, way.p, way.R, _interpolated(candidate.q, s, way.s_mm))
    made.add(StepKind.LINE, joints[0], speed_mm_s=air, arc=ArcChange.ON, seam=piece.name)
    stops = way.stops(BLEND_MM)
    for number, (move, stop) in enumerate(zip(way.moves, stops, strict=True), start=1):
        arc = ArcChange.OFF if number == len(way.moves) else None
        more = {"speed_mm_s": piece.speed_mm_s, "stops": stop, "arc": arc}
        if isinstance(move, Arc):
            made.states.append(joints[move.via])
            made.add(StepKind.ARC, joints[move.to], via=len(made.states) - 1, **more)
        else:
            made.add(StepKind.LINE, joints[move.to], **more)
    if len(piece.after):
        made.add(StepKind.LINE, piece.after[-1], speed_mm_s=air)


def _interpolated(q: FloatArray, s: FloatArray, at: FloatArray) -> FloatArray:
    return np.stack([np.interp(at, s, column) for column in q.T], axis=1)


def _joints_at(cell: OneRobotCell, branch: int, p: FloatArray, R: FloatArray, near: FloatArray) -> FloatArray:
    """Return all axes at poses of the tool in the base, in one branch and in the turns of axes nearby."""
    T = np.zeros((len(p), 4, 4))
    T[:, :3, :3], T[:, :3, 3], T[:, 3, 3] = R, p, 1.0
    found = solve_inverse(cell.arm, T @ cell.T_flange_tool.inverse().matrix).joints[:, branch]
    found = found + TURN * np.rint((near[:, :JOINTS] - found) / TURN)
    return np.concatenate([found, near[:, JOINTS:]], axis=1)


def possible_sequences(
    sequence: WeldSequence, *, controller: ControllerSettings | None = None
) -> tuple[dict[str, str], dict[str, str]]:
    """Return the files in all languages that can hold a sequence, and by language why the others cannot.

    Parameters
    ----------
    sequence : WeldSequence
    controller : ControllerSettings, optional
    """
    writers = [each for each in controllers() if each.sequence_writer is not None]
    try:
        program = build_sequence_program(sequence, controller=controller)
    except InputError as error:
        return {}, {each.name: str(error) for each in writers}
    files: dict[str, str] = {}
    refused: dict[str, str] = {}
    for each in writers:
        try:
            files |= each.write_sequence(program)
        except InputError as error:
            refused[each.name] = str(error)
    return files, refused


def degrees(values: FloatArray, decimals: int) -> Sequence[Sequence[str]]:
    """Return angles of shape (n, k), rad, as texts in degrees."""
    return [
        [f"{value:.{decimals}f}" for value in row] for row in (np.round(np.degrees(values), decimals) + 0.0).tolist()
    ]
