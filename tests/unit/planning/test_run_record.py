"""Times of a run, the joint that limits them, and the record of a run."""

import csv
import io
import json
import math
import re
from dataclasses import replace

import jsonschema
import numpy as np
import pytest

from tests.saddle import changed
from wpcal.controllers.program.two_robots import build_sync_program, possible_programs, write_programs
from wpcal.core.errors import InputError
from wpcal.core.records import to_json
from wpcal.core.schemas import schema_text
from wpcal.planning.cell.shape import Shape
from wpcal.planning.plan.plan import schedule_plan
from wpcal.planning.plan.run import build_run
from wpcal.planning.plan.run_record import run_csv, run_record

pytest.importorskip("fcl", reason="python-fcl is not installed")
RELATIVE = 1e-9  #: Ten significant digits.
CHAIN_MM = 0.02  #: Five decimals of a degree: 9e-8 rad at 2 m in twelve joints are 2e-3 mm.
CLOSED_CHAIN_MM = 1e-6  #: Asked of every point of every plan.


@pytest.fixture(scope="module")
def run(cell, simple_plan):
    return build_run(simple_plan, cell, schedule_plan(simple_plan, cell))


def tip_in_part(cell, joints1, joints2):
    return (np.linalg.inv(cell.held_places(joints2)) @ cell.tool_places(joints1))[:, :3, 3]


def test_the_table_says_what_the_record_says(cell, run):
    record = json.loads(to_json(run_record(run, cell)))
    rows = list(csv.DictReader(io.StringIO(run_csv(run, cell))))
    assert len(rows) == len(record["points"]) == len(run)
    for row, point in zip(rows, record["points"], strict=True):
        joints = [float(row[f"r{r}_{name}_deg"]) for r in (1, 2) for name in "SLURBT"]
        np.testing.assert_allclose(joints, point["robot1_deg"] + point["robot2_deg"], rtol=RELATIVE, atol=0)
        assert (row["mark"], row["phase"]) == (str(point["mark"]), point["phase"])
        for name in ("s_mm", "slope_deg", "rotation_deg", "work_deg", "travel_deg", "clearance_mm"):
            if point[name] is None:
                assert row[name] == ""
            else:
                np.testing.assert_allclose(float(row[name]), point[name], rtol=RELATIVE, atol=0)


def test_the_record_keeps_its_schema(cell, run, golden):
    schema = json.loads(schema_text("wpcal/plan/1"))
    validator = jsonschema.Draft202012Validator(schema)
    for one in (run, replace(run, check=None)):
        record = json.loads(to_json(run_record(one, cell)))
        validator.validate(record)
    with pytest.raises(jsonschema.ValidationError):
        validator.validate({**record, "freedom": "surely"})
    golden([run, record])


def test_the_record_puts_the_wire_on_the_seam(cell, run, simple_plan):
    record = json.loads(to_json(run_record(run, cell)))
    weld = [point for point in record["points"] if point["s_mm"] is not None]
    joints = (np.radians([point[f"robot{robot}_deg"] for point in weld]) for robot in (1, 2))
    expected = tip_in_part(cell, simple_plan.q[:, :6], simple_plan.q[:, 6:])
    np.testing.assert_allclose(tip_in_part(cell, *joints), expected, rtol=0, atol=CLOSED_CHAIN_MM)
    times = np.array([point["t_s"] for point in weld])
    np.testing.assert_allclose(
        (weld[-1]["s_mm"] - weld[0]["s_mm"]) / (times[-1] - times[0]), record["speed_mm_s"], rtol=RELATIVE, atol=0
    )


def test_the_rapid_program_puts_the_wire_on_the_seam(cell, run, simple_plan):
    programs = write_programs(build_sync_program(run, cell), ("rapid",))
    joints = []
    for robot in (1, 2):
        rows = re.findall(r"jointtarget \w+:=\[\[([^\]]*)\]", programs[f"WPCAL_W1_R{robot}.mod"])
        joints.append(np.radians([[float(v) for v in row.split(",")] for row in rows]))
    tip = tip_in_part(cell, *joints)[run.first : run.last + 1]
    expected = tip_in_part(cell, simple_plan.q[:, :6], simple_plan.q[:, 6:])
    np.testing.assert_allclose(tip, expected, rtol=0, atol=CHAIN_MM)


def test_unchecked_is_said_and_never_free(cell, run, simple_plan):
    unchecked = replace(run, check=None)
    record = run_record(unchecked, cell)
    assert record["freedom"] == "unchecked"
    assert record["check"] is None
    assert all(point["clearance_mm"] is None for point in record["points"])
    for text in write_programs(build_sync_program(unchecked, cell)).values():
        assert "free" not in text
    assert "NOT CHECKED for collisions" in write_programs(build_sync_program(unchecked, cell))["WPCAL_W1_R1.mod"]
    checked = run_record(run, cell)
    assert checked["freedom"] == "free"
    assert checked["check"]["states"] == (len(run) - 1) * 10 + 1
    assert checked["check"]["least_margin_mm"] > 0


def test_a_path_that_is_not_free_becomes_no_program(cell, run, simple_plan, golden):
    place = cell.tool_places(simple_plan.q[40:41, :6])[0, :3, 3] + [0, 0, 60]
    blocked = replace(cell, bench=(*cell.bench, Shape("clamp", [place], [place], [25.0])))
    hit = build_run(simple_plan, blocked, schedule_plan(simple_plan, blocked))
    record = run_record(hit, blocked)
    assert record["freedom"] == "not free"
    assert "clamp" in record["check"]["between"]
    with pytest.raises(InputError, match=r"no program is written for a path that is not free: .* clamp"):
        build_sync_program(hit, blocked)
    golden(record)


def test_a_language_that_cannot_hold_a_program_does_not_stop_the_others(cell, run):
    silent = replace(cell.arm2, joints=tuple(replace(joint, speed_rad_s=None) for joint in cell.arm2.joints))
    program = build_sync_program(run, changed(cell, arm2=silent))
    programs, refusals = possible_programs(program)
    assert sorted(programs) == ["WPCAL_W1_R1.mod", "WPCAL_W1_R2.mod"]
    assert len(refusals) == 1
    assert "does not state the speed of joint S" in refusals[0]


def test_unknown_languages_are_refused(cell, run):
    with pytest.raises(InputError, match="unknown language 'karel'; known: inform, rapid"):
        write_programs(build_sync_program(run, cell), ("karel",))


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


def test_the_seam_is_slowed_as_a_whole_until_every_joint_can_follow(cell, simple_plan, golden):
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
    golden([schedule, schedule.describe()])


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
