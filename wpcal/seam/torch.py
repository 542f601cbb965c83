"""The shape of the torch: seams are judged with it, and every pose and move of a program is compared with the part."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wpcal.core.errors import InputError


@dataclass(frozen=True, slots=True)
class TorchShape:
    """A straight torch: a wire, and around it from its mouth on a round nozzle and neck of one radius.

    Parameters
    ----------
    wire_mm : float
        From the tip of the wire to the mouth of the nozzle; only the wire is nearer to the joint. 20 mm is usual with
        spray arcs.
    nozzle_radius_mm : float
        Outer radius. Gas nozzles of usual size have 10 to 11 mm.
    length_mm : float
        From the tip of the wire to where the wrist has room to turn: a usual neck has 300 mm. What comes behind is not
        compared with the part.

    Raises
    ------
    InputError
        When a length is not positive, or the nozzle begins behind the end of the torch.
    """

    wire_mm: float = 20.0
    nozzle_radius_mm: float = 11.0
    length_mm: float = 300.0

    def __post_init__(self) -> None:
        for name in ("wire_mm", "nozzle_radius_mm", "length_mm"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"torch {name}: expected a positive number, got {getattr(self, name):g}")
        if self.wire_mm >= self.length_mm:
            raise InputError(f"torch: the wire ({self.wire_mm:g} mm) is longer than the torch ({self.length_mm:g} mm)")

    def __str__(self) -> str:
        """Describe the torch for people."""
        return (
            f"a straight torch of {self.length_mm:g} mm, nozzle radius {self.nozzle_radius_mm:g} mm, "
            f"wire {self.wire_mm:g} mm"
        )


USUAL_TORCH = TorchShape()
"""The torch that is assumed unless the caller states another one."""
