"""Places along a row of poses between which no point of a tool moves far: every swept check takes its steps here.

A move of the tip says little about the torch behind it: 40 degrees in 1 mm of a seam swing a body 300 mm away by
200 mm. So a step is bounded by the farthest point, by translation and rotation together. A turn about the wire moves a
point by its distance from the wire only.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import product
from wpcal.core.tangent import exp_rotation
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


class Swept(NamedTuple):
    """m places along poses or moves, as a controller moves between them: straight, and about one axis."""

    at: FloatArray  #: shape (m,). Number of the pose or move, with the share of the way from it to the next.
    p: FloatArray  #: shape (m, 3). mm.
    R: FloatArray  #: shape (m, 3, 3). Axes of the tool.


def sweep(p: FloatArray, R: FloatArray, tool: Reaching, *, axis: int) -> Swept:
    """Divide the moves between poses so that no point of a tool moves farther than its step between two places.

    `p`, `R`: shapes (n, 3) and (n, 3, 3). Tips of the wire, mm, and axes of the tool, in one frame; n of 1 or more.
    `axis`: Column of `R` along the wire.
    """
    found = sweep_moves(p[:-1], np.diff(p, axis=0), R[:-1], turns_between(R[:-1], R[1:]), tool, axis=axis)
    return Swept(
        np.append(found.at, len(p) - 1.0), np.concatenate([found.p, p[-1:]]), np.concatenate([found.R, R[-1:]])
    )


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
    row = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(row)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[row]
    between = product(exp_rotation(share[:, None] * turn[row]), R[row])
    return Swept(row + share, p[row] + share[:, None] * chord[row], np.asarray(between))
