r"""The covariance of the small motion ξ of a fitted part, by criterion, from the errors of the taught points.

For least squares the map from errors to ξ is linear. The minimax fit is the least-squares fit plus a motion that
depends on the residuals only. That motion is simulated with a fixed seed. If the points state unequal errors, the
covariance follows from these, whatever the criterion minimises.
"""

from __future__ import annotations

import math

import numpy as np

from wpcal.calibrate.errors.prediction import EXCESS_GOAL, EXCESS_POINTS, EXCESS_SAMPLES
from wpcal.calibrate.solve.interior_point import solve_interior_point
from wpcal.calibrate.solve.least_squares import kabsch
from wpcal.calibrate.solve.ties import break_ties
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import point_jacobian, translation_adjoint


def isotropic_covariance(p_base: FloatArray, sigma_mm: float) -> FloatArray:
    """Covariance of ξ for the least-squares fit of points that are all off by `sigma_mm` per axis.

    About the centroid the information is the inertia of the points and n, without a cross term.

    `p_base`: shape (n, 3). Moved model points, base frame, mm.
    `sigma_mm`: Standard deviation per axis, mm.
    Returns ndarray, shape (6, 6). About the base's origin: rad², rad·mm, mm².
    """
    offsets = p_base - p_base.mean(axis=0)
    moments = offsets.T @ offsets
    about_centroid = np.zeros((6, 6))
    about_centroid[:3, :3] = np.linalg.inv(np.trace(moments) * np.eye(3) - moments)
    about_centroid[3:, 3:] = np.eye(3) / len(p_base)
    to_origin = translation_adjoint(p_base.mean(axis=0))
    return np.asarray(sigma_mm**2 * (to_origin @ about_centroid @ to_origin.T))


def weighted_covariance(p_base: FloatArray, covariances: FloatArray) -> FloatArray:
    """Covariance of ξ for the fit weighted with the inverse covariances.

    `p_base`: shape (n, 3). Moved model points, base frame, mm.
    `covariances`: shape (n, 3, 3). Of the taught points, mm².
    Returns ndarray, shape (6, 6). About the base's origin: rad², rad·mm, mm².
    """
    J = point_jacobian(p_base - p_base.mean(axis=0))
    information = np.einsum("nik,nij,njl->kl", J, np.linalg.inv(covariances), J)
    to_origin = translation_adjoint(p_base.mean(axis=0))
    return np.asarray(to_origin @ np.linalg.inv(information) @ to_origin.T)


def propagated_covariance(p_base: FloatArray, covariances: FloatArray) -> FloatArray:
    """Covariance of ξ for the least-squares fit of points whose errors are unequal.

    With M = Σ Jᵢᵀ Jᵢ it is M⁻¹ (Σ Jᵢᵀ Cᵢ Jᵢ) M⁻¹; this is `isotropic_covariance` if all Cᵢ are σ² I.

    `p_base`: shape (n, 3). Moved model points, base frame, mm.
    `covariances`: shape (n, 3, 3). Of the taught points, mm².
    Returns ndarray, shape (6, 6). About the base's origin: rad², rad·mm, mm².
    """
    J = point_jacobian(p_base - p_base.mean(axis=0))
    change = translation_adjoint(p_base.mean(axis=0)) @ np.linalg.inv(np.einsum("nik,nil->kl", J, J))
    return np.asarray(change @ np.einsum("nik,nij,njl->kl", J, covariances, J) @ change.T)


def minimax_covariance(p_base: FloatArray, sigma_mm: float, *, bounded: bool = False, seed: int = 0) -> FloatArray:
    """Covariance of ξ for the minimax fit of points that are off by `sigma_mm` per axis.

    For Gaussian errors the least-squares motion and the residuals are independent, so that the covariance is that of
    least squares plus that of the further motion to the minimax fit. For bounded errors their product is added.

    `p_base`: shape (n, 3). Moved model points, base frame, mm.
    `sigma_mm`: Standard deviation per axis, mm.
    Returns ndarray, shape (6, 6). About the base's origin: rad², rad·mm, mm².
    """
    return np.asarray(minimax_covariances(p_base[None], sigma_mm, bounded=bounded, seed=seed)[0])


def minimax_covariances(p_base: FloatArray, sigma_mm: float, *, bounded: bool = False, seed: int = 0) -> FloatArray:
    """Covariances of ξ for the minimax fits of several sets of points; the rest as in `minimax_covariance`.

    `p_base`: shape (m, n, 3). m sets of moved model points, base frame, mm.
    Returns ndarray, shape (m, 6, 6). About the base's origin: rad², rad·mm, mm².
    """
    linear = np.array([isotropic_covariance(p, sigma_mm) for p in p_base])
    if sigma_mm == 0:
        return linear
    rng = np.random.default_rng(seed)
    n = p_base.shape[1]
    used = p_base if n <= EXCESS_POINTS else p_base[:, rng.choice(n, EXCESS_POINTS, replace=False)]
    shape = (EXCESS_SAMPLES, *used.shape[1:])
    unit = rng.uniform(-math.sqrt(3.0), math.sqrt(3.0), shape) if bounded else rng.standard_normal(shape)
    centres = used.mean(axis=1)
    motions = _simulated_motions(used - centres[:, None], sigma_mm * unit)
    for row, (centre, first, further) in enumerate(zip(centres, *motions, strict=True)):
        excess = further.T @ further
        if bounded:
            excess += first.T @ further + further.T @ first
        to_origin = translation_adjoint(centre)
        linear[row] += to_origin @ (excess / len(further)) @ to_origin.T
    return linear


def unequal_minimax_covariance(p_base: FloatArray, covariances: FloatArray, *, seed: int = 0) -> FloatArray:
    """Covariance of ξ for the minimax fit of points whose errors are unequal, from simulated fits.

    Its two parts are then not independent, so their sum is simulated; the scale is good to 5 %.

    Returns ndarray, shape (6, 6). About the base's origin: rad², rad·mm, mm².

    Parameters
    ----------
    p_base : ndarray, shape (n, 3)
        Moved model points, base frame, mm. Of more than `EXCESS_POINTS` only that many are used, which overstates.
    covariances : shape (n, 3, 3). Of the taught points, mm².
    """
    rng = np.random.default_rng(seed)
    n = len(p_base)
    rows = np.arange(n) if n <= EXCESS_POINTS else rng.choice(n, EXCESS_POINTS, replace=False)
    used, factors = p_base[rows], np.linalg.cholesky(covariances[rows])
    errors = np.einsum("nij,mnj->mni", factors, rng.standard_normal((EXCESS_SAMPLES, *used.shape)))
    total = np.add(*_simulated_motions((used - used.mean(axis=0))[None], errors))[0]
    to_origin = translation_adjoint(used.mean(axis=0))
    return np.asarray(to_origin @ (total.T @ total / len(total)) @ to_origin.T)


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
