"""Positions of a Comau PDL2 program (``.pdl``): values of ``name := POS(…)``, in the frame that ``$UFRAME`` is set to.

References
----------
Comau, PDL2 Programming Language Manual, CR00758049 (POS, $UFRAME).
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from wpcal.core.errors import FormatError, InputError
from wpcal.core.rotations import rotation_from_zyz
from wpcal.core.transform import RigidTransform
from wpcal.taught.programs import BASE, ProgramPoint, ProgramPoints, ProgramReader, coordinates, unusable_point

AXES = ("X", "Y", "Z", "E1", "E2", "E3")
POSITION = re.compile(r"^[ \t]*+(?P<name>\w++)[ \t]*+:=[ \t]*+POS[ \t]*+\((?P<values>[^()\n]*+)\)", re.IGNORECASE)
FRAME = re.compile(r"^[ \t]*+\$UFRAME[ \t]*+:=[ \t]*+(?P<name>\w++)", re.IGNORECASE)


def read_pdl2(text: str, path: str) -> ProgramPoints:
    """Read the positions of a program.

    Raises `FormatError` when it has no line ``PROGRAM``, or a position is not six numbers.
    """
    if not re.search(r"^[ \t]*+PROGRAM\b", text, re.MULTILINE | re.IGNORECASE):
        raise FormatError("has no line PROGRAM", path=path)
    poses, names, lines = dict[str, tuple[int, RigidTransform]](), dict[str, str](), text.splitlines()
    for number, line in enumerate(lines, start=1):
        if match := POSITION.match(line):
            cells = match["values"].split(",")[: len(AXES)]
            if len(cells) < len(AXES):
                raise FormatError(f"{match['name']}: expected six numbers", path=path, line=number)
            values = coordinates(list(zip(AXES, cells, strict=True)), match["name"], path, number)
            poses[match["name"].lower()], names[match["name"].lower()] = (
                (number, frame_of_pendant(values)),
                match["name"],
            )
    used = [match["name"].lower() for line in lines if (match := FRAME.match(line))]
    frames = {name: poses[name][1] for name in used if name in poses}
    points = tuple(_point(names[name], line, T, used) for name, (line, T) in poses.items() if name not in frames)
    return ProgramPoints(points, frames)


def _point(name: str, line: int, T: RigidTransform, used: Sequence[str]) -> ProgramPoint:
    if len(set(used)) > 1:
        return unusable_point(name, line, f"the program sets $UFRAME to {', '.join(sorted(set(used)))}")
    return ProgramPoint(name, line, T.t_mm, T.R, used[0] if used else BASE)


def frame_of_pendant(values: Sequence[float]) -> RigidTransform:
    """Return ``T_base_frame`` of x, y, z in mm and Euler angles in degrees, ``R = Rz(e1) Ry(e2) Rz(e3)``."""
    if len(values) != len(AXES):
        raise InputError(f"expected 6 numbers, got {len(values)}")
    return RigidTransform(rotation_from_zyz(*np.radians(values[3:])), np.asarray(values[:3]), "base", "frame")


READER = ProgramReader(read_pdl2, frame_of_pendant, ",".join(AXES))
