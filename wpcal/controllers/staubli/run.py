"""Staubli VAL3 (``.dtx``, ``.pgx``): what an application does.

Data is in the database, with the frame of each point as its father; programs are VAL3 in XML. ``appro`` displaces a
point along its own axes, ``compose`` along those of a frame. The tool is declared on the controller. The output
``doArc`` switches the arc, or the programs ``arcStart`` and ``arcEnd`` of the user.

References: Staubli, VAL3 Reference Manual (pointRx, jointRx, frame, mdesc, movej, movel, movec, appro, compose).
"""

from __future__ import annotations

import math
import operator
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.blocks import BlockInterpreter, Node, Steps, rows_of, tree
from wpcal.controllers.run.expressions import LIKE_C, SIGNS, Syntax
from wpcal.controllers.run.machine import MOST_ELEMENTS, ProgramError, about, rigid, turns_of
from wpcal.controllers.staubli.grammar import GRAMMAR, elements
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.numbers import parse_number

AXES = ("x", "y", "z", "rx", "ry", "rz")
JOINTS = ("j1", "j2", "j3", "j4", "j5", "j6")
SPEEDS, ZONES = ("accel", "vel", "decel", "tmax", "rmax"), ("leave", "reach")
WORDS = Syntax(
    re.compile(r'"[^"]*"|\d+(?:\.\d+)?|\.\d+|[A-Za-z_]\w*|==|!=|<=|>=|&|[-+*/%=<>()\[\]{},.!]'),
    LIKE_C,
    {**SIGNS, "!": operator.not_},
    {"true": True, "false": False},
    aggregate=("{", "}"),
    index=("[", "]"),
    is_upper=False,
)
BLOCK = r"(?:if|while|for|do|switch)\b"


@dataclass(frozen=True)
class _Element:
    """One value of the database: numbers by their names, and for points and frames the father."""

    kind: str
    values: Mapping[str, float]
    father: str = ""
    blends: bool = False  #: Whether a motion does not stop.

    def place(self) -> FloatArray:
        """Return a point, a frame or a transformation as a matrix: R = Rx Ry Rz of the moving axes."""
        if not set(AXES) <= set(self.values):
            raise ProgramError(f"a {self.kind} where a point is needed")
        x, y, z, *angles = (self.values[key] for key in AXES)
        return rigid(about("XYZ", angles), [x, y, z])


def _element_of(T: FloatArray, like: _Element) -> _Element:
    return replace(like, values=dict(zip(AXES, [*T[:3, 3], *turns_of("XYZ", T)], strict=True)))


def _element(value: ET.Element, name: str, kind: str) -> tuple[int, Any]:
    """Return the number of a value of the database, and the value."""
    cells = {key: value.get(key) for key in (*AXES, *JOINTS, *SPEEDS, *ZONES, "value")}
    try:
        numbers = {key: float(parse_number(cell)) for key, cell in cells.items() if cell is not None}
        at = int(parse_number(value.get("key") or "0"))
    except InputError as error:
        raise ProgramError(f"{name}: {error}") from None
    is_number = kind == "num" and "value" in numbers
    return at, numbers["value"] if is_number else _Element(
        kind, numbers, value.get("fatherId") or "", value.get("blend", "off") != "off"
    )


class Interpreter(BlockInterpreter):
    """Runs the programs of an application."""

    grammar, words, COMMENT = GRAMMAR, WORDS, "//"
    ARCS: Mapping[str, Does] = {"arcStart": Does.ON, "arcEnd": Does.OFF}

    def load(self, file: str, text: str) -> None:
        tag = {"dtx": "Data", "pgx": "Program"}.get(file.lower().rpartition(".")[2])
        for element in () if tag is None else elements(text, file, tag):
            if tag == "Data":
                self.step(file, 0, partial(self._data, element))
            else:
                self._program(file, text, element)

    def _data(self, element: ET.Element) -> None:
        name, kind = element.get("name") or "", (element.get("type") or "").lower()
        size = int(parse_number(element.get("size") or "1"))
        if size > MOST_ELEMENTS:
            raise ProgramError(f"{name} has {size} elements")
        self.values[name] = dict(_element(value, name, kind) for value in element)

    def _program(self, file: str, text: str, element: ET.Element) -> None:
        name = element.get("name") or ""
        code = next((e.text or "" for e in element.iter() if e.tag.rpartition("}")[2] == "Code"), "")
        names = [e.get("name") or "" for e in element.iter() if e.tag.rpartition("}")[2] == "Parameter"]
        at = text.find(f'name="{name}"')
        first = text.count("\n", 0, max(text.find("<Code>", max(at, 0)), 0)) + 1
        rows = [(number, row) for number, row in rows_of(code, "//", first=first) if row not in {"begin", "end"}]
        body = tree(rows, file, begins=BLOCK, turns="ELSE ELSEIF", ends="ENDIF ENDWHILE ENDFOR UNTIL ENDSWITCH")
        self.routines[self.declare(name, file, self.routines)] = Steps(file, names, body, first)

    # -- values ----------------------------------------------------------------------------------------------------

    def name(self, name: str) -> Any:
        """Return a variable; one without an index is its first element, and of a tool its name."""
        if name not in self.values and name not in self.locals[-1] and (name in self.tools or "" in self.tools):
            return name
        return super().name(name)

    def value(self, text: str | list[str]) -> Any:
        return _first(super().value(text))

    def part(self, value: Any, name: str) -> Any:
        """Return a number of an element; what is in ``trsf`` is the element itself."""
        value = _first(value)
        if isinstance(value, _Element) and (name in {"trsf", "mdesc"} or name in value.values):
            return value if name in {"trsf", "mdesc"} else value.values[name]
        raise ProgramError(f"not followed: .{name}")

    def call(self, name: str, arguments: list[Any]) -> Any:
        return super().call(name, [_first(one) for one in arguments])

    def _T(self, point: Any) -> FloatArray:
        if not isinstance(point, _Element):
            raise ProgramError("not a point")
        return self._T_father(point.father) @ point.place()

    def _T_father(self, name: str, depth: int = 0) -> FloatArray:
        if name.startswith("world"):
            return np.eye(4)
        found = re.fullmatch(r"(\w+)\[(\w+)\]", name)
        frames = self.values.get(found[1]) if found else None
        frame = frames.get(int(found[2])) if found and isinstance(frames, dict) and found[2].isdigit() else None
        if not isinstance(frame, _Element) or depth > 9:
            raise ProgramError(f"the frame {name or 'of the point'} is not in the database")
        self.frame = name
        return self._T_father(frame.father, depth + 1) @ frame.place()

    def _compose(self, point: Any, frame: Any, trsf: Any) -> _Element:
        """Displace a point along the axes of a frame."""
        T_frame = self._T_father(frame.father) @ frame.place()
        T_father = self._T_father(point.father)
        T = np.linalg.inv(T_father) @ T_frame @ _trsf(trsf) @ np.linalg.inv(T_frame) @ self._T(point)
        return _element_of(T, point)

    FUNCTIONS: Mapping[str, Callable[..., Any]] = {
        "appro": lambda _, point, trsf: _element_of(point.place() @ _trsf(trsf), point),  # along its own axes
        "compose": _compose,
    }

    # -- running ---------------------------------------------------------------------------------------------------

    def statement(self, word: str, tokens: list[str], node: Node) -> None:
        if word == "call":
            self.routine(tokens[1], self._values(tokens[3:]))
        elif tokens[1:2] == ["("] and word.lower() in self.INSTRUCTIONS:
            count, function = self.INSTRUCTIONS[word.lower()]
            values = self._values(tokens[2:])
            if len(values) != count and count is not None:
                raise ProgramError(f"a move of {len(values)} values")
            function(self, *values)
        elif "=" in tokens:
            at = tokens.index("=")
            self._assign(tokens[:at], self.value(tokens[at + 1 :]))
        else:
            self.unknown(node.text)

    def _values(self, tokens: list[str]) -> list[Any]:
        return [_first(one) for one in self.parser(tokens).values(")")]

    def _assign(self, left: list[str], value: Any) -> None:
        if left == ["doArc"]:
            self.machine.switch(Does.ON if value else Does.OFF)
            return
        name, kept = left[0], self.values.get(left[0])
        if len(left) == 1 and not isinstance(kept, dict):
            self.give(name, value)
            return
        end = left.index("]") if "]" in left else 0
        at = int(self.value(left[2:end])) if end else 0
        rest = [token for token in left[end + 1 :] if token not in {".", "trsf"}]
        if not isinstance(kept, dict):
            raise ProgramError(f"not followed: {''.join(left)}")
        kept[at] = _changed(kept.get(at), rest, value)

    # -- moves -----------------------------------------------------------------------------------------------------

    def _travel(self, kind: str, goal: Any, tool: Any, motion: Any, via: Any = None) -> None:
        self.tool = str(tool)
        speed = motion.values.get("tmax") if isinstance(motion, _Element) else None
        T_via = None if via is None else self._T(via)
        self.go(kind, self._T(goal), via=T_via, speed_mm_s=speed, zone_mm=_zone_mm(motion))

    def _movej(self, goal: Any, tool: Any, motion: Any) -> None:
        if isinstance(goal, _Element) and set(JOINTS) <= set(goal.values):
            self.blend(_zone_mm(motion))
            self.machine.joint_move(np.array([goal.values[key] for key in JOINTS]))
        else:
            self._travel("J", goal, tool, motion)

    def _movec(self, via: Any, goal: Any, tool: Any, motion: Any) -> None:
        self._travel("C", goal, tool, motion, via)

    #: By their words, lower case: how many values they take, if that is known, and what they do.
    INSTRUCTIONS: Mapping[str, tuple[int | None, Callable[..., None]]] = {
        "movej": (3, _movej),
        "movel": (3, lambda self, *how: self._travel("L", *how)),
        "movec": (4, _movec),
        "waitendmove": (0, lambda self: self.machine.stand()),
        **dict.fromkeys(("delay", "putln", "put", "logmsg", "resetmotion"), (None, lambda *_: None)),
    }


def _zone_mm(motion: Any) -> float | None:
    """Return how far from a point a motion may leave the path, or be back on it; None where it stops."""
    if not isinstance(motion, _Element) or not motion.blends:
        return None
    return max(motion.values.get(key, math.inf) for key in ZONES)


def _first(value: Any) -> Any:
    """Return an array without an index as its first element."""
    return value[0] if isinstance(value, dict) and 0 in value else value


def _changed(old: Any, rest: list[str], value: Any) -> Any:
    """Return an element of an array as an assignment to it, or to a number in it, makes it."""
    if isinstance(old, _Element) and rest and rest[0] in old.values:
        return replace(old, values={**old.values, rest[0]: float(value)})
    if rest or isinstance(old, _Element) != isinstance(value, _Element):
        raise ProgramError(f"not followed: an assignment to .{'.'.join(rest)}")
    return value


def _trsf(value: Any) -> FloatArray:
    if isinstance(value, Sequence) and len(value) == len(AXES):
        value = _Element("trsf", dict(zip(AXES, map(float, value), strict=True)))
    if not isinstance(value, _Element):
        raise ProgramError("not a transformation")
    return value.place()
