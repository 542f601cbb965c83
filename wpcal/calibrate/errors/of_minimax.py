r"""What a minimax fit adds to the covariance of least squares, from simulated fits of points or touches.

The minimax fit is that of least squares plus a motion that depends on the residuals only: for Gaussian errors of equal
size their covariances add. The fits are those of the linear model, with a fixed seed (`wpcal.optim.least_largest`).
"""

from __future__ import annotations

import math

import numpy as np

from wpcal.calibrate.errors.prediction import EXCESS_GOAL, EXCESS_POINTS, EXCESS_SAMPLES, symmetric_root
from wpcal.core.arrays import FloatArray
from wpcal.optim.least_largest import least_largest

MOST_ROWS = 20_000  #: Observations of all samples that are solved at once: a few megabytes.


def minimax_excess(J: FloatArray, A: FloatArray, *, bounded: bool = False, seed: int = 0) -> FloatArray:
    """What the motion from least squares to minimax adds to the covariance of unit errors, shape (6, 6).

    `J`: shape (n, 3, 6). Derivative of the residuals by comparable coordinates of the motion, projected by A.
    `A`: shape (n, 3, 3). Projectors on what each observation sees.
    `bounded`: Whether the errors are evenly distributed: their product with the further motion is then added.
    """
    rng = np.random.default_rng(seed)
    J, A = _fewer(J, A, rng)
    shape = (EXCESS_SAMPLES, len(J), 3)
    errors = rng.uniform(-math.sqrt(3.0), math.sqrt(3.0), shape) if bounded else rng.standard_normal(shape)
    first, motions = _simulated(J, A, errors)
    further = motions - first
    excess = further.T @ further
    if bounded:
        excess += first.T @ further + further.T @ first
    return np.asarray(excess / EXCESS_SAMPLES)


def minimax_of_stated(J: FloatArray, A: FloatArray, own: FloatArray, shared: FloatArray, *, seed: int) -> FloatArray:
    """Covariance of the motion of minimax where every observation states its error, shape (6, 6).

    `J`, `A`: As in `minimax_excess`. `own`: shape (n, 3, 3). Covariances of the observations' own errors, mm².
    `shared`: shape (n, 3, s). What each sees of one standard deviation of s errors that all share.
    """
    rng = np.random.default_rng(seed)
    J, A, own, shared = _fewer(J, A, rng, own, shared)
    errors = np.einsum("nij,mnj->mni", symmetric_root(own), rng.standard_normal((EXCESS_SAMPLES, len(J), 3)))
    errors += np.einsum("nis,ms->mni", shared, rng.standard_normal((EXCESS_SAMPLES, shared.shape[2])))
    _, motions = _simulated(J, A, errors)
    return np.asarray(motions.T @ motions / EXCESS_SAMPLES)


def _fewer(J: FloatArray, A: FloatArray, rng: np.random.Generator, *more: FloatArray) -> tuple[FloatArray, ...]:
    """Return `EXCESS_POINTS` observations where all see three numbers: fewer overstate. Others are all needed."""
    if len(J) <= EXCESS_POINTS or not (np.einsum("nii->n", A) > 2.5).all():
        return (J, A, *more)
    used = rng.choice(len(J), EXCESS_POINTS, replace=False)
    return tuple(each[used] for each in (J, A, *more))


def _simulated(J: FloatArray, A: FloatArray, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Scaled motions by least squares and by minimax of errors (m, n, 3), shapes (m, 6)."""
    m, n = errors.shape[:2]
    residuals = np.ascontiguousarray((errors.swapaxes(0, 1) @ A).swapaxes(0, 1))
    flat = J.reshape(3 * n, 6)
    first = -np.linalg.solve(flat.T @ flat, flat.T @ residuals.reshape(m, 3 * n).T).T
    left = residuals + (first @ flat.T).reshape(m, n, 3)
    further = np.empty_like(first)
    block = max(MOST_ROWS // n, 1)
    for k in range(0, m, block):
        part = left[k : k + block]
        further[k : k + block] = least_largest(part, J, goal=EXCESS_GOAL)[0]
    return np.asarray(first), np.asarray(first + further)
