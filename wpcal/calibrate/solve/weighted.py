r"""The fit weighted with a covariance per taught point: least :math:`\sum_i r_i^\top \Sigma_i^{-1} r_i`."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from wpcal.calibrate.solve.least_squares import centred, fit_least_squares, kabsch, rotation_maximising, weighted_rms
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.pairs import PointPairs
from wpcal.core.rotations import cross_matrix, cube_rotations
from wpcal.core.tangent import exp_rotation, point_jacobian
from wpcal.core.transform import RigidTransform
from wpcal.optim.levenberg_marquardt import minimise_squares

MAX_STEPS = 100  #: Gauss-Newton steps converge in about 5; damped steps of odd data take more.
FIRST_DAMPING = 1e-6  #: The least-squares fit is near the answer: the first step is almost that of Gauss and Newton.
SEARCH_STEPS = 12
"""Damped steps of all starts at once; enough to tell the valleys apart. The best are then followed to their end."""
SEARCH_DAMPING = 1e-3  #: The starts are far from their valleys; a smaller damping gains nothing in the first steps.
MOST_VALLEYS = 4
"""Ends of descents that are followed to rest; most of the 24 starts end in the same one or two valleys."""
SAME_SUM = 1e-9
"""Another valley must be lower by this share: of two equal ones that of the least-squares fit is the answer."""
SURE = 0.01
"""Residuals that good data exceed more often than this need no other start: the fit is where the errors say."""
LEAST_CURVATURE = 1e-9  #: Least eigenvalue of the scaled Hessian (largest: a few) that is still told from round-off.
ROUND_OFF = 16 * float(np.finfo(np.float64).eps)
"""Share of the largest coordinate by which a computed residual may be off."""


def information_matrices(pairs: PointPairs) -> FloatArray:
    """Inverse covariances of the taught points, scaled so that their mean trace is 3 (equal errors give the identity).

    Raises `InputError` when the pairs carry no covariances, or one is not symmetric and positive definite.
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
    """Fit with the covariances of the pairs, by damped least squares from many rotations.

    Raises `InputError` when there are no covariances or one is not positive definite.
    Raises `GeometryError` when the points do not fix a rotation.

    Returns: The best fit found. Where its residuals are larger than the covariances explain, 24 further rotations are
    tried. Good data have one valley; data with a slip may have several, and nothing proves then that no better one
    exists (`weighted_lower_bound`).
    """
    information = information_matrices(pairs)
    problem = _WeightedSquares(pairs, information)
    off = ROUND_OFF * float(np.abs(pairs.p_target).max()) * math.sqrt(len(pairs))

    def ended(start: RigidTransform) -> tuple[float, RigidTransform]:
        # a step that changes the residuals by less is lost in the round-off of the sum
        still = math.sqrt(off * (math.sqrt(problem.cost(start)) + off))
        found = minimise_squares(problem, start, still=still, most_steps=MAX_STEPS, first_damping=FIRST_DAMPING)
        return found.cost, found.state

    best_cost, best = ended(fit_least_squares(pairs))
    if _explained(problem, best):
        return best
    for start in _valleys(pairs, information):
        cost, found = ended(start)
        if cost < best_cost * (1.0 - SAME_SUM):
            best_cost, best = cost, found
    return best


def _explained(problem: _WeightedSquares, T: RigidTransform) -> bool:
    """Tell whether the residuals are as large as the covariances say: χ² with 3n - 6 degrees of freedom."""
    pairs = problem.pairs
    assert pairs.covariances is not None  # `information_matrices` has refused pairs without them
    scale = float(np.trace(np.linalg.inv(pairs.covariances[0])) / np.trace(problem.W[0]))
    return problem.cost(T) * scale <= float(chdtri(3 * len(pairs) - 6, SURE))


def _valleys(pairs: PointPairs, information: FloatArray) -> list[RigidTransform]:
    """Return the best ends of short descents from the 24 rotations of a cube about the scalar-weighted fit."""
    p_mean, q_mean = pairs.p_source.mean(axis=0), pairs.p_target.mean(axis=0)
    p, q = pairs.p_source - p_mean, pairs.p_target - q_mean
    scalar = np.trace(information, axis1=1, axis2=2)
    R, _ = kabsch(p, q, scalar / scalar.sum())
    R = cube_rotations() @ R
    t = _best_translation(p, q, information, R)
    sums = _sums(p, q, information, R, t)
    damping = np.full(len(R), SEARCH_DAMPING)
    for _ in range(SEARCH_STEPS):
        gradient, hessian, _, centre = _normal_equations(p, q, information, R, t)
        diagonal = np.einsum("...kk->...k", hessian)[..., None] * np.eye(6)
        step = np.linalg.solve(hessian + damping[:, None, None] * diagonal, gradient[..., None])[..., 0]
        turn = exp_rotation(step[:, :3])
        new_R = turn @ R
        new_t = np.einsum("bij,bj->bi", turn, t - centre) + centre + step[:, 3:]
        new_sums = _sums(p, q, information, new_R, new_t)
        better = new_sums < sums
        R, t = np.where(better[:, None, None], new_R, R), np.where(better[:, None], new_t, t)
        sums, damping = np.where(better, new_sums, sums), np.where(better, damping / 10.0, damping * 10.0)
    order = np.argsort(sums, kind="stable")[:MOST_VALLEYS]
    return [RigidTransform(R[i], t[i] + q_mean - R[i] @ p_mean, pairs.target, pairs.source) for i in order]


def _best_translation(p: FloatArray, q: FloatArray, information: FloatArray, R: FloatArray) -> FloatArray:
    """Translations of least Σ r Λ r at given rotations, shape (B, 3)."""
    pull = np.einsum("nij,bnj->bi", information, q - p @ R.transpose(0, 2, 1))
    return np.asarray(np.linalg.solve(information.sum(axis=0), pull.T).T)


def _sums(p: FloatArray, q: FloatArray, information: FloatArray, R: FloatArray, t: FloatArray) -> FloatArray:
    r = q - p @ R.transpose(0, 2, 1) - t[:, None]
    return np.asarray(np.einsum("bni,nij,bnj->b", r, information, r, optimize=True))


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

    Returns `R, t`: shapes (..., 3, 3), (..., 3). The fits after the step.
    Returns `sums`: shape (...). Σ r Λ r after the step, as the linear model predicts it.

    `p`, `q`: shape (..., n, 3). mm.
    `information`: shape (..., n, 3, 3). Λ, mm⁻².
    `R`, `t`: shapes (..., 3, 3), (..., 3). The fits.
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
        """Gradient and half of the exact Hessian; without its curvature term where that would make it indefinite.

        Large residuals, as of a slip, bend the sum so much that the normal matrix alone creeps to the minimum.
        """
        p, q = self.pairs.p_source, self.pairs.p_target
        gradient, hessian, _, centre = _normal_equations(p, q, self.W, T.R, T.t_mm)
        moved = T.apply(p)
        mixed = np.einsum("nij,nj,nk->ik", self.W, q - moved, moved - centre)
        exact = hessian.copy()
        exact[:3, :3] += np.trace(mixed) * np.eye(3) - 0.5 * (mixed + mixed.T)
        scale = np.sqrt(np.diag(hessian))
        convex = np.linalg.eigvalsh(exact / np.outer(scale, scale))[0] > LEAST_CURVATURE
        return -gradient, exact if convex else hessian  # the model point moves towards the taught one

    def moved(self, T: RigidTransform, step: FloatArray) -> RigidTransform:
        turn, centre = exp_rotation(step[:3]), T.apply(self.pairs.p_source).mean(axis=0)
        return RigidTransform(turn @ T.R, turn @ (T.t_mm - centre) + centre + step[3:], T.target, T.source)


def _weighted_sum(pairs: PointPairs, W: FloatArray, T: RigidTransform) -> float:
    r = pairs.p_target - T.apply(pairs.p_source)
    return float(np.einsum("ni,nij,nj->", r, W, r))
