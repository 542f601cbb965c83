"""What a controller stored when it ran the searches of a plan."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.numbers import parse_number
from wpcal.core.transform import RigidTransform
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.setup import TouchSetup


class Outcome(StrEnum):
    """How a search ended."""

    FOUND = "found"
    MISSED = "missed"  #: The end of the stroke was reached without contact.
    NOT_RUN = "not run"
    ACTIVE_AT_START = "active at start"  #: The touch signal was already on.


STORED_NUMBERS = {Outcome.NOT_RUN: 0, Outcome.FOUND: 1, Outcome.MISSED: 2, Outcome.ACTIVE_AT_START: 3}
"""What programs store for an outcome, in every language with numbers (docs/reference/touch-results.md)."""
HALF = 4  #: Digits of half a fingerprint.


def halves_of(fingerprint: str) -> tuple[int, int]:
    """Return the first and the last four hexadecimal digits as numbers, for languages without text variables."""
    return int(fingerprint[:HALF], 16), int(fingerprint[HALF:], 16)


def fingerprint_of(first: int, last: int) -> str:
    """Return the fingerprint of two stored numbers; the inverse of `halves_of`.

    Raises `InputError` when a number has more than four hexadecimal digits, or is negative.
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


OUTCOMES = {number: outcome for outcome, number in STORED_NUMBERS.items()}


@dataclass(frozen=True, slots=True)
class ResultsFile:
    """A file from the controller."""

    path: str
    text: str


TouchResultsReader = Callable[[Sequence[ResultsFile], TouchPlan, TouchSetup], SearchResults]
"""Reads the results of a plan: from the files, the plan (for the order of numbered results) and the touch setup."""


@dataclass(slots=True)
class StoredValues:
    """What a file stores. Names of searches are upper case."""

    outcomes: dict[str, float] = field(default_factory=dict)  #: Numbers as stored.
    places: dict[str, RigidTransform] = field(default_factory=dict)  #: Of the tool in the work object.
    #: Why there is no place, where the file has one that cannot be used.
    faults: dict[str, str] = field(default_factory=dict)
    fingerprint: str = ""
    tool: str = ""
    count: float | None = None
    T_base_part: RigidTransform | None = None

    def results(self, controller: str, path: str) -> SearchResults:
        """Return the results of the file.

        Raises `FormatError` when it stores no outcome, an outcome is none, or a found place is missing or unusable.
        """
        if not self.outcomes:
            raise FormatError("holds no results of a touch program of wpcal", path=path)
        count = None if self.count is None else _whole(self.count, "count of searches", path)
        found = tuple(self._result(name, number, path) for name, number in self.outcomes.items())
        return SearchResults(controller, found, self.fingerprint.lower(), self.tool, count, self.T_base_part, path)

    def _result(self, name: str, number: float, path: str) -> SearchResult:
        index = _whole(number, f"search {name}: its outcome", path)
        if index not in OUTCOMES:
            raise FormatError(f"search {name}: its outcome is {index}; expected 0 to {max(OUTCOMES)}", path=path)
        outcome = OUTCOMES[index]
        if outcome is not Outcome.FOUND:
            return SearchResult(name, outcome, None)
        if name in self.faults:
            raise FormatError(f"search {name}: its place {self.faults[name]}", path=path)
        if name not in self.places:
            raise FormatError(f"search {name} is found, but the file has no place of it", path=path)
        T = self.places[name]
        return SearchResult(name, outcome, T.t_mm, T.R)


def fingerprint_of_stored(first: float | None, last: float | None) -> str:
    """Return the fingerprint that two stored numbers hold; empty if they hold none (0 and 0: never run)."""
    if not first and not last:
        return ""
    try:
        return fingerprint_of(int(first or 0), int(last or 0))
    except InputError:
        return ""


def number_at(values: Mapping[int, float], index: int, what: str, path: str) -> float:
    """Return a numbered value. Raises `FormatError` when the file does not have it."""
    if index not in values:
        raise FormatError(f"lacks {what}; does the touch setup (--setup) name the registers of the program?", path=path)
    return values[index]


def parsed_number(text: str, what: str, path: str) -> float:
    """Return a number of a file. Raises `FormatError` when it is none."""
    try:
        return parse_number(text)
    except InputError as error:
        raise FormatError(f"{what}: {error}", path=path) from None


def text_number(value: float) -> str:
    """Return a number of a tool as text."""
    return f"{value:g}"


def _whole(value: float, what: str, path: str) -> int:
    if value != int(value):
        raise FormatError(f"{what} is {value:g}; expected a whole number", path=path)
    return int(value)
