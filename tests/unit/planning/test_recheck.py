"""A path is free only if the states between its points are: posts in the way, random paths, interpolation."""

from dataclasses import replace

import numpy as np
import pytest

from tests.saddle import changed
from wpcal.core.errors import InputError
from wpcal.planning.cell.clearance import capsule_clearance
from wpcal.planning.cell.hulls import hull_clearance
from wpcal.planning.cell.shape import Shape
from wpcal.planning.plan.plan import CollisionVerdict
from wpcal.planning.plan.recheck import check_path, finer_states

pytest.importorskip("fcl", reason="python-fcl is not installed")
ROUND_OFF_RAD = 1e-12
ROUND_OFF_MM = 1e-9
AWAY = np.array([0.0, -0.9, 0.9, 0.0, 0.6, 0.0])  #: Both arms folded back: far from each other and from the table.


def turned(angle):
    """AWAY with another angle of joint 1."""
    return AWAY + angle * np.eye(6)[0]


def rechecked(state, cell, **more):
    return check_path(state, np.arange(float(len(state))), cell, **more)


def sweep(first, last, n=2):
    joints1 = np.linspace(first, last, n)
    return np.concatenate([joints1, np.repeat(AWAY[None], n, axis=0)], axis=1)


def test_a_post_between_two_points_is_found(cell, golden):
    state = sweep(turned(-0.5), turned(0.5))
    tip = cell.tool_places(AWAY[None])[0, :3, 3]
    post = Shape("post", [[*tip[:2], 0]], [[*tip[:2], 2000]], [20])
    blocked = replace(cell, bench=(*cell.bench, post))
    assert capsule_clearance(blocked, state).is_clear.all()  # at its points nothing is wrong
    assert rechecked(state, cell).verdict is CollisionVerdict.FREE
    found = rechecked(state, blocked)
    assert found.verdict is CollisionVerdict.NOT_FREE
    assert "post" in found.clearance.nearest(found.worst)
    assert "post" in found.describe()
    assert 0.3 < found.s_mm[found.worst] < 0.7
    golden(found)


@pytest.mark.parametrize("seed", range(6))
def test_what_is_called_free_touches_nothing_at_finer_steps_still(cell, seed):
    rng = np.random.default_rng(seed)
    verdicts = []
    for _ in range(20):
        start = AWAY + rng.uniform(-0.7, 0.7, (2, 6))
        end = start + rng.uniform(-0.3, 0.3, (2, 6))
        state = np.concatenate([np.linspace(start[0], end[0], 4), np.linspace(start[1], end[1], 4)], axis=1)
        found = rechecked(state, cell)
        verdicts.append(found.verdict)
        closely = hull_clearance(cell, finer_states(state, refine=73)).distance_mm.min()
        if found.verdict is CollisionVerdict.FREE:
            assert closely > 0
        assert closely <= found.clearance.distance_mm.min() + ROUND_OFF_MM + found.motion_mm
    assert {CollisionVerdict.FREE, CollisionVerdict.NOT_FREE} == set(verdicts)


def test_a_needle_between_two_states_is_not_stepped_over(cell):
    """Without a safety distance the states beside a needle are clear, however near; that says nothing of between."""
    bare = changed(
        cell, d1_mm=0.0, links=(), links2=(), part=(), torch=(Shape("ball", [[0, 0, 0]], [[0, 0, 0]], [1.0]),)
    )
    state = sweep(turned(-0.05), turned(0.05))
    tip = cell.tool_places(turned(0.00333)[None])[0, :3, 3]
    needle = Shape("needle", [[*tip[:2], 0]], [[*tip[:2], 3000]], [0.5])
    coarse = rechecked(state, replace(bare, bench=(needle,)), refine=1)
    assert coarse.refine == 8  # halved as often as it may be
    assert coarse.clearance.is_clear.all()
    assert coarse.verdict is CollisionVerdict.NOT_FREE
    assert "between" in coarse.describe()
    fine = rechecked(state, replace(bare, bench=(needle,)), refine=50)
    assert not fine.clearance.is_clear.all()


def test_steps_are_halved_until_nothing_fits_between(cell):
    state = sweep(turned(-0.2), turned(0.2))
    found = rechecked(state, cell, refine=10)
    assert found.refine in (20, 40, 80)
    assert found.least_gap_mm > found.motion_mm
    assert found.verdict is CollisionVerdict.FREE
    assert len(found.s_mm) == found.refine + 1


def test_between_points_all_joints_go_straight(cell):
    rng = np.random.default_rng(0)
    state = np.concatenate([rng.uniform(-1, 1, (4, 6)), rng.uniform(-1, 1, (4, 6))], axis=1)
    fine = finer_states(state, refine=10)
    assert len(fine) == 31
    np.testing.assert_array_equal(fine[::10], state)
    np.testing.assert_allclose(fine[13], state[1] + 0.3 * (state[2] - state[1]), rtol=0, atol=ROUND_OFF_RAD)


def test_the_tip_leaves_the_line_by_the_rise_of_an_arc(cell, golden):
    """Joint 1 alone turns the tip on a circle about the base: between two points it rises r (1 - cos(a/2))."""
    angle = 0.02
    state = sweep(AWAY, turned(angle))
    tip = cell.tool_places(AWAY[None])[0, :3, 3] - cell.T_world_base.t_mm
    rise = np.hypot(*tip[:2]) * (1 - np.cos(angle / 2))
    found = rechecked(state, cell)
    np.testing.assert_allclose(found.tip_error_mm, rise, rtol=0, atol=ROUND_OFF_MM)
    golden(found)


def test_the_motion_between_states_is_that_of_the_farthest_body(cell):
    state = sweep(AWAY, turned(0.1))
    found = rechecked(state, cell)
    arm = np.linalg.norm(cell.tool_places(AWAY[None])[0, :2, 3])
    assert 0.7 * arm * 0.01 < found.motion_mm < 1.5 * arm * 0.01
    still = np.concatenate([np.repeat(AWAY[None], 3, axis=0), np.repeat(AWAY[None], 3, axis=0)], axis=1)
    assert rechecked(still, cell).motion_mm == 0.0
    assert rechecked(still, cell).tip_error_mm < ROUND_OFF_MM


def test_the_tip_is_seen_from_the_part(cell):
    """Moving robot 2 alone moves it too."""
    state = np.concatenate([np.repeat(AWAY[None], 2, axis=0), np.stack([AWAY, turned(0.1)])], axis=1)
    found = rechecked(state, cell)
    T = np.linalg.inv(cell.part_places(state)) @ cell.tool_places(state[:, :6])
    assert np.linalg.norm(T[1, :3, 3] - T[0, :3, 3]) > 50
    assert found.tip_error_mm > 0.5


@pytest.mark.parametrize("refine", [0, -3])
def test_a_step_cannot_be_cut_into_less_than_one_part(cell, refine):
    with pytest.raises(InputError, match="at least one part"):
        rechecked(sweep(AWAY, AWAY), cell, refine=refine)
