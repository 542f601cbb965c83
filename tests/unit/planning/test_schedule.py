"""Times: one speed along the seam, no joint faster than it can, and the joint that limits it named."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.saddle import changed
from wpcal.core.errors import InputError
from wpcal.planning.plan.plan import schedule_plan

ROUND_OFF = 1e-9  #: Relative; seconds and mm/s of size 1 to 100.
CHORD = 2e-3
"""Arc length to chord of steps of 2 mm on a radius of 25 mm: (step / radius)² / 24 = 3e-4, and what the discretisation
of the seam adds."""


@pytest.mark.parametrize("asked", [6.0, 0.5, 60.0])
def test_the_wire_goes_along_the_seam_at_the_asked_speed(cell, simple_plan, asked):
    schedule = schedule_plan(simple_plan, cell, speed_mm_s=asked)
    tip = np.linalg.inv(cell.part_places(simple_plan.q)) @ cell.tool_places(simple_plan.q[:, :6])
    speeds = np.linalg.norm(np.diff(tip[:, :3, 3], axis=0), axis=1) / np.diff(schedule.t_s)
    np.testing.assert_allclose(speeds, asked, rtol=CHORD, atol=0)
    assert schedule.t_s[0] == 0.0
    assert not schedule.is_slowed


def test_the_seam_is_slowed_as_a_whole_until_every_joint_can_follow(cell, simple_plan):
    schedule = schedule_plan(simple_plan, cell, speed_mm_s=1000.0)
    assert schedule.is_slowed
    np.testing.assert_allclose(
        np.diff(simple_plan.s_mm) / np.diff(schedule.t_s), schedule.speed_mm_s, rtol=ROUND_OFF, atol=0
    )
    rates = np.abs(np.diff(simple_plan.q, axis=0)) / np.diff(schedule.t_s)[:, None]
    use = rates / cell.speeds
    np.testing.assert_allclose(use.max(), 1.0, rtol=ROUND_OFF, atol=0)
    row, column = np.unravel_index(np.argmax(use), use.shape)
    arm = (cell.arm, cell.arm2)[column // 6]
    limit = schedule.limit
    assert (limit.robot, limit.joint) == (column // 6 + 1, arm.joints[column % 6].name)
    assert limit.s_mm == simple_plan.s_mm[row]
    assert "1000 asked" in schedule.describe()
    assert f"joint {limit.joint} of robot {limit.robot}" in schedule.describe()


def test_a_slower_joint_slows_the_seam(cell, simple_plan):
    joints = tuple(replace(joint, speed_rad_s=joint.speed_rad_s / 100) for joint in cell.arm2.joints)
    lazy = changed(cell, arm2=replace(cell.arm2, joints=joints))
    schedule = schedule_plan(simple_plan, lazy, speed_mm_s=6.0)
    assert schedule.limit.robot == 2
    assert schedule.limit.joint == "T"  # the one that turns the pipe
    assert schedule.speed_mm_s < 6.0


def test_arms_without_stated_speeds_limit_nothing(cell, simple_plan):
    silent = [
        replace(arm, joints=tuple(replace(joint, speed_rad_s=None) for joint in arm.joints))
        for arm in (cell.arm, cell.arm2)
    ]
    schedule = schedule_plan(simple_plan, changed(cell, arm=silent[0], arm2=silent[1]), speed_mm_s=1e4)
    assert schedule.speed_mm_s == 1e4
    assert schedule.limit is None
    assert "state no joint speeds" in schedule.describe()


@pytest.mark.parametrize("speed", [0.0, -1.0, math.nan, math.inf])
def test_an_impossible_speed_is_refused(cell, simple_plan, speed):
    with pytest.raises(InputError, match="must be positive"):
        schedule_plan(simple_plan, cell, speed_mm_s=speed)


def test_points_on_one_place_are_refused(cell, simple_plan):
    s = simple_plan.s_mm.copy()
    s[4] = s[3]
    with pytest.raises(InputError, match="points 4 and 5"):
        schedule_plan(replace(simple_plan, s_mm=s), cell)


def test_a_robot_at_rest_has_no_limit_of_its_own(cell, simple_plan):
    still = np.concatenate([simple_plan.q[:, :6], np.repeat(simple_plan.q[:1, 6:], len(simple_plan), axis=0)], axis=1)
    assert schedule_plan(replace(simple_plan, q=still), cell).limit.robot == 1
