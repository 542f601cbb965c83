"""Numbers as people type them into a spreadsheet: decimal commas, thousand separators, units.

A cell is accepted where it can mean one number only. Otherwise the message says what to type.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from wpcal.core.errors import InputError
from wpcal.core.numbers import parse_number
from wpcal.core.wording import LONGEST_SHOWN, shown

UNIT_OF_COLUMN = re.compile(r"_(mm2|mm|deg)$")  #: The end of the name of a column of numbers.
_UNIT = re.compile(r"(?<=[0-9.,])\s*(mm²|mm2|mm|cm|dm|m|µm|um|inch|in|\"|deg|°|rad)$", re.IGNORECASE)
_SAME_UNIT = {"mm²": "mm2", "°": "deg", "um": "µm", "inch": "in", '"': "in"}
_HEADER_UNIT = re.compile(r"(?P<name>.*?[^\s_])(?:[\s_]+|\s*[(\[]\s*)(?P<unit>mm²|mm2|mm|deg|°)\s*[)\]]?")
_MINUS = str.maketrans({"\u2212": "-", "\u2013": "-"})
"""The minus signs of typesetting."""
_GROUP_MARKS = " \u00a0\u2009\u202f'\u2019"
"""Blanks and apostrophes between groups of three digits."""
_GROUPED = re.compile(rf"[-+]?[0-9]{{1,3}}(?:[{_GROUP_MARKS}][0-9]{{3}})+(?:[.,][0-9]*+)?")
_WITH_BOTH = re.compile(r"[-+]?[0-9]{1,3}(?:(?P<mark>[.,])[0-9]{3})(?:(?P=mark)[0-9]{3})*(?P<last>[.,])[0-9]*+")
_WITH_ONE_TWICE = re.compile(r"[-+]?[0-9]{1,3}(?:(?P<mark>[.,])[0-9]{3})(?:(?P=mark)[0-9]{3})+")
LONGEST_NUMBER = 100  #: Characters of a cell with a number; a longer one is not looked at more closely.


def column_name(cell: str) -> str:
    """Return the name of a column as wpcal writes it: lower case, with its unit after an underscore.

    >>> column_name(" X [mm]"), column_name("Model x (mm)"), column_name("Name")
    ('x_mm', 'model_x_mm', 'name')
    """
    name = cell.strip().lower()
    found = _HEADER_UNIT.fullmatch(name) if len(name) <= LONGEST_NUMBER else None
    if found is None:
        return name
    unit = _SAME_UNIT.get(found["unit"], found["unit"])
    return f"{'_'.join(found['name'].split())}_{unit}"


def decimal_sign(cells: Iterable[str], *, comma_separates: bool) -> str:
    """Return the decimal sign of columns of numbers: a point, unless the cells can only mean commas.

    `comma_separates`: Whether the file separates its cells by commas. A single comma in a cell is then never a decimal
    sign by itself.
    """
    sure, likely = set(), set()
    for cell in cells:
        if "," not in cell and "." not in cell:
            continue
        text = _bare(cell)[0]
        found = _WITH_BOTH.fullmatch(text)
        twice = _WITH_ONE_TWICE.fullmatch(text)
        if found and found["mark"] != found["last"]:
            sure.add(found["last"])
        elif twice:
            sure.add("." if twice["mark"] == "," else ",")
        else:
            likely |= {sign for sign in ".," if sign in text}
    if sure:
        return "," if sure == {","} else "."
    return "," if likely == {","} and not comma_separates else "."


def number_in_cell(cell: str, *, column: str, decimal: str) -> float:
    """Return the number that a cell holds.

    `column`: Name of the column; its end is the unit in which the number is expected.
    Raises `InputError` when the cell is empty, has another unit, has an ambiguous comma or point, or is not a finite
    number.
    """
    if not cell.strip():
        raise InputError("the cell is empty, expected a number")
    if len(cell) > LONGEST_NUMBER:
        raise InputError(f"expected a number, got {shown(cell)}")
    text, unit = _bare(cell)
    expected = UNIT_OF_COLUMN.search(column)
    if unit and unit != (expected[1] if expected else ""):
        wanted = f"type the number in {expected[1]}" if expected else "type the number alone"
        raise InputError(f"{shown(cell)} is in {unit}; {wanted}")
    return parse_number(_plain(text, cell, decimal))


def _bare(cell: str) -> tuple[str, str]:
    """Return a cell without its unit, and the unit."""
    text = cell.strip().translate(_MINUS)
    found = _UNIT.search(text) if len(text) <= LONGEST_NUMBER else None
    if found is None:
        return text, ""
    unit = found[1].lower()
    return text[: found.start()].rstrip(), _SAME_UNIT.get(unit, unit)


def _plain(text: str, cell: str, decimal: str) -> str:
    """Return a number with a decimal point and without separators of thousands."""
    if _GROUPED.fullmatch(text):
        text = "".join(c for c in text if c not in _GROUP_MARKS)
    other = "," if decimal == "." else "."
    both, twice = _WITH_BOTH.fullmatch(text), _WITH_ONE_TWICE.fullmatch(text)
    if (both and both["mark"] == other and both["last"] == decimal) or (twice and twice["mark"] == other):
        return text.replace(other, "").replace(decimal, ".")
    if other in text or text.count(decimal) > 1:
        if not set(text) <= set("0123456789.,+-eE"):
            raise InputError(f"expected a number, got {shown(cell)}")
        sign = "comma" if other == "," else "point"
        raise InputError(
            f"{cell[:LONGEST_SHOWN]!r}: it is unclear whether the {sign} is a decimal sign; "
            "write a decimal point in every number"
        )
    return text.replace(decimal, ".")
