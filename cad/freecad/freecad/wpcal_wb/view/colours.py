# SPDX-License-Identifier: MIT
"""The colours of predicted errors: those of wpcal's pages."""

from __future__ import annotations

import math
from typing import Tuple

Colour = Tuple[float, float, float]  #: Red, green, blue from 0 to 1.

STOPS = (
    (0.0, (17, 122, 139)),
    (0.3, (63, 167, 122)),
    (0.6, (240, 200, 70)),
    (0.8, (236, 130, 50)),
    (1.0, (190, 30, 45)),
)
"""From zero to the tolerance: teal, yellow, red. The order remains visible in grey and for colour-blind people."""
BEYOND = (122, 31, 162)  #: Violet: above the tolerance. No colour of the scale.
UNKNOWN = (138, 148, 160)  #: Grey: without a predicted error, and refused seams.
RESIDUAL = (214, 36, 110)  #: No colour scale has the colour of the residuals.
ROUND_OFF = 1e-9  #: An error of exactly the tolerance is on the scale, whatever the last digit.


def colour_of(share: float | None) -> Colour:
    """Return the colour of an error by its share of the tolerance; None or NaN if it is not known."""
    if share is None or not math.isfinite(share):
        return unit(UNKNOWN)
    if share > 1 + ROUND_OFF:
        return unit(BEYOND)
    share = min(max(share, 0.0), 1.0)
    above = next(index for index in range(1, len(STOPS)) if share <= STOPS[index][0])
    (low, first), (high, last) = STOPS[above - 1], STOPS[above]
    part = (share - low) / (high - low)
    return unit(tuple(a + (b - a) * part for a, b in zip(first, last)))


def unit(colour: tuple[float, ...]) -> Colour:
    """Return a colour of 0…255 as Coin wants it."""
    red, green, blue = (value / 255.0 for value in colour)
    return red, green, blue


def css(colour: Colour) -> str:
    """Return a colour as style sheets of Qt want it."""
    return "rgb({},{},{})".format(*(round(255 * value) for value in colour))


def legend_style() -> str:
    """Return the background of a bar that shows the scale from zero to the tolerance."""
    stops = ", ".join(f"stop:{share:g} {css(unit(colour))}" for share, colour in STOPS)
    return f"background: qlineargradient(x1:0, y1:0, x2:1, y2:0, {stops});"
