"""The batched solver of least largest linear residuals, against a linear programme and SLSQP."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import linprog, minimize

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.optim.least_largest import least_largest, least_squares_within
from wpcal.optim.levenberg_marquardt import minimise_squares
from wpcal.optim.many_squares import minimise_many_squares

SAME = 1e-7  # of values, relative; the oracles stop at 1e-9 or so
BATCH, N = 20, 11


def numbers_of(rank: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Residuals that give `rank` numbers each, as touches on faces, edges and points do."""
    Q = np.linalg.qr(rng.normal(size=(N, 3, 3)))[0][..., :rank]
    A = Q @ Q.swapaxes(-1, -2)
    d = (A @ rng.normal(size=(BATCH, N, 3, 1)))[..., 0]
    return d, A @ rng.normal(size=(N, 3, 6))


def largest(d: np.ndarray, J: np.ndarray, xi: np.ndarray) -> np.ndarray:
    return np.linalg.norm(d + np.einsum("nik,bk->bni", J, xi), axis=2).max(axis=1)


def test_single_numbers_have_the_value_of_a_linear_programme() -> None:
    d, J = numbers_of(1, np.random.default_rng(0))
    xi, weights = least_largest(d, J)
    found = largest(d, J, xi)
    for k in range(BATCH):
        axis = d[k] / np.linalg.norm(d[k], axis=1, keepdims=True)
        g, a = np.einsum("ni,nik->nk", axis, J), np.einsum("ni,ni->n", axis, d[k])
        A = np.block([[g, -np.ones((N, 1))], [-g, -np.ones((N, 1))]])
        best = linprog([0] * 6 + [1], A_ub=A, b_ub=np.concatenate([-a, a]), bounds=[(None, None)] * 7)
        assert found[k] == pytest.approx(best.fun, rel=SAME)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, rtol=0, atol=SAME)


@pytest.mark.parametrize("rank", [2, 3])
def test_several_numbers_have_the_value_of_slsqp(rank: int) -> None:
    d, J = numbers_of(rank, np.random.default_rng(rank))
    found = largest(d, J, least_largest(d, J)[0])
    for k in range(0, BATCH, 5):

        def slack(z: np.ndarray, k: int = k) -> np.ndarray:
            return np.asarray(z[6] - np.sum((d[k] + J @ z[:6]) ** 2, axis=1))

        start = np.append(np.zeros(6), np.sum(d[k] ** 2, axis=1).max())
        oracle = minimize(
            lambda z: z[6],
            start,
            method="SLSQP",
            constraints={"type": "ineq", "fun": slack},
            options={"ftol": 1e-14, "maxiter": 500},
        )
        assert found[k] == pytest.approx(np.sqrt(oracle.fun), rel=SAME)


def test_the_sum_of_squares_is_least_within_the_bound() -> None:
    d, J = numbers_of(1, np.random.default_rng(5))
    most = 1.05 * largest(d, J, least_largest(d, J)[0])
    xi = least_squares_within(d, J, most)
    assert (largest(d, J, xi) <= most * (1.0 + SAME)).all()
    free = np.array([-np.linalg.lstsq(J.reshape(-1, 6), r.ravel())[0] for r in d])
    sums = [np.sum((d + np.einsum("nik,bk->bni", J, z)) ** 2, axis=(1, 2)) for z in (free, xi, xi + 1e-4 * (free - xi))]
    assert (sums[0] <= sums[1] * (1.0 + SAME)).all()
    nearer = largest(d, J, xi + 1e-4 * (free - xi)) <= most
    assert (nearer <= (sums[2] >= sums[1] * (1.0 - 1e-3))).all()


def test_an_exact_problem_is_its_own_answer() -> None:
    d, J = numbers_of(1, np.random.default_rng(7))
    d[3] = 0.0
    assert not least_largest(d, J)[0][3].any()


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
