"""What the text of a RAPID module says."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from pathlib import Path

import numpy as np

from wpcal.controllers.abb.read import read_rapid
from wpcal.controllers.language.grammar import Complaint, Grammar
from wpcal.core.errors import InputError
from wpcal.core.numbers import parse_number
from wpcal.core.rotations import rotation_from_quaternion
from wpcal.core.transform import RigidTransform

HELD = "the part in the hand of robot 2"  #: In the header of programs of coordinated motion.
UNIT_ATOL = 1e-2  #: Programs print quaternions with few digits.
LARGEST = 1e4
_NUMBERS = r"\s*([-+0-9.eE]+)\s*"
_TOOL = re.compile(
    rf"\btooldata\s+(\w+)\s*:=\s*\[\s*(?:TRUE|FALSE)\s*,\s*\[\s*\[{','.join([_NUMBERS] * 3)}\]\s*,"
    rf"\s*\[{','.join([_NUMBERS] * 4)}\]",
    re.IGNORECASE,
)
_WORK_OBJECT = re.compile(r"\bwobjdata (\w++):=\[(\w++),(\w++),\"(\w*+)\"", re.IGNORECASE)


def _tools(text: str) -> dict[str, RigidTransform]:
    """Read ``PERS tooldata tGun:=[TRUE,[[x,y,z],[q1,q2,q3,q4]],[…]]``."""
    found = {}
    for match in _TOOL.finditer(text):
        values = np.array([parse_number(cell, most=LARGEST) for cell in match.groups()[1:]])
        q = np.roll(values[3:], -1)
        if not abs(float(np.linalg.norm(q)) - 1.0) <= UNIT_ATOL:
            raise InputError(f"tooldata {match[1]}: the quaternion has length {np.linalg.norm(q):.4g}")
        found[match[1]] = RigidTransform(rotation_from_quaternion(q), values[:3], "flange", "tool")
    return found


def _judge_held(lines: list[str], _path: Path) -> Iterator[Complaint]:
    """Yield what is wrong with the work object in the hand of robot 2."""
    text = "\n".join(lines)
    if HELD not in re.sub(r"\s*!\s*", " ", text[: text.find("PERS")]):
        return
    held = {match[1] for match in _WORK_OBJECT.finditer(text)}
    for number, line in enumerate(lines, 1):
        yield from ((what, number) for what in _complaints(line, held))


def _complaints(line: str, held: Collection[str]) -> Iterator[str]:
    found, used = _WORK_OBJECT.search(line), re.search(r"\\WObj:=(\w+)", line)
    if found and (found[2].upper(), found[3].upper()) != ("FALSE", "FALSE"):
        yield 'the work object does not move with a robot: expected [FALSE,FALSE,"ROB_2",…'
    elif found and found[4].upper() != "ROB_2":
        yield f"the work object is in the hand of {found[4] or 'nobody'}: expected ROB_2"
    if "\\ID:=" in line and used and used[1] not in held:
        yield f"a move in {used[1]}, which is not the held work object"


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
    tools=_tools,
    tools_in_words="a tooldata (RAPID)",
)
