"""Refuse weld poses whose tip, wire or nozzle is inside the part, and straight pieces between them that lead there."""

from __future__ import annotations

import math

import numpy as np

from wpcal.brep.material import Material
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import ErrorCode, GeometryError
from wpcal.seam.judge.material import TorchPart, find_poses_in_material
from wpcal.seam.judge.stations import start_mm
from wpcal.seam.seam import Seam
from wpcal.seam.torch import TorchShape

STEP_MM = 1.0
"""Between two points of a seam the torch is compared with the part at this step: less than the thinnest sheet that is
welded as a rib, and small against the nozzle."""


def check_weld_poses(
    part: Material,
    seam: Seam,
    tips: FloatArray,
    back: FloatArray,
    torch: TorchShape,
    *,
    back_mm: tuple[float, float],
) -> None:
    """Refuse a seam when the torch is inside material along it, or on its way along the wire to its ends.

    Parameters
    ----------
    part : Material
        In `base`.
    seam : Seam
        For the message, and for how its root was found.
    tips : ndarray, shape (n, 3)
        Tips of the wire in `base`, mm.
    back : ndarray, shape (n, 3)
        Unit vectors from the tips along the wire towards the torch.
    torch : TorchShape
    back_mm : tuple of float
        How far the torch comes from along the wire at the first point, and goes at the last, mm.

    Raises
    ------
    GeometryError
        With the seam, the point (counted from 0, as in ``seams.csv``), what is inside and the solid.
    """
    at = _places(tips)
    rows = np.minimum(at.astype(int), len(tips) - 2)
    share = (at - rows)[:, None]
    p = tips[rows] + share * (tips[rows + 1] - tips[rows])
    away = back[rows] + share * (back[rows + 1] - back[rows])
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    more = np.zeros(len(p))
    more[0], more[-1] = back_mm
    found = find_poses_in_material(part, p, away, torch, start_mm=start_mm(seam), more_mm=more)
    if len(found):
        row = int(found.row[0])
        raise _inside(seam, float(at[row]), found.part[0], found.solid[0], p[row], torch)


def _places(tips: FloatArray) -> FloatArray:
    """Return the numbers of points to compare, with fractions between two points."""
    steps = np.maximum(np.ceil(np.linalg.norm(np.diff(tips, axis=0), axis=1) / STEP_MM), 1.0).astype(int)
    return np.concatenate([*(row + np.arange(count) / count for row, count in enumerate(steps)), [float(len(steps))]])


def _inside(seam: Seam, at: float, what: TorchPart, solid: str, tip: FloatArray, torch: TorchShape) -> GeometryError:
    x, y, z = tip
    row = math.floor(at)
    place = f"point {row}" if row == at else f"between points {row} and {row + 1}"
    return GeometryError(
        f"seam {seam.name}: {place}, base {x:.1f}, {y:.1f}, {z:.1f} mm: the {what.value} of {torch} is inside "
        f"{solid!r}; no program is written. Cut the seam there (range_mm in seams.json), tilt the torch with "
        "--work-angle-deg or --travel-angle-deg, state its shape (--nozzle-radius-mm, --wire-mm, --torch-length-mm), "
        "or leave the seam out with --seams",
        code=ErrorCode.POSE_IN_MATERIAL,
    )
