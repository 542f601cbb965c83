"""Taught points of Yaskawa INFORM: the Cartesian positions (``///RECTAN``) of a job (``.jbi``), or ``VAR.DAT``.

``///POSTYPE ROBOT`` and ``BASE`` mean the base of a robot that does not move on an axis. ``USER`` names a user frame by
number only. Positions stored as pulses need the arm to become coordinates.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from wpcal.core.errors import FormatError
from wpcal.core.wording import shown
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

AXES = ("X", "Y", "Z", "Rx", "Ry", "Rz")
POSITION = re.compile(r"^(?P<name>[CP]\d{3,5})\s*=\s*(?P<values>\S.*)$")
SETTING = re.compile(r"^///(?P<key>USER|POSTYPE|NPOS|RECTAN|PULSE)\b\s*(?P<value>.*)$")
SECTION = re.compile(r"^///[A-Z]{1,2}\s*$")
VARIABLES = re.compile(r"^///P\s*$", re.MULTILINE)
VARIABLE = re.compile(r"^\s*+(?:P(?P<number>\d{2,5})\s*+=\s*+)?(?P<values>[-+.\d].*)$")
NONZERO = re.compile(r"[1-9]")
IN_PULSES = "is stored as pulses; convert the job to Cartesian positions (RECTAN) on the controller"
IN_ANGLES = "is stored as joint angles; convert the job to Cartesian positions (RECTAN) on the controller"


def read_inform(text: str, path: str) -> ProgramPoints:
    """Read the positions of a job, or the position variables of ``VAR.DAT`` that are not all zero.

    Raises `FormatError` when it has no section ``//POS`` or ``///P``, or a position is not six numbers.
    """
    if VARIABLES.search(text):
        return ProgramPoints(tuple(_variables(text, path)))
    if not re.search(r"^//POS\b", text, re.MULTILINE):
        raise FormatError("has no section //POS", path=path)
    settings: dict[str, str] = {}
    points = []
    for number, line in enumerate(text.splitlines(), start=1):
        if line.startswith("//INST"):
            break
        setting, position = SETTING.match(line), POSITION.match(line)
        if setting:
            settings[setting["key"]] = setting["value"].strip()
        elif position:
            points.append(_point(position["name"], position["values"], settings, path, number))
    return ProgramPoints(tuple(points))


def _variables(text: str, path: str) -> Iterator[ProgramPoint]:
    """Yield position variables: one row each, in order; without settings their frame is unknown."""
    settings: dict[str, str] = {}
    in_section, index = False, 0
    for number, line in enumerate(text.splitlines(), start=1):
        setting, row = SETTING.match(line), VARIABLE.match(line)
        if SECTION.match(line):
            in_section = VARIABLES.match(line) is not None
        elif setting:
            settings[setting["key"]] = setting["value"].strip()
        elif in_section and row:
            index = index if row["number"] is None else int(row["number"])
            if NONZERO.search(row["values"]):
                values = ",".join(row["values"].replace(",", " ").split())
                yield _point(f"P{index:03d}", values, {"POSTYPE": "USER", **settings}, path, number)
            index += 1


def _point(name: str, values: str, settings: dict[str, str], path: str, line: int) -> ProgramPoint:
    kind = settings.get("POSTYPE", "").upper()
    if kind == "PULSE":
        return unusable_point(name, line, IN_PULSES, joint_values(values.split(","), in_pulses=True))
    if kind == "ANGLE":
        return unusable_point(name, line, IN_ANGLES, joint_values(values.split(",")))
    if kind not in ("ROBOT", "BASE", "USER"):
        return unusable_point(name, line, f"is in POSTYPE {kind or 'none'}; expected ROBOT, BASE or USER")
    if kind == "BASE" and _has_base_axes(settings.get("NPOS", "")):
        return unusable_point(name, line, "is in BASE of a robot that a base axis moves")
    cells = values.split(",")
    if len(cells) != len(AXES):
        raise FormatError(f"{name}: expected six numbers, got {shown(values.strip())}", path=path, line=line)
    T = stored_pose(list(zip(AXES, cells, strict=True)), name, path, line)
    return ProgramPoint(name, line, T.t_mm, T.R, settings.get("USER") if kind == "USER" else BASE)


def _has_base_axes(npos: str) -> bool:
    """Tell from ``NPOS C,BC,EC,P,BP,EX`` whether the job holds positions of a base axis."""
    counts = npos.split(",")
    return any(count.strip() not in ("", "0") for count in (counts[1:2] + counts[4:5]))


READER = ProgramReader(read_inform, frame_from_angles, "X,Y,Z,Rx,Ry,Rz")
