"""The run of both robots: approach and retract along the wire, times, and the check of all of it."""

from dataclasses import replace

import numpy as np
import pytest

from wpcal.core.errors import InputError
from wpcal.core.motion import APPROACH_MM
from wpcal.planning.cell.cell import joint_speeds
from wpcal.planning.cell.shape import Shape
from wpcal.planning.plan.plan import CollisionVerdict, schedule_plan
from wpcal.planning.plan.recheck import check_path
from wpcal.planning.plan.run import Phase, build_run

pytest.importorskip("fcl", reason="python-fcl is not installed")
CLOSED_FORM_MM = 1e-6  #: The inverse kinematics meets a pose of two metres to 1e-9 of it.
CLOSED_FORM_RAD = 1e-9
ROUND_OFF_S = 1e-9


@pytest.fixture(scope="module")
def schedule(cell, simple_plan):
    return schedule_plan(simple_plan, cell)


@pytest.fixture(scope="module")
def run(cell, simple_plan, schedule):
    return build_run(simple_plan, cell, schedule)


def test_the_weld_is_in_the_run_unchanged(run, simple_plan, schedule):
    rows = slice(run.first, run.last + 1)
    np.testing.assert_array_equal(run.q[rows], simple_plan.q)
    np.testing.assert_allclose(np.diff(run.t_s[rows]), np.diff(schedule.t_s), rtol=0, atol=ROUND_OFF_S)
    assert run.phases.count(Phase.WELD) == len(simple_plan) - 1
    along = run.along(simple_plan.s_mm)
    assert np.isnan(along).sum() == len(run) - len(simple_plan)
    assert along[run.first] == simple_plan.s_mm[0]


@pytest.mark.parametrize("end", [0, -1])
def test_the_torch_comes_and_goes_along_its_wire(cell, run, end):
    weld = run.first if end == 0 else run.last
    T = cell.tool_places(run.q[:, :6])
    away = T[end, :3, 3] - T[weld, :3, 3]
    np.testing.assert_allclose(away, -APPROACH_MM * T[weld, :3, 2], rtol=0, atol=CLOSED_FORM_MM)
    np.testing.assert_allclose(T[end, :3, :3], T[weld, :3, :3], rtol=0, atol=CLOSED_FORM_RAD)
    np.testing.assert_array_equal(run.q[end, 6:], run.q[weld, 6:])


def test_in_the_air_no_joint_is_too_fast(cell, run):
    rates = np.abs(np.diff(run.q[:, :6], axis=0)) / np.diff(run.t_s)[:, None]
    assert (rates <= joint_speeds(cell.arm) * (1 + ROUND_OFF_S)).all()
    assert (np.diff(run.t_s) > 0).all()


def test_the_whole_run_is_checked_or_says_that_it_was_not(cell, simple_plan, schedule, run):
    assert run.check.verdict is CollisionVerdict.FREE
    assert len(run.check.s_mm) == (len(run) - 1) * 10 + 1
    assert build_run(simple_plan, cell, schedule, refine=None).check is None


def first_points(plan, n):
    """The start of a plan, along which robot 1 hardly moves."""
    state = np.concatenate([plan.q[:n, :6], plan.q[:n, 6:]], axis=1)
    names = ("s_mm", "slope_rad", "rotation_rad", "work_rad", "travel_rad")
    return replace(plan, q=state, **{name: getattr(plan, name)[:n] for name in names})


def test_a_lamp_behind_the_torch_shortens_the_approach(cell, simple_plan):
    """The weld itself is free of it: only the far end of the approach would meet it."""
    start = first_points(simple_plan, 3)
    wrist = cell.frames(start.q)[6].point([0, 0, -95]).T[0]
    wire = cell.tool_places(start.q[:, :6])[0, :3, 2]
    place = wrist - 130.0 * wire  # 75 of the forearm, 5 of the lamp and 20 between: 30 are left, less than the approach
    blocked = replace(cell, bench=(*cell.bench, Shape("lamp", [place], [place], [5.0])))
    schedule = schedule_plan(start, blocked)
    whole = build_run(start, blocked, schedule, refine=None)
    assert check_path(whole.q, whole.t_s, blocked).verdict is CollisionVerdict.NOT_FREE
    found = build_run(start, blocked, schedule)
    assert found.check.verdict is CollisionVerdict.FREE
    assert 0 < found.first < whole.first


def test_a_weld_that_is_not_free_stays_so(cell, simple_plan):
    place = cell.tool_places(simple_plan.q[40:41, :6])[0, :3, 3] + [0, 0, 60]
    blocked = replace(cell, bench=(*cell.bench, Shape("clamp", [place], [place], [25.0])))
    run = build_run(simple_plan, blocked, schedule_plan(simple_plan, blocked))
    assert run.check.verdict is CollisionVerdict.NOT_FREE


def test_the_tip_between_the_points_is_that_of_a_much_finer_path(cell, simple_plan, schedule, run):
    """Forty parts per step by plain matrices, instead of ten: the largest distance and the range of speeds."""
    joints = [np.asarray(q) for q in (simple_plan.q[:, :6], simple_plan.q[:, 6:])]
    off, speeds = 0.0, []
    for i in range(len(simple_plan) - 1):
        parts = np.linspace(0.0, 1.0, 41)[:, None]
        one, two = (q[i] + parts * (q[i + 1] - q[i]) for q in joints)
        tip = (np.linalg.inv(cell.held_places(two)) @ cell.tool_places(one))[:, :3, 3]
        chord = tip[-1] - tip[0]
        off = max(off, np.linalg.norm(np.cross(tip - tip[0], chord), axis=1).max() / np.linalg.norm(chord))
        step_s = (schedule.t_s[i + 1] - schedule.t_s[i]) / 40
        speeds.extend(np.linalg.norm(np.diff(tip, axis=0), axis=1) / step_s)
    np.testing.assert_allclose(run.tip.error_mm, off, rtol=0.02, atol=0)
    np.testing.assert_allclose(
        [run.tip.slowest_mm_s, run.tip.fastest_mm_s], [min(speeds), max(speeds)], rtol=0.02, atol=0
    )
    assert run.tip.slowest_mm_s < schedule.speed_mm_s < run.tip.fastest_mm_s
    assert not run.tip.is_coarse(schedule.speed_mm_s) or "smaller steps" in run.tip.describe(schedule.speed_mm_s)


def test_what_cannot_be_reached_is_left_out(cell, simple_plan, schedule):
    far = build_run(simple_plan, cell, schedule, approach_mm=3000.0, refine=None)
    assert 0 < far.first < 300
    tip = cell.tool_places(far.q[:, :6])[:, :3, 3]
    assert np.linalg.norm(tip[0] - tip[far.first]) < 3000.0


@pytest.mark.parametrize(("approach_mm", "air_speed_mm_s"), [(-1.0, 50.0), (50.0, 0.0), (np.nan, 50.0)])
def test_numbers_that_make_no_sense_are_refused(cell, simple_plan, schedule, approach_mm, air_speed_mm_s):
    with pytest.raises(InputError, match="expected positive"):
        build_run(simple_plan, cell, schedule, approach_mm=approach_mm, air_speed_mm_s=air_speed_mm_s)
