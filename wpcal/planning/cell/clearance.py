"""Distances between the bodies of a cell, measured by the capsules around them: fast enough for use inside a search.

The distances are as accurate as the capsules in the cell file. `wpcal.planning.cell.hulls` measures the convex hulls
instead; only a path that it has checked is called free.

References: Hou, Wang, Yue, Jia 2018, eq. (6): a state is clear when the least distance is larger than d1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray, blocks
from wpcal.core.errors import GeometryError
from wpcal.core.same_bits import length
from wpcal.planning.cell.bodies import BodyPairs, body_pairs
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.segments import Segments, segment_distances
from wpcal.planning.cell.shape import JOINTS
from wpcal.robot.kinematics.forward import Frames

STATES = 1024  #: States per batch: the axes of all capsules of a cell (some MB) then stay in the cache.
BLOCK = 16_384  #: Distances per batch: each temporary array (128 kB) stays in the cache of a core.

LeastMargins = Callable[[tuple[Frames, ...]], tuple[FloatArray, IntArray]]
"""From the frames of some states to the least margin of each, mm, and the row of its pair."""


@dataclass(frozen=True, slots=True, eq=False)
class Clearance:
    """Clearances of n states."""

    #: shape (n,). Least distance minus safety distance over all pairs, mm; infinite in a cell without pairs.
    margin_mm: FloatArray
    #: shape (n,). Distance of the pair with the least margin, mm; negative where capsules overlap.
    distance_mm: FloatArray
    pair: IntArray  #: shape (n,). The pair with the least margin, a row of `pairs`; -1 in a cell without pairs.
    pairs: BodyPairs

    @classmethod
    def of_states(cls, cell: Cell, q: FloatArray, pairs: BodyPairs, measure: LeastMargins) -> Clearance:
        """Measure states, `q` of shape (n, 12), in batches."""
        margin, row = np.full(len(q), np.inf), np.full(len(q), -1, dtype=np.int64)
        for start in range(0, len(q) if len(pairs) else 0, STATES):
            some = slice(start, start + STATES)
            margin[some], row[some] = measure(cell.frames(q[some]))
        return cls(margin, margin + np.append(pairs.safety_mm, 0.0)[row], row, pairs)

    @property
    def is_clear(self) -> BoolArray:
        """Whether every pair is farther apart than its safety distance (Hou 2018, eq. 6), shape (n,)."""
        return np.asarray(self.margin_mm > 0.0)

    def nearest(self, row: int) -> tuple[str, str]:
        """Return the names of the bodies with the least margin at a state.

        Raises `IndexError` in a cell without pairs.
        """
        return self.pairs.names(int(self.pair[row]))


def capsule_clearance(cell: Cell, q: FloatArray) -> Clearance:
    """Measure n states by capsules; `q`: shape (n, 12). All axes, rad.

    About 35 ns per pair of capsules: 6 µs per state of a cell with 160 pairs, and a third of that for the kinematics.
    One call with many states is far cheaper than many calls with one state.
    """
    pairs = body_pairs(cell)
    return Clearance.of_states(cell, q, pairs, partial(_least_margins, pairs))


def require_bases_apart(cell: Cell) -> None:
    """Refuse a cell whose fixed bodies (pedestals and bench) are nearer to each other than the safety distance.

    Raises `GeometryError` with the two bodies and the missing distance.
    """
    links = tuple(shape for shape in cell.links if shape.link == 0)
    carrier = cell.carrier and replace(cell.carrier, links=tuple(s for s in cell.carrier.links if s.link == 0))
    fixed = replace(cell, links=links, carrier=carrier, torch=(), part=())
    clear = capsule_clearance(fixed, np.zeros((1, 2 * JOINTS)))
    if not clear.is_clear[0]:
        one, two = clear.nearest(0)
        apart = length(cell.T_base1_base2.t_mm)
        raise GeometryError(
            f"the robots stand too close (bases {apart:.0f} mm apart): {one} and {two} miss their safety distance by "
            f"{-clear.margin_mm[0]:.0f} mm, whatever the joints"
        )


def _least_margins(pairs: BodyPairs, frames: tuple[Frames, ...]) -> tuple[FloatArray, IntArray]:
    """Return the least margin of every state and its pair of bodies."""
    margins = pair_margins(pairs, frames)
    row = np.argmin(margins, axis=0)
    return margins[row, np.arange(len(row))], row


def pair_margins(pairs: BodyPairs, frames: tuple[Frames, ...]) -> FloatArray:
    """Return distance minus safety distance of every pair of bodies at every state, shape (m, n), mm."""
    table = _CapsuleTable.of_pairs(pairs)
    axes = table.axes(frames)
    margins = np.empty((len(table.pair), axes.p.shape[2]))
    step = max(1, BLOCK // margins.shape[1])
    for some in blocks(len(margins), step):
        ends = (Segments(axes.p[:, rows], axes.u[:, rows]) for rows in (table.first[some], table.second[some]))
        distance = segment_distances(*ends)
        margins[some] = distance - table.needed_mm[some, None]
    starts = np.flatnonzero(np.diff(table.pair, prepend=-1))
    return np.asarray(np.minimum.reduceat(margins, starts, axis=0), dtype=np.float64)


def stacked(frames: tuple[Frames, ...]) -> FloatArray:
    """Return axes and origins of c frames at n states as one array, shape (4, 3, c, n)."""
    together = np.empty((4, 3, len(frames), max(frame.p.shape[1] for frame in frames)))
    for row, frame in enumerate(frames):
        for own, axis in zip(together, frame, strict=True):
            own[:, row] = axis
    return together


@dataclass(frozen=True, slots=True, eq=False)
class _CapsuleTable:
    """Pairs of capsules: rows of both, the body pair of each, and radii plus safety distance; the axes of all."""

    first: IntArray
    second: IntArray
    pair: IntArray
    needed_mm: FloatArray
    carrier: IntArray
    ends: FloatArray  #: shape (2, 3, k, 1). Starts and spans of the axes in the frames of their carriers, mm.

    @classmethod
    @lru_cache(maxsize=16)
    def of_pairs(cls, pairs: BodyPairs) -> _CapsuleTable:
        counts = [len(body.shape.radius_mm) for body in pairs.bodies]
        starts = np.concatenate([[0], np.cumsum(counts)])
        rows = [
            (a, b, row)
            for row, (i, j) in enumerate(zip(pairs.first, pairs.second, strict=True))
            for a in range(starts[i], starts[i + 1])
            for b in range(starts[j], starts[j + 1])
        ]
        first, second, pair = np.array(rows, dtype=np.int64).reshape(-1, 3).T
        radius = np.concatenate([np.zeros(0), *(body.shape.radius_mm for body in pairs.bodies)])
        carrier = np.repeat(np.array([body.carrier for body in pairs.bodies], dtype=np.int64), counts)
        shapes = [body.shape for body in pairs.bodies]
        p, q = (
            np.concatenate([np.zeros((0, 3)), *(getattr(shape, end) for shape in shapes)]).T[:, :, None]
            for end in ("p", "q")
        )
        needed = radius[first] + radius[second] + pairs.safety_mm[pair]
        return cls(first, second, pair, needed, carrier, np.stack([p, q - p]))

    def axes(self, frames: tuple[Frames, ...]) -> Segments:
        """Return the axes of all capsules of all bodies, in order, in `world`: arrays of shape (3, k, n)."""
        x, y, z, origin = stacked(frames)[:, :, self.carrier]
        u = self.ends[1]
        start = Frames(x, y, z, origin).point(self.ends[0])
        return Segments(start, np.asarray(u[0] * x + u[1] * y + u[2] * z, dtype=np.float64))
