r"""A batched primal-dual interior-point method for the least largest distance, in the tangent of SE(3).

Every problem of the batch is

.. math:: \min_{\xi, s} \; s \quad\text{so that}\quad f_i(\xi) \le s, \qquad f_i = |q_i - \exp(\xi) T p_i|^2,

and each step solves the 7×7 Newton equations of its optimality conditions: :math:`\sum_i w_i \nabla f_i = 0`,
:math:`\sum_i w_i = 1`, :math:`w_i (s - f_i) = \mu`. The multipliers :math:`w` are the weights of the certificate.

Lengths are scaled: residuals by the first largest distance, rotations by the size of the cloud, so that every
number in the iteration is near one.

References: Mehrotra, S. (1992), SIAM J. Optim. 2(4), 575 (predictor and corrector); Boyd and Vandenberghe (2004), ch.
11.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.calibrate.solve.least_squares import distances
from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.rotations import cross_matrix
from wpcal.core.tangent import exp_rotation
from wpcal.optim.least_largest import TO_BOUNDARY, room

MAX_STEPS = 60  #: A regular problem takes 8 to 15 steps; what has not come to rest after 60 needs another start.
GOAL = 1e-14
"""Scaled optimality error of the squared distances at which a problem is done: 1e-14 of the largest distance."""
EXACT = 1e-14  #: Largest distance, in sizes of the cloud, that is round-off: such a fit is exact.
LEAST_CURVATURE = 1e-9  #: Least eigenvalue of the scaled Hessian (largest: about 2) that is still told from round-off.
MAX_TURN_RAD = 0.5
"""Longest rotation of one step: the quadratic model of a rotation is off by angle³/6, 2 % of the radius here."""


@dataclass(frozen=True, slots=True, eq=False)
class InteriorPointState:
    """State of a batch of B problems with n points; the batch axis comes first."""

    #: `R`, `t`: shapes (B, 3, 3) and (B, 3). The fits, in the frames of the points given (mm).
    R: FloatArray
    t: FloatArray
    weights: FloatArray  #: shape (B, n). Multipliers, each row summing to one.
    largest: FloatArray  #: shape (B,). Largest distance, mm.
    converged: BoolArray  #: shape (B,).
    steps: int  #: Newton steps until the last problem of the batch was done.


def solve_interior_point(p: FloatArray, q: FloatArray, R: FloatArray, t: FloatArray) -> InteriorPointState:
    """Find the locally least largest distance of every problem of a batch.

    `p`, `q`: shape (B, n, 3). Source and target points, about their centroids, mm.
    `R`, `t`: shapes (B, 3, 3) and (B, 3). Where each problem starts; an exact fit is its own answer.
    Returns: The best fit met on the way, and the multipliers of the last step.
    """
    batch, n = p.shape[:2]
    best_R, best_t, best = R.copy(), t.copy(), distances(p, q, R, t).max(axis=1)
    weights, done = np.full((batch, n), 1.0 / n), best <= EXACT * np.abs(q).max(axis=(1, 2))
    rows = np.flatnonzero(~done)
    work = _Work(p[rows], q[rows], R[rows], t[rows])
    steps = 0
    while len(rows) and steps < MAX_STEPS:
        work.step()
        steps += 1
        largest = np.sqrt(work.largest_squared) * work.unit
        better = largest < best[rows]
        kept = rows[better]
        best_R[kept], best_t[kept], best[kept] = work.R[better], work.t[better], largest[better]
        weights[rows] = work.w
        reached = work.optimality_error() <= np.maximum(GOAL, work.round_off)
        done[rows[reached]] = True
        if reached.any():
            rows = rows[~reached]
            work.keep(~reached)
    weights = np.maximum(weights, 0.0)
    weights /= weights.sum(axis=1, keepdims=True)
    return InteriorPointState(best_R, best_t, weights, best, done, steps)


class _Work:
    """The running problems of a batch, scaled."""

    def __init__(self, p: FloatArray, q: FloatArray, R: FloatArray, t: FloatArray) -> None:
        self.p, self.q, self.R, self.t = p, q, R, t
        self.size = np.sqrt(np.mean(np.sum(p**2, axis=2), axis=1))
        self._evaluate_residuals()
        self.unit = np.sqrt(np.einsum("bij,bij->bi", self.r, self.r).max(axis=1))
        self.r /= self.unit[:, None, None]
        # A squared scaled distance of order one carries the round-off of coordinates of the cloud's size.
        self.round_off = 16.0 * np.finfo(np.float64).eps * (1.0 + self.size / self.unit)
        self._evaluate_squares()
        n = p.shape[1]
        self.s = 1.1 * self.largest_squared
        self.w = np.full(self.f.shape, 1.0 / n)
        self.z = self.s[:, None] - self.f

    _PER_PROBLEM = (
        "p",
        "q",
        "R",
        "t",
        "size",
        "unit",
        "round_off",
        "r",
        "y",
        "f",
        "s",
        "w",
        "z",
        "largest_squared",
        "C",
    )

    def keep(self, chosen: BoolArray) -> None:
        """Go on with some of the problems only."""
        for name in self._PER_PROBLEM:
            setattr(self, name, getattr(self, name)[chosen])

    def _evaluate_residuals(self) -> None:
        self.y = self.p @ self.R.transpose(0, 2, 1)
        self.r = self.q - self.y - self.t[:, None, :]

    def _evaluate_squares(self) -> None:
        """Squared scaled distances f and their gradients C = -2 (y × r / size, r)."""
        self.f = np.einsum("bij,bij->bi", self.r, self.r)
        self.largest_squared = self.f.max(axis=1)
        (a, b, c), (x, y, z) = self.y.transpose(2, 0, 1), self.r.transpose(2, 0, 1)
        self.C = np.empty((*self.f.shape, 6))
        self.C[:, :, 0], self.C[:, :, 1], self.C[:, :, 2] = b * z - c * y, c * x - a * z, a * y - b * x
        self.C[:, :, :3] /= self.size[:, None, None]
        self.C[:, :, 3:] = self.r
        self.C *= -2.0

    def optimality_error(self) -> FloatArray:
        """Scaled gap between the largest squared distance and the value of the dual, to second order."""
        total = self.w.sum(axis=1)
        gap = self.largest_squared - np.einsum("bi,bi->b", self.w, self.f) / total
        torque = (self.w[:, None, :] @ self.C)[:, 0]
        return np.asarray(gap + np.einsum("bk,bk->b", torque, torque), dtype=np.float64)

    def _hessian(self) -> FloatArray:
        """Hessian of Σ w f; without its curvature term if that would make it indefinite."""
        w = self.w[:, None, :]
        sum_y = (w @ self.y)[:, 0] / self.size[:, None]
        outer = (self.y.transpose(0, 2, 1) * w) @ self.y / (self.size**2)[:, None, None]
        H = np.zeros((len(self.w), 6, 6))
        eye = np.eye(3)
        H[:, :3, :3] = 2.0 * (np.trace(outer, axis1=1, axis2=2)[:, None, None] * eye - outer)
        H[:, :3, 3:] = 2.0 * cross_matrix(sum_y)
        H[:, 3:, :3] = H[:, :3, 3:].transpose(0, 2, 1)
        H[:, 3:, 3:] = 2.0 * self.w.sum(axis=1)[:, None, None] * eye
        cross = (self.r.transpose(0, 2, 1) * w) @ self.y
        cross *= (self.unit / self.size**2)[:, None, None]
        full = H.copy()
        full[:, :3, :3] += 2.0 * np.trace(cross, axis1=1, axis2=2)[:, None, None] * eye
        full[:, :3, :3] -= cross + cross.transpose(0, 2, 1)
        if _surely_convex(full):
            return full
        convex = np.linalg.eigvalsh(full)[:, 0] > LEAST_CURVATURE
        return np.asarray(np.where(convex[:, None, None], full, H + LEAST_CURVATURE * np.eye(6)), dtype=np.float64)

    def step(self) -> None:
        """One predictor and corrector step of every problem."""
        slack_error = self.s[:, None] - self.f - self.z
        D = self.w / self.z
        DC = D[:, :, None] * self.C
        K = np.zeros((len(self.w), 7, 7))
        K[:, :6, :6] = self._hessian() + self.C.transpose(0, 2, 1) @ DC
        K[:, :6, 6] = K[:, 6, :6] = -DC.sum(axis=1)
        K[:, 6, 6] = D.sum(axis=1)
        # A direction that no active point resists leaves K singular; round-off of its largest entry makes it regular.
        K += 4.0 * np.finfo(np.float64).eps * np.abs(K).max(axis=(1, 2))[:, None, None] * np.eye(7)
        mu = np.mean(self.w * self.z, axis=1)
        zero = np.zeros_like(self.w)
        dx, dw, dz = self._direction(K, D, slack_error, zero)
        alpha = np.minimum(room(self.w, dw), room(self.z, dz))
        after = np.mean((self.w + alpha[:, None] * dw) * (self.z + alpha[:, None] * dz), axis=1)
        sigma = np.clip(after / mu, 0.0, 1.0) ** 3  # Mehrotra's centring
        target = (sigma * mu)[:, None] - dw * dz
        dx, dw, dz = self._direction(K, D, slack_error, target)
        alpha = np.minimum(1.0, TO_BOUNDARY * np.minimum(room(self.w, dw), room(self.z, dz)))
        turn = np.linalg.norm(dx[:, :3], axis=1) * self.unit / self.size
        alpha = np.minimum(alpha, MAX_TURN_RAD / np.maximum(turn, MAX_TURN_RAD))
        self._move(alpha, dx, dw, dz)

    def _direction(
        self, K: FloatArray, D: FloatArray, slack_error: FloatArray, target: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Newton direction for w z = target with the multipliers and slacks eliminated."""
        push = target / self.z - D * slack_error
        rhs = np.empty((len(self.w), 7, 1))
        rhs[:, :6, 0] = -(push[:, None, :] @ self.C)[:, 0]
        rhs[:, 6, 0] = push.sum(axis=1) - 1.0
        dx = np.linalg.solve(K, rhs)[:, :, 0]
        dz = dx[:, 6, None] - (self.C @ dx[:, :6, None])[:, :, 0] + slack_error
        dw = (target - self.w * dz) / self.z - self.w
        return np.asarray(dx), np.asarray(dw), np.asarray(dz)

    def _move(self, alpha: FloatArray, dx: FloatArray, dw: FloatArray, dz: FloatArray) -> None:
        a = alpha[:, None]
        turn = exp_rotation(a * dx[:, :3] * (self.unit / self.size)[:, None])
        self.R = turn @ self.R
        self.t = self.t + a * dx[:, 3:6] * self.unit[:, None]
        self.s = self.s + alpha * dx[:, 6]
        self.w, self.z = self.w + a * dw, self.z + a * dz
        self._evaluate_residuals()
        self.r /= self.unit[:, None, None]
        self._evaluate_squares()


def _surely_convex(H: FloatArray) -> bool:
    """Whether all matrices, shape (B, 6, 6), are positive definite by twice `LEAST_CURVATURE`; False is no proof."""
    try:
        np.linalg.cholesky(H - 2.0 * LEAST_CURVATURE * np.eye(6))
    except np.linalg.LinAlgError:
        return False
    return True
