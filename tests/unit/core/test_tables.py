import numpy as np
import pytest

from wpcal.core.errors import FormatError, InputError
from wpcal.core.tables import read_table

HEADER = "name,x_mm,y_mm"


def read(tmp_path, text, encoding="utf-8"):
    path = tmp_path / "points.csv"
    path.write_bytes(text.encode(encoding))
    return read_table(path)


@pytest.mark.parametrize(
    "text",
    [
        "name,x_mm,y_mm\na,1.5,-2\nb,0,3e1\n",
        "\ufeffname,x_mm,y_mm\r\na,1.5,-2\r\n\r\nb,0,3e1\r\n",
        "Name; X_mm ;y_mm\na;1,5;-2\nb;0;3e1\n",
        "name\tx_mm\ty_mm\na\t1,5\t-2\nb\t0\t3e1\n",
        'name,x_mm,y_mm\n"a","1.5","-2"\n"b",0,3e1',
    ],
    ids=["plain", "bom and crlf", "semicolon and decimal comma", "tab", "quoted"],
)
def test_one_table_in_many_spellings(tmp_path, text):
    table = read(tmp_path, text)
    assert table.unique_names("name") == ("a", "b")
    assert np.array_equal(table.numbers(["x_mm", "y_mm"]), [[1.5, -2.0], [0.0, 30.0]])


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


def test_comma_beside_point_is_refused_as_doubtful(tmp_path):
    with pytest.raises(FormatError, match="unclear whether the point is a decimal sign"):
        read(tmp_path, "name;x_mm;y_mm\na;1.037,5;2.5\n").numbers(["x_mm", "y_mm"])
    with pytest.raises(FormatError, match="unclear whether the comma is a decimal sign"):
        read(tmp_path, "name;x_mm;y_mm\na;1,5;2.5\n").numbers(["x_mm", "y_mm"])


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
