"""Usual motions of a torch, and the options about them: export, plans, reach and touches share these numbers."""

from __future__ import annotations

from typing import Any

from wpcal.core.options import opt, opt_deg

APPROACH_MM = 50.0  #: Distance along the wire before and after a seam: it clears a nozzle of common size.
WIRE_RADIUS_MM = 0.6  #: Radius of a wire of 1.2 mm, the thickest that is usual.
AIR_CLEARANCE_MM = 3.0
"""Least distance of wire and nozzle from the part on moves through the air: above the errors of a calibration and of a
path, and above the bend of a wire that sticks out by 20 mm."""
AIR_SPEED_MM_S = 100.0  #: Speed of approach and retract.
WELD_SPEED_MM_S = 8.0
"""Speed along a seam: common for a MAG fillet with a throat of 4 to 5 mm. For plans and programs,
unless weld data state one."""


def work_angle(default_deg: float = 0.0) -> Any:
    """Declare the work angle of a torch, rad."""
    what = "Work angle of the torch: from the bisector, + towards y."
    return opt_deg(default_deg, what, "--work-angle-deg", least=-180.0, most=180.0)


def travel_angle(default_deg: float = 0.0) -> Any:
    """Declare the travel angle of a torch, rad."""
    what = "Travel angle of the torch: + push (0 to 15 is usual), - drag."
    return opt_deg(default_deg, what, "--travel-angle-deg", least=-180.0, most=180.0)


def torch_range(default_deg: float = 15.0) -> Any:
    """Declare how far a plan may turn the torch from its target angles, rad."""
    what = "Largest deviation of the torch from its target angles."
    return opt_deg(default_deg, what, "--torch-range-deg", least=-180.0, most=180.0)


def standoff() -> Any:
    """Declare how far the tool centre point of the controller is behind the tip of the wire, mm."""
    return opt(0.0, "Tool centre point back from the tip of the wire, along it.", least=0)


def weld_speed() -> Any:
    """Declare the speed along a seam, mm/s."""
    return opt(WELD_SPEED_MM_S, "Speed along the seam.", "--speed-mm-s", above=0)
