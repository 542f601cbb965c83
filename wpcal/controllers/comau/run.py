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

from wpcal.controllers.comau.grammar import GRAMMAR
from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.blocks import BlockInterpreter, Node, Row, Steps, tree
from wpcal.controllers.run.expressions import COMPARE, PRODUCT, SIGNS, SUM, Syntax, without_comment
from wpcal.controllers.run.machine import about, rigid, turns_of
from wpcal.controllers.run.program import ProgramError
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
HEAD = re.compile(r"(?:PROGRAM|ROUTINE)\s+(?P<name>\w+)(?:\s*\((?P<given>[^()]*)\))?", re.IGNORECASE)
HEADS = {"IF", "FOR", "WHILE", "REPEAT", "SELECT"}


class Interpreter(BlockInterpreter):
    """Runs a program."""

    grammar, words, COMMENT, BREAK, FOR = GRAMMAR, WORDS, "--", "EXIT", (":=", "TO", "STEP", "DO")
    BLOCKS: Mapping[str, Callable[..., None]] = {
        "IF": BlockInterpreter.choose,
        "FOR": BlockInterpreter.count,
        "WHILE": BlockInterpreter.loop_while,
        "REPEAT": BlockInterpreter.until,
    }

    def __init__(self, files: Mapping[str, str], *args: Any, **given: Any) -> None:
        super().__init__(files, *args, **given)
        self.tool = next(iter(self.tools), "")
        self.bases[""] = np.eye(4)

    def load(self, file: str, text: str) -> None:
        """Read a program with its routines."""
        main, name, names = "", "", list[str]()
        rows: list[Row] | None = None
        for number, row in enumerate(text.splitlines(), 1):
            bare, remark = (part.strip() for part in without_comment(row, "--", "'"))
            word = re.split(r"[\s(]", bare, maxsplit=1)[0].upper()
            if rows is None:
                head = HEAD.match(bare)
                main = head["name"].upper() if head and word == "PROGRAM" else main
                if head and word == "ROUTINE" and "EXPORTED" not in bare.upper():
                    name, names = head["name"].upper(), _parameters(head["given"] or "")
                rows = [] if word == "BEGIN" else None
            elif word == "END":
                body = tree(rows, file, begins=_begins, turns="ELSE", ends="ENDIF ENDFOR ENDWHILE UNTIL ENDSELECT")
                self.routines[self.declare(name or main, file, self.routines)] = Steps(file, names, body, number)
                name, names, rows = "", [], None
            elif bare or remark:
                rows.append((number, bare or f"--{remark}"))
        if rows is not None or main not in self.routines:
            raise ProgramError("a program has PROGRAM, BEGIN and END", path=file)

    # -- values ----------------------------------------------------------------------------------------------------

    def part(self, value: Any, name: str) -> Any:
        """Return a number of a position."""
        if not isinstance(value, _Position) or name not in FIELDS:
            raise ProgramError(f"not followed: .{name}")
        return value.values[FIELDS.index(name)]

    def fn_pos(self, *values: Any) -> _Position:
        """Make a position of six numbers, and its configuration."""
        numbers = [*values[:6], *[0.0] * (6 - len(values[:6]))]
        if len(values) > 6 and values[6]:
            raise ProgramError(f"the configuration {values[6]!r} is not followed")
        return _Position(tuple(float(v) for v in numbers))

    def fn_vec(self, *values: Any) -> FloatArray:
        """Make a vector."""
        if len(values) != 3:
            raise ProgramError("a vector has three numbers")
        return np.array(values, dtype=np.float64)

    fn_abs = staticmethod(abs)

    # -- running ---------------------------------------------------------------------------------------------------

    def statement(self, word: str, tokens: list[str], node: Node) -> None:
        """Run one line."""
        if word in {"MOVE", "MOVEFLY"}:
            self._move(tokens[1:])
        elif ":=" in tokens:
            if word == "$LIN_SPD" or not SETTINGS.fullmatch(word):
                at = tokens.index(":=")
                self._assign(tokens[:at], self.value(tokens[at + 1 :]))
        else:
            self._call(word, tokens, node.text)

    def _call(self, word: str, tokens: list[str], text: str) -> None:
        if word in {"ARC_START", "ARC_END"} and word not in self.routines:
            self.machine.switch(Does.ON if word == "ARC_START" else Does.OFF)
        elif word in self.routines:
            self.routine(word, self.parser(tokens[2:]).values(")") if len(tokens) > 1 else ())
        else:
            self.unknown(text)

    def _assign(self, left: list[str], value: Any) -> None:
        name = left[0].upper()
        if name in {"$UFRAME", "$TOOL", "$BASE"} and len(left) == 1:
            self._set_frame(name, left, value)
        elif name == "$DOUT":
            number = int(self.value(left[2:-1]))
            self.output("DOUT", number, on=bool(value))
        elif name == "$LIN_SPD":
            self.values[name] = value
        elif len(left) == 3 and left[1] == "." and left[2].lower() in FIELDS:
            kept, at = self.name(name), FIELDS.index(left[2].lower())
            if not isinstance(kept, _Position):
                raise ProgramError(f"not followed: {''.join(left)}")
            self.values[name] = replace(kept, values=(*kept.values[:at], float(value), *kept.values[at + 1 :]))
        elif len(left) == 1 and not name.startswith("$"):
            self.give(name, value)
        else:
            raise ProgramError(f"not followed: {''.join(left)}")

    def _set_frame(self, name: str, left: list[str], value: Any) -> None:
        if not isinstance(value, _Position) or name == "$BASE":
            raise ProgramError(f"not followed: {''.join(left)}")
        setattr(self, "tool" if name == "$TOOL" else "frame", name)
        (self.tools if name == "$TOOL" else self.bases)[name] = value.place()

    # -- moves -----------------------------------------------------------------------------------------------------

    def _move(self, tokens: list[str]) -> None:
        words = [token.upper() for token in tokens]
        if words[-1] == "ADVANCE":
            tokens, words = tokens[:-1], words[:-1]
        kind = {"JOINT": "J", "LINEAR": "L", "CIRCULAR": "C"}.get(words[0], "")
        speed = self.values.get("$LIN_SPD")
        mm_s = None if speed is None or kind == "J" else MM_PER_M * speed
        if words[0] == "RELATIVE" and "IN" in words:
            at = words.index("IN")
            self._relative(self.value(tokens[1:at]), words[at + 1 :], mm_s)
            return
        via = words.index("VIA") if "VIA" in words else len(words)
        is_known = kind and words[1:2] == ["TO"] and "WITH" not in words
        if not is_known or (kind == "C") != (via < len(words)):
            raise ProgramError(f"not followed: MOVE {' '.join(tokens)}")
        T_via = None if kind != "C" else self._T(tokens[via + 1 :])
        self.go(kind, self._T(tokens[2:via]), via=T_via, speed_mm_s=mm_s)

    def _T(self, tokens: list[str]) -> FloatArray:
        value = self.value(tokens)
        if not isinstance(value, _Position):
            raise ProgramError(f"{' '.join(tokens)} is not a position")
        return self.T_frame() @ value.place()

    def _relative(self, d: Any, frame: list[str], mm_s: float | None) -> None:
        if not isinstance(d, np.ndarray) or frame not in (["TOOL"], ["UFRAME"]):
            raise ProgramError("MOVE RELATIVE is followed with VEC in TOOL or UFRAME")
        T = self.machine.T_base_tool(self.T_tool()).copy()
        T[:3, 3] += (T if frame == ["TOOL"] else self.T_frame())[:3, :3] @ d
        self.go("L", T, speed_mm_s=mm_s)


def _begins(text: str) -> bool:
    return re.split(r"[\s(]", text, maxsplit=1)[0].upper() in HEADS


def _parameters(text: str) -> list[str]:
    return [name.strip().upper() for one in text.split(";") for name in one.split(":")[0].split(",") if name.strip()]
