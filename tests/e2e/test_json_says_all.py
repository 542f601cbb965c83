"""``--json`` carries every note that the console shows."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from tests.running import FINISHED, run_here

FIXTURES = Path(__file__).parents[2] / "fixtures"
MARKS = ("note: ", "warning: ")
WIDE = "10000"
"""No line is broken."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A part with an oddity (its unit), a part without, and points of which one is wrong and one is left out."""
    text = (FIXTURES / "tee" / "tee.step").read_text()
    assert "SI_UNIT(.MILLI.,.METRE.)" in text
    (tmp_path / "cm.step").write_text(text.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT(.CENTI.,.METRE.)"))
    shutil.copy(FIXTURES / "tee" / "tee.step", tmp_path)
    rows = (FIXTURES / "tee" / "taught_blunder.csv").read_text().splitlines()
    rows[-1] = rows[-1].replace("check", "no")
    (tmp_path / "taught.csv").write_text("\n".join(rows) + "\n")
    shutil.copy(FIXTURES / "yin2003" / "table1.csv", tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", WIDE)
    return tmp_path


def both(*arguments: str, out: bool = False) -> tuple[list[str], dict[str, Any]]:
    """Return the notes that the console shows, and the record that ``--json`` prints."""
    shown = run_here(*arguments, *(("-o", "shown") if out else ()))
    printed = run_here(*arguments, *(("-o", "printed") if out else ()), "--json")
    assert shown.returncode == printed.returncode, (shown.stderr, printed.stderr)
    assert shown.returncode in FINISHED, shown.stderr
    lines = (line.strip() for line in shown.stdout.splitlines())
    notes = [line.removeprefix(mark) for line in lines for mark in MARKS if line.startswith(mark)]
    return notes, json.loads(printed.stdout)


def messages(record: dict[str, Any]) -> list[str]:
    return [issue["message"] for issue in record["issues"]]


@pytest.mark.usefixtures("folder")
def test_seams_says_what_is_odd_in_the_file() -> None:
    notes, record = both("seams", "cm.step")
    assert notes == messages(record)
    assert "unit-not-mm" in [issue["code"] for issue in record["issues"]]


@pytest.mark.usefixtures("folder")
def test_advise_says_what_is_odd_in_the_file() -> None:
    notes, record = both("advise", "cm.step", "--points", "3")
    assert notes == record["notes"]
    assert any("the file is in cm" in note for note in notes)


@pytest.mark.usefixtures("folder")
def test_calibrate_and_export_carry_notes_and_verdict() -> None:
    notes, record = both("calibrate", "tee.step", "taught.csv", out=True)
    assert notes
    for note in notes:
        is_list = note.startswith("left out by hand (use no): ")
        assert note in messages(record) or (is_list and record["left_out"] == note.split(": ")[1].split(", "))
    exported = run_here("export", "printed", "-f", "json", "--json")
    assert json.loads(exported.stdout)["verdict"] == record["verdict"]


@pytest.mark.usefixtures("folder")
def test_fit_carries_its_warnings() -> None:
    notes, record = both("fit", "table1.csv", "--tolerance-mm", "0.01")
    assert notes
    assert set(notes) <= set(messages(record))
