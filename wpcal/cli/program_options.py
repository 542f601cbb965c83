"""Options that bring the points of a controller's program into the robot's base."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from wpcal.cli.option_groups import option
from wpcal.cli.shared_help import ROBOT_HELP, TOOL_HELP, TOOL_METAVAR

if TYPE_CHECKING:
    from wpcal.taught.table import TaughtPoints
    from wpcal.taught.user_frames import ProgramReading


@dataclass(frozen=True, slots=True, kw_only=True)
class ProgramFlags:
    """How the points of a program are read."""

    uframes: tuple[str, ...] = option(
        "--uframe",
        multiple=True,
        metavar="[NAME=]VALUES",
        help="User frame in the base, as on the pendant: X,Y,Z,A,B,C (KUKA), X,Y,Z,W,P,R (FANUC), X,Y,Z,Rx,Ry,Rz "
        "(Yaskawa), X,Y,Z,Q1,Q2,Q3,Q4 (ABB); or `base`, or a frame that the file contains. NAME is its name "
        "or number in the program; without NAME it is used for every point whose frame is not known. Repeatable.",
    )
    tool: str | None = option("--tool", metavar=TOOL_METAVAR, help=f"{TOOL_HELP} For points taught without a tool.")
    robot: str | None = option("--robot", metavar="ARM", help=f"{ROBOT_HELP} For points stored as joint angles.")
    points: str | None = option("--points", metavar="P1,P2", help="Only these points of a program.")

    @property
    def given(self) -> list[str]:
        """The flags that were given."""
        values = (("--uframe", self.uframes), ("--tool", self.tool), ("--robot", self.robot), ("--points", self.points))
        return [flag for flag, value in values if value]

    def read_taught(self, path: Path) -> TaughtPoints:
        """Read taught points from a table or a program; a program is known by its suffix.

        Raises
        ------
        InputError
            When the file cannot be used, or an option for programs is given with a table.
        """
        from wpcal.controllers.taught_program import is_program, read_taught_program
        from wpcal.core.errors import InputError
        from wpcal.taught.table import read_taught

        reading = self.to_reading()
        if is_program(path):
            return read_taught_program(path, reading)
        if self.given:
            raise InputError(f"{path}: is not a controller program: {', '.join(self.given)} cannot be used with it")
        return read_taught(path)

    def to_reading(self) -> ProgramReading:
        """Return the options as the readers of programs take them.

        Raises
        ------
        InputError
            When one of them cannot be used.
        """
        from wpcal.cli.hints import named_option
        from wpcal.robot.identify.poses_file import parse_tool
        from wpcal.robot.kinematics.arm_file import find_arm
        from wpcal.taught.user_frames import ProgramReading, parse_uframes

        with named_option("--uframe"):
            uframes = parse_uframes(self.uframes)
        with named_option("--tool"):
            tool = None if self.tool is None else parse_tool(self.tool)[0].t_mm.tolist()
        return ProgramReading(
            uframes=uframes,
            tool=tool,
            arm=None if self.robot is None else find_arm(self.robot),
            points=None if self.points is None else [name.strip() for name in self.points.split(",")],
        )
