"""An ordinary lap joint at the default uncertainty: its ends are touched after its faces."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cad.kernel.call import kernel_call
from cad.kernel.primitives import box
from cad.samples.parts import DARK, STEEL
from cad.step.new_file import new_step_text
from tests.few import few
from tests.running import run_here
from tests.touch_robots.loop import BRANDS, CONFIG, T_FLANGE_TOOL, displacement, planned_frame, run_program
from tests.touch_robots.robot import Torch, Welder
from tests.touch_robots.solid import Solid, triangles_of
from wpcal.core.records import write_file
from wpcal.touch.searches.record import read_touch_plan

PLACE = "812,-240,156,1.1459,-2.005,34.377"
MOVED = ((1.2, -1.0, 0.8), (0.2, -0.3, 0.25))  #: How the part stands beside its planned place.
LIFTED = ((1.2, -1.0, 3.0), (0.2, -0.3, 0.25))  #: By so much that the ends are not where a single stage searches them.
FOUND_MM = 0.02  #: Of any place of the part, with rounding to three digits.
pytestmark = pytest.mark.usefixtures("kernel_here")


@pytest.fixture(scope="module")
def lap(tmp_path_factory):
    """Return two plates of 6 mm that lie on each other by 40 mm."""
    path = tmp_path_factory.mktemp("lap") / "lap.step"
    with kernel_call("making a lap joint"):
        plates = [("lower", box(300, 150, 6, (0, 0, 0)), STEEL), ("upper", box(300, 150, 6, (0, 110, 6)), DARK)]
    write_file(path, new_step_text(plates, "lap"), overwrite=True)
    return path


def test_the_second_stage_has_the_tool_of_the_first(lap, tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    commanded("touches", lap, "--nominal", PLACE, "--standoff-mm", "15", "-o", first)
    commanded("touches", lap, "--after", first, "-", "-o", second)
    commanded("export", second, "-f", "rapid")
    text = (second / "rapid" / "WPCAL_touch.mod").read_text()
    stated = re.search(r"wptT1_S:=\[\[(.*?)\],\[(.*?)\]", text)
    p, (w, *xyz) = (np.array(each.split(","), dtype=float) for each in stated.groups())
    tip = p + 15.0 * Rotation.from_quat([*xyz, w]).as_matrix()[:, 2]
    np.testing.assert_allclose(tip, read_touch_plan(second).search("T1").start, rtol=0, atol=1e-3)
    other = run_here("touches", lap, "--after", first, "-", "--standoff-mm", "10", "-o", tmp_path / "other")
    assert (other.returncode, "--standoff-mm 10 (the command line): the plan of touches has 15" in other.stderr) == (
        2,
        True,
    )


def commanded(*words):
    """Run a command that plans or writes."""
    done = run_here(*words)
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


def ran(brand: str, step: Path, plan: Path, true: np.ndarray) -> Path:
    """Write the program of a plan, run it on the part where it really stands, and return what it stored."""
    commanded("export", plan, "-f", brand, *CONFIG)
    torch = Torch(T_FLANGE_TOOL, stick_out_mm=read_touch_plan(plan).stick_out_mm, nozzle_radius_mm=11.0)
    found = run_program(brand, plan / brand, Solid(triangles_of(step), true), plan / "results", torch=torch)
    assert found.run.is_finished
    assert found.run.stops == []
    return found.results


@pytest.mark.parametrize("brand", few(list(BRANDS), 1))
def test_the_ends_of_thin_plates_are_found_from_their_faces(brand, lap, tmp_path):
    first, second, out = (tmp_path / name for name in ("first", "second", "out"))
    told = commanded("touches", lap, "--nominal", PLACE, "-o", first)
    assert "the first of two stages" in told
    true = planned_frame(read_touch_plan(first)) @ displacement(*MOVED)
    stored = ran(brand, lap, first, true)
    refused = run_here("calibrate", lap, stored, "--touches", first / "touches.json", "-o", out)
    assert (refused.returncode, "plan the second" in refused.stderr) == (2, True)
    assert "the first of two stages" not in commanded("touches", lap, "--after", first, stored, "-o", second)
    promised = [json.loads((each / "touches.json").read_text())["predicted"]["error_95_mm"] for each in (first, second)]
    assert promised[1] == pytest.approx(promised[0], rel=0.2)
    stored = ran(brand, lap, second, true)
    commanded("calibrate", lap, stored, "--touches", second / "touches.json", "-o", out)
    T = np.array(json.loads((out / "calibration.json").read_text())["T_base_part"])
    points = triangles_of(lap).reshape(-1, 3)
    assert np.linalg.norm(points @ (T - true)[:3, :3].T + (T - true)[:3, 3], axis=1).max() < FOUND_MM


@pytest.fixture(scope="module")
def welding(lap, tmp_path_factory):
    """Return the folder of both plans, at the planned place, and of programs that touch in two stages and weld."""
    folder = tmp_path_factory.mktemp("welding")
    first, second, placed, out = (folder / name for name in ("first", "second", "placed", "out"))
    commanded("touches", lap, "--nominal", PLACE, "-o", first)
    told = commanded("touches", lap, "--after", first, "-", "-o", second)
    assert "the second of two stages: strokes allow for 3.0 mm" in told
    true = planned_frame(read_touch_plan(first))
    stored = ran("rapid", lap, first, true)
    commanded("touches", lap, "--after", first, stored, "-o", placed)
    stored = ran("rapid", lap, placed, true)
    commanded("calibrate", lap, stored, "--touches", placed / "touches.json", "-o", out)
    for name, plans in (("both", (first, second)), ("alone", (second,))):
        words = [word for plan in plans for word in ("--touches", plan)]
        commanded("export", out, "-f", "rapid", "-f", "krl", *words, "-o", folder / name)
    return folder


def welded(brand: str, step: Path, folder: Path, moved, name: str):
    """Run searches and welds of a part that is displaced; return the run and the weld poses."""
    plan = read_touch_plan(folder / "second")
    torch = Torch(T_FLANGE_TOOL, stick_out_mm=plan.stick_out_mm, nozzle_radius_mm=11.0)
    solid = Solid(triangles_of(step), planned_frame(plan) @ displacement(*moved))
    out = folder / "stored"
    found = run_program(brand, folder / name / brand, solid, out, torch=torch, goes_on=False, kind=Welder)
    return found.run, found.robot.welded


@pytest.mark.parametrize("brand", few(["krl", "rapid"], 1))
def test_one_program_touches_in_two_stages_and_welds(brand, lap, welding):
    """The seams end where they are; with the second stage alone a search misses, and nothing is welded."""
    run, planned = welded(brand, lap, welding, ((0.0, 0.0, 0.0),), "both")
    assert run.is_finished, run.messages
    run, poses = welded(brand, lap, welding, LIFTED, "both")
    assert run.is_finished, run.messages
    T = planned_frame(read_touch_plan(welding / "second"))
    off = poses @ np.linalg.inv(planned) @ T - T @ displacement(*LIFTED)
    points = triangles_of(lap).reshape(-1, 3)
    assert np.linalg.norm(points @ off[:, :3, :3].transpose(0, 2, 1) + off[:, None, :3, 3], axis=2).max() < FOUND_MM
    run, poses = welded(brand, lap, welding, LIFTED, "alone")
    assert (run.is_finished, len(poses)) == (False, 0)


def test_two_plans_that_are_not_two_stages_are_one_line(welding, tmp_path):
    first, second = (welding / name for name in ("first", "second"))
    for plans, message in (
        ((second, first), "expected a plan that does not hold the part by itself"),
        ((first, second, second), "touches have one or two stages"),
        ((first,), "leave a motion of the part free"),
    ):
        words = [word for plan in plans for word in ("--touches", plan)]
        done = run_here("export", welding / "out", "-f", "krl", *words, "-o", tmp_path / "none")
        assert (done.returncode, done.stderr.count("wpcal: ")) == (2, 1), done.stderr
        assert message in done.stderr
    words = ("--touches", first, "--touches", second, "-o", tmp_path / "none")
    done = run_here("export", welding / "out", "-f", "inform", "--config", "1,0,0,0,0,0,0,0", *words)
    assert (done.returncode, "touch and weld in one run is not written in this language" in done.stderr) == (2, True)
    assert not (tmp_path / "none").exists()
