"""What a spreadsheet makes of our tables: numbers are numbers, texts are texts."""

import csv
import io
from pathlib import Path

import hypothesis.strategies as st
import pytest
from hypothesis import example, given

from wpcal.core.csv_text import csv_text
from wpcal.core.tables import parse_table

FORMULA = "=cmd|' /C calc'!A0"
STARTS = ("=", "+", "-", "@", "\t", "\r")


@pytest.mark.parametrize("text", ["1", "-2.5", "+3e-4", "-.5", "-1,5", "812.290000"])
def test_a_number_stays_a_number(text: str) -> None:
    assert csv_text([[text]]) == csv_text([[text]]).replace("'", "")


@pytest.mark.parametrize("text", [FORMULA, "+1+2", "-2+3", "@SUM(A1)", "\t=1", "\r=1", "-", "'=1", "＝1"])
def test_a_formula_is_text(text: str) -> None:
    (row,) = csv.reader(io.StringIO(csv_text([[text]]), newline=""))
    assert row == [f"'{text}"]


@given(st.text(st.characters(codec="utf-8", exclude_categories=["Cc"])), st.sampled_from([*STARTS, "", "'", "''="]))
@example("1", "-")
def test_reading_gives_what_was_written(text: str, start: str) -> None:
    cell = (start + text).strip()
    table = parse_table(csv_text([["name", "x_mm"], [cell, "1"]]).encode(), path="a.csv")
    assert table.columns["name"] == [cell]


def test_every_table_is_written_here() -> None:
    """A writer of its own would forget the apostrophe."""
    root = Path(__file__).parents[3]
    writers = [
        path.name
        for folder in ("wpcal", "cad")
        for path in (root / folder).rglob("*.py")
        if "csv.writer" in path.read_text()
    ]
    assert writers == []
