"""All bodies of a cell, and the pairs that can meet.

Which pairs are compared
    * Bodies of the robot with the torch (links, torch) with bodies of the carrier of the part (links of the positioner
      or of robot 2, part): all, but not the base with the frame of a positioner.
    * Bodies of one robot: if at least four joints are between them. Nearer bodies touch by construction (the three
      axes of a wrist meet in a point), or the limits of the joints between them keep them apart. The torch and the part
      count as one link beyond the flange, so they are compared with links 0 to 3.
    * The bench: with the bodies of links 2 to 6 of a robot, the torch, the part, and what a positioner moves. The base
      is mounted on the bench, and link 1 turns about a vertical axis above it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.motion import WIRE_RADIUS_MM
from wpcal.planning.cell.cell import CARRIER, TOOL, WORLD, Cell
from wpcal.planning.cell.segments import Segments, segment_distances
from wpcal.planning.cell.shape import JOINTS, Shape

JOINTS_BETWEEN = 4  #: Fewest joints between two bodies of one robot that are compared: see the head of this file.
FIRST_LINK_OVER_BENCH = 2  #: Links of a robot before this one cannot be brought to the bench by any joint.


class Owner(Enum):
    """The owner of a body; a cell with one robot has `ROBOT` and `POSITIONER` instead of the two robots."""

    ROBOT1 = "robot 1"
    ROBOT2 = "robot 2"
    BENCH = "bench"
    ROBOT = "robot"
    POSITIONER = "positioner"

    @property
    def has_torch(self) -> bool:
        """Whether it is the robot with the torch."""
        return self in (Owner.ROBOT, Owner.ROBOT1)


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A shape and the frame that carries it."""

    shape: Shape
    owner: Owner
    link: int  #: 0 to 6; 7 for torch and part.
    carrier: int  #: Row of its frame in the result of `Cell.frames`.

    @property
    def name(self) -> str:
        """Owner and shape, for messages."""
        return self.shape.name if self.owner is Owner.BENCH else f"{self.owner.value} {self.shape.name}"


@dataclass(frozen=True, slots=True, eq=False)
class BodyPairs:
    """The bodies of a cell and the pairs of them that can meet."""

    bodies: tuple[Body, ...]
    #: `first`, `second`: shape (m,). Rows of `bodies`.
    first: IntArray
    second: IntArray
    #: shape (m,). Distance that each pair must keep, mm: d1, or the nozzle's own distance to the part.
    safety_mm: FloatArray

    def __len__(self) -> int:
        return len(self.first)

    def names(self, row: int) -> tuple[str, str]:
        """Return the names of the bodies of one pair."""
        return self.bodies[self.first[row]].name, self.bodies[self.second[row]].name


def stick_out_mm(cell: Cell) -> float:
    """Return the length of the wire from its tip to the nozzle, mm; of a torch without sizes to its nearest body."""
    if cell.torch_shape is not None:
        return cell.torch_shape.wire_mm
    tip = Segments(np.zeros((3, 1)), np.zeros((3, 1)))
    axes = [segment_distances(tip, Segments(shape.p.T, (shape.q - shape.p).T)) for shape in cell.torch]
    return min(
        (float((axis - shape.radius_mm).min()) for axis, shape in zip(axes, cell.torch, strict=True)), default=0.0
    )


def with_wire(cell: Cell, to_part_mm: float, more_mm: float = 0.0) -> Cell:
    """Return the cell for moves through the air: the wire is a body of the torch.

    `to_part_mm`: Least distance of the wire from the part.
    `more_mm`: How far the longest wire of a seam sticks out beyond the tool centre point.
    """
    length = stick_out_mm(cell)
    if length <= 0.0:
        return cell
    ends = np.array([[0.0, 0.0, more_mm]]), np.array([[0.0, 0.0, -length]])
    wire = Shape("wire", *ends, np.array([WIRE_RADIUS_MM]), to_part_mm=to_part_mm)
    return replace(cell, torch=(wire, *cell.torch))


def with_torch_at(cell: Cell, to_part_mm: float) -> Cell:
    """Return the cell whose torch may come this near to the part, where its bodies ask for more."""
    near = [cell.d1_mm if shape.to_part_mm is None else shape.to_part_mm for shape in cell.torch]
    torch = [replace(shape, to_part_mm=min(mm, to_part_mm)) for shape, mm in zip(cell.torch, near, strict=True)]
    return replace(cell, torch=tuple(torch))


def bodies_of(cell: Cell) -> tuple[Body, ...]:
    """Return every body of a cell: links of the robot, torch, links of the carrier, part, bench."""
    two = cell.has_two_robots
    robot, carrier = (Owner.ROBOT1, Owner.ROBOT2) if two else (Owner.ROBOT, Owner.POSITIONER)
    carried = () if cell.carrier is None else cell.carrier.links
    return (
        *(Body(shape, robot, shape.link, shape.link) for shape in cell.links),
        *(Body(shape, robot, JOINTS + 1, TOOL) for shape in cell.torch),
        *(Body(shape, carrier, shape.link, CARRIER + shape.link) for shape in carried),
        *(Body(shape, carrier, JOINTS + 1, cell.part_row) for shape in cell.part),
        *(Body(shape, Owner.BENCH, 0, WORLD) for shape in cell.bench),
    )


def body_pairs(cell: Cell) -> BodyPairs:
    """Return the pairs of bodies that can meet (the rule is at the head of this file)."""
    bodies = bodies_of(cell)
    rows = [(i, j) for i in range(len(bodies)) for j in range(i + 1, len(bodies)) if _can_meet(bodies[i], bodies[j])]
    first, second = (np.array([row[k] for row in rows], dtype=np.int64) for k in (0, 1))
    safety = [_safety(cell, bodies[i], bodies[j]) for i, j in rows]
    return BodyPairs(bodies, first, second, np.array(safety, dtype=np.float64))


def _can_meet(a: Body, b: Body) -> bool:
    """Apply the rule to two different bodies; the bench is last in the list."""
    if b.owner is Owner.BENCH:
        least = {Owner.BENCH: JOINTS + 2, Owner.POSITIONER: 1}.get(a.owner, FIRST_LINK_OVER_BENCH)
        return a.link >= least
    if a.owner is b.owner:
        return abs(a.link - b.link) >= JOINTS_BETWEEN
    return b.owner is not Owner.POSITIONER or a.link + b.link > 0


def _safety(cell: Cell, a: Body, b: Body) -> float:
    if a.carrier == TOOL and b.carrier == cell.part_row and a.shape.to_part_mm is not None:
        return a.shape.to_part_mm
    return cell.d1_mm
