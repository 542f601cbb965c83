"""How a message shows a value or names that came from a file: short, however long they are, and harmless."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

LONGEST_SHOWN = 40  #: Characters of a wrong text that a message repeats.
MOST_LISTED = 20  #: Names that a message lists.
MOST_NAMED = 6  #: Names that a sentence about what to do lists; tables and pages have the rest.
_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""Control characters except tabs and line ends, characters that turn the direction of writing or end a line, and half
surrogates."""


def printable(text: str) -> str:
    r"""Return a text with its control characters as escapes, so that a name cannot steer a terminal.

    >>> print(printable("plate \x1b[31m"))
    plate \u001b[31m
    """
    return _CONTROL.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def shown(value: object) -> str:
    """Return a wrong value for a message, cut where it is long."""
    if isinstance(value, Sequence | Mapping) and not isinstance(value, str):
        return f"a {'list' if isinstance(value, Sequence) else 'record'} of {len(value)} entries"
    if isinstance(value, int) and abs(value) >= 10**LONGEST_SHOWN:
        return f"a number of more than {LONGEST_SHOWN} digits"
    text = repr(value[: LONGEST_SHOWN + 1] if isinstance(value, str) else value)
    return text if len(text) <= LONGEST_SHOWN + 2 else f"{text[:LONGEST_SHOWN]}…"


def short(value: float) -> str:
    """Return a number with the three digits that count, and no power of ten where it is large: ``0.256``, ``1520``."""
    return f"{float(f'{value:.3g}'):.9g}"


def counted(number: int, word: str) -> str:
    """Return a number with its noun: ``1 face``, ``31 faces``."""
    return f"{number} {word}" if number == 1 else f"{number} {plural(word)}"


def plural(word: str) -> str:
    """Return the plural of a noun: ``points``, ``touches``."""
    return f"{word}es" if word.endswith(("ch", "s", "sh", "x")) else f"{word}s"


def listed(names: Iterable[str], most: int = MOST_LISTED) -> str:
    """Return names for a message, separated by commas; where there are many, the first of them and their number."""
    found = list(names)
    text = ", ".join(name if len(name) <= LONGEST_SHOWN else f"{name[:LONGEST_SHOWN]}…" for name in found[:most])
    return f"{text} and {len(found) - most} more" if len(found) > most else text
