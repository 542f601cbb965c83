"""The one judgement of reach: where on its way along a seam the torch is inside material.

The torch moves as a controller moves it, between the poses at the frames of the seam or at the moves of a program. It
is compared at places between which none of its points moves farther than its step (`wpcal.robot.moves.sweep`), but for
those at which it has room all around (`wpcal.seam.judge.room`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from wpcal.brep.hits import START_MM
from wpcal.brep.material import Material, TriangleMaterial, find_solids_around
from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.robot.moves.sweep import Swept, Way, last_poses, sweep
from wpcal.robot.torch.attitude import ToolAxis, neck_directions, wire_directions
from wpcal.robot.torch.shape import TorchShape, Tube
from wpcal.seam.judge.material import PosesInMaterial, TorchPart, find_poses_in_material, place_tube
from wpcal.seam.judge.room import RoomyMaterial, asked_places, with_room
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
) -> list[tuple[InWay, ...]]:
    """Return every place along each seam with the torch inside material.

    `ways`: Seams with the tips of the wire, shape (n, 3), in the frame of the material, mm, and the axes of the tool in
    the same frame, shape (n, 3, 3).
    `torch`: With its usual wire: that of the seam (`Seam.more_wire_mm`) is added.
    """
    found = [tuple[InWay, ...]()] * len(ways)
    for more_mm in {seam.more_wire_mm for seam, *_ in ways}:
        own = [number for number, (seam, *_) in enumerate(ways) if seam.more_wire_mm == more_mm]
        longer = torch.with_more_wire(more_mm)
        paths = [ways[number][1:] for number in own]
        start = np.array([start_mm(ways[number][0]) for number in own])
        swept, inside = sweep_torch(material, paths, longer, axis=axis, start_mm=start)
        last = last_poses(paths)
        for row, part, solid in zip(inside.row.tolist(), inside.part, inside.solid, strict=True):
            way = int(np.searchsorted(last, swept.at[row]))
            at = float(swept.at[row]) - (last[way - 1] + 1 if way else 0)
            found[own[way]] += (InWay(at, swept.p[row], part, solid),)
    return found


def sweep_torch(
    material: Material,
    ways: Sequence[Way],
    torch: TorchShape,
    *,
    axis: ToolAxis,
    start_mm: FloatArray | float = START_MM,
) -> tuple[Swept, PosesInMaterial]:
    """Move a torch along ways, and find the places at which it is inside material.

    `ways`: In the frame of the material; as in `find_in_ways`.
    `start_mm`: shape (k,). For each way, as in `find_poses_in_material`.
    """
    column, last = 2 if axis is ToolAxis.Z else 0, last_poses(ways)
    swept = sweep(ways, torch.reaching, axis=column)
    rows = np.arange(len(swept.at))
    if isinstance(material, TriangleMaterial) and len(material.corners):
        material = with_room(material)
        rows = np.flatnonzero(_may_be_inside(material, swept, torch, axis))
    found = find_poses_in_material(
        material,
        swept.p[rows],
        -swept.R[rows, :, column],
        torch,
        start_mm=np.broadcast_to(start_mm, len(last))[np.searchsorted(last, swept.at[rows])],
        bend=None if torch.neck is None else neck_directions(swept.R[rows], axis),
    )
    return swept, replace(found, row=rows[found.row])


def _may_be_inside(part: RoomyMaterial, swept: Swept, torch: TorchShape, axis: ToolAxis) -> BoolArray:
    """Tell at which places, shape (m,), a torch may be inside material.

    On a stretch of its way on which no triangle meets the torch, it is inside a solid all along, or nowhere.
    """
    front = Tube(np.array([0.0, 0.0, -torch.wire_mm]), np.array([0.0, 0.0, torch.front_mm]), torch.nozzle_radius_mm)
    back, bend = -wire_directions(swept.R, axis), neck_directions(swept.R, axis)
    may = np.zeros(len(back), dtype=bool)
    for tube in (front, *torch.tubes):
        start, way, length = place_tube(tube, swept.p + torch.wire_mm * back, back, bend)
        may |= part.may_meet(start, start + length * way, way, tube.radius_mm)
    of = asked_places(len(may))
    alone = np.unique(of[~may])
    return may | np.isin(of, alone[find_solids_around(part, swept.p[alone])[0]])
