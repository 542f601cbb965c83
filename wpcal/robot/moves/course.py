"""The path that moves have to keep to: the given poses, and points between them.

Between two given points the path is the cubic curve with their directions of travel. It misses an arc of radius r and
step h by h⁴ / (384 r³): 2e-4 mm for a step of 10 mm at a radius of 50 mm, where the chord misses it by 0.25 mm. The
tool turns along a cubic of rotation vectors, with the rate of turn at each point from the steps before and after it.
Corners and jumps, where directions or rates do not fit together, are left as they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.same_bits import product
from wpcal.core.tangent import exp_rotation
from wpcal.robot.moves.interpolation import turns_between

STEP_MM = 2.0
"""Between checked points: an arc that meets both ends of a straight step leaves it by 0.05 mm at a radius of 10 mm."""
LEAST_PARTS = 2  #: Of a step, so that every step is checked between its ends.
LEAST_ASYMMETRY = 0.35
"""A step is a corner, not a curve, where the angles of its two ends with the chord differ by more than this share of
the larger one."""
LARGEST_CHANGE = 0.5
"""The tool turns smoothly at a point where its rates before and after differ by at most this share of the larger."""
ROUND_OFF_RAD = 1e-6  #: Angles below are those of a straight step.


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """m points along the path, of which some may be ends of moves."""

    #: `p`, `tip`: shape (m, 3). Tool centre points, and tips of the wire, mm.
    p: FloatArray
    tip: FloatArray
    R: FloatArray  #: shape (m, 3, 3). Axes of the tool.
    s_mm: FloatArray  #: shape (m,). Length along the path.
    nodes: IntArray  #: shape (k,). Rows at which moves may end.
    steps: IntArray  #: shape (k - 1,). Number of the step between given poses that leaves each node but the last.
    axis: int  #: The axis of the tool along the wire: 0 for x, 2 for z.
    standoff_mm: float  #: From the tool centre point to the tip.

    @property
    def wire(self) -> FloatArray:
        """Directions of the wire, shape (m, 3)."""
        return self.R[:, :, self.axis]

    @classmethod
    def along(
        cls,
        p: FloatArray,
        R: FloatArray,
        *,
        s_mm: FloatArray,
        headings: FloatArray | None,
        axis: int,
        standoff_mm: float,
        most_mm: float,
        step_mm: float = STEP_MM,
        pieces: IntArray | int = 1,
    ) -> Course:
        """Return the course through given poses.

        `p`: shape (n, 3). Tool centre points, mm.
        `R`: shape (n, 3, 3). Axes of the tool.
        `s_mm`: shape (n,). Lengths along the path.
        `headings`: shape (n, 3). Directions of travel of the wire's tip; None: straight between two points.
        `pieces`: shape (n - 1,), or one for all. Into how many pieces each step is divided; a move may end at each.
        """
        tip = p + standoff_mm * R[:, :, axis]
        step = np.diff(tip, axis=0)
        length = np.linalg.norm(step, axis=1)
        own = np.maximum(np.ceil(length / step_mm), LEAST_PARTS).astype(np.int64)  # of a piece
        parts = own * pieces
        first = np.repeat(np.arange(len(parts)), parts)
        starts = np.concatenate([[0], np.cumsum(parts)])
        number = np.arange(len(first)) - starts[first]
        t = number / parts[first]
        R_all = np.concatenate([product(exp_rotation(_turned(R, np.diff(s_mm), first, t)), R[first]), R[-1:]])
        chord = tip[first] + t[:, None] * step[first]
        curve = chord if headings is None else _hermite(tip, length, headings, _is_curve(step, headings), first, t)
        is_node = number % own[first] == 0
        off = np.zeros(len(parts))
        np.maximum.at(off, first, np.linalg.norm(curve - chord, axis=1))
        is_node |= off[first] > most_mm  # where the chord of a step already misses the path
        tips = np.concatenate([curve, tip[-1:]])
        s = np.concatenate([s_mm[first] + t * np.diff(s_mm)[first], s_mm[-1:]])
        nodes = np.concatenate([np.flatnonzero(is_node), [len(first)]])
        return cls(tips - standoff_mm * R_all[:, :, axis], tips, R_all, s, nodes, first[is_node], axis, standoff_mm)


def _is_curve(step: FloatArray, headings: FloatArray) -> BoolArray:
    """Tell which steps are smooth: their two directions are mirrored at the chord, or nearly so."""
    length = np.linalg.norm(step, axis=1, keepdims=True)
    unit = step / np.where(length > 0.0, length, 1.0)
    ends = [t - np.einsum("ij,ij->i", t, unit)[:, None] * unit for t in (headings[:-1], headings[1:])]
    larger = np.maximum(*(np.linalg.norm(end, axis=1) for end in ends))
    forward = np.minimum(*(np.einsum("ij,ij->i", t, unit) for t in (headings[:-1], headings[1:]))) > 0.0
    return np.asarray(
        forward & (np.linalg.norm(ends[0] + ends[1], axis=1) <= LEAST_ASYMMETRY * larger + ROUND_OFF_RAD),
        dtype=np.bool_,
    )


def _turned(R: FloatArray, length: FloatArray, first: IntArray, t: FloatArray) -> FloatArray:
    """Return rotation vectors from the start of each step to places in it."""
    turn = turns_between(R[:-1], R[1:])
    h = np.where(length > 0.0, length, 1.0)[:, None]
    rate = turn / h
    change = np.linalg.norm(np.diff(rate, axis=0), axis=1)
    size = np.linalg.norm(rate, axis=1)
    is_smooth = change <= LARGEST_CHANGE * np.maximum(size[:-1], size[1:])
    mean = (rate[:-1] * h[1:] + rate[1:] * h[:-1]) / (h[:-1] + h[1:])
    begin, end = np.full_like(rate, np.nan), np.full_like(rate, np.nan)
    begin[1:][is_smooth] = end[:-1][is_smooth] = mean[is_smooth]
    begin_known, end_known = np.isfinite(begin), np.isfinite(end)
    at_begin = np.where(begin_known, begin, np.where(end_known, 2.0 * rate - end, rate))
    at_end = np.where(end_known, end, np.where(begin_known, 2.0 * rate - begin, rate))
    x, h, both = t[:, None], h[first], turn[first]
    cubic = x * x * (3.0 - 2.0 * x) * both + x * (1.0 - x) * h * ((1.0 - x) * at_begin[first] - x * at_end[first])
    return np.asarray(cubic, dtype=np.float64)


def _hermite(
    p: FloatArray, length: FloatArray, headings: FloatArray, is_curve: BoolArray, first: IntArray, t: FloatArray
) -> FloatArray:
    """Return points of the cubics; of a step that is no curve, points of its chord."""
    chord = p[1:] - p[:-1]
    unit = headings / np.linalg.norm(headings, axis=1, keepdims=True)
    cosine = np.clip(np.einsum("ij,ij->i", unit[:-1], unit[1:]), -1.0, 1.0)
    half = np.arccos(cosine) / 2.0  # of an arc with these directions: its length is chord * half / sin(half)
    arc = length * np.where(half > ROUND_OFF_RAD, half / np.where(half > ROUND_OFF_RAD, np.sin(half), 1.0), 1.0)
    m0 = np.where(is_curve[:, None], arc[:, None] * unit[:-1], chord)[first]
    m1 = np.where(is_curve[:, None], arc[:, None] * unit[1:], chord)[first]
    x = t[:, None]
    from_start = x * x * (3.0 - 2.0 * x)
    return np.asarray(p[first] + from_start * chord[first] + x * (1.0 - x) ** 2 * m0 - x * x * (1.0 - x) * m1)
