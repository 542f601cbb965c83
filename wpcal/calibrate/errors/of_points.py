r"""How errors of taught points become a small motion of the fitted part, by criterion.

For least squares and weighted fits the map G from errors to the motion is linear; what minimax adds is simulated. All
motions are about the centroid of the moved model points.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.of_minimax import minimax_excess
from wpcal.calibrate.errors.prediction import Sigma, TeachingError
from wpcal.calibrate.errors.robot_field import ResidualRows, foresee
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


def scaled_points(p_base: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how points, shape (n, 3), constrain a fit: J and A of `minimax_excess`, and the scale of its motion."""
    about = p_base - p_base.mean(axis=0)
    scale = 1.0 / np.repeat([max(float(np.abs(about).max()), 1e-300), 1.0], 3)
    return -point_jacobian(about) * scale, np.broadcast_to(np.eye(3), (len(about), 3, 3)), scale


def points_excess(p_base: FloatArray, *, bounded: bool = False, seed: int = 0) -> FloatArray:
    """What minimax adds to the covariance of the motion of points, shape (n, 3), mm, by unit errors; shape (6, 6)."""
    J, A, scale = scaled_points(p_base)
    return np.asarray(scale[:, None] * minimax_excess(J, A, bounded=bounded, seed=seed) * scale)


def budget_of_design(
    p_base: FloatArray, teaching: TeachingError, *, with_minimax: bool = False, seed: int = 0
) -> ErrorBudget:
    """Budget of points before they are touched, shape (n, 3), mm, for least squares or for minimax."""
    gain, sigma = point_gain(p_base), Sigma.expected(teaching.per_axis_mm)
    about, excess = p_base - p_base.mean(axis=0), None
    rows = ResidualRows.of(about, point_jacobian(about), np.zeros_like(p_base), np.tile(np.eye(3), (len(p_base), 1, 1)))
    belief = foresee(rows, sigma.mm, teaching.robot)
    if with_minimax:
        excess = points_excess(p_base, bounded=teaching.is_bounded, seed=seed)
    touching = gained_covariance(gain)
    return replace(ErrorBudget.of(p_base, gain, touching, belief, sigma, excess=excess), tool_mm=teaching.tool_mm)
