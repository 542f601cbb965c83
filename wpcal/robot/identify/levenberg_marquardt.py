"""Levenberg-Marquardt over the parameters of a `KinematicModel`, and the noise that its residuals show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import log_rotation
from wpcal.robot.identify.identifiability import Noise, whitened
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import KinematicModel, Parameter

MAX_STEPS = 40
"""Steps of Levenberg-Marquardt: four to six are usual; measurements that belong to other poses use them up."""

STILL_SIGMAS = 1e-6
"""The last step moves the poses by less than this part of their noise (root mean square), and as steps shrink
quadratically the next one would be round-off. Below 1e-7 the sum of squares no longer shows whether a step helps ..."""

ROUND_OFF_MM = 1e-11
"""... or by less than the round-off of positions metres away, where simulated noise is smaller than any real one."""

FIRST_DAMPING, DAMPING_FACTOR, MOST_DAMPING = 1e-6, 10.0, 1e6
"""Part of the scaled diagonal that is added at first, how it changes after a step, and where no step helps."""

LEAST_MM, LEAST_RAD = 1e-6, 1e-9
"""Noise is never taken as smaller: no instrument is better, and simulated poses without noise have none to estimate."""


@dataclass(frozen=True, slots=True, eq=False)
class Minimum:
    """Where Levenberg-Marquardt stopped, with the whitened residuals and Jacobian there."""

    model: KinematicModel
    parameters: tuple[Parameter, ...]
    noise: Noise
    r: FloatArray
    J: FloatArray
    iterations: int
    converged: bool


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


def evaluate(
    model: KinematicModel,
    parameters: tuple[Parameter, ...],
    theta: FloatArray,
    observations: PoseObservations,
    noise: Noise,
) -> Minimum:
    """Return residuals and Jacobian at a model; nothing is moved."""
    r = (pose_errors(model, theta, observations) * _weights(observations, noise)).ravel()
    J = whitened(model.jacobian(parameters, theta, observations.reflector), observations, noise)
    return Minimum(model, parameters, noise, r, J, 0, converged=True)


def _weights(observations: PoseObservations, noise: Noise) -> FloatArray:
    """One over the noise of each column of `pose_errors`."""
    sigmas = [noise.sigma_rad, noise.sigma_mm] if observations.has_orientations else [noise.sigma_mm]
    return 1.0 / np.repeat(sigmas, 3)


def minimise(
    model: KinematicModel,
    parameters: tuple[Parameter, ...],
    theta: FloatArray,
    observations: PoseObservations,
    noise: Noise,
) -> Minimum:
    """Levenberg-Marquardt with columns scaled to length one."""
    weights = _weights(observations, noise)
    still = max(STILL_SIGMAS, ROUND_OFF_MM / noise.sigma_mm) * np.sqrt(observations.equations)
    r = (pose_errors(model, theta, observations) * weights).ravel()
    damping, small, iteration = FIRST_DAMPING, False, 0
    while True:
        J = whitened(model.jacobian(parameters, theta, observations.reflector), observations, noise)
        if small or iteration == MAX_STEPS:
            return Minimum(model, parameters, noise, r, J, iteration, converged=small)
        norms = np.linalg.norm(J, axis=0)
        scaled = J / norms
        normal, gradient = scaled.T @ scaled, scaled.T @ r
        while True:
            scaled_step = np.linalg.solve(normal + damping * np.eye(len(normal)), gradient)
            small = bool(np.linalg.norm(scaled @ scaled_step) <= still) and damping <= FIRST_DAMPING
            candidate = model.moved(parameters, scaled_step / norms)
            trial = (pose_errors(candidate, theta, observations) * weights).ravel()
            if small or trial @ trial <= r @ r:
                break
            damping *= DAMPING_FACTOR
            if damping > MOST_DAMPING:
                return Minimum(model, parameters, noise, r, J, iteration, converged=False)
        model, r = candidate, trial
        damping /= DAMPING_FACTOR
        iteration += 1


def estimate_noise(fit: Minimum, observations: PoseObservations) -> Noise:
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
