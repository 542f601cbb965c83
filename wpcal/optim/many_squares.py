r"""Damped least squares from many starts at once: each round moves every start that still runs.

Each start takes the steps that `wpcal.optim.levenberg_marquardt.minimise_squares` takes from it alone. States are rows
of one array, and one call of the problem evaluates all of them.

References: Marquardt (1963), An algorithm for least-squares estimation of nonlinear parameters, J. SIAM 11(2).
"""

from typing import Protocol

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.optim.levenberg_marquardt import DAMPING_FACTOR, LEAST_SINGULAR, MOST_DAMPING


class ManySquares(Protocol):
    """Sums of squared residuals on a space of states; row k of the starts has the number k."""

    def evaluate(self, states: FloatArray, numbers: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Evaluate states.

        Returns `sums`: ndarray, shape (m,).
        Returns `gradients`: ndarray, shape (m, k). JᵀWr.
        Returns `normal_matrices`: ndarray, shape (m, k, k). JᵀWJ.

        `states`: ndarray, shape (m, ...).
        `numbers`: shape (m,). The starts from which they come.
        """

    def moved(self, states: FloatArray, steps: FloatArray) -> FloatArray:
        """Return states of shape (m, ...), moved by steps of shape (m, k).

        `states`: ndarray, shape (m, ...).
        `steps`: ndarray, shape (m, k).
        """


def minimise_many_squares(
    problem: ManySquares, starts: FloatArray, *, still: float, most_steps: int, first_damping: float
) -> tuple[FloatArray, FloatArray]:
    """Minimise sums of squares from many starts.

    `starts`: ndarray, shape (m, ...).
    Returns `states`: ndarray, shape (m, ...).
    Returns `sums`: ndarray, shape (m,). Never larger than those of the starts.
    """
    states, running = starts.copy(), np.arange(len(starts))
    sums, gradient, H = problem.evaluate(states, running)
    damping, steps = np.full(len(starts), first_damping), np.zeros(len(starts), dtype=np.int64)
    while len(running):
        step = _damped_steps(gradient[running], H[running], damping[running])
        tiny = np.einsum("mk,mkl,ml->m", step, H[running], step) <= still**2
        trial = problem.moved(states[running], step)
        new_sums, new_gradient, new_H = problem.evaluate(trial, running)
        better = new_sums <= sums[running]
        taken = running[better]
        states[taken], sums[taken] = trial[better], new_sums[better]
        gradient[taken], H[taken] = new_gradient[better], new_H[better]
        steps[taken] += 1
        damping[running] *= np.where(better, 1.0 / DAMPING_FACTOR, DAMPING_FACTOR)
        ended = tiny | (damping[running] > MOST_DAMPING) | (steps[running] >= most_steps)
        running = running[~ended]
    return states, sums


def _damped_steps(gradient: FloatArray, H: FloatArray, damping: FloatArray) -> FloatArray:
    """Solve with every column of J scaled to length one; directions that no residual sees stay at rest."""
    norms = np.sqrt(np.einsum("mkk->mk", H))
    scale = np.where(norms > 0, norms, 1.0)
    scaled = H / (scale[:, :, None] * scale[:, None, :]) + damping[:, None, None] * np.eye(H.shape[1])
    values, vectors = np.linalg.eigh(scaled)
    seen = values > LEAST_SINGULAR * values[:, -1:]
    along = (vectors.transpose(0, 2, 1) @ (gradient / scale)[..., None])[..., 0]
    along = np.where(seen, along / np.where(seen, values, 1.0), 0.0)
    return np.asarray(-(vectors @ along[..., None])[..., 0] / scale)
