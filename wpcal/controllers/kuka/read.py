"""Taught points from a KUKA data list (``.dat``): E6POS, POS and FRAME with the base that FDAT names.

A point ``XP1`` taught in an inline form has its base and tool in ``FP1`` (FDAT): ``BASE_NO``, ``TOOL_NO`` and
``IPO_FRAME``. Its name is ``P1``, as on the pendant. ``BASE_DATA[n]`` and FRAME variables of the same file give the
values of frames; in a file without positions, as ``$config.dat``, these frames are the taught points.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from wpcal.controllers.kuka.values import declaration_of, rows_of_krl
from wpcal.controllers.language.grammar import ENCODING, Complaint, Grammar
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes
from wpcal.core.numbers import parse_whole_number
from wpcal.core.transform import RigidTransform
from wpcal.taught.programs import (
    BASE,
    JointValues,
    ProgramPoint,
    ProgramPoints,
    ProgramReader,
    frame_from_angles,
    joint_values,
    stored_pose,
    unusable_point,
)

TOOL = re.compile(r"\$TOOL|TOOL_DATA\[\d+\]", re.IGNORECASE)
FIELD = re.compile(r"(?:^\{(?:FRAME:)?|,)\s*+(\w++)\s++([^\s,{}]++)")
POSITION_TYPES = frozenset({"E6POS", "E3POS", "POS"})
JOINT_TYPES = frozenset({"E6AXIS", "E3AXIS", "AXIS"})
PLACE = ("x", "y", "z", "c", "b", "a")  #: A, B, C turn about z, y, x.
AXES = ("a1", "a2", "a3", "a4", "a5", "a6")


def read_krl(text: str, path: str) -> ProgramPoints:
    """Read a data list. Raises `FormatError` when a position lacks a coordinate."""
    stated = [*_declarations(text)]
    frames = [(name, line, _pose(fields, name, path, line)) for kind, name, line, fields in stated if kind == "FRAME"]
    used = {name.lower(): fields for kind, name, _, fields in stated if kind == "FDAT"}
    points = [
        _point(name, line, _position(kind, fields, name, path, line), used.get(f"f{name[1:]}".lower()), path)
        for kind, name, line, fields in stated
        if kind in POSITION_TYPES | JOINT_TYPES
    ]
    if not points:  # frames that were taught as points, as in $config.dat
        points = [ProgramPoint(name, line, T.t_mm, T.R, BASE) for name, line, T in frames if np.any(T.t_mm)]
    own = {name.removeprefix("BASE_DATA[").removesuffix("]"): T for name, _, T in frames}
    return ProgramPoints(tuple(points), own)


def read_krl_tools(text: str) -> dict[str, RigidTransform | str]:
    """Read ``TOOL_DATA[3]={X …,Y …,Z …,A …,B …,C …}`` and ``$TOOL={…}``, as `Grammar.tools`."""
    return {
        name.upper(): _pose(fields, name, "", number).relabelled(target="flange", source="tool")
        for _, name, number, fields in _declarations(text)
        if TOOL.fullmatch(name)
    }


def _declarations(text: str) -> Iterator[tuple[str, str, int, dict[str, str]]]:
    """Yield type, name, line and parts of every structure with a value; elements of BASE_DATA are frames."""
    for each in filter(None, map(declaration_of, rows_of_krl(text))):
        if each.value.startswith("{"):
            kind = "FRAME" if each.name.upper() == "BASE_DATA" and each.element[1:-1] else each.kind
            is_whole = "}" in each.value  # of a line that was cut off the last number may be another one
            fields = {key.lower(): value for key, value in FIELD.findall(each.value if is_whole else "")}
            yield kind, f"{each.name}{each.element}", each.line, fields


def _position(
    kind: str, fields: dict[str, str], name: str, path: str, line: int
) -> RigidTransform | JointValues | None:
    if kind in POSITION_TYPES:
        return _pose(fields, name, path, line)
    return joint_values([fields.get(key, "") for key in AXES])


def _pose(fields: dict[str, str], name: str, path: str, line: int) -> RigidTransform:
    missing = [key.upper() for key in PLACE if key not in fields]
    if missing:
        raise FormatError(f"{name} lacks {', '.join(missing)}", path=path, line=line)
    return stored_pose([(key.upper(), fields[key]) for key in PLACE], name, path, line)


def _point(
    name: str, line: int, pose: RigidTransform | JointValues | None, used: dict[str, str] | None, path: str
) -> ProgramPoint:
    shown = name[1:] if used is not None and name[:1] in "Xx" else name
    if not isinstance(pose, RigidTransform):
        return unusable_point(shown, line, "is stored as joint angles; store it as E6POS on the controller", pose)
    given = used or {}
    if given.get("ipo_frame", "").lower() == "#tcp":
        return unusable_point(shown, line, "was taught with a fixed tool (IPO_FRAME #TCP)")
    try:
        number = parse_whole_number(given.get("base_no", "-1"))
    except InputError as error:
        raise FormatError(f"{shown}: BASE_NO: {error}", path=path, line=line) from None
    frame = BASE if number == 0 else str(number) if number > 0 else None  # -1: not set
    return ProgramPoint(shown, line, pose.t_mm, pose.R, frame, at_flange=given.get("tool_no") == "0")


READER = ProgramReader(read_krl, lambda values: frame_from_angles([*values[:3], *values[:2:-1]]), "X,Y,Z,A,B,C")


_IN_STEP = re.compile(r"^[ \t]*+S(?:LIN|CIRC)[ \t]++(?:(\w++),)?(\w++)", re.IGNORECASE)


def _judge_step(lines: list[str], path: Path) -> Iterator[Complaint]:
    """Yield moves that do not wait for the other robot, and points that the data list does not have."""
    beside = path.with_suffix(".dat")
    names = set(re.findall(r"E6POS (\w+)=", read_bytes(beside).decode(ENCODING))) if beside.is_file() else None
    for number, line in enumerate(lines, 1):
        if re.match(r"[ \t]*+\$BASE=BASE_DATA", line, re.IGNORECASE):
            yield "the base does not move with robot 2: expected SBASE", number
        match = _IN_STEP.match(line)
        if match is None:
            continue
        if "$SYNC_ID" not in line.upper():
            yield "a move that does not wait for the other robot ($SYNC_ID)", number
        for name in (match[1], match[2]):
            if name and names is not None and name not in names:
                yield f"there is no point {name} in {beside.name}", number


GRAMMAR = Grammar(
    comment=r"^[ \t]*+;",
    harmless=r"(?:WAIT SEC [\d.]+|WAIT FOR \$IN\[\d+\]|\$OUT\[\d+\] ?= ?(?:TRUE|FALSE)|"
    r'MsgNotify\("[^"]*"\)|HALT)(?: ?;.*)?',
    read=read_krl,
    poses_in=(".dat",),
    moves_of=lambda path: path.with_suffix(".src"),
    stated_output=r"\$OUT\[(\d{1,9}+)\] switches the arc",
    touches={".src": r"\bWPFIND\(|\bTS_Search\(XWPT_", ".dat": r"\bWPO_\w+"},
    results=r"WPR_|WPPLACE\b|XWPT_\w+_M$",  # the last are between start and end of a search of TouchSense
    in_step=r"(?i)\$SYNC_ID\[\]",
    mark=r"(?i)\$SYNC_ID\[\]=\"(\w{1,40}+)\"",
    judge_step=_judge_step,
    tools=read_krl_tools,
    tools_in_words="TOOL_DATA or $TOOL (KRL)",
)
