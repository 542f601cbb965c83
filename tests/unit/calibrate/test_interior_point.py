import numpy as np

from wpcal.calibrate.solve.interior_point import solve_interior_point
from wpcal.calibrate.solve.least_squares import centred, kabsch, weighted_rms

ROUND_OFF_MM = 1e-9
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
