"""Fits of least largest distance: exact pairs, bounds, and the interior point method behind them."""

import numpy as np
import pytest

from tests.few import few
from wpcal.calibrate import fit_least_squares, solve_minimax
from wpcal.calibrate.solve.branch_and_bound import bound_cells
from wpcal.calibrate.solve.interior_point import solve_interior_point
from wpcal.calibrate.solve.least_squares import centred, kabsch, weighted_rms
from wpcal.core import PointPairs
from wpcal.core.rotations import cube_rotations
from wpcal.core.tangent import exp_rotation, log_rotation

ROUND_OFF_MM = 1e-9
RECTANGLE = np.array([[0, 0, 0], [400, 0, 0], [400, 300, 0], [0, 300.0, 0]])


def named(p, q):
    return PointPairs(tuple(map(str, range(len(p)))), p, q)


def cloud(n, noise_mm, seed=0):
    rng = np.random.default_rng(seed)
    p = rng.uniform(0, 1, (n, 3)) * [600, 400, 300]
    return named(p, p + noise_mm * rng.normal(size=(n, 3)))


@pytest.mark.parametrize("n", [3, 64, 65, 1000, 20_000])
def test_clouds_of_every_size_are_certified(n):
    pairs = cloud(n, 1.0)
    found = solve_minimax(pairs)
    fits = found.T, fit_least_squares(pairs)
    largest, of_squares = (np.linalg.norm(pairs.p_target - T.apply(pairs.p_source), axis=1).max() for T in fits)
    assert found.objective_mm == pytest.approx(largest, rel=0, abs=ROUND_OFF_MM)
    assert found.gap_mm <= ROUND_OFF_MM
    assert found.objective_mm < of_squares


def test_nearby_motions_are_worse():
    pairs = cloud(12, 1.0)
    found = solve_minimax(pairs)
    rng = np.random.default_rng(1)
    centre = pairs.p_target.mean(axis=0)
    for _ in range(200):
        turn = exp_rotation(1e-3 * rng.normal(size=3))
        moved = (found.T.apply(pairs.p_source) - centre) @ turn.T + centre + 0.1 * rng.normal(size=3)
        assert np.linalg.norm(pairs.p_target - moved, axis=1).max() >= found.objective_mm


def test_two_swapped_names_of_a_rectangle_are_solved_where_plain_lawson_stalls():
    found = solve_minimax(named(RECTANGLE, RECTANGLE[[1, 0, 2, 3]]))
    assert found.objective_mm == pytest.approx(200 * np.sqrt(2), rel=0, abs=1e-6)
    assert found.certified


def test_a_mirrored_body_keeps_a_gap_and_says_so():
    rng = np.random.default_rng(0)
    p = 100 * rng.normal(size=(8, 3))
    found = solve_minimax(named(p, p * [1, 1, -1]))
    assert found.lower_bound_mm < found.objective_mm
    assert not found.certified
    assert found.starts > 1


@pytest.mark.parametrize("seed", few([1, 0, 2, 3], 2))
@pytest.mark.many
def test_branch_and_bound_closes_the_gap_of_mirrored_bodies(seed):
    rng = np.random.default_rng(seed)
    p = 100 * rng.normal(size=(8, 3))
    pairs = named(p, p * [1, 1, -1])
    before, after = solve_minimax(pairs), solve_minimax(pairs, certify=True)
    assert before.gap_mm > 0.1
    assert after.certified
    assert after.lower_bound_mm <= after.objective_mm <= before.objective_mm


def test_the_cube_turns_into_itself_in_24_ways():
    R = cube_rotations()
    assert np.allclose(np.abs(R).round(), np.abs(R), rtol=0, atol=1e-12)
    assert len({tuple(r.round().ravel()) for r in R}) == 24
    assert np.allclose(np.linalg.det(R), 1.0, rtol=0, atol=1e-12)


def test_the_bound_of_a_ball_of_rotations_holds_for_rotations_in_it():
    rng = np.random.default_rng(2)
    p, q = 100 * rng.normal(size=(2, 6, 3))
    p, q = p - p.mean(axis=0), q - q.mean(axis=0)
    centres = exp_rotation(rng.normal(size=(20, 3)))
    pool = rng.dirichlet(np.ones(6), size=3)
    for angle in (0.02, 0.3, 2.0):
        weights = np.broadcast_to(pool, (20, *pool.shape))
        bounds = bound_cells(p, q, centres, weights, angle=angle, goal=np.inf).bound
        for R0, bound in zip(centres, bounds, strict=True):
            R = exp_rotation(angle * rng.uniform(0, 1) ** (1 / 3) * _unit(rng)) @ R0
            assert np.linalg.norm(log_rotation(R @ R0.T)) <= angle + 1e-9
            best = _least_over_translation(p, q, R)
            assert bound <= best + ROUND_OFF_MM


def test_the_bound_of_a_small_ball_is_nearly_reached_in_it():
    rng = np.random.default_rng(3)
    p, q = 100 * rng.normal(size=(2, 6, 3))
    p, q = p - p.mean(axis=0), q - q.mean(axis=0)
    w, angle = rng.dirichlet(np.ones(6)), 0.01
    cell = bound_cells(p, q, np.eye(3)[None], w[None, None], angle=angle, goal=0.0)  # goal 0: no other weights
    turns = exp_rotation(angle * np.array([_unit(rng) for _ in range(4000)]))
    r = q - p @ turns.transpose(0, 2, 1)
    squares = np.sum((r - (w @ r)[:, None, :]) ** 2, axis=2) @ w
    at_centre = w @ np.sum((q - p - w @ (q - p)) ** 2, axis=1)
    fall = at_centre - squares.min()
    assert cell.bound[0] ** 2 <= squares.min()
    assert at_centre - cell.bound[0] ** 2 <= 1.05 * fall  # the slack is of second order in the angle


def _unit(rng):
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def _least_over_translation(p, q, R):
    from scipy.optimize import minimize

    r = q - p @ R.T
    return minimize(lambda t: np.linalg.norm(r - t, axis=1).max(), np.zeros(3), method="Nelder-Mead").fun


BATCH, POINTS = 200, 8


def batch(noise_mm, seed=0):
    rng = np.random.default_rng(seed)
    p = centred(rng.uniform(0, 1, (BATCH, POINTS, 3)) * [400, 300, 200])
    q = centred(p + noise_mm * rng.normal(size=p.shape))
    return p, q, *kabsch(p, q, np.full((BATCH, POINTS), 1.0 / POINTS))


def test_a_batch_of_teaching_noise_converges_in_a_dozen_steps_to_certified_answers():
    p, q, R, t = batch(0.3)
    state = solve_interior_point(p, q, R, t)
    assert state.converged.all()
    assert state.steps <= 15
    assert (state.largest - weighted_rms(p, q, state.weights) <= ROUND_OFF_MM).all()


def test_the_curvature_of_the_rotation_keeps_large_residuals_quick():
    p, q, R, t = batch(30.0)
    assert solve_interior_point(p, q, R, t).converged.mean() >= 0.98
    steps = [solve_interior_point(p[i : i + 1], q[i : i + 1], R[i : i + 1], t[i : i + 1]).steps for i in range(40)]
    assert np.median(steps) <= 12


def test_a_problem_of_a_batch_is_solved_as_it_is_alone():
    p, q, R, t = batch(0.3)
    together = solve_interior_point(p, q, R, t).largest
    alone = [solve_interior_point(p[[i]], q[[i]], R[[i]], t[[i]]).largest[0] for i in range(0, BATCH, 20)]
    assert np.allclose(together[::20], alone, rtol=0, atol=ROUND_OFF_MM)


def test_an_exact_fit_is_its_own_answer_among_others():
    p, q, R, t = batch(0.3)
    q[3], R[3], t[3] = p[3], np.eye(3), 0.0
    state = solve_interior_point(p, q, R, t)
    assert state.largest[3] == 0.0
    assert state.converged.all()
