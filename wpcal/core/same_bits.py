"""Arithmetic that gives the same bits on every processor: for searches, which turn the last bit into another answer.

`@`, `numpy.linalg` and the sines of NumPy choose instructions by the processor (OpenBLAS by `OPENBLAS_CORETYPE` too),
and their last bits differ. Sums, products, quotients and roots of arrays do not: IEEE 754 fixes them. Everything here
is made of these four, with `numpy.einsum`, which adds in a fixed order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, IntArray

FEW_TURNS_RAD = 1e5  #: A search may try larger angles; of these whole turns are taken off first.
HALF_TURN_PARTS = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21)
"""π/2 in parts of 33 bits: whole multiples of the first two are exact (fdlibm, `e_rem_pio2.c`)."""
SINE = (1.58969099521155010221e-10, -2.50507602534068634195e-08, 2.75573137070700676789e-06,
        -1.98412698298579493134e-04, 8.33333333332248946124e-03, -1.66666666666666324348e-01)  # fmt: skip
COSINE = (-1.13596475577881948265e-11, 2.08757232129817482790e-09, -2.75573143513906633035e-07,
          2.48015872894767294178e-05, -1.38888888888741095749e-03, 4.16666666666666019037e-02)  # fmt: skip
"""Coefficients of the sine and the cosine up to π/4 (fdlibm, `k_sin.c` and `k_cos.c`)."""
ATAN_OVER = (-8.750608600031904122785e-1, -1.615753718733365076637e1, -7.500855792314704667340e1,
             -1.228866684490136173410e2, -6.485021904942025371773e1)  # fmt: skip
ATAN_UNDER = (1.0, 2.485846490142306297962e1, 1.650270098316988542046e2, 4.328810604912902668951e2,
              4.853903996359136964868e2, 1.945506571482613964425e2)  # fmt: skip
"""Coefficients of the arc tangent up to 0.66, numerator and denominator (Cephes, `atan.c`)."""
ATAN_SPLIT = 0.66  #: Above this tangent, the arc tangent is found from π/4.
QUARTER_REST = 3.061616997868383e-17  #: What π/4 has beyond its nearest number.
RANK_BITS = 30
"""Costs are compared after rounding to this many bits, nine digits: round-off is far below, and a real gain above."""

PRODUCTS = (("j,j->", "j,...jk->...k"), ("...ij,j->...i", "...ij,...jk->...ik"))
"""Sums of products, by whether the first and the second factor are matrices."""


def product(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Return ``a @ b`` for arrays of shape (...) that `numpy.matmul` takes."""
    left, right = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    return np.asarray(np.einsum(PRODUCTS[left.ndim > 1][right.ndim > 1], left, right), dtype=np.float64)


def length(v: ArrayLike) -> float:
    """Return the length of one vector, shape (k,)."""
    return float(np.sqrt(product(v, v)))


def solve(A: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Solve many small systems by elimination with pivots from the largest of a column.

    Returns `x`: shape (n, k, m). Infinite or NaN where a system is singular.
    Returns `det`: shape (n,). Absolute values of the determinants.

    `A`: shape (n, k, k).
    `b`: shape (n, k, m).
    """
    n, k = len(A), A.shape[1]
    M = np.concatenate([A, b], axis=2)
    row, det = np.arange(n), np.ones(n)
    with np.errstate(divide="ignore", invalid="ignore"):
        for j in range(k):
            best = j + np.argmax(np.abs(M[:, j:, j]), axis=1)
            if (best != j).any():
                M[row, best], M[:, j] = M[:, j].copy(), M[row, best]
            det *= np.abs(M[:, j, j])
            pivot = M[:, j, j:] / M[:, j, j, None]
            M[:, :, j:] -= M[:, :, j, None] * pivot[:, None]
            M[:, j, j:] = pivot
    return M[:, :, k:], det


def poses(R: FloatArray, p: FloatArray) -> FloatArray:
    """Return rigid motions of rotations (..., 3, 3) and origins (..., 3), shape (..., 4, 4)."""
    out = np.zeros((*R.shape[:-2], 4, 4))
    out[..., :3, :3], out[..., :3, 3], out[..., 3, 3] = R, p, 1.0
    return out


def inverse_pose(T: FloatArray) -> FloatArray:
    """Return the inverses of rigid motions, shape (..., 4, 4)."""
    R = np.swapaxes(T[..., :3, :3], -1, -2)
    return poses(R, -np.einsum("...ij,...j->...i", R, T[..., :3, 3]))


def sine_cosine(angle: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return sine and cosine of angles of shape (...), rad; errors below 2e-16 up to some thousand turns."""
    x = np.asarray(angle, dtype=np.float64)
    far = np.abs(x) > FEW_TURNS_RAD
    if far.any():
        x = np.where(far, np.fmod(x, 2.0 * np.pi), x)
    turns = np.rint(x * (2.0 / np.pi))
    x = ((x - turns * HALF_TURN_PARTS[0]) - turns * HALF_TURN_PARTS[1]) - turns * HALF_TURN_PARTS[2]
    z = x * x
    s = x + x * z * _polynomial(SINE, z)
    c = 1.0 - (0.5 * z - z * z * _polynomial(COSINE, z))
    quarter = turns - 4.0 * np.floor(turns / 4.0)
    odd, low = (quarter == 1.0) | (quarter == 3.0), quarter >= 2.0
    sine, cosine = np.where(odd, c, s), np.where(odd, s, c)
    return np.where(low, -sine, sine), np.where(low != odd, -cosine, cosine)


def sine(angle: ArrayLike) -> FloatArray:
    """Return the sine of angles of shape (...), rad, as `sine_cosine` does."""
    return sine_cosine(angle)[0]


def cosine(angle: ArrayLike) -> FloatArray:
    """Return the cosine of angles of shape (...), rad, as `sine_cosine` does."""
    return sine_cosine(angle)[1]


def arc_tangent(y: ArrayLike, x: ArrayLike) -> FloatArray:
    """Return the angles of points (x, y) of shape (...), rad, in [-π, π]; zero for the origin."""
    y, x = np.asarray(y, dtype=np.float64), np.asarray(x, dtype=np.float64)
    high, wide = np.abs(y), np.abs(x)
    large = np.maximum(high, wide)
    t = np.minimum(high, wide) / np.where(large == 0.0, 1.0, large)
    steep = t > ATAN_SPLIT
    t = np.where(steep, (t - 1.0) / (t + 1.0), t)
    z = t * t
    z = z * _polynomial(ATAN_OVER, z) / _polynomial(ATAN_UNDER, z)
    angle = t + t * z
    angle = np.where(steep, (angle + QUARTER_REST) + np.pi / 4, angle)
    angle = np.where(high > wide, np.pi / 2 - angle, angle)
    angle = np.where(np.signbit(x), np.pi - angle, angle)
    return np.asarray(np.copysign(angle, y), dtype=np.float64)


def _polynomial(coefficients: tuple[float, ...], z: FloatArray) -> FloatArray:
    first, second, *rest = coefficients
    value = np.asarray(first * z + second)
    for one in rest:
        value *= z
        value += one
    return value


def ranked(costs: ArrayLike) -> FloatArray:
    """Return costs of shape (...) rounded to `RANK_BITS` bits of the largest finite one: equal ones become the same."""
    values = np.asarray(costs, dtype=np.float64)
    largest = float(np.abs(values).max(initial=0.0, where=np.isfinite(values)))
    return np.asarray(np.rint(np.ldexp(values, RANK_BITS - int(np.frexp(largest)[1]))), dtype=np.float64)


def first_least(costs: ArrayLike, axis: int | None = None) -> IntArray:
    """Return the row of the least cost of shape (...); of costs that are equal after rounding, the first."""
    return np.asarray(np.argmin(ranked(costs), axis=axis))
