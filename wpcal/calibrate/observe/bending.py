r"""How long plates bend: a smooth displacement across the plate along its long axis, beside the motion of the plate.

The curvature of a plate that was cut, tacked and heated is white noise along the plate: the displacement w is
integrated Brownian motion. Motion and turn of the plate are unknowns of their own, so w is free of both. Its components
are then the modes :math:`\varphi_j` of a beam with free ends (Karhunen-Loève),

.. math:: w(s) = \sum_j a_j \varphi_j(s), \qquad \varphi_j'''' = (k_j / L)^4 \varphi_j, \qquad
    a_j \sim N(0,\ \sigma^2 (L / 1\,\mathrm{m})^3\ 420 / k_j^4),

with :math:`\cos k_j \cosh k_j = 1` and :math:`\sum 1 / k_j^4 = 1 / 420`. The stated σ is thus the root mean square of w
along a plate of 1 m; a plate half as long bends by 0.35 of it. Cross-sections stay plane and normal to the axis.

References: Blevins (1979), Formulas for natural frequency and mode shape, table 8-1 (free beam).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import InputError

MODES = 8
"""Modes of each direction; those left out hold 0.2 % of the variance. With six of them the band covers 1 % less."""
FREE_BEAM = np.array([4.730040744862704, 7.853204624095838, 10.995607838001671])
"""The first solutions of cos k cosh k = 1; the others are (j + 1/2) π to 1e-6."""
LEAST_LONG = 2.0  #: A body that is at least this many times as long as wide bends.
SQUARE_COS = 0.02  #: Faces within 1 degree of a right angle are taken for the sides of a box.
NEARLY_SQUARE = 2.0  #: A bar whose section is less than this many times as wide as thick bends across its width, too.


@dataclass(frozen=True, slots=True, eq=False)
class Bends:
    """Directions in which bodies bend, m of them; each has `MODES` amplitudes."""

    body: IntArray  #: shape (m,).
    #: `axis`, `normal`: shape (m, 3). Unit vectors in `part`: along the body, and of the displacement.
    axis: FloatArray
    normal: FloatArray
    half_mm: FloatArray  #: shape (m,). Half the length of the body.
    sigma_mm: float  #: Root mean square displacement of a body of 1 m.

    @classmethod
    def none(cls) -> Bends:
        """No body bends."""
        return cls(np.zeros(0, dtype=np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), 1.0)

    def __len__(self) -> int:
        """Return the number of amplitudes."""
        return MODES * len(self.body)

    @property
    def scales(self) -> FloatArray:
        """Standard deviations of the amplitudes, mm, shape (MODES m,)."""
        each = math.sqrt(420.0) / _roots() ** 2
        return (self.sigma_mm * (2e-3 * self.half_mm[:, None]) ** 1.5 * each).ravel()

    def shapes(self, direction: int, s_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the modes of one direction and their slopes.

        `s_mm`: shape (n,). Along the axis from the middle of the body; beyond its ends the ends count.
        Returns tuple of ndarray, shapes (n, MODES). Displacement and slope (per mm) of an amplitude of 1 mm.
        """
        half = float(self.half_mm[direction])
        x, kappa = np.clip(s_mm / half, -1.0, 1.0)[:, None], _roots() / 2.0
        far = np.exp(kappa * (np.abs(x) - 1.0))  # cosh and sinh by their value at the end, without overflow
        back = np.exp(-2.0 * kappa * np.abs(x))
        end = np.exp(-2.0 * kappa)
        cosh, sinh = (1.0 + back) / (1.0 + end), np.sign(x) * (1.0 - back) / (1.0 - end)
        is_even = np.arange(MODES) % 2 == 0
        w = np.where(
            is_even, np.cos(kappa * x) / np.cos(kappa) + far * cosh, np.sin(kappa * x) / np.sin(kappa) + far * sinh
        )
        to_sinh, to_cosh = (1.0 - end) / (1.0 + end), (1.0 + end) / (1.0 - end)
        slope = np.where(
            is_even,
            -np.sin(kappa * x) / np.cos(kappa) + far * sinh * to_sinh,
            np.cos(kappa * x) / np.sin(kappa) + far * cosh * to_cosh,
        )
        return w, slope * kappa / half


def find_bends(points: Sequence[FloatArray], normals: Sequence[FloatArray], sigma_mm: float) -> Bends:
    """Find the bodies that are long enough to bend, and the directions in which they do.

    `points`: shapes (k, 3). Points of the border of each body, in `part`, mm.
    `normals`: shapes (f, 3). Unit normals of its plane faces.
    Raises `InputError` when `sigma_mm` is not positive.
    """
    if not 0.0 < sigma_mm < math.inf:
        raise InputError(f"the bending of a plate of 1 m must be a positive number of mm, got {sigma_mm:g}")
    rows: list[tuple[int, FloatArray, FloatArray, float]] = []
    for body, (p, own) in enumerate(zip(points, normals, strict=True)):
        axes, size = _box(p, own)
        if size[0] < LEAST_LONG * size[1]:
            continue
        across = [2, 1] if size[1] < NEARLY_SQUARE * size[2] else [2]
        rows += [(body, axes[0], axes[k], float(size[0]) / 2.0) for k in across]
    if not rows:
        raise InputError(f"no body is {LEAST_LONG:g} times as long as wide: none can bend")
    body_of, axis, normal, half = zip(*rows, strict=True)
    return Bends(np.array(body_of), np.array(axis), np.array(normal), np.array(half), sigma_mm)


def _box(p: FloatArray, normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the axes of a body along its length, width and thickness, shape (3, 3), and its size along them, mm."""
    tried = np.concatenate([normals, np.linalg.eigh(np.cov((p - p.mean(axis=0)).T))[1].T])
    size = np.ptp(p @ tried.T, axis=0)
    thin = tried[np.argmin(size)]
    flat = np.flatnonzero(np.abs(tried @ thin) < SQUARE_COS)
    long = tried[flat[np.argmax(size[flat])]] if len(flat) else np.linalg.svd(thin[None])[2][1]
    long = long - (long @ thin) * thin
    long /= np.linalg.norm(long)
    axes = np.stack([long, np.cross(thin, long), thin])
    return axes, np.ptp(p @ axes.T, axis=0)


def _roots() -> FloatArray:
    """K of the first `MODES` modes of a beam with free ends."""
    return np.concatenate([FREE_BEAM, (np.arange(4, MODES + 1) + 0.5) * math.pi])
