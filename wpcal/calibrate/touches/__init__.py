"""Touches on points, faces and edges together: what each lies on, the fit, and what holds the part."""

from wpcal.calibrate.touches.targets import GraphTargets
from wpcal.calibrate.touches.touches import NamedAxis, Nearest, Touches, TouchTargets

__all__ = ["GraphTargets", "NamedAxis", "Nearest", "TouchTargets", "Touches"]
