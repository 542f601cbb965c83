"""Point pairs with what is known of their errors, fitted in batches: the rows of the robust fit and of its tests."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wpcal.calibrate.solve.least_squares import COLLINEAR_RATIO, centred, kabsch
from wpcal.calibrate.solve.weighted import refine_once
from wpcal.calibrate.trust.residuals import FLOOR_MM, LEAST_SIGMA_MM
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.pairs import PointPairs

ISOTROPIC = 1e-12
"""A covariance counts as isotropic if it differs from a multiple of the identity by less than this (relative)."""


@dataclass(frozen=True, slots=True, eq=False)
class ErrorRows:
    """Pairs about their centroids with what is known of their errors."""

    #: `p`, `q`: shape (n, 3). Model and taught points, mm.
    p: FloatArray
    q: FloatArray
    #: `covariances`, `information`: shape (n, 3, 3). Of the taught points, and inverse, mm² and mm⁻². If nothing is
    #: known, multiples of the identity of unit size.
    covariances: FloatArray
    information: FloatArray
    #: shape (n,). One third of the traces of the information: the part of it that a closed-form fit can use.
    weights: FloatArray
    scaled: bool  #: Whether the covariances are known with their size.
    isotropic: bool  #: Whether they are multiples of the identity, so that the closed form is exact.

    @classmethod
    def of(cls, pairs: PointPairs, sigma_mm: float | None) -> ErrorRows:
        """Take the stated covariances, or the error per axis `sigma_mm` of all pairs, if known."""
        unit = 1.0 if sigma_mm is None else max(sigma_mm, LEAST_SIGMA_MM)
        covariances = pairs.covariances
        scaled = covariances is not None or sigma_mm is not None
        if covariances is None:
            covariances = np.tile(unit**2 * np.eye(3), (len(pairs), 1, 1))
        information = np.asarray(np.linalg.inv(covariances))
        weights = np.trace(information, axis1=1, axis2=2) / 3.0
        isotropic = bool(
            np.allclose(information, weights[:, None, None] * np.eye(3), rtol=0, atol=ISOTROPIC * weights.max())
        )
        return cls(
            centred(pairs.p_source), centred(pairs.p_target), covariances, information, weights, scaled, isotropic
        )

    def __len__(self) -> int:
        return len(self.p)

    def without_scale(self) -> ErrorRows:
        """Return the rows with the ratios of their errors only."""
        return replace(self, scaled=False)

    def select(self, rows: IntArray | BoolArray) -> ErrorRows:
        """Return rows. `rows`: Indices, or a mask of shape (n,). Any shape of indices makes a batch."""
        covariances, information = self.covariances[rows], self.information[rows]
        return ErrorRows(
            self.p[rows], self.q[rows], covariances, information, self.weights[rows], self.scaled, self.isotropic
        )

    def fit(self) -> tuple[FloatArray, FloatArray]:
        """Fit in closed form with the weights. Anisotropic covariances take one Gauss-Newton step more."""
        R, t = kabsch(self.p, self.q, self.weights / self.weights.sum(axis=-1, keepdims=True))
        if self.isotropic:
            return R, t
        R, t, _ = refine_once(self.p, self.q, self.information, R, t)
        return R, t

    def squares(self, R: FloatArray, t: FloatArray) -> FloatArray:
        """Squared residuals rᵀ Λ r of a fit. `R`, `t`: ndarray, shapes (..., 3, 3), (..., 3)."""
        r = self.q - self.p @ np.swapaxes(R, -1, -2) - t[..., None, :]
        if self.isotropic:
            return np.asarray(self.weights * np.einsum("...ni,...ni->...n", r, r))
        return np.asarray(np.einsum("...ni,...nij,...nj->...n", r, self.information, r))

    def sum_of_squares(self) -> float:
        """Least sum of the squared residuals of one set of rows."""
        return float(self.squares(*self.fit()).sum())

    def floor(self, freedom: int) -> float:
        """Sum of squares that a controller's last digit alone leaves."""
        return freedom * float(self.weights.mean()) * FLOOR_MM**2

    def fixes_rotation(self) -> BoolArray:
        """Tell of every set of a batch whether it fixes a rotation; points in a row do not."""
        values = np.linalg.svd(self.p - self.p.mean(axis=-2, keepdims=True), compute_uv=False)
        return np.asarray(values[..., 1] > COLLINEAR_RATIO * values[..., 0])
