"""Positions of a Comau PDL2 program (``.pdl``): values of ``name := POS(…)``, in the frame that ``$UFRAME`` is set to.

References: Comau, PDL2 Programming Language Manual, CR00758049 (POS, $UFRAME).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import partial

from wpcal.controllers.language.grammar import Grammar
from wpcal.core.errors import FormatError
from wpcal.core.rotations import rotation_from_zyz
from wpcal.core.transform import RigidTransform
from wpcal.taught.programs import (
    BASE,
    ProgramPoint,
    ProgramPoints,
    ProgramReader,
    frame_from_angles,
    stored_pose,
    unusable_point,
)

AXES = ("X", "Y", "Z", "E1", "E2", "E3")
POSITION = re.compile(r"^[ \t]*+(?P<name>\w++)[ \t]*+:=[ \t]*+POS[ \t]*+\((?P<values>[^()\n]*+)\)", re.IGNORECASE)
FRAME = re.compile(r"^[ \t]*+\$UFRAME[ \t]*+:=[ \t]*+(?P<name>\w++)", re.IGNORECASE)


def read_pdl2(text: str, path: str) -> ProgramPoints:
    """Read the positions of a program.

    Raises `FormatError` when it has no line ``PROGRAM``, or a position is not six numbers.
    """
    if not re.search(r"^[ \t]*+PROGRAM\b", text, re.MULTILINE | re.IGNORECASE):
        raise FormatError("has no line PROGRAM", path=path)
    poses, lines = dict[str, tuple[str, int, RigidTransform]](), text.splitlines()
    for number, line in enumerate(lines, start=1):
        if match := POSITION.match(line):
            name, cells = match["name"], list(zip(AXES, match["values"].split(","), strict=False))
            if len(cells) < len(AXES):
                raise FormatError(f"{name}: expected six numbers", path=path, line=number)
            poses[name.lower()] = name, number, stored_pose(cells, name, path, number, rotation_from_zyz)
    used = [match["name"].lower() for line in lines if (match := FRAME.match(line))]
    frames = {name: poses[name][2] for name in used if name in poses}
    points = tuple(_point(*found, used) for name, found in poses.items() if name not in frames)
    return ProgramPoints(points, frames)


def _point(name: str, line: int, T: RigidTransform, used: Sequence[str]) -> ProgramPoint:
    if len(set(used)) > 1:
        return unusable_point(name, line, f"the program sets $UFRAME to {', '.join(sorted(set(used)))}")
    return ProgramPoint(name, line, T.t_mm, T.R, used[0] if used else BASE)


READER = ProgramReader(read_pdl2, partial(frame_from_angles, rotation=rotation_from_zyz), ",".join(AXES))


GRAMMAR = Grammar(
    comment=r"^[ \t]*+--",
    harmless=r"DELAY \d+|\$DOUT\[\d+\] := (?:TRUE|FALSE|ON|OFF)|WAIT FOR \$DIN\[\d+\]|PAUSE|"
    r"WRITE(?: LUN_CRT)? ?\('[^']*'(?:, ?NL)?\)",
    read=read_pdl2,
    poses_in=(".pdl",),
    stated_output=r"\$DOUT\[(\d{1,9}+)\] switches the arc",
)
