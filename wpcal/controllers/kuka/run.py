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
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.controllers.kuka.read import GRAMMAR as TEXT
from wpcal.controllers.kuka.values import (
    AXES,
    CARTESIAN,
    GRAMMAR,
    Aggregate,
    KrlParser,
    frame_value,
    krl_text,
    read_data,
    read_source,
)
from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.blocks import BlockInterpreter, Node, text_of
from wpcal.controllers.run.machine import MOST_ELEMENTS, WHOLE_ZONE, ProgramError, Run, entries_of, real
from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import inverse_pose

IGNORED = re.compile(r"\$(?:VEL|ACC|VEL_AXIS|ACC_AXIS|APO|BWDSTART|LOAD|ADVANCE|TIMER)\b.*|[LF]DAT_ACT")
"""System variables that do not change where a motion leads; their values are kept."""
USUAL = {"$ORI_TYPE": "#VAR", "$CIRC_TYPE": "#BASE", "$IPO_MODE": "#BASE"}
"""The values with which the tool turns on its way as it is judged; with others it does not, or the part is held."""
PLAIN = {"WAIT", "PTP", "LIN", "CIRC", "SPTP", "SLIN", "SCIRC", "TRIGGER", "PTP_REL", "LIN_REL", "CIRC_REL"}
"""Words whose line may hold ``=`` and is no assignment."""
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
ARC = {"#ARCONAFTERMOVESTD": Does.ON, "#ARCOFFAFTERMOVESTD": Does.OFF}
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


def _new(name: str, file: str, known: Mapping[str, Any]) -> str:
    """Return the key of a routine or of data: modules have names of their own."""
    return f"{name}@{Path(file).stem.upper()}" if name in known else name


def _own(name: str, file: str, known: Mapping[str, Any]) -> str:
    """Return the key of what a module calls by this name."""
    key = f"{name}@{Path(file).stem.upper()}"
    return key if key in known else name


def _is_kept(name: str, value: Any) -> bool:
    """Tell whether a system variable changes no way with this value."""
    return IGNORED.fullmatch(name) is not None or USUAL.get(name, ...) == value


WAITS = re.compile(r"\bWHEN[ \t]++\$IN\[(\d++)\]==(TRUE|FALSE)", re.IGNORECASE)


class Interpreter(BlockInterpreter):
    """A robot interpreter with its modules; `signals` are numbers of inputs."""

    grammar, words, COMMENT, BREAK, PARSER, RETURNS = TEXT, GRAMMAR, ";", "EXIT", KrlParser, False
    ARCS: Mapping[str, Does] = {"ARC_START": Does.ON, "ARC_END": Does.OFF}

    def __init__(self, files: Mapping[str, str], *args: Any, **given: Any) -> None:
        tools, bases = (given.pop(key, None) or {} for key in ("tools", "bases"))
        self.tool_data = {n: frame_value(T) for n, T in tools.items()}
        self.base_data = {n: frame_value(T) for n, T in bases.items()}
        self.system: dict[str, Any] = {"$NULLFRAME": frame_value(np.eye(4)), "$ADVANCE": 3}
        self.system["MACHINE_DEF"] = {"": Aggregate({"ROOT": 0, "MECH_TYPE": 0})}
        self.system["$H_POS"] = Aggregate(dict.fromkeys(JOINTS))
        self.texts = {name: text for name, text in files.items() if name.lower().endswith(".dat")}
        self.kinds: dict[str, str] = {}
        self.interrupts: dict[int, Interrupt] = {}
        self.hit: FloatArray | None = None
        self.after = ""  #: The line after the one that runs.
        self.in_handler = self.is_braked = False
        self.has_own_speed = False  #: Whether the data of an arc package state the speed.
        super().__init__(files, *args, **given)
        self.file = ""  # until a routine runs

    def start(self, routine: str) -> Run:
        self.has_own_speed = False  # whatever the routine before left
        return super().start(routine)

    def load(self, file: str, text: str) -> None:
        self.file = file
        if file.lower().endswith(".dat"):
            self._declare(file, text)
        elif file.lower().endswith(".src"):
            for name, routine in read_source(text, file).items():
                self.routines[_new(name, file, self.routines)] = routine

    def signals_of(self, text: str) -> dict[Any, bool]:
        return {int(match[1]): match[2].upper() == "TRUE" for match in WAITS.finditer(text)}

    def _declare(self, file: str, text: str) -> None:
        for each in read_data(text, file):
            name = _new(each.name, file, self.values)
            self.kinds[name] = each.kind
            try:
                self.values[name] = self._typed(each.kind, self.value(each.value)) if each.value else None
            except ProgramError as error:
                raise ProgramError(f"{each.name}: {error.what}", path=file, line=each.line) from None

    # -- values ----------------------------------------------------------------------------------------------------

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
        for known in (self.locals[-1], self.values):
            if (key := _own(name, self.file, known)) in known:
                if known[key] is None:
                    raise ProgramError(f"{name} has no value")
                return known[key]
        found: dict[str, Callable[[], Any]] = {
            "$POS_INT": lambda: self._seen(self.hit),
            "$POS_ACT": lambda: self._seen(self.machine.reading(np.eye(4))),
            "TOOL_DATA": lambda: self.tool_data,
            "BASE_DATA": lambda: self.base_data,
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
        if not isinstance(value, Aggregate) or name.upper() not in value.values:
            raise ProgramError(f"no part {name}")
        return value.values[name.upper()]

    def item(self, value: Any, indices: list[Any]) -> Any:
        if not indices:
            return value  # a text, written with empty brackets
        found = value.get(indices[0], value.get("")) if isinstance(value, dict) else None
        if found is None:
            raise ProgramError(f"no element {indices}")
        return found

    FUNCTIONS: Mapping[str, Callable[..., Any]] = {
        "inv_pos": lambda _, frame: frame_value(inverse_pose(frame.matrix())),
        "abs": lambda _, value: abs(value),
        "sqrt": lambda _, value: math.sqrt(value),
        # coupled to the flange of the robot that holds the part, with these numbers
        "sbase": lambda self, number: self.values.get("PART_HELD") or self.item(self.base_data, [number]),
        "ek": lambda _, __, ___, part: part,  # that a positioner carries
    }

    def _frame(self, name: str) -> FloatArray:
        value = self.system.get(name)
        if not isinstance(value, Aggregate):
            raise ProgramError(f"a motion before {name} has a value")
        return value.matrix()

    # -- running ---------------------------------------------------------------------------------------------------

    def entries(self) -> list[str]:
        """Return the subprograms that no other one calls, and no interrupt."""
        known = self.routines
        calls = {
            name: [_own(word, each.file, known) for word in self._words(text_of(each.body))]
            for name, each in known.items()
        }
        return [name for name in entries_of(calls) if not known[name].parameters]

    def backup(self) -> dict[str, str]:
        """Return the data lists with the present values."""
        return {name: self._saved(text, name) for name, text in self.texts.items()}

    def _saved(self, text: str, file: str) -> str:
        def declared(match: re.Match[str]) -> str:
            value = self.values[_own(match["name"].upper(), file, self.values)]
            return match[0] if value is None else f"{match['head']}={krl_text(value)}"

        text = re.sub(r"(?m)^(?P<head>\s*DECL\s+\w+\s+(?P<name>\w+))\s*=[^\r\n]*", declared, text)
        return re.sub(r'(?m)^(?P<head>\s*(?P<name>\w+)\[\])\s*="[^"]*"', declared, text)

    def routine(self, name: str, arguments: Sequence[Any] = ()) -> None:
        """Run a subprogram to its end; its interrupts end with it."""
        key = _own(name.upper(), self.file, self.routines)
        if key not in self.routines and key not in self.ARCS:
            raise ProgramError(f"the instruction or routine {name} is unknown")
        try:
            super().routine(key, arguments)
        finally:
            self.interrupts = {number: one for number, one in self.interrupts.items() if one.level <= self.calls}

    def block(self, nodes: Sequence[Node]) -> None:
        file = self.file
        for node, after in zip(nodes, [*nodes[1:], None], strict=False):
            self.after = "" if after is None else after.text
            try:
                self.step(file, node.line, partial(self.execute, node))
            except _ResumeError as resume:
                if resume.level != self.calls:
                    raise
                self.in_handler, self.file = False, file

    def statement(self, word: str, tokens: list[str], node: Node) -> None:
        self._note_speed()
        if word in {"GLOBAL", "INTERRUPT"}:
            self._interrupt(tokens)
        elif "=" in tokens and word not in PLAIN and word != "DECL":
            equals = tokens.index("=")
            self._assign(tokens[:equals], self.value(tokens[equals + 1 :]), "".join(tokens[equals + 1 :]))
        elif HARMLESS.fullmatch(node.text):
            pass
        elif tokens[1:2] == ["("] and tokens[-1] == ")" and word != "WAIT":
            self._call(word, tokens[2:-1])
        elif (function := getattr(self, f"_do_{word.lower()}", None)) is not None:
            function(tokens[1:])
        else:
            raise ProgramError(f"{node.text[:80]!r} is unknown")

    def _note_speed(self) -> None:
        speed = self.system.get("$VEL.CP")
        if isinstance(speed, int | float) and not self.has_own_speed:
            self.machine.at = replace(self.machine.at, speed_mm_s=1000.0 * speed)

    def give(self, name: str, value: Any) -> None:
        self._assign([name], value)

    def _do_decl(self, tokens: list[str]) -> None:
        for name in (one.upper() for one in tokens[1:] if one != ","):
            self.locals[-1].setdefault(name, None)
            self.kinds.setdefault(name, tokens[0].upper())

    def _assign(self, left: list[str], value: Any, shown: str = "") -> None:
        name, whole = left[0].upper(), "".join(left).upper()
        if _is_kept(whole, value):
            self.system[whole] = value
        elif name in {"TOOL_DATA", "BASE_DATA", "$OUT"} and left[1:2] == ["["] and left[-1] == "]":
            self._set_element(name, self.value(left[2:-1]), value)
        elif left[1:] not in ([], ["[", "]"]):
            self._set_part(*self._home(name), left, value)
        elif name in {"$TOOL", "$BASE"}:
            if not isinstance(value, Aggregate):
                raise ProgramError(f"{value!r} is no frame")
            value.matrix()
            self._show(name, value, shown)
        else:
            values, key = self._home(name)
            values[key] = self._typed(self.kinds.get(key, "INT"), value)

    def _set_element(self, name: str, number: Any, value: Any) -> None:
        if name == "$OUT":
            self.run.outputs[f"OUT{number}"] = value
            self.machine.output(number, value)
            return
        table = self.tool_data if name == "TOOL_DATA" else self.base_data
        if len(table) > MOST_ELEMENTS:
            raise ProgramError(f"more than {MOST_ELEMENTS} frames")
        table[number] = value

    def _show(self, name: str, value: Any, shown: str) -> None:
        """Set the present tool or base; a place shows it in words."""
        self.system[name] = value
        setattr(self, "tool" if name == "$TOOL" else "frame", shown)

    def _home(self, name: str) -> tuple[dict[str, Any], str]:
        """Return among which values a variable is, and its key there."""
        if name in {"$TOOL", "$BASE"}:
            kept = self.system.get(name)
            if not isinstance(kept, Aggregate):
                raise ProgramError(f"{name} has no value")
            self.system[name] = Aggregate(dict(kept.values), kept.kind)  # it may be an element of TOOL_DATA
            return self.system, name
        if name in self.locals[-1]:
            return self.locals[-1], name
        key = _own(name, self.file, self.values)
        if key not in self.values:
            raise ProgramError(f"{name} is not declared")
        return self.values, key

    def _set_part(self, values: dict[str, Any], key: str, left: list[str], value: Any) -> None:
        holder = values[key]
        if left[1:2] != ["."] or len(left) != 3 or not isinstance(holder, Aggregate):
            raise ProgramError(f"cannot be assigned: {''.join(left).upper()}")
        if left[2].upper() not in holder.values:
            raise ProgramError(f"{left[0]} has no part {left[2]}")
        holder.values[left[2].upper()] = value

    # -- instructions ----------------------------------------------------------------------------------------------

    def _call(self, name: str, given: list[str]) -> None:
        if name == "ARCMAINNG":
            does = ARC.get(given[0].upper() if given else "")
            if does is not None:
                self.machine.switch(does)
                self.has_own_speed = does is Does.ON
        elif name == "BAS":
            self._bas(self.listed(given[:1]))
        elif name in {"MSGNOTIFY", "MSGQUIT"}:
            self.run.messages.append(str(self.listed(given)[0]))
        else:
            self.routine(name, self.listed(given))

    def _bas(self, arguments: list[Any]) -> None:
        what = arguments[0] if arguments else ""
        if what == "#INITMOV":
            self.system["$ADVANCE"] = 3
            for name in ("$TOOL", "$BASE"):
                self._show(name, frame_value(np.eye(4)), "$NULLFRAME")
        elif what in {"#CP_PARAMS", "#PTP_PARAMS"}:
            act = self.system.get("FDAT_ACT")
            if not isinstance(act, Aggregate) or act.values.get("IPO_FRAME", "#BASE") != "#BASE":
                raise ProgramError("FDAT_ACT has no tool and base")
            for name, table, key in (("$TOOL", self.tool_data, "TOOL_NO"), ("$BASE", self.base_data, "BASE_NO")):
                number = act.values.get(key)
                value = frame_value(np.eye(4)) if number == 0 else self.item(table, [number])
                self._show(name, value, f"{name[1:]}_DATA[{number}]")
        elif what not in {"#VEL_CP", "#VEL_PTP", "#ACC_CP", "#ACC_PTP"}:
            raise ProgramError(f"BAS({what}) is unknown")

    def _interrupt(self, tokens: list[str]) -> None:
        words = [token.upper() for token in tokens]
        if "DECL" in words and "WHEN" in words and "DO" in words:
            when, do = words.index("WHEN"), words.index("DO")
            number = self.value(tokens[words.index("DECL") + 1 : when])
            self.interrupts[number] = Interrupt(tokens[when + 1 : do], words[do + 1], self.calls)
            return
        if words[1:2] not in (["ON"], ["OFF"]):
            raise ProgramError(f"{' '.join(words)} is unknown")
        for number in [self.value(tokens[2:])] if len(words) > 2 else list(self.interrupts):
            if number not in self.interrupts:
                raise ProgramError(f"the interrupt {number} is not declared")
            self.interrupts[number].is_on = words[1] == "ON"

    def _do_brake(self, _: list[str]) -> None:
        if not self.in_handler:
            raise ProgramError("BRAKE outside an interrupt routine")
        self.is_braked = True

    def _do_resume(self, _: list[str]) -> None:
        if not self.in_handler:
            raise ProgramError("RESUME outside an interrupt routine")
        raise _ResumeError(self.running.level)

    def _do_halt(self, _: list[str]) -> None:
        self.run.stop(self.run.messages[-1] if self.run.messages else "HALT", self.on_stop)

    def _do_wait(self, tokens: list[str]) -> None:
        word = tokens[0].upper() if tokens else ""
        if word == "SEC":
            self.value(tokens[1:])
        elif word != "FOR":
            raise ProgramError(f"WAIT {' '.join(tokens)} is unknown")
        elif self.signals and not self.value(tokens[1:]):
            self.run.stop(f"WAIT {' '.join(tokens)}", self.on_stop)

    def _do_ptp(self, tokens: list[str]) -> None:
        (target,) = self._targets(tokens, 1)
        if set(target.values) & set(JOINTS):
            joints = [target.values.get(axis) for axis in JOINTS]
            self.machine.joint_move(None if None in joints else np.array([real(angle) for angle in joints]))
        else:
            self._travel(self._goal(target), is_line=False)

    def _do_lin(self, tokens: list[str]) -> None:
        (target,) = self._targets(tokens, 1)
        self._travel(self._goal(target), is_line=True)

    def _do_circ(self, tokens: list[str]) -> None:
        via, goal = (self._goal(target) for target in self._targets(tokens, 2))
        self.machine.arc(via, goal, self._frame("$TOOL"))

    def _do_slin(self, tokens: list[str]) -> None:
        self._do_lin(self._with(tokens))

    def _do_scirc(self, tokens: list[str]) -> None:
        self._do_circ(self._with(tokens))

    def _with(self, tokens: list[str]) -> list[str]:
        """Return a move of a spline without what holds on it only: its speed, its mark."""
        words = [token.upper() for token in tokens]
        if "WITH" not in words:
            return tokens
        begin, (own, ends), at = words.index("WITH"), _without_blends(tokens), self.machine.at
        for name, _, value in (each.partition("=") for each in "".join(own[begin + 1 :]).split(",")):
            if name.upper() == "$VEL.CP":
                at = replace(at, speed_mm_s=1000.0 * real(self.value([value])))
            elif name.upper() == "$SYNC_ID[]":
                at = replace(at, mark=str(self.value([value])))
            elif name.upper() != "$SYNC_LIST" and not _is_kept(name.upper(), value.upper()):
                raise ProgramError(f"WITH {name} is unknown")
        self.machine.at = at
        return [*tokens[:begin], *ends]

    def _do_lin_rel(self, tokens: list[str]) -> None:
        in_tool = tokens[-1].upper() == "#TOOL"
        (by,) = self._targets(tokens[:-1] if in_tool else tokens, 1)
        shift = Aggregate({axis: by.values.get(axis, 0.0) for axis in PLACES}).matrix()
        now, base = self.machine.T_base_tool(self._frame("$TOOL")), self._frame("$BASE")
        if not in_tool and not np.array_equal(shift[:3, :3], np.eye(3)):
            raise ProgramError("a relative turn in $BASE is not followed")
        self._travel(now @ shift if in_tool else base @ shift @ inverse_pose(base) @ now, is_line=True)

    def _do_ptp_rel(self, tokens: list[str]) -> None:
        (by,) = self._targets(tokens, 1)
        if set(by.values) - set(PLACES):
            raise ProgramError("a relative move of axes is not followed")
        self._do_lin_rel(tokens)

    def _targets(self, tokens: list[str], count: int) -> list[Aggregate]:
        given, blends = _without_blends(tokens)
        if blends:
            percent = self.system.get("$APO.CPTP")  # of the half of a motion
            share = percent / 100.0 if isinstance(percent, int | float) else 1.0
            self.machine.at = replace(self.machine.at, blends=True, zone=(math.inf, WHOLE_ZONE * min(share, 1.0)))
        found = self.listed(given)
        if len(found) != count or not all(isinstance(one, Aggregate) for one in found):
            raise ProgramError(f"{' '.join(tokens)[:80]!r}: expected {count} points")
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
        if not is_line:
            raise ProgramError("a search on a PTP motion")
        self._search(goal, T_tool, *armed)

    def _search(self, goal: FloatArray, T_tool: FloatArray, interrupt: Interrupt) -> None:
        speed = self.machine.at.speed_mm_s
        if speed is None:
            raise ProgramError("a search without $VEL.CP")
        hit = self.machine.search(goal, T_tool, speed)
        if hit is None:
            return
        if self.system["$ADVANCE"] and not self.after.upper().startswith("WAIT"):
            raise ProgramError("RESUME with an advance run: neither $ADVANCE=0 nor a WAIT behind the motion")
        self.hit = hit @ inverse_pose(T_tool)
        self.running, self.in_handler, self.is_braked = interrupt, True, False
        self.routine(interrupt.call)
        if not self.is_braked:
            raise ProgramError("an interrupt routine without BRAKE: the motion goes on through the part")
        raise ProgramError(f"the motion goes on after the interrupt {interrupt.call}: no RESUME")


def _without_blends(tokens: list[str]) -> tuple[list[str], list[str]]:
    """Return the tokens of a move without the words for what it does at its end, and these."""
    count = len(tokens)
    while count and tokens[count - 1].upper() in BLENDS:
        count -= 1
    return tokens[:count], tokens[count:]
