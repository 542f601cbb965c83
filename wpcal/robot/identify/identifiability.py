"""Which parameters the measurements determine, and which of them cannot be told apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import KinematicModel, Parameter

DEPENDENT_PART = 1e-6
"""A column of the Jacobian counts as a combination of others when less than this fraction of it remains: exact
dependence of a nominal model leaves 1e-13, the weakest parameter of a well-posed case more than 1e-3."""
NAMED_PART = 0.1
"""The message about an unseen parameter names the parameters with at least this share in its combination."""


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviation of one measured coordinate (mm) and of one component of a measured turn (rad)."""

    sigma_mm: float
    sigma_rad: float


TRACKER = Noise(sigma_mm=0.05, sigma_rad=float(np.deg2rad(0.005)))
"""A laser tracker with a probe at 2 to 3 m: weights until the residuals say what the noise really is."""


@dataclass(frozen=True, slots=True)
class Unseen:
    """A parameter that the measurements cannot tell from others; it keeps its nominal value."""

    parameter: Parameter
    like: tuple[str, ...]  #: Names of the kept parameters it cannot be told from: those with a large share.
    #: How much each kept parameter changes per unit of this one, in the order of the kept ones. Where the true value
    #: differs from the nominal one, the kept parameters absorb the difference in these shares.
    shares: tuple[float, ...]

    @property
    def name(self) -> str:
        """The name of the parameter."""
        return self.parameter.name

    def __str__(self) -> str:
        return (
            f"{self.name} cannot be seen"
            if not self.like
            else f"{self.name} cannot be told from {', '.join(self.like)}"
        )


def whitened(J: FloatArray, observations: PoseObservations, noise: Noise) -> FloatArray:
    """Scale a Jacobian to standard deviations and weights, and stack its rows, shape (6 N, m) or (3 N, m).

    `J`: shape (N, 6, m). Derivatives of the poses: turn (rad), then position (mm).
    """
    sigmas = np.repeat([noise.sigma_rad, noise.sigma_mm], 3)[:, None]
    rows = J / sigmas if observations.has_orientations else J[:, 3:] / sigmas[3:]
    rows = rows * np.sqrt(observations.weights)[:, None, None]
    return np.asarray(rows.reshape(-1, J.shape[2]), dtype=np.float64)


def split_determined(
    model: KinematicModel, parameters: Sequence[Parameter], theta: FloatArray, observations: PoseObservations
) -> tuple[tuple[Parameter, ...], tuple[Unseen, ...]]:
    """Split parameters into those the measurements determine and the others.

    `theta`: shape (N, n). Model angles, rad.
    """
    J = whitened(model.jacobian(parameters, theta, observations.reflector), observations, TRACKER)
    norms = np.linalg.norm(J, axis=0)
    lengths = np.array([parameter.is_length for parameter in parameters])
    usual = np.where(lengths, *(norms[kind].max(initial=0.0) for kind in (lengths, ~lengths)))
    basis = np.empty((len(J), 0))
    kept: list[int] = []
    dependent: list[int] = []
    for j in range(len(parameters)):
        if norms[j] <= DEPENDENT_PART * usual[j]:
            dependent.append(j)
            continue
        left = J[:, j] / norms[j]
        for _ in range(2):  # Gram-Schmidt twice is as exact as Householder's
            left = left - basis @ (basis.T @ left)
        size = float(np.linalg.norm(left))
        if size > DEPENDENT_PART and basis.shape[1] < len(J):
            basis = np.column_stack([basis, left / size])
            kept.append(j)
        else:
            dependent.append(j)
    return tuple(parameters[j] for j in kept), tuple(_unseen(parameters, J, norms, usual, kept, j) for j in dependent)


def _unseen(
    parameters: Sequence[Parameter], J: FloatArray, norms: FloatArray, usual: FloatArray, kept: list[int], j: int
) -> Unseen:
    """Name the kept parameters that column j is a combination of, and their shares."""
    parameter = parameters[j]
    if norms[j] <= DEPENDENT_PART * usual[j] or not kept:
        return Unseen(parameter, (), (0.0,) * len(kept))
    parts = np.linalg.lstsq(J[:, kept] / norms[kept], J[:, j] / norms[j], rcond=None)[0]
    like = tuple(parameters[kept[k]].name for k in np.flatnonzero(np.abs(parts) > NAMED_PART))
    return Unseen(parameter, like, tuple((parts * norms[j] / norms[kept]).tolist()))
