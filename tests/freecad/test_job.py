"""The whole job in FreeCAD's window: one run of `inside/steps_job.py`, and what it left.

A push plays it until all points are touched, and has the whole job without the window (`test_headless.py`).
"""

import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from tests.freecad.running import ROOT, install_addon
from tests.freecad.window import WindowRun, missing_tools, run_in_window
from wpcal.results.folder import read_finished

TEE = ROOT / "fixtures" / "tee"
STEPS = Path(__file__).parent / "inside" / "steps_job.py"
LONGEST_S = 240
SAME_POSE = 1e-6  #: FreeCAD writes coordinates of STEP files with 15 digits: the pose is that of the golden result.
LARGEST_PICTURE_BYTES = 150_000
FEWEST_COLOURS = 20  #: A window that was not drawn has one or two colours.
PICTURES = ("seams", "touches", "calibrate", "placed", "export")


def run_steps(folder: Path, **environment: str) -> WindowRun:
    if missing_tools():
        pytest.skip(f"not installed: {', '.join(missing_tools())}")
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment |= {"WPCAL_TEE": str(TEE), "PATH": path, "WPCAL_CACHE": "off"}
    addon = install_addon(folder) / "WpCal"
    return run_in_window(STEPS, folder, seconds=LONGEST_S, addon=addon, environment=environment)


@pytest.fixture(scope="module")
def job(tmp_path_factory: pytest.TempPathFactory) -> tuple[WindowRun, Path]:
    folder = tmp_path_factory.mktemp("job")
    return run_steps(folder), folder


def test_clicks_and_typed_coordinates_have_the_golden_residuals(tmp_path: Path) -> None:
    facts = run_steps(tmp_path, WPCAL_ONLY_TOUCHES="1").facts
    golden = json.loads((TEE / "golden" / "calibration.json").read_text(encoding="utf-8"))
    assert facts["summary"].startswith("PASS")
    assert facts["residuals"] == [f"{point['distance_mm']:.3f}" for point in golden["points"]]


@pytest.mark.deep
def test_they_become_the_golden_calibration(job: tuple[WindowRun, Path]) -> None:
    run, _ = job
    golden = json.loads((TEE / "golden" / "calibration.json").read_text(encoding="utf-8"))
    assert run.facts["verdict"] == golden["verdict"] == run.facts["verdict again"]
    np.testing.assert_allclose(run.facts["pose"], golden["T_base_part"], rtol=0, atol=SAME_POSE)


@pytest.mark.deep
def test_the_preferences_find_wpcal_and_say_how_to_install_it(job: tuple[WindowRun, Path]) -> None:
    run, _ = job
    assert Path(run.facts["found"]).samefile(Path(sys.executable).parent / "wpcal")
    assert "/nowhere/wpcal" in run.facts["missing"]
    assert "pipx install" in run.facts["missing"]


@pytest.mark.deep
def test_the_result_folder_is_one_of_calibrate_and_programs_are_in_it(job: tuple[WindowRun, Path]) -> None:
    run, _ = job
    finished = read_finished(Path(run.facts["result"]))
    assert [seam.name for seam in finished.seams] == ["W1", "W2", "W3", "W4"]
    assert run.facts["saved again"].endswith("Tick: Replace an existing result")
    assert "“Welding speed (mm/s)”: -3.0 is not" in run.facts["wrong speed"]  # the field, not the option
    programs = [Path(program) for program in run.facts["programs"]]
    assert [program.name for program in programs] == ["WPCAL.mod", "WPCAL.dat", "WPCAL.src"]
    assert "vWeld:=[6," in programs[0].read_text(encoding="utf-8")  # the speed that was typed
    plan = json.loads((Path(run.facts["touch_folder"]) / "touches.json").read_text(encoding="utf-8"))
    assert len(plan["searches"]) == 6


@pytest.mark.deep
def test_options_undo_and_a_saved_document_keep_what_was_made(job: tuple[WindowRun, Path]) -> None:
    run, _ = job
    assert run.facts["verdict for 0.2 mm"] == "UNSURE"
    assert run.facts["tolerance again"] == "0.4"
    assert "has each plate where it is" in run.facts["plates"]
    assert "plate" not in run.facts["plates again"]
    assert run.facts["undone"] == 4  # calibrate, two tolerances, coordinate systems
    assert run.facts["redone"]
    kept = run.facts["kept"]
    assert {"WpCalSeams", "WpCalTaught", "WpCalCalibration", "WpCalPlaced", "WpCalFrames"} <= set(kept)
    assert sum(name.startswith("Frame_") for name in kept) == 4  # both ends of two seams


@pytest.mark.deep
@pytest.mark.parametrize("name", PICTURES)
def test_the_pictures_for_the_docs_show_something_and_are_small(job: tuple[WindowRun, Path], name: str) -> None:
    _, folder = job
    picture = folder / f"freecad-{name}.png"
    assert picture.stat().st_size <= LARGEST_PICTURE_BYTES
    colours = np.rint(255.0 * imread(picture)[..., :3]) @ [1, 256, 65536]
    assert len(np.unique(colours)) >= FEWEST_COLOURS
