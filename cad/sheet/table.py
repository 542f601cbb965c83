"""The table to fill in and the title block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ezdxf.enums import TextEntityAlignment as Align

from cad.sheet.draw import Pen, SheetRow
from cad.sheet.paper import HEADING_ROWS, Box, SheetLayout, scale_words

COLUMNS = {"No": 0.7, "point": 1.3, "where": 5.2, "x": 1.6, "y": 1.6, "z": 1.6, "X": 2.4, "Y": 2.4, "Z": 2.4}
"""Relative widths. The columns to fill in by hand are the widest numbers: they need room for eight digits."""
PAD = 0.6  #: Space between a cell's edge and its text, relative to the height of text.


@dataclass(frozen=True, slots=True)
class TitleBlock:
    """What the title block says."""

    part: str
    file: str
    sha256: str  #: SHA-256 of the file; empty for shapes from a script.
    unit: str  #: Length unit of the file.
    made_by: str


def draw_table(pen: Pen, box: Box, rows: Sequence[SheetRow]) -> None:
    """Draw the heading and one line per point. The robot's coordinates are left empty."""
    edges = _edges(box)
    row, top = pen.paper.row, box.top
    pen.box(box, "BORDER")
    names = list(COLUMNS)
    part, robot = edges[names.index("x")], edges[names.index("X")]
    group_y = top - 0.5 * row
    pen.text("touch in this order", box.x + PAD * pen.paper.text, group_y)
    pen.text("in the CAD model, mm", (part + robot) / 2, group_y, align=Align.MIDDLE_CENTER)
    pen.text("as the robot shows it (base), mm", (robot + box.right) / 2, group_y, align=Align.MIDDLE_CENTER)
    for name, left, right in zip(names, edges[:-1], edges[1:], strict=True):
        pen.text(name.lower(), (left + right) / 2, top - 1.5 * row, align=Align.MIDDLE_CENTER)
    for number, cells in enumerate(rows):
        y = top - (HEADING_ROWS + number + 0.5) * row
        _row(pen, cells, edges, y)
    lines = int(box.height / row + 0.5)  # unused rows are for further points
    for number in range(1, lines):
        y = top - number * row
        pen.line((part if number == 1 else box.x, y), (box.right, y), "BORDER" if number == HEADING_ROWS else "TABLE")
    for name, x in zip(names[1:], edges[1:-1], strict=True):
        first = top if name in ("x", "X") else top - row
        layer = "BORDER" if name in ("x", "X") else "TABLE"
        pen.line((x, first), (x, top - lines * row), layer)


def _edges(box: Box) -> list[float]:
    total = sum(COLUMNS.values())
    edges = [box.x]
    for share in COLUMNS.values():
        edges.append(edges[-1] + share / total * box.width)
    return edges


def _row(pen: Pen, cells: SheetRow, edges: list[float], y: float) -> None:
    pad = PAD * pen.paper.text
    pen.text(cells.number, (edges[0] + edges[1]) / 2, y, align=Align.MIDDLE_CENTER)
    pen.text(cells.name, edges[1] + pad, y, 1.1)
    pen.text(pen.fitted(cells.where, edges[3] - edges[2] - 2 * pad), edges[2] + pad, y)
    for k, text in enumerate(cells.place):
        pen.text(text, edges[4 + k] - pad, y, align=Align.MIDDLE_RIGHT)


def draw_title(pen: Pen, layout: SheetLayout, title: TitleBlock) -> None:
    """Draw the title block: the part, its file, the scale, and fields for the person who fills in the sheet."""
    box, row, pad = layout.title, pen.paper.row, PAD * pen.paper.text
    pen.box(box, "BORDER")
    inner = box.width - 2 * pad
    scale = scale_words(layout.places[0].scale)
    half = len(title.sha256) // 2
    lines = [
        (pen.fitted(title.part, inner, 1.6), 1.6),
        (pen.fitted(f"file {title.file} ({title.unit})", inner), 1.0),
        (f"sha256 {title.sha256[:half]}" if half else "", 0.8),
        (f"       {title.sha256[half:]}" if half else "", 0.8),
        (f"{layout.paper.name}, scale {scale} (view at the right: no scale), mm, first angle", 0.85),
        (f"dot: seen from here, ring: behind the part. {title.made_by}", 0.85),
    ]
    indent = pen.width("sha256 ", 0.8)
    bottom = box.y + 2 * row
    step = (box.height - 2 * row) / len(lines)
    for number, (text, size) in enumerate(lines):
        x = box.x + pad + (indent if number == 3 else 0.0)
        pen.text(text.strip(), x, box.top - (number + 0.5) * step, size)
    pen.line((box.x, bottom), (box.right, bottom), "TABLE")
    fields = (("robot", "tool"), ("date", "name"))
    for number, pair in enumerate(fields):
        y = bottom - number * row
        pen.line((box.x, y - row), (box.right, y - row), "TABLE")
        for k, field in enumerate(pair):
            pen.text(field, box.x + pad + k * box.width / 2, y - 0.5 * row, 0.85)
    pen.line((box.x + box.width / 2, box.y), (box.x + box.width / 2, bottom), "TABLE")
