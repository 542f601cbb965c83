"""What the data and the programs of a VAL3 application say. No person teaches points with such files."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping

import numpy as np

from wpcal.controllers.language.grammar import ENCODING, Grammar
from wpcal.core.errors import FormatError, InputError
from wpcal.core.numbers import parse_number
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.taught.programs import BASE, ProgramPoint, ProgramPoints

WORLD = "world"
NO_LINE = 0  #: XML says names of points, no lines.


def elements(text: str, path: str, tag: str) -> list[ET.Element]:
    """Return the elements of a tag, in any namespace; `FormatError` when the text is not XML."""
    try:
        root = ET.fromstring(text.encode(ENCODING, "replace"))
    except ET.ParseError as error:
        line, column = error.position
        raise FormatError(f"is not XML: {error.msg}", path=path, line=line, column=column) from None
    except (LookupError, ValueError):
        raise FormatError("is not XML: its encoding is not known", path=path) from None
    return [element for element in root.iter() if element.tag.rpartition("}")[2] == tag]


def read_val3(text: str, path: str) -> ProgramPoints:
    """Read the points of a database: mm, and degrees of ``Rx Ry Rz``, in the frame that is their father."""
    data = {element.get("name", ""): element for element in elements(text, path, "Data")}
    values = [
        (f"{name}[{number}]", (element.get("type") or "").lower(), value)
        for name, element in data.items()
        for number, value in enumerate(element)
    ]
    frames = {label: _pose(value, path) for label, kind, value in values if kind == "frame"}
    found = (_point(label, value, frames, path) for label, kind, value in values if kind.startswith("point"))
    return ProgramPoints(tuple(found), frames)


def _point(label: str, value: ET.Element, frames: Mapping[str, RigidTransform], path: str) -> ProgramPoint:
    father, T = value.get("fatherId") or "", _pose(value, path)
    if father not in frames and not father.startswith(WORLD):
        raise FormatError(f"point {label}: the frame {father or 'unknown'} is not in the file", path=path)
    return ProgramPoint(label, NO_LINE, T.t_mm, T.R, father if father in frames else BASE)


def _pose(element: ET.Element, path: str) -> RigidTransform:
    try:
        values = [parse_number(element.get(key) or "") for key in ("x", "y", "z", "rx", "ry", "rz")]
    except InputError as error:
        raise FormatError(f"a pose of six numbers: {error}", path=path, line=None) from None
    x, y, z = np.radians(values[3:])
    R = rotation_from_zyx(x, 0, 0) @ rotation_from_zyx(0, y, 0) @ rotation_from_zyx(0, 0, z)
    return RigidTransform(R, np.array(values[:3]), "base", "frame")


GRAMMAR = Grammar(
    comment=r"^[ \t]*+//",
    harmless=r'delay\([\d.]+\)|putln\("[^"]*"\)|logMsg\("[^"]*"\)',
    read=read_val3,
    poses_in=(".dtx",),
    moves_of=lambda path: path.parent / "start.pgx",
)
