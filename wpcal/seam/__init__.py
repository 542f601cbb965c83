"""Weld seams of a `BrepGraph`: found (`find`), chained and given frames (`path`), accepted or not (`judge`)."""

from typing import TYPE_CHECKING

from wpcal.core.lazy_names import lazy_names
from wpcal.seam.options import ConcaveEdges, SeamOptions, StepOptions
from wpcal.seam.seam import JointType, Seam, SeamFrames, SeamSource, WeldType

if TYPE_CHECKING:
    from wpcal.seam.detect import detect_seams

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
__getattr__, __dir__ = lazy_names(__name__, {"detect_seams": "wpcal.seam.detect:detect_seams"})  # the search is large
