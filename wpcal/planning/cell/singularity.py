"""The distance of arms from their singular poses, where a small motion of the tool needs a large motion of a joint.

An arm of the OPW family has three kinds: the wrist straight (axes 4 and 6 collinear), the elbow stretched, and the
centre of the wrist on axis 1. Each kind has a measure that is zero there and changes its sign between branches of the
inverse, so a path whose measures stay away from zero keeps its branch.
"""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.same_bits import arc_tangent, length, product, sine_cosine
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import TURN
from wpcal.robot.kinematics.opw import OPWGeometry

LEAST_REGULARITY = 0.1
"""Measures stay above this (a wrist bent by six degrees): joint rates are then at most ten times the tool's rate."""


def regularity(arm: Arm, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Measure the distance from the three singular poses.

    Parameters
    ----------
    q : shape (n, 6). Shown angles, rad.

    Returns
    -------
    values : ndarray, shape (n, 3)
        Wrist: sine of its bend. Elbow: sine of the angle off the stretched arm. Shoulder: distance of the wrist's
        centre from axis 1 in the plane of the arm, in parts of the reach. Absolute values.
    slopes : ndarray, shape (n, 3, 6). Derivatives with respect to the shown angles, per rad.
    """
    g = OPWGeometry.of_chain(arm.as_nominal().chain)
    theta = arm.model_angles(q) * g.signs + g.offsets
    t2, t3, t5 = theta[:, 1], theta[:, 2], theta[:, 4]
    kappa, bend = length([g.a2, g.c3]), arc_tangent(g.a2, g.c3)
    upper, fore = g.c2 / (g.c2 + kappa), kappa / (g.c2 + kappa)
    (s5, s3, s2, s23), (c5, c3, c2, c23) = sine_cosine(np.stack([t5, t3 + bend, t2, t2 + t3 + bend]))
    values = np.stack([s5, s3, g.a1 / (g.c2 + kappa) + upper * s2 + fore * s23], axis=1)
    slopes = np.zeros((len(theta), 3, 6))
    slopes[:, 0, 4] = c5
    slopes[:, 1, 2] = c3
    slopes[:, 2, 2] = fore * c23
    slopes[:, 2, 1] = upper * c2 + slopes[:, 2, 2]
    signs = np.sign(values)
    return np.abs(values), product(signs[:, :, None] * (slopes * g.signs), arm.coupling_matrix)


def is_within_turns(arm: Arm, q: FloatArray) -> BoolArray:
    """Tell which joints some whole turns bring within the limits, shape (...).

    `q`: shape (..., 6). Shown angles, rad; NaN where there are none.
    """
    low, high = arm.limits
    with np.errstate(invalid="ignore"):
        return np.asarray((np.ceil((low - q) / TURN) <= np.floor((high - q) / TURN)).all(axis=-1))


def is_regular(arm: Arm, q: FloatArray) -> BoolArray:
    """Tell which joints are away from singular poses, shape (...).

    `q`: shape (..., 6). Shown angles, rad; NaN where there are none.
    """
    values, _ = regularity(arm, np.nan_to_num(q).reshape(-1, q.shape[-1]))
    return np.asarray((values.min(axis=1) >= LEAST_REGULARITY).reshape(q.shape[:-1])) & np.isfinite(q).all(axis=-1)
