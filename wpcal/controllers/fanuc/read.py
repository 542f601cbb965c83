"""Taught points of FANUC: the Cartesian positions of the first motion group in a TP program as ASCII (``.ls``).

A position names its user frame by number only. Frame 0 is the world, which is the base. Tool 0 is the flange. A point's
name is its comment (``P[1:"corner"]``) if no other point has the same comment, and otherwise ``P1``.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from wpcal.controllers.fanuc.registers import POSITIONS, WORLD, read_page, read_registers
from wpcal.controllers.language.grammar import Complaint, Grammar
from wpcal.core.errors import FormatError
from wpcal.taught.programs import (
    BASE,
    ProgramPoint,
    ProgramPoints,
    ProgramReader,
    frame_from_angles,
    joint_values,
    stored_pose,
    unusable_point,
)

POSITION = re.compile(
    r"^P\[(?P<number>[0-9]{1,20}+)(?:\s*+:\s*+\"(?P<comment>[^\"\n]*+)\")?\]\s*+\{(?P<body>[^{}]*+)\}", re.MULTILINE
)
"""All quantifiers are possessive, so that the search takes time in proportion to the text."""
GROUP_1 = re.compile(r"GP1\s*:(?P<body>.*?)(?=GP\d+\s*:|\Z)", re.DOTALL)
FRAME = re.compile(r"\bUF\s*:\s*([0-9]+)\b")  #: UF : F is the frame selected at run time.
TOOL = re.compile(r"\bUT\s*:\s*(\w+)")
COORDINATE = re.compile(r"\b([XYZWPR])\s*+=\s*+([^\s,=]{1,40}?)\s*+(?:mm|deg)\b")
REMOTE = re.compile(r"\bR[XYZ]\s*=")
"""Keys of a position with a remote tool: the robot holds the part, and the coordinates are those of the part."""
JOINT = re.compile(r"\bJ([1-6])\s*+=\s*+([^\s,=]{1,40}+)")


def read_fanuc(text: str, path: str) -> ProgramPoints:
    """Read the section ``/POS``, the position registers of ``posreg.va``, or the position of ``curpos.dg``.

    Raises `FormatError` when a position lacks a coordinate, or a coordinate is not a number.
    """
    if POSITIONS.search(text):
        return read_registers(text, path)
    if WORLD.search(text):
        return read_page(text, path)
    start = re.search(r"^/POS\b", text, re.MULTILINE)
    if start is None:
        raise FormatError("has no section /POS", path=path)
    found = list(POSITION.finditer(text, start.end()))
    comments = Counter((match["comment"] or "").strip() for match in found)
    points, line, counted = [], 1, 0
    for match in found:
        line, counted = line + text.count("\n", counted, match.start()), match.start()
        comment = (match["comment"] or "").strip()
        name = comment if comment and comments[comment] == 1 else f"P{match['number']}"
        points.append(_point(name, match["body"], path, line))
    return ProgramPoints(tuple(points))


def _point(name: str, body: str, path: str, line: int) -> ProgramPoint:
    group = GROUP_1.search(body)
    if group is None:
        return unusable_point(name, line, "has no position of motion group 1")
    angles = JOINT.findall(group["body"])
    if angles:
        what = "is stored as joint angles; show it as Cartesian on the pendant and save again"
        return unusable_point(name, line, what, joint_values([dict(angles).get(key, "") for key in "123456"]))
    return _in_space(name, group["body"], path, line)


def _in_space(name: str, text: str, path: str, line: int) -> ProgramPoint:
    values = dict(COORDINATE.findall(text))
    if any("*" in value for value in values.values()):
        return unusable_point(name, line, "was never taught")
    if REMOTE.search(text):
        return unusable_point(name, line, "was taught with a remote tool (RX, RY, RZ), where the robot holds the part")
    missing = [key for key in "XYZWPR" if key not in values]
    if missing:
        raise FormatError(f"{name} lacks {', '.join(missing)}", path=path, line=line)
    T = stored_pose([(key, values[key]) for key in "XYZWPR"], name, path, line)
    frame, tool = FRAME.search(text), TOOL.search(text)
    number = None if frame is None else frame[1]
    label = BASE if number == "0" else number
    return ProgramPoint(name, line, T.t_mm, T.R, label, at_flange=tool is not None and tool[1] == "0")


READER = ProgramReader(read_fanuc, frame_from_angles, "X,Y,Z,W,P,R")


_LINE = r"^[ \t]*+(?:\d++:)?[ \t]*+"


def _judge_step(lines: list[str], _path: Path) -> Iterator[Complaint]:
    """Yield positions without both groups, and moves in which the torch would not follow the part."""
    split = next((row for row, line in enumerate(lines) if line.startswith("/POS")), len(lines))
    blocks = {found["number"]: found["body"] for found in POSITION.finditer("\n".join(lines[split:]))}
    if not any(re.match(r"DEFAULT_GROUP\s*=\s*1,1,", line) for line in lines[:split]):
        yield "the program does not move both groups: expected DEFAULT_GROUP = 1,1,*,*,*", None
    before: str | None = None
    for number, line in enumerate(lines[:split], 1):
        if match := re.match(r"\s*\d+:\s*([JLC]) P\[(\d+)", line):
            yield from ((what, number) for what in _complaints(line, match[1], match[2], before, blocks))
            before = match[2]


def _complaints(line: str, kind: str, name: str, before: str | None, blocks: dict[str, str]) -> Iterator[str]:
    """Yield what is wrong with a move to a position, which comes behind one to the position `before`."""
    if name not in blocks:
        yield f"there is no position P[{name}]"
    elif "GP1:" not in blocks[name] or "GP2:" not in blocks[name]:
        yield f"P[{name}] does not hold both groups"
    leader = {one: block.partition("GP2:")[2].split() for one, block in blocks.items() if one in (before, name)}
    rests = before is not None and leader.get(before) == leader.get(name)
    if kind == "L" and "COORD" not in line and not rests:
        yield "a move of both groups without COORD: the torch would not follow the part"


GRAMMAR = Grammar(
    comment=f"{_LINE}!",
    harmless=r"(?:WAIT +[\d.]+\(sec\)|WAIT [DR]I\[\d+\]=(?:ON|OFF)|[DR]O\[\d+\]=(?:ON|OFF)|"
    r"MESSAGE\[[^\]]*\]|PAUSE|LINE_COUNT *= *\d+) *;?",
    read=read_fanuc,
    poses_in=(".ls",),
    touches={".ls": r"\bSkip,LBL\[\d+\],PR\[|\bSearch Start\["},
    in_step=r"^[ \t]*+\d++:[LC] [^\n;]*\bCOORD\b",
    judge_step=_judge_step,
    calls=r"^[ \t]*+(?:\d++:)?[ \t]*+CALL (?P<name>[\w.]++)",
)
