"""A generated part: its members, what they are, and its welds in closed form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from tests.benchmarks.welds.lists import Weld


@dataclass(frozen=True, slots=True)
class Member:
    """A body of a part: its name in the STEP file, its shape, its colour, and what it is in a person's words."""

    name: str
    shape: Any
    color: tuple[float, float, float]
    what: str
    welded: bool = True


@dataclass(frozen=True, slots=True)
class Part:
    """A part with its list."""

    name: str
    about: str
    members: Sequence[Member]
    welds: Sequence[Weld]
