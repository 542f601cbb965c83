"""Touches on points, faces and edges together: what each lies on, the fit, and what holds the part."""

from wpcal.calibrate.touches.problem import calibrate_touches
from wpcal.calibrate.touches.targets import GraphTargets
from wpcal.calibrate.touches.touches import Nearest, Touches, TouchTargets

__all__ = ["GraphTargets", "Nearest", "TouchTargets", "Touches", "calibrate_touches"]
