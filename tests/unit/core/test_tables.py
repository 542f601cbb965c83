"""Tables: columns, cells, separators, units, the robot space that they state, and the text of CSV files."""

import csv
import io
from pathlib import Path

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import example, given

from wpcal.core.csv_text import csv_text
from wpcal.core.errors import FormatError, FrameError, InputError
from wpcal.core.robot_space import RobotSpace, common_space, space_of_table
from wpcal.core.tables import parse_table, read_table

HEADER = "name,x_mm,y_mm"


def read(tmp_path, text, encoding="utf-8"):
    path = tmp_path / "points.csv"
    path.write_bytes(text.encode(encoding))
    return read_table(path)


@pytest.mark.parametrize(
    ("body", "line", "column", "words"),
    [
        ("a,1,2\nb,one,2\n", 3, "x_mm", "expected a number, got 'one'"),
        ("a,1,2\n\nb,1,nan\n", 4, "y_mm", "finite"),
        ("a,inf,2\n", 2, "x_mm", "finite"),
        ("a,,2\n", 2, "x_mm", "empty"),
        ('a,"1,5",2\n', 2, "x_mm", "decimal sign"),
        ("a,1,5,2\n", 2, 3, "decimal comma"),
        ("a,1\n", 2, 2, "expected 3 cells, got 2; an empty cell needs its , too"),
    ],
)
def test_a_bad_cell_is_named_with_line_and_column(tmp_path, body, line, column, words):
    with pytest.raises(FormatError, match=words) as caught:
        read(tmp_path, f"{HEADER}\n{body}").numbers(["x_mm", "y_mm"])
    assert (caught.value.line, caught.value.column) == (line, column)
    assert str(caught.value).startswith(str(tmp_path / "points.csv"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "empty"),
        (" \r\n", "empty"),
        (f"{HEADER}\n", "no rows"),
        ("name,x_mm,x_mm\na,1,2\n", "appears twice"),
        ('name,x_mm,y_mm\na,"1,2\n', "not a readable table"),
        ('{"name": ["a"],\n"x_mm": [1, 2]}', "is a JSON file"),
        ("<html>,\n<p>1,2,3</p>", "is an XML or HTML file"),
        (f"{HEADER}\na,1,2\n".encode("utf-16-le").decode(), "UTF-16"),
    ],
)
def test_a_table_that_is_none_is_refused(tmp_path, text, words):
    with pytest.raises(FormatError, match=words):
        read(tmp_path, text)


def test_text_in_another_encoding_is_refused(tmp_path):
    with pytest.raises(FormatError, match="UTF-8"):
        read(tmp_path, f"{HEADER}\nä,1,2\n", encoding="latin-1")


def test_a_file_that_is_not_there_is_one_clear_error(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_table(tmp_path / "missing.csv")


def test_missing_columns_are_named_beside_those_found(tmp_path):
    with pytest.raises(FormatError, match=r"missing column z_mm; found name, x_mm, y_mm"):
        read(tmp_path, f"{HEADER}\na,1,2\n").numbers(["x_mm", "z_mm"])


def test_names_are_unique_and_not_empty(tmp_path):
    with pytest.raises(FormatError, match=r"line 4.*'a' appears twice, first in line 2"):
        read(tmp_path, f"{HEADER}\na,1,2\nb,1,2\na,3,4\n").unique_names("name")
    with pytest.raises(FormatError, match=r"line 2.*empty"):
        read(tmp_path, f"{HEADER}\n,1,2\n").unique_names("name")
    with pytest.raises(FormatError, match=r"line 3.*'b\\x1b' contains a control character"):
        read(tmp_path, f"{HEADER}\na,1,2\nb\x1b,1,2\n").unique_names("name")


def test_choices_fill_in_the_default_and_refuse_other_words(tmp_path):
    table = read(tmp_path, "name,use\na,\nb,Check\n")
    assert table.choices("use", ("yes", "check"), default="yes") == ("yes", "check")
    assert table.choices("other", ("yes",), default="yes") == ("yes", "yes")
    with pytest.raises(FormatError, match="line 2"):
        read(tmp_path, "name,use\na,perhaps\n").choices("use", ("yes", "no"), default="yes")


def test_one_space_passes():
    assert common_space([("a", RobotSpace.IDENTIFIED), ("b", RobotSpace.IDENTIFIED)]) is RobotSpace.IDENTIFIED


def test_mixing_is_refused_by_name():
    with pytest.raises(FrameError, match=r"taught\.csv is in nominal robot space and seams\.json in identified"):
        common_space([("taught.csv", RobotSpace.NOMINAL), ("seams.json", RobotSpace.IDENTIFIED)])


def test_nothing_has_no_space():
    with pytest.raises(InputError):
        common_space([])


def test_a_word_is_parsed_or_refused():
    assert RobotSpace.parse("identified") is RobotSpace.IDENTIFIED
    with pytest.raises(InputError, match="nominal or identified"):
        RobotSpace.parse("real")


def test_a_table_without_the_column_is_nominal(tmp_path):
    assert space_of_table(read(tmp_path, "name,x_mm\na,1")) is RobotSpace.NOMINAL


def test_a_table_tells_its_space_and_may_not_mix(tmp_path):
    assert space_of_table(read(tmp_path, "name,robot_space\na,identified\nb,identified")) is RobotSpace.IDENTIFIED
    with pytest.raises(FrameError, match=r"line 3, in nominal"):
        space_of_table(read(tmp_path, "name,robot_space\na,identified\nb,nominal"))
    with pytest.raises(FormatError, match="line 2"):
        space_of_table(read(tmp_path, "name,robot_space\na,real"))


COLUMNS = ("x_mm", "y_mm")


def numbers(text: str, encoding: str = "utf-8") -> list[list[float]]:
    table = parse_table(text.encode(encoding), path="points.csv")
    found: list[list[float]] = table.numbers(COLUMNS).tolist()
    return found


@pytest.mark.parametrize(
    "text",
    [
        "name,x_mm,y_mm\nA,1812.5,-2.25\n",
        "\ufeffname;x_mm;y_mm\r\n\r\nA;1812,5;-2,25\r\n;;\r\n",
        "name\tx_mm\ty_mm\nA\t1812.5\t-2.25\n",
        "name,x_mm,y_mm\nA,1812.5 mm,-2.25mm\n",
        "name,x_mm,y_mm\nA,1 812.5,-2.25\n",
        "name,x_mm,y_mm\nA,1\u00a0812.5,\u22122.25\n",
        "name;x_mm;y_mm\nA;1'812.5;-2.25\n",
        'name,x_mm,y_mm\nA,"1,812.5",-2.25\n',
        "name;x_mm;y_mm\nA;1.812,5;-2,25\n",
        "Name,X [mm],Y (mm)\nA,1812.5,-2.25\n",
        "name,x_mm,y_mm,,\nA,1812.5,-2.25,,\n",
        ",Position,\nname,x_mm,y_mm\nA,1812.5,-2.25\n",
        'name,x_mm,y_mm\n"A","1812.5","-2.25"',
    ],
    ids=[
        "plain", "German Excel", "tabs", "units", "blank groups", "hard blanks", "Swiss groups", "English groups",
        "German groups", "units in the header", "empty columns", "merged cells", "quoted",
    ],
)  # fmt: skip
def test_one_point_in_many_ways(text: str) -> None:
    assert numbers(text) == [[1812.5, -2.25]]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("name,x_mm,y_mm\nA,1.8 m,2\n", "line 2, column x_mm: '1.8 m' is in m; type the number in mm"),
        ("name,x_mm,y_mm\nA,71.3 in,2\n", "'71.3 in' is in in; type the number in mm"),
        ("name;x_mm;y_mm\nA;1,812;2.5\n", "unclear whether the comma is a decimal sign"),
        ("name;x_mm;y_mm\nA;1,5;2.5\n", "unclear whether the comma is a decimal sign"),
        ("name;x_mm;y_mm\nA;1.812,5;2.500\n", "unclear whether the point is a decimal sign"),
        ('name,x_mm,y_mm\nA,"1,812",2\n', "unclear whether the comma is a decimal sign"),
        ("name,x_mm,y_mm\nA,812,5,2,25\n", "expected 3 cells, got 5; a decimal comma needs ; between the cells"),
        ("name,x_mm,y_mm\nA,nan,2\n", "line 2, column x_mm: expected a finite number, got 'nan'"),
        ("name,x_mm,y_mm\nA,81_2,2\n", "line 2, column x_mm: expected a number, got '81_2'"),
        ("name,x_mm,y_mm\nA,１２,2\n", "expected a number, got '１２'"),
        ("name,x_mm,y_mm\nA,2e9,2\n", "expected a number of at most 1e+09"),
        ("name,x_mm,y_mm\nA,TRUE,2\n", "expected a number, got 'TRUE'"),
        ("name,x_mm,y_mm\nA,1 81.5,2\n", "expected a number, got '1 81.5'"),
        ("name,x,y\nA,1,2\n", "missing column x_mm, y_mm; found name, x, y; write x_mm instead of x"),
        ("name,,x_mm\nA,1,2\n", "line 1: column 2 has no name; write one row with a name for each column"),
        (",,\n,,\n", "all cells are empty; expected a header line"),
        ("name," + ",".join(f"c{i}" for i in range(1200)) + "\n1", "has 1201 columns, expected at most 1000"),
    ],
)
def test_what_to_type_instead_is_one_line(text: str, says: str) -> None:
    with pytest.raises(FormatError) as caught:
        numbers(text)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_degrees_and_other_units() -> None:
    table = parse_table("q1_deg,q2_deg,use\n10°,-20 deg,yes\n".encode(), path="p.csv")
    assert table.numbers(("q1_deg", "q2_deg")).tolist() == [[10.0, -20.0]]
    with pytest.raises(FormatError, match=r"'0\.5 rad' is in rad; type the number in deg"):
        parse_table(b"q1_deg\n0.5 rad\n", path="p.csv").numbers(("q1_deg",))


def test_plain_numbers_take_the_short_way_to_the_same_numbers() -> None:
    values = np.random.default_rng(1).normal(0, 1e3, (200, 2))
    plain = "x_mm,y_mm\n" + "".join(f"{x!r},{y!r}\n" for x, y in values.tolist())
    with_units = "x_mm,y_mm\n" + "".join(f"{x!r} mm,{y!r} mm\n" for x, y in values.tolist())
    assert numbers(plain) == numbers(with_units) == values.tolist()


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
