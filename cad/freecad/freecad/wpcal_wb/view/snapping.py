# SPDX-License-Identifier: MIT
"""Which feature a click was meant for.

FreeCAD takes the edge or the face in front of a marker that lies exactly on it. A person who clicks a corner means the
corner, though the pointer is a few pixels beside it.
"""

from __future__ import annotations

import math
from typing import Any, Mapping

SNAP_PX = 8.0
"""A click so near to a marker is meant for it. Markers are 7 pixels wide."""
DEPTH_SHARE = 3.0
"""A feature farther behind the clicked place than so many times the way beside it lies on another part of the model."""
LONG_MM = 1000.0
"""Places are projected to whole pixels: a long line gives the size of one more exactly."""


def feature_under(view: Any, point: Any, features: Mapping[str, Any], frame: Any) -> str | None:
    """Return the name of the feature that a click was meant for; None if none is near.

    Parameters
    ----------
    view : Gui.View3DInventor
    point : FreeCAD.Vector
        What was clicked, in the document.
    features : mapping of str to dict
        With `p_mm`, in the part.
    frame : FreeCAD.Placement
        Where the part lies in the document.
    """
    clicked = view.getPointOnScreen(point)
    snap_mm = SNAP_PX * _mm_per_pixel(view, point)
    near = []
    for name, feature in features.items():
        place = frame.multVec(type(point)(*feature["p_mm"]))
        if (place - point).Length <= DEPTH_SHARE * snap_mm:
            pixels = math.dist(clicked, view.getPointOnScreen(place))
            if pixels <= SNAP_PX:
                near.append((pixels, name))
    return min(near)[1] if near else None


def _mm_per_pixel(view: Any, point: Any) -> float:
    """Return the size of a pixel at a place, mm: from a line across the view."""
    across = view.getCameraOrientation().multVec(type(point)(1, 0, 0))
    pixels = math.dist(view.getPointOnScreen(point), view.getPointOnScreen(point + across * LONG_MM))
    return LONG_MM / max(pixels, 1.0)
