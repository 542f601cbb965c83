"""Numbers as text: one rule for every table, program, URDF file and option.

A number is written with the digits 0 to 9, is finite and is at most `LARGEST_MM`, unless its reader states another
limit. Python alone would also accept ``81_2``, digits of other scripts, ``nan`` and ``infinity``.
"""

from __future__ import annotations

import math
import re

from wpcal.core.arrays import LARGEST_MM
from wpcal.core.errors import InputError
from wpcal.core.wording import shown

NUMBER = re.compile(r"[-+]?(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)(?:[eE][-+]?[0-9]++)?")
"""Possessive: the time to refuse a text stays proportional to its length."""
_WHOLE = re.compile(r"[-+]?[0-9]++")
_NOT_FINITE = ("nan", "inf", "infinity")


def parse_number(text: str, *, most: float = LARGEST_MM) -> float:
    """Return the number that a text is; blanks around it are ignored.

    Raises `InputError` when the text is empty, is not a number, or the number is not finite or too large.

    >>> parse_number(" -8.1e2")
    -810.0
    >>> parse_number("81_2")
    Traceback (most recent call last):
    wpcal.core.errors.InputError: expected a number, got '81_2'
    """
    plain = text.strip()
    if not NUMBER.fullmatch(plain):
        kind = "a finite number" if plain.lower().lstrip("+-") in _NOT_FINITE else "a number"
        raise InputError(f"expected {kind}, got {shown(plain)}")
    value = float(plain)
    if not abs(value) <= most:
        what = "a finite number" if math.isinf(value) else f"a number of at most {most:g}"
        raise InputError(f"expected {what}, got {shown(plain)}")
    return value


def parse_numbers(text: str, *, most: float = LARGEST_MM) -> list[float]:
    """Return numbers separated by commas, as options take them.

    Raises `InputError` when one of them is not a number; see `parse_number`.
    """
    return [parse_number(cell, most=most) for cell in text.split(",")]


def parse_whole_number(text: str, *, most: int = 10**9) -> int:
    """Return the whole number that a text is.

    Raises `InputError` when the text is not a whole number of at most `most`.
    """
    plain = text.strip()
    if not _WHOLE.fullmatch(plain) or len(plain) > len(str(most)) + 1 or abs(int(plain)) > most:
        raise InputError(f"expected a whole number of at most {most:g}, got {shown(plain)}")
    return int(plain)
