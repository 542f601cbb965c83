"""What the text of a URScript program says. No person teaches points with such files."""

from __future__ import annotations

import re
from bisect import bisect_left

import numpy as np

from wpcal.controllers.language.grammar import Grammar
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.numbers import parse_number
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform
from wpcal.taught.programs import BASE, ProgramPoint, ProgramPoints

_NUMBER = r"\s*+([^,\]\s]{1,60}+)\s*+"  # possessive and bounded: the time stays proportional to the size
_POSE = r"p\[" + ",".join([_NUMBER] * 6) + r"\]"
_FRAME = re.compile(r"^[ \t]*+(\w++)[ \t]*+=\s*+" + _POSE, re.MULTILINE)
_MOVE = re.compile(r"(?:move[jlpc]\(|\bwpt_goal\s*+=|(?<=\))\s*+,)\s*+(?:pose_trans\(\s*+(\w++)\s*+,\s*+)?" + _POSE)
"""The first pose of a move, the second of `movec`, which follows the first, and where a search ends."""
_TOOL = re.compile(r"\b(set_tcp)\s*\(\s*p\s*\[" + ",".join([r"\s*([-+0-9.eE]+)\s*"] * 6) + r"\]", re.IGNORECASE)
MM_PER_M = 1000.0
LARGEST = 1e4


def read_script(text: str, path: str) -> ProgramPoints:
    """Read the poses of the moves: positions in m, rotation vectors in rad, in the frame of ``pose_trans``."""
    line_ends = [match.start() for match in re.finditer("\n", text)]
    frames = {}
    for match in _FRAME.finditer(text):
        p, R = _pose(match.groups()[1:], path, bisect_left(line_ends, match.start(1)) + 1)
        frames[match[1]] = RigidTransform(R, p, "base", "frame")
    points = []
    for number, match in enumerate(_MOVE.finditer(text), 1):
        line = bisect_left(line_ends, match.start()) + 1
        p, R = _pose(match.groups()[1:], path, line)
        if match[1] is not None and match[1] not in frames:
            raise FormatError(f"move {number}: the frame {match[1]} is not in the file", path=path, line=line)
        points.append(ProgramPoint(f"move {number}", line, p, R, BASE if match[1] is None else match[1]))
    return ProgramPoints(tuple(points), frames)


def _pose(cells: tuple[str, ...], path: str, line: int) -> tuple[FloatArray, FloatArray]:
    try:
        values = np.array([parse_number(cell) for cell in cells])
    except InputError as error:
        raise FormatError(f"a pose of six numbers: {error}", path=path, line=line) from None
    return MM_PER_M * values[:3], exp_rotation(values[3:])


def _tools(text: str) -> dict[str, RigidTransform]:
    """Read ``set_tcp(p[x,y,z,rx,ry,rz])``, in metres and a rotation vector."""
    found = {}
    for match in _TOOL.finditer(text):
        values = np.array([parse_number(cell, most=LARGEST) for cell in match.groups()[1:]])
        found["set_tcp"] = RigidTransform(exp_rotation(values[3:]), MM_PER_M * values[:3], "flange", "tool")
    return found


GRAMMAR = Grammar(
    comment=r"^[ \t]*+#",
    harmless=r'sleep\([\d.]+\)|(?:textmsg|popup)\("[^"]*"\)|'
    r"set_(?:standard|configurable|tool)_digital_out\(\d+, ?(?:True|False)\)",
    read=read_script,
    poses_in=(".script",),
    stated_output=r"standard digital output (\d{1,9}+) switches the arc",
    touches={".script": r"\bwpt_search\("},
    tools=_tools,
    tools_in_words="set_tcp (UR)",
)
