"""Read the poses of written programs back, with the readers of the controllers; URScript and VAL3 are read here.

No person teaches points with files of these two languages, so wpcal has no other reader of them.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wpcal.controllers.registry import controller_of_file
from wpcal.controllers.taught_program import ENCODING, parse_program
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.numbers import parse_number
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform
from wpcal.taught.programs import BASE

URSCRIPT, VAL3 = ".script", ".dtx"
_NUMBER = r"\s*+([^,\]\s]{1,60}+)\s*+"  # possessive and bounded: the time stays proportional to the size
_POSE = r"p\[" + ",".join([_NUMBER] * 6) + r"\]"
_UR_FRAME = re.compile(r"^[ \t]*+(\w++)[ \t]*+=\s*+" + _POSE, re.MULTILINE)
UR_MOVE = re.compile(r"(?:move[jlpc]\(|\bwpt_goal\s*+=|(?<=\))\s*+,)\s*+(?:pose_trans\(\s*+(\w++)\s*+,\s*+)?" + _POSE)
"""The first pose of a move, the second of `movec`, which follows the first, and where a search ends."""


@dataclass(frozen=True, slots=True, eq=False)
class ReadPose:
    """One pose of a program as a controller would take it."""

    name: str  #: Of the point, or its number.
    line: int | None
    p_base: FloatArray  #: shape (3,). Tool centre point in `base`, mm.
    R_base: FloatArray  #: shape (3, 3). Axes of the tool in `base`.
    #: False if the file does not say where its user frame is: position and axes are then in that frame.
    in_base: bool = True


def is_weld_program(path: Path) -> bool:
    """Tell by the suffix whether the poses of a file can be read back."""
    controller = controller_of_file(path)
    return path.suffix.lower() in (URSCRIPT, VAL3) or (controller is not None and controller.reads_back)


def read_poses_back(
    raw: bytes, path: Path, T_base_part: RigidTransform | None, *, is_carried: bool = False
) -> list[ReadPose]:
    """Return the poses of a program's file in `base`.

    Parameters
    ----------
    raw : Of the file.
    path : Its suffix tells the language. Messages name it.
    T_base_part : The user frame of points whose own frame is not in the file: the part as calibrated.
    is_carried : Whether points in a frame that another unit carries are taken as points in the part.

    Raises
    ------
    InputError : When no reader knows the suffix.
    FormatError
        When the file breaks its format, or a point of a weld program cannot be used. Joint values are left out, and so
        are points of other programs that have no coordinates.
    """
    suffix = path.suffix.lower()
    if suffix == URSCRIPT:
        return _urscript(raw.decode(ENCODING), str(path))
    if suffix == VAL3:
        return _val3(raw, str(path))
    program = parse_program(raw, path)
    poses = []
    for point in program.found.points:
        if point.joints is not None or (point.fault and T_base_part is None):
            continue
        if point.fault and not (is_carried and np.isfinite(point.p_mm).all()):
            raise FormatError(f"point {point.name}: {point.fault}", path=str(path), line=point.line)
        T = None if point.at_flange else _frame_of(point.frame, program.found.frames, T_base_part)
        if T is None:
            poses.append(ReadPose(point.name, point.line, point.p_mm, point.R, in_base=False))
        else:
            poses.append(ReadPose(point.name, point.line, T.apply(point.p_mm), T.R @ point.R))
    return poses


def _frame_of(
    frame: str | None, carried: Mapping[str, RigidTransform], T_base_part: RigidTransform | None
) -> RigidTransform | None:
    if frame == BASE:
        return RigidTransform.identity(target="base", source="frame")
    return carried.get(frame or "", T_base_part)


def _urscript(text: str, path: str) -> list[ReadPose]:
    """Read the moves of a script: positions in m, rotation vectors in rad, in the frame of ``pose_trans``."""
    line_ends = [match.start() for match in re.finditer("\n", text)]
    frames = {
        match[1]: _ur_pose(match.groups()[1:], path, bisect_left(line_ends, match.start(1)) + 1)
        for match in _UR_FRAME.finditer(text)
    }
    poses = []
    for number, match in enumerate(UR_MOVE.finditer(text), 1):
        line = bisect_left(line_ends, match.start()) + 1
        p, R = _ur_pose(match.groups()[1:], path, line)
        if match[1] is not None:
            if match[1] not in frames:
                raise FormatError(f"move {number}: the frame {match[1]} is not in the file", path=path, line=line)
            p0, R0 = frames[match[1]]
            p, R = p0 + R0 @ p, R0 @ R
        poses.append(ReadPose(f"move {number}", line, p, R))
    return poses


def _ur_pose(cells: tuple[str, ...], path: str, line: int) -> tuple[FloatArray, FloatArray]:
    values = _numbers(cells, path, line)
    return 1000.0 * values[:3], exp_rotation(values[3:])


def _numbers(cells: tuple[str | None, ...], path: str, line: int | None) -> FloatArray:
    try:
        return np.array([parse_number(cell or "") for cell in cells])
    except InputError as error:
        raise FormatError(f"a pose of six numbers: {error}", path=path, line=line) from None


def _val3(raw: bytes, path: str) -> list[ReadPose]:
    """Read the points of a database: mm, and degrees of ``Rx Ry Rz``, in the frame that is their father."""
    try:
        database = ET.fromstring(raw)
    except ET.ParseError as error:
        line, column = error.position
        raise FormatError(f"is not XML: {error.msg}", path=path, line=line, column=column) from None
    data = {e.get("name", ""): e for e in database.iter() if e.tag.rpartition("}")[2] == "Data"}
    frames = {
        f"{name}[{number}]": _val3_pose(value, path)
        for name, element in data.items()
        if (element.get("type") or "").lower() == "frame"
        for number, value in enumerate(element)
    }
    poses = []
    for name, element in data.items():
        if not (element.get("type") or "").lower().startswith("point"):
            continue
        for number, value in enumerate(element):
            label, father = f"{name}[{number}]", value.get("fatherId") or ""
            p, R = _val3_pose(value, path)
            if father not in frames and not father.startswith("world"):
                raise FormatError(f"point {label}: the frame {father or 'unknown'} is not in the file", path=path)
            p0, R0 = frames.get(father, (np.zeros(3), np.eye(3)))
            poses.append(ReadPose(label, None, p0 + R0 @ p, R0 @ R))
    return poses


def _val3_pose(element: ET.Element, path: str) -> tuple[FloatArray, FloatArray]:
    x, y, z, rx, ry, rz = _numbers(tuple(element.get(key) for key in ("x", "y", "z", "rx", "ry", "rz")), path, None)
    about_x, about_y, about_z = (np.radians(a) for a in (rx, ry, rz))
    R = rotation_from_zyx(about_x, 0, 0) @ rotation_from_zyx(0, about_y, 0) @ rotation_from_zyx(0, 0, about_z)
    return np.array([x, y, z]), R
