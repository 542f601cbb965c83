"""Fits that are equally good: each of them by its value, and the one that is taken."""

import numpy as np
import pytest

from wpcal.calibrate import fit_least_squares
from wpcal.calibrate.solve.least_squares import distances
from wpcal.calibrate.solve.ties import break_ties, with_copies
from wpcal.core import PointPairs
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform

ROUND_OFF_MM = 1e-9


@pytest.mark.parametrize(("share", "turns_back"), [(1e-9, True), (1e-3, False)])
def test_a_point_carries_a_minimax_fit_from_a_share_of_a_millionth_on(share, turns_back):
    p = np.array([[-100.0, 0, 0], [100, 0, 0], [0, 50, 0]])
    q = p + np.array([[-1.0, 0, 0], [1, 0, 0], [0, 0, 0]])
    turned = exp_rotation(np.array([0.005, 0, 0]))
    R, t = break_ties(p[None], q[None], turned[None], np.zeros((1, 3)), np.array([[0.5, 0.5, share]]))
    np.testing.assert_allclose(R[0], np.eye(3) if turns_back else turned, rtol=0, atol=ROUND_OFF_MM)
    np.testing.assert_allclose(t[0], 0.0, rtol=0, atol=ROUND_OFF_MM)


@pytest.mark.parametrize("heavy", range(3))
def test_a_weighted_fit_with_a_free_rotation_reaches_its_bound(heavy):
    """The point reflection of six points leaves open an axis of the half turn, across the heaviest pair."""
    six = 100.0 * np.vstack([np.eye(3), -np.eye(3)]) + [7.0, -3.0, 20.0]
    p, q = np.vstack([six, [[1000.0, 0, 0]]]), np.vstack([-six, [[0, 1000.0, 500.0]]])
    pairs, w = (
        PointPairs(tuple("abcdefg"), p, q),
        np.concatenate([np.tile(1.0 + 2.0 * np.eye(3)[heavy], 2), [0.0]]) / 10.0,
    )
    about_heavy = RigidTransform(2.0 * np.outer(*2 * [np.eye(3)[heavy]]) - np.eye(3), np.zeros(3), "base", "part")
    T = fit_least_squares(pairs, w, nominal=about_heavy)
    reached = np.sqrt(w @ distances(p, q, T.R, T.t_mm) ** 2)
    assert reached == pytest.approx(np.sqrt(0.8) * 100.0, rel=0, abs=ROUND_OFF_MM)


def test_every_copy_of_a_fit_has_its_distances():
    rng = np.random.default_rng(2)
    p = rng.normal(size=(5, 3)) * [300, 200, 100]
    p -= p.mean(axis=0)
    q = p[[1, 0, 2, 3, 4]]
    R, t = exp_rotation(np.array([0.1, -0.2, 0.3])), np.array([10.0, -20.0, 30.0])
    turns, shifts = with_copies(p, q, R[None], t[None])
    assert len(turns) == 2
    expected = np.sort(distances(p, q, R, t))
    for turn, shift in zip(turns, shifts, strict=True):
        np.testing.assert_allclose(np.sort(distances(p, q, turn, shift)), expected, rtol=0, atol=1e-7)
