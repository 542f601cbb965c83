"""Touch programs as they are exported, run by robots that are not there (`tests/touch_robots`)."""

import numpy as np
import pytest

from tests.few import few
from tests.running import run_here
from tests.touch_plans import TEE_PLAN, tee_plan
from tests.touch_robots.loop import BRANDS, CONFIG, displacement, planned_frame, run_program
from tests.touch_robots.robot import CrashError, Senses
from tests.touch_robots.solid import Solid, triangles_of
from wpcal.controllers.run.machine import inverted

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


@pytest.mark.parametrize("brand", few(BRANDS, 3))
def test_a_part_in_its_place_is_touched_where_the_plan_says(brand, programs, tee, tmp_path):
    ran = run(brand, programs, tee, tmp_path, ((0.0, 0.0, 0.0),))
    assert ran.run.is_finished
    assert ran.run.stops == []
    places = [(inverted(planned_frame(tee_plan())) @ hit.T_base_tool)[:3, 3] for hit in ran.robot.hits]
    planned = [search.planned for search in tee_plan().searches]
    assert np.array(places) == pytest.approx(np.array(planned), abs=ROUND_OFF_MM)
    assert ran.results.exists()


@pytest.mark.parametrize("brand", few(BRANDS, 3))
def test_a_missed_search_stops_and_is_named_and_the_next_one_runs(brand, programs, tee, tmp_path):
    """The part is 14 mm too low: the searches end above it, but for those of the web and of the hole."""
    ran = run(brand, programs, tee, tmp_path, ((0.0, 0.0, -14.0),))
    assert ran.run.is_finished
    assert [stop.split()[0] for stop in ran.run.stops] == ["T1", "T2", "T3", "T4", "T5", "T6", "T8"]
    assert all("missed" in stop for stop in ran.run.stops)
    assert len(ran.robot.hits) == 1


@pytest.mark.parametrize("brand", BRANDS)
def test_a_signal_that_is_on_stops_and_the_robot_does_not_search(brand, programs, tee, tmp_path):
    ran = run(brand, programs, tee, tmp_path, ((0.0, 0.0, 0.0),), senses=Senses(always_on=True))
    assert [stop.split()[0] for stop in ran.run.stops] == NAMES
    assert all("signal on" in stop for stop in ran.run.stops)


@pytest.mark.parametrize("brand", BRANDS)
def test_an_operator_may_end_the_program_at_a_missed_search(brand, programs, tee, tmp_path):
    ran = run(brand, programs, tee, tmp_path, ((0.0, 0.0, -14.0),), goes_on=False)
    assert not ran.run.is_finished
    assert len(ran.run.stops) == 1
    assert ran.results.exists()


def test_a_part_in_the_way_of_the_air_moves_is_found(programs, tee, tmp_path):
    with pytest.raises(CrashError, match="the wire meets the part"):
        run("rapid", programs, tee, tmp_path, ((30.0, 0.0, 0.0),))


def test_a_wire_without_voltage_is_found(programs, tee, tmp_path):
    with pytest.raises(CrashError, match="signal does not come"):
        run("krl", programs, tee, tmp_path, ((0.0, 0.0, 0.0),), senses=Senses(never_on=True))
