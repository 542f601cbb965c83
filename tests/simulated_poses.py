"""What an instrument measures of an arm whose real parameters are known."""

import numpy as np

from wpcal.core.tangent import exp_rotation
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import KinematicModel, link_parameters

XIONG_2015_ERRORS = np.array(
    [
        *np.deg2rad([0.1, 0.1, -0.1, 0.2, 0.1, -0.1]),
        *(2.0, np.deg2rad(0.1), 1.5, 2.0, -1.5, 1.0, 2.0, -2.0, 1.5, 2.0, -1.5, 1.0),
        *np.deg2rad([0.1, 0.1, -0.1, 0.2, 0.1, -0.1]),
    ]
)
"""Preset errors of the 24 `link_parameters` of an MH6 (mm, rad): the values of Table 3 of the paper, rounded, which
reproduce the largest error that its authors' result had (2.9 %, of d1); Table 2 is lost in the text at hand."""


def off_by(arm, errors=XIONG_2015_ERRORS):
    """The arm as it is when its `link_parameters` are off by `errors`."""
    return arm.as_identified(KinematicModel(arm.chain).moved(link_parameters(arm.chain), errors).chain)


def random_joints(arm, count, *, rng):
    """Shown joint angles drawn evenly within the limits, rad."""
    return rng.uniform(*arm.limits, (count, len(arm.joints)))


def simulate_poses(arm, errors, joints, *, rng, noise=None):
    """Measured poses of an arm whose `link_parameters` are off by `errors`, at shown angles, rad."""
    real = KinematicModel(arm.chain).moved(link_parameters(arm.chain), errors)
    p, R = real.poses(arm.model_angles(joints), np.zeros(len(joints), dtype=np.int64))
    if noise is None:
        return PoseObservations(joints, p, R)
    turned = exp_rotation(rng.normal(0.0, noise.sigma_rad, p.shape)) @ R
    return PoseObservations(joints, p + rng.normal(0.0, noise.sigma_mm, p.shape), turned)
