"""Is a planned path free? Judged by hulls at states between the planned ones, as the controllers pass through them.

The programs hold joint targets and both controllers interpolate joints, with the same fraction of a segment at the same
time. The states between two planned ones are therefore those of a straight line in the twelve joints, not of the seam.
How far the wire tip leaves the seam on them is measured too: it tells whether the planned points stand close enough.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.planning.bodies import body_frames
from wpcal.planning.cell import CellState, RobotCell, part_in_world, tool_in_world
from wpcal.planning.clearance import Clearance, capsule_axes
from wpcal.planning.hulls import hull_clearance
from wpcal.planning.plan import Plan

REFINE = 10
"""Parts into which each step of a plan is cut: joints then move by tenths of a degree between checked states."""
TINY_MM2 = 1e-18
"""Squared length of a chord of 1e-9 mm: points that do not move along the seam are compared as they are."""


class Freedom(Enum):
    """What is known of a path."""

    UNCHECKED = "unchecked"
    FREE = "free"
    NOT_FREE = "not free"


@dataclass(frozen=True, slots=True, eq=False)
class PathCheck:
    """What a check between the points of a path found.

    Parameters
    ----------
    refine : int
        Parts into which each step was cut.
    s_mm : ndarray, shape (m,)
        Arc length along the seam of the checked states.
    clearance : Clearance
        Of the m states, by hulls.
    motion_mm : float
        Farthest that any body moves from one checked state to the next: what is thinner than half of this beyond its
        distance could be missed.
    tip_error_mm : float
        Farthest that the wire tip is from the line between neighbouring points, seen from the part.
    """

    refine: int
    s_mm: FloatArray
    clearance: Clearance
    motion_mm: float
    tip_error_mm: float

    @property
    def freedom(self) -> Freedom:
        """FREE when every checked state is clear (Hou 2018, eq. 6)."""
        return Freedom.FREE if bool(self.clearance.is_clear.all()) else Freedom.NOT_FREE

    @property
    def worst(self) -> int:
        """Row of the state with the least margin."""
        return int(np.argmin(self.clearance.margin_mm))

    def describe(self) -> str:
        """Say in one line what was found: the nearest bodies, their distance, and where."""
        row = self.worst
        if self.clearance.pair[row] < 0:
            return f"{len(self.s_mm)} states checked; no bodies that could meet"
        first, second = self.clearance.nearest(row)
        distance = self.clearance.distance_mm[row]
        asked = distance - self.clearance.margin_mm[row]
        return (
            f"{len(self.s_mm)} states checked; least: {first} to {second}, {distance:.1f} mm "
            f"({asked:g} mm asked) at s = {self.s_mm[row]:.1f} mm"
        )


def recheck_clearance(plan: Plan, cell: RobotCell, *, refine: int = REFINE) -> PathCheck:
    """Measure a plan by hulls at finer steps.

    Parameters
    ----------
    plan : Plan
        n points.
    cell : RobotCell
    refine : int
        Parts into which each step is cut: (n - 1) refine + 1 states are measured.

    Returns
    -------
    PathCheck

    Raises
    ------
    InputError
        When `refine` is less than 1, or hulls need a package that is not installed.
    """
    return check_path(plan.state, plan.s_mm, cell, refine=refine)


def check_path(planned: CellState, s_mm: FloatArray, cell: RobotCell, *, refine: int = REFINE) -> PathCheck:
    """Measure any path of n states by hulls at finer steps; `s_mm`, shape (n,), says where along the seam they are.

    Raises
    ------
    InputError
        As in `recheck_clearance`.
    """
    state = finer_states(planned, refine=refine)
    s_fine = np.interp(np.arange(len(state)) / refine, np.arange(len(planned)), s_mm)
    clearance = hull_clearance(cell, state)
    motion = _largest_motion(clearance, cell, state)
    return PathCheck(refine, frozen(s_fine), clearance, motion, _tip_error(cell, state, refine))


def finer_states(state: CellState, *, refine: int) -> CellState:
    """Return a path with each step cut into `refine` equal parts in the joints.

    Raises
    ------
    InputError
        When `refine` is less than 1 or there are no states.
    """
    if refine < 1 or len(state) < 1:
        raise InputError(f"expected at least one state and at least one part a step, got {len(state)} and {refine}")
    at = np.arange((len(state) - 1) * refine + 1)
    row, part = at // refine, (at % refine / refine)[:, None]
    after = np.minimum(row + 1, len(state) - 1)
    joints = (q[row] + part * (q[after] - q[row]) for q in (state.joints1, state.joints2))
    return CellState(*joints)


def _largest_motion(clearance: Clearance, cell: RobotCell, state: CellState) -> float:
    """Return the farthest that an end of a capsule's axis moves between neighbours."""
    if len(state) < 2 or not clearance.pairs.bodies:
        return 0.0
    axes = capsule_axes(clearance.pairs, body_frames(cell, state))
    ends = np.concatenate([axes.p, axes.p + axes.u], axis=1)
    return float(np.linalg.norm(np.diff(ends, axis=2), axis=0).max())


def _tip_error(cell: RobotCell, state: CellState, refine: int) -> float:
    """Return the largest distance of the tip from the chords between planned points, in the part, mm."""
    T_part_world = np.linalg.inv(part_in_world(cell, state.joints2))
    tip = (T_part_world @ tool_in_world(cell, state.joints1))[:, :3, 3]
    row = np.minimum(np.arange(len(tip)) // refine, max(len(tip) // refine - 1, 0)) * refine
    start, chord = tip[row], tip[np.minimum(row + refine, len(tip) - 1)] - tip[row]
    along = np.einsum("ij,ij->i", tip - start, chord) / np.maximum(np.einsum("ij,ij->i", chord, chord), TINY_MM2)
    return float(np.linalg.norm(tip - start - along[:, None] * chord, axis=1).max())
