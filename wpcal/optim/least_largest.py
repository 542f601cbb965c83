r"""A batched primal-dual interior-point method for residuals that are linear in the motion.

Every problem of a batch has residual vectors :math:`r_i(\xi) = d_i + J_i \xi`, of one to three numbers each, with the
same J. Two problems are solved, both convex:

.. math:: \min_{\xi, s} s \quad\text{with}\quad |r_i|^2 \le s, \qquad\qquad
          \min_\xi \sum |r_i|^2 \quad\text{with}\quad |r_i|^2 \le s_0 .

The first is the minimax fit of touches near a pose. The second chooses among fits whose largest residual is the same.
`wpcal.calibrate.solve.interior_point` solves the first for points, whose residuals it follows around full turns.

References: Mehrotra, S. (1992), SIAM J. Optim. 2(4), 575 (predictor and corrector).
"""

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray

MOST_STEPS = 60  #: A regular problem takes 8 to 20 steps.
GOAL = 1e-15
"""Scaled optimality error at which a problem is done, in units of the square of its first largest residual."""
TO_BOUNDARY = 0.995
"""Part of the way to a zero slack or multiplier that one step may go: the usual choice, 1 would end the iteration."""
EXACT_MM = 1e-12  #: A first largest residual below this is round-off: such a problem is its own answer.


def least_largest(
    d: FloatArray, J: FloatArray, *, goal: float = GOAL, curvature: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Find the motion of least largest residual.

    `d`: shape (B, n, 3). Residuals without motion, mm.
    `J`: shape (n, 3, k). Their derivatives.
    `curvature`: shape (k, k), optional. Hessian, positive semidefinite, that the residuals add to the
    weighted sum of their squares because they are not linear. It holds the motion back where the model is flat.

    Returns `motions`: shape (B, k). The best ones met on the way; without `curvature` never worse than no motion.
    Returns `weights`: shape (B, n). Multipliers. All best motions have the same residuals where they are not zero.
    """
    return _solve(d, J, None, goal, curvature)


def least_squares_within(d: FloatArray, J: FloatArray, most_mm: FloatArray) -> FloatArray:
    """Find the motion of least sum of squares whose largest residual is at most `most_mm`, shape (B,).

    `d`, `J` and the motions are those of `least_largest`. Motions within the bound must exist, not on it alone. The
    caller looks whether the answer keeps the bound.
    """
    return _solve(d, J, most_mm, GOAL)[0]


def _solve(
    d: FloatArray, J: FloatArray, most_mm: FloatArray | None, goal: float, curvature: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    unit = np.linalg.norm(d, axis=2).max(axis=1)
    answer, weights = np.zeros((len(d), J.shape[2])), np.zeros(d.shape[:2])
    rows = np.flatnonzero(unit > EXACT_MM)
    scale = unit[rows]
    bend = np.zeros((J.shape[2], J.shape[2])) if curvature is None else curvature
    work = _Work(d[rows] / scale[:, None, None], J, None if most_mm is None else most_mm[rows] / scale, bend)
    best = np.ones(len(rows))
    for _ in range(MOST_STEPS):
        if not len(rows):
            break
        work.step()
        better = work.largest < best if most_mm is None and curvature is None else np.ones(len(rows), dtype=bool)
        best = np.where(better, work.largest, best)
        answer[rows[better]] = work.xi[better] * scale[better, None]
        weights[rows] = work.w
        error = work.error()
        go_on = np.isfinite(error) & (error > goal)
        if not go_on.all():
            rows, scale, best = rows[go_on], scale[go_on], best[go_on]
            work.keep(go_on)
    return answer, weights


class _Work:
    """The running problems of a batch; residuals in units of the first largest one."""

    def __init__(self, d: FloatArray, J: FloatArray, most: FloatArray | None, bend: FloatArray) -> None:
        batch, n = d.shape[:2]
        self.bend = bend
        self.d, self.J, self.is_bounded = d, J, most is not None
        self.squares = 2.0 * (J.transpose(0, 2, 1) @ J).reshape(n, -1)
        self.xi = np.zeros((batch, J.shape[2]))
        self._evaluate()
        self.s = 1.1 * self.largest if most is None else most**2
        self.w = np.full((batch, n), 1.0 / n)
        self.z = np.maximum(self.s[:, None] - self.f, 0.1 * self.s[:, None])

    def keep(self, chosen: BoolArray) -> None:
        """Go on with some of the problems only."""
        for name in ("d", "xi", "f", "C", "largest", "s", "w", "z"):
            setattr(self, name, getattr(self, name)[chosen])

    def _evaluate(self) -> None:
        r = self.d + (self.xi @ self.J.reshape(-1, self.J.shape[2]).T).reshape(self.d.shape)
        self.f = np.einsum("bij,bij->bi", r, r)
        self.C = np.ascontiguousarray(2.0 * (r.swapaxes(0, 1) @ self.J).swapaxes(0, 1))
        self.largest = self.f.max(axis=1)

    @property
    def _bent(self) -> FloatArray:
        """Gradient of the curvature's own term."""
        return np.asarray(self.xi @ self.bend)

    @property
    def _pull(self) -> FloatArray:
        """Weights of the gradients in the stationarity condition."""
        return self.w + 1.0 if self.is_bounded else self.w

    def error(self) -> FloatArray:
        """Complementarity, force and broken bounds, scaled."""
        force = (self._pull[:, None, :] @ self.C)[:, 0] + self._bent
        slack = np.abs(self.s[:, None] - self.f - self.z).max(axis=1)
        return np.asarray(np.einsum("bi,bi->b", self.w, self.z) + np.einsum("bk,bk->b", force, force) + slack**2)

    def step(self) -> None:
        """One predictor and corrector step of every problem."""
        k = self.J.shape[2]
        D = self.w / self.z
        DC = D[:, :, None] * self.C
        K = np.zeros((len(self.w), k + 1, k + 1))
        K[:, :k, :k] = (self._pull @ self.squares).reshape(-1, k, k) + self.C.transpose(0, 2, 1) @ DC + self.bend
        if self.is_bounded:
            K[:, k, k] = 1.0
        else:
            K[:, :k, k] = K[:, k, :k] = -DC.sum(axis=1)
            K[:, k, k] = D.sum(axis=1)
        # A direction that no active residual resists leaves K singular; round-off of its largest entry makes it regular
        K += 4.0 * np.finfo(np.float64).eps * np.abs(K).max(axis=(1, 2))[:, None, None] * np.eye(k + 1)
        broken = self.s[:, None] - self.f - self.z
        mu = np.mean(self.w * self.z, axis=1)
        _, dw, dz = self._direction(K, D, broken, np.zeros_like(self.w))
        alpha = np.minimum(room(self.w, dw), room(self.z, dz))[:, None]
        after = np.mean((self.w + alpha * dw) * (self.z + alpha * dz), axis=1)
        centring = np.clip(after / mu, 0.0, 1.0) ** 3
        dx, dw, dz = self._direction(K, D, broken, (centring * mu)[:, None] - dw * dz)
        alpha = np.minimum(1.0, TO_BOUNDARY * np.minimum(room(self.w, dw), room(self.z, dz)))[:, None]
        self.xi = self.xi + alpha * dx[:, :k]
        self.s = self.s + alpha[:, 0] * dx[:, k]
        self.w, self.z = self.w + alpha * dw, self.z + alpha * dz
        self._evaluate()

    def _direction(
        self, K: FloatArray, D: FloatArray, broken: FloatArray, target: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Newton direction for w z = target with the multipliers and slacks eliminated."""
        push = target / self.z - D * broken
        pull = push + 1.0 if self.is_bounded else push
        k = self.J.shape[2]
        rhs = np.empty((len(self.w), k + 1, 1))
        rhs[:, :k, 0] = -(pull[:, None, :] @ self.C)[:, 0] - self._bent
        rhs[:, k, 0] = 0.0 if self.is_bounded else push.sum(axis=1) - 1.0
        dx = np.linalg.solve(K, rhs)[:, :, 0]
        dz = dx[:, k, None] - (self.C @ dx[:, :k, None])[:, :, 0] + broken
        dw = (target - self.w * dz) / self.z - self.w
        return np.asarray(dx), np.asarray(dw), np.asarray(dz)


def room(values: FloatArray, change: FloatArray) -> FloatArray:
    """How much of a change (B, n) keeps every one of values (B, n) positive, at most 1 / TO_BOUNDARY; shape (B,)."""
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        ratio = np.where(change < 0, -values / change, np.inf)
    return np.asarray(np.minimum(ratio.min(axis=1), 1.0 / TO_BOUNDARY), dtype=np.float64)
