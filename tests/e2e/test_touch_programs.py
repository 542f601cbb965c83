"""Touch programs as they are exported, run by robots that are not there (`tests/touch_robots`)."""

import re

import numpy as np
import pytest

from tests.few import few
from tests.running import run_here
from tests.touch_plans import TEE_PLAN, tee_plan
from tests.touch_robots.loop import BRANDS, CONFIG, displacement, planned_frame, run_program
from tests.touch_robots.robot import CrashError, Senses
from tests.touch_robots.solid import Solid, triangles_of
from wpcal.controllers.language.touch import ENDED_TEXT
from wpcal.touch.searches import TouchSetup

ROUND_OFF_MM = 2e-3
"""Programs state poses to 0.001 mm and 0.001 degrees or better, and the frame makes 1 µm of that at 100 mm."""
NAMES = [search.name for search in tee_plan().searches]


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    out = tmp_path_factory.mktemp("programs")
    formats = [part for name in BRANDS for part in ("-f", name)]
    ended = run_here("export", TEE_PLAN, *formats, *CONFIG, "-o", out)
    assert ended.returncode == 0, ended.stderr
    return out


@pytest.fixture(scope="module")
def tee():
    return triangles_of(TEE_PLAN.parent / "tee.step")


def run(brand, programs, tee, out, moved, **options):
    solid = Solid(tee, planned_frame(tee_plan()) @ displacement(*moved))
    return run_program(brand, programs / brand, solid, out, **options)


@pytest.mark.parametrize("brand", BRANDS)
def test_a_missed_search_stops_and_is_named_the_next_one_runs_and_the_second_ends_the_program(
    brand, programs, tee, tmp_path
):
    """The part is 14 mm too low: the searches end above it."""
    ran = run(brand, programs, tee, tmp_path, ((0.0, 0.0, -14.0),))
    assert not ran.run.is_finished
    assert (ran.run.stops[0].split()[0], ENDED_TEXT in ran.run.messages[-1]) == ("T1", True)
    assert [word for word in NAMES if any(f"{word} missed" in text for text in ran.run.messages)] == NAMES[:2]
    assert ran.robot.hits == []


@pytest.mark.parametrize("brand", BRANDS)
def test_a_signal_that_is_on_stops_and_the_robot_does_not_search(brand, programs, tee, tmp_path):
    ran = run(brand, programs, tee, tmp_path, ((0.0, 0.0, 0.0),), senses=Senses(always_on=True))
    assert not ran.run.is_finished
    assert (ran.run.stops[0].split()[0], ENDED_TEXT in ran.run.messages[-1]) == ("T1", True)
    assert "signal on" in ran.run.stops[0]


@pytest.mark.parametrize("brand", BRANDS)
def test_an_operator_may_end_the_program_at_a_missed_search(brand, programs, tee, tmp_path):
    ran = run(brand, programs, tee, tmp_path, ((0.0, 0.0, -14.0),), goes_on=False)
    assert not ran.run.is_finished
    assert len(ran.run.stops) == 1
    assert ran.results.exists()


STATED = 2.58  #: In standard deviations of the plan: as far as 99 % of the parts are off along any direction.


def drawn(brand, count):
    """Return directions of six freedoms, 1 mm or 0.3 degrees long."""
    rows = np.random.default_rng(sum(map(ord, brand))).normal(size=(count, 6))
    return rows / np.linalg.norm(rows, axis=1, keepdims=True) * ([1.0] * 3 + [0.3] * 3)


@pytest.mark.parametrize("brand", few(BRANDS, 1))
def test_a_part_as_far_off_as_stated_is_touched_by_searches_only(brand, programs, tee, tmp_path):
    for row in STATED * drawn(brand, 4):
        ran = run(brand, programs, tee, tmp_path, (row[:3], row[3:]))
        assert ran.run.is_finished
        assert len(ran.robot.hits) == len(NAMES)


@pytest.mark.parametrize("brand", few(BRANDS, 1))
def test_a_part_farther_off_is_met_on_sensed_ways_only_and_two_misses_end_the_program(brand, programs, tee, tmp_path):
    ends = []
    for mm, row in zip(np.linspace(8.0, 40.0, 6), drawn(brand, 6), strict=True):
        off = row[:3] * [1.0, 1.0, 0.5]
        off[2] = abs(off[2])  # the robot passes over a part that is too low
        ran = run(brand, programs, tee, tmp_path, (mm * off / np.linalg.norm(off), row[3:]))
        told = [
            name for name in NAMES if any(re.search(rf"{name}\W+.*(missed|active|on)", m) for m in ran.run.messages)
        ]
        assert (len(told) == TouchSetup().most_misses) != ran.run.is_finished
        ends.append(not ran.run.is_finished)
    assert sum(ends) >= 3


def test_a_wire_without_voltage_is_found(programs, tee, tmp_path):
    with pytest.raises(CrashError, match="signal does not come"):
        run("krl", programs, tee, tmp_path, ((0.0, 0.0, 0.0),), senses=Senses(never_on=True))
