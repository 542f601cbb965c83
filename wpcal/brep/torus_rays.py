"""Where straight lines meet tori: the real roots of a quartic, for many lines at once.

The length along the line is counted from the point nearest to the centre. The quartic then has no cubic term. It is
divided into two quadratics by the largest root of its resolvent cubic (Descartes), and the roots are made exact by
Newton's steps.
"""

import numpy as np

from wpcal.core.arrays import FloatArray

NEWTON_ROUNDS = 3
"""From the closed form to round-off: two rounds were enough for all but lines that nearly touch the torus."""
ON_TORUS = 1e-11
"""A root at which the quartic is larger than this, on a torus of size 1, belongs to a line that passes by."""
EVEN = 1e-9
"""A root of the resolvent below this is none: the quartic is then even, and its squares are roots of a quadratic."""


def torus_roots(o: FloatArray, d: FloatArray, major_mm: FloatArray, minor_mm: FloatArray) -> FloatArray:
    """Return the distances at which lines meet tori about the z axis.

    `o`, `d`: shape (k, 3). Starts (mm) and unit directions in the frame of each torus.
    `major_mm`, `minor_mm`: shape (k,). Radius of the circle in the middle of the tube, and of the tube.

    Returns shape (k, 4). mm, not sorted; NaN where there is no root. A line that only touches the torus may have none.
    """
    size = major_mm + minor_mm
    nearest = -np.einsum("ki,ki->k", o, d)
    x, y, z = ((o + nearest[:, None] * d) / size[:, None]).T
    ring, tube = major_mm / size, minor_mm / size
    k = x * x + y * y + z * z + ring**2 - tube**2
    flat = 4.0 * ring**2
    p = 2.0 * k - flat * (d[:, 0] ** 2 + d[:, 1] ** 2)
    q = -2.0 * flat * (x * d[:, 0] + y * d[:, 1])
    s = k * k - flat * (x * x + y * y)
    t = _depressed_quartic(p, q, s)
    with np.errstate(divide="ignore", invalid="ignore"):
        for _ in range(NEWTON_ROUNDS):
            value = ((t * t + p[:, None]) * t + q[:, None]) * t + s[:, None]
            slope = (4.0 * t * t + 2.0 * p[:, None]) * t + q[:, None]
            t = t - np.where(slope == 0.0, 0.0, value / slope)
        value = ((t * t + p[:, None]) * t + q[:, None]) * t + s[:, None]
    t = np.where(np.abs(value) <= ON_TORUS, t, np.nan)
    return np.asarray(t * size[:, None] + nearest[:, None], dtype=np.float64)


def _depressed_quartic(p: FloatArray, q: FloatArray, s: FloatArray) -> FloatArray:
    """Return the real roots of t⁴ + p t² + q t + s, shape (k, 4); NaN where there is none."""
    m2 = _largest_cubic_root(2.0 * p, p * p - 4.0 * s, -q * q)
    with np.errstate(divide="ignore", invalid="ignore"):
        m = np.sqrt(np.maximum(m2, 0.0))
        first, second = (p + m2 - q / m) / 2.0, (p + m2 + q / m) / 2.0
        one, two = np.sqrt(m2 - 4.0 * first), np.sqrt(m2 - 4.0 * second)
        general = np.stack([-m - one, -m + one, m - two, m + two]) / 2.0
        root = np.sqrt(p * p - 4.0 * s)
        low, high = np.sqrt((-p - root) / 2.0), np.sqrt((-p + root) / 2.0)
    return np.asarray(np.where(m2 > EVEN, general, np.stack([-high, high, -low, low])).T, dtype=np.float64)


def _largest_cubic_root(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return the largest real roots of y³ + a y² + b y + c, shape (k,)."""
    shift = a / 3.0
    p = b - a * shift
    q = c + shift * (2.0 * shift * shift - b)
    half, third = q / 2.0, p / 3.0
    inside = half * half + third**3
    with np.errstate(divide="ignore", invalid="ignore"):
        w = np.cbrt(-half - np.copysign(np.sqrt(np.maximum(inside, 0.0)), half))
        single = w - np.where(w == 0.0, 0.0, third / w)
        length = np.sqrt(np.maximum(-third, 0.0))
        turn = np.arccos(np.clip(-half / np.where(length > 0.0, length, 1.0) ** 3, -1.0, 1.0))
        y = np.where(inside > 0.0, single, 2.0 * length * np.cos(turn / 3.0)) - shift
        for _ in range(NEWTON_ROUNDS - 1):
            value, slope = ((y + a) * y + b) * y + c, (3.0 * y + 2.0 * a) * y + b
            y = y - np.where(np.abs(slope) > EVEN, value / slope, 0.0)
    return np.asarray(y, dtype=np.float64)
