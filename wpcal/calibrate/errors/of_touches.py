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

import numpy as np

from wpcal.calibrate.errors.prediction import (
    EXCESS_GOAL,
    EXCESS_SAMPLES,
    Sigma,
    TeachingError,
)
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.solve.touches import Pose, fit_squares, scaled_jacobian
from wpcal.calibrate.trust.criteria import Criterion
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import translation_adjoint
from wpcal.optim.least_largest import least_largest

MOST_ROWS = 20_000  #: Touches of all samples that are solved at once: a few megabytes.


def propagate_covariance(
    touches: Touches, pose: Pose, criterion: Criterion, teaching: TeachingError, *, seed: int = 0
) -> tuple[FloatArray, Sigma]:
    """Propagate the errors of the touches to the covariance of a fit.

    Returns
    -------
    covariance : ndarray, shape (6, 6). Of ξ about the base's origin, as in `CalibrationResult`.
    sigma : Sigma
        The teaching error behind it. The usual one is assumed if nothing is stated and there are as many touches as
        freedoms.
    """
    J, pivot, length = scaled_jacobian(touches, pose)
    to_origin = translation_adjoint(pivot) / np.repeat([length, 1.0], 3)  # of (L ω, v)
    if touches.covariances is not None:
        shared = np.zeros((len(J), 3, 0)) if touches.shared is None else touches.shared
        scaled = _of_stated_errors(J, pose, touches.covariances, shared, criterion, seed)
        return to_origin @ scaled @ to_origin.T, Sigma.of_each(touches.covariances)
    sigma = _sigma(touches, pose, teaching)
    scaled = np.linalg.inv(np.einsum("nik,nil->kl", J, J))
    if criterion is Criterion.MINIMAX and sigma.mm > 0:
        scaled = scaled + _excess(J, pose, bounded=teaching.is_bounded, seed=seed)
    return sigma.mm**2 * to_origin @ scaled @ to_origin.T, sigma


def _of_stated_errors(
    J: FloatArray, pose: Pose, covariances: FloatArray, shared: FloatArray, criterion: Criterion, seed: int
) -> FloatArray:
    """Covariance of the scaled motion where every touch states its error, shape (6, 6)."""
    own = covariances - shared @ shared.swapaxes(1, 2)
    if criterion is Criterion.MINIMAX:  # its two parts are not independent then: the whole is simulated
        rng = np.random.default_rng(seed)
        errors = np.einsum("nij,mnj->mni", _root(own), rng.standard_normal((EXCESS_SAMPLES, len(J), 3)))
        errors += np.einsum("nis,ms->mni", shared, rng.standard_normal((EXCESS_SAMPLES, shared.shape[2])))
        _, motions = _simulated(J, pose, errors)
        return np.asarray(motions.T @ motions / EXCESS_SAMPLES)
    weights = pose.at.information(covariances if criterion is Criterion.WEIGHTED else None)
    WJ = weights @ J
    change = np.linalg.inv(np.einsum("nik,nil->kl", J, WJ))
    common = np.einsum("nik,nis->ks", WJ, shared)
    return np.asarray(change @ (np.einsum("nik,nij,njl->kl", WJ, own, WJ) + common @ common.T) @ change)


def _root(covariances: FloatArray) -> FloatArray:
    """Return square roots of covariances (n, 3, 3), which may be singular."""
    values, vectors = np.linalg.eigh(covariances)
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]) @ vectors.swapaxes(1, 2))


def _sigma(touches: Touches, pose: Pose, teaching: TeachingError) -> Sigma:
    """Teaching error per axis: stated, from the residuals of least squares, or assumed if there are none."""
    if teaching.per_axis_mm is not None:
        return Sigma.stated(teaching.per_axis_mm)
    freedom = int(pose.at.rank.sum()) - 6
    if freedom <= 0:  # no residual tells how well they were made
        return Sigma.expected(None)
    squares = fit_squares(touches, pose).at.d
    return Sigma.estimated(float(np.sqrt(np.sum(squares**2) / freedom)), freedom)


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
