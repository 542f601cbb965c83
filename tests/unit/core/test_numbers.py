"""A number is what people and machines write as one, and nothing else that Python takes for one."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wpcal.core.errors import InputError
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
    ["nan", "inf", "-Infinity", "1e400", "1.0000001e9", "81_2", "１２", "٣", "0x10", "1,5", "", "1 2", "e5", "."],
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
