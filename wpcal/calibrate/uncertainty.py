r"""From the error of a taught point to the error of a weld.

A taught point is off by a small random vector. The fit turns these vectors into a small motion
:math:`\xi = (\omega, v)` of the part (`wpcal.core.tangent`: rotation first, about the base's origin). A point
:math:`p` of the part is then off by :math:`\omega \times p + v`. The covariance of :math:`\xi` is computed in
`wpcal.calibrate.points.covariance` and `wpcal.calibrate.touches.covariance`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtri, fdtri

from wpcal.core.arrays import FloatArray, as_points, frozen
from wpcal.core.errors import InputError
from wpcal.core.tangent import point_jacobian

USUAL_SIGMA_MM = 0.3
"""Teaching error per axis if none is stated: a careful touch with a worn wire tip."""
COVERAGE = 0.95
"""Share of the errors that stay below the predicted error."""

EXCESS_SAMPLES = 256
"""Simulated fits behind the part of the minimax covariance that has no closed form: its scale is then good to 5 %."""

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
        Every axis is off by at most this, evenly distributed. Give one of the two; with neither, the residuals decide.
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
        """Standard deviation per axis, mm; bound / √3 for an even distribution."""
        return self.bound_mm / math.sqrt(3.0) if self.bound_mm is not None else self.sigma_mm

    @property
    def is_bounded(self) -> bool:
        """Whether the error is evenly distributed within a bound."""
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
        Infinite if the teaching error is stated.

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
