r"""What a controller does on a line and on a circular arc.

The tool centre point goes on the straight line, or on the circle through three points. The tool turns at a constant
rate about one axis that is fixed in the frame of the targets, from the orientation at the start to that at the end
(slerp), in proportion to the length of the path. This holds on lines in every language that wpcal writes, and on arcs
in the mode that its programs state; the writers of `wpcal.controllers` say which and cite the manuals. Some controllers
do not use the orientation of the point in the middle of an arc, others lead the tool through it. wpcal therefore writes
there exactly the orientation that the tool has in the middle of the turn: both ways are then the same motion.

A turn of nearly 180 degrees can go one way or the other; `LARGEST_TURN_RAD` keeps away from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.rotations import quaternion_from_rotation
from wpcal.core.same_bits import arc_tangent, product, sine_cosine
from wpcal.core.tangent import exp_rotation

LARGEST_TURN_RAD = np.radians(170.0)  #: Of the tool within one move.
LEAST_SWEEP_RAD = np.radians(4.0)
"""The least of an arc. Seen from its start, its middle is then a degree beside its end: controllers refuse less."""
LARGEST_SWEEP_RAD = np.radians(200.0)
"""The most of an arc: half a circle, and more where its points do not divide it in two. 240 degrees are refused."""
LEAST_CHORD_MM = 0.1  #: Between the start, the middle and the end of an arc: controllers refuse less.
NO_TURN_RAD = 1e-12  #: Smaller turns have no axis.


@dataclass(frozen=True, slots=True, eq=False)
class Moves:
    """m moves as arrays: lines, and arcs through a point."""

    #: `p0`, `chord`: shape (m, 3). Start, and the way from it to the end, mm.
    p0: FloatArray
    chord: FloatArray
    R0: FloatArray  #: shape (m, 3, 3). Axes of the tool at the start.
    turn: FloatArray  #: shape (m, 3). Rotation vector from the start to the end, in the frame of the targets, rad.
    #: `centre`, `u`, `v`: shape (m, 3). Of the arcs: centre, start from the centre, and the same a quarter turn on.
    #: Zero for lines.
    centre: FloatArray
    u: FloatArray
    v: FloatArray
    sweep: FloatArray  #: shape (m,). Of the arcs, rad; zero for lines.
    #: shape (m,). False for moves that controllers refuse, or that may turn the tool the other way.
    is_sound: BoolArray

    def __len__(self) -> int:
        return len(self.p0)

    @classmethod
    def between(cls, p0: FloatArray, R0: FloatArray, p1: FloatArray, turn: FloatArray, via: FloatArray) -> Moves:
        """Return moves from points to points.

        `p0`, `p1`: shape (m, 3). Starts and ends, mm.
        `R0`: shape (m, 3, 3). Axes of the tool at the starts.
        `turn`: shape (m, 3). Rotation vectors from there to the ends, rad.
        `via`: shape (m, 3). A point of each arc between its ends; NaN for a line.
        """
        chord = p1 - p0
        is_arc, is_held = np.isfinite(via[:, 0]), np.linalg.norm(turn, axis=1) < LARGEST_TURN_RAD
        if not is_arc.any():
            zero = np.zeros_like(chord)
            return cls(p0, chord, R0, turn, zero, zero, zero, np.zeros(len(p0)), is_held)
        b = np.where(is_arc[:, None], via - p0, 0.0)
        normal = _cross(b, chord)
        square = np.einsum("ij,ij->i", normal, normal)
        lengths = [np.einsum("ij,ij->i", x, x) for x in (b, chord, chord - b)]
        is_round = is_arc & (square > 1e-18 * lengths[0] * lengths[1]) & (np.min(lengths, axis=0) > LEAST_CHORD_MM**2)
        from_start = _cross(lengths[1][:, None] * b - lengths[0][:, None] * chord, -normal)
        from_start /= np.where(is_round, 2.0 * square, 1.0)[:, None]
        centre = np.where(is_round[:, None], p0 + from_start, 0.0)
        u = np.where(is_round[:, None], -from_start, 0.0)
        v = _cross(normal / np.sqrt(np.where(is_round, square, 1.0))[:, None], u)
        end = np.where(is_round[:, None], p1 - centre, 0.0)
        sweep = arc_tangent(np.einsum("ij,ij->i", end, v), np.einsum("ij,ij->i", end, u)) % (2.0 * np.pi)
        sweep = np.where(is_round, sweep, 0.0)
        sound = is_held & (is_round == is_arc)
        sound &= ~is_arc | ((sweep >= LEAST_SWEEP_RAD) & (sweep <= LARGEST_SWEEP_RAD))
        return cls(p0, chord, R0, turn, centre, u, v, sweep, sound)

    def select(self, rows: IntArray) -> Moves:
        """Return the moves at `rows`, of shape (k,)."""
        names = ("p0", "chord", "R0", "turn", "centre", "u", "v", "sweep", "is_sound")
        return Moves(*(getattr(self, name)[rows] for name in names))

    def shares(self, points: FloatArray) -> FloatArray:
        """Return where each move is nearest to a point, shape (m,): 0 at its start, 1 at its end.

        `points`: shape (m, 3). One for each move, mm.
        """
        length = np.einsum("ij,ij->i", self.chord, self.chord)
        along = np.einsum("ij,ij->i", points - self.p0, self.chord) / np.where(length > 0.0, length, 1.0)
        if not self.sweep.any():
            return np.asarray(np.clip(along, 0.0, 1.0), dtype=np.float64)
        w = points - self.centre
        angle = arc_tangent(np.einsum("ij,ij->i", w, self.v), np.einsum("ij,ij->i", w, self.u)) % (2.0 * np.pi)
        is_before = (angle - self.sweep) > (2.0 * np.pi - angle)
        round_ = np.where(is_before, 0.0, angle) / np.where(self.sweep > 0.0, self.sweep, 1.0)
        return np.clip(np.where(self.sweep > 0.0, round_, along), 0.0, 1.0)

    def positions(self, share: FloatArray) -> FloatArray:
        """Return where the tool centre points are at shares of shape (m,); shape (m, 3), mm."""
        on_line = self.p0 + share[:, None] * self.chord
        if not self.sweep.any():
            return np.asarray(on_line, dtype=np.float64)
        sine, cosine = sine_cosine((share * self.sweep)[:, None])
        return np.where(self.sweep[:, None] > 0.0, self.centre + cosine * self.u + sine * self.v, on_line)

    def rotations(self, share: FloatArray) -> FloatArray:
        """Return the axes of the tools at shares of shape (m,); shape (m, 3, 3)."""
        return np.asarray(product(exp_rotation(share[:, None] * self.turn), self.R0), dtype=np.float64)

    def directions(self, share: FloatArray, axis: int) -> FloatArray:
        """Return one axis of the tools at shares of shape (m,); shape (m, 3)."""
        first = self.R0[:, :, axis]
        size = np.linalg.norm(self.turn, axis=1, keepdims=True)
        about = self.turn / np.where(size > NO_TURN_RAD, size, 1.0)
        along = np.einsum("ij,ij->i", about, first)[:, None] * about
        sine, cosine = sine_cosine(share[:, None] * size)
        return np.asarray(along + cosine * (first - along) + sine * _cross(about, first))

    def headings(self, share: FloatArray) -> FloatArray:
        """Return unit directions of travel at shares of shape (m,); shape (m, 3). Zero for a move without length."""
        sine, cosine = sine_cosine((share * self.sweep)[:, None])
        way = np.where(self.sweep[:, None] > 0.0, cosine * self.v - sine * self.u, self.chord)
        length = np.linalg.norm(way, axis=1, keepdims=True)
        return np.asarray(way / np.where(length > 0.0, length, 1.0), dtype=np.float64)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the vector products, shape (m, 3): those of `np.cross` to the bit, in a third of its time for few rows."""
    (x, y, z), (u, v, w) = a.T, b.T
    found = np.empty_like(a)
    found[:, 0], found[:, 1], found[:, 2] = y * w - z * v, z * u - x * w, x * v - y * u
    return found


def turns_between(R0: FloatArray, R1: FloatArray) -> FloatArray:
    """Return rotation vectors from R0 to R1, both of shape (m, 3, 3), in their common frame; shape (m, 3), rad."""
    q = quaternion_from_rotation(product(R1, np.swapaxes(R0, -1, -2)))
    half = np.linalg.norm(q[:, :3], axis=1)
    is_turn = half > NO_TURN_RAD
    factor = np.where(is_turn, 2.0 * arc_tangent(half, q[:, 3]) / np.where(is_turn, half, 1.0), 2.0)
    return np.asarray(factor[:, None] * q[:, :3], dtype=np.float64)


def swings_between(d0: FloatArray, d1: FloatArray) -> FloatArray:
    """Return the least rotations from directions to directions, shape (m, 3). Rotation vectors, rad.

    `d0`, `d1`: shape (m, 3). Unit vectors.
    """
    normal = _cross(d0, d1)
    sine = np.linalg.norm(normal, axis=1)
    angle = arc_tangent(sine, np.einsum("ij,ij->i", d0, d1))
    return np.asarray((angle / np.where(sine > NO_TURN_RAD, sine, 1.0))[:, None] * normal, dtype=np.float64)


def turns_through(d0: FloatArray, middle: FloatArray, d1: FloatArray) -> FloatArray:
    """Return the rotations that lead directions through others: three directions are on one cone.

    `d0`, `middle`, `d1`: shape (m, 3). Unit vectors.
    Returns ndarray, shape (m, 3). Rotation vectors, rad; NaN where the three do not differ.
    """
    normal = _cross(middle - d0, d1 - middle)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    about = np.where(length > NO_TURN_RAD, normal / np.where(length > NO_TURN_RAD, length, 1.0), np.nan)
    e0, e1 = (d - np.einsum("ij,ij->i", about, d)[:, None] * about for d in (d0, d1))
    angle = arc_tangent(np.einsum("ij,ij->i", _cross(e0, e1), about), np.einsum("ij,ij->i", e0, e1)) % (2.0 * np.pi)
    return np.asarray(angle[:, None] * about, dtype=np.float64)
