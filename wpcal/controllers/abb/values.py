"""Values of RAPID: records with their parts, how they are read and printed."""

from __future__ import annotations

import operator
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.controllers.run.expressions import AND, COMPARE, OR, PRODUCT, SIGNS, SUM, Parser, Syntax
from wpcal.controllers.run.machine import Matrix, ProgramError, rigid
from wpcal.core.rotations import quaternion_from_rotation, rotation_from_quaternion

PARTS = {
    "pos": [("x", "num"), ("y", "num"), ("z", "num")],
    "orient": [(f"q{i}", "num") for i in (1, 2, 3, 4)],
    "pose": [("trans", "pos"), ("rot", "orient")],
    "confdata": [("cf1", "num"), ("cf4", "num"), ("cf6", "num"), ("cfx", "num")],
    "extjoint": [(f"eax_{i}", "num") for i in "abcdef"],
    "robjoint": [(f"rax_{i}", "num") for i in range(1, 7)],
    "jointtarget": [("robax", "robjoint"), ("extax", "extjoint")],
    "robtarget": [("trans", "pos"), ("rot", "orient"), ("robconf", "confdata"), ("extax", "extjoint")],
    "loaddata": [("mass", "num"), ("cog", "pos"), ("aom", "orient"), ("ix", "num"), ("iy", "num"), ("iz", "num")],
    "tooldata": [("robhold", "bool"), ("tframe", "pose"), ("tload", "loaddata")],
    "wobjdata": [("robhold", "bool"), ("ufprog", "bool"), ("ufmec", "string"), ("uframe", "pose"), ("oframe", "pose")],
    "speeddata": [("v_tcp", "num"), ("v_ori", "num"), ("v_leax", "num"), ("v_reax", "num")],
    "tasks": [("taskname", "string")],
    "zonedata": [("finep", "bool"), *((f"z{i}", "num") for i in range(6))],
}
PLAIN = {"num": 0, "dnum": 0, "bool": False, "string": "", "errnum": 0, "intnum": 0, "switch": False, "syncident": 0}
KINDS: dict[str, tuple[type, ...]] = {"string": (str,), "bool": (bool,), "num": (int, float), "dnum": (int, float)}
TOKEN = re.compile(
    r'"[^"]*"|(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?|[A-Za-z_]\w*|:=|<>|<=|>=|[-+*/=<>()\[\]{},;:.\\%?]'
)
SYNTAX = Syntax(
    TOKEN,
    ({**OR, "XOR": operator.xor}, AND, {"=": operator.eq, **COMPARE}, SUM, {**PRODUCT, "DIV": operator.floordiv}),
    {**SIGNS, "NOT": operator.not_},
    {"TRUE": True, "FALSE": False},
    aggregate=("[", "]"),
    index=("{", "}"),
)


@dataclass
class Record:
    """A value with parts."""

    kind: str
    values: list[Any]

    def index(self, part: str) -> int:
        """Return where a part is."""
        names = [name for name, _ in PARTS[self.kind]]
        if part not in names:
            raise ProgramError(f"{self.kind} has no part {part}")
        return names.index(part)

    def _numbers(self) -> Any:
        if self.kind != "pos":
            raise ProgramError(f"{self.kind} cannot be calculated with")
        return np.array(self.values, float)

    def __add__(self, other: Record) -> Record:
        return Record("pos", [float(v) for v in self._numbers() + other._numbers()])

    def __sub__(self, other: Record) -> Record:
        return Record("pos", [float(v) for v in self._numbers() - other._numbers()])

    def __mul__(self, other: Any) -> Record:
        return Record("pos", [float(v) for v in self._numbers() * float(other)])

    __rmul__ = __mul__

    def copy(self) -> Record:
        """Return a record that shares nothing."""
        return Record(self.kind, [v.copy() if isinstance(v, Record) else v for v in self.values])


def typed(kind: str, value: Any) -> Any:
    """Give an aggregate its type, and check it."""
    if isinstance(value, Record):
        if value.kind != kind:
            raise ProgramError(f"{value.kind} where {kind} is expected")
        return value.copy()
    if kind in PARTS:
        if not isinstance(value, list) or len(value) != len(PARTS[kind]):
            raise ProgramError(f"{value!r} is no {kind}")
        return Record(kind, [typed(k, v) for (_, k), v in zip(PARTS[kind], value, strict=True)])
    if kind in KINDS and type(value) not in KINDS[kind]:
        raise ProgramError(f"{value!r} is no {kind}")
    return value


def empty(kind: str) -> Any:
    """Return the value of data without one."""
    if kind in PARTS:
        return Record(kind, [empty(k) for _, k in PARTS[kind]])
    if kind not in PLAIN:
        raise ProgramError(f"the type {kind} is unknown")
    return PLAIN[kind]


def matrix(pose: Record) -> Matrix:
    """Return a pose or robtarget as a matrix: quaternions with the real part first, of length 1."""
    trans, rot = pose.values[pose.index("trans")].values, pose.values[pose.index("rot")].values
    if abs(np.linalg.norm(rot) - 1.0) > 1e-3:
        raise ProgramError(f"the orientation {rot} is not normalised")
    return rigid(rotation_from_quaternion(np.roll(np.array(rot, float), -1)), trans)


def pose_values(T: Matrix) -> list[Any]:
    """Return the values of a pose."""
    x, y, z, w = quaternion_from_rotation(T[:3, :3])
    return [[float(v) for v in T[:3, 3]], [float(v) for v in (w, x, y, z)]]


def printed(value: Any) -> str:
    """Print a value as the controller saves it: numbers in single precision with six digits."""
    if isinstance(value, Record):
        return "[" + ",".join(printed(v) for v in value.values) + "]"
    if isinstance(value, list):
        return "[" + ",".join(printed(v) for v in value) + "]"
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    if isinstance(value, str):
        return f'"{value}"'
    return f"{float(np.float32(value)) + 0.0:.6G}"


class RapidParser(Parser):
    """Knows arguments with a backslash."""

    def values(self, closing: str) -> list[Any]:
        """Return arguments; the last is those with a backslash, if there are any."""
        found: list[Any] = []
        options: dict[str, Any] = {}
        while self.peek() != closing:
            if self.peek() == ",":
                self.take()
            if self.peek() == "\\":
                self.take()
                name = self.take().upper()
                options[name] = True
                if self.peek() == ":=":
                    self.take()
                    options[name] = self.value()
            else:
                found.append(self.value())
        self.take(closing)
        return [*found, options] if options else found


def nested(record: Record) -> list[Any]:
    """Return a record as nested lists."""
    return [nested(v) if isinstance(v, Record) else v for v in record.values]
