"""Decisions about seams, given back in seams.json, through the commands; `unit/seam/test_edits.py` has the rules."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.running import run_here
from tests.saved_graphs import saved_seams
from wpcal.core.records import to_json
from wpcal.seam.record import seams_record

FIXTURES = Path(__file__).parents[2] / "fixtures"
pytestmark = pytest.mark.usefixtures("kernel_here")


def edited_file(folder: Path, edit: Callable[[dict[str, Any]], None]) -> Path:
    """Write the seams of the T-joint with an edit of the first."""
    record = json.loads(to_json(seams_record(saved_seams("tee"))))
    edit(record["seams"][0])
    path = folder / "seams.json"
    path.write_text(json.dumps(record), encoding="utf-8")
    return path


def test_the_commands_take_the_file(tmp_path: Path) -> None:
    part, taught = FIXTURES / "tee" / "tee.step", FIXTURES / "tee" / "taught_exact.csv"
    path = edited_file(tmp_path, lambda seam: seam.update(edit={"reject": True}))
    listed = run_here("seams", part, "--seams", path, "--json")
    assert (listed.returncode, listed.stderr) == (0, "")
    assert [seam["accepted"] for seam in json.loads(listed.stdout)["seams"]] == [False, True, True, False]
    done = run_here("calibrate", part, taught, "-o", tmp_path / "out", "--seams", path)
    assert (done.returncode, done.stderr) == (0, "")
    record = json.loads((tmp_path / "out" / "seams.json").read_text())
    assert [seam["accepted"] for seam in record["seams"]] == [False, True, True, False]
    assert record["seams"][0]["edit"] == {"reject": True}
    # what calibrate wrote, frames in base, is a file to give back, too
    assert run_here("seams", part, "--seams", tmp_path / "out" / "seams.json").returncode == 0


def test_a_stale_edit_is_one_line(tmp_path: Path) -> None:
    def move_start(seam: dict[str, Any]) -> None:
        seam["edit"] = {"reject": True}
        seam["candidate"]["start_part_mm"][0] += 1.0

    done = run_here("seams", FIXTURES / "tee" / "tee.step", "--seams", edited_file(tmp_path, move_start))
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "is not found on this part" in done.stderr
