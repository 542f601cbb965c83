"""What a controller stored when it ran the searches of a plan."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform


class Outcome(StrEnum):
    """How a search ended."""

    FOUND = "found"
    MISSED = "missed"
    """The end of the stroke was reached without contact."""
    NOT_RUN = "not run"
    ACTIVE_AT_START = "active at start"
    """The touch signal was already on."""


STORED_NUMBERS = {Outcome.NOT_RUN: 0, Outcome.FOUND: 1, Outcome.MISSED: 2, Outcome.ACTIVE_AT_START: 3}
"""What programs store for an outcome, in every language with numbers (docs/reference/touch-results.md)."""
HALF = 4  #: Digits of half a fingerprint.


def halves_of(fingerprint: str) -> tuple[int, int]:
    """Return the first and the last four hexadecimal digits as numbers, for languages without text variables."""
    return int(fingerprint[:HALF], 16), int(fingerprint[HALF:], 16)


def fingerprint_of(first: int, last: int) -> str:
    """Return the fingerprint of two stored numbers; the inverse of `halves_of`.

    Raises
    ------
    InputError : When a number has more than four hexadecimal digits, or is negative.
    """
    if not (0 <= first < 16**HALF and 0 <= last < 16**HALF):
        raise InputError(f"expected two numbers from 0 to 65535 as fingerprint, got {first} and {last}")
    return f"{first:04x}{last:04x}"


@dataclass(frozen=True, slots=True, eq=False)
class SearchResult:
    """One stored place."""

    name: str  #: Of the search, as the plan has it.
    outcome: Outcome
    #: shape (3,). The tool centre point at contact, mm, in the work object of the program: `part` as planned. None
    #: unless found.
    p: FloatArray | None
    R: FloatArray | None = None  #: shape (3, 3). The tool's axes as columns, where the file holds an orientation.


@dataclass(frozen=True, slots=True, eq=False)
class SearchResults:
    """The results of one run of a touch program."""

    controller: str  #: Name of the format.
    results: tuple[SearchResult, ...]  #: In the order of the file.
    fingerprint: str  #: Of the plan, or empty where the file does not say.
    tool: str = ""  #: Name or number of the tool, or empty.
    count: int | None = None  #: The number of searches that the file states.
    T_base_part: RigidTransform | None = None  #: The work object of the places, where the file holds its values.
    path: str = ""  #: The file, for messages.
