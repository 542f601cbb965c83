"""Taught points from a controller's program: which controller wrote the file, and its points in the robot's base."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from wpcal.controllers.language.grammar import ENCODING
from wpcal.controllers.registry import Controller, controller_of_file, controllers
from wpcal.controllers.user_frames import ProgramReading, parse_uframes, points_in_base
from wpcal.core.errors import InputError
from wpcal.core.input_file import read_bytes, sha256_of
from wpcal.core.options import named_option, opt
from wpcal.robot.identify.poses_file import parse_tool
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.taught.programs import TaughtProgram
from wpcal.taught.table import TaughtPoints, read_taught


def is_program(path: Path) -> bool:
    """Tell by the suffix whether a file is a controller's program."""
    return controller_of_file(path) is not None


def require_program(path: Path) -> Controller:
    """Return the controller that reads a file.

    Raises `InputError` when no controller reads files of this suffix, with the known suffixes.
    """
    controller = controller_of_file(path)
    if controller is None:
        known = ", ".join(sorted(suffix for one in controllers() for suffix in one.suffixes))
        raise InputError(f"{path}: unknown kind of program {path.suffix or '(no suffix)'!r}; known: {known}")
    return controller


def read_taught_program(path: Path, reading: ProgramReading | None = None) -> TaughtPoints:
    """Read the taught points of a program as points in `base`.

    Raises `InputError` when the file cannot be opened, its suffix is unknown, or `reading` cannot be used.
    Raises `FormatError` when the file breaks its format, holds no points or not the points asked for, or does not say
    the user frame.
    """
    require_program(path)
    raw = read_bytes(path)
    return replace(points_in_base(parse_program(raw, path), reading or ProgramReading()), sha256=sha256_of(raw))


def parse_program(raw: bytes, path: Path) -> TaughtProgram:
    """Return what a program's bytes hold, in the frames that it names; also the points that cannot be used.

    Raises `InputError` when the suffix is unknown.
    Raises `FormatError` when the program breaks its format.
    """
    reader = require_program(path).load_reader()
    return TaughtProgram(str(path), reader, reader.read(raw.decode(ENCODING), str(path)))


@dataclass(frozen=True, slots=True, kw_only=True)
class PointsAsked:
    """How the points of a program are read."""

    uframe: tuple[str, ...] = opt(
        (),
        "User frame in the base, in the order of this controller's pendant: X,Y,Z,A,B,C, X,Y,Z,W,P,R, X,Y,Z,Rx,Ry,Rz, "
        "X,Y,Z,O,A,T or X,Y,Z,Q1,Q2,Q3,Q4; or `base`, or a frame of the file. NAME is its name or number in the "
        "program; without NAME it is used for every point whose frame is not known. Repeatable.",
        metavar="[NAME=]VALUES",
        many=True,
    )
    tool: str | None = opt(
        None,
        "Tool centre point in the flange frame: numbers in mm and degrees (R = Rz Ry Rx), or the file of `wpcal tcp`. "
        "For points taught without a tool.",
        metavar="X,Y,Z[,RX,RY,RZ]|TOOL.json",
    )
    robot: str | None = opt(
        None,
        "Arm: the name of a shipped arm, an arm file or a URDF file. For points stored as joint angles. For `wpcal "
        "pick` and `wpcal teach` also the robot itself, as KIND:ADDRESS: its position is read.",
        metavar="ARM",
    )
    points: str | None = opt(None, "Only these points of a program.", metavar="P1,P2")

    @property
    def given(self) -> list[str]:
        """The flags that were given."""
        values = (("--uframe", self.uframe), ("--tool", self.tool), ("--robot", self.robot), ("--points", self.points))
        return [flag for flag, value in values if value]

    def read_taught(self, path: Path) -> TaughtPoints:
        """Read taught points from a table or a program; a program is known by its suffix.

        Raises `InputError` when the file cannot be used, or an option for programs is given with a table.
        """
        reading = self.to_reading()
        if is_program(path):
            return read_taught_program(path, reading)
        if self.given:
            raise InputError(f"{path}: is not a controller program: {', '.join(self.given)} cannot be used with it")
        return read_taught(path)

    def to_reading(self) -> ProgramReading:
        """Return the options as the readers of programs take them.

        Raises `InputError` when one of them cannot be used.
        """
        with named_option("--uframe"):
            uframes = parse_uframes(self.uframe)
        with named_option("--tool"):
            tool = None if self.tool is None else parse_tool(self.tool)[0].t_mm.tolist()
        return ProgramReading(
            uframes=uframes,
            tool=tool,
            arm=None if self.robot is None else find_arm(self.robot),
            points=None if self.points is None else [name.strip() for name in self.points.split(",")],
        )
