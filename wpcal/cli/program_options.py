"""Options by which the taught points of a controller's program are turned into the robot's base."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from wpcal.taught.table import TaughtPoints
    from wpcal.taught.user_frames import ProgramReading

PROGRAM_VALUES = ("uframes", "tool", "robot", "points")
"""Arguments that `program_options` adds."""

Command = TypeVar("Command", bound=Callable[..., Any])


def program_options(command: Command) -> Command:
    """Add ``--uframe``, ``--tool``, ``--robot`` and ``--points``."""
    for option in (
        click.option("--points", metavar="P1,P2", help="Only these points of a program."),
        click.option(
            "--robot", metavar="ARM", help="Arm file, or the name of a shipped arm: for points stored as joint angles."
        ),
        click.option("--tool", metavar="X,Y,Z", help="Tool tip in the flange, mm, for points taught without a tool."),
        click.option(
            "--uframe",
            "uframes",
            multiple=True,
            metavar="[NAME=]VALUES",
            help="User frame in the base, as on the pendant: X,Y,Z,A,B,C (KUKA), X,Y,Z,W,P,R (FANUC), X,Y,Z,Rx,Ry,Rz "
            "(Yaskawa), X,Y,Z,Q1,Q2,Q3,Q4 (ABB); or `base`, or a frame that the file carries. NAME is the program's "
            "name or number of it; without, it holds for every point whose frame is not known. Repeatable.",
        ),
    ):
        command = option(command)
    return command


def read_touched(path: Path, values: dict[str, Any]) -> TaughtPoints:
    """Read taught points from a table or a program, taking the values of `program_options` out of `values`.

    Parameters
    ----------
    path : Path
        A program is known by its suffix.
    values : dict
        A command's arguments; `PROGRAM_VALUES` are taken out.

    Raises
    ------
    InputError
        When the file cannot be used, or an option for programs is given with a table.
    """
    from wpcal.core.errors import InputError
    from wpcal.taught.table import read_taught
    from wpcal.taught.user_frames import is_program, read_taught_program

    given = [f"--{name.replace('uframes', 'uframe')}" for name in PROGRAM_VALUES if values[name]]
    reading = to_program_reading(values)
    if not is_program(path):
        if given:
            raise InputError(f"{path}: is no controller program: {', '.join(given)} cannot be used with it")
        return read_taught(path)
    return read_taught_program(path, reading)


def to_program_reading(values: dict[str, Any]) -> ProgramReading:
    """Take the values of `program_options` out of a command's arguments.

    Raises
    ------
    InputError
        When one of them cannot be used.
    """
    from wpcal.robot.kinematics.arm_file import find_arm
    from wpcal.taught.user_frames import ProgramReading, parse_uframes

    uframes, tool, robot, points = (values.pop(name) for name in PROGRAM_VALUES)
    return ProgramReading(
        uframes=parse_uframes(uframes),
        tool=None if tool is None else _numbers(tool),
        arm=None if robot is None else find_arm(robot),
        points=None if points is None else [name.strip() for name in points.split(",")],
    )


def _numbers(text: str) -> list[float]:
    from wpcal.core.errors import InputError

    try:
        return [float(value) for value in text.split(",")]
    except ValueError:
        raise InputError(f"--tool: expected X,Y,Z in mm, got {text!r}") from None
