"""FANUC TP (``.ls``): what a program does.

A motion with ``Skip,LBL[n]`` ends where the skip condition is met, and the next line runs; if it comes to its end, the
program jumps to the label. ``PR[n]=LPOS`` behind the label is the place at that moment. Points state their own frame
and tool, which must be the present ones. ``Offset`` moves a point in the user frame, ``Tool_Offset`` in the tool,
``INC`` adds to where the tool is. User frames that the remarks of a program ask for count as set.

References: FANUC, R-30iB HandlingTool Operator's Manual (motion options, registers, branching, skip condition).
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.controllers.fanuc.read import COORDINATE, FRAME, GROUP_1, JOINT, POSITION, TOOL
from wpcal.controllers.fanuc.read import GRAMMAR as TEXT
from wpcal.controllers.fanuc.write import DECIMALS, LANGUAGE, LONGEST_REMARK
from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.expressions import AND, COMPARE, OR, SIGNS, Parser, Syntax, tokens_of
from wpcal.controllers.run.interpreter import LineInterpreter, matrix_of, numbers_of, stated_frame
from wpcal.controllers.run.machine import ProgramError
from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import inverse_pose

TOKEN = re.compile(r"'[^']*'|\d+(?:\.\d+)?|\.\d+|[A-Za-z$_][\w$]*|<>|<=|>=|[-+*/=<>()\[\],.!:]")
SYNTAX = Syntax(
    TOKEN,
    (
        OR,
        AND,
        {"=": operator.eq, **COMPARE},
        {"+": operator.add, "-": operator.sub},
        {"*": operator.mul, "/": operator.truediv, "DIV": operator.floordiv, "MOD": operator.mod},
    ),
    {**SIGNS, "!": operator.not_},
    {"ON": True, "OFF": False},
    index=("[", "]"),
    quote="'",
)
MOST_LABEL = 32766
EXTENDED = re.compile(r"\bE\d\s*+=\s*+(-?\d++(?:\.\d++)?)")


class Values(tuple[float, ...]):
    """Six numbers of a position register, that can be added."""

    def __add__(self, other: Any) -> Any:
        """Add number by number."""
        return type(self)(a + b for a, b in zip(self, other, strict=True))

    def __sub__(self, other: Any) -> Values:
        """Take away number by number."""
        return type(self)(a - b for a, b in zip(self, other, strict=True))


class Joints(Values):
    """Joint angles, deg."""


def _matrix(values: Values) -> FloatArray:
    if isinstance(values, Joints):
        raise ProgramError("joint angles where a pose is needed")
    return matrix_of(values)


def _values(T: FloatArray) -> Values:
    return Values(numbers_of(T, DECIMALS, DECIMALS))


@dataclass(frozen=True, slots=True)
class _Point:
    frame: str  #: Number, or F for the present one.
    tool: str
    values: Values | None  #: None if it was not taught.
    external: tuple[float, ...] = ()  #: A rail as extended axis of group 1, mm, then the axes of group 2, deg.
    held: tuple[str, Values] | None = (
        None  #: A robot as group 2: the number of its tool, and where this is in its base.
    )


class _Program:
    """One ``.ls`` file: instructions with their lines in the file, labels, positions."""

    def __init__(self, file: str, text: str) -> None:
        self.file = file
        head, main, points = (re.search(rf"^/{word}\b.*$", text, re.MULTILINE) for word in ("PROG", "MN", "POS"))
        if head is None or main is None or points is None or not main.end() < points.start():
            raise ProgramError("a program has /PROG, /MN, /POS and /END", path=file)
        self.name = head[0][5:].strip().partition(" ")[0].upper()
        if not re.fullmatch(r"[A-Z][A-Z0-9_-]{0,35}", self.name):
            raise ProgramError(f"{self.name!r} is not the name of a program", path=file)
        self.lines = self._lines(text[main.end() : points.start()], text.count("\n", 0, main.end()) + 1)
        self.labels = self._labels()
        self.points = {int(one["number"]): _point(one["body"]) for one in POSITION.finditer(text, points.end())}

    def _labels(self) -> dict[str, int]:
        labels: dict[str, int] = {}
        for at, (number, line) in enumerate(self.lines):
            if found := re.fullmatch(r"LBL\[(\d{1,5}+)(?::[^\]]*)?\]", line):
                label = str(int(found[1]))
                if label in labels or not 1 <= int(label) <= MOST_LABEL:
                    raise ProgramError(f"LBL[{label}] is there twice, or out of range", path=self.file, line=number)
                labels[label] = at
        return labels

    def _lines(self, text: str, first: int) -> list[tuple[int, str]]:
        """Return instructions with their lines; the end of a circular move belongs to the instruction before."""
        lines = list[tuple[int, str]]()
        for number, line in enumerate(text.splitlines()[1:], start=first + 1):
            found = re.fullmatch(r"\s*+(\d*+):(.*?);?\s*", line)
            if found is None:
                raise ProgramError(f"is not an instruction: {line.strip()[:60]!r}", path=self.file, line=number)
            if found[1]:
                lines.append((number, found[2].strip()))
            elif lines:
                lines[-1] = (lines[-1][0], f"{lines[-1][1]} {found[2].strip()}")
        return lines


def _point(body: str) -> _Point:
    group, frame, tool = GROUP_1.search(body), FRAME.search(body), TOOL.search(body)
    if group is None or frame is None or tool is None:
        return _Point("F", "F", None)
    own, _, others = body.partition("GP2")
    try:
        values = _six(group["body"])
        external = tuple(float(v) for v in (*EXTENDED.findall(own), *(v for _, v in JOINT.findall(others))))
        held = _held(others)
    except ValueError:
        return _Point(frame[1], tool[1], None)
    return _Point(frame[1], tool[1], values, external, held)


def _six(text: str) -> Values:
    """Return the six numbers of a group; `ValueError` where they are not there."""
    joints, place = dict(JOINT.findall(text)), dict(COORDINATE.findall(text))
    if joints:
        return Joints(float(joints.get(key, "")) for key in "123456")
    return Values(float(place.get(key, "")) for key in "XYZWPR")


def _held(text: str) -> tuple[str, Values] | None:
    """Return where a robot as group 2 is."""
    place, tool = dict(COORDINATE.findall(text)), TOOL.search(text)
    six = Values(float(place.get(key, "nan")) for key in "XYZWPR")
    return None if not place or tool is None else (tool[1], six)


class Interpreter(LineInterpreter):
    """Runs TP programs; registers have no value before the program gives them one."""

    grammar = TEXT
    SIGNAL = r"SKIP CONDITION (?P<name>[DR]I\[\d+\])=(?:ON|(?P<off>OFF))"
    job: _Program
    LONGEST_MESSAGE = 24  #: Characters that MESSAGE shows.
    REMARKS: Mapping[str, float] = {"!": LONGEST_REMARK, "--eg:": math.inf}
    BLOCK = (r"IF .*THEN$", r"ELSE$", r"ENDIF$")
    FOR, LABELLED = (r"FOR ", r"ENDFOR$"), "LBL[{}]"

    def __init__(self, files: Mapping[str, str], *args: Any, **given: Any) -> None:
        self.jobs: dict[str, _Program] = {}
        self.registers: dict[str, dict[int, Any]] = {kind: {} for kind in ("R", "PR", "DO", "RO", "F", "AR")}
        self.skip = ""
        self.offsets: dict[str, str] = {}
        self.loops = []
        self.held: dict[str, FloatArray] = {}  #: Tools of group 2.
        super().__init__(files, *args, **given)
        self.tool = self.frame = "0"
        self.bases.setdefault("0", np.eye(4))

    def load(self, file: str, text: str) -> None:
        program = _Program(file, text)
        self.jobs[self.declare(program.name, file, self.jobs)] = program
        self.bases = stated_frame(text, LANGUAGE) | self.bases
        self.held |= stated_frame(text, LANGUAGE, r"set UTOOL (\d++) of group 2 to the")

    # -- values ----------------------------------------------------------------------------------------------------

    def value(self, text: str) -> Any:
        return Parser(tokens_of(text, SYNTAX), SYNTAX, self).whole()

    def name(self, name: str) -> Any:
        if name == "LPOS":
            return _values(inverse_pose(self.T_frame()) @ self.machine.reading(self.T_tool()))
        if name in {*self.registers, "DI", "RI", "P", "UFRAME", "UTOOL"}:
            return name
        raise ProgramError(f"{name} is not followed")

    def call(self, name: str, arguments: list[Any]) -> Any:
        raise ProgramError(f"{name}(…) is not followed")

    def item(self, value: Any, indices: list[Any]) -> Any:
        number = int(indices[0])
        if value in {"DI", "RI"}:
            return self.is_on(f"{value}[{number}]")
        if value == "P":
            found: Any = self._point(number)
        elif value in {"UFRAME", "UTOOL"}:
            given = self.bases if value == "UFRAME" else self.tools
            found = _values(given[str(number)]) if str(number) in given else None
        else:
            found = self.registers.get(value, {}).get(number)
        if found is None:
            raise ProgramError(f"nobody knows {value}[{number}]: the program gave it no value")
        return found[int(indices[1]) - 1] if len(indices) > 1 else found

    def _point(self, number: int) -> Values:
        point = self.job.points.get(number)
        if point is None:
            raise ProgramError(f"P[{number}] is not taught")
        if point.frame not in {self.frame, "F"} or point.tool not in {self.tool, "F"}:
            present = f"present are {self.frame}, {self.tool}"
            raise ProgramError(f"P[{number}] is of UF {point.frame}, UT {point.tool}; {present}")
        if point.values is None:
            raise ProgramError(f"P[{number}] is not six numbers of group 1")
        return point.values

    # -- running ---------------------------------------------------------------------------------------------------

    def instruction(self, line: str, at: int) -> int | None:
        line = re.sub(r"\[(\d++):[^\]]*+\]", r"[\1]", line)  # comments of registers and positions
        if re.match(r"[JLCA] ?(?:P|PR)\[", line):
            return self._motion(line)
        return self.matched(line, at)

    def _call(self, name: str, given: str | None) -> None:
        before, values = self.registers["AR"], given.split(",") if given else []
        self.registers["AR"] = {number: self.value(one) for number, one in enumerate(values, 1)}
        self.routine(name)
        self.registers["AR"] = before

    # -- blocks ----------------------------------------------------------------------------------------------------

    def number(self, name: str) -> Any:
        return self.value(name)

    def set(self, name: str, value: Any) -> None:
        self.registers["R"][int(self.value(name[2:-1]))] = value

    def _for(self, at: int, name: str, first: str, word: str, last: str) -> int | None:
        return self.count_from(at, name, self.value(first), self.value(last), 1 if word == "TO" else -1)

    _BLOCKS: tuple[tuple[str, Callable[..., int | None]], ...] = (
        (r"IF \(?(.*?)\)? ?THEN", LineInterpreter.then),
        (r"ELSE", LineInterpreter.otherwise),
        (r"FOR (R\[[^\]]*\])=(.*?) (TO|DOWNTO) (.*)", _for),
        (r"ENDFOR", LineInterpreter.count_on),
        (r"ENDIF", lambda _, __: None),
    )

    # -- motions ---------------------------------------------------------------------------------------------------

    _MOTION = re.compile(
        r"(?P<kind>[JLC]) ?(?P<first>P|PR)\[(?P<number>\d+)\](?: (?P<last>P|PR)\[(?P<end>\d+)\])?"
        r" (?:(?P<speed>\d+(?:\.\d+)?)|R\[(?P<register>\d+)\])(?P<unit>%|mm/sec|cm/min|sec|deg/sec)"
        r" (?P<zone>FINE|CNT ?\d+|CR ?\d+)\s*+(?P<rest>.*)"
    )

    def _motion(self, line: str) -> int | None:
        found = self._MOTION.fullmatch(line)
        if found is None or (found["kind"] == "C") != (found["last"] is not None):
            raise ProgramError(f"not followed: {line[0]} {line[1:].lstrip(' ')!r}")
        kind, mm_s = found["kind"], self._speed_mm_s(found)
        options, skip = self._options(found["rest"])
        zone_mm = {"FINE": None}.get(found["zone"], math.inf)  # a share of the speed bounds no distance
        ends = (found["first"], found["number"]), (found["last"], found["end"])
        names = [(name, int(number)) for name, number in ends if name]
        points, last = [self.item(name, [number]) for name, number in names], names[-1][1]
        if not any(name == "PR" for name, _ in names):
            self.bring(self.job.points[last].external)
        self._lead(last, found["rest"])
        if isinstance(points[-1], Joints):
            self._joint_move(found, points, zone_mm)
            return None
        *via, T_goal = (self._T_base(point, options) for point in points)
        if skip is not None:
            return self._search(kind, T_goal, mm_s, *skip)
        self.go(kind, T_goal, via=next(iter(via), None), speed_mm_s=mm_s, zone_mm=zone_mm)
        return None

    def _speed_mm_s(self, found: re.Match[str]) -> float | None:
        """Return the speed of a move; None of one whose speed is not that of the tool."""
        kind, unit = found["kind"], found["unit"]
        if (kind == "J") != (unit == "%") and unit not in {"sec", "deg/sec"}:
            raise ProgramError(f"the speed of {kind} {found[0][1:].lstrip(' ')!r}")
        amount = float(found["speed"] or self.item("R", [int(found["register"] or 0)]))
        return {"mm/sec": amount, "cm/min": amount / 6.0}.get(unit)

    def _joint_move(self, found: re.Match[str], points: Sequence[Values], zone_mm: float | None) -> None:
        *via, goal = points
        if found["rest"] or not isinstance(points[0], Joints):
            raise ProgramError(f"joint angles in {found['kind']} {found[0][1:].lstrip(' ')!r}")
        self.blend(zone_mm)
        self.machine.joint_move(np.array(goal), kind=found["kind"], via=np.array(via[0]) if via else None)

    def _lead(self, number: int, rest: str) -> None:
        """Move the part in the hand of group 2, on a line."""
        point = self.job.points.get(number)
        if point is None or point.held is None:
            return
        tool, values = point.held
        if self.leader is None or tool not in self.held:
            raise ProgramError("group 2 moves, too: nobody knows what it holds")
        self.leader.at = self.machine.at
        self.leader.move(_matrix(values), self.held[tool], is_line="COORD" in rest)

    def _T_base(self, values: Values, options: Mapping[str, str]) -> FloatArray:
        """Return a position with the offsets of its move in `base`."""
        T_frame, T = self.T_frame(), _matrix(values)
        if "INC" in options:
            if np.any(np.abs(values[3:]) > 0.0):
                raise ProgramError("INC with a turn")
            T = inverse_pose(T_frame) @ self.machine.T_base_tool(self.T_tool())
            T[:3, 3] += values[:3]
        for option in ("Offset", "Tool_Offset"):
            if option in options:
                given = options[option] or self.offsets.get(option, "")
                if not given:
                    raise ProgramError(f"{option} without a condition")
                T_offset = _matrix(self.value(given))
                T = T_offset @ T if option == "Offset" else T @ T_offset
        return T_frame @ T

    def _options(self, text: str) -> tuple[dict[str, str], tuple[str, str] | None]:
        """Return the offsets of a move, and the label and register of its search."""
        options, skip = dict[str, str](), None
        for one in filter(None, text.split(" ")):
            if found := re.fullmatch(r"Skip,LBL\[(\d+)\](?:,PR\[(\d+)\]=LPOS)?", one):
                skip = (found[1], found[2] or "")
            elif found := re.fullmatch(r"(Offset|Tool_Offset)(?:,(PR\[\d+\]))?|(INC)", one):
                options[found[1] or found[3]] = found[2] or ""
            elif not re.fullmatch(r"ACC\d+|PTH|BREAK|COORD", one):
                raise ProgramError(f"the motion option {one!r} is not followed")
        return options, skip

    def _search(self, kind: str, T_goal: FloatArray, mm_s: float | None, label: str, register: str) -> int | None:
        if kind != "L" or mm_s is None:
            raise ProgramError("Skip on a move that is not a line")
        if not self.skip:
            raise ProgramError("Skip without SKIP CONDITION")
        hit = self.machine.search(T_goal, self.T_tool(), mm_s, is_edge=False)
        if hit is None:
            return self.jump(label)
        if register:
            self.registers["PR"][int(register)] = _values(inverse_pose(self.T_frame()) @ hit)
        return None

    # -- instructions ----------------------------------------------------------------------------------------------

    def _set_skip(self, name: str, level: str) -> None:
        if self.signals.get(name) != (level == "ON"):
            raise ProgramError("the skip condition does not wait for the touch")
        self.skip = name

    def _offset(self, kind: str, register: str, frame: str | None) -> None:
        if frame and frame != self.frame:
            raise ProgramError("OFFSET CONDITION in another user frame")
        self.item("PR", [int(register)])
        self.offsets["Tool_Offset" if kind == "TOOL_OFFSET" else "Offset"] = f"PR[{register}]"

    def _set(self, left: str, right: str) -> None:
        found = re.fullmatch(r"(R|PR|DO|F|UFRAME|UTOOL|RO|P)\[(.*?)(?:,(\d))?\]", left)
        if found is None:
            raise ProgramError(f"not followed: {left}={right}")
        kind, number, part = found[1], int(self.value(found[2])), found[3]
        value = self.value(right.strip("()") if kind in {"DO", "F"} else right)
        if part is not None:
            row = list(self.item(kind, [number]))
            row[int(part) - 1] = float(value)
            value = type(self.item(kind, [number]))(row)
        if kind in {"UFRAME", "UTOOL"}:
            (self.bases if kind == "UFRAME" else self.tools)[str(number)] = _matrix(value)
        elif kind == "P":
            self.job.points[number] = _Point("F", "F", value)
        else:
            self.registers[kind][number] = value
        if kind in {"DO", "RO"}:
            self.output(kind, number, on=value)

    def _number(self, what: str, group: str | None, number: str) -> None:
        if group == "2":
            return  # its positions name their tool
        setattr(self, "frame" if what == "UFRAME" else "tool", str(int(self.value(number))))

    def holds(self, condition: str) -> bool:
        return bool(self.value(condition))

    _INSTRUCTIONS: tuple[tuple[str, Callable[..., int | None]], ...] = (
        (r"LBL\[\d+\]|WAIT +[\d.]+ ?\(sec\)", lambda _: None),
        (r"SKIP CONDITION ([DR]I\[\d+\])=(ON|OFF)", _set_skip),
        (r"(TOOL_OFFSET|OFFSET) CONDITION PR\[(\d+)\](?:,UFRAME\[(\d+)\])?", _offset),
        (r"(UFRAME|UTOOL)_NUM(?:\[GP([12])\])?=(.*)", _number),
        (r"JMP LBL\[([^\]]+)\]", lambda self, label: self.jump(str(int(self.value(label))))),
        (r"CALL (\w+)(?:\((.*)\))?", _call),
        (
            r"IF (.*?),(JMP LBL\[[^\]]*\]|CALL .*)",
            lambda self, one, then: self.matched(then, 0) if self.value(one) else None,
        ),
        (r"WAIT (.*?)", LineInterpreter.wait),
        (r"MESSAGE\[(.*)\]", LineInterpreter.message),
        (r"PAUSE", LineInterpreter.pause),
        (r"ABORT", LineInterpreter.abort),
        (r"END", lambda _: -1),
        (r"Weld Start\[.*", lambda self: self.machine.switch(Does.ON)),
        (r"Weld End\[.*", lambda self: self.machine.switch(Does.OFF)),
        (r"Weave (?:Sine|Circle|Figure 8)\[.*|Weave End.*", lambda _: None),
        (r"((?:R|PR|DO|RO|F|UFRAME|UTOOL|P)\[.*?\])=(.*?)", _set),
    )
