"""Numbers with the digits that a controller keeps."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray
from wpcal.core.rotations import rotation_from_zyx, rotation_from_zyz, zyx_angles, zyz_angles
from wpcal.core.transform import RigidTransform


def rounded(values: ArrayLike, decimals: int) -> FloatArray:
    """Round numbers to decimals; a zero gets no sign. Of the same shape."""
    return np.asarray(np.round(np.asarray(values, dtype=np.float64), decimals) + 0.0, dtype=np.float64)


def texts(values: ArrayLike, decimals: int) -> list[list[str]]:
    """Return the numbers of a table, shape (n, k), with this many decimals."""
    return [[f"{value:.{decimals}f}" for value in row] for row in rounded(values, decimals).tolist()]


def zyx_degrees(R: ArrayLike, *, decimals: int) -> FloatArray:
    r"""Return the angles of ``R = Rz(γ) Ry(β) Rx(α)`` in degrees, rounded with the least change of the rotation.

    An error of γ rotates about z and an error of α about the rotated x, with :math:`z\cdot x'' = -\sin\beta`. α is
    therefore moved by :math:`e_\gamma \sin\beta` before it is rounded, where :math:`e_\gamma` is the rounding error of
    γ. The rotation is then wrong by at most √3/2 units of the last digit. Rounding each angle alone gives up to √5/2
    near β = ±90°.

    `R`: array_like, shape (..., 3, 3)

    Returns shape (..., 3). α, β, γ about x, y, z, degrees. If β is rounded to ±90°, only γ ∓ α matters, and α is 0.
    """
    angles = np.degrees(zyx_angles(R))
    alpha, beta, gamma = (angles[..., i] for i in range(3))
    b = rounded(beta, decimals)
    locked = np.abs(b) == 90.0
    both = np.remainder(gamma - np.sign(b) * alpha + 180.0, 360.0) - 180.0
    alpha, gamma = np.where(locked, 0.0, alpha), np.where(locked, both, gamma)
    g = rounded(gamma, decimals)
    a = np.where(locked, 0.0, alpha + (g - gamma) * np.sin(np.radians(beta)))
    return np.stack([rounded(a, decimals), b, g], axis=-1)


def zyz_degrees(R: ArrayLike, *, decimals: int) -> FloatArray:
    """Return the angles of ``R = Rz(o) Ry(a) Rz(t)`` in degrees, rounded with the least change of the rotation.

    An error of o rotates about z, and one of t about the rotated z, with z · z'' = cos a. t is therefore moved by the
    rounding error of o times cos a before it is rounded, as in `zyx_degrees`.

    `R`: array_like, shape (..., 3, 3).
    Returns shape (..., 3). o, a, t, degrees. If a is rounded to 0 or 180°, only o ± t matters, and t is 0.
    """
    angles = np.degrees(zyz_angles(R))
    o, a, t = (angles[..., i] for i in range(3))
    middle = rounded(a, decimals)
    locked = (middle == 0.0) | (middle == 180.0)
    both = np.remainder(o + np.where(middle == 0.0, t, -t) + 180.0, 360.0) - 180.0
    o = np.where(locked, both, o)
    first = rounded(o, decimals)
    last = np.where(locked, 0.0, t + (o - first) * np.cos(np.radians(a)))
    return np.stack([first, middle, rounded(last, decimals)], axis=-1)


def rounded_frame(T: RigidTransform, *, mm_decimals: int, deg_decimals: int, is_zyz: bool = False) -> RigidTransform:
    """Return the frame with the rounded numbers that a controller is given.

    Points are written relative to this frame, so its rounding does not move them in `base`.
    """
    degrees, rotation = (zyz_degrees, rotation_from_zyz) if is_zyz else (zyx_degrees, rotation_from_zyx)
    R = rotation(*np.radians(degrees(T.R, decimals=deg_decimals)))
    return RigidTransform(R, rounded(T.t_mm, mm_decimals), T.target, T.source)
