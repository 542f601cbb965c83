"""Sweep motions against the part: no point of the torch moves farther than its step between two places."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from wpcal.brep.hits import START_MM
from wpcal.brep.material import TriangleMaterial
from wpcal.controllers.program.air_moves import TorchAtTool
from wpcal.controllers.run.recorder import Motion
from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import poses
from wpcal.robot.moves.interpolation import Moves, turns_between
from wpcal.robot.moves.sweep import Way, last_poses
from wpcal.robot.torch.attitude import wire_directions
from wpcal.seam.judge.reach import sweep_torch

LARGEST_MOVE_MM = 20_000.0  #: No robot makes longer moves; they are not followed.
PLACES_AT_ONCE = 20_000  #: In one array, about.
TURN_PLACES = 300  #: The turn of the torch in one motion has fewer.
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
        for some in _at_once(own):
            yield from _meetings(some, part, longer, start_mm)


def _at_once(motions: Sequence[Motion]) -> Iterator[list[tuple[Motion, Way]]]:
    """Yield motions that lead somewhere with their poses, so many together that their places fit in one array."""
    some, count = list[tuple[Motion, Way]](), 0.0
    for motion in motions:
        if motion.goal is None or not np.isfinite(motion.goal).all():
            continue
        some.append((motion, _poses(motion)))
        count += TURN_PLACES + float(np.linalg.norm(np.diff(some[-1][1][0], axis=0), axis=1).sum())
        if count > PLACES_AT_ONCE:
            yield some
            some, count = [], 0.0
    if some:
        yield some


def _meetings(
    some: Sequence[tuple[Motion, Way]], part: TriangleMaterial, torch: TorchAtTool, start_mm: float
) -> Iterator[Meeting]:
    ways = [(p + torch.standoff_mm * wire_directions(R, torch.axis), R) for _, (p, R) in some]
    swept, found = sweep_torch(part, ways, torch.shape, axis=torch.axis, start_mm=start_mm)
    own = np.searchsorted(last_poses(ways), swept.at[found.row])
    for first in np.unique(own, return_index=True)[1]:
        x, y, z = swept.p[found.row[first]]
        what = (
            f"on the move there, at base {x:.1f}, {y:.1f}, {z:.1f} mm, the {found.part[first].value} of {torch.shape}"
        )
        yield Meeting(some[own[first]][0], f"{what} is inside {found.solid[first]!r}")


def _poses(motion: Motion) -> Way:
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
    `step_mm`, `step_rad`, `least`: At most this far apart, and in at least this many steps, shape (m,).
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
