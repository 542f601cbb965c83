"""Taught points from a Kawasaki AS file (``.as``): transformation values of ``.TRANS`` and of ``POINT … = TRANS(…)``.

A transformation value does not state its frame. It is relative to the ``BASE`` in effect where a move uses it. Without
such a move it counts as relative to the robot's base, if the file sets no other base. Values of ``.JOINTS`` are joint
angles. The case of names does not matter.

References: Files that controllers and post-processors wrote (docs/how-to/kawasaki.md).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

from wpcal.controllers.language.grammar import Grammar
from wpcal.core.errors import FormatError
from wpcal.core.rotations import rotation_from_zyz
from wpcal.core.transform import RigidTransform
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

AXES = ("X", "Y", "Z", "O", "A", "T")
NULL = "null"  #: The transformation that changes nothing, as the language calls it.
_NAME = r"[A-Za-z][\w.]*+(?:\[[\d,]*+\])?"
_SECTION = re.compile(r"^\.(?P<name>[A-Za-z_]++)(?![\w.])(?!\s*+[=\[])")  # otherwise it is a local variable
_VALUES = re.compile(rf"^(?P<name>#?{_NAME})[ \t]++(?P<values>\S.*)$")
_POINT = re.compile(rf"^\s*+POINT\s++(?P<name>{_NAME})\s*+=\s*+TRANS\s*+\((?P<values>[^()]*+)\)", re.IGNORECASE)
_SETTING = re.compile(rf"^\s*+(?P<key>BASE|TOOL)\s++(?P<name>{_NAME})", re.IGNORECASE)
_MOVE = re.compile(r"^\s*+(?:[LJX]MOVE|C[12]MOVE|[LJ]W[SCE]|C[12]WC)\s++(?P<what>[^;\n]*+)", re.IGNORECASE)
_PLACE = re.compile(r"(?:[^,\[]++|\[[^\]]*+\]?)*")  # up to a comma that is not between brackets
_WORD = re.compile(_NAME)
ADDED = "is added to another transformation in a move; its own coordinates are not a place"


@dataclass(slots=True)
class _Use:
    """In which frames the moves of a file use a point."""

    bases: set[str] = field(default_factory=set)
    tools: set[str] = field(default_factory=set)
    is_added: bool = False


@dataclass(slots=True)
class _File:
    """What a file holds: names are lower case in all but `rows`."""

    rows: list[tuple[str, int, list[str]]] = field(default_factory=list)
    joints: list[tuple[str, int, list[str]]] = field(default_factory=list)
    uses: dict[str, _Use] = field(default_factory=dict)
    bases: set[str] = field(default_factory=set)
    tools: set[str] = field(default_factory=set)
    base: str = ""  #: The present one of a program.
    tool: str = ""

    def take(self, number: int, line: str) -> None:
        """Note what a line of a program says."""
        setting, move, point = _SETTING.match(line), _MOVE.match(line), _POINT.match(line)
        if setting and setting["key"].upper() == "BASE":
            self.base = setting["name"].lower()
            self.bases.add(self.base)
        elif setting:
            self.tool = setting["name"].lower()
            self.tools.add(self.tool)
        elif move:
            self._use(move["what"])
        elif point:
            self.rows.append((point["name"], number, point["values"].split(",")))

    def _use(self, what: str) -> None:
        """Note the point of a move: alone, or added to another transformation."""
        place = _PLACE.findall(re.split(r"\still\b", what.lower(), maxsplit=1)[0])[0].strip()
        for name in set(_WORD.findall(place)):
            use = self.uses.setdefault(name, _Use())
            use.is_added |= name != place
            use.bases.add(self.base)
            use.tools.add(self.tool)


def read_as(text: str, path: str) -> ProgramPoints:
    """Read the transformation values of a file.

    Raises `FormatError` when it has neither a section ``.TRANS`` nor ``.JOINTS`` nor a program, or a value is not six
    numbers.
    """
    found = _parsed(text)
    if not re.search(r"^\.(?:PROGRAM|TRANS|JOINTS)\b", text, re.MULTILINE | re.IGNORECASE):
        raise FormatError("has no .PROGRAM, .TRANS or .JOINTS", path=path)
    poses = [(name, line, _pose(name, cells, path, line)) for name, line, cells in found.rows]
    own = found.bases | found.tools
    points = [_point(name, line, T, found) for name, line, T in poses if name.lower() not in own]
    joints = ((name, line, joint_values(cells[:6])) for name, line, cells in found.joints)
    points += [unusable_point(name, line, "is stored as joint angles", values) for name, line, values in joints]
    frames = {name.lower(): T for name, _, T in poses if name.lower() in found.bases}
    return ProgramPoints(tuple(sorted(points, key=lambda point: point.line)), frames)


def _parsed(text: str) -> _File:
    found, section = _File(), ""
    for number, line in enumerate(text.splitlines(), start=1):
        head = _SECTION.match(line)
        if head:
            section, found.base, found.tool = head["name"].upper(), "", ""
        elif section == "PROGRAM":
            found.take(number, line)
        elif section in ("TRANS", "JOINTS") and (value := _VALUES.match(line)):
            rows = found.rows if section == "TRANS" else found.joints
            rows.append((value["name"].lstrip("#"), number, re.split(r"[\s,]+", value["values"].strip())))
    found.bases.discard(NULL)
    found.tools.discard(NULL)
    return found


def _pose(name: str, cells: Sequence[str], path: str, line: int) -> RigidTransform:
    if len(cells) < len(AXES):
        what = f"{name}: expected six numbers, got {shown(' '.join(cells).strip())}"
        raise FormatError(what, path=path, line=line)
    return stored_pose(list(zip(AXES, cells, strict=False)), name, path, line, rotation_from_zyz)  # then external axes


def _point(name: str, line: int, T: RigidTransform, found: _File) -> ProgramPoint:
    use = found.uses.get(name.lower(), _Use())
    if use.is_added:
        return unusable_point(name, line, ADDED)
    bases = use.bases - {""}
    if found.bases and ("" in use.bases or not use.bases):
        what = f"is used where the file does not say the base, and the file sets {', '.join(sorted(found.bases))}"
        return unusable_point(name, line, what)
    if len(bases) > 1:
        return unusable_point(name, line, f"is used in the bases {', '.join(sorted(bases))}")
    frame = next(iter(bases), NULL)
    at_flange = use.tools == {NULL}
    return ProgramPoint(name, line, T.t_mm, T.R, BASE if frame == NULL else frame, at_flange)


READER = ProgramReader(read_as, partial(frame_from_angles, rotation=rotation_from_zyz), "X,Y,Z,O,A,T")


GRAMMAR = Grammar(
    comment=r"^[ \t]*+;",
    harmless=r"(?:ACCEL|DECEL|TWAIT|W1SET|W2SET)\b.*|(?:SW|)WAIT SIG\(-?\d+\)|SWAIT -?\d+|"
    r'SIGNAL -?\d+(?:, ?-?\d+)*|PRINT "[^"]*"|PAUSE',
    read=read_as,
    poses_in=(".as",),
    touches={".as": r"\bwpto_\w+"},
    results=r"wptp_",
)
