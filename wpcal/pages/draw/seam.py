"""A picture of one seam in its part as SVG: wall, base, seam, its axes and the torch. Needs no other package."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from wpcal.brep.curves import edge_polylines
from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.pages.draw.section import SIZE, draw_section
from wpcal.pages.draw.svg import polyline, svg, text
from wpcal.robot.torch.shape import TorchShape
from wpcal.seam.seam import Seam

WIDTH, HEIGHT, MARGIN = 900.0, 640.0, 40.0  #: Pixels.
AROUND = 0.6
"""The picture shows the part this far around the seam, in lengths of the seam's box, and at least `LEAST_MM`."""
LEAST_MM = 40.0
EDGES, WALL, BASE, SEAM, TORCH = "#aab2ba", "#2471a3", "#1e8449", "#c0392b", "#d68910"
STATIONS = 4  #: Wires that are drawn.
NOZZLE_MM = 25.0  #: How much of the nozzle is drawn, at the middle of the seam.


def explained_svg(
    graph: BrepGraph, trimmed: TrimmedFaces, seam: Seam, title: str, torch: TorchShape, section: Mapping[str, Any]
) -> str:
    """Draw a seam with what it joins, and beside it the section across its middle.

    Returns: SVG. Edges of the part grey, the boundary of the wall blue, that of the base green, the seam red, z and the
    wire of the torch orange. The same seam gives the same text.
    """
    p, torch = seam.frames.p, torch.with_more_wire(seam.more_wire_mm)
    low, high = p.min(axis=0), p.max(axis=0)
    room = max(AROUND * float((high - low).max()), LEAST_MM)
    view = _view(seam)
    start, _, points = edge_polylines(graph)
    of_point = np.repeat(np.arange(graph.edge_count), np.diff(start))
    inner = np.flatnonzero((of_point[1:] == of_point[:-1]) & (graph.edge_solid[of_point[1:]] >= 0))
    edges = _inside(points[inner], points[inner + 1], low - room, high + room)
    lines = [(EDGES, 0.8, piece) for piece in edges]
    for colour, faces in ((WALL, seam.pieces.wall), (BASE, seam.pieces.base)):
        for face in sorted({face for face in faces.tolist() if face >= 0}):
            own = slice(trimmed.start[face], trimmed.start[face + 1])
            pieces = _inside(trimmed.p0[own], trimmed.p1[own], low - room, high + room)
            lines += [(colour, 1.8, piece) for piece in pieces]
    lines.append((SEAM, 3.0, p))
    rows = np.unique(np.linspace(0, len(p) - 1, STATIONS).round().astype(int))
    tips = [np.stack([p[row], p[row] + torch.wire_mm * seam.frames.R[row, :, 2]]) for row in rows]
    lines += [(TORCH, 2.0, tip) for tip in tips]
    lines.append((TORCH, 1.2, _nozzle(p[len(p) // 2], seam.frames.R[len(p) // 2], torch)))
    flat = [(colour, width, line @ view.T) for colour, width, line in lines]
    return _svg(flat, title, seam, draw_section(graph, trimmed, seam, torch, section))


def _view(seam: Seam) -> FloatArray:
    """Return the axes of the picture, shape (2, 3): right and up, seen from the side of the torch."""
    middle = seam.frames.R[len(seam.frames) // 2]
    toward = 0.75 * middle[:, 2] + 0.45 * middle[:, 0] + 0.5 * middle[:, 1]
    toward = toward / np.linalg.norm(toward)
    up = np.array([0.0, 0.0, 1.0]) if abs(toward[2]) < 0.95 else np.array([0.0, 1.0, 0.0])
    right = np.cross(up, toward)
    right = right / np.linalg.norm(right)
    return np.stack([right, np.cross(toward, right)])


def _inside(p0: FloatArray, p1: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the parts of segments p0, p1, shape (k, 3), that are inside a box, shape (m, 2, 3)."""
    d = p1 - p0
    with np.errstate(divide="ignore", invalid="ignore"):
        at = np.stack([(low - p0) / d, (high - p0) / d])
    outside = (d == 0) & ((p0 < low) | (p0 > high))
    enters = np.where(d == 0, -np.inf, at.min(axis=0)).max(axis=1).clip(0.0, 1.0)
    leaves = np.where(d == 0, np.inf, at.max(axis=0)).min(axis=1).clip(0.0, 1.0)
    kept = (leaves > enters) & ~outside.any(axis=1)
    ends = [p0[kept] + share[kept, None] * d[kept] for share in (enters, leaves)]
    return np.stack(ends, axis=1)


def _nozzle(p: FloatArray, R: FloatArray, torch: TorchShape) -> FloatArray:
    """Return the outline of the nozzle at a pose, in the plane across the seam, shape (7, 3)."""
    mouth, wide, narrow = torch.wire_mm, torch.nozzle_radius_mm, torch.mouth_mm
    cone, end = mouth + torch.taper_mm, mouth + NOZZLE_MM
    corners = ((mouth, -narrow), (cone, -wide), (end, -wide), (end, wide), (cone, wide), (mouth, narrow))
    outline = [p + out * R[:, 2] + aside * R[:, 1] for out, aside in (*corners, corners[0])]
    return np.stack(outline)


def _svg(lines: list[tuple[str, float, FloatArray]], title: str, seam: Seam, section: list[str]) -> str:
    every = np.concatenate([line for _, _, line in lines])
    low, size = every.min(axis=0), np.maximum(np.ptp(every, axis=0), 1e-6)
    scale = min((WIDTH - 2 * MARGIN) / size[0], (HEIGHT - 3 * MARGIN) / size[1])
    out = [text(MARGIN, 26, title, 16)]
    for colour, width, line in lines:
        at = MARGIN + (line - low) * scale
        out.append(polyline(np.stack([at[:, 0], HEIGHT - MARGIN - at[:, 1] + MARGIN / 2], axis=1), colour, width))
    words = ((WALL, "wall"), (BASE, "base"), (SEAM, f"seam {seam.name}"), (TORCH, "z, wire, nozzle"), (EDGES, "part"))
    out += [text(MARGIN + 150 * number, 46, word, 13, colour) for number, (colour, word) in enumerate(words)]
    out += [f'<g transform="translate({WIDTH:g},0)">', *section, "</g>"]
    return svg(WIDTH + SIZE + 2 * MARGIN, HEIGHT, out)
