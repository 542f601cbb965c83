"""Options of `wpcal export` and `wpcal audit`: how the torch is held, and its shape."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import option
from wpcal.cli.shared_help import ANGLE, TRAVEL_ANGLE_HELP, WORK_ANGLE_HELP

if TYPE_CHECKING:
    from wpcal.robot.torch.attitude import TorchSettings
    from wpcal.robot.torch.shape import TorchShape


@dataclass(frozen=True, slots=True, kw_only=True)
class TipFlags:
    """Where the tool centre point is, and how the tool is turned to the wire."""

    standoff_mm: float = option(
        "--standoff-mm", type=float, default=0.0, show_default=True, help="Tool centre point back from the seam."
    )
    tool_axis: str = option(
        "--tool-axis",
        type=click.Choice(["z", "x"]),
        default="z",
        show_default=True,
        help="Axis of the tool along the wire.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TorchFlags:
    """How the torch is held at the seam."""

    work_angle_deg: float = option("--work-angle-deg", type=ANGLE, default=0.0, show_default=True, help=WORK_ANGLE_HELP)
    travel_angle_deg: float = option(
        "--travel-angle-deg", type=ANGLE, default=0.0, show_default=True, help=TRAVEL_ANGLE_HELP
    )
    tip: TipFlags
    spin_range_deg: float | None = option(
        "--spin-range-deg",
        type=float,
        help="How far the tool may turn about the wire to turn less along a seam; 0: it follows the travel, or the "
        "neck as it was felt.  [default: 180; 0 if the torch of seams.json has a bent neck]",
    )

    def to_settings(self, shape: TorchShape) -> TorchSettings:
        """Return the torch as the programs take it, angles in radians; the turn of a bent neck is fixed."""
        from wpcal.core.errors import InputError
        from wpcal.robot.torch.attitude import ToolAxis, TorchSettings

        work_rad, travel_rad = math.radians(self.work_angle_deg), math.radians(self.travel_angle_deg)
        if shape.neck is not None and self.spin_range_deg:
            raise InputError(
                f"--spin-range-deg {self.spin_range_deg:g}: the neck of {shape.name} is free as it is turned in "
                "seams.json, and in no other way; leave the option away"
            )
        usual_deg = 180.0 if shape.neck is None else 0.0
        spin_rad = math.radians(usual_deg if self.spin_range_deg is None else self.spin_range_deg)
        return TorchSettings(work_rad, travel_rad, self.tip.standoff_mm, ToolAxis(self.tip.tool_axis), spin_rad)


@dataclass(frozen=True, slots=True, kw_only=True)
class TorchShapeFlags:
    """The shape of the torch that is compared with the part."""

    wire_mm: float | None = option(
        "--wire-mm",
        type=float,
        help="From the tip of the wire to the nozzle.  [default: that of the torch in seams.json, else 20]",
    )
    nozzle_radius_mm: float | None = option(
        "--nozzle-radius-mm",
        type=float,
        help="Radius of nozzle and neck.  [default: that of the torch in seams.json, else 11]",
    )
    torch_length_mm: float | None = option(
        "--torch-length-mm",
        type=float,
        help="Length of the torch that is compared.  [default: that of the torch in seams.json, else 300]",
    )

    def to_shape(self, felt: TorchShape | None = None) -> TorchShape:
        """Return the torch that is compared with the part.

        Parameters
        ----------
        felt : TorchShape, optional
            The torch with which reach was felt, of ``seams.json``. The options change the sizes of a straight one.

        Raises
        ------
        InputError
            If options state other sizes than those of a torch with a neck.
        """
        from wpcal.core.errors import InputError
        from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape

        shape = felt or USUAL_TORCH
        stated = {
            name: value
            for name, value in (
                ("wire_mm", self.wire_mm),
                ("nozzle_radius_mm", self.nozzle_radius_mm),
                ("length_mm", self.torch_length_mm),
            )
            if value is not None and value != getattr(shape, name)
        }
        if not stated:
            return shape
        if shape.neck is not None or shape.mouth_radius_mm is not None:
            raise InputError(
                f"seams.json names {shape}, and the options state another torch "
                f"({', '.join(f'{name} {value:g}' for name, value in stated.items())}): leave the options away, or "
                "find the seams again with your torch (--torch FILE of wpcal calibrate)"
            )
        sizes = {"wire_mm": shape.wire_mm, "nozzle_radius_mm": shape.nozzle_radius_mm, "length_mm": shape.length_mm}
        wire_mm, nozzle_mm, length_mm = (sizes | stated).values()
        return TorchShape(wire_mm, nozzle_mm, length_mm)
