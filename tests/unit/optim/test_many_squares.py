"""Many starts at once take the steps that each takes alone."""

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.optim.levenberg_marquardt import minimise_squares
from wpcal.optim.many_squares import minimise_many_squares

STILL, STEPS, DAMPING = 1e-12, 200, 1e-3


@dataclass(frozen=True)
class Valley:
    """Rosenbrock's curved valley: residuals 1 - x and 10 (y - x²)."""

    def evaluate(self, states: FloatArray, _: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        x, y = states.T
        r = np.stack([1.0 - x, 10.0 * (y - x**2)], axis=1)
        J = np.zeros((len(states), 2, 2))
        J[:, 0, 0], J[:, 1, 0], J[:, 1, 1] = -1.0, -20.0 * x, 10.0
        return np.sum(r**2, axis=1), np.einsum("mik,mi->mk", J, r), np.einsum("mik,mil->mkl", J, J)

    def moved(self, states: FloatArray, steps: FloatArray) -> FloatArray:
        return states + steps


class One:
    """The same for the solver of one state."""

    def cost(self, state: FloatArray) -> float:
        return float(Valley().evaluate(state[None], np.array([0]))[0][0])

    def normal_equations(self, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        _, gradient, H = Valley().evaluate(state[None], np.array([0]))
        return gradient[0], H[0]

    def moved(self, state: FloatArray, step: FloatArray) -> FloatArray:
        return state + step


def test_every_start_ends_where_it_ends_alone() -> None:
    starts = np.random.default_rng(0).uniform(-3.0, 3.0, (12, 2))
    together, sums = minimise_many_squares(Valley(), starts, still=STILL, most_steps=STEPS, first_damping=DAMPING)
    for start, end, value in zip(starts, together, sums, strict=True):
        alone = minimise_squares(One(), start, still=STILL, most_steps=STEPS, first_damping=DAMPING)
        np.testing.assert_allclose(end, alone.state, rtol=0, atol=1e-9)
        assert abs(value - alone.cost) < 1e-12
    np.testing.assert_allclose(together, 1.0, rtol=0, atol=1e-9)
