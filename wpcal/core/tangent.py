"""The tangent of SE(3), defined once: rotation first, then translation; perturbation on the left.

A small motion is ``xi = (omega, v)``, rad and mm, and ``T = exp(xi) T0`` moves a point ``p = T0 q`` by
``omega × p + v`` to first order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray
from wpcal.core.rotations import cross_matrix, quaternion_from_rotation
from wpcal.core.same_bits import arc_tangent, product, sine_cosine

SMALL_ANGLE_RAD = 1e-4
"""Below this angle, the series of the sine terms up to the square is exact to round-off (next term: angle^4 / 120)."""


def exp_rotation(omega: ArrayLike) -> FloatArray:
    """Rotation matrices of rotation vectors (Rodrigues), shape (..., 3, 3).

    `omega`: shape (..., 3). Axis times angle, rad.
    """
    w = np.asarray(omega, dtype=np.float64)
    angle = np.linalg.norm(w, axis=-1)[..., None, None]
    small = angle < SMALL_ANGLE_RAD
    safe = np.where(small, 1.0, angle)
    sine, cosine = sine_cosine(safe)
    a = np.where(small, 1.0 - angle**2 / 6.0, sine / safe)
    b = np.where(small, 0.5 - angle**2 / 24.0, (1.0 - cosine) / safe**2)
    K = cross_matrix(w)
    return np.asarray(np.eye(3) + a * K + b * product(K, K), dtype=np.float64)


def log_rotation(R: ArrayLike) -> FloatArray:
    """Rotation vectors of rotation matrices, rad, of length at most pi, shape (..., 3).

    `R`: array_like, shape (..., 3, 3).
    """
    q = quaternion_from_rotation(R)
    v, w = q[..., :3], q[..., 3:]
    sin_half = np.linalg.norm(v, axis=-1, keepdims=True)
    small = sin_half < SMALL_ANGLE_RAD / 2
    factor = np.where(
        small, 2.0 / np.where(small, w, 1.0), 2.0 * arc_tangent(sin_half, w) / np.where(small, 1.0, sin_half)
    )
    return np.asarray(factor * v, dtype=np.float64)


def point_jacobian(points: ArrayLike) -> FloatArray:
    """Derivative of moved points with respect to xi at xi = 0: ``[-[p]×, I]``.

    `points`: shape (..., 3). Points in the target frame of T, mm.
    Returns shape (..., 3, 6). Columns: omega (mm per rad), then v (mm per mm).
    """
    p = np.asarray(points, dtype=np.float64)
    J = np.zeros((*p.shape, 6))
    J[..., :3] = -cross_matrix(p)
    J[..., 3:] = np.eye(3)
    return J


def translation_adjoint(pivot: ArrayLike) -> FloatArray:
    """Carry a small motion about a pivot c to the same motion about the origin: ``[[I, 0], [[c]×, I]]``.

    ``omega × (p - c) + v = omega × p + (v + c × omega)``: the adjoint of the translation by c (Lynch and Park, Modern
    Robotics, 2017, section 3.3.2, where the order of the six is the one used here).

    `pivot`: shape (3,). In the target frame of T, mm.
    Returns shape (6, 6). A covariance C about the pivot is ``A C Aᵀ`` about the origin.

    A turn about an axis along z at x = 100 mm carries the origin along -y:

    >>> (translation_adjoint([100, 0, 0]) @ [0, 0, 0.01, 0, 0, 0]).tolist()
    [0.0, 0.0, 0.01, 0.0, -1.0, 0.0]
    """
    adjoint = np.eye(6)
    adjoint[3:, :3] = cross_matrix(pivot)
    return adjoint
