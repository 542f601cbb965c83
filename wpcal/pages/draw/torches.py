"""Torches as a picture (SVG): each one from the side, all to one scale, with the wire down."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.pages.draw.svg import polygon, polyline, svg, text
from wpcal.robot.torch.shape import TorchShape

PIXELS_PER_MM = 1.0
PIXELS = np.array([PIXELS_PER_MM, -PIXELS_PER_MM])  #: Of 1 mm to the right and upwards.
LEAST_WIDTH = 110.0  #: Pixels: the words below a torch are this wide.
ROOM = 30.0  #: Pixels around each torch.
WORDS = 46.0  #: Pixels below the wires, for the names.
WIRE, METAL, EDGE = "#c05000", "#d8dde2", "#404850"


def torches_svg(shapes: Sequence[TorchShape]) -> str:
    """Draw torches side by side. SVG."""
    drawn = [_pieces(shape) for shape in shapes]
    boxes = [np.concatenate([*pieces, np.zeros((1, 2))]) for pieces in drawn]
    base = ROOM + max(float(box[:, 1].max()) for box in boxes) * PIXELS_PER_MM
    left, out = 0.0, list[str]()
    for shape, pieces, box in zip(shapes, drawn, boxes, strict=True):
        tip = np.array([left + ROOM - float(box[:, 0].min()) * PIXELS_PER_MM, base])
        out += [polygon(tip + piece * PIXELS, METAL, EDGE) for piece in pieces]
        out.append(polyline(tip + np.array([[0.0, 0.0], [0.0, shape.wire_mm]]) * PIXELS, WIRE, 2))
        out.append(text(left + ROOM, base + 22, shape.name, 15))
        nozzle = f"nozzle {2 * shape.nozzle_radius_mm:g} mm, wire {shape.wire_mm:g} mm"
        out.append(text(left + ROOM, base + 40, nozzle, 11))
        left += max(float(np.ptp(box[:, 0])) * PIXELS_PER_MM, LEAST_WIDTH) + 2 * ROOM
    return svg(left, base + ROOM + WORDS, out)


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
