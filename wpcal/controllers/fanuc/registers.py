"""Positions of FANUC that are no program: position registers (``posreg.va``) and the page ``curpos.dg``.

The controller drops the zero before the point of small numbers (``-.123``) and prints asterisks where a number does not
fit or was never set. ``posreg.va`` names neither user frame nor tool; ``curpos.dg`` has the position in the world.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from wpcal.core.transform import RigidTransform
from wpcal.taught.programs import BASE, ProgramPoint, ProgramPoints, stored_pose, unusable_point

POSITIONS = re.compile(r"^\[\*POSREG\*\]\$POSREG\b", re.MULTILINE)
POSITION = re.compile(r"^\s*+\[1,(?P<number>\d{1,5})\]\s*+=\s*+'(?P<comment>[^'\n]*+)'(?P<rest>.*)$")
OTHER = re.compile(r"^\s*+\[")
WORLD = re.compile(r"^CURRENT WORLD POSITION:", re.MULTILINE)
TOOL = re.compile(r"^Frame #:\s*\S+\s+Tool #:\s*(\S+)\s*$", re.MULTILINE)
COORDINATE = re.compile(r"\b([XYZWPR]):\s*+([^\s:]{1,40}+)")
JOINT = re.compile(r"\bJ[1-9]\s*+=")
KEYS = "XYZWPR"


@dataclass(frozen=True, slots=True, eq=False)
class Register:
    """A position register of motion group 1."""

    number: int
    comment: str
    line: int  #: Of the file, from 1 on.
    pose: RigidTransform | str  #: Or why it is none.


def rows_behind(head: re.Pattern[str], text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines of a section of registers, and their numbers in the file."""
    start = head.search(text)
    first = 0 if start is None else text.count("\n", 0, start.start())
    for number, line in enumerate(text.splitlines()[first + 1 :], first + 2):
        if line.startswith("[*"):
            return
        yield number, line


def registers_of(text: str, path: str) -> Iterator[Register]:
    """Yield the position registers of ``posreg.va``. Raises `FormatError` when a coordinate is not a number."""
    found: list[tuple[re.Match[str], int, list[str]]] = []
    body: list[str] = []
    for number, line in rows_behind(POSITIONS, text):
        match = POSITION.match(line)
        if match:
            body = [match["rest"]]
            found.append((match, number, body))
        elif OTHER.match(line):
            body = []
        else:
            body.append(line)
    for match, line_number, rows in found:
        number = int(match["number"])
        yield Register(number, match["comment"].strip(), line_number, _pose("\n".join(rows), f"PR[{number}]", path))


def _pose(text: str, name: str, path: str) -> RigidTransform | str:
    if "Uninitialized" in text:
        return "is not initialised"
    if JOINT.search(text):
        return "is stored as joint angles"
    values = dict(COORDINATE.findall(text))
    if any("*" in value for value in values.values()):
        return "has coordinates that the controller prints as asterisks"
    missing = [key for key in KEYS if key not in values]
    if missing:
        return f"lacks {', '.join(missing)}"
    return stored_pose([(key, values[key]) for key in KEYS], name, path, 0)


def read_registers(text: str, path: str) -> ProgramPoints:
    """Read taught points from position registers; those that were never taught are left out.

    A point's name is its comment if no other one has it, and otherwise ``PR3``.
    """
    found = [each for each in registers_of(text, path) if each.pose != "is not initialised"]
    comments = Counter(each.comment for each in found)
    points = []
    for each in found:
        name = each.comment if each.comment and comments[each.comment] == 1 else f"PR{each.number}"
        if isinstance(each.pose, str):
            points.append(unusable_point(name, each.line, each.pose))
        else:
            points.append(ProgramPoint(name, each.line, each.pose.t_mm, each.pose.R))
    return ProgramPoints(tuple(points))


def read_page(text: str, path: str) -> ProgramPoints:
    """Read the current position of motion group 1 in the world; the world is the base."""
    start = WORLD.search(text)
    assert start is not None
    line, tool = text.count("\n", 0, start.start()) + 1, TOOL.search(text)
    pose = _pose("\n".join(text[start.end() :].splitlines()[:8]), "curpos", path)
    if isinstance(pose, str):
        return ProgramPoints((unusable_point("curpos", line, pose),))
    at_flange = tool is not None and tool[1] == "0"
    return ProgramPoints((ProgramPoint("curpos", line, pose.t_mm, pose.R, BASE, at_flange=at_flange),))
