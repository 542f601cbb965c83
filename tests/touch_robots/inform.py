"""Yaskawa INFORM (`.JBI`), as far as touch programs use it (INFORM manuals of DX100, FS100, YRC1000).

Rules that matter here: `MOVL … SRCH RIN#(n)=ON` stops at the input; `GETS B… $B002` is 1 if it came and 0 if the
motion reached its end. `$PX003` is the detected place in Cartesian coordinates of the robot frame, `$PX002` the same
in pulses, which CNVRT turns into a user frame. Points of a job are in the frame that the header says. P, B, I, D
variables are in `VAR.DAT`; numbers of position variables are whole micrometres, printed with three digits, and angles
with four.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tests.touch_robots.robot import Array, Robot
from wpcal.controllers.run.machine import inverted, rigid
from wpcal.controllers.run.program import ProgramError, Run, StoppedError

MESSAGE_LENGTH = 32  #: Characters that MSG shows.
RANGES = {"B": (0, 255), "I": (-32768, 32767), "D": (-(2**31), 2**31 - 1)}


def place_of(values: Any) -> Array:
    """Return X Y Z Rx Ry Rz as a matrix: R = Rz Ry Rx."""
    return rigid(Rotation.from_euler("xyz", values[3:6], degrees=True), values[:3])


def values_of(T: Array) -> list[float]:
    angles = Rotation.from_matrix(T[:3, :3]).as_euler("xyz", degrees=True)
    return [*(round(float(v), 3) + 0.0 for v in T[:3, 3]), *(round(float(v), 4) + 0.0 for v in angles)]


@dataclass(frozen=True)
class Place:
    """A position variable: frame (PULSE, BASE, ROBOT, USER), number of the user frame, tool, values."""

    frame: str
    user: int
    tool: int
    values: tuple[float, ...]
    T_base_flange: Any = None
    """What pulses stand for."""


class Job:
    """One `.JBI` file."""

    def __init__(self, text: str) -> None:
        head, _, body = text.replace("\r", "").partition("//INST\n")
        lines = head.splitlines()
        if lines[0] != "/JOB" or not lines[1].startswith("//NAME ") or not body:
            raise ProgramError("a job has /JOB, //NAME and //INST")
        self.name = lines[1][7:].strip()
        if not re.fullmatch(r"[A-Z0-9_-]{1,32}", self.name):
            raise ProgramError(f"{self.name!r} is no name of a job")
        self.points: dict[str, Place] = {}
        self.counts: list[int] = []
        frame, user, tool, is_pulse = "", 0, 0, False
        for line in lines[2:]:
            if line.startswith("///NPOS "):
                self.counts = [int(v) for v in line[8:].split(",")]
            elif line.startswith("///USER "):
                user = int(line[8:])
            elif line.startswith("///TOOL "):
                tool = int(line[8:])
            elif line.startswith("///POSTYPE "):
                frame = line[11:].strip()
            elif line in {"///RECTAN", "///PULSE"}:
                is_pulse = line == "///PULSE"
            elif found := re.fullmatch(r"(C\d{5}|P\d{3,5})=([-\d., ]+)", line):
                values = tuple(float(v) for v in found[2].split(","))
                self.points[found[1]] = Place("PULSE" if is_pulse else frame, user, tool, values)
            elif not re.match(r"//POS$|///RCONF |///GROUP", line):
                raise ProgramError(f"unknown in the header: {line!r}")
        taught = sum(1 for name in self.points if name.startswith("C"))
        if not self.counts or self.counts[0] != taught:
            raise ProgramError(f"///NPOS says {self.counts[:1]} points, there are {taught}")
        rows = body.splitlines()
        at = next(i for i, row in enumerate(rows) if not row.startswith("///"))
        self.attributes, self.lines = rows[:at], rows[at:]
        if self.lines[0] != "NOP" or self.lines[-1] != "END":
            raise ProgramError("a job begins with NOP and ends with END")
        self.labels = {row.split()[0][1:]: i for i, row in enumerate(self.lines) if row.startswith("*")}
        if any(len(label) > 8 for label in self.labels):
            raise ProgramError("a label has more than 8 characters")


class Controller:
    """A controller with its variables; `tools` and `frames` are the tool files and user frames as they were set up."""

    def __init__(
        self,
        files: dict[str, str],
        robot: Robot,
        *,
        signal: int = 1,
        tools: dict[int, Array] | None = None,
        frames: dict[int, Array] | None = None,
        on_stop: Callable[[str], bool] = lambda _: False,
        level: str = "ON",
        input_name: str = "RIN#",
    ) -> None:
        self.robot, self.input, self.on_stop, self.level, self.run = robot, signal, on_stop, level, Run()
        self.jobs = {one.name: one for one in map(Job, files.values())}
        self.tools, self.frames = dict(tools or {}), dict(frames or {})
        self.numbers: dict[str, int] = {}
        self.places: dict[str, Place] = {}
        self.detected: Array | None = None
        self.is_found = 0
        self.job: Job | None = None
        self.tool = 0
        self.input_name = input_name

    # -- values ----------------------------------------------------------------------------------------------------

    def number(self, text: str) -> int:
        if re.fullmatch(r"-?\d+", text):
            return int(text)
        if re.fullmatch(r"[BID]\d{3}", text):
            return self.numbers.get(text, 0)
        raise ProgramError(f"{text!r} is no number")

    def set(self, name: str, value: int) -> None:
        low, high = RANGES[name[0]]
        if not low <= value <= high:
            raise ProgramError(f"{name} cannot hold {value}")
        self.numbers[name] = value

    def place(self, name: str) -> Place:
        assert self.job is not None
        name = name.replace("PX", "P")
        found = self.job.points.get(name) or self.places.get(name)
        if found is None:
            raise ProgramError(f"{name} is not taught")
        return found

    def _T_frame(self, place: Place) -> Array:
        if place.frame in {"ROBOT", "BASE"}:
            return np.eye(4)
        if place.frame == "USER" and place.user in self.frames:
            return self.frames[place.user]
        raise ProgramError(f"the frame {place.frame} {place.user} is not set")

    def _T_tool(self, number: int) -> Array:
        if number not in self.tools:
            raise ProgramError(f"the tool {number} is not set")
        return self.tools[number]

    # -- running ---------------------------------------------------------------------------------------------------

    def start(self, name: str) -> Run:
        try:
            self._job(name)
            self.run.is_finished = True
        except StoppedError:
            pass
        return self.run

    def _job(self, name: str) -> None:
        if name not in self.jobs:
            raise ProgramError(f"CALL JOB: {name} is not there")
        before, self.job = self.job, self.jobs[name]
        at = 0
        while self.job.lines[at] not in {"END", "RET"}:
            jump = self.execute(self.job.lines[at].strip())
            at = at + 1 if jump is None else jump
        self.job = before

    def execute(self, line: str) -> int | None:
        if line == "NOP" or line.startswith(("'", "*", "//")):
            if line.startswith("'") and len(line) > 33:
                raise ProgramError(f"a remark has at most 32 characters: {line!r}")
            return None
        for pattern, function in self._INSTRUCTIONS:
            if found := re.fullmatch(pattern, line):
                return function(self, *found.groups())
        raise ProgramError(f"unknown: {line!r}")

    def _movj(self, name: str) -> None:
        place = self.place(name)
        if place.frame == "PULSE":
            self.robot.joint_move()
        else:
            self.tool = place.tool
            goal = self._T_frame(place) @ place_of(place.values)
            self.robot.move(goal, self._T_tool(place.tool), is_line=False)

    def _movl(self, name: str, speed: str, rest: str | None) -> None:
        place = self.place(name)
        if place.frame == "PULSE":
            raise ProgramError("a line to pulses")
        self.tool = place.tool
        goal, T_tool = self._T_frame(place) @ place_of(place.values), self._T_tool(place.tool)
        if not rest or re.fullmatch(r" PL=\d", rest):
            self.robot.move(goal, T_tool)
            return
        found = re.fullmatch(r" SRCH (RIN#|IN#)\((\d+)\)=(ON|OFF)(?: T=(\d+\.\d+))?(?: DIS=(\d+\.\d+))?", rest)
        if found is None:
            raise ProgramError(f"unknown: {rest!r}")
        if (found[1], int(found[2]), found[3]) != (self.input_name, self.input, self.level):
            raise ProgramError(f"{rest}: the search does not wait for the touch")
        if found[5]:
            raise ProgramError("DIS: its meaning is not settled here")
        hit = self.robot.search(goal, T_tool, float(speed), is_edge=False)
        self.is_found = int(hit is not None)
        if hit is not None:
            self.detected = hit @ inverted(T_tool)

    def _gets(self, name: str, system: str) -> None:
        if system == "$B002":
            self.set(name, self.is_found)
            return
        if system in {"$PX000", "$PX001"}:
            T_base_flange: Any = self.robot.reading(np.eye(4))
        elif system in {"$PX002", "$PX003"}:
            T_base_flange = self.detected
        else:
            raise ProgramError(f"{system} is unknown")
        if not name.startswith("P"):
            raise ProgramError(f"GETS {name} {system}")
        if T_base_flange is None:  # nothing was detected yet: all pulses are zero
            T_base_flange = np.eye(4)
        if system in {"$PX000", "$PX002"}:
            place = Place("PULSE", 0, self.tool, (0.0,) * 6, T_base_flange)
        else:
            place = Place("ROBOT", 0, self.tool, tuple(values_of(T_base_flange @ self._T_tool(self.tool))))
        self.places[name.replace("PX", "P")] = place

    def _cnvrt(self, to: str, source: str, frame: str, user: str | None) -> None:
        place = self.place(source)
        if place.frame == "PULSE":
            T = place.T_base_flange @ self._T_tool(place.tool)
        else:
            T = self._T_frame(place) @ place_of(place.values)
        kind = {"BF": "BASE", "RF": "ROBOT", "UF#": "USER"}[frame]
        new = Place(kind, int(user or 0), place.tool, ())
        values = tuple(values_of(inverted(self._T_frame(new)) @ T))
        self.places[to.replace("PX", "P")] = Place(kind, new.user, place.tool, values)

    def _set(self, name: str, value: str) -> None:
        if name.startswith("P"):
            self.places[name.replace("PX", "P")] = self.place(value)
        else:
            self.set(name, self.number(value))

    def _change(self, word: str, name: str, by: str | None) -> None:
        step = {"ADD": 1, "SUB": -1, "INC": 1, "DEC": -1}[word] * (self.number(by) if by else 1)
        self.set(name, self.number(name) + step)

    def _gete(self, name: str, source: str, element: str) -> None:
        value = self.place(source).values[int(element) - 1]
        self.set(name, round(value * (1000.0 if int(element) <= 3 else 10000.0)))

    def _clear(self, name: str, count: str) -> None:
        first = int(name[1:])
        for number in range(first, first + int(count)):
            self.set(f"{name[0]}{number:03d}", 0)

    def _condition(self, text: str) -> bool:
        if found := re.fullmatch(r"(RIN#|IN#)\((\d+)\)=(ON|OFF)", text):
            if (found[1], int(found[2])) != (self.input_name, self.input):
                raise ProgramError(f"{text}: nothing is connected")
            return (self.robot.is_on() == (self.level == "ON")) == (found[3] == "ON")
        found = re.fullmatch(r"([BID]\d{3})(=|<>|<|>|<=|>=)(\S+)", text)
        if found is None:
            raise ProgramError(f"the condition {text!r} is unknown")
        a, b = self.number(found[1]), self.number(found[3])
        return {"=": a == b, "<>": a != b, "<": a < b, ">": a > b, "<=": a <= b, ">=": a >= b}[found[2]]

    def _jump(self, label: str, condition: str | None) -> int | None:
        assert self.job is not None
        if label not in self.job.labels:
            raise ProgramError(f"*{label} is not there")
        return self.job.labels[label] if condition is None or self._condition(condition) else None

    def _call(self, name: str, condition: str | None) -> None:
        if condition is None or self._condition(condition):
            self._job(name)

    def _message(self, text: str) -> None:
        if len(text) > MESSAGE_LENGTH:
            raise ProgramError(f"MSG shows {MESSAGE_LENGTH} characters: {text!r}")
        self.run.messages.append(text)

    def _pause(self, condition: str | None) -> None:
        if condition is None or self._condition(condition):
            self.run.stop(self.run.messages[-1] if self.run.messages else "", self.on_stop)

    def _wait(self, condition: str, seconds: str | None) -> None:
        if not self._condition(condition) and seconds is None:
            self.run.stop(f"WAIT {condition}", self.on_stop)

    def _output(self, number: str, state: str) -> None:
        self.run.outputs[f"OT{number}"] = state == "ON"

    def _abort(self) -> None:
        raise StoppedError("ABORT")

    _INSTRUCTIONS: tuple[tuple[str, Callable[..., int | None]], ...] = (
        (r"MOVJ (C\d{5}|P\d{3}) VJ=\d+\.\d+(?: PL=\d)?", _movj),
        (r"MOVL (C\d{5}|P\d{3}) V=(\d+\.\d+)( .*)?", _movl),
        (r"GETS ((?:B|I|D|PX?)\d{3}) (\$\w+)", _gets),
        (r"CNVRT (PX\d{3}) (PX\d{3}) (BF|RF|UF#)(?:\((\d+)\))?(?: TL#\(\d+\))?", _cnvrt),
        (r"SET ([BID]\d{3}|PX?\d{3}) (\S+)", _set),
        (r"(ADD|SUB|INC|DEC) ([BID]\d{3})(?: (\S+))?", _change),
        (r"GETE (D\d{3}) (P\d{3}) \((\d)\)", _gete),
        (r"CLEAR ([BID]\d{3}) (\d+)", _clear),
        (r"JUMP \*(\S+)(?: IF (.*))?", _jump),
        (r"CALL JOB:(\S+)(?: IF (.*))?", _call),
        (r"TIMER T=\d+\.\d+", lambda _: None),
        (r'MSG "(.*)"', _message),
        (r"PAUSE(?: IF (.*))?", _pause),
        (r"WAIT (\S+)(?: T=(\S+))?", _wait),
        (r"DOUT OT#\((\d+)\) (ON|OFF)", _output),
        (r"ABORT", _abort),
    )

    # -- files -----------------------------------------------------------------------------------------------------

    def backup(self) -> dict[str, str]:
        """Return `VAR.DAT`: a section for each kind of variable in the order of their numbers.

        That B, I and D are ten to a row, and P one, is public. What a row of P holds is not: here it is what a job has.
        """
        rows = ["//VAR", "///SHARE 100,100,100,100,100,128,128,128"]
        for kind in "BIDR":
            values = [self.numbers.get(f"{kind}{n:03d}", 0) for n in range(100)]
            rows += [f"///{kind}", *(",".join(map(str, values[i : i + 10])) for i in range(0, 100, 10))]
        rows.append("///P")
        rows += [_printed(self.places.get(f"P{number:03d}")) for number in range(128)]
        return {"VAR.DAT": "\r\n".join(rows) + "\r\n"}


def _printed(place: Place | None) -> str:
    values = (0.0,) * 6 if place is None else place.values
    return ",".join([*(f"{v:.3f}" for v in values[:3]), *(f"{v:.4f}" for v in values[3:])])
