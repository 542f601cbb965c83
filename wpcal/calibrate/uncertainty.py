r"""From the error of a taught point to the error of a weld.

A taught point is off by a small random vector. The fit turns these into a small motion
:math:`\xi = (\omega, v)` of the part (`wpcal.core.tangent`: rotation first, about the base's origin), and a point
:math:`p` of the part is then off by :math:`\omega \times p + v`.

For least squares the map is linear. The minimax fit is the least-squares fit plus a motion that depends on the
residuals only; that motion is simulated with a fixed seed. Where the points state unequal errors, the errors along the
weld follow from these, whatever the criterion makes small.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtri, fdtri

from wpcal.calibrate.points.interior_point import solve_interior_point
from wpcal.calibrate.points.least_squares import kabsch
from wpcal.calibrate.points.tie_break import break_ties
from wpcal.core.arrays import FloatArray, as_points, frozen
from wpcal.core.errors import InputError
from wpcal.core.tangent import point_jacobian, translation_adjoint

USUAL_SIGMA_MM = 0.3
"""Teaching error per axis where none is stated: a careful touch with a worn wire tip."""
COVERAGE = 0.95
"""Share of the errors that the predicted error is meant to hold."""

EXCESS_SAMPLES = 256
"""Simulated fits behind the part of the minimax covariance that has no closed form: its scale is then good to 5 %."""

EXCESS_GOAL = 1e-8
"""Scaled optimality error of a simulated fit: far below the sampling error."""

EXCESS_POINTS = 512
"""Larger clouds simulate that part on this many of their points; more points only make it smaller."""

POSTURE_FACTOR = math.sqrt(2.0)
"""A bias fixed in the tool moves by 2 sin(angle / 2) times its length when the wrist turns: √2 for a quarter turn."""


@dataclass(frozen=True, slots=True)
class TeachingError:
    """What is known of the error of a taught point, per axis of the base.

    Parameters
    ----------
    sigma_mm : float, optional
        Standard deviation per axis, Gaussian.
    bound_mm : float, optional
        Every axis is off by at most this, evenly spread. One of the two, or none: the residuals then tell.
    tcp_bias_mm : float
        Length of an error of the tool centre point, the same in every taught point. It leaves no residual while the
        torch keeps its posture.

    Raises
    ------
    InputError
        When both are given, or one is negative or not finite.
    """

    sigma_mm: float | None = None
    bound_mm: float | None = None
    tcp_bias_mm: float = 0.0

    def __post_init__(self) -> None:
        for name in ("sigma_mm", "bound_mm", "tcp_bias_mm"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value >= 0):
                raise InputError(f"teaching error: {name} is a length that is not negative, got {value}")
        if self.sigma_mm is not None and self.bound_mm is not None:
            raise InputError("teaching error: give sigma_mm or bound_mm, not both")

    @property
    def per_axis_mm(self) -> float | None:
        """Standard deviation per axis, mm; that of an even spread is bound / √3."""
        return self.bound_mm / math.sqrt(3.0) if self.bound_mm is not None else self.sigma_mm

    @property
    def is_bounded(self) -> bool:
        """Whether the error is evenly spread within a bound."""
        return self.bound_mm is not None


def residual_sigma(residuals_mm: FloatArray) -> tuple[float, int]:
    """Estimate the error per axis from least-squares residuals.

    Parameters
    ----------
    residuals_mm : ndarray, shape (n, 3)

    Returns
    -------
    sigma_mm : float
        √(Σ d² / (3 n - 6)): six of the 3 n numbers went into the fit.
    degrees_of_freedom : int
        3 n - 6. For n = 3 these are the three side lengths: nothing normal to the plane of the points is seen.
    """
    freedom = residuals_mm.size - 6
    return float(np.sqrt(np.sum(residuals_mm**2) / freedom)), freedom


def isotropic_covariance(p_base: FloatArray, sigma_mm: float) -> FloatArray:
    """Covariance of ξ for the least-squares fit of points that are all off by `sigma_mm` per axis; shape (6, 6).

    About the centroid the information is the inertia of the points and n, without a cross term.
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

    Parameters
    ----------
    p_base : ndarray, shape (n, 3)
        Moved model points, base frame, mm.
    covariances : ndarray, shape (n, 3, 3)
        Of the taught points, mm².

    Returns
    -------
    ndarray, shape (6, 6)
        About the base's origin: rad², rad·mm, mm².
    """
    J = point_jacobian(p_base - p_base.mean(axis=0))
    information = np.einsum("nik,nij,njl->kl", J, np.linalg.inv(covariances), J)
    to_origin = translation_adjoint(p_base.mean(axis=0))
    return np.asarray(to_origin @ np.linalg.inv(information) @ to_origin.T)


def propagated_covariance(p_base: FloatArray, covariances: FloatArray) -> FloatArray:
    """Covariance of ξ for the least-squares fit of points whose errors are unequal.

    With M = Σ Jᵢᵀ Jᵢ it is M⁻¹ (Σ Jᵢᵀ Cᵢ Jᵢ) M⁻¹; that of `isotropic_covariance` where all Cᵢ are σ² I.

    Parameters
    ----------
    p_base : ndarray, shape (n, 3)
        Moved model points, base frame, mm.
    covariances : ndarray, shape (n, 3, 3)
        Of the taught points, mm².

    Returns
    -------
    ndarray, shape (6, 6)
        About the base's origin: rad², rad·mm, mm².
    """
    J = point_jacobian(p_base - p_base.mean(axis=0))
    change = translation_adjoint(p_base.mean(axis=0)) @ np.linalg.inv(np.einsum("nik,nil->kl", J, J))
    return np.asarray(change @ np.einsum("nik,nij,njl->kl", J, covariances, J) @ change.T)


def minimax_covariance(p_base: FloatArray, sigma_mm: float, *, bounded: bool = False, seed: int = 0) -> FloatArray:
    """Covariance of ξ for the minimax fit of points that are off by `sigma_mm` per axis.

    For Gaussian errors the least-squares motion and the residuals are independent, so that the covariance is that of
    least squares plus that of the further motion to the minimax fit. For bounded errors their product is added.

    Parameters
    ----------
    p_base : ndarray, shape (n, 3)
        Moved model points, base frame, mm.
    sigma_mm : float
        Standard deviation per axis, mm.
    bounded : bool
        Errors evenly spread within √3 sigma instead of Gaussian ones.
    seed : int
        Of the simulated errors.

    Returns
    -------
    ndarray, shape (6, 6)
        About the base's origin: rad², rad·mm, mm².
    """
    linear = isotropic_covariance(p_base, sigma_mm)
    if sigma_mm == 0:
        return linear
    rng = np.random.default_rng(seed)
    used = p_base if len(p_base) <= EXCESS_POINTS else p_base[rng.choice(len(p_base), EXCESS_POINTS, replace=False)]
    shape = (EXCESS_SAMPLES, *used.shape)
    unit = rng.uniform(-math.sqrt(3.0), math.sqrt(3.0), shape) if bounded else rng.standard_normal(shape)
    first, further = _simulated_motions(used - used.mean(axis=0), sigma_mm * unit)
    excess = further.T @ further
    if bounded:
        excess += first.T @ further + further.T @ first
    to_origin = translation_adjoint(used.mean(axis=0))
    return np.asarray(linear + to_origin @ (excess / len(further)) @ to_origin.T)


def unequal_minimax_covariance(p_base: FloatArray, covariances: FloatArray, *, seed: int = 0) -> FloatArray:
    """Covariance of ξ for the minimax fit of points whose errors are unequal, from simulated fits.

    Its two parts are then not independent, so their sum is simulated; the scale is good to 5 %.

    Parameters
    ----------
    p_base : ndarray, shape (n, 3)
        Moved model points, base frame, mm. Of more than `EXCESS_POINTS` so many are used, which overstates.
    covariances : ndarray, shape (n, 3, 3)
        Of the taught points, mm².
    seed : int
        Of the simulated errors.

    Returns
    -------
    ndarray, shape (6, 6)
        About the base's origin: rad², rad·mm, mm².
    """
    rng = np.random.default_rng(seed)
    n = len(p_base)
    rows = np.arange(n) if n <= EXCESS_POINTS else rng.choice(n, EXCESS_POINTS, replace=False)
    used, factors = p_base[rows], np.linalg.cholesky(covariances[rows])
    errors = np.einsum("nij,mnj->mni", factors, rng.standard_normal((EXCESS_SAMPLES, *used.shape)))
    total = np.add(*_simulated_motions(used - used.mean(axis=0), errors))
    to_origin = translation_adjoint(used.mean(axis=0))
    return np.asarray(to_origin @ (total.T @ total / len(total)) @ to_origin.T)


def error_95(points_base: ArrayLike, covariance: FloatArray, *, degrees_of_freedom: float = math.inf) -> FloatArray:
    """Length that the error of a point stays below with 95 % probability.

    The squared length of a Gaussian vector with covariance C is close to tr C · F(m, ν) with
    m = (tr C)² / tr C² (Satterthwaite), ν the degrees of freedom behind the scale of C.

    Parameters
    ----------
    points_base : array_like, shape (k, 3)
        Base frame, mm.
    covariance : ndarray, shape (6, 6)
        Of ξ, about the base's origin.
    degrees_of_freedom : float
        Infinite where the teaching error is stated.

    Returns
    -------
    ndarray, shape (k,)
        mm.
    """
    J = point_jacobian(as_points(points_base, name="points"))
    C = J @ covariance @ J.transpose(0, 2, 1)
    trace = np.trace(C, axis1=1, axis2=2)
    square = np.einsum("kij,kij->k", C, C)
    m = np.divide(trace**2, square, out=np.ones_like(trace), where=square > 0)
    if math.isinf(degrees_of_freedom):
        quantile = chdtri(m, 1.0 - COVERAGE) / m
    else:
        quantile = fdtri(m, degrees_of_freedom, COVERAGE)
    return frozen(np.sqrt(np.maximum(trace, 0.0) * quantile))


def _simulated_motions(p: FloatArray, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least-squares motions of errors (m, n, 3), and the further motions to the minimax fit; shapes (m, 6)."""
    q = p + errors
    source = np.broadcast_to(p, errors.shape)
    R, t = kabsch(source, q, np.full(errors.shape[:2], 1.0 / len(p)))
    state = solve_interior_point(source, q, R, t, goal=EXCESS_GOAL)
    first = np.hstack([_small_rotation(R), t])
    R, t = break_ties(source, q, state.R, state.t, state.weights)
    return first, np.hstack([_small_rotation(R), t]) - first


def _small_rotation(R: FloatArray) -> FloatArray:
    """Rotation vectors of small rotations, shape (m, 3)."""
    return 0.5 * np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1)
