"""Identification by weighted least squares: Levenberg-Marquardt with the analytic Jacobian, rank, and covariance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri, stdtrit

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError
from wpcal.core.tangent import log_rotation
from wpcal.core.transform import RigidTransform
from wpcal.robot.identify.identifiability import TRACKER, Noise, Unseen, split_determined
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import POSE_SYMBOLS, Group, KinematicModel, Parameter
from wpcal.robot.identify.pose_residuals import Minimum, estimate_noise, evaluate, minimise
from wpcal.robot.kinematics.forward import LINK_SYMBOLS

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

        Parameters
        ----------
        absorbed : ndarray, shape (m,), optional
            Standard deviations that unseen parameters add (`absorbed_errors`), mm and rad; none unless given.
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
) -> LeastSquaresFit:
    r"""Identify parameters by weighted least squares.

    Minimises :math:`\sum_i |\Delta p_i|^2/\sigma_p^2 + |\Delta\omega_i|^2/\sigma_\omega^2` over the parameters, with
    Δω the rotation vector from the modelled to the measured orientation.

    Raises `GeometryError` when there are not more measured numbers than parameters that they determine.

    Parameters
    ----------
    parameters : sequence of Parameter
        What may change; where some cannot be told from others, earlier ones are kept and later ones stay fixed.
    theta : shape (N, n). Model angles of the rows, rad.

    Notes
    -----
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
    fit = minimise(start, kept, theta, observations, first)
    iterations = fit.iterations
    for _ in range(NOISE_ROUNDS if noise is None else 0):
        estimate = estimate_noise(fit, observations)
        ratio = (estimate.sigma_mm / estimate.sigma_rad) / (fit.noise.sigma_mm / fit.noise.sigma_rad)
        fit = minimise(fit.model, kept, theta, observations, estimate)
        iterations += fit.iterations
        if abs(np.log(ratio)) < NOISE_SETTLED:
            break
    return _finish(fit, start, unseen, iterations, observations)


def assess(
    start: KinematicModel,
    model: KinematicModel,
    parameters: tuple[Parameter, ...],
    theta: FloatArray,
    observations: PoseObservations,
    *,
    unseen: tuple[Unseen, ...] = (),
    noise: Noise | None = None,
) -> LeastSquaresFit:
    """Report rank, covariance and noise at a model that another solver found; nothing is moved.

    `theta`: shape (N, n). Model angles of the rows, rad.
    """
    found = evaluate(model, parameters, theta, observations, noise or TRACKER)
    if noise is None:
        found = evaluate(model, parameters, theta, observations, estimate_noise(found, observations))
    return _finish(found, start, unseen, 0, observations)


def absorbed_errors(
    fit: LeastSquaresFit,
    theta: FloatArray,
    observations: PoseObservations,
    *,
    expected_mm: float,
    expected_rad: float,
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
    norms = np.linalg.norm(fit.jacobian, axis=0)
    Q, upper = np.linalg.qr(fit.jacobian / norms)
    squares = np.zeros(len(fit.parameters))
    for draw in draws:
        change = -draw @ shares
        model = fit.model.moved(every, np.concatenate([draw, change]))
        r = evaluate(model, fit.parameters, theta, observations, fit.noise).r - fit.residuals
        squares += (change + np.linalg.solve(upper, Q.T @ r) / norms) ** 2
    return np.sqrt(squares / ABSORBED_DRAWS)


def clustered_covariance(J: FloatArray, r: FloatArray, observations: PoseObservations) -> tuple[FloatArray, int]:
    r"""Return the covariance of parameters when the rows of one pose are off together, and the number of poses.

    Reflectors on one tool see the same error of the joints, so their rows are not independent. The spread between poses
    takes the place of the noise: :math:`V = A \left(\sum_g J_g^\top u_g u_g^\top J_g\right) A` with
    :math:`A = (J^\top J)^{-1}` and the deleted residuals :math:`u_g = (I - H_{gg})^{-1} r_g` of each pose.

    `J`: shape (M, m). Whitened.
    `r`: shape (M,). Whitened.
    Returns `covariance`: ndarray, shape (m, m).

    References
    ----------
    Bell, McCaffrey (2002), Bias reduction in standard errors for linear regression with multi-stage samples: CR3.
    """
    block = np.repeat(observations.poses, len(r) // len(observations))
    norms = np.linalg.norm(J, axis=0)
    Q, upper = np.linalg.qr(J / norms)
    poses = np.unique(observations.poses[observations.weights > 0])
    scores = np.empty((len(poses), J.shape[1]))
    for k, pose in enumerate(poses):
        own = block == pose
        u = np.linalg.lstsq(np.eye(int(own.sum())) - Q[own] @ Q[own].T, r[own], rcond=None)[0]
        scores[k] = Q[own].T @ u
    half = np.linalg.solve(upper, scores.T) / norms[:, None]
    return half @ half.T * (len(poses) - 1) / len(poses), len(poses)


def _finish(
    fit: Minimum, start: KinematicModel, unseen: tuple[Unseen, ...], iterations: int, observations: PoseObservations
) -> LeastSquaresFit:
    norms = np.linalg.norm(fit.J, axis=0)
    _, singular, Vt = np.linalg.svd(fit.J / norms, full_matrices=False)
    half = Vt.T / singular / norms[:, None]
    covariance, clusters = half @ half.T, None
    if len(np.unique(observations.poses)) < len(observations):
        covariance, clusters = clustered_covariance(fit.J, fit.r, observations)
    return LeastSquaresFit(
        model=fit.model,
        parameters=fit.parameters,
        steps=_difference(fit.parameters, start, fit.model),
        covariance=covariance,
        unseen=unseen,
        condition=float(singular[0] / singular[-1]),
        noise=fit.noise,
        degrees_of_freedom=observations.equations - len(fit.parameters),
        iterations=iterations,
        residuals=fit.r,
        jacobian=fit.J,
        clusters=clusters,
        converged=fit.converged,
    )


def _difference(parameters: Sequence[Parameter], start: KinematicModel, end: KinematicModel) -> FloatArray:
    """Values of `end` minus values of `start`, shape (m,), mm and rad; turns as rotation vectors."""
    table = end.chain.table - start.chain.table
    shifts = end.reflectors_flange - start.reflectors_flange
    base = _pose_difference(start.chain.T_base_dh0, end.chain.T_base_dh0)
    tool = _pose_difference(start.chain.T_dhn_flange, end.chain.T_dhn_flange)
    return np.array([_entry(parameter, table, base, tool, shifts) for parameter in parameters])


def _pose_difference(start: RigidTransform, end: RigidTransform) -> FloatArray:
    return np.concatenate([end.t_mm - start.t_mm, log_rotation(end.R @ start.R.T)])


def _entry(parameter: Parameter, table: FloatArray, base: FloatArray, tool: FloatArray, shifts: FloatArray) -> float:
    if parameter.group is Group.LINK:
        return float(table[LINK_SYMBOLS.index(parameter.symbol), parameter.index])
    k = POSE_SYMBOLS.index(parameter.symbol)
    if parameter.group is Group.REFLECTOR:
        return float(shifts[parameter.index, k])
    return float((base if parameter.group is Group.BASE else tool)[k])
