"""What the terminal shows: progress, and names as text."""

import io
import re
import sys
import time
from pathlib import Path

import pytest
from rich.table import Table

from tests.running import run_here, run_process
from wpcal.cli import progress
from wpcal.cli.console import plain_console
from wpcal.cli.progress import PATIENCE_VARIABLE, counted_progress, shown_progress
from wpcal.cli.streams import PrintableText
from wpcal.core.wording import printable
from wpcal.pages.html import build_page

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


EVIL = "plate \x1b]0;owned\x07\x1b[2J\x9b31m\u202egnp"
SHOWN = r"plate \u001b]0;owned\u0007\u001b[2J\u009b31m\u202egnp"


def test_control_characters_are_escaped_and_letters_stay() -> None:
    assert printable(EVIL) == SHOWN
    assert printable("Träger 1\t– ok\n漢字 👍") == "Träger 1\t– ok\n漢字 👍"
    assert printable("\ud800") == r"\ud800"


def test_a_table_escapes_names_and_keeps_its_own_colours(monkeypatch: pytest.MonkeyPatch) -> None:
    raw = io.BytesIO()
    stream = PrintableText(raw, encoding="utf-8", errors="replace")
    monkeypatch.setattr(sys, "stdout", stream)
    monkeypatch.setenv("FORCE_COLOR", "1")
    table = Table("solid", title=EVIL)
    table.add_row(EVIL)
    plain_console().print(table)
    plain_console().print(f"note: {EVIL}", highlight=False)
    print(EVIL)
    stream.flush()
    text = raw.getvalue().decode()
    assert text.count(r"\u001b]0;owned\u0007") == 4
    assert "\x1b]" not in text
    assert "\x9b" not in text
    assert "\u202e" not in text
    assert "\x1b[1m" in text  # a heading is bold


def test_a_process_escapes_what_a_file_says(tmp_path) -> None:
    (tmp_path / "p.csv").write_text("name,x_mm\x1b[31m,y_mm\nA,1,2\n")
    done = run_process("fit", "p.csv", cwd=tmp_path)
    assert done.returncode == 2
    assert r"found name, x_mm\u001b[31m, y_mm" in done.stderr
    assert "\x1b" not in done.stderr


def test_the_title_of_a_page_is_escaped() -> None:
    page = build_page(title=EVIL, entry="report", body="", data={"name": EVIL})
    assert "\x1b" not in page
    assert "\u202e" not in page
