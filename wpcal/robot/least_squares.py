"""Identification by weighted least squares: Levenberg-Marquardt with the analytic Jacobian, rank, and covariance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError
from wpcal.core.tangent import log_rotation
from wpcal.core.transform import RigidTransform
from wpcal.robot.chain import LINK_SYMBOLS
from wpcal.robot.identifiability import TRACKER, Noise, Unseen, split_determined, whitened
from wpcal.robot.observations import PoseObservations
from wpcal.robot.parameters import POSE_SYMBOLS, Group, KinematicModel, Parameter

STRONG_CORRELATION = 0.95
"""Pairs of parameters above this are reported by name (issue: 'correlations above 0.95')."""

MAX_STEPS = 40
"""Steps of Levenberg-Marquardt: four to six are usual; measurements that belong to other poses use them up."""

STILL_SIGMAS = 1e-8
"""The last step moves the poses by less than this part of their noise (root mean square): nobody could see it ..."""

ROUND_OFF_MM = 1e-11
"""... or by less than the round-off of positions metres away, where simulated noise is smaller than any real one."""

FIRST_DAMPING, DAMPING_FACTOR, MOST_DAMPING = 1e-6, 10.0, 1e6
"""Part of the scaled diagonal that is added at first, how it changes after a step, and where no step helps."""

LEAST_MM, LEAST_RAD = 1e-6, 1e-9
"""Noise is never taken as smaller: no instrument is better, and simulated poses without noise have none to estimate."""

NOISE_ROUNDS = 6
"""Rounds of fit and noise estimate; the ratio of the two settles within three or four."""

NOISE_SETTLED = 0.02
"""A change of the ratio of the two noises by less than 2 % moves no parameter by a visible part of its spread."""


@dataclass(frozen=True, slots=True, eq=False)
class LeastSquaresFit:
    """What least squares found.

    Parameters
    ----------
    model : KinematicModel
        The identified model.
    parameters : tuple of Parameter
        The m parameters that were identified.
    steps : ndarray, shape (m,)
        Identified minus starting value, mm and rad.
    covariance : ndarray, shape (m, m)
        Of the parameters, mm and rad.
    unseen : tuple of Unseen
        Parameters that were asked for but left at their start.
    condition : float
        Of the weighted Jacobian with columns of length one.
    noise : Noise
        Given, or estimated from the residuals.
    degrees_of_freedom : int
        Measured numbers minus parameters.
    iterations : int
    converged : bool
        Whether the last step was below round-off; measurements that do not belong to the poses may not get there.
    """

    model: KinematicModel
    parameters: tuple[Parameter, ...]
    steps: FloatArray
    covariance: FloatArray
    unseen: tuple[Unseen, ...]
    condition: float
    noise: Noise
    degrees_of_freedom: int
    iterations: int
    converged: bool

    @property
    def rank(self) -> int:
        """How many parameters the measurements determine."""
        return len(self.parameters)

    @property
    def standard_deviations(self) -> FloatArray:
        """Of the parameters, shape (m,), mm and rad."""
        return np.sqrt(np.diag(self.covariance))

    def half_widths(self, level: float = 0.95) -> FloatArray:
        """Half widths of the intervals that cover each true value with probability `level`, shape (m,)."""
        return np.asarray(stdtrit(self.degrees_of_freedom, 0.5 + level / 2.0) * self.standard_deviations)

    def strong_correlations(self) -> list[tuple[str, str, float]]:
        """Pairs of parameters whose errors go together (or against each other) beyond 0.95, strongest first."""
        s = self.standard_deviations
        correlation = self.covariance / np.outer(s, s)
        first, second = np.nonzero(np.triu(np.abs(correlation) > STRONG_CORRELATION, k=1))
        pairs = [
            (self.parameters[i].name, self.parameters[j].name, float(correlation[i, j]))
            for i, j in zip(first, second, strict=True)
        ]
        return sorted(pairs, key=lambda pair: -abs(pair[2]))


def pose_errors(model: KinematicModel, theta: FloatArray, observations: PoseObservations) -> FloatArray:
    """Return measured minus modelled poses, shape (N, 6) or (N, 3).

    Columns: turn (rad, only where orientations were measured), then distance (mm), in the frame of the measurement.
    """
    p, R = model.poses(theta, observations.reflector)
    shift = observations.p_base - p
    if observations.R_base_flange is None:
        return shift
    turn = log_rotation(observations.R_base_flange @ np.swapaxes(R, 1, 2))
    return np.concatenate([turn, shift], axis=1)


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

    Parameters
    ----------
    start : KinematicModel
        Nominal links, with base and tool near theirs.
    parameters : sequence of Parameter
        What may change; where some cannot be told from others, earlier ones are kept and later ones stay fixed.
    theta : ndarray, shape (N, n)
        Model angles of the rows, rad.
    observations : PoseObservations
    noise : Noise, optional
        Estimated from the residuals of position and orientation (variance components) unless given.

    Returns
    -------
    LeastSquaresFit

    Raises
    ------
    GeometryError
        When there are not more measured numbers than parameters that they determine.

    Notes
    -----
    The rank is decided at the start, where parallel axes are exactly parallel: at an estimate a hair away a
    meaningless direction would count as seen.
    """
    first = noise or TRACKER
    kept, unseen = split_determined(start, parameters, theta, observations)
    rows = observations.equations
    if rows <= len(kept):
        raise GeometryError(
            f"too few poses: {len(observations)} give {rows} numbers for {len(kept)} parameters; "
            f"{-(-(len(kept) + 1) * len(observations) // rows)} poses are the least, three times as many are advisable"
        )
    fit = _minimise(start, kept, theta, observations, first)
    iterations = fit.iterations
    for _ in range(NOISE_ROUNDS if noise is None else 0):
        estimate = _estimate_noise(fit, observations)
        ratio = (estimate.sigma_mm / estimate.sigma_rad) / (fit.noise.sigma_mm / fit.noise.sigma_rad)
        fit = _minimise(fit.model, kept, theta, observations, estimate)
        iterations += fit.iterations
        if abs(np.log(ratio)) < NOISE_SETTLED:
            break
    return _finish(fit, start, unseen, iterations)


@dataclass(frozen=True, slots=True, eq=False)
class _Minimum:
    """Where Levenberg-Marquardt stopped, with the whitened residuals and Jacobian there."""

    model: KinematicModel
    parameters: tuple[Parameter, ...]
    noise: Noise
    r: FloatArray
    J: FloatArray
    iterations: int
    converged: bool


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
    """Report rank, covariance and noise at a model that another solver found; nothing is moved."""
    found = _at(model, parameters, theta, observations, noise or TRACKER)
    if noise is None:
        found = _at(model, parameters, theta, observations, _estimate_noise(found, observations))
    return _finish(found, start, unseen, 0)


def _at(
    model: KinematicModel,
    parameters: tuple[Parameter, ...],
    theta: FloatArray,
    observations: PoseObservations,
    noise: Noise,
) -> _Minimum:
    r = (pose_errors(model, theta, observations) * _weights(observations, noise)).ravel()
    J = whitened(model.jacobian(parameters, theta, observations.reflector), observations, noise)
    return _Minimum(model, parameters, noise, r, J, 0, converged=True)


def _weights(observations: PoseObservations, noise: Noise) -> FloatArray:
    """One over the noise of each column of `pose_errors`."""
    sigmas = [noise.sigma_rad, noise.sigma_mm] if observations.has_orientations else [noise.sigma_mm]
    return 1.0 / np.repeat(sigmas, 3)


def _finish(fit: _Minimum, start: KinematicModel, unseen: tuple[Unseen, ...], iterations: int) -> LeastSquaresFit:
    norms = np.linalg.norm(fit.J, axis=0)
    _, singular, Vt = np.linalg.svd(fit.J / norms, full_matrices=False)
    half = Vt.T / singular / norms[:, None]
    return LeastSquaresFit(
        model=fit.model,
        parameters=fit.parameters,
        steps=_difference(fit.parameters, start, fit.model),
        covariance=half @ half.T,
        unseen=unseen,
        condition=float(singular[0] / singular[-1]),
        noise=fit.noise,
        degrees_of_freedom=len(fit.r) - len(fit.parameters),
        iterations=iterations,
        converged=fit.converged,
    )


def _minimise(
    model: KinematicModel,
    parameters: tuple[Parameter, ...],
    theta: FloatArray,
    observations: PoseObservations,
    noise: Noise,
) -> _Minimum:
    """Levenberg-Marquardt with columns scaled to length one."""
    weights = _weights(observations, noise)
    still = max(STILL_SIGMAS, ROUND_OFF_MM / noise.sigma_mm) * np.sqrt(observations.equations)
    r = (pose_errors(model, theta, observations) * weights).ravel()
    damping, small, iteration = FIRST_DAMPING, False, 0
    while True:
        J = whitened(model.jacobian(parameters, theta, observations.reflector), observations, noise)
        if small or iteration == MAX_STEPS or damping >= MOST_DAMPING:
            return _Minimum(model, parameters, noise, r, J, iteration, converged=small)
        norms = np.linalg.norm(J, axis=0)
        scaled = J / norms
        normal, gradient = scaled.T @ scaled, scaled.T @ r
        while damping < MOST_DAMPING:
            scaled_step = np.linalg.solve(normal + damping * np.eye(len(normal)), gradient)
            small = bool(np.linalg.norm(scaled @ scaled_step) <= still) and damping <= FIRST_DAMPING
            candidate = model.moved(parameters, scaled_step / norms)
            trial = (pose_errors(candidate, theta, observations) * weights).ravel()
            if small or trial @ trial <= r @ r:
                model, r = candidate, trial
                break
            damping *= DAMPING_FACTOR
        damping /= DAMPING_FACTOR
        iteration += 1


def _estimate_noise(fit: _Minimum, observations: PoseObservations) -> Noise:
    """Variance components: the squared residuals of each kind over its share of the degrees of freedom."""
    Q = np.linalg.qr(fit.J)[0]
    freedom = 1.0 - np.sum(Q * Q, axis=1)
    if not observations.has_orientations:
        return Noise(max(LEAST_MM, fit.noise.sigma_mm * _scale(fit.r, freedom)), fit.noise.sigma_rad)
    r, freedom = fit.r.reshape(-1, 2, 3), freedom.reshape(-1, 2, 3)
    return Noise(
        max(LEAST_MM, fit.noise.sigma_mm * _scale(r[:, 1], freedom[:, 1])),
        max(LEAST_RAD, fit.noise.sigma_rad * _scale(r[:, 0], freedom[:, 0])),
    )


def _scale(r: FloatArray, freedom: FloatArray) -> float:
    """Root of the sum of squares of whitened residuals over what is expected of it; 1 where the noise was right."""
    return float(np.sqrt(np.sum(r * r) / max(float(np.sum(freedom)), np.finfo(float).eps)))


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
