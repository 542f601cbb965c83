# SPDX-License-Identifier: MIT
"""Coordinates that a person pastes: from a teach pendant, a spreadsheet, or a line of a program."""

from __future__ import annotations

import re

_NUMBER = r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?"
_LABELLED = re.compile(rf"\b([XYZ])\s*[:=]?\s*({_NUMBER})", re.IGNORECASE)
"""As robots show a position: `X 812.29 Y -240.62 Z 165.80`, `X=812.29`."""
_PLAIN = re.compile(rf"(?<![\w.])({_NUMBER})")  #: A number that is not part of a name such as `P12`.
_DECIMAL_COMMA = re.compile(r"(?<=\d),(?=\d)")
_THOUSANDS = re.compile(r"(?<![\d.,])\d{1,3}[ \u00a0\u202f]\d{3}[.,]\d")  #: A space between thousands, as in `1 234,5`.


def pasted_points(text: str) -> list[tuple[str, str, str]]:
    """Return the points in a text, one per line: the first three numbers of each, or those after X, Y and Z.

    A comma is the decimal sign if the line has no decimal point and something else separates its numbers.

    Raises `ValueError` when a line is not empty and has fewer than three numbers, or when spaces may separate its
    thousands.
    """
    points = []
    for number, line in enumerate(text.splitlines(), 1):
        if line.strip():
            points.append(_point(line, number))
    return points


def _point(line: str, number: int) -> tuple[str, str, str]:
    has_thousands = _THOUSANDS.search(line) is not None
    if "." not in line and re.search(r"[;\t]|\d\s+[-+]?\d", line.strip()):
        line = _DECIMAL_COMMA.sub(".", line)
    labelled = {axis.upper(): value for axis, value in reversed(_LABELLED.findall(line))}
    values = [labelled[axis] for axis in "XYZ"] if len(labelled) == 3 else _PLAIN.findall(line)
    if len(values) < 3:
        raise ValueError(f"line {number}: expected three numbers, got {line.strip()[:60]!r}")
    if has_thousands and len(values) > 3:
        raise ValueError(f"line {number}: write thousands without a space: {line.strip()[:60]!r}")
    return values[0], values[1], values[2]
