"""Place labels beside their points, clear of each other, of other points and, where possible, of lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cad.sheet.paper import Box
from wpcal.core.arrays import BoolArray, FloatArray, IntArray, numbered_rows

DIRECTIONS = 24  #: Directions tried around a point.
REACHES = (1.0, 1.5, 2.0, 2.7, 3.5, 4.5, 6.0, 8.0)
"""Lengths of the leader that are tried, relative to the height of a label."""
SAMPLE_MM = 1.0  #: Drawn lines are sampled as points this far apart.
CLASH = 1000.0
"""Cost of a label on another label, on a point or outside its cell, like 1000 mm of leader: only a last resort."""
CROSSING = 60.0  #: Cost of a leader across another leader or label.
ON_LINES = 6.0  #: Cost per mm of drawn line under a label: a longer leader is better than a label on an edge.
LEADER_ON_LINES = 0.4  #: Cost per mm of drawn line near a leader, so that the leader leaves the part by a short way.
CLEARANCE = 0.25  #: Free space around a label, relative to its height.


@dataclass(frozen=True, slots=True, eq=False)
class Label:
    """The place of one label."""

    box: Box
    anchor: FloatArray  #: shape (2,). End of the leader at the box, on paper, mm.


def place_labels(p: FloatArray, sizes: FloatArray, lines: FloatArray, cell: Box, *, avoid: FloatArray) -> list[Label]:
    """Find a place for every label, one after the other, starting with the most crowded point.

    Returns: In the order of the points.

    `p`: shape (m, 2). The points on paper, mm.
    `sizes`: shape (m, 2). Width and height of each label, mm.
    `lines`: shape (n, 2, 2). Drawn segments on paper, mm.
    `avoid`: shape (k, 2, 2). Segments that no label may cover, mm.
    """
    ink = _sampled(lines)
    kept_free = np.concatenate([p, _sampled(avoid)])
    placed: dict[int, Label] = {}
    for row in _crowded_first(p):
        others = [(p[k], label) for k, label in placed.items()]
        placed[int(row)] = _best(p[row], kept_free, sizes[row], ink, cell, others)
    return [placed[row] for row in range(len(p))]


def _crowded_first(p: FloatArray) -> IntArray:
    away = np.linalg.norm(p[:, None] - p, axis=2) + np.diag(np.full(len(p), np.inf))
    return np.asarray(np.argsort(away.min(axis=1, initial=np.inf), kind="stable"))


def _best(
    point: FloatArray,
    kept_free: FloatArray,
    size: FloatArray,
    ink: FloatArray,
    cell: Box,
    others: list[tuple[FloatArray, Label]],
) -> Label:
    middle = np.mean([ink.min(axis=0), ink.max(axis=0)], axis=0) if len(ink) else cell.centre
    low, anchor = _candidates(point, size)
    high = low + size
    wide, margin = CLEARANCE * size[1], CLEARANCE * size[1]
    outside = (low < [cell.x, cell.y]).any(axis=1) | (high > [cell.right, cell.top]).any(axis=1)
    cost = np.linalg.norm(anchor - point, axis=1) + CLASH * outside
    cost += CLASH * _inside(kept_free, low - wide, high + wide).sum(axis=1)
    cost += ON_LINES * SAMPLE_MM * _inside(ink, low - margin / 2, high + margin / 2).sum(axis=1)
    cost += LEADER_ON_LINES * SAMPLE_MM * _beside(ink, point, anchor, margin).sum(axis=1)
    outward = (low + size / 2 - middle) @ _unit(point - middle)
    cost -= 0.1 * outward  # of two equal places, the one farther out wins
    for start, other in others:
        box_low = np.array([other.box.x, other.box.y])
        box_high = np.array([other.box.right, other.box.top])
        cost += CLASH * ((low - margin < box_high) & (high + margin > box_low)).all(axis=1)
        cost += CROSSING * _cross(point, anchor, start, other.anchor)
        along = point + np.linspace(0.0, 1.0, 12)[:, None, None] * (anchor - point)
        cost += CROSSING * ((along > box_low) & (along < box_high)).all(axis=2).any(axis=0)
        old = start + np.linspace(0.0, 1.0, 12)[:, None] * (other.anchor - start)
        cost += CROSSING * _inside(old, low, high).any(axis=1)
    best = int(np.argmin(cost))
    return Label(Box(*low[best].tolist(), *size.tolist()), anchor[best])


def _candidates(point: FloatArray, size: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the lower left corners of the boxes to try and where their leaders end, shape (k, 2) each."""
    angle = np.linspace(0.0, 2.0 * np.pi, DIRECTIONS, endpoint=False)
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    reach = np.array(REACHES) * size[1]
    end = (point + direction[None] * reach[:, None, None]).reshape(-1, 2)
    away = np.tile(direction, (len(REACHES), 1))
    low = end - size * np.where(away[:, :1] >= 0, [0.0, 0.5], [1.0, 0.5])
    steep = np.abs(away[:, 0]) < np.sin(np.radians(20.0))  # a label above or below its point is centred
    low[steep] = end[steep] - size * np.where(away[steep, 1:] > 0, [0.5, 0.0], [0.5, 1.0])
    return low, end


def _sampled(lines: FloatArray) -> FloatArray:
    """Return points along segments, at most `SAMPLE_MM` apart, shape (k, 2)."""
    length = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    count = np.maximum(np.ceil(length / SAMPLE_MM).astype(np.int64), 1)
    row, place = numbered_rows(count)
    t = ((place + 0.5) / count[row])[:, None]
    return np.asarray(lines[row, 0] + t * (lines[row, 1] - lines[row, 0]), dtype=np.float64)


def _inside(points: FloatArray, low: FloatArray, high: FloatArray) -> BoolArray:
    """Tell which points are in which boxes, shape (boxes, points)."""
    return np.asarray(((points > low[:, None]) & (points < high[:, None])).all(axis=2))


def _beside(points: FloatArray, start: FloatArray, end: FloatArray, near: float) -> BoolArray:
    """Tell which points are near which leaders, except at the start of the leader; shape (leaders, points)."""
    leader = end - start
    length = np.linalg.norm(leader, axis=1)
    along = (points - start) @ leader.T / length
    across = np.abs((points - start) @ np.stack([-leader[:, 1], leader[:, 0]])) / length
    return np.asarray(((along > near) & (along < length) & (across < near)).T)


def _cross(start: FloatArray, ends: FloatArray, a: FloatArray, b: FloatArray) -> BoolArray:
    """Tell which segments from `start` cross the segment a to b, shape (ends,)."""

    def turn(p: FloatArray, q: FloatArray, r: FloatArray) -> FloatArray:
        u, v = q - p, r - p
        return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])

    apart = turn(start, ends, a) * turn(start, ends, b) < 0
    return np.asarray(apart & (turn(a, b, start) * turn(a, b, ends) < 0))


def _unit(v: FloatArray) -> FloatArray:
    length = float(np.linalg.norm(v))
    return v / length if length > 0 else np.array([0.0, 1.0])
