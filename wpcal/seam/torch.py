"""The torch with which reach and material are felt, unless the caller knows a better one."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StraightTorch:
    """A straight torch: a wire, then a round nozzle and body as wide as the nozzle.

    Parameters
    ----------
    stickout_mm : float
        From the tip of the wire to the mouth of the nozzle; only the wire is nearer.
    nozzle_mm : float
        Diameter of the nozzle, with a small clearance.
    length_mm : float
        From the tip to where the wrist has room to turn.
    """

    stickout_mm: float = 20.0
    nozzle_mm: float = 20.0
    length_mm: float = 300.0

    def __str__(self) -> str:
        """Describe the torch for people."""
        return (
            f"a straight torch of {self.length_mm:g} mm, nozzle {self.nozzle_mm:g} mm in diameter, "
            f"stick-out {self.stickout_mm:g} mm"
        )


USUAL_TORCH = StraightTorch()
"""A usual gas nozzle of 20 mm and a stick-out of 20 mm. Its length is that of a usual neck."""
