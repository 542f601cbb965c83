"""KRL source: routines as trees of lines, and data lists."""

from __future__ import annotations

import re
from typing import NamedTuple

from wpcal.controllers.kuka.values import GRAMMAR
from wpcal.controllers.language.grammar import mark_of
from wpcal.controllers.run.blocks import Row, Steps, rows_of, tree
from wpcal.controllers.run.expressions import tokens_of
from wpcal.controllers.run.program import ProgramError

BLOCK = r"(?:FOR|WHILE|LOOP|REPEAT|SWITCH)(?![^\s(])|IF(?![^\s(]).*THEN$"
ENDS = "ENDIF ENDFOR ENDWHILE ENDLOOP UNTIL ENDSWITCH"
MOST_NAME = 24  #: Characters of a name.


class SourceLine(NamedTuple):
    """A line of a data list."""

    number: int
    tokens: list[str]
    text: str

    @property
    def word(self) -> str:
        """The first token."""
        return self.tokens[0].upper()


def _rows(text: str) -> list[Row]:
    """Return the lines without comments, folds and file attributes; of comments the marks of seams."""
    rows = rows_of(text, ";")
    return [row for row in rows if row[1][0] not in ";&" or (row[1][0] == ";" and mark_of(row[1][1:]) is not None)]


def _lines_of(text: str, file: str) -> list[SourceLine]:
    found = []
    for number, bare in _rows(text):
        if not bare.startswith(";"):
            try:
                found.append(SourceLine(number, tokens_of(bare, GRAMMAR), bare))
            except ProgramError as error:
                raise ProgramError(error.what, path=file, line=number) from None
    return found


def read_data(text: str, file: str) -> list[tuple[str, str, SourceLine, list[str]]]:
    """Return type, name, line and value of each variable of a data list."""
    lines = _lines_of(text, file)
    if not lines or lines[0].word != "DEFDAT" or lines[-1].word != "ENDDAT":
        raise ProgramError("a data list begins with DEFDAT and ends with ENDDAT", path=file)
    found: dict[str, tuple[str, str, SourceLine, list[str]]] = {}
    for line in lines[1:-1]:
        try:
            _declare(found, line)
        except ProgramError as error:
            raise error.at(file, line.number) from None
    return list(found.values())


def _declare(found: dict[str, tuple[str, str, SourceLine, list[str]]], line: SourceLine) -> None:
    tokens = [one for one in line.tokens if one.upper() not in {"GLOBAL", "CONST"}]
    words = [one.upper() for one in tokens]
    if words[0] == "DECL" and len(words) > 2:
        kind, name = words[1], words[2]
        if name in found:
            raise ProgramError(f"{name} is declared twice")
        if len(name) > MOST_NAME:
            raise ProgramError(f"{name} has more than {MOST_NAME} characters")
        found[name] = (kind, name, line, tokens[tokens.index("=") + 1 :] if "=" in tokens else [])
    elif words[1:4] == ["[", "]", "="] and words[0] in found:
        found[words[0]] = (found[words[0]][0], words[0], line, tokens[4:])
    elif words[0] not in {"EXT", "EXTFCT", "SIGNAL", "ENUM", "STRUC"}:
        raise ProgramError(f"{line.text[:40]!r} is no declaration")


def read_source(text: str, file: str) -> dict[str, Steps]:
    """Return the routines of a source file by name."""
    found: dict[str, Steps] = {}
    head, rows = (0, ""), list[Row]()
    for number, bare in _rows(text):
        word = re.split(r"\W", bare, maxsplit=1)[0].upper()
        if head[1] and word == "END":
            words = [one.upper() for one in tokens_of(head[1], GRAMMAR) if one.upper() != "GLOBAL"]
            inside = [one for one in words[3:-1] if one not in {",", ":", "IN", "OUT"}]
            body = tree(rows, file, begins=BLOCK, turns="ELSE CASE DEFAULT", ends=ENDS)
            found[words[1]] = Steps(file, inside, body, head[0])
            head, rows = (0, ""), []
        elif head[1]:
            rows.append((number, bare))
        elif re.match(r"(?:GLOBAL\s+)?DEF\s+\w", bare, re.IGNORECASE):
            head = number, bare
        elif not bare.startswith(";"):
            raise ProgramError(f"{bare[:40]!r} is outside a routine", path=file, line=number)
    if head[1]:
        raise ProgramError("ends within a block", path=file, line=head[0])
    return found
