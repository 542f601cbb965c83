"""In which model of the robot a position is meant: quantities of different models are never mixed."""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum

from wpcal.core.errors import FrameError, InputError
from wpcal.core.tables import Table


class RobotSpace(Enum):
    """What a Cartesian position of a robot was computed with.

    A controller turns joint angles into positions, and targets into joint angles, with its own nominal model. Where
    both ways go through that model its errors largely cancel; where only one of them is corrected, they do not.
    """

    NOMINAL = "nominal"
    """The controller's own model: what the pendant shows."""
    IDENTIFIED = "identified"
    """The identified model: where the tool really is."""

    @classmethod
    def parse(cls, text: str) -> RobotSpace:
        """Read the word as it stands in a file.

        Raises
        ------
        InputError
            When the word is neither ``nominal`` nor ``identified``.
        """
        try:
            return cls(text)
        except ValueError:
            raise InputError(f"robot_space is nominal or identified, got {text!r}") from None


def common_space(spaces: Iterable[tuple[str, RobotSpace]]) -> RobotSpace:
    """Return the space that all named quantities share.

    Parameters
    ----------
    spaces : iterable of (str, RobotSpace)
        What it is (a file, a point set) and the space it stands in; at least one.

    Raises
    ------
    FrameError
        When two of them stand in different spaces.
    InputError
        When there is none.
    """
    named = list(spaces)
    if not named:
        raise InputError("nothing to compare: expected at least one quantity with a robot space")
    first_name, first = named[0]
    for name, space in named[1:]:
        if space is not first:
            raise FrameError(
                f"{first_name} is in {first.value} robot space and {name} in {space.value}: correct both ways or "
                "neither, a position of one model is off by the robot's error in the other"
            )
    return first


def space_of_table(table: Table) -> RobotSpace:
    """Return the robot space of a table of points: its column ``robot_space``, or nominal where there is none.

    Raises
    ------
    FormatError
        When a word is neither ``nominal`` nor ``identified``.
    FrameError
        When rows of both spaces stand in one table.
    """
    words = table.choices("robot_space", [space.value for space in RobotSpace], default=RobotSpace.NOMINAL.value)
    rows = zip(table.lines, words, strict=True)
    return common_space((f"{table.path}, line {line},", RobotSpace(word)) for line, word in rows)
