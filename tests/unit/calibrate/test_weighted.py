"""The weighted fit always ends, and nothing better is found by another method, also where a coordinate has a slip."""

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tests.few import few
from wpcal.calibrate import Criterion, calibrate, fit_weighted
from wpcal.calibrate.solve.weighted import refine_once, weighted_root_mean_square
from wpcal.core.pairs import PointPairs
from wpcal.core.transform import RigidTransform

SAME_ROOT = 1e-6  # relative; the other method stops at its own tolerance
SIGMA_MM = np.array([0.1, 0.1, 0.5])  # a touch: sure across the wire, less sure along it
LEFT_MM = 1e-6  #: By two steps of fits that are up to 0.01 mm off: each leaves a share as residuals are of the part.
SLIPS = ("none", "sign", "decimal", "swap")


def with_slip(seed: int, slip: str) -> PointPairs:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 11))
    p = rng.uniform(0, 1, (n, 3)) * [600, 400, 300]
    axes = Rotation.random(n, random_state=seed).as_matrix()
    noise = np.einsum("nij,nj->ni", axes * SIGMA_MM, rng.normal(size=(n, 3)))
    q = Rotation.random(random_state=seed).apply(p) + rng.uniform(-1000, 1000, 3) + noise
    row, column = rng.integers(n), rng.integers(3)
    if slip == "sign":
        q[row, column] *= -1.0
    elif slip == "decimal":
        q[row, column] *= rng.choice([0.1, 10.0])
    elif slip == "swap":
        q[[row, (row + 1) % n]] = q[[(row + 1) % n, row]]
    covariances = axes @ np.diag(SIGMA_MM**2) @ axes.transpose(0, 2, 1)
    return PointPairs(tuple(f"P{i}" for i in range(n)), p, q, covariances)


def best_of_many_starts(pairs: PointPairs, starts: int) -> float:
    """`weighted_root_mean_square` of the best end of a trust-region method from random rotations, mm."""
    assert pairs.covariances is not None
    whiten = np.linalg.cholesky(np.linalg.inv(pairs.covariances)).transpose(0, 2, 1)
    p, q = pairs.p_source - pairs.p_source.mean(axis=0), pairs.p_target - pairs.p_target.mean(axis=0)
    best, least = np.zeros(6), np.inf
    turn = np.eye(3)
    for R0 in Rotation.random(starts, random_state=7).as_matrix():

        def residuals(x: np.ndarray, R0: np.ndarray = R0) -> np.ndarray:
            return np.einsum("nij,nj->ni", whiten, q - p @ (Rotation.from_rotvec(x[:3]).as_matrix() @ R0).T - x[3:])

        found = least_squares(
            lambda x, f=residuals: f(x).ravel(), np.zeros(6), x_scale=[0.01] * 3 + [1.0] * 3, max_nfev=200
        )
        if found.cost < least:
            best, least, turn = found.x, found.cost, R0
    R = Rotation.from_rotvec(best[:3]).as_matrix() @ turn
    t = pairs.p_target.mean(axis=0) + best[3:] - R @ pairs.p_source.mean(axis=0)
    return weighted_root_mean_square(pairs, RigidTransform(R, t, pairs.target, pairs.source))


@pytest.mark.parametrize(("seeds", "starts"), few([(3, 8), (200, 24)], 1))
@pytest.mark.parametrize("slip", SLIPS)
def test_every_slip_has_a_fit_that_random_starts_do_not_beat(slip: str, seeds: int, starts: int) -> None:
    for seed in range(seeds):
        pairs = with_slip(seed, slip)
        root = weighted_root_mean_square(pairs, fit_weighted(pairs))
        assert root <= best_of_many_starts(pairs, starts) * (1.0 + SAME_ROOT), f"seed {seed}"


@pytest.mark.parametrize("problems", few([25, 100], 1))
@pytest.mark.parametrize("slip", SLIPS)
@pytest.mark.many
def test_the_fit_is_at_rest(slip: str, problems: int) -> None:
    """No small motion makes the sum smaller, in many problems of every slip."""
    for seed in range(problems):
        pairs = with_slip(seed, slip)
        T = fit_weighted(pairs)
        root = weighted_root_mean_square(pairs, T)
        rng, centre = np.random.default_rng(seed), pairs.p_target.mean(axis=0)
        for _ in range(6):
            turn = Rotation.from_rotvec(1e-5 * rng.normal(size=3)).as_matrix()
            t = turn @ (T.t_mm - centre) + centre + 1e-3 * rng.normal(size=3)
            other = RigidTransform(turn @ T.R, t, T.target, T.source)
            assert weighted_root_mean_square(pairs, other) >= root * (1.0 - 1e-12), f"seed {seed}"
            if slip == "none":
                weights = np.linalg.inv(pairs.covariances)
                R, moved = other.R, other.t_mm
                for _ in range(2):
                    R, moved, _ = refine_once(pairs.p_source, pairs.p_target, weights, R, moved)
                np.testing.assert_allclose(np.column_stack([R, moved]), T.matrix[:3], rtol=0, atol=LEFT_MM)


@pytest.mark.parametrize("criterion", few([Criterion.MINIMAX, Criterion.WEIGHTED], 8))
@pytest.mark.parametrize("seed", few(range(12), 4))
def test_a_slip_never_ends_a_calibration(seed: int, criterion: Criterion) -> None:
    result = calibrate(with_slip(seed, "sign"), criterion=criterion)
    assert {row["criterion"] for row in result.criteria.rows} >= {"minimax", "weighted"}
