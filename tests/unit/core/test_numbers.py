"""Numbers, patterns and errors."""

import ast
import math
import pickle
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wpcal.core import errors
from wpcal.core.errors import ConvergenceError, ErrorCode, FormatError, GeometryError, InputError, WpcalError, blamed_on
from wpcal.core.numbers import parse_number, parse_numbers, parse_whole_number


@given(st.floats(-1e9, 1e9))
def test_every_number_in_range_is_read_with_all_its_digits(value: float) -> None:
    assert parse_number(repr(value)) == value


@given(st.text(max_size=20))
def test_a_text_is_a_finite_number_in_range_or_an_input_error(text: str) -> None:
    try:
        value = parse_number(text)
    except InputError:
        return
    assert text.strip().isascii()
    assert math.isfinite(value)
    assert abs(value) <= 1e9


@pytest.mark.parametrize(
    "text",
    [
        "nan",
        "inf",
        "-Infinity",
        "1e400",
        "1.0000001e9",
        "81_2",
        "１２",
        "٣",
        "0x10",
        "1,5",
        "",
        "1 2",
        "e5",
        ".",
        "1e",
        "1e+",
        ".5e-",
        "1.e",
        "1e1e",
        "+",
    ],
)
def test_what_is_no_number_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="expected a"):
        parse_number(text)


@pytest.mark.parametrize(("text", "value"), [("1.", 1.0), ("+.5", 0.5), ("-8.1E+02", -810.0), (" 7 ", 7.0)])
def test_forms_of_a_number(text: str, value: float) -> None:
    assert parse_number(text) == value


def test_lists_and_whole_numbers() -> None:
    assert parse_numbers("1,-2.5, 3e1") == [1.0, -2.5, 30.0]
    assert parse_whole_number("-1") == -1
    for text in ("1.5", "1e3", "9" * 5000, "", "１", "1_0"):
        with pytest.raises(InputError, match="expected a whole number"):
            parse_whole_number(text)


def test_a_long_text_is_cut_in_the_message() -> None:
    with pytest.raises(InputError) as caught:
        parse_number("9" * 100_000 + "x")
    assert len(str(caught.value)) < 100


ROOT = Path(__file__).parents[3]
POSSESSIVE_GROUP = re.compile(r"\)(?:[?*+]|\{[0-9,]*\})\+")
"""A repeated group that gives nothing back. Python before 3.11.5 matches it wrongly if the group fails inside."""


def texts(path: Path) -> list[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)]


def test_no_pattern_repeats_a_group_possessively():
    files = [path for package in ("wpcal", "cad") for path in (ROOT / package).rglob("*.py")]
    assert not [path for path in files for text in texts(path) if POSSESSIVE_GROUP.search(text)]
    assert POSSESSIVE_GROUP.search(r"(?:[eE][0-9]++)?+")


def _classes(base: type[WpcalError] = WpcalError) -> list[type[WpcalError]]:
    return [
        base,
        *(c for child in base.__subclasses__() if child.__module__ == errors.__name__ for c in _classes(child)),
    ]


@pytest.mark.parametrize("kind", _classes())
def test_every_error_has_the_code_of_its_class_unless_told_otherwise(kind: type[WpcalError]) -> None:
    assert kind("what").code == kind.code in set(ErrorCode)
    assert kind("what", code=ErrorCode.EXISTS).code == "exists"


@pytest.mark.parametrize("kind", _classes())
def test_a_code_survives_the_way_out_of_a_child_process(kind: type[WpcalError]) -> None:
    back = pickle.loads(pickle.dumps(kind("what", code=ErrorCode.USER_FRAME_MISSING)))
    assert (type(back), str(back), back.code) == (kind, "what", "user-frame-missing")


def test_the_place_and_the_best_answer_survive_too() -> None:
    back = pickle.loads(pickle.dumps(FormatError("what", path="a.csv", line=3, column="x_mm")))
    assert (str(back), back.what, back.line) == ("a.csv, line 3, column x_mm: what", "what", 3)
    assert pickle.loads(pickle.dumps(ConvergenceError("what", best=2.5))).best == 2.5


def test_naming_the_file_keeps_the_code() -> None:
    with pytest.raises(GeometryError, match=r"^part\.step: collinear$") as caught, blamed_on("part.step"):
        raise GeometryError("collinear", code="on-a-line")
    assert caught.value.code == "on-a-line"
