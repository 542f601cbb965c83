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
from wpcal.controllers.run.machine import Matrix, ProgramError, about, real, rigid, turns_of

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
        x, y, z, a, b, c = (real(self.values[key]) for key in "XYZABC")
        return rigid(about("ZYX", [a, b, c]), [x, y, z])


def frame_value(T: Matrix, kind: str = "FRAME", rest: dict[str, Any] | None = None) -> Aggregate:
    """Return a matrix as a structure in the digits of the controller."""
    values = dict(zip("XYZABC", (float(np.float32(v)) for v in (*T[:3, 3], *turns_of("ZYX", T))), strict=True))
    return Aggregate({**values, **(rest or {})}, kind)


def _multiply(a: Any, b: Any) -> Any:
    return frame_value(a.matrix() @ b.matrix())


def _divide(a: Any, b: Any) -> Any:
    """Return a quotient; that of two INT is an INT, cut off."""
    return int(a / b) if isinstance(a, int) and isinstance(b, int) else a / b


DIVIDES = {**PRODUCT, "/": _divide}
GRAMMAR = Syntax(
    TOKEN,
    ({**OR, "EXOR": operator.xor}, AND, {"==": operator.eq, **COMPARE}, SUM, DIVIDES, {":": _multiply}),
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


DECLARATION = re.compile(
    r"(?P<scope>(?:(?:DECL|GLOBAL|CONST)\s+)*)(?:(?P<kind>\w+)\s+)?"
    r"(?P<name>\$?\w+)(?P<element>\[[\d,]*\])?(?:\s*,\s*\w+)*\s*(?:=\s*(?P<value>.*)|$)",
    re.IGNORECASE,
)
OTHERS = {"EXT", "EXTFCT", "SIGNAL", "ENUM", "STRUC"}  #: What else a data list says.


class Declared(NamedTuple):
    """What a line of a data list declares, or gives a value."""

    line: int
    scope: str  #: The words before the type, in capitals.
    kind: str  #: In capitals; empty where the line does not say it.
    name: str
    element: str  #: With its brackets; empty without one.
    value: str  #: As text; empty without one.


def declaration_of(row: Row) -> Declared | None:
    """Return what a line declares if it is one of a data list."""
    match = DECLARATION.match(row[1])
    if match is None:
        return None
    scope, kind, name, element, value = (text or "" for text in match.groups())
    return Declared(row[0], scope.upper(), kind.upper(), name, element, value)


def rows_of_krl(text: str) -> list[Row]:
    """Return the lines without comments, folds and file attributes; of comments the marks of seams."""
    rows = rows_of(text, ";")
    return [row for row in rows if row[1][0] not in ";&" or (row[1][0] == ";" and mark_of(row[1][1:]) is not None)]


def read_data(text: str, file: str) -> list[Declared]:
    """Return the variables of a data list, with names in capitals."""
    rows = [row for row in rows_of_krl(text) if not row[1].startswith(";")]
    if not rows or _word(rows[0]) != "DEFDAT" or _word(rows[-1]) != "ENDDAT":
        raise ProgramError("a data list begins with DEFDAT and ends with ENDDAT", path=file)
    found: dict[str, Declared] = {}
    for row in rows[1:-1]:
        each = declaration_of(row)
        name = "" if each is None else each.name.upper()
        if each is not None and each.kind and "DECL" in each.scope:
            if name in found or len(name) > MOST_NAME:
                what = "is declared twice" if name in found else f"has more than {MOST_NAME} characters"
                raise ProgramError(f"{name} {what}", path=file, line=row[0])
            found[name] = each._replace(name=name)
        elif each is not None and each.element == "[]" and name in found:  # the text of a variable
            found[name] = found[name]._replace(line=row[0], value=each.value)
        elif _word(row) not in OTHERS:
            raise ProgramError(f"{row[1][:40]!r} is no declaration", path=file, line=row[0])
    return list(found.values())


def _word(row: Row) -> str:
    return re.split(r"\W", row[1], maxsplit=1)[0].upper()


def read_source(text: str, file: str) -> dict[str, Steps]:
    """Return the routines of a source file by name."""
    found: dict[str, Steps] = {}
    head, rows = (0, ""), list[Row]()
    for number, bare in rows_of_krl(text):
        if head[1] and _word((number, bare)) == "END":
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
