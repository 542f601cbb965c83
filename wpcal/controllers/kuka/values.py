"""Values of KRL: structures, frames, and expressions with them."""

from __future__ import annotations

import operator
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.controllers.run.expressions import AND, COMPARE, OR, PRODUCT, SIGNS, SUM, Parser, Syntax
from wpcal.controllers.run.machine import Matrix, about, rigid, turns_of
from wpcal.controllers.run.program import ProgramError

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
