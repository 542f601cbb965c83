"""How far bodies can move towards each other per unit of each axis, from the lengths of the links alone.

A point turns about an axis with its distance from the axis. That distance is at most the distance of the next axis'
origin from the axis, plus the lengths of the links after it, plus the distance of the point from the last of these
origins, whatever the axes between them do. Two bodies move towards each other only by the axes that move one of them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import length, product
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.bodies import bodies_of
from wpcal.planning.cell.cell import CARRIER, TOOL, Cell
from wpcal.planning.cell.one_robot_clearance import OneRobotClearance
from wpcal.planning.cell.shape import JOINTS
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.forward import Frames


class _Axes(NamedTuple):
    """The lines about which a row of axes turns at home: points on them and directions, shape (a, 3), in `world`."""

    origin: FloatArray
    z: FloatArray


def motion_per_axis(cell: Cell, clearance: OneRobotClearance) -> FloatArray:
    """Return bounds of how far the bodies of each pair of carriers move towards each other per unit of each axis.

    Returns ndarray, shape (c, k). mm per rad, and 1 for a rail; rows as in `OneRobotClearance.carriers`.
    """
    frames = cell.frames(cell.home[None])
    reaches = [_reaches(cell, frames, carrier, balls) for carrier, balls in enumerate(_balls(cell, clearance, frames))]
    each = [(reaches[one], reaches[other]) for one, other in clearance.carriers]
    return np.array([np.where((a > 0.0) & (b > 0.0), 0.0, a + b) for a, b in each]).reshape(len(each), len(cell.home))


def _balls(cell: Cell, clearance: OneRobotClearance, frames: tuple[Frames, ...]) -> list[FloatArray]:
    """Return balls at home whose hull contains the bodies of each carrier: rows of centre in `world` and radius, mm."""
    found: list[list[FloatArray]] = [[] for _ in frames]
    for body in bodies_of(cell):
        shape, frame = body.shape, frames[body.carrier]
        for points, radius in ((shape.p, shape.radius_mm), (shape.q, shape.radius_mm), (shape.hull, 0.0)):
            if len(points):
                centres = frame.point(points.T).T
                found[body.carrier].append(np.column_stack([centres, np.broadcast_to(radius, len(points))]))
    if clearance.part is not None:
        corners = frames[cell.part_row].point(clearance.part.corners.reshape(-1, 3).T).T
        found[cell.part_row].append(np.column_stack([corners, np.zeros(len(corners))]))
    return [np.concatenate([np.zeros((0, 4)), *rows]) for rows in found]


def _reaches(cell: Cell, frames: tuple[Frames, ...], carrier: int, balls: FloatArray) -> FloatArray:
    """Return how far the bodies of one carrier move per unit of each axis, shape (k,)."""
    found = np.zeros(len(cell.home))
    if carrier <= TOOL:
        own = _distances(_axes(cell.arm, cell.base_places(cell.home[None])[0], frames), min(carrier, JOINTS), balls)
        found[: len(own)] = own
        if cell.rail_axis is not None:
            found[cell.rail_axis] = 1.0
    elif carrier >= CARRIER and cell.carrier is not None:
        arm, first = cell.carrier.arm, cell.first_turning
        axes = _axes(arm, cell.carrier.T_world_base.matrix, frames[CARRIER:])
        own = _distances(axes, min(carrier - CARRIER, len(arm.joints)), balls)
        found[first : first + len(own)] = own
    return found


def _axes(arm: Arm, T_world_base: FloatArray, frames: tuple[Frames, ...]) -> _Axes:
    """Return the lines of the joints of an arm: z of the frame before each link."""
    first: RigidTransform = arm.chain.T_base_dh0
    start = product(T_world_base, first.matrix)
    after = frames[1 : len(arm.joints)]
    origins = np.array([start[:3, 3], *(frame.p[:, 0] for frame in after)])
    return _Axes(origins, np.array([start[:3, 2], *(frame.z[:, 0] for frame in after)]))


def _distances(axes: _Axes, count: int, balls: FloatArray) -> FloatArray:
    """Return the largest distances of a body from the first `count` axes, which all move it, shape (count,), mm."""
    if not len(balls):
        return np.zeros(count)
    centres, radius = balls[:, :3], balls[:, 3]
    found = np.zeros(count)
    beyond = 0.0  # from the origin of the next axis to the farthest point, whatever the axes between do
    for axis in reversed(range(count)):
        origin, z = axes.origin[axis], axes.z[axis]
        if axis == count - 1:
            found[axis] = (np.linalg.norm(np.cross(centres - origin, z), axis=1) + radius).max()
            beyond = float((np.linalg.norm(centres - origin, axis=1) + radius).max())
        else:
            link = axes.origin[axis + 1] - origin
            found[axis] = length(np.cross(link, z)) + beyond
            beyond += length(link)
    return found
