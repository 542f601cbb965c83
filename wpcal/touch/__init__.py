"""Touches on points, faces and edges together: what each lies on, the fit, and what holds the part."""

from wpcal.touch.calibrate import calibrate_touches
from wpcal.touch.model import GraphTargets
from wpcal.touch.resolve import named_axes, touches_of
from wpcal.touch.touches import Nearest, Touches, TouchTargets

__all__ = ["GraphTargets", "Nearest", "TouchTargets", "Touches", "calibrate_touches", "named_axes", "touches_of"]
