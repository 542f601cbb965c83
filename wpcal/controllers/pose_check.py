"""Refuse weld poses whose wire, nozzle or neck is inside the part, and straight pieces between them that lead there."""

from __future__ import annotations

import math

import numpy as np

from wpcal.brep.rays import START_MM
from wpcal.controllers.part_triangles import PartTriangles, tube_hits
from wpcal.controllers.torch_shape import TorchShape
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import ErrorCode, GeometryError
from wpcal.seam.judge.stations import BEAD_MM
from wpcal.seam.seam import Seam, SeamSource

WIRE_RADIUS_MM = 0.3
"""Half of the radius of a usual wire: in a joint of 60 degrees a whole wire touches both plates near the root."""
STEP_MM = 1.0
"""Between two points of a seam the torch is compared with the part at this step: less than the thinnest sheet that is
welded as a rib, and small against the nozzle."""


def check_weld_poses(
    part: PartTriangles,
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
    part : PartTriangles
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
    start = np.full(len(p), BEAD_MM if seam.source is SeamSource.BEAD else START_MM)  # the root of a bead is inside it
    reach = np.full(len(p), torch.length_mm)
    reach[0], reach[-1] = reach[0] + back_mm[0], reach[-1] + back_mm[1]
    mouth = np.maximum(np.full(len(p), torch.wire_mm), start)
    for what, hits in (
        ("wire", tube_hits(part, p, away, start, mouth, WIRE_RADIUS_MM)),
        ("nozzle", tube_hits(part, p, away, mouth, reach, torch.nozzle_radius_mm)),
    ):
        if (hits >= 0).any():
            row = int(np.argmax(hits >= 0))
            raise _inside(seam, float(at[row]), what, part.solid_of(int(hits[row])), p[row], torch)
    around = part.surrounds(tips + start[0] * back)
    if (around >= 0).any():
        row = int(np.argmax(around >= 0))
        raise _inside(seam, float(row), "tip", part.names[int(around[row])], tips[row], torch)


def _places(tips: FloatArray) -> FloatArray:
    """Return the numbers of points to compare, with fractions between two points."""
    steps = np.maximum(np.ceil(np.linalg.norm(np.diff(tips, axis=0), axis=1) / STEP_MM), 1.0).astype(int)
    return np.concatenate([*(row + np.arange(count) / count for row, count in enumerate(steps)), [float(len(steps))]])


def _inside(seam: Seam, at: float, what: str, solid: str, tip: FloatArray, torch: TorchShape) -> GeometryError:
    x, y, z = tip
    row = math.floor(at)
    place = f"point {row}" if row == at else f"between points {row} and {row + 1}"
    return GeometryError(
        f"seam {seam.name}: {place}, base {x:.1f}, {y:.1f}, {z:.1f} mm: the {what} of {torch} is inside {solid!r}; "
        "no program is written. Cut the seam there (range_mm in seams.json), tilt the torch with --work-angle-deg or "
        "--travel-angle-deg, state its shape (--nozzle-radius-mm, --wire-mm, --torch-length-mm), or leave the seam out "
        "with --seams",
        code=ErrorCode.POSE_IN_MATERIAL,
    )
