"""The drawing of a sheet as a DXF document: one unit is one mm on paper, and each kind of line has its own layer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from ezdxf.enums import TextEntityAlignment as Align
from ezdxf.fonts import fonts

from cad.sheet.fonts import FONT
from cad.sheet.labels import Label, place_labels
from cad.sheet.paper import Box, OnPaper, Paper, SheetLayout
from wpcal.core.arrays import FloatArray, IntArray

LAYERS = {"BORDER": (7, 50), "OUTLINE": (7, 35), "SMOOTH": (8, 13), "POINTS": (1, 25), "LABELS": (7, 18),
          "AXES": (5, 25), "TABLE": (7, 18), "TEXT": (7, 18)}  # fmt: skip
"""Colour (AutoCAD index) and pen in 1/100 mm. ISO 128: 0.35 mm for visible edges, half of that for thin lines."""
MILLIMETRES = 4  #: The value of $INSUNITS for mm.
DOT = 0.4  #: Radius of a point's mark, in heights of text.
BALLOON = 0.95  #: Radius of the circle around a number, in heights of text.
SIGN = 1.2  #: Height of a sign, in heights of text.
LABEL_TEXT = 1.2  #: Names at points are larger than other text, because people look for them.
CIRCLE_CORNERS = 24
ARROW = 5.0  #: Length of an arrow in the plane of a view, in heights of text.
Strokes = tuple[tuple[tuple[float, float], ...], ...]  #: Polylines of a sign, in a square of 1 by 1.
ALONG_VIEW = 0.2
"""A way whose part in the plane of a view is shorter than this runs along the view: no arrow is drawn."""
AXIS_PART = 0.55  #: Length of the axes in the corner of a view, relative to the room for labels.


@dataclass(frozen=True, slots=True)
class SheetRow:
    """One point or weld: a line of the table as text, and its label."""

    number: str
    name: str
    cells: tuple[str, ...] = ()  #: What the table says after the name.
    #: Unit vector in `part` of the move that ends at the point; drawn as an arrow.
    way: tuple[float, float, float] | None = None
    start: tuple[float, float, float] | None = None  #: In `part`, mm. An arrow comes from here to the middle of a weld.
    symbol: Strokes = ()  #: Behind the name of a label, and in the table.


@dataclass(frozen=True, slots=True)
class Pen:
    """Draws lines, boxes and text in the model space of a DXF document. Lengths are mm on paper."""

    space: Any
    paper: Paper

    def line(self, a: FloatArray | Sequence[float], b: FloatArray | Sequence[float], layer: str) -> None:
        """Draw a line. `a`, `b`: shape (2,). Its ends on paper, mm."""
        self.space.add_line(tuple(map(float, a)), tuple(map(float, b)), dxfattribs={"layer": layer})

    def sign(self, strokes: Strokes, x: float, y: float, layer: str = "TEXT") -> None:
        """Draw a sign as high as a letter, its left edge at `x` and its middle at `y`, mm."""
        size = SIGN * self.paper.text
        for stroke in strokes:
            corners = [(x + size * u, y + size * (v - 0.5)) for u, v in stroke]
            self.space.add_lwpolyline(corners, dxfattribs={"layer": layer})

    def box(self, box: Box, layer: str) -> None:
        """Draw a rectangle."""
        corners = [(box.x, box.y), (box.right, box.y), (box.right, box.top), (box.x, box.top)]
        self.space.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})

    def text(
        self, text: str, x: float, y: float, size: float = 1.0, layer: str = "TEXT", *, align: Align = Align.MIDDLE_LEFT
    ) -> None:
        """Write one line at x, y (mm); `size` is relative to the height of the paper's text."""
        height = size * self.paper.text
        clean = text.replace("%%", "% %")  # in DXF, %%d and others are signs
        self.space.add_text(clean, height=height, dxfattribs={"layer": layer, "style": "SHEET"}).set_placement(
            (float(x), float(y)), align=align
        )

    def width(self, text: str, size: float = 1.0) -> float:
        """Return how wide a text is, mm."""
        return float(fonts.make_font(FONT, size * self.paper.text).text_width(text))

    def fitted(self, text: str, width: float, size: float = 1.0) -> str:
        """Cut a text that is wider than `width` (mm), with dots at its end."""
        if self.width(text, size) <= width:
            return text
        while text and self.width(f"{text}…", size) > width:
            text = text[:-1]
        return f"{text.rstrip()}…"


def draw_views(pen: Pen, layout: SheetLayout, rows: Sequence[SheetRow]) -> list[list[Label]]:
    """Draw the views with their points and labels, and return the labels of each view."""
    return [_draw_view(pen, place, rows) for place in layout.places]


def _draw_view(pen: Pen, place: OnPaper, rows: Sequence[SheetRow]) -> list[Label]:
    view, room = place.view, pen.paper.label_room
    drawn = place.on_paper(view.segments)
    for layer, segments in (("OUTLINE", drawn), ("SMOOTH", place.on_paper(view.smooth))):
        for chain in chained(segments):
            pen.space.add_lwpolyline(chain.tolist(), dxfattribs={"layer": layer})
    p, text = place.on_paper(view.p), pen.paper.text
    pen.text(view.axes.name, place.cell.x + 0.3 * room, place.cell.top - 0.3 * room, 1.1)
    axes = np.concatenate([_axes(pen, place), _arrows(pen, place, p, rows)])
    sizes = np.array([[_label_width(pen, row), 2 * BALLOON * text] for row in rows])
    clear = Box(place.cell.x + 1, place.cell.y + 1, place.cell.width - 2, place.cell.height - 0.6 * room - 1)
    labels = place_labels(p, sizes, drawn, clear, avoid=axes)
    for point, seen, label, row in zip(p, view.is_seen, labels, rows, strict=True):
        _mark(pen, point, is_seen=bool(seen))
        pen.line(point + _towards(label.anchor - point, DOT * text), label.anchor, "LABELS")
        _label(pen, label, row)
    return labels


def _towards(v: FloatArray, length: float) -> FloatArray:
    return np.asarray(v / max(float(np.linalg.norm(v)), length) * length)


def _label_width(pen: Pen, row: SheetRow) -> float:
    sign = SIGN + 0.5 if row.symbol else 0.0
    return (2 * BALLOON + 0.5 + sign) * pen.paper.text + pen.width(row.name, LABEL_TEXT)


def _label(pen: Pen, label: Label, row: SheetRow) -> None:
    radius = BALLOON * pen.paper.text
    x, y = label.box.x + radius, label.box.y + label.box.height / 2
    pen.space.add_circle((x, y), radius, dxfattribs={"layer": "LABELS"})
    size = 1.0 if len(row.number) == 1 else 0.8
    pen.text(row.number, x, y, size, "LABELS", align=Align.MIDDLE_CENTER)
    pen.text(row.name, x + radius + 0.5 * pen.paper.text, y, LABEL_TEXT, "LABELS")
    if row.symbol:
        pen.sign(row.symbol, label.box.right - SIGN * pen.paper.text, y, "LABELS")


def _mark(pen: Pen, point: FloatArray, *, is_seen: bool) -> None:
    """Draw a dot for a visible point, a ring for a point behind the part."""
    radius = DOT * pen.paper.text
    pen.space.add_circle(tuple(point), radius, dxfattribs={"layer": "POINTS"})
    if not is_seen:
        return
    angle = np.linspace(0.0, 2.0 * np.pi, CIRCLE_CORNERS, endpoint=False)
    ring = point + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    pen.space.add_hatch(color=256, dxfattribs={"layer": "POINTS"}).paths.add_polyline_path(
        ring.tolist(), is_closed=True
    )


def _arrows(pen: Pen, place: OnPaper, p: FloatArray, rows: Sequence[SheetRow]) -> FloatArray:
    """Draw an arrow that ends at every point with a way or a start; return what labels avoid, shape (k, 2, 2)."""
    text, plane, drawn = pen.paper.text, place.view.axes.plane, []
    for point, row in zip(p, rows, strict=True):
        way = np.zeros(2) if row.way is None else ARROW * text * (plane @ np.array(row.way))
        if row.start is not None:
            way = point - place.on_paper(plane @ np.array(row.start))
        if np.linalg.norm(way) < ALONG_VIEW * ARROW * text:
            continue
        unit = way / np.linalg.norm(way)
        side = np.array([-unit[1], unit[0]])
        tip = point - DOT * text * unit
        tail = point - way if row.start is not None else tip - way
        pen.line(tail, tip, "POINTS")
        for sign in (1.0, -1.0):
            pen.line(tip, tip - 0.9 * text * unit + sign * 0.35 * text * side, "POINTS")
        drawn.append([tail, tip])
    return np.array(drawn).reshape(-1, 2, 2)


def _axes(pen: Pen, place: OnPaper) -> FloatArray:
    """Draw the directions of x, y, z in the lower left of a view; return what labels avoid, shape (k, 2, 2)."""
    plane, room = place.view.axes.plane, pen.paper.label_room
    length = AXIS_PART * room
    shown = [(name, plane[:, k]) for k, name in enumerate("xyz") if np.linalg.norm(plane[:, k]) > 0.1]
    lowest = np.min([direction for _, direction in shown] + [np.zeros(2)], axis=0)
    origin = np.array([place.cell.x, place.cell.y]) + 0.45 * room - length * lowest
    drawn: list[list[FloatArray]] = []
    for name, direction in shown:
        end = origin + length * direction
        pen.line(origin, end, "AXES")
        side = np.array([-direction[1], direction[0]])
        for sign in (1.0, -1.0):
            pen.line(end, end - 0.25 * length * direction + sign * 0.08 * length * side, "AXES")
        x, y = end + 0.9 * pen.paper.text * _towards(direction, 1.0)
        pen.text(name, x, y, 1.0, "AXES", align=Align.MIDDLE_CENTER)
        drawn += [[origin, end], [end, [x, y] + 1.5 * pen.paper.text * direction]]
    return np.array(drawn)


def chained(segments: FloatArray) -> list[FloatArray]:
    """Join segments end to end into polylines: fewer entities, and lines without gaps in print.

    `segments`: shape (n, 2, 2). On paper, mm.

    Returns shape (k, 2). Every segment is in one polyline. A polyline ends where more than two segments meet.
    """
    if len(segments) == 0:
        return []
    keys = np.round(segments.reshape(-1, 2), 3)  # ends of neighbours differ by round-off, much less than a pen's width
    _, node = np.unique(keys, axis=0, return_inverse=True)
    ends = node.reshape(-1, 2)
    at: dict[int, list[int]] = {}
    for number, pair in enumerate(ends.tolist()):
        for one in set(pair):
            at.setdefault(one, []).append(number)
    place = dict(zip(node.tolist(), segments.reshape(-1, 2), strict=True))
    used = np.zeros(len(segments), dtype=bool)
    chains = []
    for number in range(len(segments)):
        if not used[number]:
            used[number] = True
            chain = ends[number].tolist()
            chain = _grown(chain, ends, at, used)
            chain = _grown(chain[::-1], ends, at, used)
            chains.append(np.array([place[k] for k in chain]))
    return chains


def _grown(chain: list[int], ends: IntArray, at: dict[int, list[int]], used: np.ndarray[Any, Any]) -> list[int]:
    """Extend a chain from its last node as long as exactly one more segment continues it."""
    while True:
        here = at[chain[-1]]
        free = [k for k in here if not used[k]]
        if len(here) != 2 or len(free) != 1:
            return chain
        used[free[0]] = True
        a, b = ends[free[0]].tolist()
        chain.append(b if a == chain[-1] else a)
