"""Regular expressions of the library mean the same on every supported Python."""

import ast
import re
from pathlib import Path

import pytest

from wpcal.core.errors import InputError
from wpcal.core.numbers import parse_number

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


@pytest.mark.parametrize("text", ["1e", "1e+", ".5e-", "1.e", "1e1e", "+", "."])
def test_half_a_number_is_refused_in_one_line(text):
    with pytest.raises(InputError, match="expected a number"):
        parse_number(text)
