"""Read the poses that a program states, with the grammar of its language."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from wpcal.controllers.language.grammar import ENCODING, Grammar
from wpcal.controllers.registry import grammar_of_file
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.transform import RigidTransform
from wpcal.taught.programs import BASE, ProgramPoint


@dataclass(frozen=True, slots=True, eq=False)
class ReadPose:
    """One pose of a program as a controller would take it."""

    name: str  #: Of the point, or its number.
    line: int | None
    p_base: FloatArray  #: shape (3,). Tool centre point in `base`, mm.
    R_base: FloatArray  #: shape (3, 3). Axes of the tool in `base`.
    #: False if the file does not say where its user frame is: position and axes are then in that frame.
    in_base: bool = True


def require_grammar(path: Path) -> Grammar:
    """Return the grammar of a file by its suffix; `InputError` in one line when no controller has one."""
    grammar = grammar_of_file(path)
    if grammar is None:
        raise InputError(f"{path}: no language is known whose programs are {path.suffix or 'without a suffix'} files")
    return grammar


def read_poses_back(raw: bytes, path: Path, T_base_part: RigidTransform | None) -> list[ReadPose]:
    """Return the poses of a program's file in `base`.

    Raises `InputError` when no grammar knows the suffix.
    Raises `FormatError` when the file breaks its format, or a point of a weld program cannot be used. Joint values are
    left out, and so are points of other programs that have no coordinates.
    """
    found = require_grammar(path).read(raw.decode(ENCODING), str(path))
    poses = []
    for point in found.points:
        if point.joints is not None or (point.fault and T_base_part is None):
            continue
        if point.fault:
            raise FormatError(f"point {point.name}: {point.fault}", path=str(path), line=point.line or None)
        poses.append(_in_base(point, found.frames, T_base_part))
    return poses


def _in_base(
    point: ProgramPoint, carried: Mapping[str, RigidTransform], T_base_part: RigidTransform | None
) -> ReadPose:
    T = carried.get(point.frame or "", T_base_part)
    if point.frame == BASE:
        T = RigidTransform.identity(target="base", source="frame")
    if T is None or point.at_flange:
        return ReadPose(point.name, point.line or None, point.p_mm, point.R, in_base=False)
    return ReadPose(point.name, point.line or None, T.apply(point.p_mm), T.R @ point.R)
