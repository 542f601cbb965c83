"""How thick the plates of a joint are, felt with rays through the part.

A ray starts beside the seam, just above one of its two faces, and goes straight into the plate. Where it leaves the
material again is a thickness there. Two more rays, from just below the face, measure the plate along the seam and away
from it: a plate that is seen from its edge is thinner there.
"""

import numpy as np

from wpcal.brep.material import Material
from wpcal.brep.surfaces import square_to
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.seam import SeamFrames

BESIDE_MM = (3.0, 1.5, 6.0)
"""Distances from the seam at which a ray starts, in the order of preference: beyond a small round, on a narrow face."""
ABOVE_MM = 1.0
"""Height above the face at which a ray starts. A face that is nearer or farther than this by half is another face."""
STATIONS = (0.25, 0.5, 0.75)
"""Where along the seam: the median is the answer, so a hole or a cut at one of them does not matter."""
THICKEST_MM = 1000.0  #: No plate is thicker; a ray ends there.
INSIDE_MM = 0.5  #: Depth below the face of the point from which a plate is measured.
ASIDE_MM = 0.25  #: Rays this far to each side of one tell whether the faces at its ends are parallel.
MOST_SLOPE = 0.2  #: Faces are parallel if the length between them changes by less, mm per mm (tan 11 degrees).
SHORTER_MM = 2.0  #: A plate across whose thickness a seam runs is as thick as the seam is long, but for cut corners.


def plate_thicknesses(frames: SeamFrames, material: Material) -> tuple[float | None, float | None]:
    """Measure the two plates of a joint.

    Returns: Of the plate at the side of +y and of that at the side of -y, mm; None where no face was found.
    """
    rows = np.unique((np.array(STATIONS) * (len(frames) - 1)).round().astype(int))
    return _thickness(frames, rows, 1.0, material), _thickness(frames, rows, -1.0, material)


def thinner(thicknesses: tuple[float | None, float | None]) -> float | None:
    """Return the smaller of two thicknesses, to a tenth of a millimetre; None if none is known."""
    known = [each for each in thicknesses if each is not None]
    return round(min(known), 1) if known else None


def _thickness(frames: SeamFrames, rows: IntArray, sign: float, material: Material) -> float | None:
    """Measure the plate whose face has an outward normal that leans from z towards +y (`sign` 1) or -y (-1)."""
    p, (x, y, z) = frames.p[rows], np.moveaxis(frames.R[rows], 2, 0)
    half = frames.angle_rad[rows, None] / 2.0
    normal = np.cos(half) * z + np.sin(half) * sign * y
    inner = np.sin(half) * z - np.cos(half) * sign * y
    length_mm, rough = float(np.ptp(frames.s_mm)), None
    for away in (inner, -inner):  # a face of a fillet goes on upwards, one at the outside of a corner downwards
        for beside in BESIDE_MM:
            above = p + beside * away + ABOVE_MM * normal
            at, solid = _entered(above, -normal, material)
            inside = above - (at + INSIDE_MM)[:, None] * normal
            (whole, through), (_, along), (_, across) = (
                _chords(inside, solid, way, material) for way in (normal, x, inner)
            )
            at_edge = np.where(np.abs(along - length_mm) <= SHORTER_MM, along, np.nan)
            flat = np.fmin(np.where(across < through, across, through), at_edge)
            if np.isfinite(flat).any():
                return float(np.nanmedian(flat))
            if rough is None and np.isfinite(whole).any():
                rough = float(np.nanmedian(whole))
    return rough


def _entered(origins: FloatArray, rays: FloatArray, material: Material) -> tuple[FloatArray, IntArray]:
    """Return how far rays go to a solid, mm, and its number; NaN for those that enter none where expected."""
    hits = material.hits(origins, rays, 1.5 * ABOVE_MM)
    ray, first = np.unique(hits.ray, return_index=True)
    at, solid = np.full(len(origins), np.nan), np.full(len(origins), -1)
    is_there = (hits.way[first] == -1) & (hits.at_mm[first] >= 0.5 * ABOVE_MM)
    at[ray[is_there]], solid[ray] = hits.at_mm[first[is_there]], hits.solid[first]
    return at, solid


def _chords(inside: FloatArray, solid: IntArray, way: FloatArray, material: Material) -> FloatArray:
    """Measure solids from points inside them, both ways along a direction.

    `inside`: shape (n, 3). NaN where there is no point.
    `way`: shape (n, 3). Unit vectors.

    Returns: shape (2, n). Each length, mm, and the same if the faces at its ends are parallel, else NaN.
    """
    first = square_to(way)
    second = np.cross(way, first)
    steps = ASIDE_MM * np.array([np.zeros_like(way), first, -first, second, -second])
    origins = np.broadcast_to(inside + steps, (2, *steps.shape)).reshape(-1, 3)
    rays = np.broadcast_to(np.array([way, -way])[:, None], (2, *steps.shape)).reshape(-1, 3)
    known = np.flatnonzero(np.isfinite(origins[:, 0]))
    hits = material.hits(origins[known], rays[known], THICKEST_MM)
    out = np.flatnonzero((hits.way == 1) & (hits.solid == np.tile(solid, 10)[known[hits.ray]]))
    ray, nearest = np.unique(hits.ray[out], return_index=True)
    ends = np.full(len(origins), np.nan)
    ends[known[ray]] = hits.at_mm[out[nearest]]
    whole, *aside = ends.reshape(2, 5, -1).sum(axis=0)
    slope = np.abs([aside[0] - aside[1], aside[2] - aside[3]]).max(axis=0) / (2.0 * ASIDE_MM)
    return np.array([whole, np.where(slope <= MOST_SLOPE, whole, np.nan)])
