"""How thick the plates of a joint are, felt with rays through the part's triangles.

A ray starts beside the seam, just above one of its two faces, and goes straight into the plate. Where it leaves the
material again is the thickness there.
"""

import numpy as np

from wpcal.brep.material import Material
from wpcal.core.arrays import FloatArray
from wpcal.seam.seam import SeamFrames

BESIDE_MM = (3.0, 1.5, 6.0)
"""Distances from the seam at which a ray starts, in the order of preference: beyond a small round, on a narrow face."""
ABOVE_MM = 1.0
"""Height above the face at which a ray starts. A face that is nearer or farther than this by half is another face."""
STATIONS = (0.25, 0.5, 0.75)
"""Where along the seam: the median is the answer, so a hole or a cut at one of them does not matter."""
THICKEST_MM = 1000.0  #: No plate is thicker; a ray ends there.


def plate_thicknesses(frames: SeamFrames, material: Material) -> tuple[float | None, float | None]:
    """Measure the two plates of a joint.

    Returns: Of the plate at the side of +y and of that at the side of -y, mm; None where no face was found.
    """
    rows = np.unique((np.array(STATIONS) * (len(frames) - 1)).round().astype(int))
    y, z = frames.R[rows, :, 1], frames.R[rows, :, 2]
    half = frames.angle_rad[rows, None] / 2.0
    first, second = (_thickness(frames.p[rows], s * y, z, half, material) for s in (1.0, -1.0))
    return first, second


def thinner(thicknesses: tuple[float | None, float | None]) -> float | None:
    """Return the smaller of two thicknesses, to a tenth of a millimetre; None if none is known."""
    known = [each for each in thicknesses if each is not None]
    return round(min(known), 1) if known else None


def _thickness(p: FloatArray, side: FloatArray, z: FloatArray, half: FloatArray, material: Material) -> float | None:
    """Measure the plate whose face has an outward normal that leans from z towards `side`."""
    normal = np.cos(half) * z + np.sin(half) * side
    inner = np.sin(half) * z - np.cos(half) * side
    for away in (inner, -inner):  # a face of a fillet goes on upwards, one at the outside of a corner downwards
        for beside in BESIDE_MM:
            origins = p + beside * away + ABOVE_MM * normal
            found = _through(origins, -normal, material)
            if found is not None:
                return found
    return None


def _through(origins: FloatArray, rays: FloatArray, material: Material) -> float | None:
    """Return the median length of rays in the first solid that they enter, of those that enter where expected."""
    hits = material.hits(origins, rays, THICKEST_MM)
    lengths = []
    for ray in range(len(origins)):
        own = np.flatnonzero(hits.ray == ray)
        if len(own) == 0 or hits.way[own[0]] != -1 or abs(hits.at_mm[own[0]] - ABOVE_MM) > ABOVE_MM / 2.0:
            continue
        out = own[(hits.solid[own] == hits.solid[own[0]]) & (hits.way[own] == 1)]
        if len(out):
            lengths.append(float(hits.at_mm[out[0]] - hits.at_mm[own[0]]))
    return float(np.median(lengths)) if lengths else None
