r"""Taught points from an ABB RAPID module: robtargets, with the work object of the Move instructions that use them.

A robtarget does not name its work object; the instruction that moves to it does (``\WObj:=name``). Without this
argument it is ``wobj0``, the world, which is the base of a robot at the world's origin. Work objects declared in the
file give their values.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from wpcal.core.arrays import LARGEST_MM
from wpcal.core.errors import FormatError, InputError
from wpcal.core.numbers import parse_number
from wpcal.core.rotations import rotation_from_quaternion
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed
from wpcal.taught.programs import (
    BASE,
    JointValues,
    ProgramPoint,
    ProgramPoints,
    ProgramReader,
    joint_values,
    unusable_point,
)

COMMENT_OR_STRING = re.compile(r'"(?:[^"\n]|"")*"|![^\n]*')
DECLARATION = re.compile(
    r"\b(?:CONST|PERS|VAR)\s++(?P<type>robtarget|jointtarget|wobjdata)\s++(?P<name>\w++)\s*+"
    r"(?:(?P<array>\{[^{}]*+\})\s*+)?:=",
    re.IGNORECASE,
)
"""The start of a declaration. Its quantifiers are possessive: the search takes time in proportion to the text."""
MOVE = re.compile(r"\b(?:Move|Arc|Search|Trigg)[A-Z]\w*+(?=[\s\\])", re.IGNORECASE)
WORK_OBJECT = re.compile(r"\\\s*+WObj\s*+:=\s*+(\w++)", re.IGNORECASE)
TOKEN = re.compile(
    r'[\[\],]|"[^"]*"|TRUE\b|FALSE\b|[-+]?(?:[0-9]++\.?[0-9]*+|\.[0-9]++)(?:E[-+]?[0-9]++)?|\S', re.IGNORECASE
)
MOST_LEVELS = 8  #: Brackets in one another: an array of work objects needs four.
NOT_CONNECTED = 9e9
"""What a controller writes for an external axis that it does not have: the largest number in a target."""
UNIT_QUATERNION_ATOL = 1e-3  #: Controllers print nine digits, people type four.


@dataclass(frozen=True, slots=True)
class _Uses:
    """The work objects and tools of the moves to a target, lower case."""

    frames: set[str] = field(default_factory=set)
    tools: set[str] = field(default_factory=set)


_Target = RigidTransform | JointValues | str | None
"""A pose; joint values, None if they cannot be read; or the reason why there is neither."""


def read_rapid(text: str, path: str) -> ProgramPoints:
    """Read a module. Raises `FormatError` when a value breaks the syntax or a quaternion is not of unit length."""
    plain = COMMENT_OR_STRING.sub(_blank, text)
    targets: list[tuple[str, int, _Target]] = []
    frames: dict[str, RigidTransform | None] = {}
    for statement, first_line in _statements(plain):
        match = DECLARATION.search(statement)
        if match is None:
            continue
        line = first_line + statement.count("\n", 0, match.start())
        kind, name, value = match["type"].lower(), match["name"], _parse(statement[match.end() :], path, line)
        for element, single in _elements(name, match["array"], value, path, line):
            if kind == "wobjdata":
                frames[element] = _work_object(single, element, path, line)
                continue
            is_joint = kind == "jointtarget"
            targets.append((element, line, _joints(single) if is_joint else _robtarget(single, element, path, line)))
    uses = _find_uses(plain)
    written = {name.lower(): name for name in frames}
    points = tuple(
        _point(*target, uses.get(target[0].split("{")[0].lower(), _Uses()), frames, written) for target in targets
    )
    return ProgramPoints(points, {name: T for name, T in frames.items() if T is not None})


def _statements(plain: str) -> Iterator[tuple[str, int]]:
    """Yield what ends with a semicolon, and the line on which it begins."""
    line = 1
    for statement in plain.split(";")[:-1]:
        yield statement, line
        line += statement.count("\n")


def _blank(match: re.Match[str]) -> str:
    """Remove a comment, and fill a string with spaces: neither holds instructions."""
    found = match[0]
    return f'"{" " * (len(found) - 2)}"' if found[0] == '"' else ""


def _parse(text: str, path: str, line: int) -> Any:
    """Read nested ``[…]`` of numbers, TRUE, FALSE and strings as lists."""
    tokens = iter(TOKEN.findall(text))
    try:
        value = _value(next(tokens, ""), tokens)
    except ValueError as error:
        raise FormatError(f"is not a value of RAPID: {error}", path=path, line=line) from None
    return value


def _value(token: str, tokens: Iterator[str], level: int = 0) -> Any:
    if token == "[":
        if level == MOST_LEVELS:
            raise ValueError(f"more than {MOST_LEVELS} brackets in one another")
        values: list[Any] = []
        for inner in tokens:
            if inner == "]":
                return values
            if inner != ",":
                values.append(_value(inner, tokens, level + 1))
        raise ValueError("a closing ] is missing")
    if token.upper() in ("TRUE", "FALSE"):
        return token.upper() == "TRUE"
    if token.startswith('"'):
        return token[1:-1]
    return parse_number(token or "nothing", most=NOT_CONNECTED)


def _elements(name: str, array: str | None, value: Any, path: str, line: int) -> list[tuple[str, Any]]:
    if array is None:
        return [(name, value)]
    if not isinstance(value, list) or "," in array:
        raise FormatError(f"{name}: expected an array of one dimension", path=path, line=line)
    return [(f"{name}{{{index}}}", single) for index, single in enumerate(value, start=1)]


def _robtarget(value: Any, name: str, path: str, line: int) -> RigidTransform | str:
    """Return the pose, or why there is none."""
    orientation = value[1] if isinstance(value, list) and len(value) > 1 else None
    if isinstance(orientation, list) and orientation == [0.0] * 4:
        return "was never taught: all four numbers of its orientation are 0"
    return _pose(value, name, path, line)


def _pose(value: Any, name: str, path: str, line: int) -> RigidTransform:
    """Read ``[[x,y,z],[q1,q2,q3,q4]]``, mm and w first."""
    try:
        return _transform(_vector(value[0]), _vector(value[1]))
    except (InputError, TypeError, ValueError, IndexError) as error:
        raise FormatError(f"{name}: expected [x,y,z],[q1,q2,q3,q4]: {error}", path=path, line=line) from None


def _vector(values: Any) -> np.ndarray[Any, Any]:
    """Return a list of numbers as an array. A list can also hold TRUE, FALSE and strings."""
    if not isinstance(values, list) or not all(isinstance(value, float) for value in values):
        raise InputError("expected numbers in brackets")
    return np.array(values, dtype=np.float64)


def _joints(value: Any) -> JointValues | None:
    """Read ``[[a1,…,a6],[external axes]]``, deg."""
    angles = value[0] if isinstance(value, list) and value else None
    return joint_values(angles) if isinstance(angles, list) else None


def _transform(place: np.ndarray[Any, Any], q_wxyz: np.ndarray[Any, Any]) -> RigidTransform:
    if place.shape != (3,) or q_wxyz.shape != (4,):
        raise InputError(f"got {place.size} and {q_wxyz.size} numbers")
    if not np.abs(place).max() <= LARGEST_MM:
        raise InputError(f"expected x, y, z of at most {LARGEST_MM:g} mm")
    if not abs(np.linalg.norm(q_wxyz) - 1.0) <= UNIT_QUATERNION_ATOL:
        raise InputError(f"the quaternion has length {np.linalg.norm(q_wxyz):.4g}")
    return RigidTransform(rotation_from_quaternion(np.roll(q_wxyz, -1)), place, "base", "frame")


def _work_object(value: Any, name: str, path: str, line: int) -> RigidTransform | None:
    """Return uframe @ oframe; None if a robot or another unit carries the work object."""
    if not isinstance(value, list) or len(value) != 5:
        raise FormatError(f"{name}: expected the five parts of a wobjdata", path=path, line=line)
    robhold, _, ufmec, uframe, oframe = value
    if robhold or ufmec:
        return None
    user, object_ = _pose(uframe, name, path, line), _pose(oframe, name, path, line)
    return RigidTransform(user.R @ object_.R, user.apply(object_.t_mm), "base", "frame")


def _find_uses(plain: str) -> dict[str, _Uses]:
    """Find the work objects and tools of every name that is in the place of a target in a Move."""
    uses: dict[str, _Uses] = {}
    for statement, _ in _statements(plain):
        match = MOVE.search(statement)
        if match is None:
            continue
        arguments = statement[match.end() :]
        wobj = WORK_OBJECT.search(arguments)
        positional = [part.split("\\")[0].strip() for part in arguments.split(",")]
        tool = positional[-1].lower()
        for argument in positional[:-1]:
            name = re.fullmatch(r"(\w+)\s*(?:\{[^}]*\})?", argument)
            if name:
                found = uses.setdefault(name[1].lower(), _Uses())
                found.frames.add(wobj[1].lower() if wobj else "wobj0")
                found.tools.add(tool)
    return uses


def _point(
    name: str, line: int, pose: _Target, uses: _Uses, frames: dict[str, RigidTransform | None], written: dict[str, str]
) -> ProgramPoint:
    if isinstance(pose, str):
        return unusable_point(name, line, pose)
    if not isinstance(pose, RigidTransform):
        return unusable_point(name, line, "is a jointtarget; store it as a robtarget on the controller", pose)
    if len(uses.frames) > 1:
        return unusable_point(name, line, f"is moved to in several work objects: {listed(sorted(uses.frames))}")
    frame = next(iter(uses.frames), None)
    if frame is not None and frame in written and frames[written[frame]] is None:
        fault = f"is in {written[frame]}, which the robot or another unit carries"
        return ProgramPoint(name, line, pose.t_mm, pose.R, fault=fault)
    label = BASE if frame == "wobj0" else frame if frame is None else written.get(frame, frame)
    return ProgramPoint(name, line, pose.t_mm, pose.R, label, at_flange="tool0" in uses.tools)


def _pendant_frame(values: Sequence[float]) -> RigidTransform:
    if len(values) != 7:
        raise InputError(f"expected 7 numbers, got {len(values)}")
    return _transform(np.asarray(values[:3]), np.asarray(values[3:]))


READER = ProgramReader(read_rapid, _pendant_frame, "X,Y,Z,Q1,Q2,Q3,Q4")
