"""Sweep motions against the part: no point of the torch moves farther than its step between two places."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.rays import START_MM
from wpcal.controllers.program.air_moves import TorchAtTool
from wpcal.controllers.run.trace import Motion
from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import poses
from wpcal.robot.moves import sweep
from wpcal.robot.moves.interpolation import Moves, turns_between
from wpcal.robot.torch.attitude import ToolAxis, neck_directions, wire_directions
from wpcal.seam.judge.material import find_poses_in_material

LARGEST_MOVE_MM = 20_000.0  #: No robot makes longer moves; they are not followed.
PLACES_AT_ONCE = 20_000  #: In one array.
ARC_STEP_MM = 1.0
SAME_STEP = 0.01  #: Of a step: a way of whole steps has as many of them in a text with other digits.


class Meeting(NamedTuple):
    """Where a motion meets the part first."""

    motion: Motion
    what: str


def is_followed(motion: Motion) -> bool:
    """Tell whether it is known where a motion leads along: not by the joints, and not from an unknown place."""
    if motion.kind == "J" or motion.start is None or motion.goal is None:
        return False
    way = np.linalg.norm(motion.goal[:3, 3] - motion.start[:3, 3])
    return bool(np.isfinite(motion.goal).all() and way <= LARGEST_MOVE_MM)


def meetings(
    motions: Sequence[Motion],
    part: TriangleMaterial,
    torch: TorchAtTool,
    more_wire_mm: Sequence[float],
    *,
    start_mm: float = START_MM,
) -> Iterator[Meeting]:
    """Yield where motions meet the part; of each motion the first place, of one that is not followed its end.

    `more_wire_mm`: How much longer than usual the wire of each motion is.
    """
    for mm in dict.fromkeys(more_wire_mm):
        own = [motion for motion, each in zip(motions, more_wire_mm, strict=True) if each == mm]
        longer = TorchAtTool(torch.shape.with_more_wire(mm), torch.axis, torch.standoff_mm + mm)
        yield from _meetings(own, part, longer, start_mm)


def _meetings(
    motions: Sequence[Motion], part: TriangleMaterial, torch: TorchAtTool, start_mm: float
) -> Iterator[Meeting]:
    shape, axis = torch.shape, torch.axis
    column, pending, count = 2 if axis is ToolAxis.Z else 0, list[tuple[Motion, FloatArray, FloatArray]](), 0

    def judged() -> Iterator[Meeting]:
        p, R = (np.concatenate([each[row] for each in pending]) for row in (1, 2))
        own = np.repeat(np.arange(len(pending)), [len(each[1]) for each in pending])
        bend = None if shape.neck is None else neck_directions(R, axis)
        found = find_poses_in_material(part, p, -R[:, :, column], shape, start_mm=start_mm, bend=bend)
        told = set[int]()
        for row, solid, piece in zip(found.row.tolist(), found.solid, found.part, strict=True):
            if own[row] not in told:
                told.add(own[row])
                x, y, z = p[row]
                what = f"on the move there, at base {x:.1f}, {y:.1f}, {z:.1f} mm, the {piece.value} of {shape}"
                yield Meeting(pending[own[row]][0], f"{what} is inside {solid!r}")

    for motion in motions:
        if motion.goal is None or not np.isfinite(motion.goal).all():
            continue
        p, R = _poses(motion)
        tips = p + torch.standoff_mm * wire_directions(R, axis)
        swept = sweep(tips, R, shape.reaching, axis=column)
        pending.append((motion, swept.p, swept.R))
        count += len(swept.p)
        if count > PLACES_AT_ONCE:
            yield from judged()
            pending, count = [], 0
    if pending:
        yield from judged()


def _poses(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Return start and goal of a line, and places along an arc; shapes (n, 3) and (n, 3, 3)."""
    if not is_followed(motion):
        ends = np.array([motion.goal])
    elif motion.via is None:
        ends = np.array([motion.start, motion.goal])
    else:
        starts, goals, vias = np.array([motion.start]), np.array([motion.goal]), motion.via[None, :3, 3]
        (ends,) = poses_along(starts, goals, vias, ARC_STEP_MM, np.inf, np.ones(1))
    return ends[:, :3, 3], ends[:, :3, :3]


def poses_along(
    starts: FloatArray, goals: FloatArray, vias: FloatArray, step_mm: float, step_rad: float, least: FloatArray
) -> list[FloatArray]:
    """Return poses along lines and arcs with both ends, shapes (n, 4, 4).

    `starts`, `goals`, `vias`: shapes (m, 4, 4) twice and (m, 3); NaN for a line.
    `step_mm`, `step_rad`, `least`: At most so far apart, and in at least so many steps, shape (m,).
    """
    R = starts[:, :3, :3]
    turn = turns_between(R, goals[:, :3, :3])
    moves = Moves.between(starts[:, :3, 3], R, goals[:, :3, 3], turn, vias)
    arc = moves.sweep * np.linalg.norm(moves.u, axis=1)
    length = np.where(arc > 0.0, arc, np.linalg.norm(moves.chord, axis=1))
    parts = np.max([length / step_mm, np.linalg.norm(turn, axis=1) / step_rad, least], axis=0) - SAME_STEP
    parts = np.maximum(np.ceil(parts), 1.0)
    count = parts.astype(np.int64) + 1
    ends = np.cumsum(count)
    own = np.repeat(np.arange(len(count)), count)
    share = (np.arange(len(own)) - np.repeat(ends - count, count)) / parts[own]
    at = moves.select(own)
    return np.split(poses(at.rotations(share), at.positions(share)), ends[:-1]) if len(own) else []
