"""Where the least largest distance leaves a freedom, the answer is still one: that of least squares among the best."""

import numpy as np
import pytest

from tests.few import few
from wpcal.calibrate.solve.minimax import solve_minimax
from wpcal.core.pairs import PointPairs
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform

SAME_VALUE_MM = 1e-9  # the certified accuracy of the largest distance
SAME_PLACE_MM = 1e-5  # the solver stops at a gap of 1e-13; across a flat optimum that is a few 1e-6 mm

CORNERS = np.array([[0, 0, 0], [200, 0, 0], [200, 120, 0], [0, 120, 0], [90, 60, 80]], dtype=float)


def pulled_apart(rng: np.random.Generator) -> PointPairs:
    """Two points off by 1 mm along their line, the others by a tenth: the part may turn about that line."""
    q = CORNERS + rng.uniform(-0.1, 0.1, CORNERS.shape)
    along = (CORNERS[2] - CORNERS[0]) / np.linalg.norm(CORNERS[2] - CORNERS[0])
    q[0], q[2] = CORNERS[0] - along, CORNERS[2] + along
    return PointPairs(tuple("abcde"), CORNERS, q)


@pytest.mark.parametrize("seed", range(6))
def test_the_answer_does_not_depend_on_the_start(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pairs = pulled_apart(rng)
    base = solve_minimax(pairs)
    assert base.certified
    assert np.count_nonzero(base.weights > 1e-3) == 2
    for _ in range(4):
        off = RigidTransform(exp_rotation(rng.normal(0, 0.2, 3)), rng.normal(0, 20, 3), "base", "part")
        other = solve_minimax(pairs, start=off)
        assert other.objective_mm == pytest.approx(base.objective_mm, rel=0, abs=SAME_VALUE_MM)
        np.testing.assert_allclose(other.T.apply(CORNERS), base.T.apply(CORNERS), rtol=0, atol=SAME_PLACE_MM)


def test_a_point_that_would_be_further_off_holds_the_turn() -> None:
    pairs = pulled_apart(np.random.default_rng(3))
    q = np.array(pairs.p_target)
    q[4] += [0.0, 0.0, 3.0]  # least squares would turn for it until another point is further off than the pair
    found = solve_minimax(PointPairs(pairs.names, CORNERS, q))
    assert found.certified
    assert found.objective_mm == pytest.approx(found.lower_bound_mm, rel=0, abs=SAME_VALUE_MM)


@pytest.mark.parametrize("seed", few(range(8), 1))
def test_a_place_that_was_taught_twice_leaves_every_turn_to_least_squares(seed: int) -> None:
    """Where the two lie farthest apart, half their distance is the optimum whatever the part is turned by."""
    rng = np.random.default_rng(seed)
    p = np.array([[-53.25, 0, 37.5], [-182.25, 0, -12.5], [117.75, 0, -12.5], [117.75, 0, -12.5]])
    q = p + rng.uniform(-0.1, 0.1, p.shape)
    q[2, 0], q[3, 0] = p[2, 0] + 0.3, p[3, 0] - 0.3
    pairs = PointPairs(tuple("abcd"), p, q)
    base = solve_minimax(pairs)
    assert base.objective_mm == pytest.approx(np.linalg.norm(q[2] - q[3]) / 2, rel=0, abs=SAME_VALUE_MM)
    off = np.linalg.norm(q - base.T.apply(p), axis=1)
    assert off[:2].max() < base.objective_mm
    for _ in range(3):
        start = RigidTransform(exp_rotation(rng.normal(0, 0.05, 3)), rng.normal(0, 20, 3), "base", "part")
        place = solve_minimax(pairs, start=start).T.apply(p)
        np.testing.assert_allclose(place, base.T.apply(p), rtol=0, atol=SAME_PLACE_MM)
