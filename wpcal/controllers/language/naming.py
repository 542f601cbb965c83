"""Names from a CAD file made safe for a controller, with a table from each original name to the written one."""

from __future__ import annotations

import re
import textwrap
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from wpcal.core.errors import InputError

SHORTEST_STEM = 2  #: A stem needs at least a letter and a digit to differ from another.


@dataclass(frozen=True, slots=True)
class NameRules:
    """The names that a language allows: a letter, then letters, digits and underscores; case does not matter."""

    language: str  #: For messages.
    longest: int  #: Characters.
    keywords: str = ""  #: Reserved words, lower case, with spaces between them.


def reserved_words(module: str) -> str:
    """Return the words of ``keywords.txt`` beside a module: those of the language, and those of our programs."""
    return Path(module).with_name("keywords.txt").read_text(encoding="ascii")


def safe_names(names: Sequence[str], rules: NameRules, *, room: int = 0) -> dict[str, str]:
    """Find a name that the language allows for every original name.

    Raises `InputError` when an original name appears twice or the suffix leaves no room.

    Returns: From the original to the written name, in the same order. No two written names differ in case only.
    """
    if len(set(names)) < len(names):
        raise InputError(f"names must be unique: {', '.join(sorted({n for n in names if names.count(n) > 1}))}")
    longest = rules.longest - room
    if longest < SHORTEST_STEM:
        raise InputError(f"{rules.language} names have {rules.longest} characters, {room} of them for numbers")
    table: dict[str, str] = {}
    taken = set(rules.keywords.split())
    for name in names:
        stem = _plain_stem(name)
        written, number = stem[:longest], 1
        while written.lower() in taken:
            number += 1
            mark = f"_{number}"
            written = stem[: longest - len(mark)] + mark
        taken.add(written.lower())
        table[name] = written
    return table


def safe_name(name: str, rules: NameRules) -> str:
    """Return one name that the language allows."""
    return safe_names([name], rules)[name]


def own_name(name: str, rules: NameRules, *, what: str) -> str:
    """Return a name that the user gave for something on the controller, unchanged.

    Raises `InputError` when the language does not allow it. A changed name would mean something else on the controller.
    """
    if safe_name(name, rules) != name:
        raise InputError(
            f"{what} {name!r}: {rules.language} names have up to {rules.longest} letters, digits and underscores, "
            "begin with a letter and are not a keyword"
        )
    return name


def in_ascii(text: str) -> str:
    """Return a text in one line of ASCII; all other characters are written as escapes."""
    ascii_text = text.encode("ascii", "backslashreplace").decode("ascii")
    return "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in ascii_text)


def comment_lines(lines: Sequence[str], *, mark: str, longest: int) -> list[str]:
    """Return comments: each line made `in_ascii` and wrapped at `longest` characters, with `mark` before each."""
    folded = (
        part
        for line in lines
        for part in textwrap.wrap(in_ascii(line), longest, subsequent_indent="  ", drop_whitespace=True) or [""]
    )
    return [f"{mark}{part}".rstrip() for part in folded]


def _plain_stem(name: str) -> str:
    """Strip accents and replace all but letters, digits and underscores."""
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode("ascii")
    stem = re.sub(r"\W+", "_", plain, flags=re.ASCII).strip("_")
    return stem if stem[:1].isalpha() else f"W_{stem}".rstrip("_")
