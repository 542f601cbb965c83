"""The options for weldments whose plates may have moved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from wpcal.cli.option_groups import option

if TYPE_CHECKING:
    from cad.workpiece.bodies import BodiesOptions, BodyGroup

EACH_SOLID = "each"
"""What ``--bodies`` means without a file."""
USUAL_BENDING = "1"
"""What ``--bending`` means without a number; `wpcal.calibrate.bodies.bending` has the reason."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BodiesFlags:
    """Whether the plates of a weldment may have moved."""

    bodies: str | None = option(
        "--bodies",
        metavar="[FILE]",
        is_flag=False,
        flag_value=EACH_SOLID,
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
    bending_mm: float | None = option(
        "--bending",
        metavar="[MM]",
        type=float,
        is_flag=False,
        flag_value=USUAL_BENDING,
        help=(
            "Long plates may have bent, too, for --bodies: MM is the root mean square bow of a plate of 1 m; "
            f"without a number {USUAL_BENDING} mm."
        ),
    )

    def to_options(self) -> BodiesOptions | None:
        """Check and return them as the calibration takes them; None without --bodies.

        Raises
        ------
        InputError
            When a tolerance is not positive, is given without --bodies, or the file cannot be read.
        """
        from cad.workpiece.bodies import BodiesOptions
        from wpcal.core.errors import InputError

        if self.bodies is None:
            if self.tack_mm is not None or self.tack_mrad is not None:
                raise InputError("--tack-mm and --tack-mrad are for --bodies")
            if self.bending_mm is not None:
                raise InputError("--bending is for --bodies")
            return None
        return replace(BodiesOptions.of(self.tack_mm, self.tack_mrad, self.groups()), bending_mm=self.bending_mm)

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
