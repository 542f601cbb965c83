"""The capsules of a cell with one robot that are compared with its part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.planning.cell.bodies import Body, Owner
from wpcal.planning.cell.cell import TOOL, Cell
from wpcal.planning.cell.shape import JOINTS
from wpcal.robot.kinematics.forward import Frames


@dataclass(frozen=True, slots=True, eq=False)
class PartCapsules:
    """The capsules that are compared with the part: their bodies, carriers, ends, radii and safety distances."""

    body: IntArray
    carriers: IntArray
    p: FloatArray
    q: FloatArray
    radius_mm: FloatArray
    needed_mm: FloatArray
    has_hull: BoolArray

    @classmethod
    def of(cls, cell: Cell, bodies: tuple[Body, ...]) -> PartCapsules:
        """Return the capsules of those of some bodies that can meet the part."""
        rows = [row for row, body in enumerate(bodies) if _meets_part(body, cell)]
        shapes = [bodies[row].shape for row in rows]
        count = [len(shape.radius_mm) for shape in shapes]
        needed = [
            cell.d1_mm if bodies[row].carrier != TOOL or shape.to_part_mm is None else shape.to_part_mm
            for row, shape in zip(rows, shapes, strict=True)
        ]
        body = np.repeat(np.array(rows, dtype=np.int64), count)
        p, q = (np.concatenate([np.zeros((0, 3)), *(getattr(shape, end) for shape in shapes)]) for end in ("p", "q"))
        radius = np.concatenate([np.zeros(0), *(shape.radius_mm for shape in shapes)])
        carriers = np.array([bodies[row].carrier for row in body], dtype=np.int64)
        hulled = np.repeat(np.array([len(shape.hull) > 0 for shape in shapes], dtype=bool), count)
        return cls(body, carriers, p, q, radius, np.repeat(np.array(needed, dtype=np.float64), count), hulled)

    def in_part(self, frames: tuple[Frames, ...], part_row: int) -> tuple[FloatArray, FloatArray]:
        """Return the ends of the axes in the frame of the part at n states, shapes (n, c, 3), mm."""
        n = max(frame.p.shape[1] for frame in frames)
        part = frames[part_row]
        R = np.broadcast_to(part.rotations(), (n, 3, 3))
        origin = np.broadcast_to(part.p, (3, n))
        carriers = sorted(set(self.carriers.tolist()))
        ends = np.empty((2, n, len(self.body), 3))
        for carrier in carriers:
            columns = np.flatnonzero(self.carriers == carrier)
            local = np.stack([self.p[columns], self.q[columns]])  # (2, c, 3)
            frame = frames[carrier]
            axes = np.stack([frame.x, frame.y, frame.z])  # (3, 3, n or 1)
            world = np.einsum("kxn,eck->encx", axes, local) + frame.p.T[:, None]
            ends[:, :, columns] = np.einsum("nji,encj->enci", R, world - origin.T[:, None])
        return ends[0], ends[1]


def _meets_part(body: Body, cell: Cell) -> bool:
    if body.owner is Owner.ROBOT:
        return body.link > 0 or cell.carrier is not None
    turns = cell.carrier is not None and len(cell.carrier.arm.joints) > 1
    return turns and body.link == 0


def tool_capsules(cell: Cell) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the torch's capsules: ends in `tool` (c, 3) twice, radii (c,) and distances from the part (c,), mm."""
    bodies = tuple(Body(shape, Owner.ROBOT, JOINTS + 1, TOOL) for shape in cell.torch)
    found = PartCapsules.of(cell, bodies)
    return found.p, found.q, found.radius_mm, found.needed_mm
