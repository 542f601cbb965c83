"""Places along a row of poses between which no point of a tool moves far: every swept check takes its steps here.

A move of the tip says little about the torch behind it: 40 degrees in 1 mm of a seam swing a body 300 mm away by
200 mm. So a step is bounded by the farthest point, by translation and rotation together. A turn about the wire moves a
point by its distance from the wire only.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray, numbered_rows
from wpcal.core.same_bits import product
from wpcal.core.tangent import exp_rotation, log_rotation
from wpcal.robot.moves.interpolation import turns_between

STEP_MM = 1.0
"""No point of the wire moves farther between two places: less than the thinnest sheet that is welded as a rib."""
BODY_STEP_MM = 8.0
"""The same of the torch behind it. Between two places a tube of radius r misses a solid by d²/8r at most: 0.7 mm."""


class Reaching(NamedTuple):
    """How far the points of a tool are from its tip."""

    wire_mm: float  #: Where the wire ends and the torch begins.
    far_mm: float  #: The farthest point from the tip.
    aside_mm: float  #: The farthest point from the line of the wire.


Way: TypeAlias = tuple[FloatArray, FloatArray]
"""Poses between which a tool moves: tips of the wire, (n, 3), mm, and axes of the tool, (n, 3, 3); n of 1 or more."""


class Swept(NamedTuple):
    """m places along poses or moves, as a controller moves between them: straight, and about one axis."""

    at: FloatArray  #: shape (m,). Number of the pose or move, with the share of the way from it to the next.
    p: FloatArray  #: shape (m, 3). mm.
    R: FloatArray  #: shape (m, 3, 3). Axes of the tool.


def sweep(ways: Sequence[Way], tool: Reaching, *, axis: int) -> Swept:
    """Divide the moves of ways so that no point of a tool moves farther than its step between two places.

    `ways`: In one frame. Their poses are numbered through, and there is no move from one way to the next.
    `axis`: Column of `R` along the wire.
    """
    p, R = (np.concatenate(each) for each in zip(*ways, strict=True))
    last = last_poses(ways)
    first = np.setdiff1d(np.arange(len(p)), last)
    chord, turn = p[first + 1] - p[first], turns_between(R[first], R[first + 1])
    found = sweep_moves(p[first], chord, R[first], turn, tool, axis=axis)
    at = np.append(found.at + (first - np.arange(len(first)))[found.at.astype(np.int64)], last)
    order = np.argsort(at, kind="stable")
    places = np.concatenate([found.p, p[last]])[order], np.concatenate([found.R, R[last]])[order]
    return Swept(at[order], *places)


def last_poses(ways: Sequence[Way]) -> IntArray:
    """Return the number of the last pose of each way, shape (k,)."""
    return np.cumsum([len(p) for p, _ in ways]) - 1


def sweep_moves(
    p: FloatArray, chord: FloatArray, R: FloatArray, turn: FloatArray, tool: Reaching, *, axis: int
) -> Swept:
    """Return the places of `sweep` on m moves of their own, each with its start and without its end.

    `p`, `chord`, `turn`: shape (m, 3). Starts of the tip, ways from there, mm, and rotation vectors, rad.
    `R`: shape (m, 3, 3). Axes of the tool at the starts.
    """
    about = np.abs(np.einsum("ni,ni->n", turn, R[:, :, axis]))
    across = np.sqrt(np.maximum((turn**2).sum(axis=1) - about**2, 0.0))
    way = np.linalg.norm(chord, axis=1)
    wire, body = way + across * tool.wire_mm, way + across * tool.far_mm + about * tool.aside_mm
    parts = np.maximum(np.ceil(np.maximum(wire / STEP_MM, body / BODY_STEP_MM)), 1.0).astype(np.int64)
    row, number = numbered_rows(parts)
    share = number / parts[row]
    between = product(exp_rotation(share[:, None] * turn[row]), R[row])
    return Swept(row + share, p[row] + share[:, None] * chord[row], np.asarray(between))


def poses_between(
    tips: FloatArray, R: FloatArray, step_mm: float, step_rad: float, standoff_mm: float = 0.0
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return poses on ways between m poses, at most one step of the tool centre point apart: it goes straight.

    `tips`, `R`: shapes (m, 3) and (m, 3, 3). The tool turns evenly between two poses.

    Returns places of the tip of the wire, shape (n, 3), `standoff_mm` ahead of the tool centre point, axes of the tool,
    shape (n, 3, 3), and the rows of the given poses, shape (m,).
    """
    p = tips - standoff_mm * R[:, :, 2]
    way, turn = np.diff(p, axis=0), log_rotation(np.swapaxes(R[:-1], -1, -2) @ R[1:])
    steps = np.maximum(np.linalg.norm(way, axis=1) / step_mm, np.linalg.norm(turn, axis=1) / step_rad)
    parts = np.maximum(np.ceil(steps), 1.0).astype(np.int64)
    first, rows = np.repeat(np.arange(len(parts)), parts), np.concatenate([[0], np.cumsum(parts)])
    share = ((np.arange(len(first)) - rows[first]) / parts[first])[:, None]
    axes = np.concatenate([R[first] @ exp_rotation(share * turn[first]), R[-1:]])
    return np.concatenate([p[first] + share * way[first], p[-1:]]) + standoff_mm * axes[:, :, 2], axes, rows
