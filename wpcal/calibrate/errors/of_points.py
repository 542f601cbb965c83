r"""How errors of taught points become a small motion of the fitted part, by criterion.

For least squares and weighted fits the map G from errors to the motion is linear. The minimax fit is the least-squares
fit plus a motion that depends on the residuals only; that motion is simulated with a fixed seed. All motions are about
the centroid of the moved model points.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.prediction import EXCESS_GOAL, EXCESS_POINTS, EXCESS_SAMPLES, Sigma, TeachingError
from wpcal.calibrate.errors.robot_field import ResidualRows, foresee
from wpcal.calibrate.solve.interior_point import solve_interior_point
from wpcal.calibrate.solve.least_squares import kabsch
from wpcal.calibrate.solve.ties import break_ties
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import point_jacobian, translation_adjoint


def point_gain(p_base: FloatArray, information: FloatArray | None = None) -> FloatArray:
    """Map from errors of points to the motion of their least-squares fit: M⁻¹ Jᵢᵀ, or N⁻¹ Jᵢᵀ Λᵢ with weights Λᵢ.

    `p_base`: shape (n, 3). Moved model points, base frame, mm.
    `information`: shape (n, 3, 3). Inverse covariances of a weighted fit.
    Returns ndarray, shape (n, 6, 3).
    """
    J = point_jacobian(p_base - p_base.mean(axis=0))
    back = J.transpose(0, 2, 1) if information is None else J.transpose(0, 2, 1) @ information
    return np.asarray(np.linalg.inv(np.einsum("nij,njk->ik", back, J)) @ back)


def gained_covariance(gain: FloatArray, covariances: FloatArray | None = None) -> FloatArray:
    """Covariance of the motion by independent errors: Σ Gᵢ Cᵢ Gᵢᵀ; of unit errors if no covariances are given.

    `gain`: shape (n, 6, 3). `covariances`: shape (n, 3, 3). mm².
    """
    spread = gain if covariances is None else gain @ covariances
    return np.asarray(np.einsum("nij,nkj->ik", spread, gain))


def isotropic_covariance(p_base: FloatArray, sigma_mm: float) -> FloatArray:
    """Covariance of ξ for the least-squares fit of points that are all off by `sigma_mm` per axis.

    `p_base`: shape (n, 3). Moved model points, base frame, mm.
    Returns ndarray, shape (6, 6). About the base's origin: rad², rad·mm, mm².
    """
    to_origin = translation_adjoint(p_base.mean(axis=0))
    return np.asarray(sigma_mm**2 * (to_origin @ gained_covariance(point_gain(p_base)) @ to_origin.T))


def minimax_excess(p_base: FloatArray, sigma_mm: float, *, bounded: bool = False, seed: int = 0) -> FloatArray:
    """What the motion from least squares to minimax adds to the covariance, per square of the error.

    For Gaussian errors the least-squares motion and the residuals are independent, so that the covariance is that of
    least squares plus that of the further motion to the minimax fit. For bounded errors their product is added.

    `p_base`: shape (m, n, 3). m sets of moved model points, base frame, mm.
    `sigma_mm`: Standard deviation per axis at which the fits are simulated, mm.
    Returns ndarray, shape (m, 6, 6).
    """
    excess = np.zeros((len(p_base), 6, 6))
    if sigma_mm == 0:
        return excess
    rng = np.random.default_rng(seed)
    n = p_base.shape[1]
    used = p_base if n <= EXCESS_POINTS else p_base[:, rng.choice(n, EXCESS_POINTS, replace=False)]
    shape = (EXCESS_SAMPLES, *used.shape[1:])
    unit = rng.uniform(-math.sqrt(3.0), math.sqrt(3.0), shape) if bounded else rng.standard_normal(shape)
    motions = _simulated_motions(used - used.mean(axis=1)[:, None], sigma_mm * unit)
    for row, (first, further) in enumerate(zip(*motions, strict=True)):
        excess[row] = further.T @ further
        if bounded:
            excess[row] += first.T @ further + further.T @ first
    return np.asarray(excess / (EXCESS_SAMPLES * sigma_mm**2))


def budget_of_design(
    p_base: FloatArray, teaching: TeachingError, *, with_minimax: bool = False, seed: int = 0
) -> ErrorBudget:
    """Budget of points before they are touched, shape (n, 3), mm, for least squares or for minimax."""
    gain, sigma = point_gain(p_base), Sigma.expected(teaching.per_axis_mm)
    about, excess = p_base - p_base.mean(axis=0), None
    rows = ResidualRows.of(about, point_jacobian(about), np.zeros_like(p_base), np.tile(np.eye(3), (len(p_base), 1, 1)))
    belief = foresee(rows, sigma.mm, teaching.robot)
    if with_minimax:
        excess = minimax_excess(p_base[None], sigma.mm, bounded=teaching.is_bounded, seed=seed)[0]
    touching = gained_covariance(gain)
    return replace(ErrorBudget.of(p_base, gain, touching, belief, sigma, excess=excess), tool_mm=teaching.tool_mm)


def unequal_minimax_covariance(p_base: FloatArray, covariances: FloatArray, *, seed: int = 0) -> FloatArray:
    """Covariance of the motion of the minimax fit of points whose errors are unequal, from simulated fits.

    Its two parts are then not independent, so their sum is simulated; the scale is good to 5 %.

    Returns ndarray, shape (6, 6).

    `p_base`: shape (n, 3). Moved model points, base frame, mm. Of more than `EXCESS_POINTS` only that many are used,
    which overstates.
    `covariances`: shape (n, 3, 3). Of the taught points, mm².
    """
    rng = np.random.default_rng(seed)
    n = len(p_base)
    rows = np.arange(n) if n <= EXCESS_POINTS else rng.choice(n, EXCESS_POINTS, replace=False)
    used, factors = p_base[rows], np.linalg.cholesky(covariances[rows])
    errors = np.einsum("nij,mnj->mni", factors, rng.standard_normal((EXCESS_SAMPLES, *used.shape)))
    total = np.add(*_simulated_motions((used - used.mean(axis=0))[None], errors))[0]
    return np.asarray(total.T @ total / len(total))


def _simulated_motions(p: FloatArray, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least-squares motions of points (m, n, 3) with errors (k, n, 3), and the further motions to the minimax fit.

    Shapes (m, k, 6). The fits of all sets run as one batch.
    """
    sets, n = p.shape[:2]
    q = (p[:, None] + errors).reshape(-1, n, 3)
    source = np.broadcast_to(p[:, None], (sets, *errors.shape)).reshape(-1, n, 3)
    R, t = kabsch(source, q, np.full(q.shape[:2], 1.0 / n))
    state = solve_interior_point(source, q, R, t, goal=EXCESS_GOAL)
    first = np.hstack([_small_rotation(R), t])
    R, t = break_ties(source, q, state.R, state.t, state.weights)
    further = np.hstack([_small_rotation(R), t]) - first
    return first.reshape(sets, -1, 6), further.reshape(sets, -1, 6)


def _small_rotation(R: FloatArray) -> FloatArray:
    """Rotation vectors of small rotations, shape (m, 3)."""
    return 0.5 * np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1)
