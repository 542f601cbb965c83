"""The example scripts of docs/ do what they say."""

import json
import os
import re
import runpy
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import wpcal

ROOT = Path(__file__).parents[2]
TEACHING_MM = 0.3  #: The touched points of the example are off by 0.1 mm per axis (standard deviation).


Run = Callable[..., str]


@pytest.fixture
def run_example(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run a script as Python does, in this process: the CAD kernel loads once for all of them."""

    def run(name: str, *arguments: Path | str) -> str:
        script = str(ROOT / "docs" / "examples" / name)
        monkeypatch.setattr(sys, "argv", [script, *map(str, arguments)])
        runpy.run_path(script, run_name="__main__")
        shown = capsys.readouterr()
        assert shown.err == ""
        return shown.out

    return run


def test_one_call_is_the_whole_story(run_example: Run) -> None:
    shown = run_example("one_call.py")
    assert shown.startswith("PASS: 2 solids")
    assert "largest residual 0.227 mm" in shown
    assert shown.count(": tee, ") == 2
    # the part's corner V7, where W3 begins, by the pose that the example's points were made with
    begin = wpcal.RigidTransform.from_six_tuple([900, 100, 50, 0, 0, 0.3], target="base", source="part").apply(
        [25.0, 64.0, 10.0]
    )
    found = re.search(r"^W3: tee, 150\.0 mm, starts at \(\((.*?)\)", shown, flags=re.MULTILINE)
    assert np.linalg.norm(np.array(found[1].split(","), dtype=float) - begin) < TEACHING_MM


def test_on_the_part_lists_features_and_seams(run_example: Run) -> None:
    shown = run_example("on_the_part.py")
    assert "V2: vertex of plate at [0.0, 0.0, 10.0]" in shown
    assert shown.count(": accepted, first ((") == 2  # the two short ends belong to these


def test_without_cad_fits_arrays(run_example: Run) -> None:
    shown = run_example("without_cad.py")
    assert "PASS: 0.107 mm at A; no fit is below 0.107 mm" in shown
    assert "correction of the cell's model: SixTuple(x_mm=0.0" in shown


def test_plates_that_moved_are_found_from_arrays(run_example: Run) -> None:
    shown = run_example("plates_that_moved.py")
    assert shown.count(" for web on plate") == 8
    assert "bodies moved (p < 0.001)" in shown
    moved = re.findall(r"^(\w+) moved by \[(.*)\] mm", shown, flags=re.MULTILINE)
    along_y = {name: float(v.split(",")[1]) for name, v in moved}
    assert along_y["web"] - along_y["plate"] == pytest.approx(-1.5, abs=0.1)


@pytest.mark.deep
def test_the_weldment_goes_from_the_model_to_the_program(
    run_example: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = (ROOT / "docs" / "examples" / "weldment.py").read_text(encoding="utf-8")
    page = (ROOT / "docs" / "how-to" / "scripting.md").read_text(encoding="utf-8")
    assert set(re.findall(r"```python\n(.*?)```", page, re.DOTALL)[0].splitlines()) <= set(script.splitlines())
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    shown = run_example("weldment.py")
    assert "PASS; the real plate ends at" in shown
    names = [seam["name"] for seam in json.loads((tmp_path / "result" / "seams.json").read_text())["seams"]]
    assert "root" in names
    assert (tmp_path / "result" / "rapid" / "WPCAL.mod").is_file()


def test_in_steps_writes_the_moved_part(run_example: Run, tmp_path: Path) -> None:
    fixture, moved = ROOT / "fixtures" / "tee", tmp_path / "moved.step"
    shown = run_example("in_steps.py", fixture / "tee.step", fixture / "taught.csv", moved)
    assert "PASS" in shown
    assert "note:" not in shown
    assert moved.stat().st_size > (fixture / "tee.step").stat().st_size
