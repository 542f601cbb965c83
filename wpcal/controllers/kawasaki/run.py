"""Kawasaki AS (``.as``): what its programs do.

``XMOVE p TILL s`` moves on a line and stops when signal s turns on (a negative number: off); the next step then runs,
as it does at the end of the motion. Without a mode a signal that is on at the start does not count; ``/LVL`` takes it
at once. ``HERE`` is the present pose in BASE and TOOL; ``HSENSESET`` and ``HSENSE`` latch the pose at the signal.
With ``CP ON``, a motion without ``BREAK`` behind it ends within ``ACCURACY`` and goes over into the next; ``LWS`` and
``LWE`` stop. ``a + b`` composes transformations, ``SHIFT(p BY x, y, z)`` displaces one in BASE, and ``DRAW`` goes on
from where the tool is.

References: Kawasaki, AS Language Reference Manual (D and E controllers).
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partialmethod
from typing import Any

import numpy as np

from wpcal.controllers.kawasaki.arc import CM_PER_MIN
from wpcal.controllers.kawasaki.read import GRAMMAR
from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.blocks import BlockInterpreter, JumpError, Node, Steps, rows_of, tree
from wpcal.controllers.run.expressions import COMPARE, PRODUCT, SIGNS, SUM, Syntax, outside, tokens_of
from wpcal.controllers.run.machine import ProgramError, StoppedError, about, moved, rigid, turns_of
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.numbers import parse_number
from wpcal.core.same_bits import inverse_pose

MOST_NAME = 15  #: Characters of a name.
TOKEN = re.compile(
    r'"[^"]*"|\d+(?:\.\d+)?(?:[eE][-+]?\d+)?|\.\d+|\$?#?[A-Za-z][\w.]*|==|<>|<=|>=|=<|[-+*/=<>()\[\],:^]'
)
SEARCH = re.compile(r"(?:/ (?P<mode>LVL|ERR) )?(?P<goal>[^/].*?) TILL (?P<signal>.+)", re.IGNORECASE)
FLAT = 1e-12  #: Of 1 minus the cosine of A, where only the sum or difference of O and T counts.


@dataclass(frozen=True)
class Transformation:
    """A transformation: X Y Z, and O about z, A about the new y, T about the new z."""

    T: Any
    external: tuple[float, ...] = ()  #: Axes from the seventh on, deg.

    @classmethod
    def of(cls, values: Sequence[float]) -> Transformation:
        """Take six numbers, mm and deg."""
        if len(values) < 6:
            raise ProgramError("a transformation has six numbers")
        return cls(rigid(about("ZYZ", values[3:6]), values[:3]), tuple(float(v) for v in values[6:]))

    def values(self) -> list[float]:
        """Return six numbers as the controller stores them."""
        R = self.T[:3, :3]
        if abs(R[2, 2]) > 1.0 - FLAT:
            o = np.degrees(np.arctan2(R[1, 0] * np.sign(R[2, 2]), R[1, 1]))
            angles = [float(o), 0.0 if R[2, 2] > 0 else 180.0, 0.0]
        else:
            angles = turns_of("ZYZ", self.T)
        return [*(float(v) for v in self.T[:3, 3]), *angles]

    def moved(self, d: Any, *, in_tool: bool = False) -> Transformation:
        """Return it displaced along the axes of BASE, or its own."""
        return Transformation(moved(self.T, d, in_tool))

    def __add__(self, other: Transformation) -> Transformation:
        """Compose."""
        return Transformation(self.T @ other.T)

    def __neg__(self) -> Transformation:
        """Invert."""
        return Transformation(inverse_pose(self.T))

    def __sub__(self, other: Transformation) -> Transformation:
        """Compose with the inverted."""
        return Transformation(self.T @ inverse_pose(other.T))


def _about(axis: str, angle: Any) -> Transformation:
    return Transformation(rigid(about(axis, [angle]), np.zeros(3)))


WORDS = Syntax(
    TOKEN,
    (
        {"OR": lambda a, b: -1 if a or b else 0},
        {"AND": lambda a, b: -1 if a and b else 0},
        {"==": operator.eq, **COMPARE, "=<": operator.le},
        SUM,
        {**PRODUCT, "MOD": operator.mod},
    ),
    {**SIGNS, "NOT": lambda a: 0 if a else -1},
    {"TRUE": -1, "FALSE": 0, "ON": -1, "OFF": 0},
    index=("[", "]"),
)


BLOCK = r"IF\s(?:.*\s)?THEN$|(?:FOR|WHILE|DO|CASE)(?!\S)"


class Interpreter(BlockInterpreter):
    """Runs AS programs; variables have no value before the files give them one."""

    grammar, words, COMMENT, BREAK, RETURNS = GRAMMAR, WORDS, ";", "EXIT", False
    SIGNAL = r"(?i)\bTILL (?P<off>-)?(?P<name>\d{1,5}+)\b"

    def __init__(self, files: Mapping[str, str], *args: Any, **given: Any) -> None:
        self.T_base: FloatArray = np.eye(4)
        self.via: Transformation | None = None
        self.speed: float | None = None
        self.weld_speeds: dict[str, float] = {}  #: By the number of a weld condition.
        self.is_cp = True  #: Unless the program says otherwise, the tool does not stop at the end of a motion.
        self.accuracy = (math.inf, math.inf)  #: How far from there it may begin the next, mm: this one, and all after.
        self.latched: list[Transformation] = []
        self.latch: int | None = None
        super().__init__(files, *args, **given)
        given = {name.upper(): Transformation(T) for name, T in {**self.tools, **self.bases}.items()}
        self.values = given | self.values  # a file that is loaded sets what it declares

    # -- loading ---------------------------------------------------------------------------------------------------

    def load(self, file: str, text: str) -> None:
        head, rows = (0, ""), list[tuple[int, str]]()
        for number, row in enumerate(text.splitlines(), 1):
            bare = row.strip()
            if bare.upper() == ".END" and head[1]:
                self._section(file, *head, rows)
                head = (0, "")
            elif head[1]:
                rows.append((number, bare))
            elif bare and not bare.startswith((".*", ";")):
                head, rows = (number, bare), []
        if head[1]:
            raise ProgramError(f"no .END behind {head[1][:40]!r}", path=file, line=head[0])

    def _section(self, file: str, line: int, head: str, rows: list[tuple[int, str]]) -> None:
        word = re.split(r"[\s(]", head, maxsplit=1)[0].upper()
        if word == ".PROGRAM":
            found = re.fullmatch(r"\.PROGRAM\s+([\w.]+)\s*\(([^)]*)\)(?:\s*#\d+)?(?:\s*;.*)?", head, re.IGNORECASE)
            if found is None or len(found[1]) > MOST_NAME:
                raise ProgramError(f"{head[:60]!r} does not begin a program", path=file, line=line)
            names = [one.strip(" .").upper() for one in found[2].split(",") if one.strip()]
            lines = [(number, text) for number, row in rows for _, text in rows_of(row, ";")]
            body = tree(lines, file, begins=BLOCK, turns="ELSE", ends="END UNTIL")
            self.routines[self.declare(found[1].upper(), file, self.routines)] = Steps(file, names, body, line)
        elif word in {".TRANS", ".JOINTS", ".REALS", ".STRINGS"}:
            for number, row in rows:
                self.step(file, number, lambda row=row: self._data(word, row))  # type: ignore[misc]
        else:
            raise ProgramError(f"{head[:60]!r} is unknown", path=file, line=line)

    def _data(self, word: str, row: str) -> None:
        if not row or row.startswith(";"):
            return
        if word in {".REALS", ".STRINGS"}:
            name, _, value = row.partition("=")
            self.give(name.strip(), self.value(value.strip()))
            return
        name, *cells = re.split(r"[\s,]+", row)
        try:
            values = [parse_number(cell) for cell in cells]
        except InputError as error:
            raise ProgramError(f"{name}: {error}") from None
        self.give(name, Transformation.of(values) if word == ".TRANS" else tuple(values))

    # -- values ----------------------------------------------------------------------------------------------------

    def name(self, name: str) -> Any:
        if name == "HERE":
            return Transformation(self._seen(self.machine.reading(np.eye(4))))
        own = {"NULL": np.eye(4), "BASE": self.T_base}
        if name in own:
            return Transformation(own[name])
        return Transformation(self.T_tool()) if name == "TOOL" else super().name(name)

    def _sig(self, *numbers: Any) -> int:
        return -1 if all(self._signal(int(number)) for number in numbers) else 0

    FUNCTIONS: Mapping[str, Callable[..., Any]] = {
        "abs": lambda _, value: abs(value),
        "sig": _sig,
        "trans": lambda _, *values: Transformation.of([*values, *[0.0] * (6 - len(values))]),
        "shift": lambda _, pose, *d: pose.moved(np.array([*d, *[0.0] * (3 - len(d))])),
        "distance": lambda _, one, other: float(np.linalg.norm(one.T[:3, 3] - other.T[:3, 3])),
        "rx": lambda _, angle: _about("X", angle),
        "ry": lambda _, angle: _about("Y", angle),
        "rz": lambda _, angle: _about("Z", angle),
        "dx": lambda _, pose: float(pose.T[0, 3]),
        "dy": lambda _, pose: float(pose.T[1, 3]),
        "dz": lambda _, pose: float(pose.T[2, 3]),
    }

    def _signal(self, number: int) -> bool:
        return self.is_on(str(abs(number))) == (number > 0)

    def _seen(self, T_base_flange: FloatArray) -> FloatArray:
        return inverse_pose(self.T_base) @ T_base_flange @ self.T_tool()

    def give(self, name: str, value: Any) -> None:
        """Give a variable a value; `$` is the sign of texts."""
        if len(name.lstrip("$#")) > MOST_NAME:
            raise ProgramError(f"{name} has more than {MOST_NAME} characters")
        if name.startswith("$") != isinstance(value, str):
            raise ProgramError(f"{name} = {value!r}")
        target = self.locals[-1] if name.upper() in self.locals[-1] or name.startswith(".") else self.values
        target[name.upper()] = value

    # -- running ---------------------------------------------------------------------------------------------------

    def whole(self, body: Sequence[Node]) -> None:
        """Run a program; labels are outside of blocks."""
        labels = {found[1]: at for at, node in enumerate(body) if (found := re.match(r"(\d+)\s", node.text))}
        at, file = 0, self.file
        while at < len(body):
            try:
                self.block(body[at : at + 1])
                at += 1
            except JumpError as jump:
                line = body[at].line
                self.run.step(self.calls, file, line)
                if jump.label not in labels:
                    self.step(file, line, lambda label=jump.label: self._no_label(label))  # type: ignore[misc]
                at = labels.get(jump.label, at + 1)

    def _no_label(self, label: str) -> None:
        raise ProgramError(f"GOTO {label}: no such label outside blocks")

    def execute(self, node: Node) -> None:
        """Run one step; ``BY`` of SHIFT is a comma."""
        text = node.text if node.text.startswith(";") else re.sub(r"^\d+\s+", "", node.text)
        super().execute(replace(node, text=re.sub(r"\bBY\b", ",", text) if "SHIFT" in text.upper() else text))

    def statement(self, word: str, tokens: list[str], node: Node) -> None:
        text = node.text
        if word == "POINT" or tokens[1:2] == ["="]:
            name, right = (tokens[1], tokens[3:]) if word == "POINT" else (tokens[0], tokens[2:])
            value = self.value(right)
            if (word == "POINT") != isinstance(value, Transformation):
                raise ProgramError(f"POINT is for transformations: {text}")
            self.give(name, value)
        else:
            function = getattr(self, f"_do_{word.lower()}", None)
            if function is None:
                self.unknown(text)
            else:
                function(tokens[1:])

    def _do_if(self, tokens: list[str]) -> None:
        words = [token.upper() for token in tokens]
        if "GOTO" not in words:
            raise ProgramError(f"IF without THEN: {' '.join(tokens)}")
        at = words.index("GOTO")
        if self.value(tokens[:at]):
            raise JumpError(tokens[at + 1])

    # -- moves -----------------------------------------------------------------------------------------------------

    def _goal(self, tokens: list[str]) -> Any:
        """Return a pose, or joints; what is behind a comma is the condition of a weld."""
        tokens = tokens[: outside(tokens, {","})]
        value = self.value(tokens)
        if not isinstance(value, (Transformation, tuple)):
            raise ProgramError(f"{' '.join(tokens)} is no pose")
        return value

    def _travel(self, kind: str, goal: Any, condition: str | None = None) -> None:
        self.bring(goal[6:] if isinstance(goal, tuple) else goal.external)
        zone_mm, self.accuracy = self.accuracy[0] if self.is_cp else None, (self.accuracy[1],) * 2
        if isinstance(goal, tuple):
            if kind != "J":
                raise ProgramError("a line to joint angles")
            self.blend(zone_mm)
            self.machine.joint_move(np.array(goal[:6]))
            return
        via, self.via = self.via, None
        if (via is None) != (kind != "C"):
            raise ProgramError("C1 without C2 of an arc, or C2 without C1")
        T_via = None if via is None else self.T_base @ via.T
        speed_mm_s = self.speed if condition is None else self.weld_speeds.get(condition)
        self.go(kind, self.T_base @ goal.T, via=T_via, speed_mm_s=speed_mm_s, zone_mm=zone_mm)

    def _move(self, kind: str, tokens: list[str]) -> None:
        self._travel(kind, self._goal(tokens))

    _do_lmove, _do_jmove, _do_c2move = partialmethod(_move, "L"), partialmethod(_move, "J"), partialmethod(_move, "C")

    def _weld(self, kind: str, tokens: list[str]) -> None:
        condition = "".join(tokens[outside(tokens, {","}) + 1 :][:1])
        self._travel(kind, self._goal(tokens), condition)

    _do_lwc, _do_c2wc = partialmethod(_weld, "L"), partialmethod(_weld, "C")

    def _do_w1set(self, tokens: list[str]) -> None:
        if (found := re.match(r"(\d+) = (\d+\.?\d*)", " ".join(tokens))) is not None:
            self.weld_speeds[found[1]] = float(found[2]) / CM_PER_MIN

    def _do_c1move(self, tokens: list[str]) -> None:
        self.via = self._goal(tokens)

    _do_c1wc = _do_c1move

    def _do_lws(self, tokens: list[str]) -> None:
        self._travel("L", self._goal(tokens))
        self.machine.stand()
        self.machine.switch(Does.ON)

    def _do_lwe(self, tokens: list[str]) -> None:
        self._weld("L", tokens)
        self.machine.stand()
        self.machine.switch(Does.OFF)

    def _here(self) -> Transformation:
        return Transformation(inverse_pose(self.T_base) @ self.machine.T_base_tool(self.T_tool()))

    def _draw(self, tokens: list[str], *, in_tool: bool) -> None:
        values = self.listed(tokens)
        if len(values) != 3:
            raise ProgramError("DRAW with a turn, a speed or left out numbers")
        self._travel("L", self._here().moved(np.array(values, dtype=np.float64), in_tool=in_tool))

    _do_draw, _do_tdraw = partialmethod(_draw, in_tool=False), partialmethod(_draw, in_tool=True)

    def _depart(self, kind: str, tokens: list[str]) -> None:
        self._travel(kind, self._here().moved([0.0, 0.0, -self.value(tokens)], in_tool=True))

    _do_depart, _do_ldepart = partialmethod(_depart, "J"), partialmethod(_depart, "L")

    def _approach(self, kind: str, tokens: list[str]) -> None:
        pose, back = self.listed(tokens)
        self._travel(kind, pose.moved([0.0, 0.0, -back], in_tool=True))

    _do_appro, _do_lappro = partialmethod(_approach, "J"), partialmethod(_approach, "L")

    def _do_home(self, tokens: list[str]) -> None:
        self.machine.joint_move(None)
        raise ProgramError("HOME: nobody knows where that is")

    def _do_xmove(self, tokens: list[str]) -> None:
        text = " ".join(tokens)
        found = SEARCH.fullmatch(text)
        if found is None:
            raise ProgramError(f"XMOVE {text}")
        goal, signal = self._goal(tokens_of(found["goal"], WORDS)), int(self.value(found["signal"]))
        if self.signals.get(str(abs(signal))) != (signal > 0):
            raise ProgramError(f"XMOVE: the signal {signal} is not that of the touch")
        if not self.speed or not isinstance(goal, Transformation):
            raise ProgramError("XMOVE to joint angles, or without a speed in mm/s")
        if not (self._signal(signal) and self._refuses((found["mode"] or "").upper())):
            hit = self.machine.search(self.T_base @ goal.T, self.T_tool(), self.speed)
            if hit is not None and self.latch is not None:
                self.latched.append(Transformation(self._seen(hit @ inverse_pose(self.T_tool()))))

    def _refuses(self, mode: str) -> bool:
        """Tell whether a search in this mode does not begin while the signal is on."""
        if mode == "ERR":
            raise ProgramError("XMOVE /ERR stops with an error: the signal is already on")
        return mode == "LVL"

    def _do_hsenseset(self, tokens: list[str]) -> None:
        found = re.fullmatch(r"(\d+)=(-?\d+)(?:,.*)?", "".join(tokens))
        if found is None or str(abs(int(found[2]))) not in self.signals:
            raise ProgramError(f"HSENSESET {' '.join(tokens)}: the signal is not connected")
        self.latch, self.latched = int(found[1]), []

    def _do_hsense(self, tokens: list[str]) -> None:
        """``HSENSE n result, signal, pose …``: the oldest latched pose, result -1; without one, result 0."""
        names = "".join(tokens[1:]).split(",")
        if str(self.latch) != tokens[0] or len(names) < 3:
            raise ProgramError(f"HSENSE {tokens[0]} without HSENSESET")
        self.give(names[0], -1 if self.latched else 0)
        if self.latched:
            self.give(names[1], -1)
            self.give(names[2], self.latched.pop(0))

    # -- settings --------------------------------------------------------------------------------------------------

    def _do_tool(self, tokens: list[str]) -> None:
        self.tool = " ".join(tokens)
        is_undeclared = len(tokens) == 1 and tokens[0].upper() not in {*self.values, "NULL"} and "" in self.tools
        self.tools[self.tool] = self.tools[""] if is_undeclared else self.value(tokens).T

    def _do_base(self, tokens: list[str]) -> None:
        self.frame = " ".join(tokens)
        self.T_base = self.value(tokens).T

    def _do_speed(self, tokens: list[str]) -> None:
        text = " ".join(tokens).upper().replace(" / ", "/").replace("MM/ S", "MM/S")
        found = re.fullmatch(r"(\d+(?:\.\d+)?)(?: (MM/S))?( ALWAYS)?", text)
        if found is None:
            raise ProgramError(f"SPEED {text}")
        self.speed = float(found[1]) if found[2] else None

    def _do_break(self, tokens: list[str]) -> None:
        self.machine.stand()

    def _do_accuracy(self, tokens: list[str]) -> None:
        words = [token.upper() for token in tokens]
        mm = self.value([token for token in tokens if token.upper() not in {"ALWAYS", "FINE"}])
        if not isinstance(mm, int | float):
            raise ProgramError(f"ACCURACY {' '.join(tokens)}")
        self.accuracy = (mm, mm if "ALWAYS" in words else self.accuracy[1])

    def _do_cp(self, tokens: list[str]) -> None:
        if tokens[0].upper() not in {"ON", "OFF"}:
            raise ProgramError(f"CP {' '.join(tokens)}")
        self.is_cp = tokens[0].upper() == "ON"

    def _do_signal(self, tokens: list[str]) -> None:
        for number in self.listed(tokens):
            self.output("OX", abs(int(number)), on=number > 0)

    def _do_swait(self, tokens: list[str]) -> None:
        number = int(self.value(tokens))
        if str(abs(number)) in self.signals and not self._signal(number):
            self.stop(f"SWAIT {' '.join(tokens)}")

    def _do_print(self, tokens: list[str]) -> None:
        tokens = tokens[2:] if tokens[1:2] == [":"] else tokens
        self.run.messages.append("".join(str(v) for v in self.listed(tokens)))

    _do_type = _do_print

    def _do_here(self, tokens: list[str]) -> None:
        self.give(tokens[0], self.name("HERE"))

    def _do_pause(self, tokens: list[str]) -> None:
        self.stop()

    def _do_halt(self, tokens: list[str]) -> None:
        raise StoppedError("HALT")

    _do_stop = _do_halt

    def _do_goto(self, tokens: list[str]) -> None:
        raise JumpError(tokens[0])

    def _do_call(self, tokens: list[str]) -> None:
        arguments = self.parser(tokens[2:]).values(")") if len(tokens) > 1 else []
        self.routine(tokens[0], arguments)
