"""Whether bodies may have moved, as a person chooses it in the page: on or off, and the tack tolerance."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cad.workpiece.bodies import BodiesOptions, BodyGroup
from wpcal.core.errors import InputError
from wpcal.core.numbers import parse_number


@dataclass(frozen=True, slots=True)
class MovingChoice:
    """What the options ``--bodies``, ``--tack-mm`` and ``--tack-mrad`` say.

    Parameters
    ----------
    is_on : bool
    tack_mm, tack_mrad : float or None
        None: not stated.
    """

    is_on: bool = False
    tack_mm: float | None = None
    tack_mrad: float | None = None

    @classmethod
    def from_record(cls, record: Any) -> MovingChoice:
        """Return what a page or a draft states.

        Raises
        ------
        InputError
            When it is not a choice, or a tolerance is not a positive number.
        """
        if not isinstance(record, dict) or not isinstance(record.get("is_on"), bool):
            raise InputError("expected is_on as true or false")
        tack_mm, tack_mrad = (_number(record.get(name), name) for name in ("tack_mm", "tack_mrad"))
        BodiesOptions.of(tack_mm, tack_mrad)  # checks them
        return cls(record["is_on"], tack_mm, tack_mrad)

    def to_record(self) -> dict[str, Any]:
        """Return plain values."""
        return {"is_on": self.is_on, "tack_mm": self.tack_mm, "tack_mrad": self.tack_mrad}

    def to_options(self, groups: tuple[BodyGroup, ...]) -> BodiesOptions | None:
        """Return the choice as a calibration takes it, with the groups of ``--bodies FILE``; None if it is off."""
        return BodiesOptions.of(self.tack_mm, self.tack_mrad, groups) if self.is_on else None

    def words(self, file: Path | None) -> list[str]:
        """Return the options of a command that say the same."""
        if not self.is_on:
            return []
        words = ["--bodies", *([] if file is None else [str(file)])]
        stated = (("--tack-mm", self.tack_mm), ("--tack-mrad", self.tack_mrad))
        return words + [word for name, value in stated if value is not None for word in (name, f"{value:g}")]


def _number(value: Any, name: str) -> float | None:
    if value is None or value == "":
        return None
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise InputError(f"expected {name} as a number")
    return float(value) if isinstance(value, int | float) else parse_number(value.replace(",", "."))
