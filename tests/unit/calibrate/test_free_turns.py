"""Turns that a fit leaves free: their derivative, and the best one about a line."""

import numpy as np
import pytest

from wpcal.calibrate.observe.motions import left_jacobian
from wpcal.calibrate.solve.free_turns import least_squares_among_best
from wpcal.calibrate.solve.ties import break_ties
from wpcal.calibrate.trust.held_motions import free_words
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import exp_rotation

ROUND_OFF = 1e-12  #: Of (x - sin x) / x³ at 2e-3.
LIMIT_MM = 60.0


@pytest.mark.parametrize("angle", [0.0, 7e-4, 2e-3, 0.7, 3.0])
def test_the_left_jacobian_is_the_integral_of_the_turn_on_its_way(angle: float) -> None:
    omega = angle * np.array([0.48, -0.6, 0.64])
    nodes, weights = np.polynomial.legendre.leggauss(24)
    way = exp_rotation(0.5 * (nodes[:, None] + 1.0) * omega)
    np.testing.assert_allclose(
        left_jacobian(omega[None])[0], np.einsum("k,kij->ij", 0.5 * weights, way), rtol=0, atol=ROUND_OFF
    )


def test_of_the_turns_about_the_carrying_line_that_keep_the_limit_the_least_squares_are_taken() -> None:
    """Two points of each of 25 problems carry. Three others would turn further than a sixth one lets them."""
    rng = np.random.default_rng(7)
    p, weights = rng.uniform(-40.0, 50.0, (25, 6, 3)), np.zeros((25, 6))
    axis = p[:, 1] - p[:, 0]
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    from_line = p - p[:, :1]
    turn = exp_rotation(np.linspace(-0.55, 0.6, 25)[:, None] * axis)
    q = p[:, :1] + np.einsum("bij,bnj->bni", turn, from_line) + rng.normal(0.0, 3.0, p.shape)
    back = q[:, 5] - p[:, 5]
    q[:, 5] = p[:, 5] - back * (0.98 * LIMIT_MM / np.linalg.norm(back, axis=1))[:, None]
    q[:, 0], q[:, 1], weights[:, :2] = p[:, 0] - LIMIT_MM * axis, p[:, 1] + LIMIT_MM * axis, 0.5
    R, t = break_ties(p, q, np.broadcast_to(np.eye(3), (25, 3, 3)), np.zeros((25, 3)), weights)

    def squares(one: int, R: FloatArray, t: FloatArray) -> FloatArray:
        return np.asarray(np.sum((p[one] @ np.swapaxes(R, -1, -2) + t[..., None, :] - q[one]) ** 2, axis=-1))

    limited = 0
    for one in range(25):
        turns = exp_rotation(np.radians(np.arange(0, 360, 0.05))[:, None] * axis[one])
        tried = squares(one, turns, p[one, 0] - turns @ p[one, 0])
        allowed = tried.max(axis=1) <= LIMIT_MM**2 * (1 + 1e-12)
        found = squares(one, R[one], t[one])
        assert found.max() <= LIMIT_MM**2 * (1 + 1e-9)
        assert found.sum() <= tried[allowed].sum(axis=1).min() * (1 + 1e-12)
        limited += tried.sum(axis=1).min() < 0.99 * found.sum()
    assert limited >= 5


def test_a_fit_turns_about_its_free_axis_unless_that_is_the_line_of_what_carries() -> None:
    """Two carrying points lie on an axis and two were touched on it: about it the others say how the part turns."""
    turn, shift = exp_rotation(np.array([0.4, 0.0, 0.0])), np.array([7.0, -20.0, 300.0])
    p = np.array([[50.0, 0, 0], [-50, 0, 0], [0, 30, 0], [0, -30, 0], [5, 7, 2], [-8, 3, 9]])
    q = np.array([[80.0, 0, 0], [-80, 0, 0], [0, 0, 0], [0, 0, 0], *(p[4:] @ turn.T)]) + shift
    on_axis, off_axis = np.array([0.5, 0.5, 0, 0, 0, 0]), np.array([0.25, 0.25, 0.25, 0.25, 0, 0])
    found = least_squares_among_best(p, q, np.eye(3), off_axis)
    np.testing.assert_allclose(found[0], turn, rtol=0, atol=ROUND_OFF)
    np.testing.assert_allclose(found[1], shift, rtol=0, atol=1e-9)
    assert least_squares_among_best(p, q, np.eye(3), on_axis) is None
    assert least_squares_among_best(p, p + shift, np.eye(3), np.full(6, 1 / 6)) is None  # no turn is free


@pytest.mark.parametrize(
    ("omega", "advance_mm", "said"),
    [
        ([0, 0, -2], 0, "turns about the axis (0 0 1) through (30 -50 0)"),
        ([0, 3, 0], 7, "screws about the axis (0 1 0) through (30 0 4), 44 mm a turn"),
        ([0, 0, 0], 9, "slides along (0 0 1)"),
    ],
)
def test_a_free_motion_is_said_as_its_axis(omega: list[float], advance_mm: float, said: str) -> None:
    pivot, at, way = np.array([10.0, 20, 5]), np.array([30.0, -50, 4]), np.array(omega, dtype=float)
    slide = advance_mm * way if way.any() else np.array([0, 0, -advance_mm])
    xi = np.concatenate([250.0 * way, np.cross(way, pivot - at) + slide])
    assert free_words(xi[None], pivot, 250.0, ()) == said
