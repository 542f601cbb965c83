"""Judge programs in a folder: their poses and, beside a result, where their text leads when it is executed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.brep.hits import START_MM
from wpcal.brep.material import TriangleMaterial
from wpcal.controllers.audit.fault import Fault
from wpcal.controllers.audit.off_line import OFF_MM, Placed, Track, off_line_faults, tools_in_part
from wpcal.controllers.judge.arc import arc_faults
from wpcal.controllers.judge.execute import NUMBERS, UNDECLARED, Files, execute, programs_of, texts_of
from wpcal.controllers.judge.in_cell import CellSweep
from wpcal.controllers.judge.swept import Meeting, meetings
from wpcal.controllers.language.grammar import ENCODING, Grammar
from wpcal.controllers.program.air_moves import TorchAtTool
from wpcal.controllers.program.describe import SPEEDS, stated_speeds
from wpcal.controllers.program.reachable_spin import ArmAtTool
from wpcal.controllers.registry import grammar_of_file
from wpcal.controllers.run.recorder import Motion, Recorder, Trace, pulses_of
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import ErrorCode, FormatError, InputError, WpcalError
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import turn_into_limits
from wpcal.robot.torch.attitude import ToolAxis, neck_directions, wire_directions
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape
from wpcal.seam.judge.material import find_poses_in_material
from wpcal.seam.record_check import FARTHEST_MM, ROTATION_ATOL
from wpcal.taught.programs import BASE, ProgramPoint

ON_LINE = f"within {OFF_MM:g} mm of their seams"
IN_TIME = "lines no faster than their headers say"
NO_SPEEDS = "speeds: no header states them"
ROUNDED = 1.01  #: A language writes a speed with few digits.


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What the poses of a program are compared with."""

    T_base_part: RigidTransform | None = None  #: The user frame of poses whose frame is not in the file.
    part: TriangleMaterial | None = None  #: In `base`.
    arm: Arm | None = None
    T_flange_tool: RigidTransform | None = None  #: With `arm`.
    torch: TorchShape = USUAL_TORCH
    tool_axis: ToolAxis = ToolAxis.Z
    standoff_mm: float = 0.0
    start_mm: float = START_MM  #: From where on the wire is felt: farther on seams that are modelled as beads.
    in_cell: CellSweep | None = None  #: The cell of the plan that a program is of.
    #: What is welded, in `base` or, of a plan, in the part; None without a result.
    lines: tuple[Track, ...] | None = None
    #: Digital output that switches the arc; None for that which the header of a program states.
    arc_output: int | None = None
    untimed: str = NO_SPEEDS  #: Which speeds are not compared.

    def __str__(self) -> str:
        """Say what is compared."""
        done = ["finite", "rotations", "user frames", *([ON_LINE] if self.lines else [])]
        done, left = [*done, *([] if self.untimed == NO_SPEEDS else [IN_TIME])], [self.untimed]
        if self.arm is not None:
            done.append(f"inside the reach of {self.arm.name}")
        if self.part is not None:
            done.append(f"executed: out of material with {self.torch}, also between poses")
        if self.in_cell is not None:
            done.append(f"executed: every move of {self.in_cell.cell.arm.name} in its cell, wire and torch included")
        elif self.part is not None:
            left += ["joint moves", "the arm"]
        else:
            left.append("what its instructions do: no result beside it")
        return f"{', '.join(done)}; NOT CHECKED: {', '.join(left)}"


def audit_poses(raw: bytes, path: Path, around: Surroundings) -> list[Fault]:
    """Return the faults of the poses that one file of a program states."""
    try:
        return list(pose_faults(read_poses_back(raw, path, around.T_base_part), around))
    except WpcalError as error:
        return [Fault.of(error, str(path))]


def executed(
    files: Files, around: Surroundings, *, leader: Recorder | None = None, **given: Any
) -> tuple[Trace, dict[str, list[Fault]]]:
    """Execute the files of programs that lie together; faults of files that cannot be loaded, by name.

    `given`: Of the recorder.
    """
    left, faults = programs_of(files), dict[str, list[Fault]]()
    arm = around.arm if around.in_cell is None else around.in_cell.cell.arm
    while left:
        try:
            trace = execute(
                left,
                tools=(UNDECLARED, *NUMBERS),
                T_base_frame=np.eye(4) if around.T_base_part is None else around.T_base_part.matrix,
                recorder=Recorder(pulses_of(arm), arc_output=around.arc_output, **given),
                leader=leader,
            )
        except FormatError as error:
            name = error.path if error.path in left else next(iter(left))
            faults[name] = [Fault.of(error, name)]
            del left[name]
        else:
            return trace, faults
    return Trace(), faults


def executed_faults(trace: Trace, around: Surroundings) -> Iterator[tuple[str, Fault]]:
    """Yield the names of files and what their text does wrong, beside a result."""
    yield from unknown_faults(trace)
    for motion, what, code in _motion_faults(trace.motions, around):
        yield motion.place.file, Fault(what, motion.place.line, code=code)


def unknown_faults(trace: Trace) -> Iterator[tuple[str, Fault]]:
    """Yield the names of files, and what could not be executed."""
    yield from ((each.place.file, Fault(f"NOT CHECKED: {each.text}", each.place.line)) for each in trace.unknowns)


def arc_faults_of(trace: Trace) -> Iterator[tuple[str, Fault]]:
    """Yield the names of files, and where the arc is on or off in the wrong place."""
    yield from ((place.file, Fault(what, place.line)) for place, what in arc_faults(trace))


def speeds_of(files: Files) -> dict[str, list[float]]:
    """Return the largest speeds along seams and in the air, mm/s, of the files whose header states them."""
    return {name: found for name, text in texts_of(files).items() if len(found := stated_speeds(text)) == len(SPEEDS)}


def untimed(trace: Trace, stated: Mapping[str, Sequence[float]]) -> str:
    """Say which speeds of programs are not compared with their headers, which state these."""
    if not stated:
        return NO_SPEEDS
    unknown = any(each.kind != "J" and each.place.speed_mm_s is None for each in trace.motions)
    return f"speeds of joint moves{' and of lines that take a speed of the controller' if unknown else ''}"


def speed_faults(trace: Trace, stated: Mapping[str, Sequence[float]]) -> Iterator[tuple[str, Fault]]:
    """Yield the names of files, and lines and arcs that are faster than their header says, of each speed the first.

    Files without such a header are called by one that has it: the largest speeds of all hold. Not moves by the joints,
    whose speed is a share of that of each axis.
    """
    largest = [max(each) for each in zip(*stated.values(), strict=True)] or [math.inf, math.inf]
    lines = [(each.place, each.seam > 0) for each in reversed(trace.motions) if each.kind != "J"]
    first = {(at.file, at.speed_mm_s or 0.0, is_weld): at.line for at, is_weld in lines}
    for (file, mm_s, is_weld), line in first.items():
        of_welds, in_air = stated.get(file, largest)
        most, where = (of_welds, "along a seam") if is_weld else (max(of_welds, in_air), "in the air")
        if mm_s > most * ROUNDED:
            what = f"{mm_s:g} mm/s {where}: its header says {most:g} at most; if it is meant, change the header"
            yield file, Fault(what, line)


def _motion_faults(motions: Sequence[Motion], around: Surroundings) -> Iterator[tuple[Motion, str, str]]:
    """Yield motions, what is wrong with them, and its code."""
    known = [(each, np.abs(each.goal[:3, 3]).max() < FARTHEST_MM) for each in motions if each.goal is not None]
    near = [each for each, is_near in known if is_near]
    yield from ((each, "leads to where no robot is", ErrorCode.INPUT) for each, is_near in known if not is_near)
    placed: Iterator[Placed] = ((each, _wires(each, around)) for each in near)
    met: Iterable[Meeting] = ()
    if around.in_cell is not None:
        placed = tools_in_part(around.in_cell.cell, around.in_cell.legs(motions))
        met = around.in_cell.meetings(motions)
    elif around.part is not None:
        torch = TorchAtTool(around.torch, around.tool_axis, around.standoff_mm)
        met = meetings(near, around.part, torch, [0.0] * len(near), start_mm=around.start_mm)
    yield from ((each.motion, each.what, ErrorCode.POSE_IN_MATERIAL) for each in met)
    yield from ((each, what, ErrorCode.INPUT) for each, what in off_line_faults(placed, around.lines or ()))


def _wires(motion: Motion, around: Surroundings) -> FloatArray:
    """Return poses on the way of a motion with the tip of the wire and, as z, its direction, shape (n, 4, 4)."""
    T = np.array([each for each in (motion.start, motion.via, motion.goal) if each is not None])
    if around.tool_axis is ToolAxis.X:
        T[:, :3, 2] = T[:, :3, 0]
    T[:, :3, 3] += around.standoff_mm * T[:, :3, 2]
    return T


def pose_faults(poses: Sequence[ReadPose], around: Surroundings) -> Iterator[Fault]:
    """Yield the faults of poses that were read back."""
    sound = []
    for pose in poses:
        what = _what_is_no_pose(pose)
        if what:
            yield _fault(pose, what)
        elif pose.in_base:
            sound.append(pose)
        elif around.T_base_part is not None:
            yield _fault(pose, "is recorded without a tool")
    if not sound:
        return
    p, R = np.array([pose.p_base for pose in sound]), np.array([pose.R_base for pose in sound])
    if around.arm is not None:
        for row in _beyond_reach(p, R, around.arm, around.T_flange_tool):
            yield _fault(sound[row], f"no joint angles within the limits of {around.arm.name} reach it")
    yield from _in_material(sound, p, R, around)


def _in_material(poses: Sequence[ReadPose], p: FloatArray, R: FloatArray, around: Surroundings) -> Iterator[Fault]:
    if around.part is None:
        return
    wire = wire_directions(R, around.tool_axis)
    tips = p + around.standoff_mm * wire
    bend = None if around.torch.neck is None else neck_directions(R, around.tool_axis)
    found = find_poses_in_material(around.part, tips, -wire, around.torch, start_mm=around.start_mm, bend=bend)
    for row, solid, part in zip(found.row.tolist(), found.solid, found.part, strict=True):
        what = f"the {part.value} of {around.torch} is inside {solid!r}"
        yield _fault(poses[row], what, ErrorCode.POSE_IN_MATERIAL)


def _what_is_no_pose(pose: ReadPose) -> str:
    p, R = pose.p_base, pose.R_base
    if not (np.isfinite(p).all() and np.isfinite(R).all()):
        return "expected finite numbers"
    if np.abs(p).max() >= FARTHEST_MM:
        return f"expected coordinates of less than {FARTHEST_MM:g} mm, got {', '.join(f'{v:g}' for v in p)}"
    if np.abs(R.T @ R - np.eye(3)).max() > ROTATION_ATOL or np.linalg.det(R) < 0.0:
        return "its orientation is not a rotation"
    return ""


def _fault(pose: ReadPose, what: str, code: str = ErrorCode.INPUT) -> Fault:
    return Fault(what, pose.line, field=f"point {pose.name}", code=code)


def _beyond_reach(p: FloatArray, R: FloatArray, arm: Arm, T_flange_tool: RigidTransform | None) -> list[int]:
    """Return the poses that no branch of the arm reaches within its limits."""
    at_tool = ArmAtTool(arm, T_flange_tool or RigidTransform.identity(target="flange", source="tool"), np.zeros(6))
    joints = turn_into_limits(arm, at_tool.branches(p, R), at_tool.near)
    return np.flatnonzero(~np.isfinite(joints).all(axis=-1).any(axis=-1)).tolist()


@dataclass(frozen=True, slots=True, eq=False)
class ReadPose:
    """One pose of a program as a controller would take it."""

    name: str  #: Of the point, or its number.
    line: int | None
    p_base: FloatArray  #: shape (3,). Tool centre point in `base`, mm.
    R_base: FloatArray  #: shape (3, 3). Axes of the tool in `base`.
    #: False if the file does not say where its user frame is: position and axes are then in that frame.
    in_base: bool = True


def require_grammar(path: Path) -> Grammar:
    """Return the grammar of a file by its suffix; `InputError` in one line when no controller has one."""
    grammar = grammar_of_file(path)
    if grammar is None:
        raise InputError(f"{path}: no language is known whose programs are {path.suffix or 'without a suffix'} files")
    return grammar


def read_poses_back(raw: bytes, path: Path, T_base_part: RigidTransform | None) -> list[ReadPose]:
    """Return the poses of a program's file in `base`.

    Raises `InputError` when no grammar knows the suffix.
    Raises `FormatError` when the file breaks its format, or a point of a weld program cannot be used. Joint values are
    left out, and so are points of other programs that have no coordinates.
    """
    found = require_grammar(path).read(raw.decode(ENCODING), str(path))
    poses = []
    for point in found.points:
        if point.joints is not None or (point.fault and T_base_part is None):
            continue
        if point.fault:
            raise FormatError(f"point {point.name}: {point.fault}", path=str(path), line=point.line or None)
        poses.append(_in_base(point, found.frames, T_base_part))
    return poses


def _in_base(
    point: ProgramPoint, carried: Mapping[str, RigidTransform], T_base_part: RigidTransform | None
) -> ReadPose:
    T = carried.get(point.frame or "", T_base_part)
    if point.frame == BASE:
        T = RigidTransform.identity(target="base", source="frame")
    if T is None or point.at_flange:
        return ReadPose(point.name, point.line or None, point.p_mm, point.R, in_base=False)
    return ReadPose(point.name, point.line or None, T.apply(point.p_mm), T.R @ point.R)
