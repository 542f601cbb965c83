r"""Taught points from an ABB RAPID module: robtargets, with the work object of the Move instructions that use them.

A robtarget does not name its work object; the instruction that moves to it does (``\WObj:=name``). Without this
argument it is ``wobj0``, the world, which is the base of a robot at the world's origin. Work objects declared in the
file give their values.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.controllers.abb.statements import Declaration, Statement, declarations, instruction, statements_of
from wpcal.controllers.abb.values import SYNTAX
from wpcal.controllers.language.grammar import Complaint, Grammar
from wpcal.controllers.run.expressions import Parser
from wpcal.core.arrays import LARGEST_MM
from wpcal.core.errors import FormatError, InputError
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

MOVE = re.compile(r"(?:Move|Arc|Search|Trigg)[A-Z]\w*", re.IGNORECASE)
LITERALS = replace(SYNTAX, levels=())
NAME = re.compile(r"(?!(?:TRUE|FALSE)\b)[A-Z]", re.IGNORECASE)  #: How a token begins that is the name of other data.
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
    statements = [*statements_of(text)]
    data = [*_data(statements, path, robtarget=_robtarget, jointtarget=_joints, wobjdata=_work_object)]
    frames = {name: T for each, name, T in data if each.kind == "wobjdata"}
    uses, written = _find_uses(statements), {name.lower(): name for name in frames}
    points = tuple(
        _point(name, each.line, pose, uses.get(each.name.lower(), _Uses()), frames, written)
        for each, name, pose in data
        if each.kind != "wobjdata"
    )
    return ProgramPoints(points, {name: T for name, T in frames.items() if T is not None})


def read_rapid_tools(text: str) -> dict[str, RigidTransform | str]:
    """Read ``PERS tooldata tGun:=[TRUE,[[x,y,z],[q1,q2,q3,q4]],[…]]``, as `Grammar.tools`; the load may be a name."""
    found: dict[str, RigidTransform | str] = {}
    for each in declarations(statements_of(text), "tooldata"):
        nameless = ['""' if NAME.match(token) else token for token in each.tokens]
        try:
            found |= {name: _tool(value) for name, value in _elements(each._replace(tokens=nameless))}
        except InputError as error:
            found[each.name] = str(error)
    return found


def _data(
    statements: Iterable[Statement], path: str | None, **read: Callable[[Any], Any]
) -> Iterator[tuple[Declaration, str, Any]]:
    """Yield declared data, the names of their elements, and what the function of their type reads from the values."""
    for each in declarations(statements, *read):
        try:
            yield from [(each, name, read[each.kind](value)) for name, value in _elements(each)]
        except InputError as error:
            raise FormatError(f"{each.name}: {error}", path=path, line=each.line) from None


def _elements(each: Declaration) -> Iterator[tuple[str, Any]]:
    """Yield one value, or those of an array."""
    value = Parser(each.tokens, LITERALS).whole()
    if not each.size:
        yield each.name, value
    elif not isinstance(value, list) or "," in each.size:
        raise InputError("expected an array of one dimension")
    else:
        yield from ((f"{each.name}{{{index}}}", single) for index, single in enumerate(value, start=1))


def _robtarget(value: Any) -> RigidTransform | str:
    """Return the pose, or why there is none."""
    orientation = value[1] if isinstance(value, list) and len(value) > 1 else None
    if isinstance(orientation, list) and orientation == [0.0] * 4:
        return "was never taught: all four numbers of its orientation are 0"
    return _pose(value)


def _tool(value: Any) -> RigidTransform:
    pose = value[1] if isinstance(value, list) and len(value) > 1 else None
    return _pose(pose).relabelled(target="flange", source="tool")


def _pose(value: Any) -> RigidTransform:
    """Read ``[[x,y,z],[q1,q2,q3,q4]]``, mm and w first."""
    try:
        return _transform(_vector(value[0]), _vector(value[1]))
    except (InputError, TypeError, ValueError, IndexError) as error:
        raise InputError(f"expected [x,y,z],[q1,q2,q3,q4]: {error}") from None


def _vector(values: Any) -> np.ndarray[Any, Any]:
    """Return a list of numbers as an array. A list can also hold TRUE, FALSE and strings."""
    if not isinstance(values, list) or not all(type(value) in (float, int) for value in values):
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
    if not abs((length := math.hypot(*q_wxyz)) - 1.0) <= UNIT_QUATERNION_ATOL:
        raise InputError(f"the quaternion has length {length:.4g}")
    return RigidTransform(rotation_from_quaternion(np.roll(q_wxyz, -1)), place, "base", "frame")


def _work_object(value: Any) -> RigidTransform | None:
    """Return uframe @ oframe; None if a robot or another unit carries the work object."""
    if not isinstance(value, list) or len(value) != 5:
        raise InputError("expected the five parts of a wobjdata")
    robhold, _, ufmec, uframe, oframe = value
    if robhold or ufmec:
        return None
    user, object_ = _pose(uframe), _pose(oframe)
    return RigidTransform(user.R @ object_.R, user.apply(object_.t_mm), "base", "frame")


def _find_uses(statements: Iterable[Statement]) -> dict[str, _Uses]:
    """Find the work objects and tools of every name that is in the place of a target in a Move."""
    uses: dict[str, _Uses] = {}
    for _, tokens in statements:
        moves = (at for at, one in enumerate(tokens[:-1]) if MOVE.fullmatch(one) and tokens[at + 1] not in {"(", ":"})
        if (move := next(moves, None)) is None:
            continue
        arguments, options = instruction(tokens[move + 1 :])
        *targets, tool = arguments or [[]]
        for target in targets:
            if len(target) == 1 or target[1:2] == ["{"]:
                found = uses.setdefault(target[0].lower(), _Uses())
                found.frames.add("".join(options.get("WOBJ", ["wobj0"])).lower())
                found.tools.add("".join(tool).lower())
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


HELD = "the part in the hand of robot 2"  #: In the header of programs of coordinated motion.


def _judge_held(lines: list[str], _path: Path) -> Iterator[Complaint]:
    """Yield what is wrong with the work object in the hand of robot 2."""
    text = "\n".join(lines)
    if HELD not in " ".join(text[: text.find("PERS")].replace("!", " ").split()):
        return
    names = set[str]()
    for each in declarations(statements_of(text), "wobjdata"):
        names.add(each.name.upper())
        robhold, is_programmed, unit = [*"".join(each.tokens).upper().strip("[").split(","), "", ""][:3]
        if (robhold, is_programmed) != ("FALSE", "FALSE"):
            yield 'the work object does not move with a robot: expected [FALSE,FALSE,"ROB_2",…', each.line
        elif (carrier := unit.strip('"')) != "ROB_2":
            yield f"the work object is in the hand of {carrier or 'nobody'}: expected ROB_2", each.line
    for number, line in enumerate(lines, 1):
        used = re.search(r"\\WObj:=(\w+)", line)
        if "\\ID:=" in line and used and used[1].upper() not in names:
            yield f"a move in {used[1]}, which is not the held work object", number


GRAMMAR = Grammar(
    comment=r"^[ \t]*+!",
    harmless=r'(?:(?:WaitTime|WaitDI|WaitDO|SetDO|Set|Reset|PulseDO) [\w\\:=,. ]*|TPWrite "[^"]*"|TPErase|Stop|'
    r"Conf[JL]\\O(?:n|ff));",
    read=read_rapid,
    poses_in=(".mod", ".prg", ".sys"),
    touches={".mod": r"\bwptO_\w+"},
    results=r"wptP_",
    in_step=r"(?i)^[ \t]*+SyncMoveO(?:n|ff)\b",
    mark=r"(?i)\\ID:=(\d{1,9}+),",
    judge_step=_judge_held,
    tools=read_rapid_tools,
    tools_in_words="a tooldata (RAPID)",
)
