"""Without a terminal, a command that lasts says its steps on stderr, one line each."""

import re
import time
from pathlib import Path

import pytest

from tests.running import run_here
from wpcal.cli import progress
from wpcal.cli.progress import PATIENCE_VARIABLE, counted_progress, shown_progress

TABLE = Path(__file__).parents[3] / "fixtures" / "yin2003" / "table1.csv"


def said(capsys: pytest.CaptureFixture[str]) -> list[str]:
    return capsys.readouterr().err.splitlines()


def test_one_line_per_step(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv(PATIENCE_VARIABLE, "0")
    with shown_progress("starting") as show:
        for text in ("reading a.step", "comparing 10 %", "comparing 20 %", "fitting"):
            show(text)
    steps = ["starting", "reading a.step", "comparing 10 %", "fitting"]
    assert said(capsys) == [f"wpcal: {step} … (0 s)" for step in steps]


def test_a_short_command_says_nothing(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv(PATIENCE_VARIABLE, "600")
    with counted_progress("starting") as show:
        show("trials", 1, 2)
    assert said(capsys) == []


def test_a_step_that_lasts_says_its_numbers(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv(PATIENCE_VARIABLE, "0.05")
    monkeypatch.setattr(progress, "REPEAT_S", 0.6)
    with counted_progress("starting") as show:
        show("trials", 5, 10)
        time.sleep(0.3)
        show("trials", 7, 10)
        time.sleep(0.9)
    first, *_, last = said(capsys)
    assert first.startswith("wpcal: trials: 5 of 10 … (")
    assert last.startswith("wpcal: trials: 7 of 10 … (")


def test_a_study_says_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PATIENCE_VARIABLE, "0")
    done = run_here("study", TABLE, "--trials", "20")
    assert re.fullmatch(r"wpcal: trials: 20 of 20 … \(\d+ s\)", done.stderr.splitlines()[-1])


def test_a_fit_says_how_many_points_it_has(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PATIENCE_VARIABLE, "0")
    done = run_here("fit", TABLE, "--json")
    assert done.stderr == "wpcal: fitting 4 points … (0 s)\n"
    assert done.stdout.startswith("{")
