"""Rational B-spline curves and surfaces as arrays; `spans.py` evaluates them, `nearest.py` finds nearest points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class NurbsCurve:
    """A rational B-spline curve."""

    degree: int
    knots: FloatArray  #: shape (m + degree + 1,). Not decreasing, with repetitions.
    poles: FloatArray  #: shape (m, 3). mm.
    weights: FloatArray  #: shape (m,).

    @property
    def span_count(self) -> int:
        """Number of knot spans that are not empty."""
        return int(np.count_nonzero(np.diff(self.knots)))


@dataclass(frozen=True, slots=True, eq=False)
class NurbsSurface:
    """A rational B-spline surface, not periodic."""

    degrees: tuple[int, int]  #: In u and v.
    #: `knots_u`, `knots_v`: Not decreasing, with repetitions.
    knots_u: FloatArray
    knots_v: FloatArray
    poles: FloatArray  #: shape (m, n, 3). mm.
    weights: FloatArray  #: shape (m, n).
    bounds: tuple[float, float, float, float]  #: First u, last u, first v, last v of the part that the face uses.

    @property
    def transposed(self) -> NurbsSurface:
        """The same surface with u and v exchanged; du × dv points to the other side."""
        u0, u1, v0, v1 = self.bounds
        poles, weights = np.ascontiguousarray(self.poles.swapaxes(0, 1)), np.ascontiguousarray(self.weights.T)
        return NurbsSurface(self.degrees[::-1], self.knots_v, self.knots_u, poles, weights, (v0, v1, u0, u1))
