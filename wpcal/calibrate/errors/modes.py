r"""Errors that touches and seams have in common, as few independent unknowns: the robot's field, the part's scale.

A Gaussian field with the covariance K at n places is :math:`f(x) = k(x)^\top V \Lambda^{-1/2} z + r(x)` with the
eigenvectors V of K, independent standard normal z, and a rest r that vanishes at these places. Where a fit has unknowns
of its own for z, what is common to touches and seams cancels as it does in `wpcal.calibrate.errors.budget`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.calibrate.errors.robot_field import Belief, correlation
from wpcal.core.arrays import FloatArray

LEAST_MODE_MM = 0.02
"""A mode that moves places by less counts as an error of each place alone: far below that of a touch."""


@dataclass(frozen=True, slots=True, eq=False)
class ErrorModes:
    """Errors of readings that are the same function of the place at touches and at seams."""

    places: FloatArray  #: shape (n, 3). Where the modes are anchored, mm.
    belief: Belief
    vectors: FloatArray  #: shape (n, q). Eigenvectors over the roots of their eigenvalues.
    tool_mm: float = 0.0  #: Standard deviation per axis of the tool's error in the posture of the welds.

    @classmethod
    def of(cls, places: FloatArray, belief: Belief, tool_mm: float = 0.0) -> ErrorModes:
        """Find the modes at places, shape (n, 3), in the frame in which they are then asked for."""
        values, vectors = np.linalg.eigh(_covariance(belief, places, places))
        kept = values > LEAST_MODE_MM**2
        return cls(places, belief, vectors[:, kept] / np.sqrt(values[kept]), tool_mm)

    def __len__(self) -> int:
        return 3 * int(self.vectors.shape[1]) + 1

    def at(self, points: FloatArray) -> FloatArray:
        """Return what one standard deviation of each unknown moves readings by, shape (k, 3, len), mm."""
        moved = np.kron(_covariance(self.belief, points, self.places) @ self.vectors, np.eye(3))
        scaled = self.belief.scale * (points - self.places.mean(axis=0))
        return np.concatenate([moved.reshape(len(points), 3, -1), scaled[:, :, None]], axis=2)

    def rest(self, points: FloatArray) -> FloatArray:
        """Return the covariance per axis of what no unknown stands for, between points, shape (k, k), mm²."""
        A = _covariance(self.belief, points, self.places) @ self.vectors
        own = _covariance(self.belief, points, points) - A @ A.T
        return np.asarray(own + self.belief.rest_mm**2 * np.eye(len(points)) + self.tool_mm**2)

    def rest_of(self, places: FloatArray) -> FloatArray:
        """Return the variance per axis of what no unknown stands for, at touches, shapes (n, 3) and (n,), mm²."""
        A = _covariance(self.belief, places, self.places) @ self.vectors
        return np.asarray(np.maximum(self.belief.a2.sum() - (A**2).sum(axis=1), 0.0) + self.belief.rest_mm**2)

    def with_unknowns(self, covariance: FloatArray, gain: FloatArray, places: FloatArray) -> FloatArray:
        """Return the covariance of what a fit finds, then of -z: readings off by F z + r move it by G (F z + r).

        `covariance`: shape (m, m). Of what is found, by errors of the touches alone.
        `gain`: shape (n, m, 3). G. `places`: shape (n, 3). Of the touches.
        """
        moved = np.einsum("nki,niq->kq", gain, self.at(places))
        own = covariance + moved @ moved.T + np.einsum("nki,nli,n->kl", gain, gain, self.rest_of(places))
        return np.block([[own, -moved], [-moved.T, np.eye(len(self))]])


def _covariance(belief: Belief, a: FloatArray, b: FloatArray) -> FloatArray:
    """Covariance per axis of the field between places, shapes (k, 3) and (n, 3); shape (k, n), mm²."""
    found = np.zeros((len(a), len(b)))
    for length, a2 in zip(belief.lengths_mm.tolist(), belief.a2.tolist(), strict=True):
        if a2:
            found += a2 * correlation(a, b, length)
    return found
