"""The cross-section of a joint as a drawing: both members hatched, the wire, the nozzle, a fillet, and the numbers.

The section is the part in the plane across the seam at the middle of the seam. Rays in two directions of this plane
find its outline: the places where neighbouring rays go through one face are joined.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.hits import RayHits, find_hits
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.pages.draw.svg import polygon, polyline, rect, text
from wpcal.robot.torch.shape import TorchShape
from wpcal.seam.judge.leans import back_directions
from wpcal.seam.seam import Seam, WeldType

SIZE, MARGIN, TOP = 560.0, 24.0, 70.0  #: Pixels: side of the square drawing, and the room around it and above it.
HALF_MM = (12.0, 60.0)  #: The drawing shows at least and at most this much to each side of the root.
PLATES = 2.5  #: The drawing shows this many thicknesses of the thicker plate to each side.
RAYS = 400  #: Rays in each of the two directions: 0.1 mm apart in a drawing of 40 mm.
HATCH = 14  #: Every this many rays of one direction are drawn as hatching.
JOINED = 6.0  #: Places on one face are joined if they are not farther apart than this many distances of rays.
COLOURS = ("#2471a3", "#1e8449", "#7d6608", "#6c3483")
TORCH, WELD, TEXT = "#d68910", "#c0392b", "#2c3e50"
NOZZLE_MM = 14.0  #: How much of the nozzle is drawn.


def draw_section(
    graph: BrepGraph, trimmed: TrimmedFaces, seam: Seam, torch: TorchShape, section: Mapping[str, Any]
) -> list[str]:
    """Draw the section at the middle of a seam, as elements of an SVG.

    Returns: In a square of `SIZE` pixels with the root in the middle, z of the seam upwards and y to the right.
    """
    row = len(seam.frames) // 2
    p, R = seam.frames.p[row], seam.frames.R[row]
    known = [section[key] for key in ("wall_thickness_mm", "base_thickness_mm") if section[key] is not None]
    half = float(np.clip(PLATES * max(known, default=HALF_MM[0]), *HALF_MM))
    half = max(half, min(torch.wire_mm + NOZZLE_MM, HALF_MM[1]))
    scale = SIZE / (2.0 * half)

    def at(plane: FloatArray) -> FloatArray:
        """Return the pixels of points (k, 2) along y and z, mm from the root."""
        return np.stack([MARGIN + (plane[:, 0] + half) * scale, TOP + (half - plane[:, 1]) * scale], axis=1)

    joined = [graph.solid_names.index(name) for name in seam.solids if name in graph.solid_names]
    solids = {solid: COLOURS[number % len(COLOURS)] for number, solid in enumerate(joined)}
    out = [f'<clipPath id="section">{rect(MARGIN, TOP, SIZE, SIZE)}</clipPath>']
    out += [rect(MARGIN, TOP, SIZE, SIZE, stroke="#d5d8dc"), '<g clip-path="url(#section)">']
    for number, turn in enumerate((math.pi / 4, -math.pi / 4)):
        origins, rays = _scan(p, R, half, turn)
        hits = find_hits(trimmed, origins, rays, length_mm=4.0 * half)
        places = (origins[hits.ray] + hits.at_mm[:, None] * rays[hits.ray] - p) @ R[:, 1:]
        for solid, first, last in _hatches(graph, hits, number):
            if (colour := solids.get(solid, "#aab2ba")) and (number == _side(solids, solid)):
                out.append(polyline(at(places[[first, last]]), colour, 0.5))
        step = 4.0 * half / RAYS
        for face, chain in _outlines(hits, places, JOINED * step):
            colour = solids.get(int(graph.face_solid[face]), "#aab2ba")
            out.append(polyline(at(places[chain]), colour, 2.0))
    out += _weld(seam, section, row, at) + _torch(seam, row, torch, at) + ["</g>"]
    return out + _numbers_told(seam, section, row, torch)


def _side(solids: Mapping[int, str], solid: int) -> int:
    """Return in which of the two directions a solid is hatched: neighbours differ, as in drawings."""
    return list(solids).index(solid) % 2 if solid in solids else 0


def _scan(p: FloatArray, R: FloatArray, half: float, turn: float) -> tuple[FloatArray, FloatArray]:
    """Return parallel rays that cover the square around a point in the plane of y and z, two arrays (RAYS, 3)."""
    way = math.cos(turn) * R[:, 1] + math.sin(turn) * R[:, 2]
    aside = -math.sin(turn) * R[:, 1] + math.cos(turn) * R[:, 2]
    off = (np.arange(RAYS) + 0.5) / RAYS * 4.0 * half - 2.0 * half
    return p + off[:, None] * aside - 2.0 * half * way, np.repeat(way[None], RAYS, axis=0)


def _hatches(graph: BrepGraph, hits: RayHits, number: int) -> list[tuple[int, int, int]]:
    """Return the solid and the two hits of every stretch inside material, of the rays that are drawn."""
    found = []
    solid = graph.face_solid[hits.face]
    for one in np.unique(solid).tolist():
        rows = np.flatnonzero((solid == one) & (hits.ray % HATCH == number * HATCH // 2))
        pairs = zip(rows[:-1].tolist(), rows[1:].tolist(), strict=True)
        found += [(one, a, b) for a, b in pairs if hits.ray[a] == hits.ray[b] and hits.way[a] < 0 < hits.way[b]]
    return found


def _outlines(hits: RayHits, places: FloatArray, within_mm: float) -> list[tuple[int, IntArray]]:
    """Join the hits of neighbouring rays on one face to polylines: the face, and rows of hits."""
    found = []
    for face in np.unique(hits.face).tolist():
        rows = np.flatnonzero(hits.face == face)
        left = rows[np.lexsort((hits.at_mm[rows], hits.ray[rows]))].tolist()
        while left:
            chain = [left.pop(0)]
            while True:
                near = [
                    row
                    for row in left
                    if 0 < hits.ray[row] - hits.ray[chain[-1]] <= 2
                    and np.linalg.norm(places[row] - places[chain[-1]]) <= within_mm
                ]
                if not near:
                    break
                best = min(near, key=lambda row: float(np.linalg.norm(places[row] - places[chain[-1]])))
                chain.append(best)
                left.remove(best)
            if len(chain) > 1:
                found.append((face, np.array(chain)))
    return found


def _weld(seam: Seam, section: Mapping[str, Any], row: int, at: Any) -> list[str]:
    """Draw the largest fillet in the opening: its throat goes along z."""
    throat = section["largest_throat_mm"]
    if seam.weld is not WeldType.FILLET or throat is None:
        return []
    half = (math.pi - float(seam.frames.angle_rad[row])) / 2.0
    leg = throat / max(math.cos(half), 0.1)
    corners = np.array([[0, 0], [math.sin(half) * leg, throat], [-math.sin(half) * leg, throat]])
    return [polygon(at(corners), WELD, WELD, opacity=0.25)]


def _torch(seam: Seam, row: int, torch: TorchShape, at: Any) -> list[str]:
    """Draw wire and nozzle as they lean at the station, seen along the seam."""
    lean = np.zeros(2) if seam.lean_rad is None else np.nan_to_num(seam.lean_rad[row])
    R = seam.frames.R[[row]]
    back = (back_directions(R, lean)[0] @ R[0])[1:]
    across = np.array([-back[1], back[0]]) / max(float(np.linalg.norm(back)), 1e-6)
    mouth, end = torch.wire_mm, torch.wire_mm + NOZZLE_MM
    wide = torch.mouth_mm + (torch.nozzle_radius_mm - torch.mouth_mm) * min(NOZZLE_MM / max(torch.taper_mm, 1.0), 1.0)
    nozzle = [mouth * back + s * torch.mouth_mm * across for s in (-1, 1)]
    nozzle += [end * back + s * wide * across for s in (1, -1)]
    wire = np.stack([np.zeros(2), mouth * back])
    return [polyline(at(wire), TORCH, 2.5), polygon(at(np.array(nozzle)), TORCH, TORCH, opacity=0.2)]


def _numbers_told(seam: Seam, section: Mapping[str, Any], row: int, torch: TorchShape) -> list[str]:
    """Write the numbers below the drawing."""

    def mm(value: float | None) -> str:
        return "?" if value is None else f"{value:g} mm"

    lean = None if seam.lean_rad is None else np.degrees(seam.lean_rad[row])
    leans = (
        "no lean is free" if lean is None or np.isnan(lean).any() else f"work {lean[0]:.0f}, travel {lean[1]:.0f} deg"
    )
    words: Sequence[str] = (
        f"section at {float(seam.frames.s_mm[row]):.1f} mm of {seam.length_mm:.1f} mm",
        f"wall {mm(section['wall_thickness_mm'])}, base {mm(section['base_thickness_mm'])}, "
        f"opening {section['opening_deg']:g} deg, gap {mm(section['gap_mm'])}",
        f"largest throat {mm(section['largest_throat_mm'])}; {torch.name}: wire {torch.wire_mm:g} mm, {leans}",
    )
    first = TOP - 50.0
    return [text(MARGIN, first + 18 * number, told, 13, TEXT) for number, told in enumerate(words)]
