"""Identification by weighted least squares: Levenberg-Marquardt with the analytic Jacobian, rank, and covariance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri, stdtrit

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError
from wpcal.robot.identify.identifiability import TRACKER, Noise, Unseen, split_determined
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import Group, KinematicModel, Parameter, model_difference
from wpcal.robot.identify.pose_residuals import Minimum, Prior, estimate_noise, evaluate, minimise

STRONG_CORRELATION = 0.95
"""Pairs of parameters above this are reported by name: their sum or difference is known three times worse than the
other combination at 0.8 and six times at 0.95."""
NOISE_ROUNDS = 6  #: Rounds of fit and noise estimate; the ratio of the two settles within three or four.
ABSORBED_DRAWS = 64  #: Draws of the errors of unseen parameters: their spread is then known to a tenth.
NOISE_SETTLED = 0.02
"""A change of the ratio of the two noises by less than 2 % moves no parameter by a visible part of its spread."""


@dataclass(frozen=True, slots=True, eq=False)
class LeastSquaresFit:
    """What least squares found."""

    model: KinematicModel  #: The identified model.
    parameters: tuple[Parameter, ...]  #: The m parameters that were identified.
    steps: FloatArray  #: shape (m,). Identified minus starting value, mm and rad.
    covariance: FloatArray  #: shape (m, m). Of the parameters, mm and rad.
    unseen: tuple[Unseen, ...]  #: Parameters that were asked for but left at their start.
    condition: float  #: Of the weighted Jacobian with columns of length one.
    noise: Noise  #: Given, or estimated from the residuals.
    degrees_of_freedom: int  #: Measured numbers minus parameters.
    iterations: int
    residuals: FloatArray  #: shape (M,). Whitened, of every measured number.
    jacobian: FloatArray  #: shape (M, m). Their whitened derivatives (of the modelled poses).
    prior: Prior  #: What was believed of the parameters before.
    #: Number of poses, where several rows of a pose make their errors dependent; the covariance then comes from the
    #: spread between poses.
    clusters: int | None
    #: Whether the last step was below round-off; measurements that do not belong to the poses may not get there.
    converged: bool

    @property
    def rank(self) -> int:
        """How many parameters the measurements determine."""
        return len(self.parameters)

    @property
    def standard_deviations(self) -> FloatArray:
        """Of the parameters, shape (m,), mm and rad."""
        return np.sqrt(np.diag(self.covariance))

    def half_widths(self, level: float = 0.95, *, absorbed: FloatArray | None = None) -> FloatArray:
        """Half widths of the intervals that cover each true value with probability `level`, shape (m,).

        `absorbed`: shape (m,), optional. Standard deviations that unseen parameters add (`absorbed_errors`), mm and
        rad; none unless given.
        """
        freedom = self.degrees_of_freedom if self.clusters is None else self.clusters - 1
        measured = stdtrit(freedom, 0.5 + level / 2.0) * self.standard_deviations
        added = np.zeros(len(measured)) if absorbed is None else ndtri(0.5 + level / 2.0) * absorbed
        return np.asarray(np.hypot(measured, added))

    def strong_correlations(self, group: Group | None = None) -> list[tuple[str, str, float]]:
        """Pairs of parameters whose errors go together (or against each other) beyond 0.95, strongest first.

        With a group, only pairs in which both belong to it.
        """
        s = self.standard_deviations
        correlation = self.covariance / np.outer(s, s)
        first, second = np.nonzero(np.triu(np.abs(correlation) > STRONG_CORRELATION, k=1))
        pairs = [
            (self.parameters[i].name, self.parameters[j].name, float(correlation[i, j]))
            for i, j in zip(first, second, strict=True)
            if group is None or (self.parameters[i].group is group and self.parameters[j].group is group)
        ]
        return sorted(pairs, key=lambda pair: -abs(pair[2]))


def solve_least_squares(
    start: KinematicModel,
    parameters: Sequence[Parameter],
    theta: FloatArray,
    observations: PoseObservations,
    *,
    noise: Noise | None = None,
    expected: tuple[float, float] | None = None,
) -> LeastSquaresFit:
    r"""Identify parameters by weighted least squares, near their nominal values.

    Minimises :math:`\sum_i |\Delta p_i|^2/\sigma_p^2 + |\Delta\omega_i|^2/\sigma_\omega^2 + \sum_j x_j^2/\tau_j^2` over
    the changes x of the parameters, with Δω the rotation vector from the modelled to the measured orientation.

    Raises `GeometryError` when there are not more measured numbers than parameters that they determine.

    `parameters`: What may change; where some cannot be told from others, earlier ones are kept and later ones stay
    fixed.
    `theta`: shape (N, n). Model angles of the rows, rad.
    `expected`: Expected errors τ of a length (mm) and of an angle (rad) of a link; without them any change is as
    likely.

    The rank is decided at the start, where parallel axes are exactly parallel. At an estimate close by, a meaningless
    direction would count as determined.
    """
    first = noise or TRACKER
    kept, unseen = split_determined(start, parameters, theta, observations)
    rows = observations.equations
    if rows <= len(kept):
        raise GeometryError(
            f"too few poses: {len(observations)} give {rows} numbers for {len(kept)} parameters; "
            f"{-(-(len(kept) + 1) * len(observations) // rows)} poses are the least, three times as many are advisable"
        )
    prior = Prior.of(start, kept, expected)
    fit = minimise(start, prior, theta, observations, first)
    iterations = fit.iterations
    for _ in range(NOISE_ROUNDS if noise is None else 0):
        estimate = estimate_noise(fit, observations)
        ratio = (estimate.sigma_mm / estimate.sigma_rad) / (fit.noise.sigma_mm / fit.noise.sigma_rad)
        fit = minimise(fit.model, prior, theta, observations, estimate)
        iterations += fit.iterations
        if abs(np.log(ratio)) < NOISE_SETTLED:
            break
    return _finish(fit, unseen, iterations, observations)


def assess(
    prior: Prior,
    model: KinematicModel,
    theta: FloatArray,
    observations: PoseObservations,
    *,
    unseen: tuple[Unseen, ...] = (),
    noise: Noise | None = None,
) -> LeastSquaresFit:
    """Report rank, covariance and noise at a model that another solver found; nothing is moved.

    `theta`: shape (N, n). Model angles of the rows, rad.
    """
    found = evaluate(model, prior, theta, observations, noise or TRACKER)
    if noise is None:
        found = evaluate(model, prior, theta, observations, estimate_noise(found, observations))
    return _finish(found, unseen, 0, observations)


def absorbed_errors(
    fit: LeastSquaresFit, theta: FloatArray, observations: PoseObservations, *, expected_mm: float, expected_rad: float
) -> FloatArray:
    """Return what the errors of unseen parameters add to the errors of those that absorb them.

    An unseen parameter keeps its nominal value. Where its true value differs, the kept parameters change so that the
    poses stay the same. Random true values are drawn and followed by one Gauss-Newton step: the first-order change and
    what is left of it at second order, since an offset of 1 mm at 95 mm already turns an axis by 0.6 degrees.

    `theta`: shape (N, n). Model angles of the rows, rad.
    Returns ndarray, shape (m,). Root mean square, mm and rad; zero where nothing is absorbed.
    """
    if not fit.unseen:
        return np.zeros(len(fit.parameters))
    lengths = np.array([unseen.parameter.is_length for unseen in fit.unseen])
    shares = np.array([unseen.shares for unseen in fit.unseen])
    draws = np.random.default_rng(0).normal(size=(ABSORBED_DRAWS, len(shares)))
    draws *= np.where(lengths, expected_mm, expected_rad)
    every = (*(unseen.parameter for unseen in fit.unseen), *fit.parameters)
    Q, upper, norms = fit.prior.split(fit.jacobian)
    squares = np.zeros(len(fit.parameters))
    for draw in draws:
        change = -draw @ shares
        model = fit.model.moved(every, np.concatenate([draw, change]))
        r = evaluate(model, fit.prior, theta, observations, fit.noise).r - fit.residuals
        r = np.concatenate([r, -fit.prior.root * change])
        squares += (change + np.linalg.solve(upper, Q.T @ r) / norms) ** 2
    return np.sqrt(squares / ABSORBED_DRAWS)


def clustered_covariance(
    J: FloatArray, r: FloatArray, observations: PoseObservations, prior: Prior
) -> tuple[FloatArray, int]:
    r"""Return the covariance of parameters when the rows of one pose are off together, and the number of poses.

    Reflectors on one tool see the same error of the joints, so their rows are not independent. The spread between poses
    takes the place of the noise: :math:`V = A \left(\sum_g J_g^\top u_g u_g^\top J_g\right) A` with
    :math:`A = (J^\top J + \Lambda)^{-1}` and the deleted residuals :math:`u_g = (I - H_{gg})^{-1} r_g` of each pose.
    The prior adds :math:`A \Lambda A`.

    `J`: shape (M, m). Whitened.
    `r`: shape (M,). Whitened.
    Returns `covariance`: ndarray, shape (m, m).

    References: Bell, McCaffrey (2002), Bias reduction in standard errors for linear regression with multi-stage
    samples: CR3.
    """
    block = np.repeat(observations.poses, len(r) // len(observations))
    Q, upper, norms = prior.split(J)
    poses = np.unique(observations.poses[observations.weights > 0])
    scores = np.empty((len(poses), J.shape[1]))
    for k, pose in enumerate(poses):
        own = np.flatnonzero(block == pose)
        u = np.linalg.lstsq(np.eye(len(own)) - Q[own] @ Q[own].T, r[own], rcond=None)[0]
        scores[k] = Q[own].T @ u
    scores *= np.sqrt((len(poses) - 1) / len(poses))
    half = np.linalg.solve(upper, np.column_stack([scores.T, Q[len(J) :].T])) / norms[:, None]
    return half @ half.T, len(poses)


def _finish(
    fit: Minimum, unseen: tuple[Unseen, ...], iterations: int, observations: PoseObservations
) -> LeastSquaresFit:
    _, upper, norms = fit.prior.split(fit.J)
    half = np.linalg.inv(upper) / norms[:, None]
    covariance, clusters = half @ half.T, None
    if len(np.unique(observations.poses)) < len(observations):
        covariance, clusters = clustered_covariance(fit.J, fit.r, observations, fit.prior)
    singular = np.linalg.svd(fit.J / np.linalg.norm(fit.J, axis=0), compute_uv=False)
    return LeastSquaresFit(
        model=fit.model,
        parameters=fit.prior.parameters,
        steps=model_difference(fit.prior.parameters, fit.prior.start, fit.model),
        covariance=covariance,
        unseen=unseen,
        condition=float(singular[0] / singular[-1]),
        noise=fit.noise,
        degrees_of_freedom=observations.equations - len(fit.prior.parameters),
        iterations=iterations,
        residuals=fit.r,
        jacobian=fit.J,
        prior=fit.prior,
        clusters=clusters,
        converged=fit.converged,
    )
