"""Identification as published: a genetic algorithm over the whole box, then tabu search from its best.

References: Xiong, Yang, Wang 2015. Eq. (7): the fitness is the sum of the error distances of all poses, with
orientations as roll, pitch, yaw; how a distance joins millimetres and angles is lost in the text at hand and ours: see
`PoseFitness`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.optim.genetic import GeneticResult, solve_genetic
from wpcal.optim.tabu import TabuResult, solve_tabu
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import KinematicModel, Parameter
from wpcal.robot.identify.pose_residuals import Prior
from wpcal.robot.kinematics.forward import LINK_SYMBOLS, start_frames, walk

ANGLE_LENGTH_MM = 1000.0
"""Ours: an error of 1 rad weighs as much as one of this length, about the reach of the arms at hand. Both halves of a
pose error then have one size, since an angle off at a joint moves the flange by the angle times the distance."""
EXPECTED_MM, EXPECTED_RAD = 2.0, float(np.deg2rad(0.2))
"""Expected errors of a length and an angle: the largest of the paper's Table 2."""
BOUND_FACTOR = 3.0  #: Bounds are this multiple of the expected error (§2.1).


class PoseFitness:
    """Sum over the poses of ``sqrt(|Δp|² + (L |Δrpy|)²)`` for many sets of link parameters at once (eq. 7).

    `parameters`: Link parameters: the coordinates of a state, as corrections in mm and rad.
    `theta`: shape (N, n). Model angles, rad.
    """

    def __init__(
        self,
        start: KinematicModel,
        parameters: Sequence[Parameter],
        theta: FloatArray,
        observations: PoseObservations,
        *,
        angle_length_mm: float = ANGLE_LENGTH_MM,
    ) -> None:
        self._chain = start.chain
        self._offset = start.reflectors_flange[observations.reflector].T[:, None]
        self._rows = np.array([LINK_SYMBOLS.index(parameter.symbol) for parameter in parameters])
        self._links = np.array([parameter.index for parameter in parameters])
        self._theta = np.ascontiguousarray(theta.T)[:, None]
        self._p = observations.p_base.T[:, None]
        R = observations.R_base_flange
        self._rpy = None if R is None else _rpy(*np.moveaxis(R, 0, 2).swapaxes(0, 1))[:, None]
        self._length = angle_length_mm

    def __call__(self, states: FloatArray) -> FloatArray:
        """Return costs (m,), mm, of states (m, d)."""
        table = np.repeat(self._chain.table[:, :, None], len(states), axis=2)
        table[self._rows, self._links] += states.T
        *_, last = walk(start_frames(self._chain.T_base_dh0, 2), table[..., None], self._theta)
        flange = last.frame.then(self._chain.T_dhn_flange)
        square = np.sum((flange.point(self._offset) - self._p) ** 2, axis=0)
        if self._rpy is not None:
            off = _rpy(flange.x, flange.y, flange.z) - self._rpy
            off -= 2.0 * np.pi * np.rint(off / (2.0 * np.pi))  # the shorter way round
            square += self._length**2 * np.sum(off**2, axis=0)
        return np.asarray(np.sqrt(square).sum(axis=-1), dtype=np.float64)


def _rpy(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    """Roll, pitch, yaw about x, y, z of ``Rz Ry Rx`` with these axes, shape (3, ...), rad."""
    roll = np.arctan2(y[2], z[2])
    pitch = np.arctan2(-x[2], np.hypot(x[0], x[1]))
    return np.stack([roll, pitch, np.arctan2(x[1], x[0])])


@dataclass(frozen=True, slots=True, eq=False)
class GeneticTabuFit:
    """What the published method found."""

    model: KinematicModel
    parameters: tuple[Parameter, ...]
    steps: FloatArray  #: shape (m,). Identified minus nominal values, mm and rad.
    genetic: GeneticResult
    tabu: TabuResult


def solve_genetic_tabu(
    prior: Prior,
    theta: FloatArray,
    observations: PoseObservations,
    *,
    rng: np.random.Generator,
    expected_mm: float = EXPECTED_MM,
    expected_rad: float = EXPECTED_RAD,
) -> GeneticTabuFit:
    """Identify link parameters by a genetic algorithm and tabu search. `theta`: ndarray, shape (N, n)."""
    kept = prior.parameters
    fitness = PoseFitness(prior.start, kept, theta, observations)
    width = BOUND_FACTOR * np.where([p.is_length for p in kept], expected_mm, expected_rad)
    first = solve_genetic(fitness, -width, width, rng=rng)
    second = solve_tabu(fitness, first.state, -width, width, rng=rng)
    return GeneticTabuFit(prior.start.moved(kept, second.state), kept, second.state, first, second)
