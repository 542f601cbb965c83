"""Laws that every calibrator obeys, whatever it makes small."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wpcal.calibrate import (
    Criterion,
    PointProblem,
    Solver,
    TeachingError,
    calibrate,
    fit_least_squares,
    fit_weighted,
    solve_minimax,
)
from wpcal.core import GeometryError, PointPairs, RigidTransform
from wpcal.core.tangent import exp_rotation

ROUND_OFF_MM = 1e-9  # float64 on coordinates of some metres
REST_MM = 1e-6  # where an iteration stops along directions in which its sum hardly changes
BOX_MM = np.array([600.0, 400.0, 300.0])  # a part that fits a weld cell

CALIBRATORS = {
    "least_squares": fit_least_squares,
    "minimax": lambda pairs: solve_minimax(pairs).T,
    "weighted": fit_weighted,
    "robust": lambda pairs: PointProblem(pairs, TeachingError()).fit(Criterion.ROBUST).T,
    "annealing": lambda pairs: calibrate(pairs, solver=Solver.ANNEALING).T_base_part,
}
SOLVERS = pytest.mark.parametrize("fit", CALIBRATORS.values(), ids=CALIBRATORS.keys())


def motion(rng):
    return exp_rotation(rng.uniform(-2.5, 2.5, 3)), rng.uniform(-2000, 2000, 3)


def make(rng, n, noise_mm, flat=False):
    p = rng.uniform(0, 1, (n, 3)) * BOX_MM
    if flat:
        p[:, 2] = 0.0
    R, t = motion(rng)
    q = p @ R.T + t + rng.normal(size=(n, 3)) * noise_mm
    A = rng.normal(size=(n, 3, 3)) * 0.3
    return PointPairs(tuple(f"p{i}" for i in range(n)), p, q, A @ A.transpose(0, 2, 1) + 0.05 * np.eye(3)), R, t


def moved_points(T):
    corners = np.array([[x, y, z] for x in (0, 600) for y in (0, 400) for z in (0, 300)], dtype=float)
    return T.apply(corners)


@SOLVERS
@pytest.mark.parametrize("flat", [False, True], ids=["in space", "in a plane"])
@pytest.mark.parametrize("n", [3, 4, 12])
def test_exact_pairs_are_recovered(fit, n, flat):
    pairs, R, t = make(np.random.default_rng(n), n, 0.0, flat)
    assert np.allclose(
        moved_points(fit(pairs)), moved_points(RigidTransform(R, t, "base", "part")), rtol=0, atol=REST_MM
    )


@SOLVERS
def test_moving_both_sides_moves_the_answer_with_them(fit):
    rng = np.random.default_rng(1)
    pairs, _, _ = make(rng, 8, 0.4)
    (Ra, ta), (Rb, tb) = motion(rng), motion(rng)
    other = PointPairs(
        pairs.names, pairs.p_source @ Ra.T + ta, pairs.p_target @ Rb.T + tb, Rb @ pairs.covariances @ Rb.T
    )
    first, second = fit(pairs), fit(other)
    expected = first.apply(pairs.p_source) @ Rb.T + tb
    assert np.allclose(second.apply(other.p_source), expected, rtol=0, atol=REST_MM)


@SOLVERS
def test_the_answer_is_a_rotation_for_flat_and_mirrored_sets(fit):
    rng = np.random.default_rng(3)
    for pairs, _, _ in (make(rng, 5, 0.3, flat=True), make(rng, 3, 0.3)):
        assert np.linalg.det(fit(pairs).R) == pytest.approx(1.0, rel=0, abs=ROUND_OFF_MM)
    pairs, _, _ = make(rng, 6, 0.3)
    mirrored = PointPairs(pairs.names, pairs.p_source * [1, 1, -1], pairs.p_target, pairs.covariances)
    assert np.linalg.det(fit(mirrored).R) == pytest.approx(1.0, rel=0, abs=ROUND_OFF_MM)


@SOLVERS
@pytest.mark.parametrize("case", ["two points", "one line", "one place"])
def test_points_that_leave_the_rotation_open_are_refused(fit, case):
    p = {"two points": np.eye(3)[:2], "one line": np.outer([0, 1, 2, 5], [1.0, 2, 3]), "one place": np.ones((4, 3))}[
        case
    ]
    pairs = PointPairs(tuple("abcd"[: len(p)]), 100.0 * p, 100.0 * p, np.tile(np.eye(3), (len(p), 1, 1)))
    with pytest.raises(GeometryError, match=r"at least 3|one line|coincide"):
        fit(pairs)


@given(n=st.integers(3, 50), noise=st.floats(0, 5), seed=st.integers(0, 2**32 - 1))
@settings(max_examples=150, deadline=None)
def test_the_minimax_bound_meets_its_value_for_teaching_noise(n, noise, seed):
    pairs, _, _ = make(np.random.default_rng(seed), n, noise)
    found = solve_minimax(pairs)
    assert found.lower_bound_mm <= found.objective_mm + ROUND_OFF_MM
    assert found.gap_mm <= ROUND_OFF_MM


@pytest.mark.deep
def test_no_solver_is_below_the_bound_of_the_exact_one():
    rng = np.random.default_rng(4)
    for _ in range(20):
        pairs, _, _ = make(rng, int(rng.integers(3, 12)), 2.0)
        bound = solve_minimax(pairs).lower_bound_mm
        for name, fit in CALIBRATORS.items():
            largest = np.linalg.norm(pairs.p_target - fit(pairs).apply(pairs.p_source), axis=1).max()
            assert largest >= bound - ROUND_OFF_MM, name


def test_weights_carry_the_middle_where_every_turn_fits_alike():
    """A mirrored octahedron turns freely; a point without weight is far off, and must not move the others."""
    p = 100.0 * np.vstack([np.eye(3), -np.eye(3), [[3.0, 0.0, 0.0]]])
    w = np.array([2, 1, 1, 2, 1, 1, 0]) / 8.0
    q = p * [1.0, 1.0, -1.0] + [40.0, -70.0, 900.0]
    q[6] = [0.0, 500.0, 0.0]
    T = fit_least_squares(PointPairs(tuple("abcdefg"), p, q), w)
    np.testing.assert_allclose(T.apply(w @ p), w @ q, rtol=0, atol=1e-9)
    assert np.sqrt(w @ np.linalg.norm(T.apply(p) - q, axis=1) ** 2) == pytest.approx(100.0, rel=0, abs=1e-9)


def test_the_bound_of_any_weights_is_below_every_fit():
    from wpcal.calibrate.solve.least_squares import centred, weighted_rms

    rng = np.random.default_rng(5)
    pairs, _, _ = make(rng, 6, 30.0)
    for _ in range(100):
        R, t = motion(rng)
        largest = np.linalg.norm(pairs.p_target - pairs.p_source @ R.T - t, axis=1).max()
        assert weighted_rms(centred(pairs.p_source), centred(pairs.p_target), rng.dirichlet(np.ones(6))) <= largest


@pytest.mark.parametrize("criterion", list(Criterion))
def test_the_same_seed_gives_the_same_bytes(criterion):
    from wpcal.core.records import to_json

    pairs, _, _ = make(np.random.default_rng(6), 7, 0.4)
    first, second = (to_json(calibrate(pairs, criterion=criterion, seed=11).to_record()) for _ in range(2))
    assert first == second
