"""FANUC TP (`.ls`), as far as touch programs use it (R-30iB basic operation manual).

Rules that matter here: a motion with `Skip,LBL[n]` ends where the skip condition is met, and the next line runs; if the
motion comes to its end the program jumps to the label. The condition is a level: where it holds at the start there is
no motion. `PR[n]=LPOS` behind the label is the place at that moment, in the present user frame and tool. Points of the
program say their own frame and tool, which must be the present ones. Registers are saved in `numreg.va`, `posreg.va`.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tests.touch_robots.robot import Array, Robot
from wpcal.controllers.run.expressions import AND, COMPARE, OR, SIGNS, SUM, Parser, Syntax, tokens_of
from wpcal.controllers.run.machine import inverted, rigid
from wpcal.controllers.run.program import ProgramError, Run, StoppedError

TOKEN = re.compile(
    r"'[^']*'|\d+(?:\.\d+)?|\.\d+|LBL|UFRAME_NUM|UTOOL_NUM|[A-Za-z$_][\w$]*|<>|<=|>=|[-+*/=<>()\[\],.!:]"
)
GRAMMAR = Syntax(
    TOKEN,
    (OR, AND, {"=": operator.eq, **COMPARE}, SUM, {"*": operator.mul, "/": operator.truediv, "DIV": operator.floordiv}),
    {**SIGNS, "!": operator.not_},
    {"ON": True, "OFF": False},
    index=("[", "]"),
    quote="'",
)
DIGITS = 3
MOST_LABEL = 32766
MESSAGE_LENGTH = 24  #: Characters that MESSAGE shows.


def place_of(values: Any) -> Array:
    """Return X Y Z W P R as a matrix: W about x, P about y, R about z, all of the fixed axes."""
    return rigid(Rotation.from_euler("xyz", values[3:6], degrees=True), values[:3])


def values_of(T: Array) -> list[float]:
    angles = Rotation.from_matrix(T[:3, :3]).as_euler("xyz", degrees=True)
    return [round(float(v), DIGITS) + 0.0 for v in (*T[:3, 3], *angles)]


class Program:
    """One `.ls` file."""

    def __init__(self, text: str) -> None:
        head = re.search(r"^/PROG\s+(\S+)", text, re.MULTILINE)
        body = re.search(r"^/MN[ \t]*\r?\n(.*?)^/POS[ \t]*\r?\n(.*?)^/END", text, re.MULTILINE | re.DOTALL)
        if head is None or body is None:
            raise ProgramError("a program has /PROG, /MN, /POS and /END")
        self.name = head[1].upper()
        if len(self.name) > 36 or not re.fullmatch(r"[A-Z][A-Z0-9_]*", self.name):
            raise ProgramError(f"{self.name} is no name of a program")
        self.lines: list[str] = []
        for number, line in enumerate(body[1].splitlines(), start=1):
            found = re.fullmatch(r"\s*(\d+):(.*?);\s*", line)
            if found is None or int(found[1]) != number:
                raise ProgramError(f"line {number} of {self.name}: {line!r}")
            self.lines.append(found[2].strip())
        self.labels: dict[int, int] = {}
        for at, line in enumerate(self.lines):
            if found := re.fullmatch(r"LBL\[(\d+)(?::[^\]]*)?\]", line):
                number = int(found[1])
                if number in self.labels or not 1 <= number <= MOST_LABEL:
                    raise ProgramError(f"LBL[{number}] is there twice, or out of range")
                self.labels[number] = at
        self.points = dict(self._points(body[2]))

    def _points(self, text: str) -> Any:
        for number, inside in re.findall(r'P\[(\d+)(?::"[^"]*")?\]\s*\{(.*?)\};', text, re.DOTALL):
            frame = re.search(r"UF\s*:\s*(\d+|F),\s*UT\s*:\s*(\d+|F)", inside)
            if frame is None or "GP1:" not in inside.replace(" ", ""):
                raise ProgramError(f"P[{number}] has no group, frame or tool")
            joints = re.findall(r"\bJ(\d)\s*=\s*([-\d.]+)\s*deg", inside)
            values = {key: float(v) for key, v in re.findall(r"\b([XYZWPR])\s*=\s*([-\d.]+)\s*(?:mm|deg)", inside)}
            if not joints and (set(values) != set("XYZWPR") or "CONFIG" not in inside):
                raise ProgramError(f"P[{number}] is not complete")
            yield int(number), (frame[1], frame[2], None if joints else [values[key] for key in "XYZWPR"])


class Controller:
    """A controller with its registers; `tools` and `frames` are UTOOL and UFRAME as they were set up."""

    def __init__(
        self,
        files: dict[str, str],
        robot: Robot,
        *,
        signal: int = 1,
        tools: dict[int, Array] | None = None,
        frames: dict[int, Array] | None = None,
        on_stop: Callable[[str], bool] = lambda _: False,
        level: bool = True,
    ) -> None:
        self.robot, self.input, self.on_stop, self.level, self.run = robot, signal, on_stop, level, Run()
        self.programs = {one.name: one for one in map(Program, files.values())}
        self.tools, self.frames = dict(tools or {}), dict(frames or {})
        self.tool = self.frame = 0
        self.registers: dict[int, Any] = {}
        self.comments: dict[str, str] = {}
        self.places: dict[int, list[float] | None] = {}
        self.outputs: dict[int, bool] = {}
        self.flags: dict[int, bool] = {}
        self.skip: list[str] | None = None
        self.program: Program | None = None
        self.depth = 0

    # -- values ----------------------------------------------------------------------------------------------------

    def value(self, text: str) -> Any:
        parser = Parser(tokens_of(text, GRAMMAR), GRAMMAR, self)
        value = parser.value()
        parser.end()
        return value

    def name(self, name: str) -> Any:
        if name in {"R", "DI", "RI", "DO", "PR", "F", "P"}:
            return name
        if name == "LPOS":
            return self._seen(self.robot.reading(np.eye(4)))
        raise ProgramError(f"{name} is unknown")

    def call(self, name: str, arguments: list[Any]) -> Any:
        raise ProgramError(f"{name}({arguments}) is unknown")

    def part(self, value: Any, name: str) -> Any:
        raise ProgramError(f"{value}.{name} is unknown")

    def item(self, value: Any, indices: list[Any]) -> Any:
        number = indices[0]
        if value in {"DI", "RI"}:
            return number == self.input and self.robot.is_on() == self.level
        if value == "F":
            return self.flags.get(number, False)
        if value == "DO":
            return self.outputs.get(number, False)
        if value == "R":
            if number not in self.registers:
                return 0
            return self.registers[number]
        if value == "P" and self.program is not None:
            return self._point(number)
        if value == "PR":
            place = self.places.get(number)
            if place is None:
                raise ProgramError(f"PR[{number}] is not initialised")
            return place[indices[1] - 1] if len(indices) > 1 else place
        raise ProgramError(f"{value}[{number}] is unknown")

    def _point(self, number: int) -> list[float] | None:
        assert self.program is not None
        if number not in self.program.points:
            raise ProgramError(f"P[{number}] is not taught")
        frame, tool, values = self.program.points[number]
        if frame not in {str(self.frame), "F"} or tool not in {str(self.tool), "F"}:
            raise ProgramError(f"P[{number}] is of UF {frame}, UT {tool}; present are {self.frame}, {self.tool}")
        return values

    def _T_frame(self) -> Array:
        if self.frame and self.frame not in self.frames:
            raise ProgramError(f"UFRAME[{self.frame}] is not set")
        return self.frames[self.frame] if self.frame else np.eye(4)

    def _T_tool(self) -> Array:
        if self.tool not in self.tools:
            raise ProgramError(f"UTOOL[{self.tool}] is not set")
        return self.tools[self.tool]

    def _seen(self, T_base_flange: Array) -> list[float]:
        return values_of(inverted(self._T_frame()) @ T_base_flange @ self._T_tool())

    # -- running ---------------------------------------------------------------------------------------------------

    def start(self, name: str) -> Run:
        try:
            self._program(name.upper())
            self.run.is_finished = True
        except StoppedError:
            pass
        return self.run

    def _program(self, name: str) -> None:
        if name not in self.programs:
            raise ProgramError(f"CALL: {name} is not there")
        before, self.program = self.program, self.programs[name]
        at = 0
        while at < len(self.program.lines):
            jump = self.execute(self.program.lines[at])
            if jump == -1:
                break
            at = at + 1 if jump is None else jump
        self.program = before

    def execute(self, line: str) -> int | None:
        """Run one line; return the line to jump to, -1 at END, or None."""
        if not line or line.startswith(("!", "--eg:")) or re.fullmatch(r"LBL\[\d+(:[^\]]*)?\]", line):
            if len(line) > 1 + 32 and line.startswith("!"):
                raise ProgramError(f"a remark has at most 32 characters: {line!r}")
            return None
        line = re.sub(r"\[(\d+):[^\]]*\]", r"[\1]", line)  # comments of registers
        if found := re.fullmatch(r"([JLC]) (.*)", line):
            return self._motion(found[1], found[2])
        for pattern, function in self._INSTRUCTIONS:
            if found := re.fullmatch(pattern, line):
                return function(self, *found.groups())
        raise ProgramError(f"unknown: {line!r}")

    def _jump(self, text: str) -> int | None:
        assert self.program is not None
        if found := re.fullmatch(r"JMP LBL\[(\d+)\]", text):
            if int(found[1]) not in self.program.labels:
                raise ProgramError(f"LBL[{found[1]}] is not there")
            return self.program.labels[int(found[1])]
        if found := re.fullmatch(r"CALL (\w+)", text):
            self._program(found[1].upper())
            return None
        raise ProgramError(f"unknown: {text!r}")

    def _motion(self, kind: str, text: str) -> int | None:
        found = re.fullmatch(
            r"(P|PR)\[(\d+)\] (?:(\d+(?:\.\d+)?)(%|mm/sec)|R\[(\d+)\](mm/sec|%)) (FINE|CNT\d+)\s*(.*)", text
        )
        if found is None:
            raise ProgramError(f"unknown motion: {kind} {text!r}")
        which, number, speed, unit, register, unit_2, _, rest = found.groups()
        if (kind == "J") != ((unit or unit_2) == "%"):
            raise ProgramError(f"the speed of {kind} {text!r}")
        values = self.item(which, [int(number)])
        if values is None:
            if kind != "J" or rest:
                raise ProgramError(f"joint angles in {kind} {text!r}")
            self.robot.joint_move()
            return None
        goal = self._T_frame() @ place_of(values)
        if not rest:
            self.robot.move(goal, self._T_tool(), is_line=kind == "L")
            return None
        skip = re.fullmatch(r"Skip,LBL\[(\d+)\](?:,PR\[(\d+)\]=LPOS)?", rest)
        if skip is None or kind != "L":
            raise ProgramError(f"unknown: {rest!r}")
        if self.skip is None:
            raise ProgramError("Skip without SKIP CONDITION")
        mm_s = float(speed) if speed else float(self.registers[int(register)])
        before = len(self.robot.hits)
        hit = self.robot.search(goal, self._T_tool(), mm_s, is_edge=False)
        if hit is None:
            return self._jump(f"JMP LBL[{skip[1]}]")
        if skip[2] and len(self.robot.hits) > before:
            self.places[int(skip[2])] = values_of(inverted(self._T_frame()) @ hit)
        return None

    def _set_skip(self, text: str) -> None:
        found = re.fullmatch(r"(DI|RI)\[(\d+)\]=(ON|OFF)", text)
        if found is None:
            raise ProgramError(f"SKIP CONDITION {text!r} is unknown")
        if int(found[2]) != self.input or (found[3] == "ON") != self.level:
            raise ProgramError("the skip condition does not wait for the touch")
        self.skip = [text]

    def _if(self, condition: str, then: str) -> int | None:
        return self._jump(then) if self.value(condition) else None

    def _set(self, left: str, right: str) -> None:
        found = re.fullmatch(r"(R|PR|DO|F|UFRAME|UTOOL|RO)\[(\d+)(?:,(\d))?\]", left)
        if found is None:
            raise ProgramError(f"unknown: {left}={right}")
        kind, number, part = found[1], int(found[2]), found[3]
        value = self.value(right.strip("()") if kind in {"DO", "F"} else right)
        if kind == "R":
            self.registers[number] = value
        elif kind in {"DO", "RO"}:
            self.outputs[number] = value
            self.run.outputs[f"{kind}{number}"] = value
        elif kind == "F":
            self.flags[number] = value
        elif kind == "PR":
            if part is None:
                self.places[number] = list(value)
            else:
                place = self.places.get(number)
                if place is None:
                    raise ProgramError(f"PR[{number}] is not initialised")
                place[int(part) - 1] = float(value)
        elif kind == "UFRAME":
            self.frames[number] = place_of(value)
        else:
            self.tools[number] = place_of(value)

    def _number(self, what: str, number: str) -> None:
        setattr(self, "frame" if what == "UFRAME" else "tool", int(number))

    def _message(self, text: str) -> None:
        if len(text) > MESSAGE_LENGTH:
            raise ProgramError(f"MESSAGE shows {MESSAGE_LENGTH} characters: {text!r}")
        self.run.messages.append(text)

    def _pause(self) -> None:
        self.run.stop(self.run.messages[-1] if self.run.messages else "", self.on_stop)

    def _abort(self) -> None:
        raise StoppedError("ABORT")

    def _wait(self, text: str) -> None:
        if not self.value(text):
            self.run.stop(f"WAIT {text}", self.on_stop)

    _INSTRUCTIONS: tuple[tuple[str, Callable[..., int | None]], ...] = (
        (r"SKIP CONDITION (.*?)", _set_skip),
        (r"(UFRAME|UTOOL)_NUM=(\d+)", _number),
        (r"(JMP LBL\[\d+\]|CALL \w+)", _jump),
        (r"IF (.*?),(JMP LBL\[\d+\]|CALL \w+)", _if),
        (r"WAIT +[\d.]+ ?\(sec\)", lambda _: None),
        (r"WAIT (.*?)", _wait),
        (r"MESSAGE\[(.*)\]", _message),
        (r"PAUSE", _pause),
        (r"ABORT", _abort),
        (r"END", lambda _: -1),
        (r"((?:R|PR|DO|RO|F|UFRAME|UTOOL)\[[^\]]*\])=(.*?)", _set),
    )

    # -- files -----------------------------------------------------------------------------------------------------

    def backup(self, *, count: int = 100) -> dict[str, str]:
        """Return `numreg.va` and `posreg.va`; the controller drops the zero before the point of a small number."""
        rows = ["[*NUMREG*]$NUMREG  Storage: CMOS  Access: RW  : ARRAY[200] OF Numeric Reg"]
        for number in range(1, 201):
            value = self.registers.get(number, 0)
            text = str(value) if isinstance(value, int) else f"{value:.6f}"
            rows.append(f"  [{number}] = {text}  '{self.comments.get(f'R{number}', '')}' ")
        places = [f"[*POSREG*]$POSREG  Storage: CMOS  Access: RW  : ARRAY[1,{count}] OF Position Reg"]
        for number in range(1, count + 1):
            place = self.places.get(number)
            if place is None:
                places.append(f"    [1,{number}] =   '' Uninitialized")
                continue
            texts = [_printed(v) for v in place]
            places += [
                f"    [1,{number}] =   '' ",
                "  Group: 1   Config: N U T, 0, 0, 0",
                f"  X: {texts[0]}   Y: {texts[1]}   Z: {texts[2]}",
                f"  W: {texts[3]}   P: {texts[4]}   R: {texts[5]}",
            ]
        return {"numreg.va": "\r\n".join(rows) + "\r\n", "posreg.va": "\r\n".join(places) + "\r\n"}


def _printed(value: float) -> str:
    text = f"{value:.{DIGITS}f}"
    text = re.sub(r"^(-?)0\.(?!0*$)", r"\1.", text)
    return f"{text:>9}" if len(text) <= 9 else "********"
