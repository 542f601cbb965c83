r"""Damped least squares on curved spaces: Levenberg-Marquardt whose step is applied by a retraction.

The state :math:`x` may be anything: a pose, a kinematic model. A problem says how a small step
:math:`\xi \in \mathbb{R}^k` moves a state, :math:`x \oplus \xi`, and linearises its residuals there,
:math:`r(x \oplus \xi) \approx r(x) + J \xi`. Each round solves

.. math:: (H + \lambda\,\mathrm{diag}(H))\,\xi = -J^\top W r, \qquad H = J^\top W J,

and accepts the step if it does not increase :math:`r^\top W r`. Two least-squares problems of wpcal do not use this
solver: whole paths of planning, whose normal equations are a band, and the inverse kinematics of thousands of poses at
once, which are square systems solved to round-off without a line search.

References: Marquardt (1963), An algorithm for least-squares estimation of nonlinear parameters, J. SIAM 11(2).
"""

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from wpcal.core.arrays import FloatArray

State = TypeVar("State")
DAMPING_FACTOR = 10.0
"""The damping is divided by this after an accepted step and multiplied by it after a refused one."""
MOST_DAMPING = 1e12  #: Steps this short no longer change the sum.
LEAST_SINGULAR = 1e-13
"""Singular values of the scaled normal matrix below this share of the largest are round-off: no residual sees that
direction, and the state does not move along it."""


class SquaresProblem(Protocol[State]):
    """A sum of squared residuals on a space of states."""

    def cost(self, state: State) -> float:
        """Return the weighted sum of squared residuals."""

    def normal_equations(self, state: State) -> tuple[FloatArray, FloatArray]:
        """Return the gradient JᵀWr, shape (k,), and the normal matrix JᵀWJ, shape (k, k)."""

    def moved(self, state: State, step: FloatArray) -> State:
        """Return the state moved by a step of shape (k,)."""


@dataclass(frozen=True, slots=True, eq=False)
class SquaresMinimum(Generic[State]):
    """Where the solver stopped."""

    state: State  #: Never with a larger cost than the start.
    cost: float  #: The weighted sum of squared residuals there.
    steps: int  #: Accepted steps.
    converged: bool  #: Whether the last step was small. Otherwise the steps ran out or no step decreased the cost.


def minimise_squares(
    problem: SquaresProblem[State], start: State, *, still: float, most_steps: int, first_damping: float
) -> SquaresMinimum[State]:
    """Minimise a sum of squares from a start nearby.

    `still`: The solver stops at a step that changes the residuals by less than this (the root of ξᵀHξ, in the unit of
    the weighted residuals). It has converged if the damping is then not above `first_damping`; otherwise only the
    damping made the step small, as at a kink of the residuals. Choose the round-off of the residuals.
    """
    state, cost, damping = start, problem.cost(start), first_damping
    for steps in range(most_steps):
        gradient, H = problem.normal_equations(state)
        while True:
            step = _damped_step(gradient, H, damping)
            tiny = float(step @ H @ step) <= still**2
            small = tiny and damping <= first_damping
            trial = problem.moved(state, step)
            trial_cost = problem.cost(trial)
            if trial_cost <= cost:
                break
            if tiny:  # round-off decides which of the two is lower
                return SquaresMinimum(state, cost, steps, converged=small)
            damping *= DAMPING_FACTOR
            if damping > MOST_DAMPING:
                return SquaresMinimum(state, cost, steps, converged=False)
        state, cost = trial, trial_cost
        damping /= DAMPING_FACTOR
        if tiny:
            return SquaresMinimum(state, cost, steps + 1, converged=small)
    return SquaresMinimum(state, cost, most_steps, converged=False)


def _damped_step(gradient: FloatArray, H: FloatArray, damping: float) -> FloatArray:
    """Solve with every column of J scaled to length one, so that units do not matter; unseen columns stay at rest."""
    norms = np.sqrt(np.diag(H))
    scale = np.where(norms > 0, norms, 1.0)
    scaled = H / np.outer(scale, scale) + damping * np.eye(len(H))
    return np.asarray(-np.linalg.lstsq(scaled, gradient / scale, rcond=LEAST_SINGULAR)[0] / scale)
