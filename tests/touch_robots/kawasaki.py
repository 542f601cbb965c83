"""Kawasaki AS, as far as touch programs use it (AS language reference manual, D/E controllers).

Rules that matter here: `XMOVE p TILL s` moves on a line and stops when signal s turns on (a negative number: off);
the next step then runs, as it does at the end of the motion. Without a mode a signal that is on at the start does not
count; `/LVL` takes it at once. `HERE` is the present pose in BASE and TOOL; `HSENSESET`/`HSENSE` latch the pose at
the signal. Signals from 1001 are inputs. `SAVE` writes transformations as X Y Z O A T with six digits behind the
point.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np

from tests.touch_robots.kawasaki_text import GRAMMAR, MOST_NAME, Pose, Step, steps_of
from tests.touch_robots.robot import Array, Robot
from wpcal.controllers.run.expressions import Parser, tokens_of
from wpcal.controllers.run.machine import inverted
from wpcal.controllers.run.program import ProgramError, Run, StoppedError


class _ReturnError(Exception):
    pass


class _JumpError(Exception):
    def __init__(self, label: str) -> None:
        self.label = label


class Controller:
    """A robot with its programs and variables; `signal` is the input of the touch, from 1001."""

    def __init__(
        self,
        files: dict[str, str],
        robot: Robot,
        *,
        signal: int = 1001,
        tools: dict[Any, Array] | None = None,
        on_stop: Callable[[str], bool] = lambda _: False,
        level: bool = True,
    ) -> None:
        self.robot, self.input, self.on_stop, self.level, self.run = robot, signal, on_stop, level, Run()
        self.values: dict[str, Any] = {}
        self.programs: dict[str, tuple[list[str], list[Step]]] = {}
        self.given = {str(name).upper(): Pose(T) for name, T in (tools or {}).items()}
        self.values.update(self.given)
        self.T_base, self.T_tool = np.eye(4), None
        self.speed_mm_s = 0.0
        self.latched: list[Pose] = []
        self.latch: int | None = None
        self.locals: list[dict[str, Any]] = [{}]
        for text in files.values():
            self._load(text)

    # -- loading ---------------------------------------------------------------------------------------------------

    def _load(self, text: str) -> None:
        rows = text.replace("\r", "").split("\n")
        at = 0
        while at < len(rows):
            row = rows[at].strip()
            end = next((i for i in range(at + 1, len(rows)) if rows[i].strip().upper() == ".END"), None)
            if not row or row.startswith((".*", ";")):
                at += 1
                continue
            if end is None:
                raise ProgramError(f"no .END behind {row!r}")
            word = row.split()[0].split("(")[0].upper()
            inside = rows[at + 1 : end]
            if word == ".PROGRAM":
                head = re.fullmatch(r"\.PROGRAM\s+([\w.]+)\s*\(([^)]*)\)(?:\s*#\d+)?(?:\s*;.*)?", row, re.IGNORECASE)
                if head is None or len(head[1]) > MOST_NAME:
                    raise ProgramError(f"{row!r} is no head of a program")
                names = [one.strip(" .").upper() for one in head[2].split(",") if one.strip()]
                self.programs[head[1].upper()] = names, steps_of(inside)
            elif word in {".TRANS", ".JOINTS", ".REALS", ".STRINGS"}:
                self._data(word, inside)
            else:
                raise ProgramError(f"{row!r} is unknown")
            at = end + 1

    def _data(self, word: str, rows: list[str]) -> None:
        for row in filter(None, map(str.strip, rows)):
            if word in {".REALS", ".STRINGS"}:
                name, _, value = row.partition("=")
                self._check(name.strip())
                self.values[name.strip().upper()] = self.value(tokens_of(value.strip(), GRAMMAR))
                continue
            name, *numbers = row.split()
            self._check(name)
            values = [float(v) for v in numbers]
            if word == ".TRANS" and len(values) < 6:
                raise ProgramError(f"{row!r} is no transformation")
            self.values[name.upper()] = Pose.of(values) if word == ".TRANS" else tuple(values)

    def _check(self, name: str) -> None:
        if len(name.lstrip("$#")) > MOST_NAME:
            raise ProgramError(f"{name} has more than {MOST_NAME} characters")

    # -- values ----------------------------------------------------------------------------------------------------

    def value(self, tokens: list[str]) -> Any:
        parser = Parser(tokens, GRAMMAR, self)
        value = parser.value()
        parser.end()
        return value

    def name(self, name: str) -> Any:
        if name == "HERE":
            return Pose(self._seen(self.robot.reading(np.eye(4))))
        if name == "NULL":
            return Pose(np.eye(4))
        if name == "BASE":
            return Pose(self.T_base)
        if name == "TOOL":
            return Pose(self._tool())
        for values in (self.locals[-1], self.values):
            if name in values:
                return values[name]
        raise ProgramError(f"{name} is undefined")

    def part(self, value: Any, name: str) -> Any:
        raise ProgramError(f"{value}.{name} is unknown")

    def item(self, value: Any, indices: list[Any]) -> Any:
        raise ProgramError(f"{value}{indices} is unknown")

    def call(self, name: str, arguments: list[Any]) -> Any:
        if name == "SIG":
            return -1 if all(self._signal(int(number)) for number in arguments) else 0
        if name == "TRANS":
            return Pose.of(arguments)
        if name in {"DX", "DY", "DZ"}:
            return arguments[0].values()["XYZ".index(name[1])]
        if name == "ABS":
            return abs(arguments[0])
        if name == "DISTANCE":
            return float(np.linalg.norm(arguments[0].T[:3, 3] - arguments[1].T[:3, 3]))
        raise ProgramError(f"the function {name} is unknown")

    def _signal(self, number: int) -> bool:
        if abs(number) != self.input:
            raise ProgramError(f"the signal {number} is not connected")
        is_on = self.robot.is_on() == self.level
        return is_on if number > 0 else not is_on

    def _tool(self) -> Array:
        if self.T_tool is None:
            raise ProgramError("a motion before TOOL")
        return self.T_tool

    def _seen(self, T_base_flange: Array) -> Array:
        return inverted(self.T_base) @ T_base_flange @ self._tool()

    # -- running ---------------------------------------------------------------------------------------------------

    def start(self, name: str) -> Run:
        try:
            self._program(name.upper(), [])
            self.run.is_finished = True
        except StoppedError:
            pass
        return self.run

    def _program(self, name: str, arguments: list[Any]) -> None:
        if name not in self.programs:
            raise ProgramError(f"CALL {name}: it is not there")
        names, steps = self.programs[name]
        if len(names) != len(arguments):
            raise ProgramError(f"{name} takes {len(names)} arguments")
        self.locals.append(dict(zip(names, arguments, strict=True)))
        at = 0
        try:
            while at < len(steps):
                try:
                    self.execute(steps[at])
                    at += 1
                except _JumpError as jump:
                    labels = {step.label: i for i, step in enumerate(steps) if step.label}
                    if jump.label not in labels:
                        raise ProgramError(f"GOTO {jump.label}: no such label outside blocks") from None
                    at = labels[jump.label]
        except _ReturnError:
            pass
        finally:
            self.locals.pop()

    def block(self, steps: list[Step]) -> None:
        for step in steps:
            self.execute(step)

    def execute(self, step: Step) -> None:
        tokens = step.tokens
        word = tokens[0].upper()
        if word == "IF":
            self._if(step)
        elif word == "FOR":
            words = [t.upper() for t in tokens]
            to = words.index("TO")
            for number in range(int(self.value(tokens[3:to])), int(self.value(tokens[to + 1 :])) + 1):
                self._set(tokens[1], number)
                self.block(step.blocks[0])
        elif word == "WHILE":
            while self.value(tokens[1:-1]):
                self.block(step.blocks[0])
        elif word == "POINT" or (len(tokens) > 2 and tokens[1] == "="):
            name, right = (tokens[1], tokens[3:]) if word == "POINT" else (tokens[0], tokens[2:])
            value = self.value(right)
            if (word == "POINT") != isinstance(value, Pose):
                raise ProgramError(f"POINT is for transformations: {' '.join(tokens)}")
            self._set(name, value)
        elif word == "GOTO":
            raise _JumpError(tokens[1])
        else:
            function = getattr(self, f"_do_{word.lower()}", None)
            if function is None:
                raise ProgramError(f"unknown: {' '.join(tokens)}")
            function(tokens[1:])

    def _if(self, step: Step) -> None:
        words = [token.upper() for token in step.tokens]
        if words[-1] == "THEN":
            holds = self.value(step.tokens[1:-1])
            if holds:
                self.block(step.blocks[0])
            elif len(step.blocks) > 1:
                self.block(step.blocks[1])
        elif "GOTO" in words:
            at = words.index("GOTO")
            if self.value(step.tokens[1:at]):
                raise _JumpError(step.tokens[at + 1])
        else:
            raise ProgramError(f"IF without THEN: {' '.join(step.tokens)}")

    def _set(self, name: str, value: Any) -> None:
        self._check(name)
        if name.startswith("$") != isinstance(value, str):
            raise ProgramError(f"{name} = {value!r}")
        target = self.locals[-1] if name.upper() in self.locals[-1] or name.startswith(".") else self.values
        target[name.upper()] = value

    # -- instructions ----------------------------------------------------------------------------------------------

    def _goal(self, tokens: list[str]) -> Pose | None:
        if tokens[0].startswith("#"):
            if not isinstance(self.name(tokens[0].upper()), tuple):
                raise ProgramError(f"{tokens[0]} is no joint pose")
            return None
        value = self.value(tokens)
        if not isinstance(value, Pose):
            raise ProgramError(f"{' '.join(tokens)} is no pose")
        return value

    def _travel(self, tokens: list[str], *, is_line: bool) -> None:
        goal = self._goal(tokens)
        if goal is None:
            self.robot.joint_move()
        else:
            self.robot.move(self.T_base @ goal.T, self._tool(), is_line=is_line)

    def _do_lmove(self, tokens: list[str]) -> None:
        self._travel(tokens, is_line=True)

    def _do_jmove(self, tokens: list[str]) -> None:
        self._travel(tokens, is_line=False)

    def _do_xmove(self, tokens: list[str]) -> None:
        mode = ""
        if tokens[0] == "/":
            mode, tokens = tokens[1].upper(), tokens[2:]
        if mode not in {"", "LVL", "ERR"}:
            raise ProgramError(f"XMOVE /{mode}")
        till = [token.upper() for token in tokens].index("TILL")
        goal, signal = self._goal(tokens[:till]), int(self.value(tokens[till + 1 :]))
        if goal is None:
            raise ProgramError("XMOVE to joint angles")
        if abs(signal) != self.input or (signal > 0) != self.level:
            raise ProgramError(f"XMOVE: the signal {signal} is not that of the touch")
        if not self.speed_mm_s:
            raise ProgramError("XMOVE without a speed in mm/s")
        was_on = self._signal(signal)
        if was_on and mode == "ERR":
            raise ProgramError("XMOVE /ERR stops with an error: the signal is already on")
        if was_on and mode == "LVL":
            return
        hit = self.robot.search(self.T_base @ goal.T, self._tool(), self.speed_mm_s)
        if hit is not None and self.latch is not None:
            self.latched.append(Pose(self._seen(hit @ inverted(self._tool()))))

    def _do_hsenseset(self, tokens: list[str]) -> None:
        number, signal = self._split("".join(tokens), r"(\d+)=(-?\d+)(?:,.*)?")
        if abs(int(signal)) != self.input:
            raise ProgramError(f"HSENSESET {number}: the signal {signal} is not connected")
        self.latch, self.latched = int(number), []

    def _do_hsense(self, tokens: list[str]) -> None:
        """`HSENSE n result, signal, pose …`: the oldest latched pose, result -1; without one, result 0."""
        parts = "".join(f" {t}" if i == 1 else t for i, t in enumerate(tokens)).split(" ", 1)
        if self.latch != int(parts[0]):
            raise ProgramError(f"HSENSE {parts[0]} without HSENSESET")
        names = parts[1].split(",")
        self._set(names[0], -1 if self.latched else 0)
        if self.latched:
            self._set(names[1], -1)
            self._set(names[2], self.latched.pop(0))

    def _split(self, text: str, pattern: str) -> tuple[str, ...]:
        found = re.fullmatch(pattern, text)
        if found is None:
            raise ProgramError(f"unknown: {text!r}")
        return found.groups()

    def _do_tool(self, tokens: list[str]) -> None:
        self.T_tool = self.value(tokens).T

    def _do_base(self, tokens: list[str]) -> None:
        self.T_base = self.value(tokens).T

    def _do_speed(self, tokens: list[str]) -> None:
        text = " ".join(tokens).upper().replace(" / ", "/").replace("MM/ S", "MM/S")
        found = re.fullmatch(r"(\d+(?:\.\d+)?)(?: (MM/S))?( ALWAYS)?", text)
        if found is None:
            raise ProgramError(f"SPEED {text}")
        self.speed_mm_s = float(found[1]) if found[2] else 0.0

    def _do_nothing(self, tokens: list[str]) -> None:
        pass

    _do_accuracy = _do_accel = _do_decel = _do_break = _do_twait = _do_base_keep = _do_nothing

    def _do_signal(self, tokens: list[str]) -> None:
        for number in Parser([*tokens, ")"], GRAMMAR, self).values(")"):
            self.run.outputs[f"OX{abs(int(number))}"] = number > 0

    def _do_swait(self, tokens: list[str]) -> None:
        if not self._signal(int(self.value(tokens))):
            self.run.stop(f"SWAIT {' '.join(tokens)}", self.on_stop)

    def _do_print(self, tokens: list[str]) -> None:
        if len(tokens) > 1 and tokens[1] == ":":
            tokens = tokens[2:]
        self.run.messages.append("".join(str(v) for v in Parser([*tokens, ")"], GRAMMAR, self).values(")")))

    _do_type = _do_print

    def _do_here(self, tokens: list[str]) -> None:
        self._set(tokens[0], self.name("HERE"))

    def _do_cp(self, tokens: list[str]) -> None:
        if tokens[0].upper() not in {"ON", "OFF"}:
            raise ProgramError(f"CP {tokens}")

    def _do_pause(self, tokens: list[str]) -> None:
        self.run.stop(self.run.messages[-1] if self.run.messages else "", self.on_stop)

    def _do_halt(self, tokens: list[str]) -> None:
        raise StoppedError("HALT")

    _do_stop = _do_halt

    def _do_return(self, tokens: list[str]) -> None:
        raise _ReturnError

    def _do_call(self, tokens: list[str]) -> None:
        arguments = Parser([*tokens[2:]], GRAMMAR, self).values(")") if len(tokens) > 1 else []
        self._program(tokens[0].upper(), arguments)

    # -- files -----------------------------------------------------------------------------------------------------

    def backup(self) -> dict[str, str]:
        """Return what SAVE writes."""
        sections: dict[str, list[str]] = {".TRANS": [], ".REALS": [], ".STRINGS": []}
        for name, value in sorted(self.values.items()):
            if isinstance(value, Pose):
                sections[".TRANS"].append(f"{name.lower()} " + " ".join(f"{v + 0.0:.6f}" for v in value.values()))
            elif isinstance(value, str):
                sections[".STRINGS"].append(f'{name.lower()} = "{value}"')
            elif isinstance(value, (int, float)):
                sections[".REALS"].append(f"{name.lower()} = {value:g}")
        rows = [row for word, inside in sections.items() for row in (word, *inside, ".END")]
        return {"saved.as": "\r\n".join(rows) + "\r\n"}
