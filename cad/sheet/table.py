"""The table to fill in, of points or of welds, and the title block."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ezdxf.enums import TextEntityAlignment as Align

from cad.sheet.draw import SIGN, Pen, SheetRow
from cad.sheet.paper import HEADING_ROWS, Box, SheetLayout, scale_words

PAD = 0.6  #: Space between a cell's edge and its text, relative to the height of text.


@dataclass(frozen=True, slots=True)
class TableForm:
    """The columns of a table: their relative widths, and what stands above groups of them."""

    columns: Mapping[str, float]  #: The first is the number, the second the name.
    #: Heading of each group, with its first column; the first group begins at the left edge.
    groups: tuple[tuple[str, str], ...]
    words: str  #: The column whose texts begin at the left and are cut; others end at the right.


POINTS = TableForm(
    {"no": 0.7, "point": 1.3, "where": 5.2, "x": 1.6, "y": 1.6, "z": 1.6, "X": 2.4, "Y": 2.4, "Z": 2.4},
    (("touch in this order", "no"), ("in the CAD model, mm", "x"), ("as the robot shows it (base), mm", "X")),
    "where",
)
"""The columns to fill in by hand are the widest numbers: they need room for eight digits."""
WELDS = TableForm(
    {"no": 0.7, "weld": 2.2, "what": 5.2, "length": 1.2, "plate": 1.0, "passes": 1.2, "by, date": 3.4, "checked": 2.6},
    (("welds, in this order", "no"), ("lengths in mm", "length"), ("signature", "by, date")),
    "what",
)


@dataclass(frozen=True, slots=True)
class TitleBlock:
    """What the title block says."""

    part: str
    file: str
    sha256: str  #: SHA-256 of the file; empty for shapes from a script.
    unit: str  #: Length unit of the file.
    made_by: str


def draw_table(pen: Pen, box: Box, form: TableForm, rows: Sequence[SheetRow]) -> None:
    """Draw the heading and one line per row. Columns without a text are filled in by hand."""
    edges = _edges(box, form)
    row, top = pen.paper.row, box.top
    lines = int(box.height / row + 0.5)  # unused rows are for further points
    pen.box(box, "BORDER")
    for name, left, right in zip(form.columns, edges[:-1], edges[1:], strict=True):
        pen.text(name.lower(), (left + right) / 2, top - 1.5 * row, align=Align.MIDDLE_CENTER)
    starts = [edges[list(form.columns).index(first)] for _, first in form.groups]
    pen.text(form.groups[0][0], box.x + PAD * pen.paper.text, top - 0.5 * row)
    for (heading, _), left, right in zip(form.groups[1:], starts[1:], [*starts[2:], box.right], strict=True):
        pen.text(heading, (left + right) / 2, top - 0.5 * row, align=Align.MIDDLE_CENTER)
    for number, cells in enumerate(rows):
        _row(pen, form, cells, edges, top - (HEADING_ROWS + number + 0.5) * row)
    for number in range(1, lines):
        y = top - number * row
        first = starts[1] if number == 1 else box.x
        pen.line((first, y), (box.right, y), "BORDER" if number == HEADING_ROWS else "TABLE")
    for x in edges[1:-1]:
        begins = x in starts
        pen.line((x, top if begins else top - row), (x, top - lines * row), "BORDER" if begins else "TABLE")


def _edges(box: Box, form: TableForm) -> list[float]:
    total = sum(form.columns.values())
    edges = [box.x]
    for share in form.columns.values():
        edges.append(edges[-1] + share / total * box.width)
    return edges


def _row(pen: Pen, form: TableForm, row: SheetRow, edges: list[float], y: float) -> None:
    pad = PAD * pen.paper.text
    pen.text(row.number, (edges[0] + edges[1]) / 2, y, align=Align.MIDDLE_CENTER)
    pen.text(row.name, edges[1] + pad, y, 1.1)
    if row.symbol:
        pen.sign(row.symbol, edges[2] - pad - SIGN * pen.paper.text, y)
    for k, (name, text) in enumerate(zip(list(form.columns)[2:], row.cells, strict=False), 2):
        if name == form.words:
            pen.text(pen.fitted(text, edges[k + 1] - edges[k] - 2 * pad), edges[k] + pad, y)
        else:
            pen.text(text, edges[k + 1] - pad, y, align=Align.MIDDLE_RIGHT)


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
