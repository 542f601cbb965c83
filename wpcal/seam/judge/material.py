"""Which poses have the tip, the wire or the nozzle inside material, and inside which solid: the one check of poses.

It takes the part as exact faces (`ExactMaterial`) where they are at hand, and as triangles (`TriangleMaterial`) for
programs that are written from a result folder.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from itertools import chain
from typing import TypeAlias

import numpy as np

from wpcal.brep.hits import START_MM
from wpcal.brep.material import Material, find_solids_around
from wpcal.brep.tubes import Radius
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.robot.moves.sweep import STEP_MM
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape, Tube

WIRE_RADIUS_MM = 0.3
"""Half of the radius of a usual wire: in a joint of 60 degrees a whole wire touches both plates near the root."""
NEAR_ROOT_MM = 4.0
"""Nearer to the tip only the axis of the wire is felt: in the root of an acute joint, such as the chamfer of a prepared
edge, a wire touches the faces that it joins. At 4 mm a wire 7 degrees beside a face is free of it."""
TOUCH_MM = 1e-3  #: A nozzle that touches a face along a line is free: it is felt this much nearer to its axis.


class TorchPart(Enum):
    """What of a torch is inside material; the order is from the seam outwards."""

    TIP = "tip"
    WIRE = "wire"
    NOZZLE = "nozzle"
    NECK = "neck"  #: Neck or body.


_Tubes: TypeAlias = tuple[tuple[TorchPart, FloatArray, FloatArray, Radius], ...]


@dataclass(frozen=True, slots=True, eq=False)
class PosesInMaterial:
    """The poses at which a torch is inside material, one row each, by number of the pose."""

    row: IntArray  #: shape (k,). Numbers of the poses.
    solid: tuple[str, ...]  #: length k. The solid that is hit first.
    part: tuple[TorchPart, ...]  #: length k. The part of the torch nearest to the tip that is inside.

    def __len__(self) -> int:
        return len(self.row)


@dataclass(frozen=True, slots=True, eq=False)
class Necks:
    """Necks and bodies of n torches, each beyond the mouth of its nozzle."""

    torch: TorchShape
    mouth: FloatArray  #: shape (n, 3). Middles of the mouths, mm.
    back: FloatArray  #: shape (n, 3). Unit directions along the wire to the torch.
    bend: FloatArray  #: shape (n, 3). Unit directions towards which the neck bends.
    more_mm: FloatArray  #: shape (n,). How far each torch goes back along the wire.

    def steps(self) -> Iterator[tuple[Tube, IntArray, FloatArray]]:
        """Yield each piece with the torches that are felt, by number, and their mouths; shapes (k,) and (k, 3).

        First they are felt where they are, then at all steps of the way back: of each torch the farthest step first.
        """
        count = np.ceil(self.more_mm / STEP_MM).astype(np.int64)
        here, row = np.arange(len(count)), np.repeat(np.arange(len(count)), count)
        far_mm = np.minimum(STEP_MM * (np.cumsum(count)[row] - np.arange(len(row))), self.more_mm[row])
        for rows, mm in ((here, np.zeros(len(here))), (row, far_mm)):
            mouth = self.mouth[rows] + mm[:, None] * self.back[rows]
            yield from ((tube, rows, mouth) for tube in self.torch.tubes if len(rows))


def find_poses_in_material(
    material: Material,
    p: FloatArray,
    back: FloatArray,
    torch: TorchShape = USUAL_TORCH,
    *,
    start_mm: FloatArray | float = START_MM,
    more_mm: FloatArray | float = 0.0,
    bend: FloatArray | None = None,
) -> PosesInMaterial:
    """Find the poses at which the tip, the wire, the nozzle or the neck of a torch is inside material.

    `p`: shape (n, 3). Tips of the wire in the frame of the material, mm.
    `back`: shape (n, 3). Unit directions from the tip along the wire to the torch: z of a seam frame if the torch is
    not tilted.
    `start_mm`: shape (n,). The tip is in contact with the joint, so the wire is felt from this far away from its tip.
    On a modelled bead the tip is below the face of the bead; use `stations.BEAD_MM` there.
    `more_mm`: shape (n,). How far beyond its length the torch is felt: it comes and goes along the wire.
    `bend`: shape (n, 3). Unit directions towards which the neck bends. None: neck and body are not felt.

    Triangles are felt by the whole tubes of wire and nozzle; they are within their deflection of the part, and so is
    the answer. Exact faces are felt by lines in the tubes; what is narrower than the distance of two lines
    (`wpcal.brep.tubes.LINES_MM`) can be missed. A solid around the whole torch is found at the tip.
    """
    start, more = (np.broadcast_to(np.asarray(mm, dtype=np.float64), len(p)) for mm in (start_mm, more_mm))
    free = np.ones(len(p), dtype=bool)
    found: list[tuple[int, int, TorchPart]] = []
    necks = (
        () if bend is None else _inside_neck(material, Necks(torch, p + torch.wire_mm * back, back, bend, more), free)
    )
    for part, rows, solids in chain(_inside(material, p, back, _tubes(torch, start, more), free), necks):
        for row, solid in zip(rows.tolist(), solids.tolist(), strict=True):
            if free[row]:
                free[row] = False
                found.append((row, solid, part))
    found.sort(key=lambda item: item[0])
    names = tuple(material.names[solid] for _, solid, _ in found)
    return PosesInMaterial(np.array([item[0] for item in found], dtype=np.int64), names, tuple(t for *_, t in found))


def _tubes(torch: TorchShape, start: FloatArray, more: FloatArray) -> _Tubes:
    """Return wire and nozzle as tubes: what they are, where they begin and end, shape (n,), and their radii, mm."""
    mouth = np.maximum(torch.wire_mm, start)
    whole, cone = np.clip(NEAR_ROOT_MM, start, mouth), mouth + torch.taper_mm
    wide = torch.nozzle_radius_mm - TOUCH_MM
    conical = () if torch.taper_mm == 0.0 else ((TorchPart.NOZZLE, mouth, cone, (torch.mouth_mm - TOUCH_MM, wide)),)
    return (
        (TorchPart.WIRE, start, whole, TOUCH_MM),
        (TorchPart.WIRE, whole, mouth, WIRE_RADIUS_MM),
        *conical,
        (TorchPart.NOZZLE, cone, torch.wire_mm + torch.front_mm + more, wide),
    )


def _inside(
    material: Material, p: FloatArray, back: FloatArray, tubes: _Tubes, free: BoolArray
) -> Iterator[tuple[TorchPart, IntArray, IntArray]]:
    """Yield parts of the torch from the tip outwards, with the poses and solids; only poses still free are asked."""
    point, solid = find_solids_around(material, p + tubes[0][1][:, None] * back)
    yield TorchPart.TIP, point, solid
    for part, low, high, radius in tubes:
        rows = np.flatnonzero(free)
        solids = material.tube_solids(p[rows], back[rows], low[rows], high[rows], radius)
        yield part, rows[solids >= 0], solids[solids >= 0]


def _inside_neck(material: Material, necks: Necks, free: BoolArray) -> Iterator[tuple[TorchPart, IntArray, IntArray]]:
    """Yield the poses at which neck or body is inside solids, there and at steps of the way along the wire."""
    for tube, torches, mouth in necks.steps():
        kept = np.flatnonzero(free[torches])
        rows = torches[kept]
        start, way, length = place_tube(tube, mouth[kept], necks.back[rows], necks.bend[rows])
        zero = np.zeros(len(rows))
        solids = material.tube_solids(start, way, zero, zero + length, tube.radius_mm - TOUCH_MM)
        hit = np.flatnonzero(solids >= 0)[::-1]  # the nearest step of each first
        yield TorchPart.NECK, rows[hit], solids[hit]


def place_tube(
    tube: Tube, mouth: FloatArray, back: FloatArray, bend: FloatArray
) -> tuple[FloatArray, FloatArray, float]:
    """Return starts and directions, shapes (n, 3), and the length (mm) of a piece of a torch at poses.

    `mouth`: shape (n, 3). Middles of the mouths of the nozzles, mm.
    `back`, `bend`: shape (n, 3). Unit directions in the same frame: along the wire to the torch, and towards which the
    neck bends.
    """
    axes = np.stack([bend, np.cross(back, bend), back], axis=2)
    length = float(np.linalg.norm(tube.end - tube.start))
    return mouth + axes @ tube.start, axes @ ((tube.end - tube.start) / length), length
