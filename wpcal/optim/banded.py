"""Levenberg-Marquardt on whole paths: all points move at once, and only neighbouring points share a residual.

The normal equations are banded, so that one step costs about as much as the residuals of the path. Limits enter as
squares of the excess over them. Which limits count is decided again in every step, by the state after it.

The loop is not `wpcal.optim.levenberg_marquardt` because of this structure: that solver forms dense normal matrices
(657 rows for 73 points of nine coordinates), and it has no set of active limits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from scipy.linalg import LinAlgError, solveh_banded

from wpcal.core.arrays import BoolArray, FloatArray

FIRST_DAMPING = 1e-2
"""Of Levenberg-Marquardt, relative to the diagonal."""
LARGEST_DAMPING = 1e6
"""Steps as short as this demands improve nothing any more."""
LEAST_DAMPING = 1e-6
"""Below this the damping has no effect on a step, and would take long to come back."""
WINDOW, LEAST_GAIN = 5, 2e-3
"""The loop ends if this many steps together gain less than this part of the sum: an objective then changes by a
thousandth."""
LEAST_CURVATURE = 1e-9
"""Added to the diagonal: a coordinate without influence (the spin of a torch at rest) does not move."""
ACTIVE_ROUNDS = 4
"""Most rounds that look for the limits which count after a step. Two or three are usually enough."""

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
        deviation = self.deviation + step @ self.ddeviation.T
        move = self.move + self.scale * np.diff(np.einsum("nmi,ni->nm", self.dq, step), axis=0)
        beyond = np.maximum(self.beyond_after(step), 0.0)
        return float((deviation**2).sum() + (beyond**2).sum() + (move**2).sum())

    def beyond_after(self, step: FloatArray) -> FloatArray:
        """Return the excess over the limits after a step of shape (n, k), to first order; shape (n, h)."""
        return np.asarray(self.beyond + np.einsum("nmi,ni->nm", self.dbeyond, step), dtype=np.float64)

    def gradient(self, active: BoolArray) -> FloatArray:
        """Return half the gradient of the sum if the limits in `active`, shape (n, h), count; shape (n, k)."""
        gradient = self.deviation @ self.ddeviation + np.einsum(
            "nmi,nm->ni", self.dbeyond, np.where(active, self.beyond, 0.0)
        )
        pull = self.scale * self.move
        gradient[:-1] -= np.einsum("nmi,nm->ni", self.dq[:-1], pull)
        gradient[1:] += np.einsum("nmi,nm->ni", self.dq[1:], pull)
        return np.asarray(gradient, dtype=np.float64)

    def band(self, active: BoolArray) -> FloatArray:
        """Return the normal matrix if the limits in `active`, shape (n, h), count; lower banded, shape (2 k, k n)."""
        n, k = len(self.deviation), self.dq.shape[2]
        limits = self.dbeyond * active[:, :, None]
        before, after = self.scale[:, :, None] * self.dq[:-1], self.scale[:, :, None] * self.dq[1:]
        diagonal = np.swapaxes(limits, 1, 2) @ limits + self.ddeviation.T @ self.ddeviation
        diagonal[:-1] += np.swapaxes(before, 1, 2) @ before
        diagonal[1:] += np.swapaxes(after, 1, 2) @ after
        coupling = -np.swapaxes(before, 1, 2) @ after  # rows: coordinates of a point, columns: of the next
        band = np.zeros((2 * k, n * k))  # band[d, j] holds element (j + d, j)
        for i in range(k):
            for j in range(k):
                if i >= j:
                    band[i - j, j::k] = diagonal[:, i, j]
                band[k + j - i, i : (n - 1) * k : k] = coupling[:, i, j]
        return band


def descend(
    path: Path,
    linearise: Callable[[Path], LinearModel],
    moved: Callable[[Path, FloatArray], Path | None],
    *,
    iterations: int = 80,
) -> Path:
    """Minimise a sum of squares, starting from a path. Never with a larger sum than the start.

    Parameters
    ----------
    moved : From a path and a step of shape (n, k) to the path after it; None where it leaves what is possible.
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

    Returns
    -------
    ndarray, shape (n, k), or None. None where round-off makes the normal matrix indefinite.
    """
    active, step = model.beyond > 0, None
    for _ in range(ACTIVE_ROUNDS):
        band = model.band(active)
        band[0] += damping * band[0] + LEAST_CURVATURE
        try:
            flat = solveh_banded(band, -model.gradient(active).ravel(), lower=True, check_finite=False)
        except LinAlgError:
            return None
        step = np.asarray(flat, dtype=np.float64).reshape(len(model.deviation), -1)
        after = model.beyond_after(step) > 0
        if (after == active).all():
            break
        active = after
    return step
