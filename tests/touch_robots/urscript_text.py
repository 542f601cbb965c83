"""URScript as text: poses, expressions, lines with their blocks; and its threads."""

from __future__ import annotations

import operator
import re
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tests.touch_robots.robot import Array
from wpcal.controllers.run.expressions import COMPARE, PRODUCT, SIGNS, SUM, Parser, Syntax, tokens_of
from wpcal.controllers.run.machine import rigid
from wpcal.controllers.run.program import ProgramError

TOKEN = re.compile(r'"[^"]*"|\d+(?:\.\d+)?(?:[eE][-+]?\d+)?|\.\d+|[A-Za-z_]\w*|==|!=|<=|>=|[-+*/%=<>()\[\],:]')
GRAMMAR = Syntax(
    TOKEN,
    (
        {"or": lambda a, b: a or b, "xor": operator.xor},
        {"and": lambda a, b: a and b},
        {"==": operator.eq, "!=": operator.ne, **{k: v for k, v in COMPARE.items() if k != "<>"}},
        SUM,
        {**PRODUCT, "%": operator.mod},
    ),
    {**SIGNS, "not": operator.not_},
    {"True": True, "False": False},
    aggregate=("[", "]"),
    index=("[", "]"),
    is_upper=False,
)


class Pose(list[Any]):
    """`p[x,y,z,rx,ry,rz]`, m and rad."""


def matrix(pose: Any) -> Array:
    if not isinstance(pose, Pose) or len(pose) != 6:
        raise ProgramError(f"{pose!r} is no pose")
    return rigid(Rotation.from_rotvec(pose[3:]), 1000.0 * np.array(pose[:3]))


def pose_of(T: Array) -> Pose:
    return Pose(float(v) for v in (*(T[:3, 3] / 1000.0), *Rotation.from_matrix(T[:3, :3]).as_rotvec()))


def printed(value: Any) -> str:
    if isinstance(value, bool):
        return str(value)
    if isinstance(value, str):
        return value
    if isinstance(value, list):
        return ("p[" if isinstance(value, Pose) else "[") + ", ".join(printed(v) for v in value) + "]"
    return f"{value + 0.0:.6g}"


class _KilledError(BaseException):
    pass


class UrParser(Parser):
    """Knows poses and named arguments."""

    def values(self, closing: str) -> list[Any]:
        found: list[Any] = []
        named: dict[str, Any] = {}
        while self.peek() != closing:
            if found or named:
                self.take(",")
            if self.tokens[self.at + 1 : self.at + 2] == ["="]:
                name = self.take()
                self.take("=")
                named[name] = self.value()
            else:
                found.append(self.value())
        self.take(closing)
        return [*found, named] if named else found

    def primary(self) -> Any:
        if self.peek() == "p" and self.tokens[self.at + 1 : self.at + 2] == ["["]:
            self.take()
            self.take("[")
            return Pose(self.values("]"))
        return super().primary()


@dataclass
class Line:
    tokens: list[str]
    body: list[Line]
    rest: list[Line]
    """Of an `if`: its elif and else branches as lines."""


def lines_of(text: str) -> list[Line]:
    rows = []
    for row in text.splitlines():
        bare = re.sub(r'^((?:[^"#]|"[^"]*")*)#.*', r"\1", row).strip()
        if bare:
            rows.append(tokens_of(bare, GRAMMAR))
    found, at = _block(rows, 0, set())
    if at != len(rows):
        raise ProgramError(f"too much: {' '.join(rows[at])}")
    return found


def _block(rows: list[list[str]], at: int, ends: set[str]) -> tuple[list[Line], int]:
    found: list[Line] = []
    while at < len(rows) and rows[at][0] not in ends:
        tokens = rows[at]
        if tokens[0] in {"def", "thread", "while", "if", "sec"}:
            if tokens[-1] != ":":
                raise ProgramError(f"no colon: {' '.join(tokens)}")
            body, at = _block(rows, at + 1, {"end", "elif", "else"})
            line = Line(tokens[:-1], body, [])
            while at < len(rows) and rows[at][0] in {"elif", "else"}:
                head = rows[at][:-1]
                body, at = _block(rows, at + 1, {"end", "elif", "else"})
                line.rest.append(Line(head, body, []))
            if at >= len(rows):
                raise ProgramError(f"no end: {' '.join(tokens)}")
            found.append(line)
        else:
            found.append(Line(tokens, [], []))
        at += 1
    return found, at


class Task:
    """One thread of the program, in a thread of Python that runs only while it has its turn."""

    def __init__(self, work: Callable[[], None]) -> None:
        self.turn, self.back = threading.Semaphore(0), threading.Semaphore(0)
        self.wakes_at = 0.0
        self.waits_for: Callable[[], bool] | None = None
        self.is_over = self.is_killed = self.has_started = False
        self.error: BaseException | None = None

        def whole() -> None:
            self.turn.acquire()
            try:
                if not self.is_killed:
                    work()
            except _KilledError:
                pass
            except BaseException as error:
                self.error = error
            self.is_over = True
            self.back.release()

        self.thread = threading.Thread(target=whole, daemon=True)
        self.thread.start()

    def step(self) -> None:
        """Let it run until it waits or ends."""
        self.turn.release()
        self.back.acquire()
        if self.error is not None:
            raise self.error

    def wait(self) -> None:
        """Give the turn back, from within the task."""
        self.back.release()
        self.turn.acquire()
        if self.is_killed:
            raise _KilledError
