"""The one judgement of reach: where on its way along a seam the torch is inside material.

The torch moves as a controller moves it, between the poses at the frames of the seam or at the moves of a program, and
comes and goes along the wire at both ends. It is compared at places between which none of its points moves farther than
its step (`wpcal.robot.moves.sweep`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from wpcal.brep.material import Material
from wpcal.core.arrays import FloatArray
from wpcal.robot.moves import sweep
from wpcal.robot.torch.attitude import ToolAxis, neck_directions, wire_directions
from wpcal.robot.torch.shape import TorchShape
from wpcal.seam.judge.material import TorchPart, find_poses_in_material
from wpcal.seam.judge.stations import start_mm
from wpcal.seam.seam import Seam


class InWay(NamedTuple):
    """One place at which the torch is inside material."""

    at: float  #: Number of the pose, with a fraction between two poses.
    p: FloatArray  #: shape (3,). Tip of the wire, mm.
    part: TorchPart
    solid: str

    def describe(self, name: str, frame: FloatArray | None = None) -> str:
        """Say it for people.

        `frame`: shape (n,). Numbers of the seam's points at the poses, if they are others.
        """
        place = self.at if frame is None else float(np.interp(self.at, np.arange(len(frame)), frame))
        row = math.floor(place)
        where = f"point {row}" if row == place else f"between points {row} and {row + 1}"
        x, y, z = self.p
        what = f"the {self.part.value} is inside {self.solid!r}"
        return f"seam {name}: {where}, base {x:.1f}, {y:.1f}, {z:.1f} mm: {what}"


def find_in_way(
    material: Material,
    seam: Seam,
    tips: FloatArray,
    R: FloatArray,
    torch: TorchShape,
    *,
    axis: ToolAxis = ToolAxis.Z,
    back_mm: tuple[float, float] = (0.0, 0.0),
) -> tuple[InWay, ...]:
    """Return every place along a seam, or on the way along the wire to its ends, with the torch inside material.

    `tips`: shape (n, 3). Tips of the wire in the frame of the material, mm.
    `R`: shape (n, 3, 3). Axes of the tool in the same frame.
    `torch`: With its usual wire: that of the seam (`Seam.more_wire_mm`) is added.
    `back_mm`: How far the torch comes from along the wire at the first point, and goes at the last, mm.
    """
    torch = torch.with_more_wire(seam.more_wire_mm)
    swept = sweep(tips, R, torch.reaching, axis=2 if axis is ToolAxis.Z else 0)
    more = np.zeros(len(swept.at))
    more[0], more[-1] = back_mm
    back = -wire_directions(swept.R, axis)
    bend = None if torch.neck is None else neck_directions(swept.R, axis)
    found = find_poses_in_material(material, swept.p, back, torch, start_mm=start_mm(seam), more_mm=more, bend=bend)
    rows = found.row.tolist()
    return tuple(
        InWay(float(swept.at[row]), swept.p[row], part, solid)
        for row, part, solid in zip(rows, found.part, found.solid, strict=True)
    )
