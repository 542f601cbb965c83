"""How a message shows a value or a name that came from a file: short, on one line, and harmless on a terminal."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

LONGEST_SHOWN = 40
"""Characters of a wrong text that a message repeats."""
MOST_LISTED = 20
"""Names that a message lists."""
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""Control characters except tabs and line ends, characters that turn the direction of writing, half surrogates."""


def shown(value: object) -> str:
    """Return a wrong value for a message, cut where it is long."""
    if isinstance(value, Sequence | Mapping) and not isinstance(value, str):
        return f"a {'list' if isinstance(value, Sequence) else 'record'} of {len(value)} entries"
    if isinstance(value, int) and abs(value) >= 10**LONGEST_SHOWN:
        return f"a number of more than {LONGEST_SHOWN} digits"
    text = repr(value[: LONGEST_SHOWN + 1] if isinstance(value, str) else value)
    return text if len(text) <= LONGEST_SHOWN + 2 else f"{text[:LONGEST_SHOWN]}…"


def listed(names: Iterable[str]) -> str:
    """Return names for a message, separated by commas; where there are many, the first of them and their number."""
    found = list(names)
    text = ", ".join(name if len(name) <= LONGEST_SHOWN else f"{name[:LONGEST_SHOWN]}…" for name in found[:MOST_LISTED])
    return f"{text} and {len(found) - MOST_LISTED} more" if len(found) > MOST_LISTED else text


def printable(text: str) -> str:
    r"""Return a text with its control characters as escapes, so that a name cannot steer a terminal.

    Tabs and line ends are kept.

    Examples
    --------
    >>> printable("plate \x1b[31m")
    'plate \\x1b[31m'
    """
    return _CONTROL.sub(_escaped, text)


def _escaped(match: re.Match[str]) -> str:
    return match[0].encode("unicode_escape").decode("ascii")
