"""Joint paths along welds of one robot: banded least squares over the torch angles; how near a wrist is to singular."""

import math

import numpy as np
import pytest

from tests.one_robot_cells import TEE, fixed_cell
from wpcal.controllers.program.planned_program import build_planned_program
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.workplace import regularity
from wpcal.planning.plan.banded import damped_step
from wpcal.planning.sequence.kept_plan import KeptPlan
from wpcal.planning.sequence.plan_sequence import plan_sequence
from wpcal.planning.sequence.seam_search import SeamSearch
from wpcal.planning.sequence.seam_task import seam_task
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.smooth import _Problem, _Rungs, respun, tilted
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.planning.sequence.torch_poses import tool_on_seam
from wpcal.robot.kinematics.arm_file import find_arm

pytest.importorskip("fcl", reason="python-fcl is not installed")

SADDLE = TEE.parents[1] / "saddle" / "golden"
TARGETS = SequenceTargets()
SPEED_MM_S = 6.0


def way_of(result, name):
    """Return the search in a cell, and the first way that its ladder finds for a seam."""
    cell = fixed_cell()
    given = read_sequence_input(result, cell, [name])
    cell = given.placed(cell)
    search = SeamSearch(cell, CellClearance(cell, given.part), TARGETS)
    return search, search.whole(seam_task(given.seams[0].seam))[0]


@pytest.fixture(scope="module")
def saddle():
    search, way = way_of(SADDLE, "W1")
    return search, way, tilted(search, way, respun(search, way))


def peaks(way):
    """Return the largest joint speed, deg/s, and acceleration, deg/s², at 6 mm/s."""
    t, q = way.task.s_mm / SPEED_MM_S, np.degrees(way.q[:, :6])
    speed = np.diff(q, axis=0) / np.diff(t)[:, None]
    change = np.diff(speed, axis=0) / ((t[2:] - t[:-2]) / 2.0)[:, None]
    return np.abs(speed).max(), np.abs(change).max()


def test_joints_move_less_on_the_saddle(saddle, golden):
    """As measured for the way that a plan takes: 26 deg/s and 92 deg/s² before, 17 and 21 after."""
    _search, before, after = saddle
    speed, change = np.array(peaks(after)) / np.array(peaks(before))
    assert speed < 0.7
    assert change < 0.4
    assert after.motion_rad_mm < 0.85 * before.motion_rad_mm
    golden([before, after])


def test_the_wire_stays_on_the_seam_within_the_ranges(saddle):
    search, before, after = saddle
    cell, task = search.cell, after.task
    T = np.linalg.inv(cell.part_places(after.q)) @ cell.tool_places(after.q)
    assert np.allclose(T, tool_on_seam(task, np.arange(len(task)), after.angles), rtol=0, atol=1e-6)
    assert np.abs(after.angles[:, :2]).max() <= TARGETS.torch_range_rad + 1e-9
    assert after.branch == before.branch
    low, high = cell.arm.limits
    assert (after.q[:, :6] >= low).all()
    assert (after.q[:, :6] <= high).all()
    assert search.clearance.margins(after.q).is_clear.all()
    assert search.checker.check(after.q).is_free


def test_the_derivatives_are_those_of_the_joints(saddle):
    """The cost after a small step is what the model predicts."""
    search, way, _ = saddle
    problem = _Problem(search, way, is_tilted=True)
    model = problem.linearise(problem.start)
    step = 1e-3 * damped_step(model, 1e-2)
    after = problem.moved(problem.start, step)
    assert isinstance(after, _Rungs)
    predicted, found = model.predicted_cost(step), problem.linearise(after).cost
    assert found < model.cost
    assert found - model.cost == pytest.approx(predicted - model.cost, rel=1e-2)


def test_a_straight_seam_is_still_one_line():
    """Its angles are even from start to end: what a controller does on a line."""
    search, way = way_of(TEE, "W2")
    after = tilted(search, way, respun(search, way))
    assert after.motion_rad_mm <= way.motion_rad_mm
    even = np.linspace(0.0, 1.0, 2)
    s = (after.task.s_mm - after.task.s_mm[0]) / after.task.length_mm
    for column in after.angles.T:
        assert np.allclose(column, np.interp(s, even, column[[0, -1]]), rtol=0, atol=1e-9)
    given = read_sequence_input(TEE, fixed_cell(), ["W2"])
    sequence = plan_sequence(search.cell, given.part, given.seams, TARGETS).sequence
    program = build_planned_program(KeptPlan.of(sequence), {each.name: each for each in given.seams})
    assert [len(path.weld_moves) for path in program.paths] == [1]


def test_in_a_narrow_place_the_way_of_the_ladder_stays(saddle):
    """With a safety distance that only the way of the ladder keeps, nothing is changed."""
    search, way, _ = saddle
    narrow = SeamSearch(search.cell, search.clearance, TARGETS)
    narrow.checked = lambda *_: (way.q[:0], 0)  # no other way is clear
    assert tilted(narrow, way, respun(narrow, way)) is way
    assert math.isfinite(way.motion_rad_mm)


SLOPE_ATOL = 1e-8  #: Round-off of a central difference quotient with steps of 1e-6.
SAME_RATIO = 1e-9  #: Round-off of a determinant of a 6 × 6 matrix.


@pytest.mark.parametrize("name", ["mh6", "m10ia", "irb1600_6_12"])
def test_the_product_of_the_measures_is_the_determinant_of_the_jacobian(name):
    arm = find_arm(name)
    q = np.random.default_rng(0).uniform(-2.0, 2.0, (200, 6))
    values, _ = regularity(arm, q)
    determinant = np.abs(np.linalg.det(arm.jacobian(q)))
    ratio = determinant / values.prod(axis=1)
    assert np.ptp(ratio) <= SAME_RATIO * ratio.mean()


@pytest.mark.parametrize("name", ["mh6", "m10ia"])
def test_derivatives_are_those_of_difference_quotients(name):
    arm = find_arm(name)
    q = np.random.default_rng(1).uniform(-2.0, 2.0, (50, 6))
    _, slopes = regularity(arm, q)
    for joint, step in enumerate(1e-6 * np.eye(6)):
        quotient = (regularity(arm, q + step)[0] - regularity(arm, q - step)[0]) / 2e-6
        np.testing.assert_allclose(slopes[:, :, joint], quotient, rtol=0, atol=SLOPE_ATOL)
