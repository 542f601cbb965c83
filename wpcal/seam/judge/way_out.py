"""A way out: from the mouth of the nozzle, a straight way as wide as the nozzle leads out of the part.

A torch that is free over its own length may still be inside a closed tank. Rays are sent from the middle of each seam,
first along the torch, then in more directions; if all are in vain, from its ends and quarters. A ray that meets
nothing counts if rays around it meet nothing, either.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.hits import find_hits
from wpcal.brep.surfaces import square_to
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.robot.torch.shape import TorchShape
from wpcal.seam.seam import Seam

STATIONS = (0.5, 0.0, 0.25, 0.75, 1.0)
"""Places along a seam, as shares of its frames, that are asked one after the other: a bar may be over its middle."""
DIRECTIONS = (8, 40, 600)  #: Directions that are tried one after the other: a manhole of 400 mm at 1 m is 1 % of them.
AROUND = 6  #: Rays around a free one, at the radius of the nozzle.
CHUNK = 30_000  #: Rays sent together.
GOLDEN_RAD = np.pi * (3.0 - np.sqrt(5.0))  #: Directions turned by it, one after the other, are spread evenly.


def find_closed_in(
    graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], torch: TorchShape
) -> dict[int, frozenset[int]]:
    """Return the rows of seams from which no way leads out of the part, with the solids around them."""
    closed: dict[int, frozenset[int]] = dict.fromkeys(range(len(seams)), frozenset())
    for share in STATIONS:
        rows = list(closed)
        frames = [seams[row].frames for row in rows]
        at = [round(share * (len(own) - 1)) for own in frames]
        p = np.array([own.p[k] for own, k in zip(frames, at, strict=True)]).reshape(-1, 3)
        z = np.array([own.R[k, :, 2] for own, k in zip(frames, at, strict=True)]).reshape(-1, 3)
        wire_mm = np.array([torch.wire_mm + seams[row].more_wire_mm for row in rows])
        held = _without_way(graph, trimmed, p + wire_mm[:, None] * z, z, torch.nozzle_radius_mm)
        closed = {rows[row]: solids for row, solids in held.items()}
    return closed


def _without_way(
    graph: BrepGraph, trimmed: TrimmedFaces, start: FloatArray, z: FloatArray, radius_mm: float
) -> dict[int, frozenset[int]]:
    """Return the rows of `start`, shape (n, 3), mm, from which no way leads out, with the solids around them."""
    left = np.flatnonzero(_meet(graph, trimmed, start, z)[0])
    around: dict[int, frozenset[int]] = {}
    few, more, many = [_spread(count) for count in DIRECTIONS]
    for some in (*few[:, None], *(more[k :: len(few)] for k in range(len(few))), many):  # most need one or two
        held, step = [], CHUNK // len(some)
        for first in range(0, len(left), step):
            rows = left[first : first + step]
            held += _held(graph, trimmed, (rows, start[rows]), some, radius_mm, around)
        left = np.array(held, dtype=np.int64)
    return {row: around[row] for row in left.tolist()}


def _held(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    seams: tuple[IntArray, FloatArray],
    ways: FloatArray,
    radius_mm: float,
    around: dict[int, frozenset[int]],
) -> list[int]:
    """Return the rows from which none of some directions leads out, and note the solids that the rays meet first."""
    (rows, start), count = seams, len(ways)
    p, way = np.repeat(start, count, axis=0), np.tile(ways, (len(rows), 1))
    meets, solid = _meet(graph, trimmed, p, way)
    free = np.flatnonzero(~meets)
    side = square_to(way[free])
    other = np.cross(way[free], side)
    is_wide = np.ones(len(free), dtype=bool)
    for turn in np.arange(AROUND) * 2.0 * np.pi / AROUND:
        off = radius_mm * (np.cos(turn) * side + np.sin(turn) * other)
        own = np.flatnonzero(is_wide)
        is_wide[own] = ~_meet(graph, trimmed, p[free[own]] + off[own], way[free[own]])[0]
    leads_out = np.zeros(len(rows), dtype=bool)
    leads_out[free[is_wide] // count] = True
    held = np.flatnonzero(~leads_out)
    for row in held.tolist():
        met = solid[row * count : (row + 1) * count]
        around[int(rows[row])] = frozenset(met[met >= 0].tolist())
    return [int(row) for row in rows[held]]


def _meet(graph: BrepGraph, trimmed: TrimmedFaces, p: FloatArray, way: FloatArray) -> tuple[BoolArray, IntArray]:
    """Tell which rays meet a face, and the solid of the first face, or -1."""
    hits = find_hits(trimmed, p, way, length_mm=2.0 * graph.size_mm)
    rays, first = np.unique(hits.ray, return_index=True)
    solid = np.full(len(p), -1)
    solid[rays] = graph.face_solid[hits.face[first]]
    return solid >= 0, solid


def _spread(count: int) -> FloatArray:
    """Return directions that are spread evenly over the sphere, shape (count, 3)."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    r = np.sqrt(1.0 - z * z)
    return np.column_stack([r * np.cos(GOLDEN_RAD * k), r * np.sin(GOLDEN_RAD * k), z])
