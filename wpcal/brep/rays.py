"""Rays through a part: which of many rays hit a face within a length."""

from __future__ import annotations

import numpy as np

from wpcal.brep.crossing import find_crossings, heights
from wpcal.brep.graph import BrepGraph
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

START_MM = 1.0
"""Rays start this far outside the part, clear of a gap and of the faces beside the joint."""
TOOL_MM = 300.0
"""Length of a straight tool: with a usual torch neck, from the tip of the wire to where the wrist has room to turn."""
CHUNK = 5000
"""Rays handled in one array: some 50 MB at ten faces per ray."""
STEPS = 12
"""Samples of a ray inside the box of a face. The ray crosses between two samples on different sides of the surface."""
THIN_MM = 0.1
"""Boxes grow by this, so that a ray across a plane face has samples on both sides of the face."""


def is_blocked(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    origins: FloatArray,
    rays: FloatArray,
    *,
    length_mm: FloatArray | float = TOOL_MM,
) -> BoolArray:
    """Tell which rays hit a face of the part.

    Parameters
    ----------
    graph : BrepGraph
    trimmed : TrimmedFaces
        Of the same graph.
    origins, rays : ndarray, shape (m, 3)
        Starts (mm) and unit directions in `part`.
    length_mm : float or ndarray, shape (m,)
        Where the rays end.

    Returns
    -------
    ndarray of bool, shape (m,)
    """
    length = np.broadcast_to(np.asarray(length_mm, dtype=np.float64), len(origins))
    blocked = np.zeros(len(origins), dtype=bool)
    for first in range(0, len(origins), CHUNK):
        own = slice(first, first + CHUNK)
        blocked[own] = _is_blocked(graph, trimmed, origins[own], rays[own], length[own])
    return blocked


def _is_blocked(
    graph: BrepGraph, trimmed: TrimmedFaces, origins: FloatArray, rays: FloatArray, length: FloatArray
) -> BoolArray:
    ray, face, low, high = _through_boxes(trimmed, origins, rays, length)
    blocked = np.zeros(len(origins), dtype=bool)
    t = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, STEPS)
    points = origins[ray, None] + t[..., None] * rays[ray, None]
    side = heights(graph, np.repeat(face, STEPS), points.reshape(-1, 3)).reshape(t.shape)
    row, column = np.nonzero((side[:, :-1] > 0) != (side[:, 1:] > 0))
    ray, face = ray[row], face[row]

    def height(at: FloatArray) -> FloatArray:
        return heights(graph, face, origins[ray] + at[:, None] * rays[ray])

    at = find_crossings(height, t[row, column], t[row, column + 1])
    foot = project_to_faces(graph, face, origins[ray] + at[:, None] * rays[ray])
    blocked[ray[trimmed.contains(face, foot.uv)]] = True
    return blocked


def _through_boxes(
    trimmed: TrimmedFaces, origins: FloatArray, rays: FloatArray, length: FloatArray
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Return pairs of a ray and a face whose box the ray meets, and where the ray enters and leaves this box."""
    o, d = np.ascontiguousarray(origins.T), np.ascontiguousarray(rays.T)
    low, high = trimmed.face_box
    with np.errstate(divide="ignore", invalid="ignore"):

        def meets(ray: IntArray, box_low: FloatArray, box_high: FloatArray) -> BoolArray:
            enter, leave = _passage(np.take(o, ray, axis=1), np.take(d, ray, axis=1), length[ray], box_low, box_high)
            return np.asarray(leave > enter, dtype=bool)

        ray, face = trimmed.box_tree.search(len(origins), meets)
        return ray, face, *_passage(o[:, ray], d[:, ray], length[ray], low[face].T, high[face].T)


def _passage(
    o: FloatArray, d: FloatArray, length: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return where rays from o along d enter boxes and where they leave them; a ray that leaves first misses its box.

    Points, directions and corners have one row per coordinate, shape (3, m).
    """
    enter, leave = np.zeros(len(length)), length
    for k in range(3):
        a, b = (low[k] - THIN_MM - o[k]) / d[k], (high[k] + THIN_MM - o[k]) / d[k]
        enter, leave = np.maximum(enter, np.fmin(a, b)), np.minimum(leave, np.fmax(a, b))
    return enter, leave
