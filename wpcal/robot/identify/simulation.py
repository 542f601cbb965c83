"""Simulated measurements of an arm whose real parameters are known: the paper's experiment, and tests of our own."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.tangent import exp_rotation
from wpcal.robot.identify.identifiability import Noise
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import KinematicModel, link_parameters
from wpcal.robot.kinematics.arm import Arm

XIONG_2015_ERRORS = frozen(
    [
        *np.deg2rad([0.1, 0.1, -0.1, 0.2, 0.1, -0.1]),
        2.0,
        np.deg2rad(0.1),
        *(1.5, 2.0, -1.5, 1.0),
        *(2.0, -2.0, 1.5, 2.0, -1.5, 1.0),
        *np.deg2rad([0.1, 0.1, -0.1, 0.2, 0.1, -0.1]),
    ]
)
"""Preset errors of the 24 parameters of an MH6, in the order of `link_parameters` (mm, rad). Table 2 of the paper is
lost in the text at hand; these are its identified values (Table 3) rounded to tenths of a degree and half millimetres,
which reproduces the largest error that its authors' result had (2.9 %, of d1)."""


def random_joints(arm: Arm, count: int, *, rng: np.random.Generator) -> FloatArray:
    """Return shown joint angles drawn evenly within the limits, shape (count, n), rad."""
    low, high = arm.limits
    return rng.uniform(low, high, (count, len(arm.joints)))


def simulate_poses(
    arm: Arm, errors: ArrayLike, joints: ArrayLike, *, rng: np.random.Generator, noise: Noise | None = None
) -> PoseObservations:
    """Return what an instrument measures of an arm whose links are off by `errors`.

    `errors`: shape (m,). Real minus nominal value of its `link_parameters`, mm and rad.
    `joints`: shape (N, n). Shown angles, rad.
    """
    q = np.asarray(joints, dtype=np.float64)
    real = KinematicModel(arm.chain).moved(link_parameters(arm.chain), errors)
    p, R = real.poses(arm.model_angles(q), np.zeros(len(q), dtype=np.int64))
    if noise is None:
        return PoseObservations(q, p, R)
    turned = exp_rotation(rng.normal(0.0, noise.sigma_rad, p.shape)) @ R
    return PoseObservations(q, p + rng.normal(0.0, noise.sigma_mm, p.shape), turned)
