"""Names come from files of others: they are printed with their control characters as escapes."""

import io
import sys

import pytest
from rich.table import Table

from tests.running import run_process
from wpcal.cli.console import plain_console
from wpcal.cli.streams import PrintableText
from wpcal.core.printable import printable
from wpcal.pages.html import build_page

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
