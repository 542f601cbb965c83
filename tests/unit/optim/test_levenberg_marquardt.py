"""Laws of the damped least-squares solver: on flat spaces it agrees with SciPy, on rotations with the closed form."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from wpcal.core.tangent import exp_rotation, log_rotation
from wpcal.optim.levenberg_marquardt import minimise_squares

STILL = 1e-12
SAME = 1e-9
"""Both solvers end where the gradient is round-off; a state is then known to its square root of the curvature."""


@dataclass
class Flat:
    """Residuals r(x) with the Jacobian by central differences."""

    residuals: object

    def cost(self, x):
        r = self.residuals(x)
        return float(r @ r)

    def normal_equations(self, x):
        h = 1e-6
        J = np.stack(
            [(self.residuals(x + h * e) - self.residuals(x - h * e)) / (2 * h) for e in np.eye(len(x))], axis=1
        )
        return J.T @ self.residuals(x), J.T @ J

    def moved(self, x, step):
        return x + step


@dataclass
class Linear:
    """Residuals A x - b."""

    A: np.ndarray
    b: np.ndarray

    def cost(self, x):
        return float(np.sum((self.A @ x - self.b) ** 2))

    def normal_equations(self, x):
        return self.A.T @ (self.A @ x - self.b), self.A.T @ self.A

    def moved(self, x, step):
        return x + step


def solve(problem, start, **options):
    return minimise_squares(problem, start, **{"still": STILL, "most_steps": 200, "first_damping": 1e-3} | options)


def test_a_linear_problem_is_solved_as_lstsq_does():
    rng = np.random.default_rng(1)
    A, b = rng.normal(size=(9, 4)), rng.normal(size=9)
    found = solve(Linear(A, b), np.zeros(4))
    assert found.converged
    np.testing.assert_allclose(found.state, np.linalg.lstsq(A, b, rcond=None)[0], rtol=0, atol=SAME)


@pytest.mark.parametrize("seed", range(5))
def test_a_curved_problem_ends_where_scipy_ends(seed):
    rng = np.random.default_rng(seed)
    t, truth = np.linspace(0, 2, 20), rng.uniform(0.5, 1.5, 3)

    def residuals(x):
        return x[0] * np.exp(-x[1] * t) + x[2] - y

    y = truth[0] * np.exp(-truth[1] * t) + truth[2] + 0.01 * rng.normal(size=20)
    found = solve(Flat(residuals), np.ones(3), still=1e-10)
    peer = least_squares(residuals, np.ones(3), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert found.converged
    np.testing.assert_allclose(found.state, peer.x, rtol=0, atol=1e-6)  # central differences are good to 1e-9 of r


def test_the_cost_never_rises_from_a_bad_start():
    def rosenbrock(x):
        return np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])

    problem = Flat(rosenbrock)
    for start in ([-1.2, 1.0], [5.0, -7.0], [0.0, 100.0]):
        costs = [solve(problem, np.array(start), most_steps=n).cost for n in range(1, 12)]
        assert (np.diff(costs) <= 0).all()
    np.testing.assert_allclose(solve(problem, np.array([-1.2, 1.0])).state, [1.0, 1.0], rtol=0, atol=1e-6)


def test_a_direction_that_no_residual_sees_stays_at_rest():
    found = solve(Linear(np.array([[1.0, 1.0, 0.0]]), np.array([2.0])), np.array([0.0, 0.0, 7.0]), first_damping=0.0)
    np.testing.assert_allclose(found.state, [1.0, 1.0, 7.0], rtol=0, atol=SAME)


def test_units_of_the_state_do_not_matter():
    A, b = np.random.default_rng(3).normal(size=(6, 3)), np.arange(6.0)
    unit = np.array([1e-6, 1.0, 1e6])
    plain = solve(Linear(A, b), np.zeros(3))
    scaled = solve(Linear(A / unit, b), np.zeros(3))
    np.testing.assert_allclose(scaled.state / unit, plain.state, rtol=0, atol=SAME)


class MeanRotation:
    """The rotation with the least sum of squared angles to others, on SO(3) itself."""

    def __init__(self, others):
        self.others = others

    def cost(self, R):
        return float(np.sum(log_rotation(self.others @ R.T) ** 2))

    def normal_equations(self, R):
        n = len(self.others)
        return -log_rotation(self.others @ R.T).sum(axis=0), n * np.eye(3)

    def moved(self, R, step):
        return exp_rotation(step) @ R


def test_on_rotations_the_retraction_stays_a_rotation_and_finds_the_mean():
    rng = np.random.default_rng(0)
    others = (Rotation.from_rotvec(0.3 * rng.normal(size=(20, 3))) * Rotation.from_rotvec([1.0, 2.0, 0.5])).as_matrix()
    found = solve(MeanRotation(others), np.eye(3))
    assert found.converged
    np.testing.assert_allclose(found.state @ found.state.T, np.eye(3), rtol=0, atol=1e-12)
    gradient = MeanRotation(others).normal_equations(found.state)[0]
    np.testing.assert_allclose(gradient, 0.0, rtol=0, atol=SAME)


def test_steps_that_run_out_are_told():
    found = solve(Flat(lambda x: np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])), np.array([-1.2, 1.0]), most_steps=2)
    assert not found.converged
    assert found.steps == 2
