"""The options for weldments whose plates may have moved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import option
from wpcal.core.wording import shown

if TYPE_CHECKING:
    from cad.pick.moving import MovingChoice
    from cad.workpiece.bodies import BodiesOptions, BodyGroup

EACH_SOLID = "each"
"""What ``--bodies`` means without a file."""
USUAL_BENDING = "1"
"""What ``--bending`` means without a number; `wpcal.calibrate.observe.bending` has the reason."""
USUAL_CONTACTS = "usual"
"""What ``--contacts`` means without a number."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BodiesFlags:
    """Whether the plates of a weldment may have moved."""

    bodies: str | None = option(
        "--bodies",
        metavar="[FILE]",
        is_flag=False,
        flag_value=EACH_SOLID,
        callback=lambda _context, _parameter, value: _json_file(value),
        help=(
            "The bodies may have moved since the model: each solid, the members of a part of one solid, or those of "
            "FILE (JSON: names, solids, tack_mm, tack_mrad). Seams are where moved faces meet."
        ),
    )
    tack_mm: float | None = option(
        "--tack-mm",
        type=float,
        help="Tack tolerance of the place of a body: standard deviation, for --bodies.  [default: 1]",
    )
    tack_mrad: float | None = option(
        "--tack-mrad",
        type=float,
        help="Tack tolerance of the turn of a body: standard deviation, for --bodies.  [default: 3]",
    )

    def to_options(self) -> BodiesOptions | None:
        """Check and return them as the calibration takes them; None without --bodies.

        Raises
        ------
        InputError
            When a tolerance is not positive, is given without --bodies, or the file cannot be read.
        """
        from cad.workpiece.bodies import BodiesOptions, BodiesSource
        from wpcal.core.errors import InputError

        if self.bodies is None:
            if self.tack_mm is not None or self.tack_mrad is not None:
                raise InputError("--tack-mm and --tack-mrad are for --bodies")
            return None
        options = BodiesOptions.of(self.tack_mm, self.tack_mrad, self.groups())
        return options if self.file is None else replace(options, source=BodiesSource.of(self.file))

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


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactBodiesFlags(BodiesFlags):
    """Whether they may have moved, and whether what lay on each other still does."""

    contacts: str | None = option(
        "--contacts",
        metavar="[MM]",
        is_flag=False,
        flag_value=USUAL_CONTACTS,
        help=(
            "Plane faces of two bodies that touch in the model stay on each other, for --bodies; they come apart by "
            "MM (standard deviation).  [default: half of --gap-mm]"
        ),
    )

    def to_options(self) -> BodiesOptions | None:
        """Check and return them; errors as in `BodiesFlags.to_options`."""
        from wpcal.core.errors import InputError

        options = BodiesFlags.to_options(self)
        if options is None and self.contacts is not None:
            raise InputError("--contacts is for --bodies")
        if options is None or self.contacts is None:
            return options
        try:
            sigma_mm = None if self.contacts == USUAL_CONTACTS else float(self.contacts)
        except ValueError:
            raise InputError(f"--contacts: expected a number of mm, got {shown(self.contacts)}") from None
        return replace(options, keeps_contacts=True, contact_sigma_mm=sigma_mm)


@dataclass(frozen=True, slots=True, kw_only=True)
class FitBodiesFlags(ContactBodiesFlags):
    """Whether they may have moved and bent, and whether what lay on each other still does."""

    bending_mm: float | None = option(
        "--bending",
        metavar="[MM]",
        type=float,
        is_flag=False,
        flag_value=USUAL_BENDING,
        help=(
            "With --bodies: long plates may have bent, too. MM is the root mean square bow of a plate of 1 m; "
            f"without a number {USUAL_BENDING} mm."
        ),
    )

    def to_options(self) -> BodiesOptions | None:
        """Check and return them; errors as in `BodiesFlags.to_options`."""
        from wpcal.core.errors import InputError

        options = ContactBodiesFlags.to_options(self)
        if options is None and self.bending_mm is not None:
            raise InputError("--bending is for --bodies")
        return None if options is None else replace(options, bending_mm=self.bending_mm)

    def to_choice(self) -> MovingChoice | None:
        """Check and return them as the picker takes them, None without --bodies; errors as in `to_options`."""
        from cad.pick.moving import MovingChoice

        options = self.to_options()
        if options is None:
            return None
        contacts = (options.keeps_contacts, options.contact_sigma_mm)
        return MovingChoice(True, self.tack_mm, self.tack_mrad, *contacts, options.bending_mm)


def _json_file(value: str | None) -> str | None:
    """Refuse a file that is no JSON file: what follows ``--bodies`` is taken for its file."""
    if value is not None and value != EACH_SOLID and Path(value).suffix.lower() != ".json":
        raise click.UsageError(
            f"--bodies: expected a JSON file of bodies, got {shown(value)}; without a file, put --bodies last or "
            "before another option"
        )
    return value
