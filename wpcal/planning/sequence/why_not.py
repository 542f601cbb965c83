"""Why a stretch of a seam cannot be welded, and what would help: the part turned, or the robot moved."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.one_robot import OneRobotCell
from wpcal.planning.cell.workplace import reach_shortage
from wpcal.planning.sequence.external import external_axes
from wpcal.planning.sequence.seam_search import SeamSearch
from wpcal.planning.sequence.seam_task import SeamTask
from wpcal.planning.sequence.torch_poses import TorchPoses, torch_poses

TRIED_AXES = 16
"""Positions of the external axes that a reason is looked for at: the most promising ones."""
TURNS_DEG = (15.0, -15.0, 30.0, -30.0, 45.0, -45.0, 60.0, -60.0, 90.0, -90.0, 135.0, -135.0, 180.0)
MOVES_MM = (100.0, 200.0, 300.0, 400.0, 600.0)
"""Changes that are tried, the smallest first."""
SIDES = 8
"""Directions in which the robot is moved."""
TESTED = 64
"""Joints whose clearance is measured for a reason."""


@dataclass(frozen=True, slots=True)
class Help:
    """A change with which a stretch comes within reach of the arm; collisions are not looked at.

    Parameters
    ----------
    text : str
    turn_deg : float
        Of the part about the vertical; 0 if the robot is moved.
    move_mm : tuple of float
        Of the robot in `world`, x and y; zeros if the part is turned.
    """

    text: str
    turn_deg: float = 0.0
    move_mm: tuple[float, float] = (0.0, 0.0)


def find_reason(search: SeamSearch, stretch: SeamTask) -> str:
    """Return why no way welds a stretch: the torch, the reach, a joint limit, or a body in the way."""
    poses = torch_poses(stretch, search.targets, search.clearance, tilted=True)
    if not poses.is_free.any(axis=1).all():
        return "the torch meets the part at every angle within its range"
    values = external_axes(search.cell, stretch, search.targets).values[:TRIED_AXES]
    joints, usable = search.states(poses, values)
    rung = int(np.argmin(usable.any(axis=(2, 3)).any(axis=0)))
    if usable.any(axis=(2, 3)).any(axis=0).all():
        return _body_in_the_way(search, values, joints, usable)
    free = poses.is_free[rung]
    q = joints[:, rung][:, free]  # (C, K', 8, 6)
    reached = np.isfinite(q).all(axis=-1)
    if not reached.any():
        T = search.flange_places(poses.T_part_tool[rung][free], values).reshape(-1, 4, 4)
        short = float(reach_shortage(search.cell.arm, T).min())
        return f"out of reach of {search.cell.arm.name}, by {short:.0f} mm at least"
    return _limit(search.cell, q[reached])


def _limit(cell: OneRobotCell, q: FloatArray) -> str:
    """Name the joint that is nearest to letting joints (r, 6) within its limits."""
    low, high = cell.arm.limits
    turned = q - 2 * np.pi * np.rint((q - (low + high) / 2) / (2 * np.pi))
    beyond = np.maximum(np.maximum(low - turned, turned - high), 0.0)
    row = int(np.argmin(beyond.max(axis=1)))
    joint = int(np.argmax(beyond[row]))
    if beyond[row, joint] == 0.0:
        return "only singular poses reach it (the wrist, the elbow or the arm is stretched)"
    least, most = np.degrees(cell.arm.limits[:, joint])
    at, name = np.degrees(turned[row, joint]), cell.arm.joints[joint].name
    return f"joint {name} would be at {at:.0f} deg, its limits are {least:g} and {most:g} deg"


def _body_in_the_way(search: SeamSearch, values: FloatArray, joints: FloatArray, usable: BoolArray) -> str:
    """Name the two bodies that are too near at the best state of the worst rung."""
    worst: tuple[float, str] | None = None
    for rung in range(joints.shape[1]):
        c, k, b = np.nonzero(usable[:, rung])
        rows = np.linspace(0, len(c) - 1, min(TESTED, len(c))).astype(int)
        q = np.concatenate([joints[c[rows], rung, k[rows], b[rows]], values[c[rows]]], axis=1)
        found = search.clearance.margins(q)
        best = int(np.argmax(found.margin_mm))
        margin = float(found.margin_mm[best])
        if worst is None or margin < worst[0]:
            one, two = search.clearance.names(int(found.pair[best]))
            worst = (margin, f"{one} and {two} miss their safety distance by {-margin:.0f} mm")
    if worst is None or worst[0] > 0.0:
        return "no branch of the arm gets along it without a change of configuration"
    return f"a body is in the way: {worst[1]} at best"


def find_help(search: SeamSearch, stretch: SeamTask) -> tuple[Help, ...]:
    """Return the smallest turn of the part, and the smallest move of the robot, that bring a stretch into reach."""
    cell = search.cell
    poses = torch_poses(stretch, search.targets, search.clearance, tilted=True)
    if not poses.is_free.any(axis=1).all():
        return ()
    part = search.clearance.part
    middle = stretch.middle if part is None else (part.corners.min(axis=(0, 1)) + part.corners.max(axis=(0, 1))) / 2
    centre = _in_world(cell, middle)
    turns = [(turn, _turned(cell, turn, centre)) for turn in TURNS_DEG]
    around = 2 * np.pi * np.arange(SIDES) / SIDES
    ways = [(step * np.cos(a), step * np.sin(a)) for step in MOVES_MM for a in around]
    found = []
    turn = next((turn for turn, moved in turns if _reaches(moved, search, stretch, poses)), None)
    if turn is not None:
        found.append(Help(f"the part turned by {turn:g} deg about the vertical", turn_deg=turn))
    for x, y in ways:
        place = cell.T_world_base
        moved = replace(cell, T_world_base=replace(place, t_mm=place.t_mm + np.array([x, y, 0.0])))
        if _reaches(moved, search, stretch, poses):
            move = (float(np.round(x)) + 0.0, float(np.round(y)) + 0.0)
            found.append(Help(f"the robot moved by {move[0]:.0f}, {move[1]:.0f} mm in x, y of world", move_mm=move))
            break
    return tuple(found)


def _in_world(cell: OneRobotCell, p_part: FloatArray) -> FloatArray:
    T = cell.part_places(cell.home[None])[0]
    return np.asarray(T[:3, :3] @ p_part + T[:3, 3], dtype=np.float64)


def _turned(cell: OneRobotCell, turn_deg: float, centre: FloatArray) -> OneRobotCell:
    """Return the cell with the part turned about the vertical through a point of `world`, in its carrier."""
    R = rotation_from_zyx(0.0, 0.0, np.radians(turn_deg))
    T_turn = RigidTransform(R, centre - R @ centre, "world", "world")
    T_world_carrier = RigidTransform.from_matrix(
        cell.carrier_places(cell.home[None])[0], target="world", source="carrier"
    )
    part = cell.T_part.relabelled(target="carrier", source="part")
    return replace(cell, T_carrier_part=T_world_carrier.inverse() @ T_turn @ T_world_carrier @ part)


def _reaches(cell: OneRobotCell, search: SeamSearch, stretch: SeamTask, poses: TorchPoses) -> bool:
    """Tell whether one branch reaches every rung, within limits and without singular poses."""
    other = SeamSearch(cell, search.clearance, search.targets)
    values = external_axes(cell, stretch, search.targets).values[:1]
    few = _fewer(poses)
    _, usable = other.states(few, values)
    return bool(np.asarray(usable.any(axis=2)).all(axis=1).any())


def _fewer(poses: TorchPoses) -> TorchPoses:
    """Keep the poses at the target torch angles where there are free ones at every rung."""
    on_target = poses.off_rad[0] == poses.off_rad.min()
    if not poses.is_free[:, on_target].any(axis=1).all():
        return poses
    return TorchPoses(
        poses.rungs,
        poses.angles[:, on_target],
        poses.T_part_tool[:, on_target],
        poses.off_rad[:, on_target],
        poses.is_free[:, on_target],
    )
