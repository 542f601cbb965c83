"""The map of `wpcal place` as a picture."""

from __future__ import annotations

import numpy as np

from wpcal.pages.draw.svg import circle, rect, svg, text
from wpcal.planning.sequence.place import PlaceMap

CELL, LEFT, TOP, LETTER = 34, 70, 60, 7  #: Pixels: of a place, of the margins, and of a letter.
NOW, BEST = "#222", "#06c"
"""Colours of the place in the cell file, and of the best one."""


def place_svg(found: PlaceMap) -> str:
    """Return the map as an SVG picture: green where all seams are reachable, red where none is."""
    a, b = found.share.shape
    place = found.best
    best = int(np.argmin(np.abs(found.x_mm - place.x_mm))), int(np.argmin(np.abs(found.y_mm - place.y_mm)))
    title = (
        f"Reachable length in %: now {100 * found.now:.0f} (black circle), best {100 * place.share:.0f} with "
        f"{place.words(found.moved)} (blue circle)"
    )
    below = "x and y of world, mm, from where the cell has it; looked at: ends and middles of seams, with collisions"
    bottom = TOP + CELL * b
    elements = [each for i in range(a) for j in range(b) for each in _box(found, i, j)]
    for (i, j), colour in ((((a - 1) // 2, (b - 1) // 2), NOW), (best, BEST)):
        elements.append(circle(LEFT + CELL * (i + 0.5), TOP + CELL * (b - j - 0.5), 8, colour, 3))
    elements += [text(LEFT, 24, title, 13), text(LEFT, 44, below, 13)]
    elements += [text(LEFT + CELL * i + 2, bottom + 18, f"{x:g}", 13) for i, x in enumerate(found.x_mm.tolist())]
    middles = (bottom - CELL * j - CELL // 2 + 5 for j in range(b))
    elements += [text(6, y, f"{value:g}", 13) for y, value in zip(middles, found.y_mm.tolist(), strict=True)]
    return svg(max(LEFT + CELL * a + 20, LEFT + LETTER * len(title)), bottom + 60, elements)


def _box(found: PlaceMap, i: int, j: int) -> list[str]:
    value = found.share[i, j]
    colour = f"hsl({120 * value:.0f},60%,{72 - 22 * value:.0f}%)"
    told = f"x {found.x_mm[i]:g}, y {found.y_mm[j]:g} mm: {100 * value:.0f} %"
    x, y = LEFT + CELL * i, TOP + CELL * (found.share.shape[1] - 1 - j)
    box = rect(x, y, CELL, CELL, fill=colour, told=told)
    return [box, text(x + 4, y + CELL - 4, f"{100 * value:.0f}", 9, "#444")]
