"""A generated part: its members, what they are, and its welds in closed form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from tests.benchmarks.welds.lists import Weld, line


@dataclass(frozen=True, slots=True)
class Member:
    """A body of a part: its name in the STEP file, its shape, its colour, and what it is in a person's words."""

    name: str
    shape: Any
    color: tuple[float, float, float]
    what: str
    welded: bool = True

    def without(self, *tools: Any) -> Member:
        """Return the member with shapes cut out of it."""
        shape = self.shape
        for tool in tools:
            shape -= tool
        return replace(self, shape=shape)


@dataclass(frozen=True, slots=True)
class Part:
    """A part with its list."""

    name: str
    about: str
    members: Sequence[Member]
    welds: Sequence[Weld]


Row = tuple[str, str, str, Sequence[float], Sequence[float]]  #: Name, kind, class, start and end of a straight weld.


def straight(members: tuple[str, ...], *rows: Row) -> list[Weld]:
    """Return straight welds between the same members."""
    return [Weld(name, members, kind, cls, line(start, end)) for name, kind, cls, start, end in rows]
