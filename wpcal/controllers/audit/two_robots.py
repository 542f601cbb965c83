"""Judge programs of two robots: both have the same marks, every move is one of both robots, and the arc burns.

Positions are in the part that one robot holds, or of both robots. Without the cell they are not compared with the part
or with the reach of an arm: the audit says so.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from wpcal.controllers.audit.arc import arc_faults
from wpcal.controllers.audit.fault import Fault
from wpcal.controllers.taught_program import ENCODING, parse_program
from wpcal.core.errors import WpcalError
from wpcal.core.input_file import read_bytes

CHECKED = (
    "of two robots, or of a robot and its positioner: the same marks in both, moves of both, what they name, arc; "
    "NOT compared with the part or with the reach of an arm"
)
HELD = "the part in the hand of robot 2"
"""In the header of programs of coordinated motion."""
_SIGNS: Mapping[str, re.Pattern[str]] = {
    ".mod": re.compile(r"^[ \t]*+SyncMoveOn\b", re.MULTILINE | re.IGNORECASE),
    ".jbi": re.compile(r"^SMOV[LC]\b|^TSYNC\b", re.MULTILINE),
    ".ls": re.compile(r"^[ \t]*+\d++:[LC] [^\n;]*\bCOORD\b", re.MULTILINE),
    ".src": re.compile(r"\$SYNC_ID\[\]", re.IGNORECASE),
}
"""What shows that a program moves in step with another robot."""
_RAPID_MARK = re.compile(r"\\ID:=(\d{1,9}+),", re.IGNORECASE)
_KRL_MARK = re.compile(r"\$SYNC_ID\[\]=\"(\w{1,40}+)\"", re.IGNORECASE)
_WORK_OBJECT = re.compile(r"\bwobjdata (\w++):=\[(\w++),(\w++),\"(\w*+)\"", re.IGNORECASE)
_POSITION = re.compile(r"^P\[(\d{1,9}+)[^\]\n]*+\]\{([^{}]*+)\};", re.MULTILINE)
_KRL_MOVE = re.compile(r"^[ \t]*+S(?:LIN|CIRC)[ \t]++(?:(\w++),)?(\w++)", re.IGNORECASE)


def is_of_two_robots(raw: bytes, path: Path) -> bool:
    """Tell by its text whether a program moves in step with another robot; a data list by the program beside it."""
    suffix = path.suffix.lower()
    if suffix == ".dat":
        source = path.with_suffix(".src")
        return source.is_file() and is_of_two_robots(read_bytes(source), source)
    sign = _SIGNS.get(suffix)
    return sign is not None and sign.search(raw.decode(ENCODING)) is not None


def two_robot_faults(raw: bytes, path: Path, output: int | None) -> list[Fault]:
    """Return the faults of a program of two robots.

    Parameters
    ----------
    path : Path
        Its suffix tells the language. The program of the other robot, ``…_R2`` for ``…_R1``, is read if it is beside.
    output : Digital output that switches the arc, as in `wpcal.controllers.audit.arc.arc_faults`.
    """
    suffix = path.suffix.lower()
    if suffix != ".src":
        try:
            parse_program(raw, path)
        except WpcalError as error:
            return [Fault.of(error, str(path))]
    judge = _JUDGES.get(suffix)
    lines = raw.decode(ENCODING).splitlines()
    own = [] if judge is None else list(judge(lines, path))
    return [*own, *arc_faults(raw, path, output)]


def _marks_of(lines: list[str], pattern: re.Pattern[str]) -> list[tuple[str, int]]:
    return [(match[1], number) for number, line in enumerate(lines, 1) for match in pattern.finditer(line)]


def _compared(lines: list[str], path: Path, pattern: re.Pattern[str]) -> Iterator[Fault]:
    """Yield marks that are written twice, and those that the other robot does not have or has in another order."""
    marks = _marks_of(lines, pattern)
    first = dict(reversed(marks))
    for mark, count in Counter(mark for mark, _ in marks).items():
        if count > 1:
            yield Fault(f"mark {mark} is there {count} times", first[mark])
    other = _other(path)
    if other is None:
        return
    theirs = [mark for mark, _ in _marks_of(read_bytes(other).decode(ENCODING).splitlines(), pattern)]
    known = set(theirs)
    missing = [(mark, line) for mark, line in marks if mark not in known]
    yield from (Fault(f"mark {mark} is not in {other.name}: this robot would wait", line) for mark, line in missing)
    common = [mark for mark, _ in marks if mark in known]
    if common != [mark for mark in theirs if mark in first]:
        yield Fault(f"the marks are in another order than in {other.name}", marks[0][1])


def _other(path: Path) -> Path | None:
    """Return the program of the other robot, if it is beside."""
    for own, their in (("_R1", "_R2"), ("_R2", "_R1")):
        if path.stem.endswith(own):
            other = path.with_name(f"{path.stem[: -len(own)]}{their}{path.suffix}")
            return other if other.is_file() else None
    return None


def _rapid(lines: list[str], path: Path) -> Iterator[Fault]:
    yield from _compared(lines, path, _RAPID_MARK)
    text = "\n".join(lines)
    if HELD not in re.sub(r"\s*!\s*", " ", text[: text.find("PERS")]):
        return
    held = {match[1]: match.groups()[1:] for match in _WORK_OBJECT.finditer(text)}
    for number, line in enumerate(lines, 1):
        match = _WORK_OBJECT.search(line)
        if match and (match[2].upper(), match[3].upper()) != ("FALSE", "FALSE"):
            yield Fault('the work object does not move with a robot: expected [FALSE,FALSE,"ROB_2",…', number)
        elif match and match[4].upper() != "ROB_2":
            yield Fault(f"the work object is in the hand of {match[4] or 'nobody'}: expected ROB_2", number)
        used = re.search(r"\\WObj:=(\w+)", line)
        if "\\ID:=" in line and used and used[1] not in held:
            yield Fault(f"a move in {used[1]}, which is not the held work object", number)


def _inform(lines: list[str], _path: Path) -> Iterator[Fault]:
    positions = {line.split("=")[0] for line in lines if re.match(r"E?C\d{5}=", line)}
    groups = [line for line in lines if line.startswith("///GROUP")]
    is_coordinated = any(line.startswith("SMOV") for line in lines)
    if is_coordinated and len(groups) != 2:
        yield Fault("a coordinated job has two groups: ///GROUP1 the torch, ///GROUP2 the master", None)
    for number, line in enumerate(lines, 1):
        if line.startswith("SMOV") and "+MOV" not in line:
            yield Fault("a coordinated move without that of the master (+MOVJ)", number)
        for name in re.findall(r"\bE?C\d{5}\b", line) if line.startswith(("MOV", "SMOV")) else ():
            if name not in positions:
                yield Fault(f"there is no position {name}", number)


def _fanuc(lines: list[str], _path: Path) -> Iterator[Fault]:
    split = next((row for row, line in enumerate(lines) if line.startswith("/POS")), len(lines))
    found = _POSITION.findall("\n".join(lines[split:]))
    groups = {name: ("GP1:" in block, "GP2:" in block) for name, block in found}
    leader = {name: block.partition("GP2:")[2].split() for name, block in found}
    before: str | None = None
    for number, line in enumerate(lines[:split], 1):
        match = re.match(r"\s*\d+:\s*([JLC]) P\[(\d+)", line)
        if match is None:
            continue
        if match[2] not in groups:
            yield Fault(f"there is no position P[{match[2]}]", number)
        elif not all(groups[match[2]]):
            yield Fault(f"P[{match[2]}] does not hold both groups", number)
        rests, before = before is not None and leader.get(before) == leader.get(match[2]), match[2]
        if match[1] == "L" and "COORD" not in line and not rests:
            yield Fault("a move of both groups without COORD: the torch would not follow the part", number)


def _krl(lines: list[str], path: Path) -> Iterator[Fault]:
    yield from _compared(lines, path, _KRL_MARK)
    beside = path.with_suffix(".dat")
    names = set(re.findall(r"E6POS (\w+)=", read_bytes(beside).decode(ENCODING))) if beside.is_file() else None
    for number, line in enumerate(lines, 1):
        match = _KRL_MOVE.match(line)
        if match is None:
            continue
        if "$SYNC_ID" not in line.upper():
            yield Fault("a move that does not wait for the other robot ($SYNC_ID)", number)
        for name in (match[1], match[2]):
            if name and names is not None and name not in names:
                yield Fault(f"there is no point {name} in {beside.name}", number)


_JUDGES: Mapping[str, Callable[[list[str], Path], Iterator[Fault]]] = {
    ".mod": _rapid,
    ".jbi": _inform,
    ".ls": _fanuc,
    ".src": _krl,
}
