"""Values of KRL: structures, frames, and expressions with them."""

from __future__ import annotations

import operator
import re
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from wpcal.controllers.language.grammar import mark_of
from wpcal.controllers.run.blocks import Row, Steps, rows_of, tree
from wpcal.controllers.run.expressions import AND, COMPARE, OR, PRODUCT, SIGNS, SUM, Parser, Syntax, tokens_of
from wpcal.controllers.run.machine import Matrix, ProgramError, about, rigid, turns_of

CARTESIAN = {"FRAME", "POS", "E6POS", "E3POS"}
AXES = {"AXIS", "E6AXIS"}
TOKEN = re.compile(
    r'"[^"]*"|(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?|[$#A-Za-z_][\w$]*|\'[BHbh][0-9A-Fa-f]+\''
    r"|==|<>|<=|>=|[-+*/:=<>()\[\]{},.#]"
)


@dataclass
class Aggregate:
    """A structure: names and values in order."""

    values: dict[str, Any]
    kind: str = ""  #: Empty where a literal does not name it.

    def matrix(self) -> Matrix:
        """Return a frame: A about z, then B about the new y, then C about the new x."""
        missing = {"X", "Y", "Z", "A", "B", "C"} - set(self.values)
        if missing:
            raise ProgramError(f"a frame without {sorted(missing)}")
        x, y, z, a, b, c = (float(self.values[key]) for key in "XYZABC")
        return rigid(about("ZYX", [a, b, c]), [x, y, z])


def frame_value(T: Matrix, kind: str = "FRAME", rest: dict[str, Any] | None = None) -> Aggregate:
    """Return a matrix as a structure in the digits of the controller."""
    values = dict(zip("XYZABC", (float(np.float32(v)) for v in (*T[:3, 3], *turns_of("ZYX", T))), strict=True))
    return Aggregate({**values, **(rest or {})}, kind)


def _multiply(a: Any, b: Any) -> Any:
    return frame_value(a.matrix() @ b.matrix())


GRAMMAR = Syntax(
    TOKEN,
    ({**OR, "EXOR": operator.xor}, AND, {"==": operator.eq, **COMPARE}, SUM, PRODUCT, {":": _multiply}),
    {**SIGNS, "NOT": operator.not_},
    {"TRUE": True, "FALSE": False},
    aggregate=("{", "}"),
    index=("[", "]"),
)


class KrlParser(Parser):
    """Knows structures, which name their parts, and constants with #."""

    def primary(self) -> Any:
        """Return a structure, a constant, or what every language has."""
        if self.peek() == "{":
            self.take()
            kind, values = "", dict[str, Any]()
            if self.tokens[self.at + 1 : self.at + 2] == [":"]:
                kind = self.take().upper()
                self.take(":")
            while self.peek() != "}":
                if values:
                    self.take(",")
                name = self.take().upper()
                if self.peek() == "[":  # a text
                    self.take()
                    self.take("]")
                values[name] = self.value()
            self.take("}")
            return Aggregate(values, kind)
        if self.peek().startswith("#"):
            return self.take().upper()
        return super().primary()


def krl_text(value: Any) -> str:
    """Write a value as a data list has it."""
    if isinstance(value, Aggregate):
        return "{" + ",".join(f"{name} {krl_text(v)}" for name, v in value.values.items()) + "}"
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    if isinstance(value, str):
        return value if value.startswith("#") else f'"{value}"'
    if isinstance(value, int):
        return str(value)
    return f"{float(np.float32(value)) + 0.0:.9g}"


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
