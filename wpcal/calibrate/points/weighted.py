r"""The fit weighted with a covariance per taught point: least :math:`\sum_i r_i^\top \Sigma_i^{-1} r_i`."""

from __future__ import annotations

import numpy as np

from wpcal.calibrate.points.least_squares import centred, fit_least_squares, weighted_rms
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import ConvergenceError, InputError
from wpcal.core.pairs import PointPairs
from wpcal.core.tangent import exp_rotation, point_jacobian
from wpcal.core.transform import RigidTransform

MAX_STEPS = 100
"""Gauss-Newton steps converge in about 5; halved steps of odd data take more."""

RESTING = 1e-12
"""Relative fall of the sum at which it is at rest: some digits above round-off."""


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
    """Fit with the covariances of the pairs by Gauss-Newton from the least-squares fit.

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
        When the sum does not come to rest; carries the best fit.
    """
    W = information_matrices(pairs)
    T = fit_least_squares(pairs)
    value = _weighted_sum(pairs, W, T)
    scale = float(np.abs(W).max()) * float(np.var(pairs.p_target, axis=0).sum()) * np.finfo(np.float64).eps
    for _ in range(MAX_STEPS):
        step = _gauss_newton_step(pairs, W, T)
        moved, after = T, np.inf
        for halving in range(30):
            moved = _moved(T, step / 2**halving, pairs.p_target.mean(axis=0))
            after = _weighted_sum(pairs, W, moved)
            if after <= value:
                break
        if after > value or value - after <= RESTING * value + scale**2:
            return moved if after <= value else T
        T, value = moved, after
    raise ConvergenceError(f"the weighted fit did not come to rest in {MAX_STEPS} steps", best=T)


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


def gauss_newton_steps(
    p: FloatArray, q: FloatArray, information: FloatArray, R: FloatArray, t: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """From fits near by to the least Σ r Λ r: one Gauss-Newton step each, and the sum it comes to.

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
    steps : ndarray, shape (..., 6)
        ξ about the centroid of the moved points.
    sums : ndarray, shape (...)
    """
    moved = p @ np.swapaxes(R, -1, -2) + t[..., None, :]
    about = moved - moved.mean(axis=-2, keepdims=True)
    J, r = point_jacobian(about.reshape(-1, 3)).reshape(*about.shape, 6), q - moved
    WJ, Wr = information @ J, np.einsum("...nij,...nj->...ni", information, r)
    gradient = np.einsum("...nik,...ni->...k", J, Wr)
    hessian = np.einsum("...nik,...nil->...kl", J, WJ)
    steps = np.einsum("...kl,...l->...k", np.linalg.pinv(hessian, hermitian=True), gradient)
    sums = np.einsum("...ni,...ni->...", r, Wr) - np.einsum("...k,...k->...", gradient, steps)
    return steps, np.asarray(sums)


def _weighted_sum(pairs: PointPairs, W: FloatArray, T: RigidTransform) -> float:
    r = pairs.p_target - T.apply(pairs.p_source)
    return float(np.einsum("ni,nij,nj->", r, W, r))


def _gauss_newton_step(pairs: PointPairs, W: FloatArray, T: RigidTransform) -> FloatArray:
    moved = T.apply(pairs.p_source)
    J = point_jacobian(moved - pairs.p_target.mean(axis=0))
    WJ = W @ J
    return np.linalg.solve(np.einsum("nik,nil->kl", J, WJ), np.einsum("nik,ni->k", WJ, pairs.p_target - moved))


def _moved(T: RigidTransform, xi: FloatArray, centre: FloatArray) -> RigidTransform:
    turn = exp_rotation(xi[:3])
    return RigidTransform(turn @ T.R, turn @ (T.t_mm - centre) + centre + xi[3:], T.target, T.source)
