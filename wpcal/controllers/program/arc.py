"""How a program switches the arc, the comments around its seams, and the values that arc instructions need."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from wpcal.core.errors import InputError
from wpcal.core.options import opt

if TYPE_CHECKING:
    from wpcal.controllers.program.weld_program import WeldPath

SEAM_MARKS = ("SEAM START", "SEAM END")
"""Comments around the moves of a seam in a program with arc instructions; `wpcal audit` reads them back."""
DRY_MARKS = ("ARC ON", "ARC OFF")  #: The same in a program of a dry run: they stand for the instructions.


@dataclass(frozen=True, slots=True)
class ArcSettings:
    """How a program switches the arc. Raises `InputError` when the output is negative."""

    output: int | None = opt(
        None,
        "Digital output that switches the arc: for languages without arc instructions.  [default: "
        "functions of yours, arc_start and arc_end]",
        "--arc-output",
        metavar="N",
        least=0,
    )

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


def _weld_name(path: WeldPath) -> str:
    return path.seam.name if path.run is None else path.run.weld.name


def needed(path: WeldPath, name: str, *, language: str, why: str) -> float:
    """Return a number of the weld data that a language cannot do without.

    Raises `InputError` with the command that states it, if it is missing.
    """
    value = getattr(path.values, name)
    if value is None:
        seam = _weld_name(path)
        raise InputError(f"{language}: weld {seam}: {why}; state it: wpcal welds … --set {seam}:{name}=VALUE")
    return float(value)


def refuse(path: WeldPath, name: str, *, language: str, why: str) -> InputError:
    """Return the error for a value that a language cannot write."""
    return InputError(f"{language}: weld {_weld_name(path)}: {name}: {why}")


def has_weave(path: WeldPath) -> bool:
    """Tell whether the weld data state a weave, with values or by the name of its data."""
    return path.values.weave is not None or path.values.weave_data is not None


def end_time_s(path: WeldPath) -> float:
    """Return how long the arc burns after the torch has stopped: crater and delay together, s."""
    crater = path.values.crater
    return (0.0 if crater is None else crater.time_s) + (path.values.end_delay_s or 0.0)
