"""An ordinary lap joint at the default uncertainty: its ends are touched after its faces."""

import json
from pathlib import Path

import numpy as np
import pytest

from cad.kernel.call import kernel_call
from cad.kernel.primitives import box
from cad.samples.parts import DARK, STEEL
from cad.step.new_file import new_step_text
from tests.few import few
from tests.running import run_here
from tests.touch_robots.loop import BRANDS, CONFIG, T_FLANGE_TOOL, displacement, planned_frame, run_program
from tests.touch_robots.robot import Torch
from tests.touch_robots.solid import Solid, triangles_of
from wpcal.core.records import write_file
from wpcal.touch.searches.record import read_touch_plan

PLACE = "812,-240,156,1.1459,-2.005,34.377"
MOVED = ((1.2, -1.0, 0.8), (0.2, -0.3, 0.25))  #: How the part stands beside its planned place.
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
    assert "two stages" not in commanded("touches", lap, "--after", first, stored, "-o", second)
    promised = [json.loads((each / "touches.json").read_text())["predicted"]["error_95_mm"] for each in (first, second)]
    assert promised[1] == pytest.approx(promised[0], rel=0.2)
    stored = ran(brand, lap, second, true)
    commanded("calibrate", lap, stored, "--touches", second / "touches.json", "-o", out)
    T = np.array(json.loads((out / "calibration.json").read_text())["T_base_part"])
    points = triangles_of(lap).reshape(-1, 3)
    assert np.linalg.norm(points @ (T - true)[:3, :3].T + (T - true)[:3, 3], axis=1).max() < FOUND_MM
