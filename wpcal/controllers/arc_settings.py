"""How a program switches the arc, and the comments around its seams."""

from __future__ import annotations

from dataclasses import dataclass

from wpcal.core.errors import InputError

SEAM_MARKS = ("SEAM START", "SEAM END")
"""Comments around the moves of a seam in a program with arc instructions; `wpcal audit` reads them back."""


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
