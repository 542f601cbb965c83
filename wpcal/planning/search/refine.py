"""Weighted least squares on whole paths: all points move at once, with exact derivatives through both inverses.

The weighted sum of the squared objectives is minimised over the nine coordinates of every point. Only neighbouring
points share a residual (the joint steps), so the normal equations are banded and one step of Levenberg-Marquardt costs
about as much as the inverse kinematics of the path. Limits and clearance enter as squares of the excess over them.
Which limits count is decided again in every step, by the state after it. The loop is `wpcal.planning.plan.banded`.

Also here: the least-squares problem around a path: residuals, excess over its limits, and all derivatives.

Angles are in degrees and lengths in millimetres here, so that one unit of each has a similar effect.
"""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import product
from wpcal.planning.cell.clearance import capsule_clearance
from wpcal.planning.cell.closed_chain import COORDINATES, PLACE, joint_slopes, joints_along
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.cell.workplace import LEAST_REGULARITY, regularity
from wpcal.planning.plan.banded import LinearModel, descend
from wpcal.planning.search.objectives import ATTITUDE, Weights, deviation_weights, deviations, joint_step_weight
from wpcal.planning.search.problem import CandidatePath, PlanningProblem

KEEP_OFF_DEG = 0.5
"""Limits count from this far inside, so that a path that a squared penalty holds back stays within them."""
KEEP_CLEAR_MM = 3.0  #: The same margin for clearances: about a tenth of the usual safety distance.
LOOK_AHEAD_MM = 30.0
"""The derivative of a clearance is computed below the safety distance plus this: a step rarely moves a body farther."""
STIFFNESS = 0.1
"""Weight of a degree beyond a limit. The objectives sum up to about 0.1 (deg/mm)², so that half a degree beyond a limit
(`KEEP_OFF_DEG`) at many points costs more."""
MM_PER_DEG = 10.0  #: This distance outside the weld zone counts like one degree: at arm's length it is half a degree.
CLEARANCE_STIFFNESS = 0.2 * STIFFNESS
"""Weight of a missing millimetre: at arm's length five millimetres are a third of a degree."""
GRADIENT_STEP_RAD = 1e-6
"""Step of the difference quotients of clearances: 1e-3 mm at arm's length, far above round-off and below a radius."""


def linearise(
    problem: PlanningProblem, path: CandidatePath, weights: Weights, *, stiffness: float = 1.0
) -> LinearModel:
    """Return the least-squares problem around a path."""
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
    low, high = problem.cell.limits
    return _two_sided(np.degrees(path.joints), np.degrees(low), np.degrees(high), slopes)


def _regular_limits(problem: PlanningProblem, path: CandidatePath, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Poses too near to a singular pose, as the missing degrees of bend; (n, 6), (n, 6, 9)."""
    values, derivatives = [], []
    for arm, columns in ((problem.cell.arm, slice(0, JOINTS)), (problem.cell.arm2, slice(JOINTS, None))):
        measure, slope = regularity(arm, path.joints[:, columns])
        values.append(STIFFNESS * (np.degrees(LEAST_REGULARITY - measure) + KEEP_OFF_DEG))
        derivatives.append(-STIFFNESS * product(slope, slopes[:, columns]))
    return np.concatenate(values, axis=1), np.concatenate(derivatives, axis=1)


def _clearance_limits(
    problem: PlanningProblem, path: CandidatePath, slopes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Missing clearance; (n, 1), (n, 1, 9). Its derivative is a difference quotient over joints, where it is small."""
    margin = capsule_clearance(problem.cell, path.joints).margin_mm
    derivative = np.zeros((len(margin), 1, COORDINATES))
    rows = np.flatnonzero(margin < LOOK_AHEAD_MM)
    if len(rows):
        nudged = path.joints[rows, None] + GRADIENT_STEP_RAD * np.eye(2 * JOINTS)
        near = capsule_clearance(problem.cell, nudged.reshape(-1, 2 * JOINTS)).margin_mm.reshape(len(rows), -1)
        slope = (near - margin[rows, None]) / GRADIENT_STEP_RAD
        derivative[rows, 0] = -CLEARANCE_STIFFNESS * np.einsum("nj,njk->nk", slope, np.radians(slopes[rows]))
    missing = np.where(np.isfinite(margin), KEEP_CLEAR_MM - margin, -LOOK_AHEAD_MM)
    return CLEARANCE_STIFFNESS * missing[:, None], derivative


STIFFNESSES = (1.0, 10.0, 100.0)
"""Of limits, one after the other. Stiff limits make short steps. They are needed only where a limit opposes a heavy
objective, for example where the target weld position is not clear."""


def refine_within_limits(problem: PlanningProblem, path: CandidatePath, weights: Weights) -> CandidatePath:
    """Refine a path with stiffer and stiffer limits until it keeps them, or the stiffest do not help."""
    for stiffness in STIFFNESSES:
        path = refine_path(problem, path, weights, stiffness=stiffness)
        if problem.is_allowed(path):
            break
    return path


def refine_path(
    problem: PlanningProblem, path: CandidatePath, weights: Weights, *, stiffness: float = 1.0, iterations: int = 80
) -> CandidatePath:
    """Minimise the weighted sum of squared objectives, starting from a path. Never with a larger sum than the start."""
    return descend(
        path,
        lambda at: linearise(problem, at, weights, stiffness=stiffness),
        lambda at, step: _moved(problem, at, step),
        iterations=iterations,
    )


def _moved(problem: PlanningProblem, path: CandidatePath, step: FloatArray) -> CandidatePath | None:
    """Return the path after a step, clipped to the ranges; None where it leaves the reach."""
    coordinates = np.clip(path.coordinates + step, *problem.box)
    joints = joints_along(problem.cell, problem.path, coordinates, path.branches, path.joints[0])
    return CandidatePath(coordinates, path.branches, joints) if np.isfinite(joints).all() else None
