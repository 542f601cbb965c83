"""Lines and arcs, and a path that is made of them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, IntArray, frozen
from wpcal.core.same_bits import arc_tangent, product
from wpcal.core.tangent import exp_rotation
from wpcal.robot.moves.interpolation import Moves, turns_between


@dataclass(frozen=True, slots=True)
class Line:
    """A straight move."""

    to: int  #: Row of the pose at its end.


@dataclass(frozen=True, slots=True)
class Arc:
    """A move on a circle."""

    via: int  #: Row of the pose in its middle.
    to: int  #: Row of the pose at its end.


Move = Line | Arc


@dataclass(frozen=True, slots=True, eq=False)
class MovePath:
    """The poses that a program states, and the moves between them."""

    p: FloatArray  #: shape (k, 3). Tool centre points in any one frame, mm. The first is the start.
    R: FloatArray  #: shape (k, 3, 3). Axes of the tool in the same frame.
    moves: tuple[Move, ...]  #: From the first pose on, in order. Each begins where the one before ends.
    s_mm: FloatArray  #: shape (k,). Where the poses are on the path that was asked for: the length along it, mm.
    #: `off_mm`, `off_rad`: Largest distance of the wire's tip, and largest angle of the wire, from the path that was
    #: asked for.
    off_mm: float = 0.0
    off_rad: float = 0.0
    most_mm: float = 0.05  #: Largest distance that is allowed: a zone may leave a corner by this much.
    _arrays: list[Moves] = field(default_factory=list, repr=False)

    def __len__(self) -> int:
        return len(self.p)

    @property
    def ends(self) -> IntArray:
        """Rows of the poses between the moves, the first and the last included; shape (number of moves + 1,)."""
        return np.array([0, *(move.to for move in self.moves)], dtype=np.int64)

    @property
    def vias(self) -> FloatArray:
        """Points in the middle of arcs, shape (number of moves, 3); NaN for lines."""
        return np.array([self.p[move.via] if isinstance(move, Arc) else np.full(3, np.nan) for move in self.moves])

    @property
    def arrays(self) -> Moves:
        """The moves as arrays."""
        if not self._arrays:
            first, last = self.ends[:-1], self.ends[1:]
            turn = turns_between(self.R[first], self.R[last])
            self._arrays.append(Moves.between(self.p[first], self.R[first], self.p[last], turn, self.vias))
        return self._arrays[0]

    def poses_at(self, s_mm: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return where a controller has the tool.

        `s_mm`: shape (m,). Lengths along the path that was asked for, mm; within its two ends.
        Returns `p, R`: ndarray, shapes (m, 3) and (m, 3, 3). In the frame of the poses.
        """
        s = np.asarray(s_mm, dtype=np.float64)
        at = self.s_mm[self.ends]
        row = np.clip(np.searchsorted(at, s, side="right") - 1, 0, len(self.moves) - 1)
        length = at[row + 1] - at[row]
        share = np.clip((s - at[row]) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
        moves = self.arrays.select(row)
        return moves.positions(share), moves.rotations(share)

    def turned_about(self, axis: int, spin_rad: float) -> MovePath:
        """Return the same path with the tool turned about one of its axes everywhere by the same angle, rad."""
        turn = exp_rotation(spin_rad * np.eye(3)[axis])
        return replace(self, R=frozen(product(self.R, turn)), _arrays=[])

    @property
    def corner_rad(self) -> FloatArray:
        """How far the direction of travel turns at the end of each move but the last, shape (number of moves - 1,)."""
        moves = self.arrays
        before, after = moves.headings(np.ones(len(moves)))[:-1], moves.headings(np.zeros(len(moves)))[1:]
        sine = np.linalg.norm(np.cross(before, after), axis=1)
        return np.asarray(arc_tangent(sine, np.einsum("ij,ij->i", before, after)), dtype=np.float64)

    def stops(self, blend_mm: float) -> tuple[bool, ...]:
        r"""Tell where the tool has to stop, because it would otherwise leave the path at a corner.

        A blend begins and ends at a distance r from the corner. Its middle is about :math:`r \sin(\delta/2) / 2` from
        it, where the path turns by δ.

        `blend_mm`: r: as the program states it, mm.
        """
        cut = blend_mm * np.sin(self.corner_rad / 2.0) / 2.0
        return (*(cut > self.most_mm).tolist(), True)
