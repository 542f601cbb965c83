"""Levenberg-Marquardt on whole paths: all points move at once, and only neighbouring points share a residual.

The normal equations are a chain of blocks, so that one step costs about as much as the residuals of the path. Limits
enter as squares of the excess over them. Which limits count is decided again in every step, by the state after it.

The loop is not `wpcal.optim.levenberg_marquardt` because of this structure: that solver forms dense normal matrices
(657 rows for 73 points of nine coordinates), and it has no set of active limits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.same_bits import product, solve

FIRST_DAMPING = 1e-2  #: Of Levenberg-Marquardt, relative to the diagonal.
LARGEST_DAMPING = 1e6  #: Steps as short as this demands improve nothing any more.
LEAST_DAMPING = 1e-6  #: Below this the damping has no effect on a step, and would take long to come back.
WINDOW, LEAST_GAIN = 5, 2e-3
"""The loop ends if this many steps together gain less than this part of the sum: an objective then changes by a
thousandth."""
LEAST_CURVATURE = 1e-9
"""Added to the diagonal: a coordinate without influence (the spin of a torch at rest) does not move."""
ACTIVE_ROUNDS = 4  #: Most rounds that look for the limits which count after a step. Two or three are usually enough.
Path = TypeVar("Path")


@dataclass(frozen=True, slots=True, eq=False)
class LinearModel:
    """The sum of squares of a path, as a function of a small step of the k coordinates of its n points."""

    deviation: FloatArray  #: shape (n, d). Weighted deviations from what is asked for.
    ddeviation: FloatArray  #: shape (d, k). Their derivatives, the same at every point.
    beyond: FloatArray  #: shape (n, h). Excess of each point over its limits, weighted; it counts where positive.
    dbeyond: FloatArray  #: shape (n, h, k).
    move: FloatArray  #: shape (n - 1, j). Weighted steps of j joints.
    dq: FloatArray  #: shape (n, j, k). Derivatives of the joints.
    scale: FloatArray  #: shape (n - 1, j). Weights of the joint steps.

    @property
    def cost(self) -> float:
        """The sum of squares."""
        return float((self.deviation**2).sum() + (np.maximum(self.beyond, 0.0) ** 2).sum() + (self.move**2).sum())

    def predicted_cost(self, step: FloatArray) -> float:
        """Return the sum of squares after a step of shape (n, k), to first order of every residual."""
        deviation = self.deviation + product(step, self.ddeviation.T)
        move = self.move + self.scale * np.diff(np.einsum("nmi,ni->nm", self.dq, step), axis=0)
        beyond = np.maximum(self.beyond_after(step), 0.0)
        return float((deviation**2).sum() + (beyond**2).sum() + (move**2).sum())

    def beyond_after(self, step: FloatArray) -> FloatArray:
        """Return the excess over the limits after a step of shape (n, k), to first order; shape (n, h)."""
        return np.asarray(self.beyond + np.einsum("nmi,ni->nm", self.dbeyond, step), dtype=np.float64)

    def gradient(self, active: BoolArray) -> FloatArray:
        """Return half the gradient of the sum if the limits in `active`, shape (n, h), count; shape (n, k)."""
        gradient = product(self.deviation, self.ddeviation) + np.einsum(
            "nmi,nm->ni", self.dbeyond, np.where(active, self.beyond, 0.0)
        )
        pull = self.scale * self.move
        gradient[:-1] -= np.einsum("nmi,nm->ni", self.dq[:-1], pull)
        gradient[1:] += np.einsum("nmi,nm->ni", self.dq[1:], pull)
        return np.asarray(gradient, dtype=np.float64)

    def normal(self, active: BoolArray) -> tuple[FloatArray, FloatArray]:
        """Return the normal matrix if the limits in `active`, shape (n, h), count.

        Returns `diagonal`: shape (n, k, k). Blocks of the points.
        Returns `coupling`: shape (n - 1, k, k). Blocks between each point and the next: rows of the point, columns of
        the next.
        """
        limits = self.dbeyond * active[:, :, None]
        before, after = self.scale[:, :, None] * self.dq[:-1], self.scale[:, :, None] * self.dq[1:]
        diagonal = _squared(limits, limits) + product(self.ddeviation.T, self.ddeviation)
        diagonal[:-1] += _squared(before, before)
        diagonal[1:] += _squared(after, after)
        return diagonal, -_squared(before, after)


def _squared(a: FloatArray, b: FloatArray) -> FloatArray:
    return product(np.swapaxes(a, 1, 2), b)


def descend(
    path: Path,
    linearise: Callable[[Path], LinearModel],
    moved: Callable[[Path, FloatArray], Path | None],
    *,
    iterations: int = 80,
) -> Path:
    """Minimise a sum of squares, starting from a path. Never with a larger sum than the start.

    `moved`: From a path and a step of shape (n, k) to the path after it; None where it leaves what is possible.
    """
    damping, model = FIRST_DAMPING, linearise(path)
    costs = [model.cost]
    while len(costs) <= iterations and damping < LARGEST_DAMPING:
        step = damped_step(model, damping)
        after = None if step is None else moved(path, step)
        model_after = None if after is None else linearise(after)
        if step is None or after is None or model_after is None or not model_after.cost < model.cost:
            damping *= 4.0
            continue
        ratio = (model.cost - model_after.cost) / max(model.cost - model.predicted_cost(step), 1e-300)
        damping = max(damping * max(0.2, 1.0 - (2.0 * min(ratio, 1.0) - 1.0) ** 3), LEAST_DAMPING)  # Nielsen 1999
        path, model = after, model_after
        costs.append(model.cost)
        if len(costs) > WINDOW and costs[-1] > (1.0 - LEAST_GAIN) * costs[-1 - WINDOW]:
            break
    return path


def damped_step(model: LinearModel, damping: float) -> FloatArray | None:
    """Return the step that minimises the damped model with the limits that count after it.

    Returns ndarray, shape (n, k), or None. None where round-off makes the normal matrix singular.
    """
    active, step = model.beyond > 0, None
    for _ in range(ACTIVE_ROUNDS):
        diagonal, coupling = model.normal(active)
        entries = np.arange(diagonal.shape[1])
        diagonal[:, entries, entries] += damping * diagonal[:, entries, entries] + LEAST_CURVATURE
        step = solve_chain(diagonal, coupling, -model.gradient(active)[:, :, None])[:, :, 0]
        if not np.isfinite(step).all():
            return None
        after = model.beyond_after(step) > 0
        if (after == active).all():
            break
        active = after
    return step


def solve_chain(diagonal: FloatArray, coupling: FloatArray, right: FloatArray) -> FloatArray:
    """Solve a symmetric system whose blocks meet only their neighbours, by eliminating every other block.

    Returns ndarray, shape (n, k, m).

    `diagonal`: ndarray, shape (n, k, k).
    `coupling`: shape (n - 1, k, k). Rows of a block, columns of the next.
    `right`: ndarray, shape (n, k, m).

    Note: Cyclic reduction (Golub, Van Loan, Matrix Computations, 4.5.4): the depth is log2 n, and each step is a few
    products of many small matrices.
    """
    n, k = diagonal.shape[:2]
    if n == 1:
        return solve(diagonal, right)[0]
    left = np.swapaxes(coupling[0::2], 1, 2)  # of the odd blocks, to the block before
    beyond = np.zeros((n // 2, k, k))
    beyond[: (n - 1) // 2] = coupling[1::2]
    odd, _ = solve(diagonal[1::2], np.concatenate([left, beyond, right[1::2]], axis=2))
    back, ahead, alone = odd[..., :k], odd[..., k : 2 * k], odd[..., 2 * k :]
    kept, rest = diagonal[0::2].copy(), right[0::2].copy()
    kept[: n // 2] -= product(coupling[0::2], back)
    rest[: n // 2] -= product(coupling[0::2], alone)
    after = (n - 1) // 2
    kept[1:] -= _squared(coupling[1::2], ahead[:after])
    rest[1:] -= _squared(coupling[1::2], alone[:after])
    x = np.empty(right.shape)
    x[0::2] = solve_chain(kept, -product(coupling[0::2][:after], ahead[:after]), rest)
    x[1::2] = alone - product(back, x[0::2][: n // 2])
    x[1::2][:after] -= product(ahead[:after], x[2::2])
    return x
