"""URScript, as far as touch programs use it (The URScript programming language, e-Series).

Rules that matter here: threads run side by side; a motion blocks its own thread, and `kill` ends a thread at once, so a
motion of a killed thread goes on only until `stopl` or the next motion. `get_actual_tcp_pose()` is the pose in the base
at the moment of the call, with the tool of `set_tcp`; lengths in m, rotation vectors. `sync()` ends the time slice of a
thread. `textmsg` writes one line of the log, numbers with six digits.

Time stands still while a thread computes. A thread that only waits for a signal wakes at the moment of the contact, so
that what it costs to ask every 2 ms is not in the results unless `cycle_s` says so.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.touch_robots.robot import Array, CrashError, Hit, Robot
from tests.touch_robots.urscript_text import GRAMMAR, Line, Pose, Task, UrParser, lines_of, matrix, pose_of, printed
from wpcal.controllers.run.machine import inverted
from wpcal.controllers.run.program import ProgramError, Run, StoppedError

CYCLE_S = 0.002  #: Of the controller.
INSTANT_S = 1e-9  #: Times that differ by less are the same.
MOST_OVERSHOOT_MM = 3.0  #: The wire bends that far; then the robot stops with a protective stop.


class _ReturnError(Exception):
    def __init__(self, value: Any) -> None:
        self.value = value


class _BreakError(Exception):
    pass


@dataclass
class _Motion:
    begin: Array
    goal: Array
    T_tool: Array
    speed: float
    from_s: float
    until_s: float
    contact_s: float
    is_search: bool


class Controller:
    """A controller that runs one script; `signal` is the standard digital input of the touch."""

    def __init__(
        self,
        files: dict[str, str],
        robot: Robot,
        *,
        signal: int = 0,
        tools: dict[Any, Array] | None = None,
        on_stop: Callable[[str], bool] = lambda _: False,
        level: bool = True,
        cycle_s: float = 0.0,
    ) -> None:
        self.robot, self.input, self.on_stop, self.level, self.run = robot, signal, on_stop, level, Run()
        (text,) = files.values()
        self.lines = lines_of(text)
        self.functions: dict[str, Line] = {}
        self.variables: dict[str, Any] = {}
        self.scopes: dict[Task, list[dict[str, Any]]] = {}
        self.T_tool = next(iter((tools or {"": np.eye(4)}).values()))
        self.cycle_s, self.now = cycle_s, 0.0
        self.tasks: list[Task] = []
        self.task: Task | None = None
        self.motion: _Motion | None = None
        self.log: list[str] = []

    # -- tasks -----------------------------------------------------------------------------------------------------

    def start(self, name: str = "") -> Run:
        """Run the script: its only function, or what stands outside functions."""
        del name
        outside = [line for line in self.lines if line.tokens[0] not in {"def", "thread", "sec"}]
        for line in self.lines:
            if line not in outside:
                self.functions[line.tokens[1]] = line
        whole = next(line for line in self.lines if line.tokens[0] == "def")
        main = self._task(lambda: self.block(outside) if outside else self.block(whole.body))
        try:
            while not main.is_over:
                self._turn()
            self.run.is_finished = True
        except StoppedError:
            pass
        finally:
            for task in self.tasks:
                task.is_killed = True
                if not task.is_over:
                    task.turn.release()
        self.run.files["log.txt"] = "".join(f"{row}\n" for row in self.log)
        return self.run

    def _task(self, work: Callable[[], None]) -> Task:
        task = Task(work)
        self.tasks.append(task)
        self.scopes[task] = [{}]
        return task

    def _turn(self) -> None:
        alive = [task for task in self.tasks if not task.is_over]
        ready = [t for t in alive if t.wakes_at <= self.now and (t.waits_for is None or t.waits_for())]
        if not ready:
            times = [t.wakes_at for t in alive if t.wakes_at > self.now]
            if self.motion is not None:
                times += [t for t in (self.motion.until_s, self._seen_s()) if t > self.now]
            if not times:
                raise ProgramError("all threads wait for each other")
            self._advance(min(times))
            return
        for task in ready:
            if not task.is_over:
                self.task, task.waits_for = task, None
                task.step()

    def _advance(self, to: float) -> None:
        self.now = to
        motion = self.motion
        if motion is None:
            return
        beyond = (min(self.now, motion.until_s) - motion.contact_s) * motion.speed
        if beyond > MOST_OVERSHOOT_MM:
            raise CrashError("the wire is pressed into the part: nothing stopped the motion")

    def _wait(self, seconds: float = 0.0, until: Callable[[], bool] | None = None) -> None:
        assert self.task is not None
        self.task.wakes_at, self.task.waits_for = self.now + seconds, until
        self.task.wait()

    def _seen_s(self) -> float:
        """Return when the input shows the contact of the present motion."""
        return np.inf if self.motion is None else self.motion.contact_s + self.robot.senses.latency_s

    # -- names -----------------------------------------------------------------------------------------------------

    def _local(self) -> dict[str, Any]:
        assert self.task is not None
        return self.scopes[self.task][-1]

    def name(self, name: str) -> Any:
        for scope in (self._local(), self.variables):
            if name in scope:
                return scope[name]
        raise ProgramError(f"{name} has no value")

    def part(self, value: Any, name: str) -> Any:
        raise ProgramError(f"{value!r}.{name} is unknown")

    def item(self, value: Any, indices: list[Any]) -> Any:
        return value[indices[0]]

    def value(self, tokens: list[str]) -> Any:
        parser = UrParser(tokens, GRAMMAR, self)
        value = parser.value()
        parser.end()
        return value

    def call(self, name: str, arguments: list[Any]) -> Any:
        if name in self.functions:
            return self._function(name, arguments)
        function = getattr(self, f"_do_{name}", None)
        if function is None:
            raise ProgramError(f"{name} is unknown")
        named = arguments.pop() if arguments and isinstance(arguments[-1], dict) else {}
        return function(*arguments, **named)

    def _function(self, name: str, arguments: list[Any]) -> Any:
        assert self.task is not None
        line = self.functions[name]
        inside = line.tokens[line.tokens.index("(") + 1 : -1]
        names = [token for token in inside if token != ","]
        if len(names) != len(arguments):
            raise ProgramError(f"{name} takes {len(names)} arguments")
        self.scopes[self.task].append(dict(zip(names, arguments, strict=True)))
        try:
            self.block(line.body)
        except _ReturnError as found:
            return found.value
        finally:
            self.scopes[self.task].pop()
        return None

    # -- statements ------------------------------------------------------------------------------------------------

    def block(self, lines: list[Line]) -> None:
        for line in lines:
            self.execute(line)

    def execute(self, line: Line) -> None:
        tokens, word = line.tokens, line.tokens[0]
        if word in {"def", "thread"}:
            self.functions[tokens[1]] = line
        elif word == "if":
            for branch in (line, *line.rest):
                if branch.tokens[0] == "else" or self.value(branch.tokens[1:]):
                    self.block(branch.body)
                    return
        elif word == "while":
            try:
                while self.value(tokens[1:]):
                    self.block(line.body)
            except _BreakError:
                pass
        elif word == "return":
            raise _ReturnError(self.value(tokens[1:]) if len(tokens) > 1 else None)
        elif word == "break":
            raise _BreakError
        elif word == "halt":
            raise StoppedError("halt")
        elif word in {"kill", "join"}:
            self._end_task(word, self.value(tokens[1:]))
        elif word in {"global", "local"} or (len(tokens) > 1 and "=" in tokens and tokens[1] in {"=", "["}):
            self._assign(tokens)
        elif tokens[1:2] == ["("]:
            self.value(tokens)
        else:
            raise ProgramError(f"unknown: {' '.join(tokens)}")

    def _assign(self, tokens: list[str]) -> None:
        scope = None
        if tokens[0] in {"global", "local"}:
            scope, tokens = (self.variables if tokens[0] == "global" else self._local()), tokens[1:]
        equals = tokens.index("=")
        right = tokens[equals + 1 :]
        if right[0] == "run":
            name = right[1]
            value: Any = self._task(lambda: self._thread(name))
        else:
            value = self.value(right)
        if tokens[1] == "[":
            self.name(tokens[0])[self.value(tokens[2 : equals - 1])] = value
            return
        if scope is None:
            assert self.task is not None
            outer = tokens[0] in self.variables and tokens[0] not in self._local()
            scope = self.variables if outer else self._local()
            if len(self.scopes[self.task]) == 1 and not outer:
                scope = self.variables
        scope[tokens[0]] = value

    def _thread(self, name: str) -> None:
        line = self.functions[name]
        if line.tokens[0] != "thread":
            raise ProgramError(f"{name} is no thread")
        with suppress(_ReturnError):
            self.block(line.body)

    def _end_task(self, word: str, task: Any) -> None:
        if not isinstance(task, Task):
            raise ProgramError(f"{word}: no thread")
        if word == "join":
            self._wait(until=lambda: task.is_over)
        elif not task.is_over:
            task.is_killed = True
            task.waits_for, task.wakes_at = None, 0.0

    # -- motion ----------------------------------------------------------------------------------------------------

    def _do_movel(self, goal: Any, a: float = 1.2, v: float = 0.25, t: float = 0.0, r: float = 0.0) -> None:
        del a
        if r and self.task is not self.tasks[0]:
            raise ProgramError("a search with a blend radius")
        if t:
            raise ProgramError("movel with a time")
        T_goal = matrix(goal)
        if self.task is self.tasks[0]:
            self._settle(is_killed=False)
            self.robot.move(T_goal, self.T_tool)
            return
        self._begin(T_goal, 1000.0 * v)
        motion = self.motion
        self._wait(until=lambda: self.motion is not motion or self.now >= motion.until_s)
        self._settle(is_killed=False)

    def _do_movej(self, goal: Any, a: float = 1.4, v: float = 1.05, t: float = 0.0, r: float = 0.0) -> None:
        del a, v, t, r
        self._settle(is_killed=False)
        if isinstance(goal, Pose):
            self.robot.move(matrix(goal), self.T_tool, is_line=False)
        else:
            self.robot.joint_move()

    def _begin(self, T_goal: Array, speed: float) -> None:
        begin = self.robot.T_base_tool(self.T_tool)
        way = float(np.linalg.norm((T_goal - begin)[:3, 3]))
        contact = np.inf
        if not (self.robot.senses.never_on or self.robot.senses.always_on):
            goal_flange = T_goal @ inverted(self.T_tool)
            assert self.robot.T_base_flange is not None
            at = self.robot.contact(self.robot.T_base_flange, goal_flange)
            if at is not None:
                self.robot.hits.append(Hit(at @ self.T_tool, None))
                contact = self.now + float(np.linalg.norm((at - self.robot.T_base_flange)[:3, 3])) / speed
        until = self.now + way / speed
        self.motion = _Motion(begin, T_goal, self.T_tool, speed, self.now, until, contact, is_search=True)

    def _present(self) -> Array:
        """Return the pose of the tool now."""
        motion = self.motion
        if motion is None:
            return self.robot.T_base_tool(self.T_tool)
        share = min(1.0, (self.now - motion.from_s) / (motion.until_s - motion.from_s))
        T = motion.begin.copy()
        T[:3, 3] += share * (motion.goal - motion.begin)[:3, 3]
        return T

    def _settle(self, *, is_killed: bool) -> None:
        """The robot stands: where it is now, and after braking where it was stopped."""
        motion, self.motion, T = self.motion, None, self._present()
        if motion is None:
            return
        if is_killed and self.now < motion.until_s:
            along = (motion.goal - motion.begin)[:3, 3] / max(np.linalg.norm((motion.goal - motion.begin)[:3, 3]), 1e-9)
            T[:3, 3] += along * motion.speed * self.robot.senses.stop_s * 0.5
        self.robot.T_base_flange = T @ inverted(motion.T_tool)

    def _do_stopl(self, a: float = 1.2, a_turn: float = 1.2) -> None:
        del a, a_turn
        self._settle(is_killed=True)

    _do_stopj = _do_stopl

    def _do_is_steady(self) -> bool:
        return self.motion is None

    def _do_get_actual_tcp_pose(self) -> Pose:
        T = self._present().copy()
        if self.robot.senses.sigma_mm:
            T[:3, 3] += self.robot.senses.rng.normal(scale=self.robot.senses.sigma_mm, size=3)
        return pose_of(T)

    # -- the rest --------------------------------------------------------------------------------------------------

    def _do_get_standard_digital_in(self, number: int) -> bool:
        if number != self.input:
            raise ProgramError(f"the input {number} is not connected")
        if self.motion is not None and not self.robot.senses.always_on:
            is_on = self.now >= self._seen_s() - INSTANT_S
        else:
            is_on = self.robot.is_on()
        return is_on == self.level

    def _do_set_standard_digital_out(self, number: int, value: bool) -> None:
        self.run.outputs[f"DO{number}"] = value

    def _do_sync(self) -> None:
        event = -1.0 if self.motion is None else min(self.motion.until_s, self._seen_s())
        self._wait(event - self.now if event > self.now + INSTANT_S and not self.cycle_s else self.cycle_s or CYCLE_S)

    def _do_sleep(self, seconds: float) -> None:
        self._wait(seconds)

    def _do_set_tcp(self, pose: Any) -> None:
        self.T_tool = matrix(pose)

    def _do_set_payload(self, *values: Any) -> None:
        pass

    def _do_get_tcp_offset(self) -> Pose:
        return pose_of(self.T_tool)

    def _do_pose_trans(self, a: Any, b: Any) -> Pose:
        return pose_of(matrix(a) @ matrix(b))

    def _do_pose_inv(self, a: Any) -> Pose:
        return pose_of(inverted(matrix(a)))

    def _do_textmsg(self, first: Any, second: Any = "") -> None:
        text = printed(first) + printed(second)
        self.run.messages.append(text)
        self.log.append(f"2026-11-22 14:00:00.000 PolyScope: {text}")

    def _do_to_str(self, value: Any) -> str:
        return printed(value)

    def _do_str_cat(self, first: Any, second: Any) -> str:
        return printed(first) + printed(second)

    def _do_norm(self, value: Any) -> float:
        return abs(value) if isinstance(value, (int, float)) else float(np.linalg.norm(value))

    def _do_popup(
        self, text: str, title: str = "", warning: Any = False, error: Any = False, blocking: Any = False
    ) -> None:
        self.run.messages.append(text)
        if blocking:
            self.run.stop(text, self.on_stop)
