"""Options of `wpcal export`, `audit` and `touchup`: how the torch is held, and its shape."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from wpcal.core.options import group, opt

if TYPE_CHECKING:
    from wpcal.controllers.audit.programs import Surroundings
    from wpcal.robot.torch.attitude import TorchSettings
    from wpcal.robot.torch.shape import TorchShape


@dataclass(frozen=True, slots=True, kw_only=True)
class SpinAsked:
    """How far the tool may turn about the wire."""

    spin_range_deg: float | None = opt(
        None,
        "How far the tool may turn about the wire to turn less along a seam; 0: it follows the travel, or the neck as "
        "it was felt.  [default: 180; 0 if the torch of seams.json has a bent neck]",
    )

    def spun(self, torch: TorchSettings, shape: TorchShape) -> TorchSettings:
        """Return how the torch is held; the turn of a bent neck is fixed.

        Raises `InputError` if a turn is asked for with a bent neck.
        """
        from wpcal.core.errors import InputError

        if shape.bends and self.spin_range_deg:
            raise InputError(
                f"--spin-range-deg {self.spin_range_deg:g}: the neck of {shape.name} is free as it is turned in "
                "seams.json, and in no other way; leave the option away"
            )
        if self.spin_range_deg is not None:
            return replace(torch, spin_range_rad=math.radians(self.spin_range_deg))
        return torch if not shape.bends else replace(torch, spin_range_rad=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class TorchAsked:
    """The shape of the torch that is compared with the part."""

    wire_mm: float | None = opt(
        None, "From the tip of the wire to the nozzle.  [default: that of the torch in seams.json, else 20]"
    )
    nozzle_radius_mm: float | None = opt(
        None, "Radius of nozzle and neck.  [default: that of the torch in seams.json, else 11]"
    )
    torch_length_mm: float | None = opt(
        None, "Length of the torch that is compared.  [default: that of the torch in seams.json, else 300]"
    )

    def to_shape(self, felt: TorchShape | None = None) -> TorchShape:
        """Return the torch that is compared with the part.

        Raises `InputError` if options state other sizes than those of a torch with a neck.
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


@dataclass(frozen=True, slots=True, kw_only=True)
class TorchOfProgramAsked:
    """The torch and the tool centre point of a program that is read back."""

    tip: TorchSettings = group("wpcal.robot.torch.attitude:TorchSettings", only=("standoff_mm", "tool_axis"))
    shape: TorchAsked = group(TorchAsked)

    def to_surroundings(self, felt: TorchShape | None = None) -> Surroundings:
        """Return what the program is compared with; errors as `TorchAsked.to_shape`."""
        from wpcal.controllers.audit.programs import Surroundings

        torch = self.shape.to_shape(felt)
        return Surroundings(torch=torch, tool_axis=self.tip.tool_axis, standoff_mm=self.tip.standoff_mm)
