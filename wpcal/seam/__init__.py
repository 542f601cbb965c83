"""Weld seams: found on a `BrepGraph`, chained, cut into steps, with frames."""

from wpcal.seam.detect import detect_seams
from wpcal.seam.options import ConcaveEdges, SeamOptions, StepOptions
from wpcal.seam.seam import JointType, Seam, SeamFrames, SeamSource, WeldType

__all__ = [
    "ConcaveEdges",
    "JointType",
    "Seam",
    "SeamFrames",
    "SeamOptions",
    "SeamSource",
    "StepOptions",
    "WeldType",
    "detect_seams",
]
