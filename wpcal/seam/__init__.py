"""Weld seams of a `BrepGraph`: found (`find`), chained and given frames (`path`), accepted or not (`judge`)."""

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
