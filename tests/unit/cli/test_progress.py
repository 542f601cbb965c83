"""Without a terminal, a command that lasts says its steps on stderr, one line each."""

import time
from pathlib import Path

import pytest

from tests.running import run_here
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
    assert said(capsys) == [f"wpcal: {step} …" for step in steps]


def test_a_short_command_says_nothing(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv(PATIENCE_VARIABLE, "600")
    with counted_progress("starting") as show:
        show("trials", 1, 2)
    assert said(capsys) == []


def test_a_step_that_lasts_says_its_numbers(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv(PATIENCE_VARIABLE, "0.05")
    with counted_progress("starting") as show:
        show("trials", 5, 10)
        time.sleep(0.5)
    assert said(capsys) == ["wpcal: trials: 5 of 10 …"]


def test_a_study_says_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PATIENCE_VARIABLE, "0")
    done = run_here("study", TABLE, "--trials", "20")
    assert done.stderr.splitlines()[-1] == "wpcal: trials: 20 of 20 …"
