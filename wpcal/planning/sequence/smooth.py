"""Torch angles along a weld that move the joints least: banded least squares over the rungs of the seam.

The ladder chooses among a grid of torch angles and spins. Here spin, work and travel at the rungs are real numbers. The
sum of the squared joint rates and of the squared deviations of the torch from its targets becomes least, within the
range of the torch angles, joint limits, and away from singular poses. Between rungs the deviations are straight, as in
the ladder: on a straight seam the spin is even from its start to its end, as a controller moves on a line.
First only the spin is free. Work and travel leave their targets only if the joints then move clearly less. The way that
is found is checked like those of the ladder. If it is not clear, less of the change is made.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.same_bits import product
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.cell.workplace import LEAST_REGULARITY, regularity
from wpcal.planning.plan.banded import LinearModel, descend
from wpcal.planning.sequence.external import values_along
from wpcal.planning.sequence.seam_search import SeamSearch
from wpcal.planning.sequence.seam_task import Candidate
from wpcal.planning.sequence.torch_poses import angles_between, tool_on_seam, torch_angles
from wpcal.robot.kinematics.inverse import TURN, own_branch

MOTION = 10.0
"""Degrees of the torch off its targets that a joint rate of one degree per mm costs, as the balanced choice of ways."""
KEEP_OFF_RAD = math.radians(0.5)
"""Limits count from this far inside, so that a path that a squared penalty holds back stays within them."""
STIFFNESS = 30.0  #: Weight of an excess over a limit: far above that of a deviation.
SPIN_PULL = 1e-3  #: Weight of a spin away from that of the ladder: where it moves no joint, it stays.
STEP_RAD = 1e-5  #: Of central differences: the error of the closed-form inverse is about 1e-12 rad.
CLEARLY_LESS, LEAST_GAIN_RAD_MM = 0.95, math.radians(0.03)
"""The torch leaves its targets for at most this part of the joint motion at them, and for this much less at least: at a
usual speed of 6 mm/s it is 0.2 degrees per second."""
SHARES = (1.0, 0.5, 0.25)  #: Parts of the change that are tried, until the way is clear.
STRAIGHT_RAD = math.radians(0.1)
"""A seam whose frames turn by less is straight: its angles are even from its start to its end."""


@dataclass(frozen=True, slots=True, eq=False)
class _Rungs:
    """Torch angles (m, 3) at the rungs, rad, and the joints (m, 6) there."""

    angles: FloatArray
    joints: FloatArray


class _Problem:
    """The sum of squares of one way: its rungs, and what holds at each of them."""

    def __init__(self, search: SeamSearch, way: Candidate, *, is_tilted: bool) -> None:
        self.search, self.way, self.task = search, way, way.task
        self.is_free = np.array([is_tilted, is_tilted, True])
        self.rows = _knots(way)
        self.external = values_along(way.q[None, [0, -1], JOINTS:], self.task, self.rows)
        self.start = _Rungs(way.angles[self.rows], way.q[self.rows, :JOINTS])
        self.asked = torch_angles(self.task, self.rows, search.targets)
        self.low, self.high = search.cell.arm.limits
        self._T_base_part = search.part_places(self.external)[0]
        self._T_tool_flange = search.cell.T_flange_tool.inverse().matrix

    def joints(self, angles: FloatArray, near: FloatArray) -> FloatArray:
        """Return the joints (..., m, 6) at angles (..., m, 3), in the turns of joints (m, 6); NaN if there are none."""
        m, count = len(self.rows), angles.size // (3 * len(self.rows))
        T = tool_on_seam(self.task, np.tile(self.rows, count), angles.reshape(-1, 3)).reshape(count, m, 4, 4)
        flange = product(self._T_base_part, product(T, self._T_tool_flange)).reshape(-1, 4, 4)
        here = np.broadcast_to(near, (*angles.shape[:-1], JOINTS))
        found = own_branch(self.search.cell.arm, flange, self.way.branch, here.reshape(-1, JOINTS)).reshape(here.shape)
        return np.asarray(found + TURN * np.rint((near - found) / TURN))

    def moved(self, at: _Rungs, step: FloatArray) -> _Rungs | None:
        """Return the way after a step of shape (m, 3); None where the arm does not reach."""
        angles = at.angles + step * self.is_free
        reach = self.search.targets.torch_range_rad
        if self.is_free.all():
            angles[:, :2] = np.clip(angles[:, :2], self.asked - reach, self.asked + reach)
        joints = self.joints(angles, at.joints)
        return _Rungs(angles, joints) if np.isfinite(joints).all() else None

    def linearise(self, at: _Rungs) -> LinearModel:
        """Return the sum of squares around a way."""
        m, s = len(self.rows), self.task.s_mm[self.rows]
        slopes = self._slopes(at)
        weights = self.search.weights
        scale = MOTION * np.sqrt(weights / (weights.sum() * (s[-1] - s[0])) / np.diff(s)[:, None])
        off = np.concatenate(
            [at.angles[:, :2] - self.asked, SPIN_PULL * (at.angles - self.start.angles)[:, 2:]], axis=1
        )
        doff = np.diag([1.0, 1.0, SPIN_PULL] * self.is_free)
        values, slopes_of = regularity(self.search.cell.arm, at.joints)
        missing = LEAST_REGULARITY - values + KEEP_OFF_RAD
        beyond = np.concatenate([at.joints - self.high, self.low - at.joints], axis=1) + KEEP_OFF_RAD
        return LinearModel(
            deviation=off / math.sqrt(m),
            ddeviation=doff / math.sqrt(m),
            beyond=STIFFNESS * np.concatenate([beyond, missing], axis=1),
            dbeyond=STIFFNESS * np.concatenate([slopes, -slopes, -(product(slopes_of, slopes))], axis=1),
            move=scale * np.diff(at.joints, axis=0),
            dq=slopes,
            scale=scale,
        )

    def _slopes(self, at: _Rungs) -> FloatArray:
        """Return the derivatives of the joints by the angles, shape (m, 6, 3)."""
        steps = STEP_RAD * np.eye(3)[self.is_free]
        ends = self.joints(at.angles + np.stack([steps, -steps])[:, :, None], at.joints)
        slopes = np.zeros((*at.joints.shape, 3))
        slopes[:, :, self.is_free] = np.moveaxis(np.nan_to_num((ends[0] - ends[1]) / (2.0 * STEP_RAD)), 0, 2)
        return slopes


def _knots(way: Candidate) -> IntArray:
    """Return the points at which the angles are free: the rungs; of a straight seam its ends."""
    R = way.task.R
    cosine = (np.einsum("ij,nij->n", R[0], R) - 1.0) / 2.0
    if math.acos(min(max(float(cosine.min()), -1.0), 1.0)) < STRAIGHT_RAD:
        return np.array([0, len(way) - 1])
    return way.task.rungs()


def respun(search: SeamSearch, way: Candidate) -> Candidate:
    """Return a way whose joints move less with other spins, with the same branch and external axes."""
    return _refined(search, way, math.inf, is_tilted=False)


def tilted(search: SeamSearch, way: Candidate, spun_way: Candidate) -> Candidate:
    """Return the way of `respun`, or one whose torch leaves its targets, if its joints then move clearly less."""
    most = min(CLEARLY_LESS * spun_way.motion_rad_mm, spun_way.motion_rad_mm - LEAST_GAIN_RAD_MM)
    if search.targets.torch_range_rad == 0.0 or most <= 0.0:
        return spun_way
    found = _refined(search, way, most, is_tilted=True)
    return found if found.motion_rad_mm < most else spun_way


def _refined(search: SeamSearch, way: Candidate, most_rad_mm: float, *, is_tilted: bool) -> Candidate:
    """Return a way of less cost and of less motion than a limit, if one is clear; else the given one."""
    problem = _Problem(search, way, is_tilted=is_tilted)
    found = descend(problem.start, problem.linearise, problem.moved)
    s, rungs = way.task.s_mm, way.task.s_mm[problem.rows]
    start = way.angles
    if len(rungs) == 2:
        start = angles_between(way.task, search.targets, np.arange(len(way)), problem.rows, problem.start.angles)
    at_rungs = found.angles - problem.start.angles
    change = np.stack([np.interp(s, rungs, column) for column in at_rungs.T], axis=1)
    asked = way.q[[0, -1], JOINTS:], (way.branch, way.q[0, :JOINTS])
    for share in SHARES:
        angles = start + share * change
        q, end = search.reached(way.task, angles, *asked)
        if end < len(angles):
            continue
        better = replace(search.candidate(way.task, angles, q, way.branch), is_reversed=way.is_reversed)
        less, now = (each.off_torch_rad**2 + (MOTION * each.motion_rad_mm) ** 2 for each in (better, way))
        is_less = less < now and better.motion_rad_mm < most_rad_mm
        if is_less and search.checked(way.task, angles, *asked)[1] is None:
            return better
    return way
