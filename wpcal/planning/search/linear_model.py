"""The least-squares problem around a path: residuals, excess over its limits, and all derivatives.

Angles are in degrees and lengths in millimetres here, so that one unit of each has a similar effect.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.planning.cell.closed_chain import COORDINATES, PLACE, joint_slopes
from wpcal.planning.cell.robot_cell import JOINTS
from wpcal.planning.cell.singularity import LEAST_REGULARITY, regularity
from wpcal.planning.search.objectives import Weights, deviation_weights, joint_step_weight
from wpcal.planning.search.problem import CandidatePath, PlanningProblem
from wpcal.planning.search.targets import ATTITUDE, deviations

KEEP_OFF_DEG = 0.5
"""Limits count from this far inside, so that a path that a squared penalty holds back stays within them."""
KEEP_CLEAR_MM = 3.0
"""The same margin for clearances: about a tenth of the usual safety distance."""
LOOK_AHEAD_MM = 30.0
"""The derivative of a clearance is computed below the safety distance plus this: a step rarely moves a body farther."""
STIFFNESS = 0.1
"""Weight of a degree beyond a limit. The objectives sum up to about 0.1 (deg/mm)², so that half a degree beyond a limit
(`KEEP_OFF_DEG`) at many points costs more."""
MM_PER_DEG = 10.0
"""This distance outside the weld zone counts like one degree: at arm's length it is half a degree."""
CLEARANCE_STIFFNESS = 0.2 * STIFFNESS
"""Weight of a missing millimetre: at arm's length five millimetres are a third of a degree."""
GRADIENT_STEP_RAD = 1e-6
"""Step of the difference quotients of clearances: 1e-3 mm at arm's length, far above round-off and below a radius."""


@dataclass(frozen=True, slots=True, eq=False)
class LinearModel:
    """The sum of squares of a path, as a function of a small step of the coordinates.

    Parameters
    ----------
    deviation : ndarray, shape (n, 4)
        Weighted deviations of slope, rotation, work and travel.
    ddeviation : ndarray, shape (4, 9)
        Their derivatives, the same at every point.
    beyond : ndarray, shape (n, h)
        Excess of each point over its limits, weighted; it counts where positive.
    dbeyond : ndarray, shape (n, h, 9)
    move : ndarray, shape (n - 1, 12)
        Weighted joint steps.
    dq : ndarray, shape (n, 12, 9)
        Derivatives of the joints, deg per unit of the coordinates.
    scale : ndarray, shape (n - 1, 12)
        Weights of the joint steps.
    """

    deviation: FloatArray
    ddeviation: FloatArray
    beyond: FloatArray
    dbeyond: FloatArray
    move: FloatArray
    dq: FloatArray
    scale: FloatArray

    @property
    def cost(self) -> float:
        """The sum of squares."""
        return float((self.deviation**2).sum() + (np.maximum(self.beyond, 0.0) ** 2).sum() + (self.move**2).sum())

    def predicted_cost(self, step: FloatArray) -> float:
        """Return the sum of squares after a step of shape (n, 9), to first order of every residual."""
        deviation = self.deviation + step @ self.ddeviation.T
        move = self.move + self.scale * np.diff(np.einsum("nmi,ni->nm", self.dq, step), axis=0)
        beyond = np.maximum(self.beyond_after(step), 0.0)
        return float((deviation**2).sum() + (beyond**2).sum() + (move**2).sum())

    def beyond_after(self, step: FloatArray) -> FloatArray:
        """Return the excess over the limits after a step of shape (n, 9), to first order; shape (n, h)."""
        return np.asarray(self.beyond + np.einsum("nmi,ni->nm", self.dbeyond, step), dtype=np.float64)

    def gradient(self, active: BoolArray) -> FloatArray:
        """Return half the gradient of the sum if the limits in `active`, shape (n, h), count; shape (n, 9)."""
        gradient = self.deviation @ self.ddeviation + np.einsum(
            "nmi,nm->ni", self.dbeyond, np.where(active, self.beyond, 0.0)
        )
        pull = self.scale * self.move
        gradient[:-1] -= np.einsum("nmi,nm->ni", self.dq[:-1], pull)
        gradient[1:] += np.einsum("nmi,nm->ni", self.dq[1:], pull)
        return np.asarray(gradient, dtype=np.float64)

    def band(self, active: BoolArray) -> FloatArray:
        """Return the normal matrix if the limits in `active`, shape (n, h), count; lower banded, shape (18, 9 n)."""
        n, k = len(self.deviation), COORDINATES
        limits = self.dbeyond * active[:, :, None]
        before, after = self.scale[:, :, None] * self.dq[:-1], self.scale[:, :, None] * self.dq[1:]
        diagonal = np.swapaxes(limits, 1, 2) @ limits + self.ddeviation.T @ self.ddeviation
        diagonal[:-1] += np.swapaxes(before, 1, 2) @ before
        diagonal[1:] += np.swapaxes(after, 1, 2) @ after
        coupling = -np.swapaxes(before, 1, 2) @ after  # rows: coordinates of a point, columns: of the next
        band = np.zeros((2 * k, n * k))  # band[d, j] holds element (j + d, j)
        for i in range(k):
            for j in range(k):
                if i >= j:
                    band[i - j, j::k] = diagonal[:, i, j]
                band[k + j - i, i : (n - 1) * k : k] = coupling[:, i, j]
        return band


def linearise(
    problem: PlanningProblem, path: CandidatePath, weights: Weights, *, stiffness: float = 1.0
) -> LinearModel:
    """Return the least-squares problem around a path.

    Parameters
    ----------
    problem : PlanningProblem
    path : CandidatePath
    weights : mapping of Objective to float
        Of the squared objectives.
    stiffness : float
        Factor on the excess over the limits.
    """
    n, s, K = len(path.coordinates), problem.path.s_mm, problem.cell.joint_weights
    slopes = np.degrees(joint_slopes(problem.cell, path.coordinates, path.joints))
    deviation_scale = np.sqrt(deviation_weights(weights) / n)
    ddeviation = np.zeros((4, COORDINATES))
    ddeviation[range(4), ATTITUDE] = np.degrees(deviation_scale)
    scale = np.sqrt(joint_step_weight(weights) * K / (K.sum() * (s[-1] - s[0])) / np.diff(s)[:, None])
    limits = [
        _box_limits(problem, path),
        _joint_limits(problem, path, slopes),
        _regular_limits(problem, path, slopes),
        _clearance_limits(problem, path, slopes),
    ]
    return LinearModel(
        deviation=deviation_scale * np.degrees(deviations(path.coordinates, problem.targets)),
        ddeviation=ddeviation,
        beyond=stiffness * np.concatenate([values for values, _ in limits], axis=1),
        dbeyond=stiffness * np.concatenate([derivative for _, derivative in limits], axis=1),
        move=scale * np.degrees(np.diff(path.joints, axis=0)),
        dq=slopes,
        scale=scale,
    )


def _two_sided(values: FloatArray, low: FloatArray, high: FloatArray, d: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Excess of values (n, m), deg, above and below their limits, from `KEEP_OFF_DEG` inside; and derivatives."""
    beyond = np.concatenate([values - high, low - values], axis=1) + KEEP_OFF_DEG
    return STIFFNESS * beyond, STIFFNESS * np.concatenate([d, -d], axis=1)


def _box_limits(problem: PlanningProblem, path: CandidatePath) -> tuple[FloatArray, FloatArray]:
    """Coordinates beyond their box, in degrees or multiples of `MM_PER_DEG`; (n, 14), (n, 14, 9)."""
    units = np.full(COORDINATES, np.degrees(1.0))
    units[PLACE] = 1.0 / MM_PER_DEG
    low, high = problem.box
    boxed = np.flatnonzero(np.isfinite(low))
    d = np.zeros((len(path.coordinates), len(boxed), COORDINATES))
    d[:, range(len(boxed)), boxed] = units[boxed]
    values, low, high = (units * part for part in (path.coordinates, low, high))
    return _two_sided(values[:, boxed], low[boxed], high[boxed], d)


def _joint_limits(problem: PlanningProblem, path: CandidatePath, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    low, high = problem.cell.joint_limits
    return _two_sided(np.degrees(path.joints), np.degrees(low), np.degrees(high), slopes)


def _regular_limits(problem: PlanningProblem, path: CandidatePath, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Poses too near to a singular pose, as the missing degrees of bend; (n, 6), (n, 6, 9)."""
    values, derivatives = [], []
    for arm, columns in ((problem.cell.arm1, slice(0, JOINTS)), (problem.cell.arm2, slice(JOINTS, None))):
        measure, slope = regularity(arm, path.joints[:, columns])
        values.append(STIFFNESS * (np.degrees(LEAST_REGULARITY - measure) + KEEP_OFF_DEG))
        derivatives.append(-STIFFNESS * (slope @ slopes[:, columns]))
    return np.concatenate(values, axis=1), np.concatenate(derivatives, axis=1)


def _clearance_limits(
    problem: PlanningProblem, path: CandidatePath, slopes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Missing clearance; (n, 1), (n, 1, 9). Its derivative is a difference quotient over joints, where it is small."""
    margin = problem.margins(path.joints)
    derivative = np.zeros((len(margin), 1, COORDINATES))
    rows = np.flatnonzero(margin < LOOK_AHEAD_MM)
    if len(rows):
        nudged = path.joints[rows, None] + GRADIENT_STEP_RAD * np.eye(2 * JOINTS)
        near = problem.margins(nudged.reshape(-1, 2 * JOINTS)).reshape(len(rows), 2 * JOINTS)
        slope = (near - margin[rows, None]) / GRADIENT_STEP_RAD
        derivative[rows, 0] = -CLEARANCE_STIFFNESS * np.einsum("nj,njk->nk", slope, np.radians(slopes[rows]))
    missing = np.where(np.isfinite(margin), KEEP_CLEAR_MM - margin, -LOOK_AHEAD_MM)
    return CLEARANCE_STIFFNESS * missing[:, None], derivative
