"""Find weld poses whose tip, wire or nozzle is inside the part, and straight pieces between them that lead there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from wpcal.brep.material import Material
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import ErrorCode, GeometryError
from wpcal.seam.judge.material import find_poses_in_material
from wpcal.seam.judge.stations import start_mm
from wpcal.seam.seam import Seam
from wpcal.seam.torch import TorchShape

STEP_MM = 1.0
"""Between two points of a seam the torch is compared with the part at this step: less than the thinnest sheet that is
welded as a rib, and small against the nozzle."""
MOST_TOLD = 3
"""Seams whose place is told; of the others the names: the message is one line."""


def find_weld_pose_in_material(
    part: Material,
    seam: Seam,
    tips: FloatArray,
    back: FloatArray,
    torch: TorchShape,
    *,
    back_mm: tuple[float, float],
    frame: FloatArray | None = None,
    bend: FloatArray | None = None,
) -> str | None:
    """Say where along a seam, or on its way along the wire to its ends, the torch is inside material.

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
        With its usual wire; `Seam.more_wire_mm` comes to it.
    back_mm : tuple of float
        How far the torch comes from along the wire at the first point, and goes at the last, mm.

    frame : ndarray, shape (n,), optional
        Numbers of the seam's frames at the tips, with fractions between them. None: the tips are those of the frames.
    bend : ndarray, shape (n, 3), optional
        Unit directions in `base` towards which the neck of the torch bends. None: neck and body are not compared.

    Returns
    -------
    str or None
        The seam, the first point (counted from 0, as in ``seams.csv``), what is inside and the solid; None if the torch
        is free everywhere.
    """
    at = _places(tips)
    rows = np.minimum(at.astype(int), len(tips) - 2)
    share = (at - rows)[:, None]
    p = tips[rows] + share * (tips[rows + 1] - tips[rows])
    away = _between(back, rows, share)
    more = np.zeros(len(p))
    more[0], more[-1] = back_mm
    torch = torch.with_more_wire(seam.more_wire_mm)
    side = None if bend is None else _between(bend, rows, share)
    found = find_poses_in_material(part, p, away, torch, start_mm=start_mm(seam), more_mm=more, bend=side)
    if len(found) == 0:
        return None
    x, y, z = p[found.row[0]]
    place = float(at[found.row[0]])
    place = place if frame is None else float(np.interp(place, np.arange(len(frame)), frame))
    row = math.floor(place)
    where = f"point {row}" if row == place else f"between points {row} and {row + 1}"
    what = f"the {found.part[0].value} is inside {found.solid[0]!r}"
    return f"seam {seam.name}: {where}, base {x:.1f}, {y:.1f}, {z:.1f} mm: {what}"


def _between(ways: FloatArray, rows: IntArray, share: FloatArray) -> FloatArray:
    """Return unit vectors between those at `rows` and the next ones."""
    way = ways[rows] + share * (ways[rows + 1] - ways[rows])
    return np.asarray(way / np.linalg.norm(way, axis=1, keepdims=True), dtype=np.float64)


def _places(tips: FloatArray) -> FloatArray:
    """Return the numbers of points to compare, with fractions between two points."""
    steps = np.maximum(np.ceil(np.linalg.norm(np.diff(tips, axis=0), axis=1) / STEP_MM), 1.0).astype(int)
    return np.concatenate([*(row + np.arange(count) / count for row, count in enumerate(steps)), [float(len(steps))]])


def refused(found: Mapping[str, str], names: Sequence[str], torch: TorchShape) -> GeometryError:
    """Return the error that names every seam with poses in material, and what can be done.

    Parameters
    ----------
    found : mapping of str to str
        What is inside material, by the name of the seam; at least one.
    names : sequence of str
        All seams of the program.
    torch : TorchShape
    """
    told = [*found.values()][:MOST_TOLD]
    more = [*found][MOST_TOLD:]
    others = f"; also {len(more)} more: {', '.join(more)}" if more else ""
    free = [name for name in names if name not in found]
    leave_out = f"; the others can be written: --only {','.join(free)}" if free else ""
    return GeometryError(
        f"{'; '.join(told)}{others} ({torch}); no program is written. Cut it there (range_mm in seams.json), tilt "
        "the torch with --work-angle-deg or --travel-angle-deg, or state its shape (--nozzle-radius-mm, --wire-mm, "
        f"--torch-length-mm){leave_out}",
        code=ErrorCode.POSE_IN_MATERIAL,
    )
