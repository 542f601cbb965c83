"""Residuals of measured poses, their least-squares minimum over model parameters, and the noise that they show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import log_rotation
from wpcal.optim.levenberg_marquardt import minimise_squares
from wpcal.robot.identify.identifiability import Noise, whitened
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import Group, KinematicModel, Parameter, model_difference

MAX_STEPS = 40
"""Steps of Levenberg-Marquardt: four to six are usual; measurements that belong to other poses use them up."""
STILL_SIGMAS = 1e-6
"""The last step moves the poses by less than this part of their noise (root mean square), and as steps shrink
quadratically the next one would be round-off. Below 1e-7 the sum of squares no longer shows whether a step helps ..."""
ROUND_OFF_MM = 1e-11
"""... or by less than the round-off of positions metres away, where simulated noise is smaller than any real one."""
FIRST_DAMPING = 1e-6  #: Nominal parameters are so near the true ones that nearly undamped steps converge.
LEAST_MM, LEAST_RAD = 1e-6, 1e-9
"""Noise is never taken as smaller: no instrument is better, and simulated poses without noise have none to estimate."""


@dataclass(frozen=True, slots=True, eq=False)
class Prior:
    """What may change, and what is believed of it before the poses are measured."""

    parameters: tuple[Parameter, ...]
    start: KinematicModel  #: With the nominal links.
    root: FloatArray  #: shape (m,). One over the expected error of each parameter; zero where any value is as likely.

    @classmethod
    def of(
        cls, start: KinematicModel, parameters: tuple[Parameter, ...], expected: tuple[float, float] | None
    ) -> Prior:
        """Expect errors of links, mm for a length and rad for an angle; nothing is known of base and tool."""
        mm, rad = expected or (np.inf, np.inf)
        own = [(mm if p.is_length else rad) if p.group is Group.LINK else np.inf for p in parameters]
        return cls(parameters, start, 1.0 / np.array(own))

    def split(self, J: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return Q and R of the whitened Jacobian J, shape (M, m), over the prior, and the norms of its columns."""
        rows = np.concatenate([J, np.diag(self.root)])
        norms = np.linalg.norm(rows, axis=0)
        return (*np.linalg.qr(rows / norms), norms)

    def residuals(self, model: KinematicModel) -> FloatArray:
        """Return nominal minus modelled parameters over their expected errors, shape (m,)."""
        return -self.root * model_difference(self.parameters, self.start, model)


@dataclass(frozen=True, slots=True, eq=False)
class Minimum:
    """Where Levenberg-Marquardt stopped, with the whitened residuals and Jacobian there."""

    model: KinematicModel
    prior: Prior
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
    model: KinematicModel, prior: Prior, theta: FloatArray, observations: PoseObservations, noise: Noise
) -> Minimum:
    """Return residuals and Jacobian at a model; nothing is moved.

    `theta`: shape (N, n). Model angles of the rows, rad.
    """
    problem = _PoseProblem(prior, theta, observations, noise)
    at = problem.at(model)
    return Minimum(model, prior, noise, at.r, problem.jacobian(at), 0, converged=True)


def minimise(
    model: KinematicModel, prior: Prior, theta: FloatArray, observations: PoseObservations, noise: Noise
) -> Minimum:
    """Find the parameters with the least sum of squared residuals, each divided by its noise.

    `theta`: shape (N, n). Model angles of the rows, rad.
    """
    problem = _PoseProblem(prior, theta, observations, noise)
    still = max(STILL_SIGMAS, ROUND_OFF_MM / noise.sigma_mm) * float(np.sqrt(observations.equations))
    found = minimise_squares(problem, problem.at(model), still=still, most_steps=MAX_STEPS, first_damping=FIRST_DAMPING)
    J = problem.jacobian(found.state)
    return Minimum(found.state.model, prior, noise, found.state.r, J, found.steps, found.converged)


@dataclass(frozen=True, slots=True, eq=False)
class _ModelAt:
    """A model with its whitened residuals, shape (6 N,) or (3 N,), and those of its parameters, shape (m,)."""

    model: KinematicModel
    r: FloatArray
    own: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _PoseProblem:
    """The `wpcal.optim.levenberg_marquardt.SquaresProblem` of measured poses."""

    prior: Prior
    theta: FloatArray
    observations: PoseObservations
    noise: Noise

    def at(self, model: KinematicModel) -> _ModelAt:
        sigmas = [self.noise.sigma_mm]
        if self.observations.has_orientations:
            sigmas.insert(0, self.noise.sigma_rad)
        r = pose_errors(model, self.theta, self.observations) / np.repeat(sigmas, 3)
        whole = (r * np.sqrt(self.observations.weights)[:, None]).ravel()
        return _ModelAt(model, whole, self.prior.residuals(model))

    def jacobian(self, at: _ModelAt) -> FloatArray:
        """Derivatives of the modelled poses: minus those of the residuals."""
        J = at.model.jacobian(self.prior.parameters, self.theta, self.observations.reflector)
        return whitened(J, self.observations, self.noise)

    def cost(self, at: _ModelAt) -> float:
        return float(at.r @ at.r + at.own @ at.own)

    def normal_equations(self, at: _ModelAt) -> tuple[FloatArray, FloatArray]:
        J, root = self.jacobian(at), self.prior.root
        return -J.T @ at.r - root * at.own, J.T @ J + np.diag(root**2)

    def moved(self, at: _ModelAt, step: FloatArray) -> _ModelAt:
        return self.at(at.model.moved(self.prior.parameters, step))


def estimate_noise(fit: Minimum, observations: PoseObservations) -> Noise:
    """Variance components: the squared residuals of each kind over its share of the degrees of freedom.

    Rows with a weight below one do not count.
    """
    Q = fit.prior.split(fit.J)[0][: len(fit.J)]
    full = observations.weights == 1.0
    freedom = (1.0 - np.sum(Q * Q, axis=1)).reshape(len(observations), -1, 3)[full]
    r = fit.r.reshape(len(observations), -1, 3)[full]
    sigma_mm = max(LEAST_MM, fit.noise.sigma_mm * _scale(r[:, -1], freedom[:, -1]))
    if not observations.has_orientations:
        return Noise(sigma_mm, fit.noise.sigma_rad)
    return Noise(sigma_mm, max(LEAST_RAD, fit.noise.sigma_rad * _scale(r[:, 0], freedom[:, 0])))


def _scale(r: FloatArray, freedom: FloatArray) -> float:
    """Root of the sum of squares of whitened residuals over what is expected of it; 1 where the noise was right."""
    return float(np.sqrt(np.sum(r * r) / max(float(np.sum(freedom)), np.finfo(float).eps)))
