"""URScript (``.script``): what a program does.

A motion blocks its own thread, and `kill` ends a thread at once; the robot then stops with `stopl`. Here a thread runs
when it is started, until its first motion meets the part: then the input is on, `get_actual_tcp_pose` is the pose at
contact, and the rest of the thread waits for the end of the motion, which must not come. `get_actual_tcp_pose` is the
pose in the base with the tool of `set_tcp`; lengths in m, rotation vectors.

References: Universal Robots, The URScript Programming Language (e-Series).
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.blocks import BlockInterpreter, LeaveError, Node, Steps, rows_of, text_of, tree
from wpcal.controllers.run.expressions import LIKE_C, SIGNS, Parser, Syntax
from wpcal.controllers.run.machine import ProgramError, StoppedError, rigid
from wpcal.controllers.ur.grammar import GRAMMAR
from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import inverse_pose
from wpcal.core.tangent import exp_rotation, log_rotation

MM_PER_M = 1000.0
TOKEN = re.compile(r'"[^"]*"|\d+(?:\.\d+)?(?:[eE][-+]?\d+)?|\.\d+|[A-Za-z_]\w*|==|!=|<=|>=|[-+*/%=<>()\[\],:]')
WORDS = Syntax(
    TOKEN,
    LIKE_C,
    {**SIGNS, "not": operator.not_},
    {"True": True, "False": False},
    aggregate=("[", "]"),
    index=("[", "]"),
    is_upper=False,
)
HARMLESS = ("sync", "sleep", "set_payload", "socket_open", "socket_close", "socket_send_line", "set_gravity")
"""Functions that move nothing and whose arguments do not matter."""
BLOCK = r"(?:def|thread|while|if|sec)(?![^\s(]).*:$"


class _Pose(list[Any]):
    """`p[x,y,z,rx,ry,rz]`, m and rad."""


def _matrix(pose: Any) -> FloatArray:
    """Return a pose as a matrix, mm."""
    if not isinstance(pose, _Pose) or len(pose) != 6:
        raise ProgramError(f"{str(pose)[:60]} is not a pose")
    return rigid(exp_rotation(np.array(pose[3:], dtype=np.float64)), MM_PER_M * np.array(pose[:3], dtype=np.float64))


def _pose_of(T: FloatArray) -> _Pose:
    return _Pose(float(v) for v in (*(T[:3, 3] / MM_PER_M), *log_rotation(T[:3, :3])))


def _shown(value: Any) -> str:
    """Return a value as the log shows it."""
    if isinstance(value, (bool, str)):
        return str(value)
    if isinstance(value, list):
        return ("p[" if isinstance(value, _Pose) else "[") + ", ".join(_shown(v) for v in value) + "]"
    return f"{value + 0.0:.6g}"


class UrParser(Parser):
    """Knows poses and named arguments."""

    def named(self) -> str | None:
        """Take the name of an argument."""
        if self.tokens[self.at + 1 : self.at + 2] != ["="]:
            return None
        name, _ = self.take(), self.take("=")
        return name

    def primary(self) -> Any:
        """Return a pose, or what all languages have."""
        if self.peek() == "p" and self.tokens[self.at + 1 : self.at + 2] == ["["]:
            self.take()
            self.take("[")
            return _Pose(self.values("]"))
        return super().primary()


@dataclass
class _Thread:
    is_over: bool = False


class ContactError(Exception):
    """A motion of a thread has met the part: its thread waits."""


class Interpreter(BlockInterpreter):
    """Runs a script."""

    grammar, words, COMMENT, PARSER = GRAMMAR, WORDS, "#", UrParser
    ARCS: Mapping[str, Does] = {"arc_start": Does.ON, "arc_end": Does.OFF}

    def __init__(self, files: Mapping[str, str], *args: Any, **given: Any) -> None:
        self.outside: list[tuple[str, Node]] = []
        self.threads: dict[str, Steps] = {}
        self.hit: FloatArray | None = None
        self.in_thread = False
        self.log: list[str] = []
        super().__init__(files, *args, **given)
        self.tool = next(iter(self.tools), "")

    def load(self, file: str, text: str) -> None:
        for node in tree(rows_of(text, "#"), file, begins=BLOCK, turns="ELIF ELSE", ends="END"):
            if node.branches and node.text.split()[0] in {"def", "thread", "sec"}:
                self._define(file, node)
            else:
                self.outside.append((file, node))

    def _define(self, file: str, node: Node) -> None:
        found = re.fullmatch(r"(def|thread|sec)\s+(\w+)\s*\(([^()]*)\)\s*:", node.text)
        if found is None:
            raise ProgramError(f"{node.text[:60]!r} does not begin a function", path=file, line=node.line)
        names = [name.strip() for name in found[3].split(",") if name.strip()]
        known = self.threads if found[1] == "thread" else self.routines
        known[found[2]] = Steps(file, names, node.branches[0][1], node.line)

    def signals_of(self, text: str) -> dict[str, bool]:
        found = re.findall(r"get_standard_digital_in\((\d{1,3}+)\) == (True|False)", text)
        return {number: level == "True" for number, level in found} if self.threads or "thread" in text else {}

    # -- running ---------------------------------------------------------------------------------------------------

    def bodies(self) -> Mapping[str, str]:
        """Return the functions that take no values, and what is outside of them, without a name."""
        outside = text_of([node for _, node in self.outside if not node.text.startswith("#")])
        return {**super().bodies(), **({"": outside} if outside else {})}

    def steps_of(self) -> Iterable[Steps]:
        return [*self.routines.values(), *self.threads.values()]

    def routine(self, name: str, arguments: Sequence[Any] = ()) -> Any:
        """Run a function; without a name the first one, or what is outside of functions."""
        if name or not self.routines:
            return super().routine(name, arguments)
        if not any(not node.text.startswith("#") for _, node in self.outside):
            return super().routine(next(iter(self.routines)))
        for file, node in self.outside:
            self.file = file
            self.block([node])
        return None

    def call(self, name: str, arguments: list[Any]) -> Any:
        return True if name in HARMLESS else super().call(name, arguments)

    def statement(self, word: str, tokens: list[str], node: Node) -> None:
        if word in {"def", "thread"}:
            self._define(self.file, node)
        elif word == "halt":
            raise StoppedError("halt")
        elif word in {"kill", "join"}:
            self._end_thread(word, self.value(tokens[1:]))
        elif word in {"global", "local"} or (len(tokens) > 1 and "=" in tokens and tokens[1] in {"=", "["}):
            self._assign(tokens)
        elif tokens[1:2] == ["("]:
            self.value(tokens)
        else:
            self.unknown(node.text)

    def _assign(self, tokens: list[str]) -> None:
        word = tokens[0] if tokens[0] in {"global", "local"} else ""
        tokens = tokens[1:] if word else tokens
        if "=" not in tokens:
            raise ProgramError(f"not followed: {' '.join(tokens)}")
        equals, name = tokens.index("="), tokens[0]
        right = tokens[equals + 1 :]
        value = self._thread(right[1]) if right[:1] == ["run"] else self.value(right)
        if tokens[1] == "[":
            self._set_element(name, self.value(tokens[2 : equals - 1]), value)
            return
        self._scope(word, name)[name] = type(value)(value) if isinstance(value, list) else value  # a list is copied

    def _scope(self, word: str, name: str) -> dict[str, Any]:
        """Return the variables among which a name is, or becomes, one."""
        is_outer = name not in self.locals[-1] and (name in self.values or len(self.locals) <= 2)
        return self.values if word == "global" or (not word and is_outer) else self.locals[-1]

    def _set_element(self, name: str, at: Any, value: Any) -> None:
        kept = self.name(name)
        if not isinstance(kept, list) or at not in range(len(kept)):
            raise ProgramError(f"no element {at} of {name}")
        kept[at] = value

    # -- threads ---------------------------------------------------------------------------------------------------

    def _thread(self, name: str) -> _Thread:
        routine = self.threads.get(name)
        if routine is None:
            raise ProgramError(f"{name} is not a thread")
        if self.in_thread:
            raise ProgramError("a thread starts another")
        thread, self.in_thread = _Thread(), True
        before, self.file = self.file, routine.file
        self.calls += 1
        self.locals.append({})
        try:
            self.block(routine.body)
            thread.is_over = True
        except LeaveError:
            thread.is_over = True
        except ContactError:
            pass
        self.locals.pop()
        self.calls -= 1
        self.in_thread, self.file = False, before
        return thread

    def _end_thread(self, word: str, thread: Any) -> None:
        if not isinstance(thread, _Thread):
            raise ProgramError(f"{word}: not a thread")
        if word == "join" and not thread.is_over:
            raise ProgramError("join: nothing stops the motion of the thread, which is in contact")
        thread.is_over = True

    # -- moves -----------------------------------------------------------------------------------------------------

    def _stands(self) -> None:
        if self.hit is not None:
            raise ProgramError("a motion before the one in contact was stopped")

    def _movel(self, goal: Any, a: float = 1.2, v: float = 0.25, t: float = 0.0, r: float = 0.0) -> None:
        """Move on a line; a line of a thread is a search."""
        del a
        self._stands()
        T = self._line_to(goal)
        if not self.in_thread:
            self.go("L", T, speed_mm_s=None if t else MM_PER_M * v, zone_mm=_zone_mm(r))
            return
        if r or t:
            raise ProgramError("a search with a blend radius or a time")
        self.hit = self.machine.search(T, self.T_tool(), MM_PER_M * v)
        if self.hit is not None:
            raise ContactError

    def _line_to(self, goal: Any) -> FloatArray:
        if not isinstance(goal, _Pose):
            raise ProgramError("a line to joint angles")
        return _matrix(goal)

    def _movec(self, via: Any, to: Any, a: float = 1.2, v: float = 0.25, r: float = 0.0, mode: int = 0) -> None:
        del a
        self._stands()
        if mode or self.in_thread:
            raise ProgramError("movec with mode 1 or in a thread")
        self.go("C", self._line_to(to), via=self._line_to(via), speed_mm_s=MM_PER_M * v, zone_mm=_zone_mm(r))

    def _movej(self, goal: Any, a: float = 1.4, v: float = 1.05, t: float = 0.0, r: float = 0.0) -> None:
        del a, v, t
        self._stands()
        if self.in_thread:
            raise ProgramError("movej in a thread")
        if isinstance(goal, _Pose):
            self.go("J", _matrix(goal), zone_mm=_zone_mm(r))
        elif isinstance(goal, list) and len(goal) == 6:
            self.blend(_zone_mm(r))
            self.machine.joint_move(np.degrees(np.array(goal, dtype=np.float64)))
        else:
            raise ProgramError("movej to neither a pose nor six joints")

    def _stop(self, a: float = 1.2, a_turn: float = 1.2) -> None:
        del a, a_turn
        self.hit = None

    # -- functions -------------------------------------------------------------------------------------------------

    def _pose(self) -> _Pose:
        """Return where the tool is, at contact where it is in contact."""
        return _pose_of(self.machine.reading(self.T_tool()) if self.hit is None else self.hit)

    def _digital_in(self, number: int) -> bool:
        name = str(number)
        return self.signals[name] if self.hit is not None and name in self.signals else self.is_on(name)

    def _digital_out(self, number: int, value: bool) -> None:
        self.output("DO", number, on=value)

    def _set_tcp(self, pose: Any) -> None:
        self.tool = "set_tcp"
        self.tools[self.tool] = _matrix(pose)

    def _pose_add(self, a: Any, b: Any) -> _Pose:
        """Add places, and compose turns."""
        A, B = _matrix(a), _matrix(b)
        T = A @ B
        T[:3, 3] = A[:3, 3] + B[:3, 3]
        return _pose_of(T)

    def _textmsg(self, first: Any, second: Any = "") -> None:
        text = _shown(first) + _shown(second)
        self.run.messages.append(text)
        self.log.append(text)

    def _popup(
        self, text: str, title: str = "", warning: Any = False, error: Any = False, blocking: Any = False
    ) -> None:
        del title, warning, error
        self.run.messages.append(text)
        if blocking:
            self.stop(text)

    FUNCTIONS: Mapping[str, Callable[..., Any]] = {
        "movel": _movel,
        "movep": _movel,
        "movec": _movec,
        "movej": _movej,
        "stopl": _stop,
        "stopj": _stop,
        "is_steady": lambda self: self.hit is None,
        "get_actual_tcp_pose": _pose,
        "get_standard_digital_in": _digital_in,
        "get_digital_in": _digital_in,
        "set_standard_digital_out": _digital_out,
        "set_digital_out": _digital_out,
        "set_tcp": _set_tcp,
        "get_tcp_offset": lambda self: _pose_of(self.T_tool()),
        "pose_trans": lambda _, a, b: _pose_of(_matrix(a) @ _matrix(b)),
        "pose_add": _pose_add,
        "pose_inv": lambda _, a: _pose_of(inverse_pose(_matrix(a))),
        "d2r": lambda _, degrees: float(np.radians(degrees)),
        "norm": lambda _, value: float(np.linalg.norm(value)),
        "textmsg": _textmsg,
        "to_str": lambda _, value: _shown(value),
        "str_cat": lambda _, first, second: _shown(first) + _shown(second),
        "popup": _popup,
    }


def _zone_mm(r: float) -> float | None:
    return MM_PER_M * r if r else None
