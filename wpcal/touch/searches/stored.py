"""What the results files of all controllers have in common: values by the names of searches."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from wpcal.core.errors import FormatError, InputError
from wpcal.core.numbers import parse_number
from wpcal.core.transform import RigidTransform
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import STORED_NUMBERS, Outcome, SearchResult, SearchResults, fingerprint_of
from wpcal.touch.searches.setup import TouchSetup

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

        Raises
        ------
        FormatError : When it stores no outcome, an outcome is none, or a found place is missing or unusable.
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
    """Return a numbered value.

    Raises
    ------
    FormatError : When the file does not have it.
    """
    if index not in values:
        raise FormatError(f"lacks {what}; does the touch setup (--setup) name the registers of the program?", path=path)
    return values[index]


def parsed_number(text: str, what: str, path: str) -> float:
    """Return a number of a file.

    Raises
    ------
    FormatError : When it is none.
    """
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
