import math

import numpy as np
import pytest

from wpcal.core.errors import InputError
from wpcal.planning.search.objectives import (
    Wishes,
    attitude_box,
    f1_1,
    f1_2,
    f2,
    f4,
    joint_motion,
    position_deviation,
    torch_deviation,
)

ROUND_OFF = 1e-12
"""Sums of some numbers near one."""
DEG = math.pi / 180.0


def coordinates(slope=0.0, rotation=0.0, work=0.0, travel=0.0, count=5):
    row = np.array([0, 0, 0, 0, slope, rotation, work, travel, 0], dtype=float)
    return np.tile(row * DEG, (count, 1))


def test_position_and_torch_deviations_are_root_mean_squares_in_degrees():
    wishes = Wishes(slope_rad=10 * DEG, travel_rad=-5 * DEG)
    assert position_deviation(coordinates(slope=13, rotation=-4), wishes) == pytest.approx(5.0, rel=0, abs=ROUND_OFF)
    assert torch_deviation(coordinates(work=-12, travel=0), wishes) == pytest.approx(13.0, rel=0, abs=ROUND_OFF)
    half = np.concatenate([coordinates(slope=13, rotation=4, count=3), coordinates(slope=10, count=3)])
    assert position_deviation(half, wishes) == pytest.approx(5.0 / 2**0.5, rel=0, abs=ROUND_OFF)


def test_motion_of_one_joint_is_its_rate_with_its_weight(cell):
    s = np.array([0.0, 1.0, 4.0])
    joints = np.zeros((3, 12))
    joints[:, 6] = 2.0 * DEG * s  # two degrees a millimetre
    weights = np.concatenate([cell.weights1, cell.weights2])
    expected = 2.0 * math.sqrt(weights[6] / weights.sum())
    assert joint_motion(cell, s, joints) == pytest.approx(expected, rel=0, abs=ROUND_OFF)
    assert joint_motion(cell, s, joints[:, ::-1]) != pytest.approx(expected, rel=0, abs=1e-3)


def test_an_even_motion_is_smoother_than_a_jerk_but_not_as_printed(cell):
    s = np.arange(5.0)
    even, jerk = np.zeros((5, 12)), np.zeros((5, 12))
    even[:, 0], jerk[:, 0] = 0.1 * s, np.array([0, 0, 0.4, 0.4, 0.4])
    assert joint_motion(cell, s, even) < 0.6 * joint_motion(cell, s, jerk)
    assert f2(cell, even) == pytest.approx(f2(cell, jerk), rel=0, abs=ROUND_OFF)


def test_f1_1_is_the_printed_product_and_one_zero_factor_frees_the_other():
    wishes = Wishes(slope_rad=10 * DEG, slope_range_rad=30 * DEG, rotation_range_rad=90 * DEG)
    slope, rotation = np.full(4, 16 * DEG), np.full(4, -45 * DEG)
    assert f1_1(slope, rotation, wishes) == pytest.approx(6 / 30 * 45 / 90, rel=0, abs=ROUND_OFF)
    assert f1_1(np.full(4, 10 * DEG), np.full(4, 80 * DEG), wishes) == 0.0
    assert f1_1(slope, np.full(4, np.nan), wishes) == 0.0


def test_f1_2_is_the_printed_product_least_at_the_limits():
    wishes = Wishes(torch_range_rad=10 * DEG)
    neutral = f1_2(np.zeros(3), np.zeros(3), wishes)
    assert neutral == pytest.approx((1 - 90 / 100) ** 2, rel=0, abs=ROUND_OFF)
    at_limit = f1_2(np.full(3, -10 * DEG), np.zeros(3), wishes)  # α = 100° = its largest
    assert at_limit == pytest.approx(0.0, rel=0, abs=ROUND_OFF)


def test_f2_is_the_printed_sum(cell):
    joints = np.zeros((4, 12))
    joints[1:, 5] = 72 * DEG  # the last joint of an MH6 has a range of 720°
    weights = np.concatenate([cell.weights1, cell.weights2])
    assert f2(cell, joints) == pytest.approx(weights[5] / weights.sum() * 0.1 / 4, rel=0, abs=ROUND_OFF)


def test_f4_asks_for_more_than_the_safety_distance():
    assert f4(np.array([19.9, 20.0, 20.1]), 20.0).tolist() == [False, False, True]


def test_ranges_stand_around_zero_for_the_weld_and_around_the_wish_for_the_torch():
    low, high = attitude_box(Wishes(work_rad=5 * DEG))
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
def test_wishes_that_cannot_be_are_refused(values, says):
    with pytest.raises(InputError, match=says):
        Wishes(**values)
