"""Taught points of Yaskawa INFORM: the Cartesian positions (``///RECTAN``) of a job (``.jbi``), or ``VAR.DAT``.

``///POSTYPE ROBOT`` and ``BASE`` mean the base of a robot that does not move on an axis. ``USER`` names a user frame by
number only. Positions stored as pulses need the arm to become coordinates.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple

from wpcal.controllers.language.grammar import Complaint, Grammar
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
SECTION = re.compile(r"^///(?P<kind>[A-Z]{1,2})\s*$")
VARIABLES = re.compile(r"^///P\s*$", re.MULTILINE)
VARIABLE = re.compile(r"^\s*+(?:[A-Z]{1,2}(?P<number>\d{2,5})\s*+=\s*+)?(?P<values>[-+.\d].*)$")
NONZERO = re.compile(r"[1-9]")
IN_PULSES = "is stored as pulses; convert the job to Cartesian positions (RECTAN) on the controller"
IN_ANGLES = "is stored as joint angles; convert the job to Cartesian positions (RECTAN) on the controller"


def read_inform(text: str, path: str) -> ProgramPoints:
    """Read the positions of a job, or the position variables of ``VAR.DAT`` that are not all zero.

    Raises `FormatError` when it has no section ``//POS`` or ``///P``, or a position is not six numbers.
    """
    if VARIABLES.search(text):
        rows = [row for row in variables_of(text) if row.kind == "P" and NONZERO.search("".join(row.cells))]
        return ProgramPoints(tuple(_variable(row, path) for row in rows))
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


class Variables(NamedTuple):
    """A row of ``VAR.DAT``: one position (P), or any count of numbers (B, I, D …), in the order of the variables."""

    kind: str
    first: int  #: Number of the first variable of the row.
    cells: list[str]
    line: int
    settings: dict[str, str]


def variables_of(text: str) -> Iterator[Variables]:
    """Yield the rows of the sections ``///B``, ``///P`` …."""
    settings, kind, index = dict[str, str](), "", 0
    for number, line in enumerate(text.splitlines(), start=1):
        if head := SECTION.match(line):
            kind, index = head["kind"], 0
        elif setting := SETTING.match(line):
            settings = {**settings, setting["key"]: setting["value"].strip()}
        elif kind and (row := VARIABLE.match(line)):
            index = index if row["number"] is None else int(row["number"])
            cells = row["values"].replace(",", " ").split()
            yield Variables(kind, index, cells, number, settings)
            index += 1 if kind == "P" else len(cells)


def _variable(row: Variables, path: str) -> ProgramPoint:
    """Return a position variable; without settings its frame is unknown."""
    return _point(f"P{row.first:03d}", ",".join(row.cells), {"POSTYPE": "USER", **row.settings}, path, row.line)


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


def _judge_step(lines: list[str], _path: Path) -> Iterator[Complaint]:
    """Yield coordinated moves without the master, and positions that are not there."""
    if what := _wrong_groups(lines):
        yield what, None
    positions = {line.split("=")[0] for line in lines if re.match(r"E?C\d{5}=", line)}
    for number, line in enumerate(lines, 1):
        if line.startswith(("MOV", "SMOV")):
            yield from ((what, number) for what in _complaints(line, positions))


def _wrong_groups(lines: list[str]) -> str:
    groups = [line.split()[-1] for line in lines if line.startswith("///GROUP")]
    if any("+MOVJ C" in line for line in lines) and groups != ["RB1", "RB2"]:
        return "a job of two robots has the torch as ///GROUP1 RB1 and the part as ///GROUP2 RB2"
    if any(line.startswith("SMOV") for line in lines) and len(groups) != 2:
        return "a coordinated job has two groups: ///GROUP1 the torch, ///GROUP2 the master"
    return ""


def _complaints(line: str, positions: Collection[str]) -> Iterator[str]:
    """Yield what is wrong with a move."""
    if line.startswith("SMOV") and "+MOV" not in line:
        yield "a coordinated move without that of the master (+MOVJ)"
    elif line.startswith(("MOVL", "MOVC")) and "+MOVJ C" in line:
        yield "a move of both robots that is not coordinated"
    for name in re.findall(r"\bE?C\d{5}\b", line):
        if name not in positions:
            yield f"there is no position {name}"


GRAMMAR = Grammar(
    comment=r"^'",
    harmless=r'TIMER T=[\d.]+|DOUT OT#\(\d+\) (?:ON|OFF)|WAIT IN#\(\d+\)=(?:ON|OFF)|MSG "[^"]*"|PAUSE|NOP',
    read=read_inform,
    poses_in=(".jbi",),
    touches={".jbi": r"\bSRCH RIN#\("},
    in_step=r"^SMOV[LC]\b|^TSYNC\b",
    judge_step=_judge_step,
    calls=r"^[ \t]*+CALL JOB:(?P<name>[\w.]++)",
)
