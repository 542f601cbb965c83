"""The options for weldments whose plates may have moved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.core.options import opt
from wpcal.core.wording import shown

if TYPE_CHECKING:
    from cad.workpiece.bodies import BodiesOptions, BodyGroup
    from cad.workpiece.moving import MovingChoice

EACH_SOLID = "each"  #: What ``--bodies`` means without a file.
USUAL_BENDING = "1"
"""What ``--bending`` means without a number, mm: class E of ISO 13920 allows twice as much on lengths from 1 to 2 m."""
USUAL_CONTACTS = "usual"  #: What ``--contacts`` means without a number.


def _json_file(value: str | None) -> str | None:
    """Refuse a file that is no JSON file: what follows ``--bodies`` is taken for its file."""
    if value is not None and value != EACH_SOLID and Path(value).suffix.lower() != ".json":
        raise click.UsageError(
            f"--bodies: expected a JSON file of bodies, got {shown(value)}; without a file, put --bodies last or "
            "before another option"
        )
    return value


@dataclass(frozen=True, slots=True, kw_only=True)
class BodiesAsked:
    """Whether the plates of a weldment may have moved and bent, and whether what lay on each other still does."""

    bodies: str | None = opt(
        None,
        "The bodies may have moved since the model: each solid, the members of a part of one solid, or those of FILE "
        "(JSON: names, solids, tack_mm, tack_mrad). Seams are where moved faces meet.",
        metavar="[FILE]",
        if_alone=EACH_SOLID,
        read=_json_file,
    )
    tack_mm: float | None = opt(
        None, "Tack tolerance of the place of a body: standard deviation, for --bodies.  [default: 1]"
    )
    tack_mrad: float | None = opt(
        None, "Tack tolerance of the turn of a body: standard deviation, for --bodies.  [default: 3]"
    )
    contacts: str | None = opt(
        None,
        "Plane faces of two bodies that touch in the model stay on each other, for --bodies; they come apart by MM "
        "(standard deviation).  [default: half of --gap-mm]",
        metavar="[MM]",
        if_alone=USUAL_CONTACTS,
    )
    bending_mm: float | None = opt(
        None,
        "With --bodies: long plates may have bent, too. MM is the root mean square bow of a plate of 1 m; without a "
        f"number {USUAL_BENDING} mm.",
        "--bending",
        metavar="[MM]",
        if_alone=USUAL_BENDING,
    )

    def to_options(self) -> BodiesOptions | None:
        """Check and return them as the calibration takes them; None without --bodies.

        Raises `InputError` when a value is not positive, is given without --bodies, or the file cannot be read.
        """
        from cad.workpiece.bodies import BodiesSource

        choice = self.to_choice()
        options = None if choice is None else choice.to_options(self.groups())
        return options if options is None or self.file is None else replace(options, source=BodiesSource.of(self.file))

    def to_choice(self) -> MovingChoice | None:
        """Check and return them as the picker takes them, None without --bodies; errors as in `to_options`."""
        from cad.workpiece.moving import MovingChoice
        from wpcal.core.errors import InputError

        if self.bodies is None:
            for value, what in (
                (self.tack_mm, "--tack-mm and --tack-mrad are"),
                (self.tack_mrad, "--tack-mm and --tack-mrad are"),
                (self.contacts, "--contacts is"),
                (self.bending_mm, "--bending is"),
            ):
                if value is not None:
                    raise InputError(f"{what} for --bodies")
            return None
        try:
            contact_mm = None if self.contacts in (None, USUAL_CONTACTS) else float(str(self.contacts))
        except ValueError:
            raise InputError(f"--contacts: expected a number of mm, got {shown(self.contacts)}") from None
        keeps = self.contacts is not None
        return MovingChoice(True, self.tack_mm, self.tack_mrad, keeps, contact_mm, self.bending_mm)

    @property
    def file(self) -> Path | None:
        """The file of bodies."""
        return None if self.bodies in (None, EACH_SOLID) else Path(str(self.bodies))

    def groups(self) -> tuple[BodyGroup, ...]:
        """Read the file of bodies."""
        if self.file is None:
            return ()
        from cad.workpiece.bodies import read_bodies

        return read_bodies(self.file)
