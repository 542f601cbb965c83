r"""Residuals with heavier tails than Gaussian errors have, and what they do to the minimax fit.

The covariance of the minimax fit is that of Gaussian or bounded errors. The minimax fit follows the worst points, so
that its error is much larger with heavier tails. Its distance from the least-squares fit is known, however, and the
error of least squares hardly depends on the shape: with :math:`\delta` the motion from least squares to minimax,
:math:`C + \delta \delta^\top` covers the error whatever the shape.
"""

from __future__ import annotations

import numpy as np

from wpcal.calibrate.errors.prediction import EXCESS_POINTS
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import log_rotation
from wpcal.core.transform import RigidTransform

SHAPE_FALSE_ALARM = 0.05
"""Probability that Gaussian errors are called heavy-tailed. A false alarm only widens the predicted error."""
SHAPE_SAMPLES = 1000  #: Simulated fits behind the critical value of the test.
ROUND_OFF = 1e-12  #: Residuals below this share of the size of the points are round-off; the callers know that size.
LEAST_FREEDOM = 4
"""Numbers observed beyond the six of the pose. The residuals of three points lie in their plane and have no shape."""
UNSEEN = 1e-9  #: Share of the largest information below which a direction is not seen.


def has_heavy_tails(
    residuals: FloatArray, jacobians: FloatArray, information: FloatArray, *, round_off_mm: float
) -> bool:
    """Test whether least-squares residuals have heavier tails than those of Gaussian errors of the stated sizes.

    With s the squared residuals in units of their errors, the statistic is n Σ s² / (Σ s)². For points of equal error
    it is the kurtosis of the residual lengths. The critical value is simulated for these observations with a fixed
    seed.

    `residuals`: shape (n, 3). Of the least-squares fit with the weights `information`, mm.
    `jacobians`: shape (n, 3, 6). Derivatives of the residuals by comparable coordinates of the motion.
    `information`: shape (n, 3, 3). Inverse covariances of the residuals, up to one factor; zero in directions that an
    observation does not see.
    """
    n = len(residuals)
    values, vectors = np.linalg.eigh(information)
    is_seen = values > UNSEEN * values.max()
    if int(is_seen.sum()) - 6 < LEAST_FREEDOM or float(np.abs(residuals).max()) <= round_off_mm:
        return False
    roots = np.einsum("nij,nj,nkj->nik", vectors, np.sqrt(np.where(is_seen, values, 0.0)), vectors)
    seen = np.einsum("nij,nj,nkj->nik", vectors, is_seen.astype(np.float64), vectors)
    rng = np.random.default_rng(0)
    used = np.arange(n) if n <= EXCESS_POINTS else rng.choice(n, EXCESS_POINTS, replace=False)
    errors = rng.standard_normal((SHAPE_SAMPLES, len(used), 3))
    errors = (errors.swapaxes(0, 1) @ seen[used]).swapaxes(0, 1).reshape(SHAPE_SAMPLES, -1)
    Q = np.linalg.qr((roots[used] @ jacobians[used]).reshape(-1, 6))[0]
    simulated = _kurtosis((errors - errors @ Q @ Q.T).reshape(SHAPE_SAMPLES, -1, 3))
    found = _kurtosis(np.einsum("nij,nj->ni", roots, residuals)[None])[0]
    return bool(found > np.quantile(simulated, 1.0 - SHAPE_FALSE_ALARM))


def motion_square(first: RigidTransform, second: RigidTransform) -> FloatArray:
    """Square δ δᵀ of the small motion from one pose of the part to another, about the base's origin, shape (6, 6)."""
    between = second @ first.inverse()
    xi = np.concatenate([log_rotation(between.R), between.t_mm])
    return np.outer(xi, xi)


def _kurtosis(residuals: FloatArray) -> FloatArray:
    squares = np.einsum("mni,mni->mn", residuals, residuals)
    return np.asarray(squares.shape[1] * np.sum(squares**2, axis=1) / np.sum(squares, axis=1) ** 2)
