"""Laws of plans for two robots: closed chains, true objectives, limits that hold, and a moved cell that plans alike."""

from dataclasses import replace

import numpy as np
import pytest

from tests.chain_error import chain_error
from tests.saddle import COARSE, changed, coarse_search, saddle_problem, shared_search
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.closed_chain import SeamPath
from wpcal.planning.plan.plan import CollisionVerdict
from wpcal.planning.plan.recheck import check_path
from wpcal.planning.search.pareto import Preference, is_nondominated
from wpcal.seam.path.position import weld_rotation, weld_slope

pytestmark = pytest.mark.many

CLOSED_MM, CLOSED_RAD = 1e-6, 1e-9
"""Asked of the closed chain at every point of every plan."""
SAME_DEG = 1e-6
"""Objectives computed again from the joints by forward kinematics, in degrees and degrees per millimetre."""
SAME_PLAN_DEG, SAME_PLAN_RAD = 0.02, 0.05
"""A moved cell gives other round-off, which the iterations carry into the last digits of a flat optimum."""
LARGEST_STEP_RAD = np.radians(30.0)
"""No joint moves more between points that are 9 mm apart; a wrap would be 360 degrees."""


@pytest.fixture
def result():
    return shared_search().result


@pytest.fixture
def cell(result):
    return result.problem.cell


@pytest.fixture
def path(result):
    return result.problem.path


def frames_of(cell, path, plan):
    """Seam axes in `world` and tool axes in the seam, from the joints alone."""
    R_seam = cell.part_places(plan.q)[:, :3, :3] @ path.R
    return R_seam, np.swapaxes(R_seam, 1, 2) @ cell.tool_places(plan.q[:, :6])[:, :3, :3]


def test_there_is_a_front_to_choose_from(result):
    assert len(result.front) >= 8
    assert is_nondominated(result.front.values).all()


def test_the_chain_is_closed_at_every_point_of_every_plan(cell, path, result):
    for plan in result.front.plans:
        _, R_seam_tool = frames_of(cell, path, plan)
        off_mm, _ = chain_error(cell, path, plan.q, R_seam_tool)
        assert off_mm.max() <= CLOSED_MM
        wire = R_seam_tool[:, :, 2]
        target = np.stack(
            [
                np.sin(plan.travel_rad),
                np.cos(plan.travel_rad) * np.sin(plan.work_rad),
                -np.cos(plan.travel_rad) * np.cos(plan.work_rad),
            ],
            axis=1,
        )
        assert np.linalg.norm(wire - target, axis=1).max() <= CLOSED_RAD


def test_objectives_are_those_of_the_joints(cell, path, result):
    for plan in result.front.plans:
        R_seam, R_seam_tool = frames_of(cell, path, plan)
        slope, rotation = weld_slope(R_seam[..., 0]), weld_rotation(R_seam[..., 0], R_seam[..., 2])
        position = np.sqrt(np.mean((slope - np.radians(10.0)) ** 2 + rotation**2))
        x, y, z = R_seam_tool[:, :, 2].T
        torch = np.sqrt(np.mean(np.arctan2(y, -z) ** 2 + np.arcsin(x) ** 2))
        rates = np.diff(plan.q, axis=0) / np.diff(path.s_mm)[:, None]
        weights = cell.joint_weights
        mean = np.average((rates**2) @ weights / weights.sum(), weights=np.diff(path.s_mm))
        expected = np.degrees([position, torch, np.sqrt(mean)])
        np.testing.assert_allclose(list(plan.objectives.values()), expected, rtol=0, atol=SAME_DEG)


def test_limits_speeds_and_steps_hold(cell, path, result):
    for plan in result.front.plans:
        assert cell.arm.within_limits(plan.q[:, :6]).all()
        assert cell.arm2.within_limits(plan.q[:, 6:]).all()
        steps = np.abs(np.diff(plan.q, axis=0))
        assert steps.max() <= LARGEST_STEP_RAD
        speeds = np.array([joint.speed_rad_s for joint in (*cell.arm.joints, *cell.arm2.joints)])
        assert (steps / np.diff(path.s_mm)[:, None] * result.problem.speed_mm_s <= speeds).all()


def test_every_plan_is_free_at_steps_finer_than_it_was_checked(cell, result):
    for plan in result.front.plans:
        assert plan.verdict is CollisionVerdict.FREE
        assert check_path(plan.q, plan.s_mm, cell, refine=25).verdict is CollisionVerdict.FREE


def test_preferences_take_the_ends_and_the_middle(result):
    values = result.front.values
    assert values[result.front.chosen(Preference.POSITION), 0] == values[:, 0].min()
    assert values[result.front.chosen(Preference.SMOOTH), 2] == values[:, 2].min()
    assert values[:, 0].min() < values[result.front.chosen(Preference.BALANCED), 0] < values[:, 0].max()


def assert_alike(one, other):
    assert len(one.front) == len(other.front)
    np.testing.assert_allclose(one.front.values, other.front.values, rtol=0, atol=SAME_PLAN_DEG)
    for a, b in zip(one.front.plans, other.front.plans, strict=True):
        np.testing.assert_allclose(a.q, b.q, rtol=0, atol=SAME_PLAN_RAD)


def test_a_cell_moved_on_its_floor_plans_alike(cell):
    move = RigidTransform(rotation_from_zyx(0.0, 0.0, np.pi / 2), [1000.0, 2000.0, 300.0], "world", "world")
    bench = tuple(replace(b, p=move.apply(b.p), q=move.apply(b.q), hull=move.apply(b.hull)) for b in cell.bench)
    moved = changed(cell, T_world_base=move @ cell.T_world_base, T_world_base2=move @ cell.T_world_base2, bench=bench)
    assert_alike(shared_search().coarse, coarse_search(replace(saddle_problem(COARSE), cell=moved)))


@pytest.mark.deep
def test_other_coordinates_of_the_part_plan_alike(cell):
    coarse = saddle_problem(COARSE)
    turn = RigidTransform(rotation_from_zyx(0.3, -0.4, 1.0), [10.0, 20.0, -30.0], "part", "part")
    part = tuple(replace(b, p=turn.apply(b.p), q=turn.apply(b.q)) for b in cell.part)
    other = replace(cell, T_carrier_part=cell.T_part @ turn.inverse(), part=part)
    path = coarse.path
    moved = SeamPath(path.name, path.s_mm, turn.apply(path.p), turn.R @ path.R)
    assert_alike(shared_search().coarse, coarse_search(replace(coarse, cell=other, path=moved)))


def test_the_target_position_is_what_a_plan_of_that_preference_has(cell, path, result):
    plan = result.front.plans[result.front.chosen(Preference.POSITION)]
    R_seam, _ = frames_of(cell, path, plan)
    slope = np.degrees(weld_slope(R_seam[..., 0]))
    assert np.abs(slope - 10.0).max() < 3.0
