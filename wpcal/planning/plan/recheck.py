"""The check for collisions: clearances by hulls at states between the planned ones, where the controllers interpolate.

The programs contain joint targets, and both controllers interpolate joints, with the same fraction of a segment at the
same time. The states between two planned states are therefore on a straight line in the twelve joints, not on the seam.
The distance of the wire tip from the seam at these states is measured too: it shows whether the planned points are
close enough.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.clearance import Clearance
from wpcal.planning.cell.hulls import hull_clearance
from wpcal.planning.cell.shape import corners_of_box
from wpcal.planning.plan.plan import CollisionVerdict
from wpcal.robot.kinematics.forward import Frames

REFINE = 10
"""Parts into which each step of a plan is divided: joints then move by tenths of a degree between checked states."""
HALVINGS = 3
"""How often the parts are halved if bodies move farther between two states than the distance between them. At eight
times finer steps, a body on a path of 2 mm steps moves by some tenths of a millimetre."""
LARGEST_TIP_ERROR_MM = 0.25  #: A fifth of a usual wire of 1.2 mm: a weld does not show less.
LARGEST_SPEED_ERROR = 0.15  #: Part of the planned speed. The throat of a fillet then changes by half of this.
TINY_MM2 = 1e-18
"""Squared length of a chord of 1e-9 mm. Shorter chords count as points, so nothing is divided by zero."""


@dataclass(frozen=True, slots=True, eq=False)
class PathCheck:
    """Result of a check between the points of a path."""

    refine: int  #: Parts into which each step was divided in the end.
    s_mm: FloatArray  #: shape (m,). Arc length along the seam at the checked states, mm.
    clearance: Clearance  #: Of the m states, by hulls.
    motion_mm: float  #: Largest motion of any body from one checked state to the next, mm.
    #: Largest distance of the wire tip from the line between neighbouring points, in the frame of the part, mm.
    tip_error_mm: float

    @property
    def least_gap_mm(self) -> float:
        """Lower bound of the distance between any two bodies at any checked state, mm."""
        if not len(self.clearance.pairs):
            return math.inf
        return float(self.clearance.margin_mm.min() + self.clearance.pairs.safety_mm.min())

    @property
    def nothing_between(self) -> bool:
        """Whether no bodies can touch between checked states: two bodies approach each other by one motion at most."""
        return self.least_gap_mm > self.motion_mm

    @property
    def verdict(self) -> CollisionVerdict:
        """FREE when every checked state is clear (Hou 2018, eq. 6) and nothing can touch between them."""
        is_free = bool(self.clearance.is_clear.all()) and self.nothing_between
        return CollisionVerdict.FREE if is_free else CollisionVerdict.NOT_FREE

    @property
    def worst(self) -> int:
        """Row of the state with the least margin."""
        return int(np.argmin(self.clearance.margin_mm))

    def describe(self) -> str:
        """Say in one line which bodies are nearest, at what distance, and where."""
        row = self.worst
        if self.clearance.pair[row] < 0:
            return f"{len(self.s_mm)} states checked; no bodies that could meet"
        first, second = self.clearance.nearest(row)
        distance = self.clearance.distance_mm[row]
        asked = distance - self.clearance.margin_mm[row]
        found = (
            f"{len(self.s_mm)} states checked; least: {first} to {second}, {distance:.1f} mm "
            f"({asked:g} mm asked) at s = {self.s_mm[row]:.1f} mm"
        )
        if self.nothing_between or not self.clearance.is_clear.all():
            return found
        return f"{found}; bodies move {self.motion_mm:.1f} mm between two states, too far to exclude a collision there"


@dataclass(frozen=True, slots=True)
class TipMotion:
    """The tip of the wire in the part between the points of a weld, where the controllers interpolate joints."""

    error_mm: float  #: Largest distance from the line between neighbouring points, mm.
    s_mm: float  #: Place of that distance along the seam, mm.
    #: `slowest_mm_s`, `fastest_mm_s`: Range of the speed in the part, mm/s.
    slowest_mm_s: float
    fastest_mm_s: float

    def is_coarse(self, speed_mm_s: float) -> bool:
        """Tell whether the points are too far apart for a weld at a speed, mm/s."""
        off = max(speed_mm_s - self.slowest_mm_s, self.fastest_mm_s - speed_mm_s)
        return self.error_mm > LARGEST_TIP_ERROR_MM or off > LARGEST_SPEED_ERROR * speed_mm_s

    def describe(self, speed_mm_s: float) -> str:
        """Say in one line how far the tip leaves the seam, and between which speeds it moves."""
        text = (
            f"between the points: tip up to {self.error_mm:.2f} mm off the line from point to point "
            f"(at s = {self.s_mm:.1f} mm), at {self.slowest_mm_s:.1f} to {self.fastest_mm_s:.1f} mm/s in the part "
            f"({speed_mm_s:g} mm/s planned)"
        )
        if not self.is_coarse(speed_mm_s):
            return text
        return f"{text}; sample the seam with smaller steps (--max-step-mm of wpcal calibrate or wpcal seams)"


def check_path(planned: FloatArray, s_mm: FloatArray, cell: Cell, *, refine: int = REFINE) -> PathCheck:
    """Measure a path by hulls at finer steps.

    If all states are clear, but bodies move farther between two states than the distance between them, the steps are
    halved and measured again, at most `HALVINGS` times.

    `planned`: shape (n, 12). All axes at the states, rad.
    `s_mm`: shape (n,). Arc length along the seam at the states, mm.
    Raises `InputError` when `refine` is less than 1, or hulls need a package that is not installed.
    """
    found = _measure(planned, s_mm, cell, refine)
    for _ in range(HALVINGS):
        if found.nothing_between or not found.clearance.is_clear.all():
            break
        found = _measure(planned, s_mm, cell, 2 * found.refine)
    return found


def _measure(planned: FloatArray, s_mm: FloatArray, cell: Cell, refine: int) -> PathCheck:
    q = finer_states(planned, refine=refine)
    s_fine = np.interp(np.arange(len(q)) / refine, np.arange(len(planned)), s_mm)
    clearance = hull_clearance(cell, q)
    tip_mm = float(_off_chords(cell.tool_in_part(q)[:, :3, 3], refine).max())
    return PathCheck(refine, frozen(s_fine), clearance, _largest_motion(clearance, cell, q), tip_mm)


def finer_states(q: FloatArray, *, refine: int) -> FloatArray:
    """Return a path, `q` of shape (n, 12), with each step divided into `refine` equal parts in the joints.

    Raises `InputError` when `refine` is less than 1 or there are no states.
    """
    if refine < 1 or len(q) < 1:
        raise InputError(f"expected at least one state and at least one part per step, got {len(q)} and {refine}")
    at = np.arange((len(q) - 1) * refine + 1)
    row, part = at // refine, (at % refine / refine)[:, None]
    after = np.minimum(row + 1, len(q) - 1)
    return np.asarray(q[row] + part * (q[after] - q[row]), dtype=np.float64)


def _largest_motion(clearance: Clearance, cell: Cell, q: FloatArray) -> float:
    """Return the largest motion of a corner of the box around any body between neighbouring states, mm.

    The motion of the points of a rigid body is largest at a corner of any box around it.
    """
    frames = cell.frames(q)
    largest = 0.0
    for body in clearance.pairs.bodies:
        frame = Frames(*(axis[:, None] for axis in frames[body.carrier]))
        steps = np.diff(frame.point(corners_of_box(*body.shape.box).T[:, :, None]), axis=2)
        largest = max(largest, float(np.linalg.norm(steps, axis=0).max(initial=0.0)))
    return largest


def _off_chords(tip: FloatArray, refine: int) -> FloatArray:
    """Return the distance of each of m places from the chord of its step, shape (m,), mm."""
    row = np.minimum(np.arange(len(tip)) // refine, max(len(tip) // refine - 1, 0)) * refine
    start, chord = tip[row], tip[np.minimum(row + refine, len(tip) - 1)] - tip[row]
    along = np.einsum("ij,ij->i", tip - start, chord) / np.maximum(np.einsum("ij,ij->i", chord, chord), TINY_MM2)
    return np.asarray(np.linalg.norm(tip - start - along[:, None] * chord, axis=1), dtype=np.float64)


def measure_tip(planned: FloatArray, s_mm: FloatArray, t_s: FloatArray, cell: Cell) -> TipMotion:
    """Measure how the tip of the wire moves in the part between the points of a weld.

    `s_mm`: shape (n,). Arc length along the seam at the states, mm.
    `t_s`: shape (n,). Their times, s; between them joints move evenly.
    """
    tip = cell.tool_in_part(finer_states(planned, refine=REFINE))[:, :3, 3]
    off, at = _off_chords(tip, REFINE), np.arange(len(tip)) / REFINE
    speed = np.linalg.norm(np.diff(tip, axis=0), axis=1) / np.diff(np.interp(at, np.arange(len(t_s)), t_s))
    worst = int(np.argmax(off))
    place = float(np.interp(at[worst], np.arange(len(s_mm)), s_mm))
    return TipMotion(float(off[worst]), place, float(speed.min()), float(speed.max()))
