"""Points without names, and one that was mis-taught."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from tests.running import run_here

pytestmark = pytest.mark.usefixtures("kernel_here")

FIXTURES = Path(__file__).parents[2] / "fixtures"


@pytest.fixture
def nameless(tmp_path: Path) -> Path:
    """The tee's taught points in another order, without their names; and the truth as the feature's name."""
    rows = list(csv.DictReader((FIXTURES / "tee" / "taught.csv").read_text().splitlines()))
    lines = [f"P{i},{r['x_mm']},{r['y_mm']},{r['z_mm']},,{r['use']}" for i, r in enumerate(reversed(rows), 1)]
    path = tmp_path / "nameless.csv"
    path.write_text("\n".join(["name,x_mm,y_mm,z_mm,feature,use", *lines, ""]))
    return path


def test_match_finds_the_names(nameless: Path) -> None:
    done = run_here("match", FIXTURES / "tee" / "tee.step", nameless, "--sigma-mm", "0.1", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    record = json.loads(done.stdout)
    assert record["answers"][record["chosen"]]["features"] == ["H1", "V6", "V12", "V16", "V4", "V2"]


def test_calibrate_gives_the_same_place_without_names(nameless: Path, tmp_path: Path) -> None:
    done = run_here("calibrate", FIXTURES / "tee" / "tee.step", nameless, "--sigma-mm", "0.1", "-o", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "out" / "calibration.json").read_text())
    golden = json.loads((FIXTURES / "tee" / "golden" / "calibration.json").read_text())
    assert found["objective_mm"] == pytest.approx(golden["objective_mm"], rel=0, abs=1e-6)
    assert found["features"] == {"P1": "H1", "P2": "V6", "P3": "V12", "P4": "V16", "P5": "V4", "P6": "V2"}


def test_a_symmetric_part_is_refused_and_nothing_is_written(tmp_path: Path) -> None:
    taught = tmp_path / "taught.csv"
    rows = csv.DictReader((FIXTURES / "saddle" / "taught.csv").read_text().splitlines())
    lines = [f"P{i},{r['x_mm']},{r['y_mm']},{r['z_mm']}," for i, r in enumerate(rows, 1)]
    taught.write_text("\n".join(["name,x_mm,y_mm,z_mm,feature", *lines, ""]))
    step = FIXTURES / "saddle" / "saddle.step"
    done = run_here("calibrate", step, taught, "-o", tmp_path / "out")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "a half turn about the line along z through (0, 0, 0)" in done.stderr
    assert not (tmp_path / "out").exists()
    listed = run_here("match", step, taught)
    assert listed.returncode == 2
    assert listed.stderr == done.stderr
    assert "H2" in listed.stdout
    near = run_here("match", step, taught, "--nominal", "800,-240,150,0,0,30", "--json")
    assert near.returncode == 0, near.stderr
    assert json.loads(near.stdout)["chosen"] is not None


TEE = Path(__file__).parents[2] / "fixtures" / "tee"
SAME_FIT_MM = 1e-6  # two runs of the polish on the same five points


def test_a_mis_taught_point_is_named_and_left_out_by_hand(tmp_path: Path) -> None:
    first = run_here("calibrate", TEE / "tee.step", TEE / "taught_blunder.csv", "-o", tmp_path / "first")
    assert (first.returncode, first.stderr) == (1, "")
    shown = " ".join(first.stdout.split())
    assert "With and without V16 (weighted)" in shown
    assert "the other points contradict V16 (2.96 mm off their fit), probability above 99 %: teach again" in shown
    assert "left out by hand (use no): V10" in shown

    rows = (TEE / "taught_blunder.csv").read_text().replace("178.15,yes", "178.15,no")
    (tmp_path / "again.csv").write_text(rows)
    again = run_here("calibrate", TEE / "tee.step", tmp_path / "again.csv", "-o", tmp_path / "again")
    assert (again.returncode, again.stderr) == (0, "")
    before, after = (json.loads((tmp_path / name / "calibration.json").read_text()) for name in ("first", "again"))
    assert (before["distrusted"]["names"], after["distrusted"], after["left_out"]) == (["V16"], None, ["V16", "V10"])
    found = before["distrusted"]["without"]["rms_mm"]
    np.testing.assert_allclose(found, after["rms_mm"], rtol=0, atol=SAME_FIT_MM)
