"""Rational B-spline curves and surfaces as arrays: points, exact derivatives, and the nearest point on a surface."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline, NdBSpline
from scipy.spatial import cKDTree

from wpcal.core.arrays import FloatArray

SEEDS_PER_SPAN = 3
"""Grid points a knot span and direction from which the nearest point is sought: a span bends less than a third turn."""
NEWTON_ROUNDS = 12
"""Gauss-Newton halves the digits' distance each round; from a seed within a third of a span 6 rounds were enough."""
SETTLED = 1e-14
"""A point that moves by less than this share of the surface has arrived: 1e-11 mm on one metre."""


@dataclass(frozen=True, eq=False)
class NurbsCurve:
    """A rational B-spline curve.

    Parameters
    ----------
    degree : int
    knots : ndarray, shape (m + degree + 1,)
        Not decreasing, with repetitions.
    poles : ndarray, shape (m, 3)
        mm.
    weights : ndarray, shape (m,)
    """

    degree: int
    knots: FloatArray
    poles: FloatArray
    weights: FloatArray

    @cached_property
    def _splines(self) -> tuple[BSpline, BSpline]:
        h = np.column_stack([self.poles * self.weights[:, None], self.weights])
        spline = BSpline(self.knots, h, self.degree)
        return spline, spline.derivative()

    def evaluate(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return points and first derivatives at parameters t (m,); two arrays (m, 3)."""
        spline, slope = self._splines
        h, dh = spline(t), slope(t)
        p = h[:, :3] / h[:, 3:]
        return p, (dh[:, :3] - p * dh[:, 3:]) / h[:, 3:]

    @property
    def span_count(self) -> int:
        """Number of knot spans that are not empty."""
        return int(np.count_nonzero(np.diff(self.knots)))


@dataclass(frozen=True, eq=False)
class NurbsSurface:
    """A rational B-spline surface, not periodic.

    Parameters
    ----------
    degrees : tuple of int
        In u and v.
    knots_u, knots_v : ndarray
        Not decreasing, with repetitions.
    poles : ndarray, shape (m, n, 3)
        mm.
    weights : ndarray, shape (m, n)
    bounds : tuple of float
        u first, u last, v first, v last: the part that the face uses.
    """

    degrees: tuple[int, int]
    knots_u: FloatArray
    knots_v: FloatArray
    poles: FloatArray
    weights: FloatArray
    bounds: tuple[float, float, float, float]

    @cached_property
    def _spline(self) -> NdBSpline:
        h = np.concatenate([self.poles * self.weights[..., None], self.weights[..., None]], axis=2)
        return NdBSpline((self.knots_u, self.knots_v), h, self.degrees)

    def evaluate(self, uv: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return points and the derivatives along u and v at parameters uv (m, 2); three arrays (m, 3)."""
        h = self._spline(uv)
        p = h[:, :3] / h[:, 3:]
        slopes = []
        for nu in ((1, 0), (0, 1)):
            dh = self._spline(uv, nu=nu)
            slopes.append((dh[:, :3] - p * dh[:, 3:]) / h[:, 3:])
        return p, slopes[0], slopes[1]

    @cached_property
    def _seeds(self) -> tuple[FloatArray, cKDTree]:
        axes = []
        for knots, low, high in ((self.knots_u, *self.bounds[:2]), (self.knots_v, *self.bounds[2:])):
            breaks = np.unique(np.clip(knots, low, high))
            fractions = np.arange(SEEDS_PER_SPAN) / SEEDS_PER_SPAN
            inner = (breaks[:-1, None] + np.diff(breaks)[:, None] * fractions).ravel()
            axes.append(np.append(inner, breaks[-1]))
        uv = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        return uv, cKDTree(self.evaluate(uv)[0])

    def project(self, points: FloatArray) -> FloatArray:
        """Return the parameters (m, 2) of the nearest points of the bounded surface to `points` (m, 3)."""
        seeds, tree = self._seeds
        uv = seeds[tree.query(points)[1]].copy()
        low, high = np.array(self.bounds[0::2]), np.array(self.bounds[1::2])
        settled = SETTLED * (high - low)
        active = np.arange(len(points))
        for _ in range(NEWTON_ROUNDS):
            before = uv[active]
            uv[active] = np.clip(before + self._step(before, points[active]), low, high)
            active = active[(np.abs(uv[active] - before) > settled).any(axis=1)]
            if len(active) == 0:
                break
        return uv

    def _step(self, uv: FloatArray, points: FloatArray) -> FloatArray:
        """Return the Gauss-Newton step towards the nearest point; arrays (m, 2), (m, 3) and (m, 2)."""
        p, du, dv = self.evaluate(uv)
        r = points - p
        a, b, c = (np.einsum("mi,mi->m", x, y) for x, y in ((du, du), (du, dv), (dv, dv)))
        f, g = np.einsum("mi,mi->m", du, r), np.einsum("mi,mi->m", dv, r)
        det = np.where(a * c - b * b == 0, 1.0, a * c - b * b)
        return np.stack([(c * f - b * g) / det, (a * g - b * f) / det], axis=1)
