"""Execution of KUKA KRL (System software 8.x, programming instructions for integrators).

Rules that matter here: an interrupt fires on a rising edge of its condition while it is on, in the routine that
declared it or below. `$POS_INT` is the place at that moment, in the present `$BASE` and `$TOOL`. `BRAKE` stops the
motion; without `RESUME` it goes on to its end after the interrupt routine. `RESUME` ends all routines below the level
that declared the interrupt and needs one of them to be running, with `$ADVANCE=0` or a stop of the advance run behind
the motion. Variables of a data list keep their values in the `.dat`, in single precision. A point without a coordinate
takes that of the present place. In the folds of ArcTech, `BAS(#CP_PARAMS,…)` takes tool and base of `FDAT_ACT`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.controllers.kuka.statements import KrlRoutine, KrlStatement, called_in, read_data, read_source
from wpcal.controllers.kuka.values import AXES, CARTESIAN, GRAMMAR, Aggregate, KrlParser, frame_value, krl_text
from wpcal.controllers.language.grammar import Does, mark_of
from wpcal.controllers.run.blocks import BreakError, LeaveError
from wpcal.controllers.run.machine import WHOLE_ZONE, Machine, Place
from wpcal.controllers.run.program import MOST_ELEMENTS, ProgramError, Run, StoppedError, entries_of
from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import inverse_pose

IGNORED = re.compile(
    r"\$(?:VEL|ACC|VEL_AXIS|ACC_AXIS|APO|ORI_TYPE|CIRC_TYPE|BWDSTART|LOAD|ADVANCE|IPO_MODE|TIMER|CMD)\b.*|[LF]DAT_ACT"
)
"""System variables that do not change where a motion ends; their values are kept."""
HARMLESS = re.compile(
    r"(?:TRIGGER WHEN .*\bDO (?:ArcMainNG\([^()]*\)|\$OUT\[\d+\] ?= ?\w+)(?: PRIO ?= ?-?\d+)?|SET_CD_PARAMS\(0\)"
    r"|PULSE\([^()]*\)|CONTINUE)",
    re.IGNORECASE,
)
"""Statements without effect on motion."""
BLENDS = {"C_DIS", "C_PTP", "C_VEL", "C_ORI", "C_SPL"}
PLACES = tuple("XYZABC")
JOINTS = tuple(f"A{axis}" for axis in range(1, 7))
EXTERNAL = tuple(f"E{axis}" for axis in range(1, 7))
ARC = {"#ARCONBEFOREMOVESTD": Does.ON, "#ARCOFFAFTERMOVESTD": Does.OFF}
KINDS: dict[str, Any] = {"INT": int, "REAL": (int, float), "BOOL": bool, "CHAR": str}


@dataclass
class Interrupt:
    """A declared interrupt."""

    condition: list[str]
    call: str
    level: int
    is_on: bool = False


class _ResumeError(Exception):
    def __init__(self, level: int) -> None:
        self.level = level


@dataclass
class _Call:
    file: str
    variables: dict[str, Any] = field(default_factory=dict)


def _new(name: str, file: str, known: Mapping[str, Any]) -> str:
    """Return the key of a routine or of data: modules have names of their own."""
    return f"{name}@{Path(file).stem.upper()}" if name in known else name


def _own(name: str, file: str, known: Mapping[str, Any]) -> str:
    """Return the key of what a module calls by this name."""
    key = f"{name}@{Path(file).stem.upper()}"
    return key if key in known else name


WAITS = re.compile(r"\bWHEN[ \t]++\$IN\[(\d++)\]==(TRUE|FALSE)", re.IGNORECASE)


def _signals_of(texts: Iterable[str]) -> dict[int, bool]:
    """Return the inputs for which interrupts wait, and their levels."""
    return {int(match[1]): match[2].upper() == "TRUE" for text in texts for match in WAITS.finditer(text)}


class Interpreter:
    """A robot interpreter with its modules.

    Parameters are those of `wpcal.controllers.run.interpreter.Interpreter`; `signals` are numbers of inputs.
    """

    def __init__(
        self,
        files: Mapping[str, str],
        machine: Machine,
        *,
        tools: Mapping[Any, FloatArray] | None = None,
        bases: Mapping[Any, FloatArray] | None = None,
        signals: Mapping[Any, bool] | None = None,
        on_stop: Callable[[str], bool] = lambda _: False,
    ) -> None:
        given = _signals_of(files.values()) if signals is None else signals
        self.machine, self.signals, self.on_stop, self.run = machine, dict(given), on_stop, Run()
        self.tools = {n: frame_value(T) for n, T in (tools or {}).items()}
        self.bases = {n: frame_value(T) for n, T in (bases or {}).items()}
        self.system: dict[str, Any] = {"$NULLFRAME": frame_value(np.eye(4)), "$ADVANCE": 3}
        self.system["MACHINE_DEF"] = {"": Aggregate({"ROOT": 0, "MECH_TYPE": 0})}
        self.system["$H_POS"] = Aggregate(dict.fromkeys(JOINTS))
        self.shown = {"$TOOL": "", "$BASE": ""}
        self.texts = {name: text for name, text in files.items() if name.lower().endswith(".dat")}
        self.data: dict[str, Any] = {}
        self.loaded = ""
        self.kinds: dict[str, str] = {}
        self.routines: dict[str, KrlRoutine] = {}
        self.calls: list[_Call] = []
        self.interrupts: dict[int, Interrupt] = {}
        self.hit: FloatArray | None = None
        self.in_handler = self.is_braked = False
        for name, text in self.texts.items():
            self._declare(name, text)
        self.loaded = ""
        for name, text in files.items():
            if name.lower().endswith(".src"):
                for routine, body in read_source(text, name).items():
                    self.routines[_new(routine, name, self.routines)] = body

    def _declare(self, file: str, text: str) -> None:
        self.loaded = file
        for kind, declared, line, tokens in read_data(text, file):
            name = _new(declared, file, self.data)
            self.kinds[name] = kind
            try:
                self.data[name] = self._typed(kind, self.value(tokens)) if tokens else None
            except ProgramError as error:
                raise ProgramError(f"{declared}: {error.what}", path=file, line=line.number) from None

    # -- values ----------------------------------------------------------------------------------------------------

    def value(self, tokens: list[str]) -> Any:
        """Return the value of an expression."""
        return KrlParser(tokens, GRAMMAR, self).whole()

    def _typed(self, kind: str, value: Any) -> Any:
        expected = KINDS.get(kind)
        if expected is None:
            is_place = kind in CARTESIAN | AXES
            if not isinstance(value, Aggregate) or (is_place and value.kind not in {"", kind, "FRAME"}):
                raise ProgramError(f"{value!r} is no {kind}")
            if kind in CARTESIAN:
                value.matrix()
            return Aggregate(dict(value.values), kind)
        if not isinstance(value, expected) or (kind != "BOOL" and isinstance(value, bool)):
            raise ProgramError(f"{value!r} is no {kind}")
        return value

    def name(self, name: str) -> Any:
        """Return the value of a variable."""
        for known in ([self.calls[-1].variables] if self.calls else []) + [self.data]:
            if (key := _own(name, self._file, known)) in known:
                if known[key] is None:
                    raise ProgramError(f"{name} has no value")
                return known[key]
        found: dict[str, Callable[[], Any]] = {
            "$POS_INT": lambda: self._seen(self.hit),
            "$POS_ACT": lambda: self._seen(self.machine.reading(np.eye(4))),
            "TOOL_DATA": lambda: self.tools,
            "BASE_DATA": lambda: self.bases,
            "$IN": lambda: {number: self.machine.is_on() == level for number, level in self.signals.items()},
            "$OUT": lambda: {int(name[3:]): value for name, value in self.run.outputs.items()},
        }
        if name in found:
            return found[name]()
        if name in self.system:
            return self.system[name]
        raise ProgramError(f"{name} is not declared")

    def _seen(self, T_base_flange: FloatArray | None) -> Aggregate:
        if T_base_flange is None:
            raise ProgramError("$POS_INT before an interrupt")
        T = inverse_pose(self._frame("$BASE")) @ T_base_flange @ self._frame("$TOOL")
        return frame_value(T, "E6POS", {"S": 2, "T": 2, **{f"E{i}": 0.0 for i in range(1, 7)}})

    def part(self, value: Any, name: str) -> Any:
        """Return a part of a structure."""
        if not isinstance(value, Aggregate) or name.upper() not in value.values:
            raise ProgramError(f"no part {name}")
        return value.values[name.upper()]

    def item(self, value: Any, indices: list[Any]) -> Any:
        """Return an element of an array."""
        if not indices:
            return value  # a text, written with empty brackets
        found = value.get(indices[0], value.get("")) if isinstance(value, dict) else None
        if found is None:
            raise ProgramError(f"no element {indices}")
        return found

    def call(self, name: str, arguments: list[Any]) -> Any:
        """Return the value of a function."""
        if name == "INV_POS" and isinstance(arguments[0], Aggregate):
            return frame_value(inverse_pose(arguments[0].matrix()))
        if name in {"ABS", "SQRT"}:
            return abs(arguments[0]) if name == "ABS" else math.sqrt(arguments[0])
        if name == "EK" and len(arguments) == 3:  # the part that a positioner carries
            return arguments[2]
        raise ProgramError(f"the function {name} is unknown")

    def _frame(self, name: str) -> FloatArray:
        value = self.system.get(name)
        if not isinstance(value, Aggregate):
            raise ProgramError(f"a motion before {name} has a value")
        return value.matrix()

    # -- running ---------------------------------------------------------------------------------------------------

    def entries(self) -> list[str]:
        """Return the subprograms that no other one calls, and no interrupt."""
        known = self.routines
        calls = {name: [_own(one, each.file, known) for one in called_in(each.body)] for name, each in known.items()}
        return [name for name in entries_of(calls) if not known[name].parameters]

    def start(self, routine: str) -> Run:
        """Run a routine to its end, or until the operator ends it at a stop."""
        try:
            self._routine(routine.upper(), [])
            self.run.is_finished = True
        except StoppedError:
            pass
        return self.run

    def backup(self) -> dict[str, str]:
        """Return the data lists with the present values."""
        return {name: self._saved(text, name) for name, text in self.texts.items()}

    def _saved(self, text: str, file: str) -> str:
        def declared(match: re.Match[str]) -> str:
            value = self.data[_own(match["name"].upper(), file, self.data)]
            return match[0] if value is None else f"{match['head']}={krl_text(value)}"

        text = re.sub(r"(?m)^(?P<head>\s*DECL\s+\w+\s+(?P<name>\w+))\s*=[^\r\n]*", declared, text)
        return re.sub(r'(?m)^(?P<head>\s*(?P<name>\w+)\[\])\s*="[^"]*"', declared, text)

    def _routine(self, name: str, arguments: list[Any]) -> None:
        routine = self.routines.get(_own(name, self._file, self.routines))
        if routine is None:
            raise ProgramError(f"the instruction or routine {name} is unknown")
        if len(arguments) != len(routine.parameters):
            raise ProgramError(f"{name} takes {len(routine.parameters)} arguments")
        self.calls.append(_Call(routine.file, dict(zip(routine.parameters, arguments, strict=True))))
        level = len(self.calls)
        try:
            self.block(routine.body)
        except LeaveError:
            pass
        finally:
            del self.calls[level - 1 :]
            for number in [n for n, one in self.interrupts.items() if one.level > len(self.calls)]:
                del self.interrupts[number]
        self.machine.switch(Does.STOP)

    def block(self, statements: list[KrlStatement]) -> None:
        """Execute statements in order."""
        for at, statement in enumerate(statements):
            try:
                self.next = statements[at + 1] if at + 1 < len(statements) else None
                self.execute(statement)
            except _ResumeError as resume:
                if resume.level != len(self.calls):
                    raise
                self.in_handler = False

    def execute(self, statement: KrlStatement) -> None:
        """Execute one statement; the machine takes what is refused."""
        file, line = self.calls[-1].file, statement.line
        self.run.step(len(self.calls), file, line.number)
        speed = self.system.get("$VEL.CP")
        speed = 1000.0 * speed if isinstance(speed, int | float) else None
        self.machine.at = Place(file, line.number, self.shown["$TOOL"], self.shown["$BASE"], speed)
        function = getattr(self, f"_do_{statement.word.lower()}", None)
        try:
            (function or self._unknown)(statement)
        except ProgramError as error:
            self.machine.refuse(error.at(file, line.number))

    def _unknown(self, s: KrlStatement) -> None:
        if not HARMLESS.fullmatch(s.line.text):
            raise ProgramError(f"{s.line.text[:80]!r} is unknown")

    def _do_mark(self, s: KrlStatement) -> None:
        does = mark_of(s.tokens[0])
        if does is not None:
            self.machine.switch(does)

    def _do_if(self, s: KrlStatement) -> None:
        self.block(s.blocks[0] if self.value(s.tokens) else s.blocks[1])

    def _repeat(self, s: KrlStatement, goes_on: Callable[[], bool], *, first: bool = True) -> None:
        try:
            while first is False or goes_on():
                first = True
                self.run.step(len(self.calls), self.calls[-1].file, s.line.number)
                self.block(s.blocks[0])
        except BreakError:
            pass

    def _do_for(self, s: KrlStatement) -> None:
        variable, first, last, step = s.parts
        by = self.value(step) if step else 1
        numbers = iter(range(self.value(first), self.value(last) + (1 if by > 0 else -1), by))

        def goes_on() -> bool:
            number = next(numbers, None)
            if number is not None:
                self._assign(variable, number)
            return number is not None

        self._repeat(s, goes_on)

    def _do_while(self, s: KrlStatement) -> None:
        self._repeat(s, lambda: bool(self.value(s.tokens)))

    def _do_loop(self, s: KrlStatement) -> None:
        self._repeat(s, lambda: True)

    def _do_repeat(self, s: KrlStatement) -> None:
        self._repeat(s, lambda: not self.value(s.tokens), first=False)

    def _do_exit(self, s: KrlStatement) -> None:
        raise BreakError

    def _do_switch(self, s: KrlStatement) -> None:
        found = self.value(s.tokens)
        for values, body in zip(s.parts, s.blocks, strict=True):
            if not values or found in self._list(values):
                self.block(body)
                return

    def _list(self, tokens: list[str]) -> list[Any]:
        return KrlParser([*tokens, ")"], GRAMMAR, self).values(")")

    def _do_decl(self, s: KrlStatement) -> None:
        for name in s.parts[0]:
            self.calls[-1].variables.setdefault(name.upper(), None)
            self.kinds.setdefault(name.upper(), s.tokens[0].upper())

    def _do_assign(self, s: KrlStatement) -> None:
        self._assign(s.parts[0], self.value(s.parts[1]), "".join(s.parts[1]))

    def _assign(self, left: list[str], value: Any, shown: str = "") -> None:
        name, whole = left[0].upper(), "".join(left).upper()
        if name in self.shown:
            self._set_frame(name, left, value, shown)
        elif IGNORED.fullmatch(whole):
            self.system[whole] = value
        elif name in {"TOOL_DATA", "BASE_DATA"} and left[1:2] == ["["] and left[-1] == "]":
            self._require_room(self.tools if name == "TOOL_DATA" else self.bases)[self.value(left[2:-1])] = value
        elif name == "$OUT" and left[1:2] == ["["]:
            number = self.value(left[2:-1])
            self.run.outputs[f"OUT{number}"] = value
            self.machine.output(number, value)
        elif self.calls and name in self.calls[-1].variables and len(left) == 1:
            self.calls[-1].variables[name] = self._typed(self.kinds.get(name, "INT"), value)
        elif (key := _own(name, self._file, self.data)) in self.data and (len(left) == 1 or left[1:] == ["[", "]"]):
            self.data[key] = self._typed(self.kinds[key], value)
        else:
            self._set_part(self._holder(name), left, value)

    def _require_room(self, table: dict[int, Aggregate]) -> dict[int, Aggregate]:
        if len(table) > MOST_ELEMENTS:
            raise ProgramError(f"more than {MOST_ELEMENTS} frames")
        return table

    def _set_frame(self, name: str, left: list[str], value: Any, shown: str) -> None:
        if len(left) == 1:
            if not isinstance(value, Aggregate):
                raise ProgramError(f"{value!r} is no frame")
            value.matrix()
            self.system[name], self.shown[name] = value, shown
            return
        now = self.system.get(name)
        if not isinstance(now, Aggregate):
            raise ProgramError(f"{name} has no value")
        self.system[name] = Aggregate(dict(now.values), now.kind)
        self._set_part(self.system[name], left, value)

    def _holder(self, name: str) -> Any:
        if self.calls and name in self.calls[-1].variables:
            return self.calls[-1].variables[name]
        key = _own(name, self._file, self.data)
        if key not in self.data:
            raise ProgramError(f"{name} is not declared")
        return self.data[key]

    @property
    def _file(self) -> str:
        return self.calls[-1].file if self.calls else self.loaded

    def _set_part(self, holder: Any, left: list[str], value: Any) -> None:
        whole = "".join(left).upper()
        if left[1:2] != ["."] or len(left) != 3 or not isinstance(holder, Aggregate):
            raise ProgramError(f"cannot be assigned: {whole}")
        if left[2].upper() not in holder.values:
            raise ProgramError(f"{left[0]} has no part {left[2]}")
        holder.values[left[2].upper()] = value

    # -- instructions ----------------------------------------------------------------------------------------------

    def _do_call(self, s: KrlStatement) -> None:
        name = s.tokens[0].upper()
        if HARMLESS.fullmatch(s.line.text):
            return
        if name in {"ARC_START", "ARC_END"} and name not in self.routines:
            self.machine.switch(Does.ON if name == "ARC_START" else Does.OFF)
        elif name == "ARCMAINNG":
            does = ARC.get(s.parts[0][0].upper() if s.parts[0] else "")
            if does is not None:
                self.machine.switch(does)
        elif name == "BAS":
            self._bas(self._list(s.parts[0][:1]) + s.parts[0][2:3])
        elif name in {"MSGNOTIFY", "MSGQUIT"}:
            self.run.messages.append(str(self._list(s.parts[0])[0]))
        else:
            self._routine(name, self._list(s.parts[0]))

    def _bas(self, arguments: list[Any]) -> None:
        what = arguments[0] if arguments else ""
        if what == "#INITMOV":
            self.system |= {"$BASE": frame_value(np.eye(4)), "$TOOL": frame_value(np.eye(4)), "$ADVANCE": 3}
            self.shown = {"$TOOL": "$NULLFRAME", "$BASE": "$NULLFRAME"}
        elif what in {"#CP_PARAMS", "#PTP_PARAMS"}:
            act = self.system.get("FDAT_ACT")
            if not isinstance(act, Aggregate) or act.values.get("IPO_FRAME", "#BASE") != "#BASE":
                raise ProgramError("FDAT_ACT has no tool and base")
            for name, table, key in (("$TOOL", self.tools, "TOOL_NO"), ("$BASE", self.bases, "BASE_NO")):
                number = act.values.get(key)
                value = frame_value(np.eye(4)) if number == 0 else self.item(table, [number])
                self.system[name], self.shown[name] = value, f"{name[1:]}_DATA[{number}]"
        elif what not in {"#VEL_CP", "#VEL_PTP", "#ACC_CP", "#ACC_PTP"}:
            raise ProgramError(f"BAS({what}) is unknown")

    def _do_interrupt(self, s: KrlStatement) -> None:
        words = [token.upper() for token in s.tokens]
        if "DECL" in words and "WHEN" in words and "DO" in words:
            when, do = words.index("WHEN"), words.index("DO")
            number = self.value(s.tokens[words.index("DECL") + 1 : when])
            self.interrupts[number] = Interrupt(s.tokens[when + 1 : do], words[do + 1], len(self.calls))
            return
        if words[1:2] not in (["ON"], ["OFF"]):
            raise ProgramError(f"{' '.join(words)} is unknown")
        for number in [self.value(s.tokens[2:])] if len(words) > 2 else list(self.interrupts):
            if number not in self.interrupts:
                raise ProgramError(f"the interrupt {number} is not declared")
            self.interrupts[number].is_on = words[1] == "ON"

    def _do_brake(self, s: KrlStatement) -> None:
        if not self.in_handler:
            raise ProgramError("BRAKE outside an interrupt routine")
        self.is_braked = True

    def _do_resume(self, s: KrlStatement) -> None:
        if not self.in_handler:
            raise ProgramError("RESUME outside an interrupt routine")
        raise _ResumeError(self.running.level)

    def _do_return(self, s: KrlStatement) -> None:
        raise LeaveError

    def _do_halt(self, s: KrlStatement) -> None:
        self.run.stop(self.run.messages[-1] if self.run.messages else "HALT", self.on_stop)

    def _do_wait(self, s: KrlStatement) -> None:
        word = s.tokens[0].upper() if s.tokens else ""
        if word == "SEC":
            self.value(s.tokens[1:])
        elif word != "FOR":
            raise ProgramError(f"WAIT {' '.join(s.tokens)} is unknown")
        elif self.signals and not self.value(s.tokens[1:]):
            self.run.stop(f"WAIT {' '.join(s.tokens)}", self.on_stop)

    def _do_ptp(self, s: KrlStatement) -> None:
        (target,) = self._targets(s, 1)
        if set(target.values) & set(JOINTS):
            joints = [target.values.get(axis) for axis in JOINTS]
            self.machine.joint_move(None if None in joints else np.array(joints, dtype=np.float64))
        else:
            self._travel(self._goal(target), is_line=False)

    def _do_lin(self, s: KrlStatement) -> None:
        (target,) = self._targets(s, 1)
        self._travel(self._goal(target), is_line=True)

    def _do_circ(self, s: KrlStatement) -> None:
        via, goal = (self._goal(target) for target in self._targets(s, 2))
        self.machine.arc(via, goal, self._frame("$TOOL"))

    def _do_lin_rel(self, s: KrlStatement) -> None:
        in_tool = s.tokens[-1].upper() == "#TOOL"
        (by,) = self._targets(s, 1, s.tokens[:-1] if in_tool else s.tokens)
        shift = Aggregate({axis: by.values.get(axis, 0.0) for axis in PLACES}).matrix()
        now, base = self.machine.T_base_tool(self._frame("$TOOL")), self._frame("$BASE")
        if not in_tool and not np.array_equal(shift[:3, :3], np.eye(3)):
            raise ProgramError("a relative turn in $BASE is not followed")
        self._travel(now @ shift if in_tool else base @ shift @ inverse_pose(base) @ now, is_line=True)

    def _do_ptp_rel(self, s: KrlStatement) -> None:
        (by,) = self._targets(s, 1)
        if set(by.values) - set(PLACES):
            raise ProgramError("a relative move of axes is not followed")
        self._do_lin_rel(s)

    def _targets(self, s: KrlStatement, count: int, tokens: list[str] | None = None) -> list[Aggregate]:
        given = list(s.tokens if tokens is None else tokens)
        while given and given[-1].upper() in BLENDS:
            given.pop()
            percent = self.system.get("$APO.CPTP")  # of the half of a motion
            share = percent / 100.0 if isinstance(percent, int | float) else 1.0
            self.machine.at = replace(self.machine.at, blends=True, zone=(math.inf, WHOLE_ZONE * min(share, 1.0)))
        found = self._list(given)
        if len(found) != count or not all(isinstance(one, Aggregate) for one in found):
            raise ProgramError(f"{s.line.text[:80]!r}: expected {count} points")
        outer = (found[-1].values.get(axis) for axis in EXTERNAL)
        external = tuple(float(v) for v in outer if isinstance(v, int | float))
        self.machine.at = replace(self.machine.at, external=external)
        return found

    def _goal(self, target: Aggregate) -> FloatArray:
        if set(target.values) & set(JOINTS):
            raise ProgramError("LIN to joint angles")
        base = self._frame("$BASE")
        if set(PLACES) - set(target.values):
            now = frame_value(inverse_pose(base) @ self.machine.T_base_tool(self._frame("$TOOL")))
            target = Aggregate({**now.values, **target.values})
        return base @ target.matrix()

    def _travel(self, goal: FloatArray, *, is_line: bool) -> None:
        T_tool = self._frame("$TOOL")
        armed = [one for one in self.interrupts.values() if one.is_on and "$IN" in (t.upper() for t in one.condition)]
        if not armed or (is_line and self.value(armed[0].condition)):
            self.machine.move(goal, T_tool, is_line=is_line)  # no edge comes from a signal that is on
            return
        (interrupt,) = armed
        if not is_line:
            raise ProgramError("a search on a PTP motion")
        speed = self.machine.at.speed_mm_s
        if speed is None:
            raise ProgramError("a search without $VEL.CP")
        hit = self.machine.search(goal, T_tool, speed)
        if hit is None:
            return
        if self.system["$ADVANCE"] and (self.next is None or self.next.word != "WAIT"):
            raise ProgramError("RESUME with an advance run: neither $ADVANCE=0 nor a WAIT behind the motion")
        self.hit = hit @ inverse_pose(T_tool)
        self.running, self.in_handler, self.is_braked = interrupt, True, False
        self._routine(interrupt.call, [])
        if not self.is_braked:
            raise ProgramError("an interrupt routine without BRAKE: the motion goes on through the part")
        raise ProgramError(f"the motion goes on after the interrupt {interrupt.call}: no RESUME")
