r"""Which of the six motions of the part the touches hold, and the name of a motion that is free.

The residuals change with a small motion by :math:`J\xi`. Its singular values, with rotations in mm at the touches'
own radius, say how strongly each motion is held: a motion of 1 mm changes the residuals by that many mm in all. If a
singular value is nearly zero, its singular vector is a free motion.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wpcal.calibrate.observe.touches import NamedAxis, Touches
from wpcal.calibrate.solve.touches import Pose, scaled_jacobian
from wpcal.calibrate.trust.touch_evidence import HeldMotion
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError
from wpcal.core.wording import short

FREE = 1e-3
"""Below this share of the largest singular value a teaching error is amplified a thousandfold: the motion is free."""
HOLDS = 0.1  #: A touch holds a motion if it makes up at least this share of the motion's residuals.
SLIDES = 1e-6  #: A motion whose rotation is a smaller share than this is called sliding.
PITCH = 1e-3  #: A motion that advances less than this share of its arc is called a turn, not a screw.
ON_AXIS_MM = 0.1  #: An axis this near to a named one is called by its name.
NAMED_AXIS_COS = 1.0 - 1e-6  #: An axis turned less than this from a named one (0.08 degrees) is called by its name.


def held_motions(touches: Touches, pose: Pose) -> tuple[HeldMotion, ...]:
    """Return the six motions of the part, the best held first, with the touches that hold each.

    Raises `GeometryError` when a motion is free; it is named.
    """
    axes = touches.axes
    J, pivot, length = scaled_jacobian(touches, pose)
    n = len(touches)
    U, values, Vt = np.linalg.svd(J.reshape(3 * n, 6), full_matrices=False)
    in_part = np.concatenate([Vt[:, :3] @ pose.R, Vt[:, 3:] @ pose.R], axis=1)
    middle = pose.R.T @ (pivot - pose.t)
    free = values <= FREE * values[0]
    if free.any():
        raise GeometryError(
            f"the touches leave the part free: it {free_words(in_part[free], middle, length, axes)}. They hold "
            f"{int((~free).sum())} of six freedoms; touch a face that hinders this"
        )
    shares = np.sum(U.reshape(n, 3, 6) ** 2, axis=1)
    return tuple(
        HeldMotion(
            _motion(in_part[k], middle, length, axes),
            float(values[k]),
            tuple(touches.names[i] for i in np.argsort(-shares[:, k], kind="stable") if shares[i, k] >= HOLDS),
        )
        for k in range(6)
    )


def free_words(free: FloatArray, pivot: FloatArray, length_mm: float, axes: Sequence[NamedAxis]) -> str:
    """Say motions that are free: ``slides along (1 0 0); turns about the axis of H1``.

    `free`: shape (k, 6). A basis of the motions in `part`: the rotation about the pivot times `length_mm`, and the
    translation.
    `pivot`: shape (3,). In `part`, mm.
    """
    _, _, coefficients = np.linalg.svd(free[:, :3].T)  # slidings apart from turns: the last rows have no turn at all
    return "; ".join(_motion(xi, pivot, length_mm, axes) for xi in coefficients @ free)


def _motion(xi: FloatArray, pivot: FloatArray, length_mm: float, axes: Sequence[NamedAxis]) -> str:
    """Say a motion: a sliding, a turn about an axis, or a screw."""
    omega, v = xi[:3] / length_mm, xi[3:]
    speed = float(np.linalg.norm(omega))
    if speed * length_mm <= SLIDES:
        return f"slides along ({_numbers(_upright(v / np.linalg.norm(v)))})"
    direction = _upright(omega / speed)
    point = pivot + np.cross(omega, v) / speed**2
    advance = abs(float(v @ omega)) / speed**2
    about = _axis_words(point, direction, axes)
    if advance <= PITCH * length_mm:
        return f"turns about {about}"
    return f"screws about {about}, {short(2 * np.pi * advance)} mm a turn"


def _axis_words(point: FloatArray, direction: FloatArray, axes: Sequence[NamedAxis]) -> str:
    for axis in axes:
        off = np.linalg.norm(np.cross(point - axis.point, axis.direction))
        if off <= ON_AXIS_MM and abs(float(direction @ axis.direction)) >= NAMED_AXIS_COS:
            return f"the axis of {axis.name}"
    foot = point - (point @ direction) * direction
    return f"the axis ({_numbers(direction)}) through ({_numbers(foot)})"


def _upright(direction: FloatArray) -> FloatArray:
    """Turn a direction so that its largest component is positive."""
    return np.asarray(direction * np.sign(direction[np.argmax(np.abs(direction))]))


def _numbers(vector: FloatArray) -> str:
    return " ".join(f"{round(float(value), 3) + 0.0:g}" for value in vector)
