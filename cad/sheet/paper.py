"""The layout of a sheet: paper size, places of views, table and title block, and scales. Lengths are mm on paper."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cad.sheet.views import View
from wpcal.core.arrays import FloatArray

STEPS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
"""Scales are 1:n or n:1, where n is one of these times a power of ten: easy to divide by in one's head."""
ROUND_OFF = 1.0 + 1e-12  #: Relative tolerance, so that a size that fits exactly does fit.
ORTHOGONAL_SHARE = 0.6
"""Share of the width for front, left and top. The rest is for the iso view, in which a person finds the points."""


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle on paper, origin at its lower left."""

    x: float
    y: float
    width: float
    height: float

    @property
    def right(self) -> float:
        """Its right edge."""
        return self.x + self.width

    @property
    def top(self) -> float:
        """Its upper edge."""
        return self.y + self.height

    @property
    def centre(self) -> FloatArray:
        """Its middle, shape (2,)."""
        return np.array([self.x + self.width / 2, self.y + self.height / 2])


@dataclass(frozen=True, slots=True)
class Paper:
    """A paper size (landscape) and the sizes of what is drawn on it, mm."""

    name: str
    width: float
    height: float
    margin: float
    #: Height of capital letters. ISO 3098 has 2.5 and 3.5; the smaller paper is read at a shorter distance.
    text: float
    row: float  #: Height of a row that is filled in by hand.
    title: float  #: Width of the title block.
    label_room: float  #: Free space around a view, for labels.

    @property
    def frame(self) -> Box:
        """The border of the drawing."""
        return Box(self.margin, self.margin, self.width - 2 * self.margin, self.height - 2 * self.margin)

    @property
    def most_points(self) -> int:
        """Number of rows that leaves half of the height to the views."""
        return int(self.frame.height / 2 / self.row) - HEADING_ROWS


HEADING_ROWS = 2  #: Rows of the table's heading.
LEAST_ROWS = 6  #: The title block needs at least the height of this many rows.
A3 = Paper("A3", 420.0, 297.0, 10.0, 2.5, 8.0, 120.0, 15.0)
A4 = Paper("A4", 297.0, 210.0, 7.0, 1.8, 6.5, 82.0, 11.0)
PAPERS = {paper.name: paper for paper in (A3, A4)}


@dataclass(frozen=True, slots=True, eq=False)
class OnPaper:
    """The place of a view on the paper."""

    view: View
    scale: float  #: mm on paper per mm of the part.
    offset: FloatArray  #: shape (2,). Place of the origin of the view's plane on paper, mm.
    cell: Box  #: The area for the view and its labels.

    def on_paper(self, uv: FloatArray) -> FloatArray:
        """Return places on paper, mm, for places in the plane of the view.

        `uv`: shape (..., 2). In the plane of the view, mm of the part.
        """
        return np.asarray(uv * self.scale + self.offset, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class SheetLayout:
    """The places of everything on a sheet."""

    paper: Paper
    places: tuple[OnPaper, ...]  #: Front, left, top, iso.
    table: Box
    title: Box


def lay_out(paper: Paper, views: tuple[View, ...], rows: int) -> SheetLayout:
    """Place the views in first-angle projection (ISO 5456-2) with the table and the title block below them."""
    frame = paper.frame
    height = (max(rows, LEAST_ROWS) + HEADING_ROWS) * paper.row
    table = Box(frame.x, frame.y, frame.width - paper.title, height)
    title = Box(table.right, frame.y, paper.title, height)
    area = Box(frame.x, frame.y + height, frame.width, frame.height - height)
    orthogonal = Box(area.x, area.y, ORTHOGONAL_SHARE * area.width, area.height)
    places = _orthogonal(paper, views[:3], orthogonal)
    used = max(place.cell.right for place in places)
    rest = Box(used, area.y, area.right - used, area.height)
    return SheetLayout(paper, (*places, _alone(paper, views[3], rest)), table, title)


def nice_scale(largest: float) -> float:
    """Return the largest standard scale (1:3, 1:25, 2:1 …) that is not larger than a number."""
    decade = 10.0 ** math.floor(abs(math.log10(largest)))
    if largest >= 1.0:
        return max(step * decade for step in STEPS if step * decade <= largest * ROUND_OFF)
    return 1.0 / min(
        step * power for step in STEPS for power in (decade, 10.0 * decade) if step * power * largest >= 1 / ROUND_OFF
    )


def scale_words(scale: float) -> str:
    """Write a scale as ``1:5`` or ``2:1``."""
    return f"1:{1 / scale:.4g}" if scale < 1 else f"{scale:.4g}:1"


def _orthogonal(paper: Paper, views: tuple[View, ...], area: Box) -> tuple[OnPaper, ...]:
    """Put front at the upper left, left to its right, and top below it, aligned with each other."""
    front, left, top = views
    sizes = [view.box[1] - view.box[0] for view in views]
    widths = (max(sizes[0][0], sizes[2][0]), sizes[1][0])
    heights = (max(sizes[0][1], sizes[1][1]), sizes[2][1])
    room = 2 * paper.label_room
    largest = min((area.width - 2 * room) / sum(widths), (area.height - 2 * room) / sum(heights))
    scale = nice_scale(largest)
    columns, lines = [w * scale + room for w in widths], [h * scale + room for h in heights]
    unused = (area.height - sum(lines)) / 2
    lines = [line + unused for line in lines]
    upper, lower = area.top - lines[0], area.top - lines[0] - lines[1]
    cells = (
        Box(area.x, upper, columns[0], lines[0]),
        Box(area.x + columns[0], upper, columns[1], lines[0]),
        Box(area.x, lower, columns[0], lines[1]),
    )
    return tuple(_centred(view, scale, cell) for view, cell in zip((front, left, top), cells, strict=True))


def _alone(paper: Paper, view: View, cell: Box) -> OnPaper:
    size = view.box[1] - view.box[0]
    room = 2 * paper.label_room
    return _centred(view, float(min((cell.width - room) / size[0], (cell.height - room) / size[1])), cell)


def _centred(view: View, scale: float, cell: Box) -> OnPaper:
    low, high = view.box
    return OnPaper(view, scale, cell.centre - scale * (low + high) / 2, cell)
