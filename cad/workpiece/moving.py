"""Whether bodies may have moved, as a person chooses it in the page: on or off, and the tack tolerance."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from cad.workpiece.bodies import BodiesOptions, BodyGroup
from wpcal.core.errors import InputError
from wpcal.core.numbers import parse_number


@dataclass(frozen=True, slots=True)
class MovingChoice:
    """What the options ``--bodies``, ``--tack-mm``, ``--tack-mrad``, ``--contacts`` and ``--bending`` say."""

    is_on: bool = False
    #: `tack_mm`, `tack_mrad`: None: not stated.
    tack_mm: float | None = None
    tack_mrad: float | None = None
    keeps_contacts: bool = False
    contact_mm: float | None = None  #: How far contacts come apart; None: not stated.
    bending_mm: float | None = None  #: How far a plate of 1 m bends; None: plates do not bend.

    @classmethod
    def from_record(cls, record: Any) -> MovingChoice:
        """Return what a page or a draft states.

        Raises `InputError` when it is not a choice, or a tolerance is not a positive number.
        """
        if not isinstance(record, dict) or not isinstance(record.get("is_on"), bool):
            raise InputError("expected is_on as true or false")
        names = ("tack_mm", "tack_mrad", "contact_mm", "bending_mm")
        tack_mm, tack_mrad, contact_mm, bending_mm = (_number(record.get(name), name) for name in names)
        keeps = record.get("keeps_contacts") is True
        choice = cls(record["is_on"], tack_mm, tack_mrad, keeps, contact_mm, bending_mm)
        replace(choice, is_on=True).to_options(())  # checks the numbers
        return choice

    def to_record(self) -> dict[str, Any]:
        """Return plain values."""
        return asdict(self)

    def to_options(self, groups: tuple[BodyGroup, ...]) -> BodiesOptions | None:
        """Return the choice as a calibration takes it, with the groups of ``--bodies FILE``; None if it is off."""
        if not self.is_on:
            return None
        options = BodiesOptions.of(self.tack_mm, self.tack_mrad, groups)
        options = replace(options, keeps_contacts=self.keeps_contacts, contact_sigma_mm=self.contact_mm)
        return replace(options, bending_mm=self.bending_mm)

    def words(self, file: Path | None) -> list[str]:
        """Return the options of a command that say the same."""
        if not self.is_on:
            return []
        words = ["--bodies", *([] if file is None else [str(file)])]
        stated = (("--tack-mm", self.tack_mm), ("--tack-mrad", self.tack_mrad))
        words += [word for name, value in stated if value is not None for word in (name, f"{value:g}")]
        if self.keeps_contacts:
            words += ["--contacts", *([] if self.contact_mm is None else [f"{self.contact_mm:g}"])]
        if self.bending_mm is not None:
            words += ["--bending", f"{self.bending_mm:g}"]
        return words


def _number(value: Any, name: str) -> float | None:
    if value is None or value == "":
        return None
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise InputError(f"expected {name} as a number")
    return float(value) if isinstance(value, int | float) else parse_number(value.replace(",", "."))
