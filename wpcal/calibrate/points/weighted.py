r"""The fit weighted with a covariance per taught point: least :math:`\sum_i r_i^\top \Sigma_i^{-1} r_i`."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wpcal.calibrate.points.least_squares import centred, fit_least_squares, rotation_maximising, weighted_rms
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import ConvergenceError, InputError
from wpcal.core.pairs import PointPairs
from wpcal.core.rotations import cross_matrix
from wpcal.core.tangent import exp_rotation, point_jacobian
from wpcal.core.transform import RigidTransform
from wpcal.optim.levenberg_marquardt import minimise_squares

MAX_STEPS = 100
"""Gauss-Newton steps converge in about 5; damped steps of odd data take more."""

FIRST_DAMPING = 1e-6
"""The least-squares fit is near the answer: the first step is almost that of Gauss and Newton."""

ROUND_OFF = 16 * float(np.finfo(np.float64).eps)
"""Share of the largest coordinate by which a computed residual may be off."""


def information_matrices(pairs: PointPairs) -> FloatArray:
    """Inverse covariances of the taught points, scaled so that their mean trace is 3 (equal errors give the identity).

    Raises
    ------
    InputError
        When the pairs carry no covariances, or one is not symmetric and positive definite.
    """
    if pairs.covariances is None:
        raise InputError("the weighted criterion needs a 3×3 covariance for every taught point")
    symmetric = np.abs(pairs.covariances - pairs.covariances.transpose(0, 2, 1)).max(axis=(1, 2))
    eigenvalues = np.linalg.eigvalsh(pairs.covariances)
    bad = (eigenvalues[:, 0] <= 0) | (symmetric > 1e-9 * eigenvalues[:, 2])
    if bad.any():
        name = pairs.names[int(np.argmax(bad))]
        raise InputError(f"point {name}: a covariance must be symmetric and positive definite")
    information = np.linalg.inv(pairs.covariances)
    return np.asarray(information * (3.0 * len(pairs) / np.trace(information, axis1=1, axis2=2).sum()))


def fit_weighted(pairs: PointPairs) -> RigidTransform:
    """Fit with the covariances of the pairs, by damped least squares from the fit without them.

    Parameters
    ----------
    pairs : PointPairs
        With covariances in the target frame, mm².

    Returns
    -------
    RigidTransform

    Raises
    ------
    InputError
        When there are no covariances or one is not positive definite.
    GeometryError
        When the points do not fix a rotation.
    ConvergenceError
        When the steps run out or none decreases the sum; carries the best fit.
    """
    problem = _WeightedSquares(pairs, information_matrices(pairs))
    start = fit_least_squares(pairs)
    off = ROUND_OFF * float(np.abs(pairs.p_target).max()) * math.sqrt(len(pairs))
    still = math.sqrt(
        off * (math.sqrt(problem.cost(start)) + off)
    )  # a shorter step is lost in the round-off of the sum
    found = minimise_squares(problem, start, still=still, most_steps=MAX_STEPS, first_damping=FIRST_DAMPING)
    if not found.converged:
        raise ConvergenceError(f"the weighted fit did not converge in {MAX_STEPS} steps", best=found.state)
    return found.state


def weighted_root_mean_square(pairs: PointPairs, T: RigidTransform) -> float:
    """Root of the mean of r W r, mm; the plain root mean square where all covariances are alike."""
    return float(np.sqrt(_weighted_sum(pairs, information_matrices(pairs), T) / len(pairs)))


def weighted_lower_bound(pairs: PointPairs) -> float:
    """Bound `weighted_root_mean_square` from below over all rigid transforms, mm.

    r W r ≥ λ |r|² with the least eigenvalue λ of W, and the least sum of λ |r|² has a closed form. The bound is met
    where every covariance is a multiple of the identity.
    """
    least = np.linalg.eigvalsh(information_matrices(pairs))[:, 0]
    bound = weighted_rms(centred(pairs.p_source), centred(pairs.p_target), least / least.sum())
    return float(bound * np.sqrt(least.sum() / len(pairs)))


def refine_once(
    p: FloatArray, q: FloatArray, information: FloatArray, R: FloatArray, t: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Take one Gauss-Newton step from a fit towards the least Σ r Λ r; any leading axes are a batch.

    Parameters
    ----------
    p, q : ndarray, shape (..., n, 3)
        mm.
    information : ndarray, shape (..., n, 3, 3)
        Λ, mm⁻².
    R, t : ndarray, shapes (..., 3, 3), (..., 3)
        The fits.

    Returns
    -------
    R, t : ndarray, shapes (..., 3, 3), (..., 3)
        The fits after the step.
    sums : ndarray, shape (...)
        Σ r Λ r after the step, as the linear model predicts it.
    """
    gradient, hessian, sums, centre = _normal_equations(p, q, information, R, t)
    step = np.einsum("...kl,...l->...k", np.linalg.pinv(hessian, hermitian=True), gradient)
    turn = rotation_maximising(np.eye(3) + cross_matrix(step[..., :3].reshape(-1, 3)).reshape(*step.shape[:-1], 3, 3))
    moved = np.einsum("...ij,...j->...i", turn, t - centre) + centre + step[..., 3:]
    return turn @ R, moved, np.asarray(sums - np.einsum("...k,...k->...", gradient, step))


def _normal_equations(
    p: FloatArray, q: FloatArray, information: FloatArray, R: FloatArray, t: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Jᵀ Λ r, Jᵀ Λ J and r Λ r of the small motion about the centroid of the moved points, and that centroid."""
    moved = p @ np.swapaxes(R, -1, -2) + t[..., None, :]
    centre = moved.mean(axis=-2)
    about = moved - centre[..., None, :]
    J, r = point_jacobian(about.reshape(-1, 3)).reshape(*about.shape, 6), q - moved
    Wr = np.einsum("...nij,...nj->...ni", information, r)
    gradient = np.einsum("...nik,...ni->...k", J, Wr)
    hessian = np.einsum("...nik,...nil->...kl", J, information @ J)
    return gradient, hessian, np.asarray(np.einsum("...ni,...ni->...", r, Wr)), centre


@dataclass(frozen=True, slots=True, eq=False)
class _WeightedSquares:
    """Σ r W r of the pairs as a `wpcal.optim.levenberg_marquardt.SquaresProblem` of rigid transforms."""

    pairs: PointPairs
    W: FloatArray

    def cost(self, T: RigidTransform) -> float:
        return _weighted_sum(self.pairs, self.W, T)

    def normal_equations(self, T: RigidTransform) -> tuple[FloatArray, FloatArray]:
        gradient, hessian, _, _ = _normal_equations(self.pairs.p_source, self.pairs.p_target, self.W, T.R, T.t_mm)
        return -gradient, hessian  # the model point moves towards the taught one

    def moved(self, T: RigidTransform, step: FloatArray) -> RigidTransform:
        turn, centre = exp_rotation(step[:3]), T.apply(self.pairs.p_source).mean(axis=0)
        return RigidTransform(turn @ T.R, turn @ (T.t_mm - centre) + centre + step[3:], T.target, T.source)


def _weighted_sum(pairs: PointPairs, W: FloatArray, T: RigidTransform) -> float:
    r = pairs.p_target - T.apply(pairs.p_source)
    return float(np.einsum("ni,nij,nj->", r, W, r))
