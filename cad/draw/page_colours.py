"""The colours of the pages, for pictures in other viewers. They are those of ``colours.js`` and ``viewer.js``."""

from __future__ import annotations

import math

PART, UNKNOWN, BEYOND, RESIDUAL = "#b9c2cc", "#8a94a0", "#7a1fa2", "#d6246e"
"""A part; a seam without a predicted error; an error beyond the tolerance; a residual."""
AXES = ("#d63c3c", "#2f9e44", "#2f6fde")
"""The axes x, y, z of a frame."""
STOPS = (
    (0.0, (17, 122, 139)),
    (0.3, (63, 167, 122)),
    (0.6, (240, 200, 70)),
    (0.8, (236, 130, 50)),
    (1.0, (190, 30, 45)),
)
"""From zero to the tolerance: teal, yellow, red."""
_ROUND_OFF = 1e-9


def colour_of(share: float) -> str:
    """Return the colour of a share of the tolerance, as ``#rrggbb``."""
    if not math.isfinite(share):
        return UNKNOWN
    if share > 1.0 + _ROUND_OFF:
        return BEYOND
    share = min(max(share, 0.0), 1.0)
    above = max(next(i for i, (stop, _) in enumerate(STOPS) if share <= stop), 1)
    (begin, low), (end, high) = STOPS[above - 1], STOPS[above]
    mixed = (math.floor(a + (b - a) * (share - begin) / (end - begin) + 0.5) for a, b in zip(low, high, strict=True))
    return "#" + "".join(f"{value:02x}" for value in mixed)
