"""Taught points from a KUKA data list (``.dat``): E6POS, POS and FRAME with the base that FDAT names.

A point ``XP1`` taught in an inline form has its base and tool in ``FP1`` (FDAT): ``BASE_NO``, ``TOOL_NO`` and
``IPO_FRAME``. Its name is ``P1``, as on the pendant. ``BASE_DATA[n]`` and FRAME variables of the same file give the
values of frames; in a file without positions, as ``$config.dat``, these frames are the taught points.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from wpcal.core.errors import FormatError, InputError
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

DECLARATION = re.compile(
    r"^\s*(?:DECL\s+)?(?:GLOBAL\s+)?(?:CONST\s+)?(?:(?P<type>\w+)\s+)?(?P<name>\$?\w+(?:\[\d+\])?)\s*=\s*\{(?P<body>.*)\}",
    re.IGNORECASE,
)
FIELD = re.compile(r"(?:^|,)\s*+(\w++)\s++([^\s,{}]++)")
POSITION_TYPES = frozenset({"e6pos", "e3pos", "pos"})
JOINT_TYPES = frozenset({"e6axis", "e3axis", "axis"})
PLACE = ("x", "y", "z", "c", "b", "a")  #: A, B, C turn about z, y, x.
AXES = ("a1", "a2", "a3", "a4", "a5", "a6")


def read_krl(text: str, path: str) -> ProgramPoints:
    """Read a data list. Raises `FormatError` when a position lacks a coordinate."""
    positions: list[tuple[str, int, RigidTransform | JointValues | None]] = []
    frames: dict[str, RigidTransform] = {}
    taught: list[tuple[str, int, RigidTransform]] = []
    used: dict[str, dict[str, str]] = {}
    for kind, name, number, fields in _declarations(text):
        if kind == "frame":
            frames[name.removeprefix("BASE_DATA[").removesuffix("]")] = pose = _pose(fields, name, path, number)
            if np.any(pose.t_mm):
                taught.append((name, number, pose))
        elif kind in POSITION_TYPES:
            positions.append((name, number, _pose(fields, name, path, number)))
        elif kind in JOINT_TYPES:
            positions.append((name, number, joint_values([fields.get(key, "") for key in AXES])))
        elif kind == "fdat":
            used[name.lower()] = fields
    points = [_point(name, line, pose, used.get(f"f{name[1:]}".lower()), path) for name, line, pose in positions]
    if not points:  # frames that were taught as points, as in $config.dat
        points = [ProgramPoint(name, line, pose.t_mm, pose.R, BASE) for name, line, pose in taught]
    return ProgramPoints(tuple(points), frames)


def _declarations(text: str) -> Iterator[tuple[str, str, int, dict[str, str]]]:
    """Yield type, name, line and parts of every structure with a value; elements of BASE_DATA are frames."""
    for number, line in enumerate(text.splitlines(), start=1):
        if match := DECLARATION.match(line):
            kind, name = (match["type"] or "").lower(), match["name"]
            fields = {key.lower(): value for key, value in FIELD.findall(match["body"].removeprefix("FRAME:"))}
            yield "frame" if re.fullmatch(r"BASE_DATA\[\d+\]", name, re.IGNORECASE) else kind, name, number, fields


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
