"""Names from files, made harmless for a terminal and a page. Every command needs this at its start: no imports."""

import re

_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""Control characters except tabs and line ends, characters that turn the direction of writing or end a line, and half
surrogates."""


def printable(text: str) -> str:
    r"""Return a text with its control characters as escapes, so that a name cannot steer a terminal.

    >>> print(printable("plate \x1b[31m"))
    plate \u001b[31m
    """
    return _CONTROL.sub(lambda match: f"\\u{ord(match[0]):04x}", text)
