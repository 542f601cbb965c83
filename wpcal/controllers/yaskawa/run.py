"""Yaskawa INFORM (``.jbi``): what a job does.

A search is ``MOVL … SRCH``: it ends at the signal, and ``$B002`` is 1 then. ``$PX003`` is the detected place in the
robot's frame, ``$PX002`` the same in pulses, which CNVRT turns into a user frame. Points are in the frame that the
header states; three MOVC are an arc from the first to the third. ``SFTON`` displaces the points after it, ``IMOV`` adds
to where the tool is. User frames that the remarks of a job ask for count as set.

References: Yaskawa, DX200 / YRC1000 INFORM Language (MOVJ, MOVL, MOVC, IMOV, SFTON, SRCH, CNVRT, GETS, JUMP, CALL).
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.expressions import COMPARE
from wpcal.controllers.run.interpreter import LineInterpreter, matrix_of, numbers_of, stated_frame
from wpcal.controllers.run.machine import ProgramError, moved
from wpcal.controllers.yaskawa.read import GRAMMAR
from wpcal.controllers.yaskawa.write import DEG_DECIMALS, LANGUAGE, LONGEST_COMMENT, MM_DECIMALS
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.numbers import parse_number
from wpcal.core.same_bits import inverse_pose

LABEL_LENGTH = 8
RANGES = {"B": (0, 255), "I": (-32768, 32767), "D": (-(2**31), 2**31 - 1)}
AXES = r"(?: [BE]C\d{5}){0,2}"  #: Of a rail and a station.
MASTER = r"(?:  \+MOVJ E?C\d{5}(?: VJ=\d+\.\d+)?)?"  #: How the station moves in step, or robot 2.
LED = re.compile(r"\+MOVJ (C\d{5})")  #: Where robot 2 goes.
OUTER = re.compile(r"\b[BE]C\d{5}\b")  #: Their positions: a rail in mm, then a station in deg.
JOINT_KINDS = ("PULSE", "ANGLE")
POINT = r"(C\d{5}|PX?\d{3,5})"
NUMBER = r"([BID]\d{3})"
UNITS = (1000.0, 1000.0, 1000.0, 10000.0, 10000.0, 10000.0)  #: Of the elements of a position, as numbers.


@dataclass(frozen=True)
class _Point:
    """A position: frame (PULSE, ANGLE, BASE, ROBOT, USER), number of the user frame, tool, values."""

    kind: str
    user: str
    tool: str
    values: tuple[float, ...]
    T_base_flange: FloatArray | None = None  #: What pulses stand for, where the robot stored them.


class _Job:
    """One ``.jbi`` file: its points, and its instructions with their lines in the file."""

    def __init__(self, file: str, text: str) -> None:
        self.file = file
        rows = text.splitlines()
        begin = next((number for number, row in enumerate(rows) if row.startswith("//INST")), 0)
        name = re.fullmatch(r"//NAME \s*([A-Z0-9_-]{1,32})\s*", "".join(rows[1:2]))
        if not begin or rows[0].strip() != "/JOB" or name is None:
            raise ProgramError("a job has /JOB, //NAME with a name, and //INST", path=file)
        self.name, self.points = name[1], dict[str, _Point]()
        self._header(rows[2:begin])
        numbered = enumerate(rows[begin + 1 :], begin + 2)
        self.lines = [(number, row.strip()) for number, row in numbered if not row.startswith("///")]
        self._require_sound()

    def _require_sound(self) -> None:
        texts = [row for _, row in self.lines]
        if texts[:1] != ["NOP"] or "END" not in texts:
            raise ProgramError("a job begins with NOP and ends with END", path=self.file)
        self.labels = {row.split()[0][1:]: at for at, row in enumerate(texts) if row.startswith("*")}
        if any(len(label) > LABEL_LENGTH for label in self.labels):
            raise ProgramError(f"a label has more than {LABEL_LENGTH} characters", path=self.file)

    def _header(self, rows: list[str]) -> None:
        given = {"USER": "", "TOOL": "0", "POSTYPE": "", "NPOS": ""}
        for number, row in enumerate(rows, 3):
            key, _, value = row.strip("/").partition(" ")
            if key in given:
                given[key] = value.strip()
            elif key in {"RECTAN", "PULSE", "ANGLE"}:
                given["FORM"] = key
            elif found := re.match(r"((?:B|E)?C\d{5}|P\d{3,5})\s*=\s*(\S.*)", row):
                kind = given["POSTYPE"] if given.get("FORM", "RECTAN") == "RECTAN" else given["FORM"]
                self.points[found[1]] = _Point(kind, given["USER"], given["TOOL"], self._values(found[2], number))
            elif not re.match(r"//POS$|///(?:RCONF |GROUP)|/{3,4}[A-Z]", row):
                raise ProgramError(f"unknown in the header: {row!r}", path=self.file, line=number)
        taught = sum(name.startswith("C") for name in self.points)
        if given["NPOS"].partition(",")[0].strip() != str(taught):
            raise ProgramError(f"///NPOS does not state the {taught} points of the job", path=self.file)

    def _values(self, text: str, line: int) -> tuple[float, ...]:
        try:
            return tuple(parse_number(cell) for cell in text.split(","))
        except InputError as error:
            raise ProgramError(str(error), path=self.file, line=line) from None


class Interpreter(LineInterpreter):
    """Runs jobs; variables have no value before a job gives them one."""

    grammar = GRAMMAR
    SIGNAL = r" SRCH (?P<name>R?IN#\(\d+\))=(?:ON|(?P<off>OFF))"
    job: _Job
    LONGEST_MESSAGE = 32  #: Characters that MSG shows.
    REMARKS: Mapping[str, float] = {"'": LONGEST_COMMENT, "//": LONGEST_COMMENT}
    BLOCK = ("IFTHENEXP", "ELSEEXP", "ENDIF")
    FOR, LABELLED = ("FOR", "NEXT"), "*{}"

    def __init__(self, files: Mapping[str, str], *args: Any, **given: Any) -> None:
        self.jobs: dict[str, _Job] = {}
        self.numbers: dict[str, int] = {}
        self.places: dict[str, _Point] = {}
        self.detected: FloatArray | None = None
        self.is_found: bool | None = None
        self.arc: list[_Point] = []
        self.shift: tuple[FloatArray, bool] | None = None
        self.loops = []
        self.via_external: tuple[float, ...] = ()  #: As in `Place`.
        self.led: list[_Point] = []  #: The last two points of robot 2.
        super().__init__(files, *args, **given)

    def load(self, file: str, text: str) -> None:
        job = _Job(file, text)
        self.jobs[self.declare(job.name, file, self.jobs)] = job
        self.bases = stated_frame(text, LANGUAGE) | self.bases

    # -- values ----------------------------------------------------------------------------------------------------

    def number(self, name: str) -> int:
        if re.fullmatch(r"-?\d{1,12}", name):
            return int(name)
        if name not in self.numbers:
            raise ProgramError(f"nobody knows {name}: the job gave it no value")
        return self.numbers[name]

    def set(self, name: str, value: int) -> None:
        low, high = RANGES[name[0]]
        if not low <= value <= high:
            raise ProgramError(f"{name} cannot hold {value}")
        self.numbers[name] = value

    def place(self, name: str) -> _Point:
        """Return a position of the job, or a variable."""
        name = name.replace("PX", "P")
        found = self.job.points.get(name) or self.places.get(name)
        if found is None:
            raise ProgramError(f"nobody knows {name}: it is not taught in the job, which gave it no value")
        return found

    def _T_frame(self, point: _Point) -> FloatArray:
        if point.kind in {"ROBOT", "BASE"}:
            return np.eye(4)
        if point.kind != "USER":
            raise ProgramError(f"a point in {point.kind or 'no frame'}")
        self.frame = point.user
        return self.T_frame()

    def _T_base(self, point: _Point) -> FloatArray:
        """Return a point in `base`, displaced by SFTON."""
        if len(point.values) != len(UNITS):
            raise ProgramError("a position has six numbers")
        self.tool = point.tool
        T = self._T_frame(point) @ matrix_of(point.values)
        if self.shift is not None:
            T = moved(T, *self.shift)
        return T

    # -- running ---------------------------------------------------------------------------------------------------

    def instruction(self, line: str, at: int) -> int | None:
        if not re.match("S?MOVC", line) and re.match(r"S?MOV|IMOV", line):
            self._end_arc()
        outer = [self.place(name) for name in dict.fromkeys(OUTER.findall(line))]
        self.bring([v for point in outer if point.kind == "ANGLE" for v in point.values])
        led = LED.search(line)
        if led is not None and self.leader is None:
            raise ProgramError("robot 2 moves, too")
        self._begin(line, at)
        jump = self.matched(line, at)
        if led is not None:
            self._lead(self.place(led[1]))
        return jump

    def _begin(self, line: str, at: int) -> None:
        """Keep at which mark a move waits, and whether it stops: at position level 0, and where a search ends.

        Without a level the controller takes its own: a corner of unknown size.
        """
        if line.startswith("MOV"):
            self.machine.at = replace(self.machine.at, mark=self._mark(at + 1))
        self.blend(None if re.search(r" PL=0\b| SRCH ", line) else math.inf)

    def _mark(self, at: int) -> str:
        """Return the number at which this job then waits for the other one; empty without one."""
        while self.job.lines[at][1].startswith("'"):
            at += 1
        waits = re.fullmatch(r"TSYNC (\d+) SNUM=2", self.job.lines[at][1])
        return "" if waits is None else waits[1]

    # -- moves -----------------------------------------------------------------------------------------------------

    def _movj(self, name: str) -> None:
        point = self.place(name)
        if point.kind in JOINT_KINDS:
            self._to_joints("J", point)
        else:
            self.go("J", self._T_base(point))

    def _to_joints(self, kind: str, point: _Point, via: _Point | None = None, mm_s: float | None = None) -> None:
        middle = None if via is None else np.array(via.values)
        self.tool = point.tool
        self.machine.at = replace(self.machine.at, tool=point.tool, speed_mm_s=mm_s)
        self.machine.joint_move(np.array(point.values), kind=kind, via=middle, in_pulses=point.kind == "PULSE")

    def _lead(self, point: _Point) -> None:
        """Move robot 2 with a point of an arc, or with a line."""
        count, self.led = len(self.arc), [*self.led[-1:], point]
        if count != 2 and self.leader is not None:
            self.leader.at = self.machine.at
            via = np.array(self.led[0].values) if count == 3 else None
            self.leader.joint_move(np.array(point.values), via=via, in_pulses=point.kind == "PULSE")

    def _movl(self, name: str, speed: str, rest: str | None) -> None:
        point, is_search = self.place(name), bool(rest) and str(rest).startswith(" SRCH")
        if not is_search:
            self._options(rest)
            if point.kind in JOINT_KINDS:
                self._to_joints("L", point, mm_s=float(speed))
                return
        goal = self._T_base(point)
        if not is_search:
            self.go("L", goal, speed_mm_s=float(speed))
            return
        found = re.fullmatch(r" SRCH (R?IN#\(\d+\))=(ON|OFF)(?: T=\d+\.\d+)?", rest or "")
        if found is None:
            raise ProgramError(f"not followed: {rest!r}")
        if self.signals.get(found[1]) != (found[2] == "ON"):
            raise ProgramError(f"{rest}: the search does not wait for the touch")
        hit = self.machine.search(goal, self.T_tool(), float(speed), is_edge=False)
        self.is_found = hit is not None
        if hit is not None:
            self.detected = hit @ inverse_pose(self.T_tool())

    def _options(self, rest: str | None) -> None:
        if rest and not re.fullmatch(r"(?: PL=\d| ACC=\d+| DEC=\d+| NWAIT)*", rest):
            raise ProgramError(f"not followed: {rest.strip()!r}")

    def _movc(self, name: str, speed: str, rest: str | None) -> None:
        """Take one of the three points of an arc; the robot goes to the first on a line."""
        self._options(rest)
        point = self.place(name)
        self.arc.append(point)
        if len(self.arc) == 2:
            self.via_external = self.external
        else:
            self.machine.at = replace(self.machine.at, via_external=self.via_external)
        if len(self.arc) in {1, 3}:
            kind, via = ("L", None) if len(self.arc) == 1 else ("C", self.arc[1])
            if point.kind in JOINT_KINDS:
                self._to_joints(kind, point, via, float(speed))
            else:
                T_via = None if via is None else self._T_base(via)
                self.go(kind, self._T_base(point), via=T_via, speed_mm_s=float(speed))
        elif len(self.arc) > 3:
            raise ProgramError("more than three MOVC in a row")

    def _end_arc(self) -> None:
        count, self.arc = len(self.arc), []
        if count in {1, 2}:
            raise ProgramError(f"an arc of {count} MOVC")

    def _imov(self, name: str, speed: str, frame: str | None, user: str | None) -> None:
        point = self.place(name)
        self.tool = point.tool
        at = self.machine.T_base_tool(self.T_tool())
        self.go("L", moved(at, *self._displacement(point, frame, user)), speed_mm_s=float(speed))

    def _shift(self, name: str | None, frame: str | None = None, user: str | None = None) -> None:
        self.shift = None if name is None else self._displacement(self.place(name), frame, user)

    def _displacement(self, point: _Point, frame: str | None, user: str | None) -> tuple[FloatArray, bool]:
        """Return a displacement in `base`, or in the tool, and whether it is in the tool."""
        if point.kind in JOINT_KINDS or any(point.values[3:]):
            raise ProgramError("a displacement in pulses or with a turn")
        d = np.array(point.values[:3])
        if frame == "TF":
            return d, True
        kind = {"UF#": "USER", "BF": "BASE", "RF": "ROBOT"}.get(frame or "", point.kind)
        return self._T_frame(_Point(kind, user or point.user, point.tool, ()))[:3, :3] @ d, False

    # -- variables -------------------------------------------------------------------------------------------------

    def _gets(self, name: str, system: str) -> None:
        if system == "$B002":
            if self.is_found is None:
                raise ProgramError("$B002 before a search")
            self.set(name, int(self.is_found))
            return
        if system not in {"$PX000", "$PX001", "$PX002", "$PX003"} or not name.startswith("P"):
            raise ProgramError(f"not followed: GETS {name} {system}")
        T_base_flange = self.machine.reading(np.eye(4)) if system in {"$PX000", "$PX001"} else self.detected
        if T_base_flange is None:  # nothing was detected yet: all pulses are zero
            T_base_flange = np.eye(4)
        is_pulse = system in {"$PX000", "$PX002"}
        values = () if is_pulse else _values(T_base_flange @ self.T_tool())
        kind = "PULSE" if is_pulse else "ROBOT"
        self.places[name.replace("PX", "P")] = _Point(kind, "0", self.tool, values or (0.0,) * 6, T_base_flange)

    def _cnvrt(self, to: str, source: str, frame: str, user: str | None) -> None:
        point = self.place(source)
        self.tool = point.tool
        if point.kind == "PULSE":
            if point.T_base_flange is None:
                raise ProgramError(f"{source} is in pulses")
            T = point.T_base_flange @ self.T_tool()
        else:
            T = self._T_frame(point) @ matrix_of(point.values)
        kind = {"BF": "BASE", "RF": "ROBOT", "UF#": "USER"}[frame]
        new = _Point(kind, user or "0", point.tool, ())
        values = _values(inverse_pose(self._T_frame(new)) @ T)
        self.places[to.replace("PX", "P")] = _Point(kind, new.user, point.tool, values)

    def _set(self, name: str, value: str) -> None:
        if name.startswith("P"):
            self.places[name.replace("PX", "P")] = self.place(value)
        else:
            self.set(name, self.number(value))

    def _change(self, word: str, name: str, by: str | None) -> None:
        if name.startswith("P"):
            one, other = self.place(name), self.place(by or "")
            if one.kind in JOINT_KINDS or other.kind in JOINT_KINDS:
                raise ProgramError(f"{word} in pulses")
            sign = 1.0 if word == "ADD" else -1.0
            values = tuple(a + sign * b for a, b in zip(one.values, other.values, strict=True))
            self.places[name.replace("PX", "P")] = _Point(one.kind, one.user, one.tool, values)
            return
        step = {"ADD": 1, "SUB": -1, "INC": 1, "DEC": -1}[word] * (self.number(by) if by else 1)
        self.set(name, self.number(name) + step)

    def _gete(self, name: str, source: str, element: str) -> None:
        at = int(element) - 1
        self.set(name, round(self.place(source).values[at] * UNITS[at]))

    def _sete(self, name: str, element: str, value: str) -> None:
        point, at = self.place(name), int(element) - 1
        values = [*point.values]
        values[at] = self.number(value) / UNITS[at]
        self.places[name.replace("PX", "P")] = _Point(point.kind, point.user, point.tool, tuple(values))

    def _clear(self, name: str, count: str) -> None:
        first = int(name[1:])
        for number in range(first, first + int(count)):
            self.set(f"{name[0]}{number:03d}", 0)

    # -- branches --------------------------------------------------------------------------------------------------

    def holds(self, text: str) -> bool:
        if found := re.fullmatch(r"(R?IN#\(\d+\))=(ON|OFF)", text):
            return self.is_on(found[1]) == (found[2] == "ON")
        found = re.fullmatch(rf"{NUMBER}(<>|<=|>=|[=<>])(\S+)", text)
        if found is None:
            raise ProgramError(f"the condition {text!r} is not followed")
        return bool({"=": operator.eq, **COMPARE}[found[2]](self.number(found[1]), self.number(found[3])))

    def _call(self, name: str, condition: str | None) -> None:
        if condition is None or self.holds(condition):
            self.routine(name)

    def _while(self, at: int, condition: str) -> int | None:
        return None if self.holds(condition) else self.end_of(at, "WHILEEXP", "ENDWHILE") + 1

    # -- the rest --------------------------------------------------------------------------------------------------

    def _end(self) -> int:
        self._end_arc()
        return -1

    _FRAME = r"(?: (BF|RF|TF|UF#)(?:\((\d+)\))?)?"
    _INSTRUCTIONS: tuple[tuple[str, Callable[..., int | None]], ...] = (
        (r"END|RET", _end),
        (r"\*.*|NOP", lambda _: None),
        (rf"S?MOVJ {POINT}{AXES} VJ=\d+\.\d+(?: PL=\d)?(?: NWAIT)?{MASTER}", _movj),
        (rf"S?MOVL {POINT}{AXES} V=(\d+\.\d+)( [A-Z].*?)?{MASTER}", _movl),
        (rf"S?MOVC {POINT}{AXES} V=(\d+\.\d+)( [A-Z].*?)?{MASTER}", _movc),
        (rf"IMOV {POINT} V=(\d+\.\d+)(?: PL=\d)?{_FRAME}", _imov),
        (rf"SFTON {POINT}{_FRAME}|SFTOF", _shift),
        (r"ARCON\b.*", lambda self: self.machine.switch(Does.ON)),
        (r"ARCOF\b.*", lambda self: self.machine.switch(Does.OFF)),
        (r"(?:ARCSET|WVON|WVOF)\b.*|TSYNC \d+ SNUM=2", lambda _: None),
        (r"GETS ((?:B|I|D|PX?)\d{3}) (\$\w+)", _gets),
        (r"CNVRT (PX\d{3}) (PX\d{3}) (BF|RF|UF#)(?:\((\d+)\))?(?: TL#\(\d+\))?", _cnvrt),
        (r"SET ([BID]\d{3}|PX?\d{3}) (\S+)", _set),
        (r"(ADD|SUB|INC|DEC) ([BID]\d{3}|PX?\d{3})(?: (\S+))?", _change),
        (r"GETE (D\d{3}) (PX?\d{3}) \(([1-6])\)", _gete),
        (r"SETE (PX?\d{3}) \(([1-6])\) (\S+)", _sete),
        (rf"CLEAR {NUMBER} (\d{{1,3}})", _clear),
        (r"JUMP \*(\S+)(?: IF (.*))?", LineInterpreter.jump),
        (r"CALL JOB:(\S+)(?: IF (.*))?", _call),
        (r'MSG "(.*)"', LineInterpreter.message),
        (r"PAUSE(?: IF (.*))?", LineInterpreter.pause),
        (r"WAIT (\S+)(?: T=(\S+))?", LineInterpreter.wait),
        (r"DOUT OT#\((\d+)\) (ON|OFF)", lambda self, one, state: self.output("OT", int(one), on=state == "ON")),
        (r"ABORT", LineInterpreter.abort),
    )
    _BLOCKS: tuple[tuple[str, Callable[..., int | None]], ...] = (
        (r"IFTHENEXP (.*)", LineInterpreter.then),
        (r"ELSEEXP", LineInterpreter.otherwise),
        (r"WHILEEXP (.*)", _while),
        (r"ENDWHILE", lambda self, at: self.end_of(at, "ENDWHILE", "WHILEEXP", by=-1)),
        (
            rf"FOR {NUMBER} ?= ?(\S+) TO (\S+)",
            lambda self, at, n, *ends: self.count_from(at, n, *map(self.number, ends)),
        ),
        (r"NEXT [BID]\d{3}", LineInterpreter.count_on),
        (r"ENDIF", lambda _, __: None),
    )


def _values(T: FloatArray) -> tuple[float, ...]:
    return tuple(numbers_of(T, MM_DECIMALS, DEG_DECIMALS))
