r"""The fit of least sum of squares where the least largest distance leaves turns free that are not about one line.

With multipliers w the optimal fits are among those of least :math:`\sum_i w_i d_i^2`. If points that carry lie on a
line and were taught in another order, or the taught points are mirrored, these are a family: the weighted centroid
stays, and the part turns by :math:`\exp(N c)`, where N holds the one, two or three axes with no torque. The least sum
of squares over c, with no distance above the largest one, is found by sequential quadratic programming and then, with
the points that limit it, by Newton's method on its optimality conditions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from wpcal.calibrate.observe.motions import left_jacobian
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.tangent import exp_rotation

FREE = 1e-9  #: An axis whose stiffness is below this share of the carrying points' sum of squares is free.
ROUND_OFF = 1e-12
"""Share of the largest lever times the distance of the carrying points: a stiffness below is round-off. Where the
carrying points coincide (one feature taught twice), nothing but round-off resists a turn, and every turn is free."""
ON_LINE = 1e-6  #: Carrying points whose second spread is this share of the first lie on a line.
SLACK = 1e-10  #: Share of the squared limit by which the search may exceed it, so that it has room to move.
NO_BETTER = 1e-7
"""The search is accurate to about this; what it finds must keep the limit and lower the sum to that accuracy."""
TOUCHES = 1e-6  #: A squared distance within this share of the limit may limit the turn.
LEAST_MULTIPLIER = 1e-9  #: A point that does not carry and has a smaller multiplier only touches the limit.
NEWTON_STEPS = 8  #: From the accuracy of sequential quadratic programming two or three steps lead to round-off.
AT_REST = 1e-15  #: Turn in rad that is round-off.
INDEPENDENT = 1e-7
"""Singular values of the conditions below this share of the largest belong to points that say the same."""


def on_line(p: FloatArray, weights: FloatArray) -> bool:
    """Whether the points with a weight lie on one line.

    `p`: shape (n, 3). mm.
    `weights`: shape (n,). Not negative, with the sum one.
    """
    spread = np.linalg.svd(np.sqrt(weights)[:, None] * (p - weights @ p), compute_uv=False)
    return bool(spread[1] <= ON_LINE * spread[0])


def free_axes(p: FloatArray, q: FloatArray, R: FloatArray, weights: FloatArray) -> FloatArray:
    """Axes in the target frame about which the part may turn without changing Σ w d², shape (3, m).

    `p`, `q`: shape (n, 3). mm.
    `R`: shape (3, 3). An optimal fit.
    `weights`: shape (n,). Its multipliers.
    """
    u, v = (p - weights @ p) @ R.T, q - weights @ q
    M = (v.T * weights) @ u
    values, vectors = np.linalg.eigh(np.trace(M) * np.eye(3) - 0.5 * (M + M.T))
    scale = float(weights @ np.einsum("ij,ij->i", u, u))
    lever, distance = np.linalg.norm(u, axis=1).max(), np.sqrt(weights @ np.einsum("ij,ij->i", v, v))
    return np.asarray(vectors[:, values <= FREE * scale + ROUND_OFF * lever * distance])


def least_squares_among_best(
    p: FloatArray, q: FloatArray, R: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Turn an optimal fit about its free axes to the least sum of squares.

    `p`, `q`: shape (n, 3). mm.
    `R`: shape (3, 3). An optimal fit.
    `weights`: shape (n,). Its multipliers.

    Returns `R`, `t`: shapes (3, 3) and (3,). None where no turn is free, where only that about the line of the carrying
    points is (`tie_break` decides it), and where the search fails.
    """
    N = free_axes(p, q, R, weights)
    if not N.size or (N.shape[1] == 1 and on_line(p, weights)):
        return None
    u, v = p - weights @ p, q - weights @ q
    limit = float(np.sqrt(np.sum((v - u @ R.T) ** 2, axis=1).max()))
    u, v = u / limit, v / limit
    R = exp_rotation(N @ _Turns(u, v, R, N).search()) @ R
    R = _Turns(u, v, R, free_axes(u, v, R, weights)).polished(weights > 0)
    if np.sum((v - u @ R.T) ** 2, axis=1).max() > 1.0 + SLACK:
        return None
    return R, weights @ q - R @ (weights @ p)


class _Turns:
    """The squared distances as functions of the free turn; lengths in units of the largest distance of the optimum."""

    def __init__(self, u: FloatArray, v: FloatArray, R: FloatArray, N: FloatArray) -> None:
        self.u, self.v, self.R, self.N = u, v, R, N

    def _moved(self, c: FloatArray) -> FloatArray:
        return np.asarray(self.u @ (exp_rotation(self.N @ c) @ self.R).T)

    def squares(self, c: FloatArray) -> FloatArray:
        """Squared distances, shape (n,)."""
        return np.asarray(np.sum((self.v - self._moved(c)) ** 2, axis=1))

    def slopes(self, c: FloatArray) -> FloatArray:
        """Derivatives of the squared distances by c, shape (n, m)."""
        y = self._moved(c)
        return np.asarray(-2.0 * np.cross(y, self.v - y) @ left_jacobian((self.N @ c)[None])[0] @ self.N)

    def search(self) -> FloatArray:
        """Return the turn c, shape (m,), of least sum of squares that the search reaches; zero if it fails."""
        start = np.zeros(self.N.shape[1])
        within: Any = {"type": "ineq", "fun": lambda c: 1.0 + SLACK - self.squares(c), "jac": lambda c: -self.slopes(c)}
        from scipy.optimize import minimize

        search: Any = minimize
        found = search(
            lambda c: float(self.squares(c).sum()),
            start,
            jac=lambda c: self.slopes(c).sum(axis=0),
            method="SLSQP",
            constraints=within,
            options={"maxiter": 200, "ftol": 1e-15},
        )
        squares = self.squares(found.x)
        is_good = squares.max() <= 1.0 + NO_BETTER and squares.sum() <= self.squares(start).sum() + NO_BETTER
        return np.asarray(found.x) if is_good else start

    def polished(self, carries: BoolArray) -> FloatArray:
        """Rotation after Newton's method on the conditions of the points that limit the turn."""
        tight = carries | (self.squares(np.zeros(self.N.shape[1])) >= 1.0 - TOUCHES)
        for _ in range(len(tight)):
            R, multipliers = self._newton(np.flatnonzero(tight))
            loose = np.flatnonzero(tight)[multipliers < -LEAST_MULTIPLIER]
            loose = loose[~carries[loose]]
            if not len(loose):
                return R
            tight[loose] = False
        return self.R

    def _newton(self, rows: IntArray) -> tuple[FloatArray, FloatArray]:
        R, N, m = self.R, self.N, self.N.shape[1]
        multipliers = np.zeros(len(rows))
        for _ in range(NEWTON_STEPS):
            y = self.u @ R.T
            r = self.v - y
            C = -2.0 * np.cross(y[rows], r[rows]) @ N
            weights = np.ones(len(y))
            weights[rows] += multipliers
            M = (self.v.T * weights) @ y
            H = 2.0 * N.T @ (np.trace(M) * np.eye(3) - 0.5 * (M + M.T)) @ N
            K = np.block([[H, C.T], [C, np.zeros((len(rows), len(rows)))]])
            slope = -2.0 * np.cross(y, r).sum(axis=0) @ N
            rhs = np.concatenate([-slope, 1.0 - np.einsum("ij,ij->i", r[rows], r[rows])])
            solution = np.linalg.lstsq(K, rhs, rcond=INDEPENDENT)[0]
            multipliers = solution[m:]
            R = exp_rotation(N @ solution[:m]) @ R
            if np.abs(solution[:m]).max() <= AT_REST:
                break
        return R, multipliers
