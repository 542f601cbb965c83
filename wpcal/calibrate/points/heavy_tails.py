r"""Residuals with heavier tails than Gaussian errors have, and what they do to the minimax fit.

The covariance of the minimax fit is that of Gaussian or bounded errors. The minimax fit follows the worst points, so
that its error is much larger with heavier tails. Its distance from the least-squares fit is known, however, and the
error of least squares hardly depends on the shape: with :math:`\delta` the motion from least squares to minimax,
:math:`C + \delta \delta^\top` covers the error whatever the shape.
"""

from __future__ import annotations

import numpy as np

from wpcal.calibrate.points.covariance import EXCESS_POINTS
from wpcal.calibrate.points.least_squares import kabsch
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import log_rotation, point_jacobian
from wpcal.core.transform import RigidTransform

SHAPE_FALSE_ALARM = 0.05
"""Probability that Gaussian errors are called heavy-tailed. A false alarm only widens the predicted error."""

SHAPE_SAMPLES = 1000
"""Simulated fits behind the critical value of the test."""

ROUND_OFF = 1e-12
"""Residuals below this share of the size of the points are round-off."""

LEAST_POINTS = 4
"""The residuals of three points lie in their plane and have hardly a shape."""


def has_heavy_tails(p_part: FloatArray, p_base: FloatArray) -> bool:
    """Test whether least-squares residuals have heavier tails than those of Gaussian errors of equal size.

    The statistic is n Σ d⁴ / (Σ d²)², the kurtosis of the residual lengths. Its critical value is simulated for these
    points with a fixed seed.

    Parameters
    ----------
    p_part, p_base : ndarray, shape (n, 3)
        Points of the model and as taught, mm.

    Returns
    -------
    bool
    """
    n = len(p_part)
    if n < LEAST_POINTS:
        return False
    R, t = kabsch(p_part, p_base, np.full(n, 1.0 / n))
    residuals = p_base - p_part @ R.T - t
    size = float(np.abs(p_base - p_base.mean(axis=0)).max())
    if float(np.abs(residuals).max()) <= ROUND_OFF * size:
        return False
    rng = np.random.default_rng(0)
    used = p_part if n <= EXCESS_POINTS else p_part[rng.choice(n, EXCESS_POINTS, replace=False)]
    J = point_jacobian((used - used.mean(axis=0)) / size).reshape(-1, 6)
    errors = rng.standard_normal((SHAPE_SAMPLES, len(J)))
    Q = np.linalg.qr(J)[0]
    simulated = _kurtosis((errors - errors @ Q @ Q.T).reshape(SHAPE_SAMPLES, -1, 3))
    return bool(_kurtosis(residuals[None])[0] > np.quantile(simulated, 1.0 - SHAPE_FALSE_ALARM))


def motion_square(first: RigidTransform, second: RigidTransform) -> FloatArray:
    """Square δ δᵀ of the small motion from one pose of the part to another, about the base's origin, shape (6, 6)."""
    between = second @ first.inverse()
    xi = np.concatenate([log_rotation(between.R), between.t_mm])
    return np.outer(xi, xi)


def _kurtosis(residuals: FloatArray) -> FloatArray:
    squares = np.sum(residuals**2, axis=2)
    return np.asarray(squares.shape[1] * np.sum(squares**2, axis=1) / np.sum(squares, axis=1) ** 2)
