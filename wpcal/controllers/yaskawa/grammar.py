"""What the text of an INFORM job says."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from pathlib import Path

from wpcal.controllers.language.grammar import Complaint, Grammar
from wpcal.controllers.yaskawa.read import read_inform


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
