"""Weld seams: found on a `BrepGraph`, chained, cut into steps, with frames."""

from wpcal.seam.detect import ConcaveEdges, SeamOptions, detect_seams
from wpcal.seam.discretise import StepOptions
from wpcal.seam.seam import JointType, Seam, SeamFrames, WeldType

__all__ = [
    "ConcaveEdges",
    "JointType",
    "Seam",
    "SeamFrames",
    "SeamOptions",
    "StepOptions",
    "WeldType",
    "detect_seams",
]
