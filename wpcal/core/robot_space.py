"""The robot model behind a position. Positions of different models are never mixed."""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum

from wpcal.core.errors import FrameError, InputError
from wpcal.core.tables import Table


class RobotSpace(Enum):
    """What a Cartesian position of a robot was computed with.

    A controller converts joint angles to positions, and targets to joint angles, with its own nominal model. If both
    conversions use that model, its errors largely cancel. If only one of them is corrected, they do not.
    """

    NOMINAL = "nominal"  #: The controller's own model: what the pendant shows.
    IDENTIFIED = "identified"  #: An identified model: where the tool really is.

    @classmethod
    def parse(cls, text: str) -> RobotSpace:
        """Read the word in a file. Raises `InputError` when the word is neither ``nominal`` nor ``identified``."""
        try:
            return cls(text)
        except ValueError:
            raise InputError(f"robot_space is nominal or identified, got {text!r}") from None


def common_space(spaces: Iterable[tuple[str, RobotSpace]]) -> RobotSpace:
    """Return the space that all named quantities share.

    Raises `FrameError` when two of them are in different spaces.
    Raises `InputError` when the list is empty.
    """
    named = list(spaces)
    if not named:
        raise InputError("nothing to compare: expected at least one quantity with a robot space")
    first_name, first = named[0]
    for name, space in named[1:]:
        if space is not first:
            raise FrameError(
                f"{first_name} is in {first.value} robot space and {name} in {space.value}: correct both or "
                "neither, because a position of one model is off by the robot's error in the other"
            )
    return first


def space_of_table(table: Table) -> RobotSpace:
    """Return the robot space of a table of points: its column ``robot_space``; nominal without that column.

    Raises `FormatError` when a word is neither ``nominal`` nor ``identified``.
    Raises `FrameError` when one table has rows of both spaces.
    """
    words = table.choices("robot_space", [space.value for space in RobotSpace], default=RobotSpace.NOMINAL.value)
    rows = zip(table.lines, words, strict=True)
    return common_space((f"{table.path}, line {line},", RobotSpace(word)) for line, word in rows)
