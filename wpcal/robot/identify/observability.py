"""Which poses to measure: the set that sees every parameter best, out of candidates all over the workspace.

References: Borm, Menq 1991, Determination of optimal measurement configurations for robot calibration based on
observability measure: O1, the geometric mean of the singular values. Mitchell 1974, DETMAX: exchange of points of a
design.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.robot.identify.identifiability import TRACKER, split_determined, whitened
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import KinematicModel, Parameter
from wpcal.robot.kinematics.arm import Arm

POSE_PLAN_SCHEMA = "wpcal/pose-plan/1"
Z_95 = 1.96  #: Half width of the 95 % interval of a Gaussian, in standard deviations.
CANDIDATES = 1500
"""Random poses to choose from: with more of them the index of the chosen set grows by less than a percent."""
LIMIT_MARGIN_RAD = np.deg2rad(5.0)
"""Candidates keep this far off the joint limits, where a controller already slows down or refuses."""
EXCHANGES = 200
"""Most exchanges of a chosen pose for a better one; the set settles after about as many as it has poses."""
EXCHANGE_GAIN = 1e-6  #: An exchange that raises the logarithm of the determinant by less is round-off.
RIDGE = 1e-8  #: Added to the information of the first few poses, which alone do not see every parameter.


@dataclass(frozen=True, slots=True, eq=False)
class PosePlan:
    """Poses to measure."""

    joints: FloatArray  #: shape (N, n). Shown angles, rad, ordered for short moves.
    index: float  #: O1 of the set with columns of the Jacobian scaled to one unit of noise.
    #: O1 of a random set of as many of the candidates (the mean of twenty): what the choice gains over chance.
    random_index: float
    #: shape (m,). Standard deviation to expect of each parameter with a laser tracker's noise, mm and rad.
    expected_sigma: FloatArray
    parameters: tuple[Parameter, ...]

    def expected_95(self) -> list[dict[str, Any]]:
        """Return the half width of each parameter's 95 % interval to expect, mm and degrees, as plain values."""
        return [
            {
                "parameter": parameter.name,
                "unit": "mm" if parameter.is_length else "deg",
                "half_width_95": Z_95 * float(sigma if parameter.is_length else np.rad2deg(sigma)),
            }
            for sigma, parameter in zip(self.expected_sigma, self.parameters, strict=True)
        ]

    def to_record(self, arm: Arm) -> dict[str, Any]:
        """Return the record ``wpcal/pose-plan/1``, angles in degrees."""
        return {
            "schema": POSE_PLAN_SCHEMA,
            "robot": arm.name,
            "poses_deg": np.rad2deg(self.joints).tolist(),
            "observability": self.index,
            "random_observability": self.random_index,
            "expected_95": self.expected_95(),
        }


def plan_poses(
    arm: Arm,
    count: int,
    *,
    parameters: Sequence[Parameter],
    rng: np.random.Generator,
    positions_only: bool = False,
    above_mm: float | None = None,
) -> PosePlan:
    """Pick `count` poses that see the parameters best.

    Raises `InputError` when there are fewer poses than the parameters need, or too few candidates above the height.

    Chosen for the largest determinant of the information matrix (O1 to a power): first greedily, then by exchanges. It
    does not matter for this choice in which units the parameters are.
    """
    joints = _candidates(arm, rng, above_mm, count)
    model = KinematicModel(arm.chain)
    theta = arm.model_angles(joints)
    p, R = model.poses(theta, np.zeros(len(joints), dtype=np.int64))
    seen = PoseObservations(joints, p, None if positions_only else R)
    kept, _ = split_determined(model, parameters, theta, seen)
    rows = seen.equations // len(seen)
    if count * rows <= len(kept):
        raise InputError(f"{count} poses give {count * rows} numbers for {len(kept)} parameters; plan more poses")
    J = whitened(model.jacobian(kept, theta, seen.reflector), seen, TRACKER).reshape(len(seen), rows, len(kept))
    blocks = np.asarray(J / np.sqrt(np.mean(np.sum(J * J, axis=1), axis=0)), dtype=np.float64)
    chosen = _exchange(blocks, _greedy(blocks, count))
    covariance = np.linalg.inv(np.einsum("nij,nik->jk", J[chosen], J[chosen]))
    chance = [_index(blocks, rng.choice(len(joints), count, replace=False)) for _ in range(20)]
    return PosePlan(
        joints=joints[_short_way(joints, chosen)],
        index=_index(blocks, chosen),
        random_index=float(np.mean(chance)),
        expected_sigma=np.sqrt(np.diag(covariance)),
        parameters=kept,
    )


def _candidates(arm: Arm, rng: np.random.Generator, above_mm: float | None, count: int) -> FloatArray:
    low, high = arm.limits
    low, high = np.maximum(low + LIMIT_MARGIN_RAD, -np.pi), np.minimum(high - LIMIT_MARGIN_RAD, np.pi)
    joints = rng.uniform(low, high, (4 * CANDIDATES, len(arm.joints)))
    if above_mm is not None:
        joints = joints[arm.forward(joints)[:, 2, 3] > above_mm]
    if len(joints) < 4 * count:
        raise InputError(
            f"only {len(joints)} of {4 * CANDIDATES} random poses stay above {above_mm:g} mm; lower the height"
        )
    return joints[:CANDIDATES]


def _greedy(blocks: FloatArray, count: int) -> list[int]:
    """Take poses one by one, each the one that multiplies the determinant most: ``det(I + B M⁻¹ Bᵀ)``."""
    rows, m = blocks.shape[1:]
    information = RIDGE * np.eye(m)
    chosen: list[int] = []
    for _ in range(count):
        gain = _log_gain(blocks, np.asarray(np.linalg.inv(information), dtype=np.float64), np.eye(rows))
        gain[chosen] = -np.inf
        best = int(np.argmax(gain))
        chosen.append(best)
        information += blocks[best].T @ blocks[best]
    return chosen


def _log_gain(blocks: FloatArray, inverse: FloatArray, identity: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.slogdet(identity + blocks @ inverse @ np.swapaxes(blocks, 1, 2))[1], dtype=np.float64)


def _exchange(blocks: FloatArray, chosen: list[int]) -> list[int]:
    """Give away the pose that is worth least and take the best other one, until nothing is won."""
    identity = np.eye(blocks.shape[1])
    information = np.asarray(np.einsum("nij,nik->jk", blocks[chosen], blocks[chosen]), dtype=np.float64)
    for _ in range(EXCHANGES):
        inverse = np.linalg.inv(information)
        loss = -np.linalg.slogdet(identity - blocks[chosen] @ inverse @ np.swapaxes(blocks[chosen], 1, 2))[1]
        worst = int(np.argmin(loss))
        less = information - blocks[chosen[worst]].T @ blocks[chosen[worst]]
        gain = _log_gain(blocks, np.asarray(np.linalg.inv(less), dtype=np.float64), identity)
        gain[chosen] = -np.inf
        best = int(np.argmax(gain))
        if gain[best] - loss[worst] < EXCHANGE_GAIN:
            break
        information = less + blocks[best].T @ blocks[best]
        chosen[worst] = best
    return chosen


def _index(blocks: FloatArray, chosen: Sequence[int] | np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> float:
    """O1: geometric mean of the singular values over the root of the number of poses."""
    singular = np.linalg.svd(blocks[list(chosen)].reshape(-1, blocks.shape[2]), compute_uv=False)
    return float(np.exp(np.mean(np.log(singular))) / np.sqrt(len(chosen)))


def _short_way(joints: FloatArray, chosen: list[int]) -> list[int]:
    """Order the poses so that each is the nearest (largest joint move) of those left; the first is nearest to zero."""
    left = sorted(chosen)
    way = [min(left, key=lambda i: float(np.abs(joints[i]).max()))]
    left.remove(way[0])
    while left:
        moves = np.abs(joints[left] - joints[way[-1]]).max(axis=1)
        way.append(left.pop(int(np.argmin(moves))))
    return way
