"""What a person decided about a candidate of a part, and how the candidate is recognised again."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Candidate:
    """Which candidate of a part a seam is: identified by its place, so that it is recognised under another number."""

    name: str  #: As found: ``W7``.
    #: `start_mm`, `middle_mm`: Its start, and the point at half its length, in `part`, mm.
    start_mm: tuple[float, float, float]
    middle_mm: tuple[float, float, float]
    length_mm: float


@dataclass(frozen=True, slots=True)
class JoinedStretch:
    """A candidate, or a part of it, that another seam goes on along."""

    candidate: Candidate
    range_mm: tuple[float, float] | None = None  #: Two lengths from the start of the candidate, mm; None for all of it.


@dataclass(frozen=True, slots=True)
class SeamEdit:
    """What a person decided about a candidate."""

    accept: bool | None = None  #: True to weld it, false to reject it; None to leave it to the rules.
    reverse: bool = False  #: Whether it is welded in the other direction.
    name: str | None = None
    #: The part of it that is welded: two lengths from the start of the candidate, mm.
    range_mm: tuple[float, float] | None = None
    other_side: bool = False  #: Whether the torch comes from the other side: y and z are reversed.
    #: Other candidates, or parts of them, that are welded with it in one run. Their ends meet.
    join: tuple[JoinedStretch, ...] = ()
