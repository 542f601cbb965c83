"""Points of a controller's program in the robot's base: user frames, tools and joint values."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import ErrorCode, FormatError, InputError
from wpcal.core.numbers import NUMBER, parse_numbers
from wpcal.core.robot_space import RobotSpace
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed
from wpcal.robot.kinematics.arm import Arm
from wpcal.taught.programs import BASE, JointValues, ProgramPoint, TaughtProgram
from wpcal.taught.table import TaughtPoints

ANY_FRAME = ""  #: Key of the user frame for all points whose own frame is not known.


@dataclass(frozen=True, slots=True, eq=False)
class ProgramReading:
    """Which points of a program are read, and what brings them into the base."""

    #: User frames by the name or number that the program uses. The key ``""`` is for all points whose frame is not
    #: known otherwise. A value is a list of numbers in the order of that controller's pendant (mm and degrees, or
    #: mm and a quaternion), the word ``base``, or the name of a frame that the file contains.
    uframes: Mapping[str, str | Sequence[float]] = field(default_factory=dict)
    #: x, y, z of the tool centre point in the flange, mm, for points recorded without a tool.
    tool: Sequence[float] | None = None
    #: For points stored as joint angles or pulses, which need `tool` as well. With an identified arm, all points must
    #: be of this kind: the controller computed coordinates with its own nominal model.
    arm: Arm | None = None
    points: Sequence[str] | None = None  #: Read only these points.


def parse_uframes(texts: Sequence[str]) -> dict[str, str | Sequence[float]]:
    """Read user frames that a person typed as ``[NAME=]VALUES``: numbers separated by commas, or a word.

    Raises `InputError` when a frame is given twice or VALUES is empty.
    """
    frames: dict[str, str | Sequence[float]] = {}
    for text in texts:
        name, _, values = text.rpartition("=")
        if not values.strip():
            raise InputError(f"user frame: expected [NAME=]VALUES, got {text!r}")
        if name.strip() in frames:
            raise InputError(f"user frame: {name.strip() or 'the frame without a name'} is given twice")
        try:
            frames[name.strip()] = parse_numbers(values)
        except InputError as error:
            if "," in values or NUMBER.match(values.strip()):
                raise InputError(f"user frame {text!r}: {error}") from None
            frames[name.strip()] = values.strip()
    return frames


def usable_points(program: TaughtProgram, *, arm: Arm | None = None) -> tuple[tuple[str, ...], dict[str, str]]:
    """Return the names of the points that can be used, and why each of the others cannot."""
    points = program.found.points
    count = Counter(point.name for point in points)
    faults = {
        point.name: f"appears {count[point.name]} times" if count[point.name] > 1 else point.fault or ""
        for point in points
        if count[point.name] > 1 or (point.fault and not (arm is not None and point.joints is not None))
    }
    return tuple(name for name in count if name not in faults), faults


def points_in_base(program: TaughtProgram, reading: ProgramReading) -> TaughtPoints:
    """Return the points of a program in `base`. Each point's name is also its feature. All points have use ``yes``.

    Raises `InputError` when `reading` cannot be used.
    Raises `FormatError` when the program holds no points or not the points asked for, or a point lacks its user frame
    (with the code `ErrorCode.USER_FRAME_MISSING`), its tool or its arm.
    """
    chosen = _chosen(program, reading.points)
    places = _Places(program, reading)
    places.require_one_space(chosen)
    found = [places.in_base(point) for point in chosen]
    names = tuple(point.name for point in chosen)
    return TaughtPoints(
        names,
        frozen([p for p, _ in found]),
        names,
        frozen(np.full((len(names), 3), np.nan)),
        ("yes",) * len(names),
        program.path,
        tuple(point.line for point in chosen),
        RobotSpace.NOMINAL if reading.arm is None else reading.arm.space,
        is_from_program=True,
        R_base_tool=frozen(np.reshape([R for _, R in found], (-1, 3, 3))),
    )


def _chosen(program: TaughtProgram, names: Sequence[str] | None) -> list[ProgramPoint]:
    points, path = program.found.points, program.path
    if not points:
        raise FormatError("holds no stored positions", path=path)
    known = dict.fromkeys(point.name for point in points)
    asked = known if names is None else dict.fromkeys(names)
    chosen, lines = [point for point in points if point.name in asked], dict[str, int]()
    for point in chosen:
        if point.name in lines:
            what = f"the point {point.name!r} appears twice, first in line {lines[point.name]}"
            raise FormatError(what, path=path, line=point.line)
        lines[point.name] = point.line
    if missing := [name for name in asked if name not in known]:
        raise FormatError(f"has no point {listed(missing)}; it has {listed(known)}", path=path)
    return chosen


class _Places:
    """Puts the points of one program into `base`."""

    def __init__(self, program: TaughtProgram, reading: ProgramReading) -> None:
        self.program, self.arm, self.tool = program, reading.arm, reading.tool
        self.given = {key: self._given_frame(key, value) for key, value in reading.uframes.items()}
        if self.tool is not None and (len(self.tool) != 3 or not all(math.isfinite(v) for v in self.tool)):
            raise InputError(f"tool: expected x, y, z in mm, got {list(self.tool)}")

    def require_one_space(self, points: Sequence[ProgramPoint]) -> None:
        """Refuse coordinates among points that an identified arm puts into the base."""
        if self.arm is None or self.arm.space is RobotSpace.NOMINAL:
            return
        for point in points:
            if point.joints is None:
                what = "holds coordinates, which the controller computed with its nominal model; "
                raise self._fault(point, f"{what}{self.arm.name} is an identified arm and needs joint angles or pulses")

    def in_base(self, point: ProgramPoint) -> tuple[FloatArray, FloatArray]:
        """Return where the tool centre point was, mm, shape (3,), and the axes of the tool or flange, shape (3, 3)."""
        if point.joints is not None and self.arm is not None:
            return self._through_arm(point, point.joints, self.arm)
        if point.fault and point.joints is not None:
            what = f"{point.fault}, or give the arm and the tool, or name the points to read"
            raise self._fault(point, what, code=ErrorCode.ARM_MISSING)
        if point.fault:
            raise self._fault(point, f"{point.fault}; name the points to read", code=ErrorCode.POINT_UNUSABLE)
        p = point.p_mm
        if point.at_flange:
            what = "was recorded without a tool, so that its position is the flange's"
            p = p + point.R @ self._tool_of(point, what)
        T_base_frame = self._frame_of(point)
        return T_base_frame.apply(p), T_base_frame.R @ point.R

    def _through_arm(self, point: ProgramPoint, joints: JointValues, arm: Arm) -> tuple[FloatArray, FloatArray]:
        """Return the tool centre point and the axes of the flange by the forward kinematics of the arm."""
        tool = self._tool_of(point, "is stored as joint values")
        try:
            q = arm.angles_from_pulses(joints.values) if joints.in_pulses else np.deg2rad(joints.values)
            T = arm.forward(q[None])[0]
        except (InputError, ValueError) as error:
            raise self._fault(point, str(error)) from None
        if not arm.within_limits(q):
            what = f"its joint values are beyond the limits of {arm.name}: another arm, or other pulses per degree"
            raise self._fault(point, what)
        return np.asarray(T[:3, :3] @ tool + T[:3, 3], dtype=np.float64), np.asarray(T[:3, :3], dtype=np.float64)

    def _tool_of(self, point: ProgramPoint, why: str) -> FloatArray:
        if self.tool is None:
            what = f"{why}; give the tool: X,Y,Z of the tool centre point in the flange"
            raise self._fault(point, what, code=ErrorCode.TOOL_MISSING)
        return np.asarray(self.tool, dtype=np.float64)

    def _frame_of(self, point: ProgramPoint) -> RigidTransform:
        """Find ``T_base_frame``: given by its name, base, in the file, given for any frame; in this order."""
        frame, carried = point.frame, self.program.found.frames
        if frame is not None and frame in self.given:
            return self.given[frame]
        if frame == BASE:
            return RigidTransform.identity(target="base", source="frame")
        if frame is not None and frame in carried:
            return carried[frame]
        if ANY_FRAME in self.given:
            return self.given[ANY_FRAME]
        order = self.program.reader.pendant_order
        if frame is None:
            what = f"the file does not say its user frame; give it as {order} or as base"
            what += f", or as one that the file contains: {listed(carried)}" if carried else ""
        else:
            what = f"is in user frame {frame}, whose values the file does not contain; "
            what += f"give the user frame as {frame}={order}"
        raise self._fault(point, what, code=ErrorCode.USER_FRAME_MISSING)

    def _given_frame(self, key: str, value: str | Sequence[float]) -> RigidTransform:
        reader, carried = self.program.reader, self.program.found.frames
        if isinstance(value, str):
            if value == BASE:
                return RigidTransform.identity(target="base", source="frame")
            if value not in carried:
                known = listed(carried) or "none"
                raise InputError(f"user frame {value!r}: the file contains no such frame; it contains {known}")
            return carried[value]
        try:
            return reader.frame_of_pendant([float(v) for v in value])
        except InputError as error:
            what = f"user frame {key or list(value)}: {error}"
            raise InputError(f"{what}; expected {reader.pendant_order} as on the pendant") from None

    def _fault(self, point: ProgramPoint, what: str, *, code: str | None = None) -> FormatError:
        return FormatError(f"point {point.name}: {what}", path=self.program.path, line=point.line, code=code)
