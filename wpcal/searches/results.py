"""What a controller stored when it ran the searches of a plan."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from wpcal.core.arrays import FloatArray


class Outcome(StrEnum):
    """How a search ended."""

    FOUND = "found"
    MISSED = "missed"
    """The end of the stroke was reached without contact."""
    NOT_RUN = "not run"
    ACTIVE_AT_START = "active at start"
    """The touch signal was already on."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchResult:
    """One stored place.

    Parameters
    ----------
    name : str
        Of the search, as the plan has it.
    outcome : Outcome
    p : ndarray, shape (3,), or None
        The tool centre point at contact, mm, in `SearchResults.frame`; None unless found.
    R : ndarray, shape (3, 3), or None
        The tool's axes as columns, where the file holds an orientation.
    """

    name: str
    outcome: Outcome
    p: FloatArray | None
    R: FloatArray | None = None


@dataclass(frozen=True, slots=True)
class SearchResults:
    """The results of one run of a touch program.

    Parameters
    ----------
    controller : str
        Name of the format.
    results : tuple of SearchResult
        In the order of the file.
    frame : str
        ``base``, ``part`` (the work object of the plan), or empty where the file does not say.
    fingerprint : str
        Of the plan, or empty where the file does not say.
    tool : str
        Name or number of the tool, or empty.
    """

    controller: str
    results: tuple[SearchResult, ...]
    frame: str
    fingerprint: str
    tool: str = ""
