"""All bodies of a cell, the pairs that can meet, and the frames of the bodies at many states.

Which pairs are compared
    * Bodies of robot 1 (links, torch) with bodies of robot 2 (links, part): all.
    * Bodies of one robot: if at least four joints are between them. Nearer bodies touch by construction (the three
      axes of a wrist meet in a point), or the limits of the joints between them keep them apart. The torch and the part
      count as one link beyond the flange, so they are compared with links 0 to 3.
    * The bench: with the bodies of links 2 to 6, the torch and the part. The base is mounted on the bench, and link 1
      turns about a vertical axis above it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.robot_cell import JOINTS, CellState, RobotCell, Shape
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.forward import Frames, start_frames, walk

JOINTS_BETWEEN = 4
"""Fewest joints between two bodies of one robot that are compared: see the head of this file."""
FIRST_LINK_OVER_BENCH = 2
"""Links before this one cannot be brought to the bench by any joint."""


class Owner(Enum):
    """The owner of a body; a cell with one robot has `ROBOT` and `POSITIONER` instead of the two robots."""

    ROBOT1 = "robot 1"
    ROBOT2 = "robot 2"
    BENCH = "bench"
    ROBOT = "robot"
    POSITIONER = "positioner"


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A shape and the frame that carries it."""

    shape: Shape
    owner: Owner
    link: int  #: 0 to 6; 7 for torch and part.
    carrier: int  #: Row of its frame in the result of `body_frames`.

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


TOOL, PART, WORLD = 2 * (JOINTS + 1), 2 * (JOINTS + 1) + 1, 2 * (JOINTS + 1) + 2
"""Rows of these frames, after the seven of each arm."""


def bodies_of(cell: RobotCell) -> tuple[Body, ...]:
    """Return every body of a cell: links of robot 1, torch, links of robot 2, part, bench."""
    return (
        *(Body(shape, Owner.ROBOT1, shape.link, shape.link) for shape in cell.links1),
        *(Body(shape, Owner.ROBOT1, JOINTS + 1, TOOL) for shape in cell.torch),
        *(Body(shape, Owner.ROBOT2, shape.link, JOINTS + 1 + shape.link) for shape in cell.links2),
        *(Body(shape, Owner.ROBOT2, JOINTS + 1, PART) for shape in cell.part),
        *(Body(shape, Owner.BENCH, 0, WORLD) for shape in cell.bench),
    )


def body_pairs(cell: RobotCell) -> BodyPairs:
    """Return the pairs of bodies that can meet (the rule is at the head of this file)."""
    bodies = bodies_of(cell)
    rows = [
        (i, j, _safety(cell, bodies[i], bodies[j]))
        for i in range(len(bodies))
        for j in range(i + 1, len(bodies))
        if _can_meet(bodies[i], bodies[j])
    ]
    first, second = (np.array([row[k] for row in rows], dtype=np.int64) for k in (0, 1))
    return BodyPairs(bodies, first, second, np.array([row[2] for row in rows], dtype=np.float64))


def _can_meet(a: Body, b: Body) -> bool:
    """Apply the rule to two different bodies; the bench is last in the list."""
    if b.owner is Owner.BENCH:
        return a.owner is not Owner.BENCH and a.link >= FIRST_LINK_OVER_BENCH
    return a.owner is not b.owner or abs(a.link - b.link) >= JOINTS_BETWEEN


def _safety(cell: RobotCell, a: Body, b: Body) -> float:
    if a.carrier == TOOL and b.carrier == PART and a.shape.to_part_mm is not None:
        return a.shape.to_part_mm
    return cell.d1_mm


def body_frames(cell: RobotCell, state: CellState) -> tuple[Frames, ...]:
    """Return the frames that carry bodies, in `world`, mm.

    Returns
    -------
    tuple of Frames
        Base, links 1 to 5 and flange of robot 1, then of robot 2, `tool`, `part`, `world`; arrays of shape (3, n), or
        (3, 1) for frames that do not move.
    """
    frames1 = list(arm_frames(cell.arm1, cell.T_world_base1, state.joints1))
    frames2 = list(arm_frames(cell.arm2, cell.T_world_base2, state.joints2))
    tool, part = frames1[-1].then(cell.T_flange1_tool), frames2[-1].then(cell.T_flange2_part)
    world = start_frames(RigidTransform.identity(target="world", source="world"), 1)
    return (*frames1, *frames2, tool, part, world)


def arm_frames(
    arm: Arm, T_world_base: RigidTransform, joints: FloatArray, *, shift_mm: FloatArray | None = None
) -> Iterator[Frames]:
    """Yield the base, the frames after all links but the last, and the flange of an arm, in `world`.

    Parameters
    ----------
    joints : shape (n, k). Shown angles, rad.
    shift_mm : shape (3, n). How far the base is from `T_world_base`, in `world`, mm.
    """
    moved = 0.0 if shift_mm is None else shift_mm
    base = start_frames(T_world_base, 1)
    yield base._replace(p=base.p + moved)
    theta = np.ascontiguousarray(arm.model_angles(joints).T)
    first = start_frames(T_world_base.relabelled(target="world", source="base") @ arm.chain.T_base_dh0, 1)
    motions = list(walk(first._replace(p=first.p + moved), arm.chain.table, theta))
    yield from (motion.frame for motion in motions[:-1])
    yield motions[-1].frame.then(arm.chain.T_dhn_flange)
