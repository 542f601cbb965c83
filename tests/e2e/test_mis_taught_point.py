"""A point that the others contradict is named by the main job, with the answer with it and without it."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.running import run_here

pytestmark = pytest.mark.usefixtures("kernel_here")

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
