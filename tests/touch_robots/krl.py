"""KUKA KRL, as far as touch programs use it (System software 8.x, programming instructions for integrators).

Rules that matter here: an interrupt fires on a rising edge of its condition while it is on, in the routine that
declared it or below. `$POS_INT` is the place at that moment, in the present `$BASE` and `$TOOL`. `BRAKE` stops the
motion; without `RESUME` it goes on to its end after the interrupt routine. `RESUME` ends all routines below the level
that declared the interrupt and needs one of them to be running, with `$ADVANCE=0` or a stop of the advance run behind
the motion. Variables of a data list keep their values in the `.dat`, in single precision.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tests.touch_robots.krl_text import Routine, Statement, read_data, read_source
from tests.touch_robots.krl_values import AXES, CARTESIAN, GRAMMAR, TOKEN, Aggregate, KrlParser, frame, printed
from tests.touch_robots.robot import Array, ProgramError, Robot, Run, StoppedError, inverse

IGNORED = {
    "$VEL.CP",
    "$VEL.ORI1",
    "$VEL.ORI2",
    "$ACC.CP",
    "$ACC.ORI1",
    "$ACC.ORI2",
    "$APO.CDIS",
    "$APO.CPTP",
    "$ORI_TYPE",
}
"""Variables without an effect here; the speed of a search counts."""


@dataclass
class Interrupt:
    condition: list[str]
    call: str
    level: int
    is_on: bool = False
    is_global: bool = False


class _ResumeError(Exception):
    def __init__(self, level: int) -> None:
        self.level = level


class _ReturnError(Exception):
    pass


@dataclass
class _Call:
    routine: str
    variables: dict[str, Any] = field(default_factory=dict)


class Controller:
    """A robot interpreter with its modules; `tools` and `bases` are TOOL_DATA and BASE_DATA of the configuration."""

    def __init__(
        self,
        files: dict[str, str],
        robot: Robot,
        *,
        signal: int = 1,
        tools: dict[int, Array] | None = None,
        on_stop: Callable[[str], bool] = lambda _: False,
        level: bool = True,
    ) -> None:
        self.robot, self.input, self.on_stop, self.level, self.run = robot, signal, on_stop, level, Run()
        self.tools = {n: frame(T) for n, T in (tools or {}).items()}
        self.bases: dict[int, Aggregate] = {}
        self.system: dict[str, Any] = {"$NULLFRAME": frame(np.eye(4)), "$ADVANCE": 3}
        self.texts = {name: text for name, text in files.items() if name.lower().endswith(".dat")}
        self.data: dict[str, Any] = {}
        self.kinds: dict[str, str] = {}
        for text in self.texts.values():
            for kind, name, tokens in read_data(text, TOKEN):
                self.kinds[name] = kind
                self.data[name] = self._typed(kind, self.value(tokens)) if tokens else None
        self.routines: dict[str, Routine] = {}
        for name, text in files.items():
            if name.lower().endswith(".src"):
                self.routines.update(read_source(text, TOKEN))
        self.calls: list[_Call] = []
        self.interrupts: dict[int, Interrupt] = {}
        self.hit: Array | None = None
        self.in_handler = False
        self.is_braked = False

    # -- values ----------------------------------------------------------------------------------------------------

    def value(self, tokens: list[str]) -> Any:
        parser = KrlParser(tokens, GRAMMAR, self)
        value = parser.value()
        parser.end()
        return value

    def _typed(self, kind: str, value: Any) -> Any:
        if kind in CARTESIAN | AXES | {"LOAD", "FDAT", "PDAT", "LDAT"}:
            if not isinstance(value, Aggregate) or value.kind not in {"", kind, "FRAME"}:
                raise ProgramError(f"{value!r} is no {kind}")
            if kind in CARTESIAN:
                value.matrix()
            return Aggregate(dict(value.values), kind)
        expected: Any = {"INT": int, "REAL": (int, float), "BOOL": bool, "CHAR": str}.get(kind)
        if expected is None:
            raise ProgramError(f"the type {kind} is unknown")
        if not isinstance(value, expected) or (kind != "BOOL" and isinstance(value, bool)):
            raise ProgramError(f"{value!r} is no {kind}")
        return value

    def name(self, name: str) -> Any:
        if self.calls and name in self.calls[-1].variables:
            return self.calls[-1].variables[name]
        if name in self.data:
            if self.data[name] is None:
                raise ProgramError(f"{name} has no value")
            return self.data[name]
        if name == "$POS_INT":
            if self.hit is None:
                raise ProgramError("$POS_INT before an interrupt")
            return self._seen(self.hit)
        if name == "$POS_ACT":
            return self._seen(self.robot.reading(np.eye(4)))
        if name == "TOOL_DATA":
            return self.tools
        if name == "BASE_DATA":
            return self.bases
        if name == "$IN":
            return {self.input: self.robot.is_on() == self.level}
        if name in self.system:
            return self.system[name]
        raise ProgramError(f"{name} is not declared")

    def _seen(self, T_base_flange: Array) -> Aggregate:
        T = inverse(self._base()) @ T_base_flange @ self._tool()
        return frame(T, "E6POS", {"S": 2, "T": 2, **{f"E{i}": 0.0 for i in range(1, 7)}})

    def part(self, value: Any, name: str) -> Any:
        if not isinstance(value, Aggregate) or name.upper() not in value.values:
            raise ProgramError(f"no part {name}")
        return value.values[name.upper()]

    def item(self, value: Any, indices: list[Any]) -> Any:
        if not indices:
            return value  # a text, written with empty brackets
        if not isinstance(value, dict) or indices[0] not in value:
            raise ProgramError(f"no element {indices}")
        return value[indices[0]]

    def call(self, name: str, arguments: list[Any]) -> Any:
        if name == "INV_POS":
            return frame(inverse(arguments[0].matrix()))
        if name == "ABS":
            return abs(arguments[0])
        raise ProgramError(f"the function {name} is unknown")

    def _base(self) -> Array:
        return self._set("$BASE").matrix()

    def _tool(self) -> Array:
        return self._set("$TOOL").matrix()

    def _set(self, name: str) -> Aggregate:
        value = self.system.get(name)
        if not isinstance(value, Aggregate):
            raise ProgramError(f"a motion before {name} has a value")
        return value

    # -- running ---------------------------------------------------------------------------------------------------

    def start(self, routine: str) -> Run:
        try:
            self._routine(routine.upper(), [])
            self.run.is_finished = True
        except StoppedError:
            pass
        return self.run

    def backup(self) -> dict[str, str]:
        """Return the data lists with the present values."""
        return {name: self._saved(text) for name, text in self.texts.items()}

    def _saved(self, text: str) -> str:
        def declared(match: re.Match[str]) -> str:
            value = self.data[match["name"].upper()]
            return match[0] if value is None else f"{match['head']}={printed(value)}"

        text = re.sub(r"(?m)^(?P<head>\s*DECL\s+\w+\s+(?P<name>\w+))\s*=[^\r\n]*", declared, text)
        return re.sub(r'(?m)^(?P<head>\s*(?P<name>\w+)\[\])\s*="[^"]*"', declared, text)

    def _routine(self, name: str, arguments: list[Any]) -> None:
        routine = self.routines.get(name)
        if routine is None:
            raise ProgramError(f"the instruction or routine {name} is unknown")
        if len(arguments) != len(routine.parameters):
            raise ProgramError(f"{name} takes {len(routine.parameters)} arguments")
        self.calls.append(_Call(name, dict(zip(routine.parameters, arguments, strict=True))))
        level = len(self.calls)
        try:
            self.block(routine.body)
        except _ReturnError:
            pass
        finally:
            del self.calls[level - 1 :]
            for number in [n for n, one in self.interrupts.items() if one.level > len(self.calls)]:
                del self.interrupts[number]

    def block(self, statements: list[Statement]) -> None:
        for at, statement in enumerate(statements):
            try:
                self.next = statements[at + 1] if at + 1 < len(statements) else None
                self.execute(statement)
            except _ResumeError as resume:
                if resume.level != len(self.calls):
                    raise
                self.in_handler = False

    def execute(self, statement: Statement) -> None:
        function = getattr(self, f"_do_{statement.word.lower()}", None)
        if function is None:
            raise ProgramError(f"{statement.word} {' '.join(statement.tokens)} is unknown")
        function(statement)

    def _do_if(self, s: Statement) -> None:
        self.block(s.blocks[0] if self.value(s.tokens) else s.blocks[1])

    def _do_for(self, s: Statement) -> None:
        variable, first, last = s.parts
        for number in range(self.value(first), self.value(last) + 1):
            self._assign(variable, number)
            self.block(s.blocks[0])

    def _do_while(self, s: Statement) -> None:
        while self.value(s.tokens):
            self.block(s.blocks[0])

    def _do_switch(self, s: Statement) -> None:
        found = self.value(s.tokens)
        for values, body in zip(s.parts, s.blocks, strict=True):
            if not values or found in self._list(values):
                self.block(body)
                return

    def _list(self, tokens: list[str]) -> list[Any]:
        return KrlParser([*tokens, ")"], GRAMMAR, self).values(")")

    def _do_decl(self, s: Statement) -> None:
        for name in s.parts[0]:
            self.calls[-1].variables.setdefault(name.upper(), None)
            self.kinds.setdefault(name.upper(), s.tokens[0].upper())

    def _do_assign(self, s: Statement) -> None:
        self._assign(s.parts[0], self.value(s.parts[1]))

    def _assign(self, left: list[str], value: Any) -> None:
        name = left[0].upper()
        whole = "".join(left).upper()
        if whole in IGNORED:
            self.system[whole] = value
        elif name in {"$BASE", "$TOOL", "$LOAD", "$ADVANCE", "$IPO_MODE", "$CIRC_TYPE"} and len(left) == 1:
            self.system[name] = value
        elif name in {"TOOL_DATA", "BASE_DATA"} and left[1] == "[":
            (self.tools if name == "TOOL_DATA" else self.bases)[self.value(left[2:-1])] = value
        elif name == "$OUT" and left[1] == "[":
            self.run.outputs[f"OUT{self.value(left[2:-1])}"] = value
        elif self.calls and name in self.calls[-1].variables:
            self.calls[-1].variables[name] = self._typed(self.kinds.get(name, "INT"), value)
        elif name in self.data:
            if len(left) == 1 or left[1:] == ["[", "]"]:
                self.data[name] = self._typed(self.kinds[name], value)
            elif left[1] == "." and isinstance(self.data[name], Aggregate):
                if left[2].upper() not in self.data[name].values:
                    raise ProgramError(f"{name} has no part {left[2]}")
                self.data[name].values[left[2].upper()] = value
            else:
                raise ProgramError(f"cannot be assigned: {whole}")
        else:
            raise ProgramError(f"{whole} is not declared")

    # -- instructions ----------------------------------------------------------------------------------------------

    def _do_call(self, s: Statement) -> None:
        name, arguments = s.tokens[0].upper(), self._list(s.parts[0])
        if name == "BAS":
            if arguments[0] == "#INITMOV":
                self.system.update({"$BASE": frame(np.eye(4)), "$TOOL": frame(np.eye(4)), "$ADVANCE": 3})
            elif arguments[0] not in {"#VEL_CP", "#VEL_PTP", "#ACC_CP", "#ACC_PTP"}:
                raise ProgramError(f"BAS({arguments[0]}) is unknown")
        elif name in {"MSGNOTIFY", "MSGQUIT"}:
            self.run.messages.append(str(arguments[0]))
        else:
            self._routine(name, arguments)

    def _do_interrupt(self, s: Statement) -> None:
        words = [token.upper() for token in s.tokens]
        if "DECL" in words:
            when, do = words.index("WHEN"), words.index("DO")
            number = self.value(s.tokens[words.index("DECL") + 1 : when])
            is_global = words[0] == "GLOBAL"
            self.interrupts[number] = Interrupt(
                s.tokens[when + 1 : do], words[do + 1], len(self.calls), is_global=is_global
            )
            return
        if words[1] not in {"ON", "OFF"}:
            raise ProgramError(f"{' '.join(words)} is unknown")
        for number in [self.value(s.tokens[2:])] if len(words) > 2 else list(self.interrupts):
            if number not in self.interrupts:
                raise ProgramError(f"the interrupt {number} is not declared")
            self.interrupts[number].is_on = words[1] == "ON"

    def _do_brake(self, s: Statement) -> None:
        if not self.in_handler:
            raise ProgramError("BRAKE outside an interrupt routine")
        self.is_braked = True

    def _do_resume(self, s: Statement) -> None:
        if not self.in_handler:
            raise ProgramError("RESUME outside an interrupt routine")
        raise _ResumeError(self.running.level)

    def _do_return(self, s: Statement) -> None:
        raise _ReturnError

    def _do_halt(self, s: Statement) -> None:
        self.run.stop(self.run.messages[-1] if self.run.messages else "HALT", self.on_stop)

    def _do_wait(self, s: Statement) -> None:
        if s.tokens[0].upper() == "SEC":
            self.value(s.tokens[1:])
        elif s.tokens[0].upper() == "FOR":
            if not self.value(s.tokens[1:]):
                self.run.stop(f"WAIT {' '.join(s.tokens)}", self.on_stop)
        else:
            raise ProgramError(f"WAIT {s.tokens} is unknown")

    def _do_ptp(self, s: Statement) -> None:
        goal = self._goal(s)
        if goal is None:
            self.robot.joint_move()
        else:
            self._travel(goal, is_line=False)

    def _do_lin(self, s: Statement) -> None:
        goal = self._goal(s)
        if goal is None:
            raise ProgramError("LIN to joint angles")
        self._travel(goal, is_line=True)

    def _goal(self, s: Statement) -> Array | None:
        tokens = s.tokens[:-1] if s.tokens[-1].upper() in {"C_DIS", "C_PTP", "C_VEL", "C_ORI"} else s.tokens
        target = self.value(tokens)
        if not isinstance(target, Aggregate):
            raise ProgramError(f"{' '.join(tokens)} is no point")
        return None if "A1" in target.values else self._base() @ target.matrix()

    def _travel(self, goal: Array, *, is_line: bool) -> None:
        T_tool = self._tool()
        armed = [one for one in self.interrupts.values() if one.is_on and "$IN" in (t.upper() for t in one.condition)]
        if not armed:
            self.robot.move(goal, T_tool, is_line=is_line)
            return
        (interrupt,) = armed
        if not is_line:
            raise ProgramError("a search on a PTP motion")
        speed = self.system.get("$VEL.CP")
        if speed is None:
            raise ProgramError("a search without $VEL.CP")
        was_on = self.value(interrupt.condition)
        hit = None if was_on and self.robot.senses.always_on else self.robot.search(goal, T_tool, 1000.0 * speed)
        if was_on and not self.robot.senses.always_on:
            raise ProgramError("a search begins in contact")
        if hit is None:
            if was_on:  # no edge comes: the arm goes on to the end of the stroke
                self.robot.move(goal, T_tool)
            return
        if self.system["$ADVANCE"] and (self.next is None or self.next.word != "WAIT"):
            raise ProgramError("RESUME with an advance run: neither $ADVANCE=0 nor a WAIT behind the motion")
        self.hit = hit @ inverse(T_tool)
        self.running, self.in_handler, self.is_braked = interrupt, True, False
        follows, depth = self.next, len(self.calls)
        self._routine(interrupt.call, [])
        if not self.is_braked:
            raise ProgramError("an interrupt routine without BRAKE: the motion goes on through the part")
        raise ProgramError(f"the motion goes on after the interrupt: no RESUME (depth {depth}, next {follows})")
