"""Straight moves in the axes, proved free between the checked states too.

A bound of how far any point of any body moves per radian of an axis follows from the lengths of the links alone. Two
bodies that are D apart at both ends of a step cannot touch on it if they approach each other by less than 2 D on it. So
a step is proved when the bound of its motion is at most the sum of the free distances at its ends; otherwise it is
halved, and its middle is measured.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.planning.cell.one_robot import CARRIER, TOOL, OneRobotCell
from wpcal.planning.cell.one_robot_clearance import OneRobotClearance, one_robot_bodies
from wpcal.planning.cell.robot_cell import JOINTS

FIRST_STEP_MM = 150.0
"""Steps of the first round: most of a move is this far from everything."""
LONG_STEP_MM = 800.0
"""The same where many moves are tried of which few are free: most are given up in the first round."""
LEAST_FREE_MM = 1.0
"""A step is also proved with this free distance at both ends where the safety distances are smaller: states are clear
beyond their safety distance, and no cell should have a smaller one."""


@dataclass(frozen=True, slots=True, eq=False)
class CheckedMove:
    """Result for a row of straight moves.

    Parameters
    ----------
    is_free : bool
    states : ndarray, shape (m, k)
        The measured states in order, rad and mm.
    at : ndarray, shape (m,)
        Their places, in moves from the start: 1.5 is half-way along the second move.
    margin_mm : ndarray, shape (m,)
        Lower bounds of the margins.
    largest_step_mm : float
        Largest bound of the motion between two neighbouring states.
    """

    is_free: bool
    states: FloatArray
    at: FloatArray
    margin_mm: FloatArray
    largest_step_mm: float


def motion_per_axis(cell: OneRobotCell, clearance: OneRobotClearance) -> FloatArray:
    """Return how far any body can move per unit of each axis, shape (k,): mm per rad, and 1 for a rail.

    Parameters
    ----------
    cell : OneRobotCell
    clearance : OneRobotClearance
        With the part.
    """
    frames = cell.frames(cell.home[None])
    places = [frame.p[:, 0] for frame in frames]
    out = dict.fromkeys(range(len(places)), 0.0)
    for body in one_robot_bodies(cell):
        points = np.concatenate([body.shape.p, body.shape.q])
        reach = float((np.linalg.norm(points, axis=1) + np.tile(body.shape.radius_mm, 2)).max())
        reach = max(reach, float(np.linalg.norm(body.shape.hull, axis=1).max(initial=0.0)))
        out[body.carrier] = max(out[body.carrier], reach)
    arm = [*range(JOINTS + 1), TOOL]
    per_axis = [_reach(places, out, arm[j:]) for j in range(JOINTS)]
    if cell.rail is not None:
        per_axis.append(1.0)
    if cell.positioner is not None:
        if clearance.part is not None:
            corners = clearance.part.corners.reshape(-1, 3)
            out[cell.part_row] = float(np.linalg.norm(corners, axis=1).max())
        chain = [*range(CARRIER, cell.part_row), cell.part_row]
        per_axis += [_reach(places, out, chain[j:]) for j in range(len(cell.positioner.arm.joints))]
    return np.array(per_axis)


def _reach(places: list[FloatArray], out: dict[int, float], chain: list[int]) -> float:
    """Return the largest distance of a body on a chain from the first frame; an axis goes through that frame."""
    along, best = 0.0, 0.0
    for before, row in itertools.pairwise(chain):
        along += float(np.linalg.norm(places[row] - places[before]))
        best = max(best, along + out[row])
    return best


class MotionChecker:
    """Checks straight moves in the axes of a cell.

    Parameters
    ----------
    cell : OneRobotCell
    clearance : OneRobotClearance
    """

    def __init__(self, cell: OneRobotCell, clearance: OneRobotClearance) -> None:
        self.cell, self.clearance = cell, clearance
        self.per_axis = motion_per_axis(cell, clearance)
        safety = [cell.d1_mm, *(s.to_part_mm for s in cell.torch if s.to_part_mm is not None)]
        self._free_mm = max(min(safety), LEAST_FREE_MM)

    def motion_mm(self, a: FloatArray, b: FloatArray) -> FloatArray:
        """Return bounds of how far any body moves, and a part towards it, between states (..., k); shape (...), mm."""
        return np.asarray(np.abs(b - a) @ self.per_axis, dtype=np.float64)

    def check(self, states: FloatArray) -> CheckedMove:
        """Check the straight moves from state to state.

        Parameters
        ----------
        states : ndarray, shape (n, k)
            Two or more, rad and mm.

        Returns
        -------
        CheckedMove
            Where it is not free, the states measured so far.
        """
        at, q = self._divided(np.asarray(states, dtype=np.float64))
        margin = self.clearance.margins(q).margin_mm
        while True:
            motion = self.motion_mm(q[:-1], q[1:])
            free = margin + self._free_mm
            wide = motion > free[:-1] + free[1:]
            is_free = bool((margin > 0.0).all())
            if not wide.any() or not is_free:
                return CheckedMove(is_free, q, at, margin, float(motion.max(initial=0.0)))
            middle = (at[:-1] + at[1:])[wide] / 2
            new = (q[:-1] + q[1:])[wide] / 2
            at, q = np.concatenate([at, middle]), np.concatenate([q, new])
            margin = np.concatenate([margin, self.clearance.margins(new).margin_mm])
            order = np.argsort(at, kind="stable")
            at, q, margin = at[order], q[order], margin[order]

    def _divided(self, states: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return places and states at steps of `FIRST_STEP_MM` at most: one call measures them all."""
        parts = np.maximum(np.ceil(self.motion_mm(states[:-1], states[1:]) / FIRST_STEP_MM), 1.0).astype(int)
        row = np.repeat(np.arange(len(parts)), parts)
        share = (np.arange(len(row)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[row]
        q = states[row] + share[:, None] * (states[row + 1] - states[row])
        return np.append(row + share, float(len(parts))), np.concatenate([q, states[-1:]])

    def free_shares(self, a: FloatArray, b: FloatArray, *, whole: bool, trust: float = 1.0) -> FloatArray:
        """Return how much of each of many straight moves is free, all measured together.

        Parameters
        ----------
        a, b : ndarray, shape (n, k)
            Starts and ends, rad and mm.
        whole : bool
            A move that is not free to its end counts as 0: nothing more of it is measured.
        trust : float
            How much farther than proved free a body may move between two measured states: 1 is a proof.

        Returns
        -------
        ndarray, shape (n,)
            0 where the start is not clear, 1 where the whole move is free.
        """
        motion = self.motion_mm(a, b)
        parts = np.maximum(np.ceil(motion / (LONG_STEP_MM if whole else FIRST_STEP_MM)), 1.0).astype(int) + 1
        move = np.repeat(np.arange(len(a)), parts)
        first = np.cumsum(parts) - parts
        t = (np.arange(len(move)) - first[move]) / (parts - 1)[move]
        margin = self.clearance.margins(a[move] + t[:, None] * (b - a)[move]).margin_mm
        while True:
            hit = np.full(len(a), np.inf)
            np.minimum.at(hit, move[margin <= 0.0], t[margin <= 0.0])
            keep = (hit[move] == np.inf) if whole else (t < hit[move])
            move, t, margin = move[keep], t[keep], margin[keep]
            near, free = move[1:] == move[:-1], margin + self._free_mm
            wide = near & ((t[1:] - t[:-1]) * motion[move[1:]] > trust * (free[1:] + free[:-1]))
            if not wide.any():
                break
            own, at = move[1:][wide], (t[1:] + t[:-1])[wide] / 2
            found = self.clearance.margins(a[own] + at[:, None] * (b - a)[own]).margin_mm
            move, t, margin = (np.concatenate(pair) for pair in ((move, own), (t, at), (margin, found)))
            order = np.lexsort([t, move])
            move, t, margin = move[order], t[order], margin[order]
        share = np.zeros(len(a))
        np.maximum.at(share, move, t)
        return share

    def is_free(self, a: FloatArray, b: FloatArray) -> bool:
        """Tell whether the straight move between two states of shape (k,) is free."""
        return self.check(np.stack([a, b])).is_free
