"""Comau PDL2 (``.pdl``): what a program does.

Positions are relative to ``$UFRAME``; ``a : b`` composes two. ``MOVE RELATIVE`` goes on from where the tool is, in the
tool or in ``$UFRAME``. The routines ``arc_start`` and ``arc_end`` of the user, or an output, switch the arc.

References: Comau, PDL2 Programming Language Manual, CR00758049 (MOVE, POS, VEC, $UFRAME, $TOOL, $BASE, FOR, WHILE,
REPEAT, IF).
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wpcal.controllers.comau.read import GRAMMAR
from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.blocks import BlockInterpreter, Node, Row, Steps, rows_of, tree
from wpcal.controllers.run.expressions import COMPARE, PRODUCT, SIGNS, SUM, Syntax
from wpcal.controllers.run.machine import ProgramError, about, rigid, turns_of
from wpcal.core.arrays import FloatArray

MM_PER_M = 1000.0
FIELDS = ("x", "y", "z", "a", "e", "r")


@dataclass(frozen=True)
class _Position:
    """A position: mm and deg, R = Rz(a) Ry(e) Rz(r)."""

    values: tuple[float, ...]

    def place(self) -> FloatArray:
        """Return it as a matrix."""
        return rigid(about("ZYZ", self.values[3:]), self.values[:3])

    @classmethod
    def of(cls, T: FloatArray) -> _Position:
        """Take a matrix."""
        return cls((*T[:3, 3], *turns_of("ZYZ", T)))


WORDS = Syntax(
    re.compile(r"'[^']*'|\d+(?:\.\d+)?(?:[eE][-+]?\d+)?|\.\d+|\$?[A-Za-z_]\w*|:=|<>|<=|>=|[-+*/=<>()\[\]{},.:]"),
    (
        {"OR": lambda a, b: a or b},
        {"AND": lambda a, b: a and b},
        {"=": operator.eq, **COMPARE},
        SUM,
        {**PRODUCT, "DIV": operator.floordiv, "MOD": operator.mod},
        {":": lambda a, b: _Position.of(a.place() @ b.place())},
    ),
    {**SIGNS, "NOT": operator.not_},
    {"TRUE": True, "FALSE": False, "ON": True, "OFF": False},
    index=("[", "]"),
    quote="'",
)
SETTINGS = re.compile(
    r"\$(?:LIN_SPD|SPD_OPT|TERM_TYPE|FLY_TYPE|FLY_DIST|FLY_PER|PROG_SPD_OVR|PROG_ACC_OVR|PROG_DEC_OVR|ROT_SPD|CNFG_CARE)"
)
"""Variables without an effect on where the robot goes."""
PROGRAM = re.compile(r"^[ \t]*+PROGRAM\s+(\w+)", re.IGNORECASE | re.MULTILINE)
ROUTINE = re.compile(r"ROUTINE(?!.*\bEXPORTED\b)\s+(?P<name>\w++)\s*+\(?(?P<given>[^()]*+)", re.IGNORECASE)
BLOCK = r"(?:IF|FOR|WHILE|REPEAT|SELECT)(?![^\s(])"
MOVE = re.compile(r"(?P<kind>JOINT|LINEAR|CIRCULAR) TO (?!.*\bWITH\b)(?P<to>.+?)(?: VIA (?P<via>.+))?", re.IGNORECASE)
RELATIVE = re.compile(r"RELATIVE (?P<by>.+?) IN (?P<frame>.+)", re.IGNORECASE)


class Interpreter(BlockInterpreter):
    """Runs a program."""

    grammar, words, COMMENT, BREAK, FOR = GRAMMAR, WORDS, "--", "EXIT", (":=", "TO", "STEP", "DO")
    ARCS: Mapping[str, Does] = {"ARC_START": Does.ON, "ARC_END": Does.OFF}

    def __init__(self, files: Mapping[str, str], *args: Any, **given: Any) -> None:
        super().__init__(files, *args, **given)
        self.tool = next(iter(self.tools), "")
        self.bases[""] = np.eye(4)

    def load(self, file: str, text: str) -> None:
        found, names, rows = PROGRAM.search(text), list[str](), None
        main = name = "" if found is None else found[1].upper()
        for number, row in rows_of(text, "--", "'"):
            word = re.split(r"[\s(]", row, maxsplit=1)[0].upper()
            if rows is not None and word == "END":
                body = tree(rows, file, begins=BLOCK, turns="ELSE", ends="ENDIF ENDFOR ENDWHILE UNTIL ENDSELECT")
                self.routines[self.declare(name, file, self.routines)] = Steps(file, names, body, number)
                name, names, rows = main, [], None
            elif rows is not None:
                rows.append((number, row))
            elif word == "BEGIN":
                rows = list[Row]()
            elif head := ROUTINE.match(row):
                name, names = head["name"].upper(), _parameters(head["given"])
        if rows is not None or main not in self.routines:
            raise ProgramError("a program has PROGRAM, BEGIN and END", path=file)

    # -- values ----------------------------------------------------------------------------------------------------

    def part(self, value: Any, name: str) -> Any:
        if not isinstance(value, _Position) or name not in FIELDS:
            raise ProgramError(f"not followed: .{name}")
        return value.values[FIELDS.index(name)]

    def _pos(self, *values: Any) -> _Position:
        """Make a position of six numbers, and its configuration."""
        numbers = [*values[:6], *[0.0] * (6 - len(values[:6]))]
        if len(values) > 6 and values[6]:
            raise ProgramError(f"the configuration {values[6]!r} is not followed")
        return _Position(tuple(float(v) for v in numbers))

    def _vec(self, *values: Any) -> FloatArray:
        if len(values) != 3:
            raise ProgramError("a vector has three numbers")
        return np.array(values, dtype=np.float64)

    FUNCTIONS: Mapping[str, Callable[..., Any]] = {"pos": _pos, "vec": _vec, "abs": lambda _, value: abs(value)}

    # -- running ---------------------------------------------------------------------------------------------------

    def statement(self, word: str, tokens: list[str], node: Node) -> None:
        if word in {"MOVE", "MOVEFLY"}:
            self._move(" ".join(tokens[1:]))
        elif ":=" in tokens:
            at = tokens.index(":=")
            if word == "$LIN_SPD" or not SETTINGS.fullmatch(word):
                self._assign(tokens[:at], self.value(tokens[at + 1 :]))
        elif word in self.routines or word in self.ARCS:
            self.routine(word, self.parser(tokens[2:]).values(")") if len(tokens) > 1 else ())
        else:
            self.unknown(node.text)

    def _assign(self, left: list[str], value: Any) -> None:
        name = left[0].upper()
        if name in {"$UFRAME", "$TOOL", "$BASE"} and len(left) == 1:
            self._set_frame(name, value)
        elif name == "$DOUT":
            self.output("DOUT", int(self.value(left[2:-1])), on=bool(value))
        elif len(left) == 1 and (name == "$LIN_SPD" or not name.startswith("$")):
            self.give(name, value)
        elif len(left) == 3 and left[1] == "." and left[2].lower() in FIELDS:
            self._set_part(name, left[2], value)
        else:
            raise ProgramError(f"not followed: {''.join(left)}")

    def _set_part(self, name: str, part: str, value: Any) -> None:
        kept, at = self.name(name), FIELDS.index(part.lower())
        if not isinstance(kept, _Position):
            raise ProgramError(f"not followed: {name}.{part}")
        self.values[name] = replace(kept, values=(*kept.values[:at], float(value), *kept.values[at + 1 :]))

    def _set_frame(self, name: str, value: Any) -> None:
        if not isinstance(value, _Position) or name == "$BASE":
            raise ProgramError(f"not followed: {name}")
        setattr(self, "tool" if name == "$TOOL" else "frame", name)
        (self.tools if name == "$TOOL" else self.bases)[name] = value.place()

    # -- moves -----------------------------------------------------------------------------------------------------

    def _move(self, text: str) -> None:
        text, speed = re.sub(" ADVANCE$", "", text, flags=re.IGNORECASE), self.values.get("$LIN_SPD")
        mm_s = None if speed is None else MM_PER_M * speed
        if found := RELATIVE.fullmatch(text):
            self._relative(self.value(found["by"]), found["frame"].upper(), mm_s)
            return
        found = MOVE.fullmatch(text)
        if found is None or (found["kind"].upper() == "CIRCULAR") != (found["via"] is not None):
            raise ProgramError(f"not followed: MOVE {text}")
        kind = found["kind"][0].upper()
        T_via = None if found["via"] is None else self._T(found["via"])
        self.go(kind, self._T(found["to"]), via=T_via, speed_mm_s=None if kind == "J" else mm_s)

    def _T(self, text: str) -> FloatArray:
        value = self.value(text)
        if not isinstance(value, _Position):
            raise ProgramError(f"{text} is not a position")
        return self.T_frame() @ value.place()

    def _relative(self, d: Any, frame: str, mm_s: float | None) -> None:
        if not isinstance(d, np.ndarray) or frame not in {"TOOL", "UFRAME"}:
            raise ProgramError("MOVE RELATIVE is followed with VEC in TOOL or UFRAME")
        T = self.machine.T_base_tool(self.T_tool()).copy()
        T[:3, 3] += (T if frame == "TOOL" else self.T_frame())[:3, :3] @ d
        self.go("L", T, speed_mm_s=mm_s)


def _parameters(text: str) -> list[str]:
    return [name.strip().upper() for one in text.split(";") for name in one.split(":")[0].split(",") if name.strip()]
