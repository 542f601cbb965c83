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
from wpcal.robot.identify.identifiability import TRACKER, Noise, Unseen, split_determined
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import POSE_SYMBOLS, Group, KinematicModel, Parameter
from wpcal.robot.identify.pose_residuals import Minimum, estimate_noise, evaluate, minimise
from wpcal.robot.kinematics.chain import LINK_SYMBOLS

STRONG_CORRELATION = 0.95
"""Pairs of parameters above this are reported by name: their sum or difference is known three times worse than the
other combination at 0.8 and six times at 0.95."""

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
    return _finish(fit, start, unseen, iterations)


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

    Parameters
    ----------
    start : KinematicModel
        The nominal model; differences are measured from it.
    model : KinematicModel
        The model to assess.
    parameters : tuple of Parameter
    theta : ndarray, shape (N, n)
        Model angles of the rows, rad.
    observations : PoseObservations
    unseen : tuple of Unseen
        Parameters left at their start.
    noise : Noise, optional
        Estimated from the residuals unless given.

    Returns
    -------
    LeastSquaresFit
    """
    found = evaluate(model, parameters, theta, observations, noise or TRACKER)
    if noise is None:
        found = evaluate(model, parameters, theta, observations, estimate_noise(found, observations))
    return _finish(found, start, unseen, 0)


def _finish(fit: Minimum, start: KinematicModel, unseen: tuple[Unseen, ...], iterations: int) -> LeastSquaresFit:
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
