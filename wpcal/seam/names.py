"""Names of seams as a person types them: single names, and ranges as ``W5-W8``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from difflib import get_close_matches

from wpcal.core.errors import InputError
from wpcal.core.wording import listed

_RANGE = re.compile(r"(.*?)(\d+)\s*-\s*(?:\1)?(\d+)", re.IGNORECASE)
"""Letters, first number, last number; the letters may be typed again."""
_NUMBERED = re.compile(r"(.*?)(\d+)[a-z]*", re.IGNORECASE)
"""A seam that was cut has the names W5a and W5b; a range that holds W5 holds both."""


def split_names(text: str) -> tuple[str, ...]:
    """Return the words of a list as ``W1, W5-W8``."""
    return tuple(word.strip() for word in text.split(",") if word.strip())


def seams_named(words: Sequence[str], known: Sequence[str]) -> tuple[str, ...]:
    """Return the seams that are meant, each once, in the order of `words`. Names of `known`.

    Raises `InputError` when a word is no seam, or a range has no seam at one of its ends.

    `words`: Names and ranges. A name counts first, so a seam may be called ``rib-2``. Capital letters do not matter
    where no other seam has the same letters.

    >>> seams_named(["W3", "w5-w7"], ["W1", "W3", "W5", "W6a", "W6b", "W7", "W8"])
    ('W3', 'W5', 'W6a', 'W6b', 'W7')
    """
    meant = [_meant(word, known) for word in words]
    unknown = [word for word, found in zip(words, meant, strict=True) if not found]
    if unknown:
        near = get_close_matches(unknown[0], known, n=3)
        hint = f"; near: {listed(near)}" if near else ""
        raise InputError(f"unknown seam {listed(unknown)}; there are {listed(known) or 'none'}{hint}")
    return tuple(dict.fromkeys(name for found in meant for name in found))


def _meant(word: str, known: Sequence[str]) -> list[str]:
    if word in known:
        return [word]
    same = [name for name in known if name.lower() == word.lower()]
    if len(same) == 1:
        return same
    asked = _RANGE.fullmatch(word)
    if asked is None:
        return []
    letters, first, last = asked[1].lower(), int(asked[2]), int(asked[3])
    if first > last:
        raise InputError(f"{word}: the range runs backwards; write the smaller number first")
    numbered = [(name, found) for name in known if (found := _NUMBERED.fullmatch(name))]
    inside = {name: int(found[2]) for name, found in numbered if found[1].lower() == letters}
    if not {first, last} <= set(inside.values()):
        return []
    return [name for name, number in inside.items() if first <= number <= last]
