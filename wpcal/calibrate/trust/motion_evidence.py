r"""Whether bodies moved, which of them, and how far those of this weldment move: likelihoods of the linear model.

The part of the touches that no motion of the whole explains is, with unit errors,
:math:`y = Z u + e`, :math:`u \sim N(0, s^2 I)` in units of the tack tolerances. Its likelihood does not know the pose
(restricted likelihood). With the eigenvalues :math:`\lambda_k` of :math:`Z Z^\top` and :math:`w` the components of y,

.. math:: \ell(s) = -\tfrac12 \sum_k \left( \ln(1 + s^2 \lambda_k) + \frac{w_k^2}{1 + s^2 \lambda_k} \right).

The ratio of the best s to s = 0 has no chi-square distribution, because 0 is the end of its range. Its distribution for
a rigid part is drawn from the same formula, in which w then is standard normal.

References: Patterson and Thompson (1971), Recovery of inter-block information when block sizes are unequal, Biometrika
58. Crainiceanu and Ruppert (2004), Likelihood ratio tests in linear mixed models with one variance component, J. R.
Statist. Soc. B 66.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, null_space, solve_triangular
from scipy.optimize import minimize
from scipy.special import chdtrc, ndtri

from wpcal.calibrate.observe.bodies import Bodies
from wpcal.calibrate.solve.bodies import LOOSE_MM, LOOSE_RAD
from wpcal.calibrate.solve.bodies_problem import Whitened
from wpcal.core.arrays import FloatArray

SCALES = np.concatenate([[0.0], np.geomspace(1e-3, 1e3, 61)])
"""Trial values of s; between two of them, 26 % apart, the likelihood is flat to a hundredth."""
DRAWS = 20000  #: Rigid parts that are drawn; a p of 0.03 is then good to 0.0012.
SURE = 0.03
"""Bodies moved if a rigid part shows as much with a lower probability. At most 5 % of rigid parts may be called moved:
of 200 parts, 5 % are then exceeded by chance in 4 of 100 shops only."""
LEAST_SEEN = 10.0
"""Tolerances are estimated where the touches see at least this many motions: the estimate is then good to 22 %."""
LARGEST_FACTOR = 100.0
"""An estimated tolerance is at most this many times the stated one, and at least the stated one divided by it."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionEvidence:
    """What the touches say of motions of bodies."""

    p_rigid: float  #: Probability that a rigid part shows touches that fit moved bodies as much better.
    #: shape (b,). For each body, the probability of its touches if it alone did not move; 1 for a body that no touch
    #: sees. Corrected for the number of bodies (Holm).
    p_body: FloatArray
    sigmas: FloatArray  #: shape (b,). The same before the correction, as a number of standard deviations.
    seen: float  #: How many motions of bodies the touches see, of 6 b.

    @property
    def has_moved(self) -> bool:
        """Whether the rigid model is refuted."""
        return self.p_rigid < SURE


@dataclass(frozen=True, slots=True, eq=False)
class _Restricted:
    """The touches without what a motion of the whole explains: y = Z u + e."""

    y: FloatArray  #: shape (k,).
    Z: FloatArray  #: shape (k, 6 b).

    @classmethod
    def of(cls, touched: Whitened) -> _Restricted:
        Q = null_space(touched.J.T)
        return cls(Q.T @ touched.r, Q.T @ touched.B).beside(touched.modes)

    def beside(self, count: int) -> _Restricted:
        """Return the model without the last columns of Z: bending, or the robot's error, is an error of the touches."""
        if count == 0:
            return self
        Z, other = self.Z[:, :-count], self.Z[:, -count:]
        solved = np.linalg.solve(
            np.linalg.cholesky(np.eye(len(self.y)) + other @ other.T), np.column_stack([self.y, Z])
        )
        return _Restricted(solved[:, 0], solved[:, 1:])


def judge_motion(touched: Whitened, *, seed: int = 0) -> MotionEvidence:
    """Judge whether the touches need bodies that moved, and which."""
    free = _Restricted.of(touched)
    values, vectors = np.linalg.eigh(free.Z @ free.Z.T)
    values = np.maximum(values, 0.0)
    shrink = 1.0 / (1.0 + np.multiply.outer(SCALES**2, values))
    shown = _ratio((vectors.T @ free.y)[None] ** 2, shrink)[0]
    drawn = _ratio(np.random.default_rng(seed).standard_normal((DRAWS, len(values))) ** 2, shrink)
    p_rigid = (1.0 + np.count_nonzero(drawn >= shown)) / (1.0 + DRAWS)
    p = _of_each(free.beside(touched.bends))
    return MotionEvidence(
        p_rigid, _holm(p), np.asarray(-ndtri(np.maximum(p, 1e-300) / 2.0)), float(np.sum(values / (1.0 + values)))
    )


def _ratio(squares: FloatArray, shrink: FloatArray) -> FloatArray:
    """Twice the logarithm of the best likelihood over that of a rigid part; shapes (d, k), (s, k) → (d,)."""
    change = np.log(shrink).sum(axis=1) + squares @ (1.0 - shrink).T
    return np.asarray(change.max(axis=1))


def _of_each(free: _Restricted) -> FloatArray:
    r"""Probability of each body's touches if it alone did not move, shape (b,).

    With V the covariance of y and :math:`M_b = Z_b^\top V^{-1} Z_b`, the slope :math:`Z_b^\top V^{-1} y` then has the
    covariance :math:`M_b - M_b^2`.
    """
    k, b = len(free.y), free.Z.shape[1] // 6
    solved = np.linalg.solve(np.eye(k) + free.Z @ free.Z.T, np.column_stack([free.y, free.Z]))
    Z = free.Z.reshape(k, b, 6).transpose(1, 2, 0)
    slope = Z @ solved[:, 0]
    M = Z @ solved[:, 1:].reshape(k, b, 6).transpose(1, 0, 2)
    values, vectors = np.linalg.eigh(M - M @ M)
    held = values > 1e-9
    along = np.einsum("bji,bj->bi", vectors, slope)
    square = np.sum(np.where(held, along**2 / np.where(held, values, 1.0), 0.0), axis=1)
    seen = held.sum(axis=1)
    return np.where(seen > 0, chdtrc(np.maximum(seen, 1), square), 1.0)


def _holm(p: FloatArray) -> FloatArray:
    """Probabilities corrected for their number (Holm 1979), shape (b,)."""
    order = np.argsort(p)
    corrected = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    back = np.empty_like(p)
    back[order] = np.minimum(corrected, 1.0)
    return back


def estimated_tolerances(touched: Whitened, bodies: Bodies) -> Bodies | None:
    """Estimate how far bodies of this weldment move, by the restricted likelihood (REML).

    Returns: With tolerances multiplied by a common factor of all turns and one of all shifts, or by one factor of both
    where the touches see fewer than `LEAST_SEEN` motions of a kind. None if they see fewer altogether: the stated
    tolerances then stay.
    """
    free = _Restricted.of(touched).beside(touched.bends)
    is_turn = np.arange(free.Z.shape[1]) % 6 < 3
    kinds = [free.Z[:, is_turn], free.Z[:, ~is_turn]]
    if _seen(free.Z) < LEAST_SEEN:
        return None
    if min(_seen_beside(kinds[0], kinds[1]), _seen_beside(kinds[1], kinds[0])) < LEAST_SEEN:
        kinds = [free.Z]

    squares = [Z @ Z.T for Z in kinds]

    def twice_minus(logs: FloatArray) -> float:
        V = np.eye(len(free.y)) + sum(math.exp(2.0 * log) * ZZ for log, ZZ in zip(logs, squares, strict=True))
        root = cholesky(V, lower=True)
        solved = solve_triangular(root, free.y, lower=True)
        return 2.0 * float(np.log(np.diag(root)).sum()) + float(np.sum(solved**2))

    held = min(min(LOOSE_MM / t.mm, 1e3 * LOOSE_RAD / t.mrad) for t in bodies.tolerances)
    bounds = [(-math.log(LARGEST_FACTOR), math.log(min(LARGEST_FACTOR, max(held, 1.0))))] * len(kinds)
    best = minimize(twice_minus, np.zeros(len(kinds)), method="L-BFGS-B", bounds=bounds)
    factors = np.exp(best.x)
    return bodies.scaled(float(factors[0]), float(factors[-1]))


def _seen(Z: FloatArray) -> float:
    values = np.maximum(np.linalg.eigvalsh(Z @ Z.T), 0.0)
    return float(np.sum(values / (1.0 + values)))


def _seen_beside(Z: FloatArray, other: FloatArray) -> float:
    """Return how many motions of one kind are seen where those of the other kind are not known."""
    V = np.eye(len(Z)) + other @ other.T
    root = np.linalg.cholesky(V)
    return _seen(np.linalg.solve(root, Z))
