"""Rotation matrices and the other forms that leave wpcal: Z-Y-X and Z-Y-Z angles, and quaternions.

Convention: column vectors, right-handed; ``R = Rz(gamma) Ry(beta) Rx(alpha)``, verified on the printed numbers of
Yin 2003 (Table 1 and the result beside figure 2). Quaternions are stored x, y, z, w with w >= 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import arc_tangent, product, sine_cosine

GIMBAL_COS = 1e-12
"""Below this value of cos beta, alpha and gamma turn about the same axis: alpha is set to 0 and gamma holds both.
The same counts for the sine of the angle in the middle of Z-Y-Z angles.
Products of rotations are off by about 1e-15, so a quarter turn stays below this; the error is at most this value.
"""


def rotation_from_zyx(alpha: ArrayLike, beta: ArrayLike, gamma: ArrayLike) -> FloatArray:
    """Return ``R = Rz(gamma) Ry(beta) Rx(alpha)`` for angles of any common shape, shape (..., 3, 3).

    `alpha`, `beta`, `gamma`: shape (...). Angles about x, y, z, rad.

    A quarter turn about z carries x to y:

    >>> bool(np.allclose(rotation_from_zyx(0, 0, np.pi / 2) @ [1, 0, 0], [0, 1, 0], rtol=0, atol=1e-15))
    True
    """
    a, b, g = np.broadcast_arrays(*(np.asarray(v, dtype=np.float64) for v in (alpha, beta, gamma)))
    (sa, sb, sg), (ca, cb, cg) = sine_cosine(np.stack([a, b, g]))
    R = np.empty((*a.shape, 3, 3))
    R[..., 0, 0] = cg * cb
    R[..., 0, 1] = cg * sb * sa - sg * ca
    R[..., 0, 2] = cg * sb * ca + sg * sa
    R[..., 1, 0] = sg * cb
    R[..., 1, 1] = sg * sb * sa + cg * ca
    R[..., 1, 2] = sg * sb * ca - cg * sa
    R[..., 2, 0] = -sb
    R[..., 2, 1] = cb * sa
    R[..., 2, 2] = cb * ca
    return R


def zyx_from_rotation(R: ArrayLike) -> tuple[float, float, float]:
    """Return (alpha, beta, gamma), rad, of one rotation matrix; beta is in [-pi/2, pi/2].

    `R`: shape (3, 3). A rotation matrix.

    Returns: Angles about x, y, z, rad. At beta = ±90° only a sum or difference of alpha and gamma is defined: alpha is
    0.
    """
    alpha, beta, gamma = (float(angle) for angle in zyx_angles(R))
    return alpha, beta, gamma


def rx_ry_rz_deg(R: ArrayLike) -> FloatArray:
    """Return rx, ry, rz (R = Rz Ry Rx) in degrees to the digits of a table, without a negative zero, shape (..., 3)."""
    return np.asarray(np.rad2deg(zyx_angles(R)).round(4) + 0.0)


def zyx_angles(R: ArrayLike) -> FloatArray:
    """Return the angles of many rotation matrices, as `zyx_from_rotation` does for one.

    `R`: shape (..., 3, 3). Rotation matrices.
    Returns shape (..., 3). Angles alpha, beta, gamma about x, y, z, rad.
    """
    m = np.asarray(R, dtype=np.float64)
    cos_beta = np.sqrt(m[..., 0, 0] ** 2 + m[..., 1, 0] ** 2)
    gimbal = cos_beta < GIMBAL_COS
    beta = arc_tangent(-m[..., 2, 0], np.where(gimbal, 0.0, cos_beta))
    gamma = np.where(gimbal, arc_tangent(-m[..., 0, 1], m[..., 1, 1]), arc_tangent(m[..., 1, 0], m[..., 0, 0]))
    # Rz(-gamma) R = Ry(beta) Rx(alpha): its second row is 0, cos alpha, -sin alpha, also where gamma is uncertain
    s, c = sine_cosine(gamma)
    alpha = arc_tangent(s * m[..., 0, 2] - c * m[..., 1, 2], c * m[..., 1, 1] - s * m[..., 0, 1])
    return np.stack([np.where(gimbal, 0.0, alpha), beta, gamma], axis=-1)


def rotation_from_zyz(o: ArrayLike, a: ArrayLike, t: ArrayLike) -> FloatArray:
    """Return ``R = Rz(o) Ry(a) Rz(t)`` for angles of any common shape, shape (..., 3, 3).

    `o`, `a`, `t`: shape (...). Angles about z, the moving y and the moving z, rad.

    A tool that points down:

    >>> rotation_from_zyz(0.0, np.pi, 0.0).round(9)[:, 2] + 0.0
    array([ 0.,  0., -1.])
    """
    zero = np.zeros(np.broadcast_shapes(np.shape(o), np.shape(a), np.shape(t)))
    return product(rotation_from_zyx(zero, a, o), rotation_from_zyx(zero, zero, np.asarray(t) + zero))


def zyz_angles(R: ArrayLike) -> FloatArray:
    """Return the angles of rotation matrices as products Rz(o) Ry(a) Rz(t).

    `R`: shape (..., 3, 3). Rotation matrices.

    Returns shape (..., 3). Angles o, a, t, rad; a is in [0, pi]. Where a is 0 or pi, o and t turn about one line: t is
    0.
    """
    m = np.asarray(R, dtype=np.float64)
    sin_a = np.sqrt(m[..., 0, 2] ** 2 + m[..., 1, 2] ** 2)
    gimbal = sin_a < GIMBAL_COS
    a = arc_tangent(np.where(gimbal, 0.0, sin_a), m[..., 2, 2])
    o = np.where(gimbal, arc_tangent(-m[..., 0, 1], m[..., 1, 1]), arc_tangent(m[..., 1, 2], m[..., 0, 2]))
    # Rz(-o) R = Ry(a) Rz(t): its second row is sin t, cos t, 0, also where o is uncertain
    s, c = sine_cosine(o)
    t = arc_tangent(c * m[..., 1, 0] - s * m[..., 0, 0], c * m[..., 1, 1] - s * m[..., 0, 1])
    return np.stack([o, a, np.where(gimbal, 0.0, t)], axis=-1)


def quaternion_from_rotation(R: ArrayLike) -> FloatArray:
    """Return unit quaternions x, y, z, w with w >= 0.

    `R`: shape (..., 3, 3). Rotation matrices.
    Returns shape (..., 4). Where w is 0 (a half turn) the first non-zero of x, y, z is positive.
    """
    m = np.asarray(R, dtype=np.float64)
    flat = m.reshape(-1, 3, 3)
    # The four squared components times four (Shepperd 1978): the largest is at least 1, so dividing by it is safe.
    trace = np.trace(flat, axis1=1, axis2=2)
    squares = np.stack([*(1.0 + 2.0 * flat[:, i, i] - trace for i in range(3)), 1.0 + trace], axis=1)
    rows = np.empty((len(flat), 4, 4))
    x, y, z, w = 0, 1, 2, 3
    rows[:, x, x], rows[:, y, y], rows[:, z, z], rows[:, w, w] = squares.T
    for i, j in ((x, y), (x, z), (y, z)):
        rows[:, i, j] = rows[:, j, i] = flat[:, i, j] + flat[:, j, i]
    for i, (j, k) in enumerate(((2, 1), (0, 2), (1, 0))):
        rows[:, i, w] = rows[:, w, i] = flat[:, j, k] - flat[:, k, j]
    q = np.take_along_axis(rows, np.argmax(squares, axis=1)[:, None, None], axis=1)[:, 0]
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    lead = np.where(q[:, w] != 0, q[:, w], 0.0)
    for i in (z, y, x):
        lead = np.where((q[:, w] == 0) & (q[:, i] != 0), q[:, i], lead)
    q[lead < 0] *= -1.0
    return np.asarray(q.reshape(*m.shape[:-2], 4), dtype=np.float64)


def rotation_from_quaternion(q_xyzw: ArrayLike) -> FloatArray:
    """Return rotation matrices of quaternions x, y, z, w, which are scaled to unit length, shape (..., 3, 3).

    `q_xyzw`: array_like, shape (..., 4).
    """
    q = np.asarray(q_xyzw, dtype=np.float64)
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    v, w = q[..., :3], q[..., 3]
    K = cross_matrix(v)
    return np.asarray(np.eye(3) + 2.0 * (w[..., None, None] * K + product(K, K)), dtype=np.float64)


def cross_matrix(v: ArrayLike) -> FloatArray:
    """Return the matrices [v]× with [v]× u = v × u, shape (..., 3, 3). `v`: array_like, shape (..., 3)."""
    a = np.asarray(v, dtype=np.float64)
    K = np.zeros((*a.shape[:-1], 3, 3))
    K[..., 0, 1], K[..., 0, 2] = -a[..., 2], a[..., 1]
    K[..., 1, 0], K[..., 1, 2] = a[..., 2], -a[..., 0]
    K[..., 2, 0], K[..., 2, 1] = -a[..., 1], a[..., 0]
    return K


def spread_rotations(count: int) -> FloatArray:
    """Return rotations spread evenly over all rotations, shape (count, 3, 3): a super-Fibonacci spiral.

    References: Alexa (2022), Super-Fibonacci spirals, CVPR, algorithm 1; the two constants are its φ and ψ.
    """
    s = np.arange(count) + 0.5
    inner, outer = np.sqrt(s / count), np.sqrt(1.0 - s / count)
    a, b = 2.0 * np.pi * s / np.sqrt(2.0), 2.0 * np.pi * s / 1.533751168755204288118041
    x, y, z, w = inner * np.sin(a), inner * np.cos(a), outer * np.sin(b), outer * np.cos(b)
    return rotation_from_quaternion(np.stack([x, y, z, w], axis=-1))


def cube_rotations() -> FloatArray:
    """Return the 24 rotations of a cube, shape (24, 3, 3): every rotation is within 62.8° of one of them."""
    half = np.sqrt(0.5)
    quarter = [
        [half * (k == i) + half * (k == j) * s for k in range(4)] for i in range(4) for j in range(i) for s in (1, -1)
    ]
    third = [[a, b, c, 0.5] for a in (-0.5, 0.5) for b in (-0.5, 0.5) for c in (-0.5, 0.5)]
    return rotation_from_quaternion(np.array([*np.eye(4), *quarter, *third]))
