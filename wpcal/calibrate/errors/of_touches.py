r"""The covariance of a fit of touches.

A touch is off by a random vector :math:`\delta_i`; its residual sees :math:`A_i \delta_i`. With
:math:`d = A(\delta - J\xi)` linear and :math:`M = \sum J_i^\top A_i J_i`, least squares has
:math:`C = M^{-1} (\sum J_i^\top A_i C_i A_i J_i) M^{-1}`, which is :math:`\sigma^2 M^{-1}` for equal errors. An
error :math:`u_i` that all touches share, such as that of the stick-out, adds :math:`g g^\top` with
:math:`g = M^{-1} \sum J_i^\top A_i u_i`. The weighted fit has its weights in place of :math:`A_i`. The further motion
of the minimax fit is simulated on the linear model with a fixed seed, all samples at once
(`wpcal.optim.least_largest`).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.prediction import EXCESS_GOAL, EXCESS_SAMPLES, Sigma, TeachingError
from wpcal.calibrate.errors.robot_field import Belief, ResidualRows
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.solve.touches import Pose, fit_squares, scaled_jacobian
from wpcal.calibrate.trust.criteria import Criterion
from wpcal.core.arrays import FloatArray
from wpcal.optim.least_largest import least_largest

MOST_ROWS = 20_000  #: Touches of all samples that are solved at once: a few megabytes.


def budget_of_touches(
    touches: Touches, pose: Pose, criterion: Criterion, teaching: TeachingError, *, seed: int = 0
) -> ErrorBudget:
    """Collect what the errors of touches do to the pose of a fit, and what is believed of these errors.

    The usual teaching error is assumed if nothing is stated and there are as many touches as freedoms.
    """
    J, _, length = scaled_jacobian(touches, pose)
    scale, covariances = 1.0 / np.repeat([length, 1.0], 3), touches.covariances
    weights = pose.at.information(covariances if criterion is Criterion.WEIGHTED else None)
    back = J.transpose(0, 2, 1) @ weights
    gain = scale[:, None] * (-np.linalg.inv(np.einsum("nij,njk->ik", back, J)) @ back)
    belief, sigma = _believed(touches, pose, teaching)
    excess = None
    if covariances is None:
        touching = np.einsum("nij,nkj->ik", gain, gain)
        if criterion is Criterion.MINIMAX and sigma.mm > 0:
            excess = scale[:, None] * _excess(J, pose, bounded=teaching.is_bounded, seed=seed) * scale
    else:
        shared = np.zeros((len(J), 3, 0)) if touches.shared is None else touches.shared
        own = covariances - shared @ shared.transpose(0, 2, 1)
        if criterion is Criterion.MINIMAX:
            touching = scale[:, None] * _minimax_of_stated(J, pose, own, shared, seed) * scale
        else:
            common = np.einsum("nij,njs->is", gain, shared)
            touching = np.einsum("nij,njl,nkl->ik", gain, own, gain) + common @ common.T
    return replace(
        ErrorBudget.of(touches.p_base, gain, touching, belief, sigma, excess=excess), tool_mm=teaching.tool_mm
    )


def _believed(touches: Touches, pose: Pose, teaching: TeachingError) -> tuple[Belief, Sigma]:
    """Weigh the residuals of least squares."""
    squares = fit_squares(touches, pose)
    J = scaled_jacobian(touches, squares)[0]
    information = squares.at.information(touches.covariances)
    about = touches.p_base - touches.p_base.mean(axis=0)
    return teaching.believed(ResidualRows.of(about, J, squares.at.d, information), touches.covariances)


def _minimax_of_stated(J: FloatArray, pose: Pose, own: FloatArray, shared: FloatArray, seed: int) -> FloatArray:
    """Covariance of the scaled motion of minimax where every touch states its error: the whole is simulated."""
    rng = np.random.default_rng(seed)
    errors = np.einsum("nij,mnj->mni", _root(own), rng.standard_normal((EXCESS_SAMPLES, len(J), 3)))
    errors += np.einsum("nis,ms->mni", shared, rng.standard_normal((EXCESS_SAMPLES, shared.shape[2])))
    _, motions = _simulated(J, pose, errors)
    return np.asarray(motions.T @ motions / EXCESS_SAMPLES)


def _root(covariances: FloatArray) -> FloatArray:
    """Return square roots of covariances (n, 3, 3), which may be singular."""
    values, vectors = np.linalg.eigh(covariances)
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]) @ vectors.swapaxes(1, 2))


def _excess(J: FloatArray, pose: Pose, *, bounded: bool, seed: int) -> FloatArray:
    """What the motion from least squares to minimax adds to the scaled covariance of unit errors, shape (6, 6)."""
    rng = np.random.default_rng(seed)
    shape = (EXCESS_SAMPLES, len(J), 3)
    errors = rng.uniform(-math.sqrt(3.0), math.sqrt(3.0), shape) if bounded else rng.standard_normal(shape)
    first, motions = _simulated(J, pose, errors)
    further = motions - first
    excess = further.T @ further
    if bounded:
        excess += first.T @ further + further.T @ first
    return np.asarray(excess / EXCESS_SAMPLES)


def _simulated(J: FloatArray, pose: Pose, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Scaled motions by least squares and by minimax of errors (m, n, 3), shapes (m, 6)."""
    m, n = errors.shape[:2]
    residuals = (pose.at.A @ errors[..., None])[..., 0]
    flat = J.reshape(3 * n, 6)
    first = -np.linalg.solve(flat.T @ flat, flat.T @ residuals.reshape(m, 3 * n).T).T
    left = residuals + (first @ flat.T).reshape(m, n, 3)
    further = np.empty_like(first)
    block = max(MOST_ROWS // n, 1)
    for k in range(0, m, block):
        part = left[k : k + block]
        further[k : k + block] = least_largest(part, np.broadcast_to(J, (len(part), n, 3, 6)), goal=EXCESS_GOAL)[0]
    return np.asarray(first), np.asarray(first + further)
