import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wpcal.controllers.language.naming import NameRules, comment_lines, in_ascii, safe_names
from wpcal.controllers.program.describe import counted_moves
from wpcal.core.errors import InputError
from wpcal.robot.moves.move import Arc, Line

RULES = NameRules("test", 12, "proc w1 for")


@given(names=st.lists(st.text(max_size=30), unique=True, max_size=12))
def test_every_written_name_is_taken_by_the_language_and_no_two_are_one(names):
    table = safe_names(names, RULES, room=4)
    assert list(table) == names
    written = list(table.values())
    assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,7}", name) for name in written)
    assert len({name.lower() for name in written}) == len(names)
    assert not {name.lower() for name in written} & set(RULES.keywords.split())


def test_names_stay_readable():
    assert safe_names(["Rippe ä 3", "FOR", "12"], RULES) == {"Rippe ä 3": "Rippe_a_3", "FOR": "FOR_2", "12": "W_12"}


def test_names_that_differ_only_in_case_or_beyond_the_length_are_numbered():
    table = safe_names(["abcdefghijklmn", "ABCDEFGHIJKLmo"], RULES)
    assert list(table.values()) == ["abcdefghijkl", "ABCDEFGHIJ_2"]


def test_a_name_twice_and_no_room_are_refused():
    with pytest.raises(InputError, match="unique"):
        safe_names(["a", "a"], RULES)
    with pytest.raises(InputError, match="12 characters"):
        safe_names(["a"], RULES, room=11)


@given(text=st.text(max_size=50))
def test_comments_cannot_leave_their_line(text):
    assert in_ascii(text).isascii()
    assert "\n" not in in_ascii(text)
    assert "\r" not in in_ascii(text)
    assert all(line.startswith("! ") or line == "!" for line in comment_lines([text], mark="! ", longest=20))


def test_long_comments_are_folded():
    lines = comment_lines(["one two three four five"], mark="; ", longest=10)
    assert lines == ["; one two", ";   three", ";   four", ";   five"]


@pytest.mark.parametrize(
    ("moves", "words"),
    [
        ([Line(1)], "1 line"),
        ([Line(1), Arc(2, 3)], "1 line and 1 arc"),
        ([Arc(2, 3)] * 2 + [Line(4)] * 3, "3 lines and 2 arcs"),
    ],
)
def test_moves_are_counted_in_words(moves, words):
    assert counted_moves(moves) == words
