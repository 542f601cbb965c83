"""Rays through a part: which of many rays hit a face within a length."""

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.hits import find_hits
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray

START_MM = 1.0  #: Rays start this far outside the part, clear of a gap and of the faces beside the joint.
TOOL_MM = 300.0
"""Length of a straight tool: with a usual torch neck, from the tip of the wire to where the wrist has room to turn."""


def is_blocked(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    origins: FloatArray,
    rays: FloatArray,
    *,
    length_mm: FloatArray | float = TOOL_MM,
) -> BoolArray:
    """Tell which rays hit a face of the part, shape (m,).

    `origins`, `rays`: shape (m, 3). Starts (mm) and unit directions in `part`.
    `length_mm`: shape (m,). Where the rays end.
    """
    blocked = np.zeros(len(origins), dtype=bool)
    blocked[find_hits(graph, trimmed, origins, rays, length_mm=length_mm).ray] = True
    return blocked
