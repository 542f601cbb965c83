"""The objectives of a plan, and which plans no other one beats in all of them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from wpcal.core.errors import InputError
from wpcal.planning.cell.closed_chain import ROTATION, WORK
from wpcal.planning.search.objectives import (
    MOTION,
    OBJECTIVE_NAMES,
    POSITION,
    TORCH,
    PathValues,
    WeldTargets,
    deviation_weights,
    joint_motion,
    joint_step_weight,
    objective_values,
    printed_position,
    printed_smoothness,
    printed_torch,
    printed_values,
)
from wpcal.planning.search.pareto import hypervolume, is_nondominated, thin_front

ROUND_OFF = 1e-12  #: Sums of some numbers near one.
DEG = math.pi / 180.0


def coordinates(slope=0.0, rotation=0.0, work=0.0, travel=0.0, count=5):
    row = np.array([0, 0, 0, 0, slope, rotation, work, travel, 0], dtype=float)
    return np.tile(row * DEG, (count, 1))


@pytest.fixture
def along(cell):
    """Make a path of some coordinates, or of some joints; everything else is zero."""

    def make(given=None, targets=None, *, joints=None, s_mm=None):
        n = len(joints) if given is None else len(given)
        return PathValues(
            cell,
            targets or WeldTargets(),
            np.arange(float(n)) if s_mm is None else s_mm,
            coordinates(count=n) if given is None else given,
            np.zeros((n, 12)) if joints is None else joints,
        )

    return make


def test_position_and_torch_deviations_are_root_mean_squares_in_degrees(along):
    targets = WeldTargets(slope_rad=10 * DEG, travel_rad=-5 * DEG)
    position = POSITION.value(along(coordinates(slope=13, rotation=-4), targets))
    assert position == pytest.approx(5.0, rel=0, abs=ROUND_OFF)
    torch = TORCH.value(along(coordinates(work=-12, travel=0), targets))
    assert torch == pytest.approx(13.0, rel=0, abs=ROUND_OFF)
    half = np.concatenate([coordinates(slope=13, rotation=4, count=3), coordinates(slope=10, count=3)])
    assert POSITION.value(along(half, targets)) == pytest.approx(5.0 / 2**0.5, rel=0, abs=ROUND_OFF)


def test_motion_of_one_joint_is_its_rate_with_its_weight(cell, along):
    s = np.array([0.0, 1.0, 4.0])
    joints = np.zeros((3, 12))
    joints[:, 6] = 2.0 * DEG * s  # two degrees per millimetre
    weights = cell.joint_weights
    expected = 2.0 * math.sqrt(weights[6] / weights.sum())
    assert joint_motion(along(joints=joints, s_mm=s)) == pytest.approx(expected, rel=0, abs=ROUND_OFF)
    assert joint_motion(along(joints=joints[:, ::-1], s_mm=s)) != pytest.approx(expected, rel=0, abs=1e-3)


def test_an_even_motion_is_smoother_than_a_jerk_but_not_as_printed(along):
    s = np.arange(5.0)
    even, jerk = np.zeros((5, 12)), np.zeros((5, 12))
    even[:, 0], jerk[:, 0] = 0.1 * s, np.array([0, 0, 0.4, 0.4, 0.4])
    even, jerk = along(joints=even), along(joints=jerk)
    assert joint_motion(even) < 0.6 * joint_motion(jerk)
    assert printed_smoothness(even) == pytest.approx(printed_smoothness(jerk), rel=0, abs=ROUND_OFF)


def test_the_printed_position_is_a_product_and_one_zero_factor_frees_the_other(along):
    targets = WeldTargets(slope_rad=10 * DEG, slope_range_rad=30 * DEG, rotation_range_rad=90 * DEG)
    off = along(coordinates(slope=16, rotation=-45, count=4), targets)
    assert printed_position(off) == pytest.approx(6 / 30 * 45 / 90, rel=0, abs=ROUND_OFF)
    assert printed_position(along(coordinates(slope=10, rotation=80, count=4), targets)) == 0.0
    vertical = coordinates(slope=16, count=4)
    vertical[:, ROTATION] = np.nan
    assert printed_position(along(vertical, targets)) == 0.0


def test_the_printed_torch_function_is_least_at_the_limits(along):
    targets = WeldTargets(torch_range_rad=10 * DEG)
    assert printed_torch(along(coordinates(count=3), targets)) == pytest.approx((1 - 90 / 100) ** 2, rel=0, abs=1e-12)
    at_limit = printed_torch(along(coordinates(work=-10, count=3), targets))  # α = 100°, its largest value
    assert at_limit == pytest.approx(0.0, rel=0, abs=ROUND_OFF)


def test_the_printed_smoothness_is_the_sum_of_the_paper(cell, along):
    joints = np.zeros((4, 12))
    joints[1:, 5] = 72 * DEG  # the last joint of an MH6 has a range of 720°
    weights = cell.joint_weights
    found = printed_smoothness(along(joints=joints))
    assert found == pytest.approx(weights[5] / weights.sum() * 0.1 / 4, rel=0, abs=ROUND_OFF)


def test_the_table_gives_the_columns_and_the_keys_of_files(along):
    path = along(coordinates(slope=13, rotation=-4, work=3))
    assert OBJECTIVE_NAMES == ("position_deg", "torch_deg", "motion_deg_per_mm")
    np.testing.assert_allclose(objective_values(path), [5.0, 3.0, 0.0], rtol=0, atol=ROUND_OFF)
    assert printed_values(path) == {
        "f1_1": printed_position(path),
        "f1_2": printed_torch(path),
        "f2": printed_smoothness(path),
    }


def test_many_paths_are_valued_at_once(along, cell):
    rng = np.random.default_rng(0)
    many, joints = rng.normal(0.0, 0.1, (4, 5, 9)), rng.normal(0.0, 0.1, (4, 5, 12))
    paths = PathValues(cell, WeldTargets(), np.arange(5.0), many, joints)
    one_by_one = [objective_values(along(one, joints=q)) for one, q in zip(many, joints, strict=True)]
    np.testing.assert_allclose(objective_values(paths), one_by_one, rtol=0, atol=ROUND_OFF)


def test_weights_go_to_the_residuals_that_the_table_names():
    weights = {TORCH: 3.0, MOTION: 5.0, POSITION: 2.0}  # in any order
    assert deviation_weights(weights).tolist() == [2.0, 2.0, 3.0, 3.0]
    assert joint_step_weight(weights) == 5.0
    assert deviation_weights({MOTION: 1.0}).tolist() == [0.0] * 4
    steeper = replace(TORCH, name="work_deg", coordinates=(WORK,))
    assert deviation_weights({TORCH: 3.0, steeper: 4.0}).tolist() == [0.0, 0.0, 7.0, 3.0]


def test_ranges_are_centred_on_zero_for_the_weld_and_on_the_target_for_the_torch():
    low, high = WeldTargets(work_rad=5 * DEG).attitude_box_rad
    np.testing.assert_allclose(np.degrees(low), [-30, -90, -10, -15], rtol=0, atol=ROUND_OFF)
    np.testing.assert_allclose(np.degrees(high), [30, 90, 20, 15], rtol=0, atol=ROUND_OFF)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"slope_rad": 1.0}, "slope: 57.2958 deg is outside its range 30"),
        ({"rotation_range_rad": 4.0}, "rotation: its range must be above 0 and at most 180 deg, got 229.183"),
        ({"torch_range_rad": 0.0}, "torch range: expected above 0 and at most 45 deg, got 0"),
        ({"work_rad": math.nan}, "work angle: expected -45 to 45 deg, got nan"),
    ],
)
def test_impossible_targets_are_refused(values, says):
    with pytest.raises(InputError, match=says):
        WeldTargets(**values)


SUMS = 1e-9  #: Sums of some tens of products near a thousand.
SAMPLING = 0.01  #: Three standard deviations of a share of 0.3 in 20 000 random points.


def test_nondominated_rows_by_hand():
    values = np.array([[1, 3], [2, 2], [3, 1], [2, 3], [2, 2], [0.5, 9]], dtype=float)
    assert is_nondominated(values).tolist() == [True, True, True, False, False, True]


def test_hypervolume_is_that_of_boxes_by_hand():
    assert hypervolume(np.array([[1.0, 1.0, 1.0]]), np.array([2.0, 3.0, 4.0])) == 6.0
    two = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    assert hypervolume(two, np.array([2.0, 2.0, 1.0])) == 3.0
    assert hypervolume(np.array([[5.0, 0.0, 0.0]]), np.array([2.0, 2.0, 1.0])) == 0.0


def test_hypervolume_is_the_share_of_random_points_that_some_row_beats():
    rng = np.random.default_rng(0)
    values, points = rng.uniform(0.2, 1.0, (12, 3)), rng.uniform(0.0, 1.0, (20_000, 3))
    share = (values[:, None] <= points).all(axis=2).any(axis=0).mean()
    assert hypervolume(values, np.ones(3)) == pytest.approx(share, rel=0, abs=SAMPLING)


def test_a_dominated_row_adds_nothing_and_another_one_does():
    rng = np.random.default_rng(1)
    values = rng.uniform(0.0, 1.0, (10, 3))
    before = hypervolume(values, np.ones(3))
    assert hypervolume(np.vstack([values, values[3] + 0.01]), np.ones(3)) == pytest.approx(before, rel=0, abs=SUMS)
    assert hypervolume(np.vstack([values, values.min(axis=0)]), np.ones(3)) > before


def test_a_thinned_front_holds_the_ends_and_leaves_no_gap():
    x = np.linspace(0.0, 1.0, 101)
    rows = thin_front(np.stack([x, 100.0 * (1.0 - x)], axis=1), 5)
    assert rows.tolist() == [0, 25, 50, 75, 100]
    assert thin_front(np.ones((3, 2)), 5).tolist() == [0, 1, 2]


def test_objectives_must_be_as_many_as_the_reference():
    with pytest.raises(InputError, match="expected rows of 2 objectives"):
        hypervolume(np.zeros((3, 3)), np.zeros(2))
