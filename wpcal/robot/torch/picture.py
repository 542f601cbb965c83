"""Torches as a picture (SVG): each one from the side, all to one scale, with the wire down."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.robot.torch.shape import TorchShape

PIXELS_PER_MM = 1.0
ROOM = 30.0
"""Pixels around each torch."""
WORDS = 46.0
"""Pixels below the wires, for the names."""
WIRE, METAL, EDGE = "#c05000", "#d8dde2", "#404850"


def torches_svg(shapes: Sequence[TorchShape]) -> str:
    """Draw torches side by side. SVG; the same torches give the same text.

    Parameters
    ----------
    shapes : sequence of TorchShape
    """
    drawn = [_pieces(shape) for shape in shapes]
    boxes = [np.concatenate([*pieces, np.zeros((1, 2))]) for pieces in drawn]
    height = max(float(box[:, 1].max()) for box in boxes) * PIXELS_PER_MM
    widths = [max(float(np.ptp(box[:, 0])) * PIXELS_PER_MM, 110.0) + 2 * ROOM for box in boxes]
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {sum(widths):g} {height + 2 * ROOM + WORDS:.1f}" '
        'font-family="sans-serif">',
        f'<rect width="{sum(widths):g}" height="{height + 2 * ROOM + WORDS:.1f}" fill="white"/>',
    ]
    left = 0.0
    for shape, pieces, box, width in zip(shapes, drawn, boxes, widths, strict=True):
        x0 = left + ROOM - float(box[:, 0].min()) * PIXELS_PER_MM
        y0 = ROOM + height
        outlines = [_points(piece, x0, y0) for piece in pieces]
        out += [f'<polygon points="{outline}" fill="{METAL}" stroke="{EDGE}"/>' for outline in outlines]
        wire = _points(np.array([[0.0, 0.0], [0.0, shape.wire_mm]]), x0, y0)
        out.append(f'<polyline points="{wire}" fill="none" stroke="{WIRE}" stroke-width="2"/>')
        nozzle = f"nozzle {2 * shape.nozzle_radius_mm:g} mm, wire {shape.wire_mm:g} mm"
        out.append(f'<text x="{left + ROOM:g}" y="{y0 + 22:.1f}" font-size="15">{escape(shape.name)}</text>')
        out.append(f'<text x="{left + ROOM:g}" y="{y0 + 40:.1f}" font-size="11">{escape(nozzle)}</text>')
        left += width
    return "\n".join([*out, "</svg>", ""])


def _pieces(shape: TorchShape) -> list[FloatArray]:
    """Return the outlines of the pieces of a torch in the plane of its bend, from the tip of the wire, mm; (k, 2) each.

    Neck and body first, so that the nozzle is drawn over them.
    """
    found = []
    for tube in reversed(shape.tubes):
        a, b = (np.array([point[0], point[2] + shape.wire_mm]) for point in (tube.start, tube.end))
        way = (b - a) / np.linalg.norm(b - a)
        side = tube.radius_mm * np.array([way[1], -way[0]])
        found.append(np.array([a + side, b + side, b - side, a - side]))
    mouth, cone, end = (shape.wire_mm + at for at in (0.0, shape.taper_mm, shape.front_mm))
    narrow, wide = shape.mouth_mm, shape.nozzle_radius_mm
    half = [(narrow, mouth), (wide, cone), (wide, end)]
    found.append(np.array([*half, *((-x, y) for x, y in reversed(half))]))
    return found


def _points(line: FloatArray, x0: float, y0: float) -> str:
    return " ".join(f"{x0 + x * PIXELS_PER_MM:.1f},{y0 - y * PIXELS_PER_MM:.1f}" for x, y in line.tolist())
