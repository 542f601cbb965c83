"""How a program switches the arc, and the comments around its seams."""

from __future__ import annotations

from dataclasses import dataclass

from wpcal.core.errors import InputError

SEAM_MARKS = ("SEAM START", "SEAM END")
"""Comments around the moves of a seam in a program with arc instructions; `wpcal audit` reads them back."""
DRY_MARKS = ("ARC ON", "ARC OFF")
"""The same in a program of a dry run: they stand for the instructions."""


@dataclass(frozen=True, slots=True)
class ArcSettings:
    """How a program switches the arc.

    Parameters
    ----------
    output : int or None
        Digital output that switches the arc, for languages without arc instructions. None: named functions of the
        user, which get the job.

    Raises
    ------
    InputError
        When the output is negative.
    """

    output: int | None = None

    def __post_init__(self) -> None:
        if self.output is not None and self.output < 0:
            raise InputError(f"digital output of the arc: expected 0 or more, got {self.output}")


def seam_marks(arc: ArcSettings | None) -> tuple[str, str]:
    """Return the comments at the start and at the end of every seam; `arc` is None for a dry run."""
    return DRY_MARKS if arc is None else SEAM_MARKS


def arc_in_words(arc: ArcSettings | None) -> str:
    """Say in the header of a program whether it switches the arc."""
    if arc is None:
        return "DRY RUN: the arc stays off; ARC ON and ARC OFF are comments (--arc on makes them instructions)"
    return "the arc burns from SEAM START to SEAM END: RUN IT with the arc blocked at the controller FIRST"
