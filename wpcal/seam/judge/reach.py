"""The one judgement of reach: where on its way along a seam the torch is inside material.

The torch moves as a controller moves it, between the poses at the frames of the seam or at the moves of a program, and
comes and goes along the wire at both ends. It is compared at places between which none of its points moves farther than
its step (`wpcal.robot.moves.sweep`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
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
        """Say it for people. `frame`: shape (n,). Numbers of the seam's points at the poses, if they are others."""
        place = self.at if frame is None else float(np.interp(self.at, np.arange(len(frame)), frame))
        row = math.floor(place)
        where = f"point {row}" if row == place else f"between points {row} and {row + 1}"
        x, y, z = self.p
        what = f"the {self.part.value} is inside {self.solid!r}"
        return f"seam {name}: {where}, base {x:.1f}, {y:.1f}, {z:.1f} mm: {what}"


def find_in_ways(
    material: Material,
    ways: Sequence[tuple[Seam, FloatArray, FloatArray]],
    torch: TorchShape,
    *,
    axis: ToolAxis = ToolAxis.Z,
    back_mm: tuple[float, float] = (0.0, 0.0),
) -> list[tuple[InWay, ...]]:
    """Return every place along each seam, or on the way along the wire to its ends, with the torch inside material.

    `ways`: Seams with the tips of the wire, shape (n, 3), in the frame of the material, mm, and the axes of the tool in
    the same frame, shape (n, 3, 3).
    `torch`: With its usual wire: that of the seam (`Seam.more_wire_mm`) is added.
    `back_mm`: How far the torch comes from along the wire at the first point, and goes at the last, mm.
    """
    found = [tuple[InWay, ...]()] * len(ways)
    for more_mm in {seam.more_wire_mm for seam, *_ in ways}:
        own = [number for number, (seam, *_) in enumerate(ways) if seam.more_wire_mm == more_mm]
        longer = torch.with_more_wire(more_mm)
        swept = [sweep(*ways[number][1:], longer.reaching, axis=2 if axis is ToolAxis.Z else 0) for number in own]
        counts = np.array([len(each.at) for each in swept])
        ends = np.cumsum(counts)
        more, R = np.zeros(ends[-1]), np.concatenate([each.R for each in swept])
        more[ends - counts], more[ends - 1] = back_mm
        inside = find_poses_in_material(
            material,
            np.concatenate([each.p for each in swept]),
            -wire_directions(R, axis),
            longer,
            start_mm=np.repeat([start_mm(ways[number][0]) for number in own], counts),
            more_mm=more,
            bend=None if torch.neck is None else neck_directions(R, axis),
        )
        for row, part, solid in zip(inside.row.tolist(), inside.part, inside.solid, strict=True):
            which = int(np.searchsorted(ends, row, side="right"))
            at, each = row - ends[which] + counts[which], swept[which]
            found[own[which]] += (InWay(float(each.at[at]), each.p[at], part, solid),)
    return found
