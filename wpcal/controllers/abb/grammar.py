"""What the text of a RAPID module says."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from wpcal.controllers.abb.read import read_rapid, read_rapid_tools
from wpcal.controllers.abb.statements import declarations, statements_of
from wpcal.controllers.language.grammar import Complaint, Grammar

HELD = "the part in the hand of robot 2"  #: In the header of programs of coordinated motion.


def _judge_held(lines: list[str], _path: Path) -> Iterator[Complaint]:
    """Yield what is wrong with the work object in the hand of robot 2."""
    text = "\n".join(lines)
    if HELD not in " ".join(text[: text.find("PERS")].replace("!", " ").split()):
        return
    names = set[str]()
    for each in declarations(statements_of(text), "wobjdata"):
        names.add(each.name.upper())
        robhold, is_programmed, unit = [*"".join(each.tokens).upper().strip("[").split(","), "", ""][:3]
        if (robhold, is_programmed) != ("FALSE", "FALSE"):
            yield 'the work object does not move with a robot: expected [FALSE,FALSE,"ROB_2",…', each.line
        elif (carrier := unit.strip('"')) != "ROB_2":
            yield f"the work object is in the hand of {carrier or 'nobody'}: expected ROB_2", each.line
    for number, line in enumerate(lines, 1):
        used = re.search(r"\\WObj:=(\w+)", line)
        if "\\ID:=" in line and used and used[1].upper() not in names:
            yield f"a move in {used[1]}, which is not the held work object", number


GRAMMAR = Grammar(
    comment=r"^[ \t]*+!",
    harmless=r'(?:(?:WaitTime|WaitDI|WaitDO|SetDO|Set|Reset|PulseDO) [\w\\:=,. ]*|TPWrite "[^"]*"|TPErase|Stop|'
    r"Conf[JL]\\O(?:n|ff));",
    read=read_rapid,
    poses_in=(".mod", ".prg", ".sys"),
    touches={".mod": r"\bwptO_\w+"},
    results=r"wptP_",
    in_step=r"(?i)^[ \t]*+SyncMoveO(?:n|ff)\b",
    mark=r"(?i)\\ID:=(\d{1,9}+),",
    judge_step=_judge_held,
    tools=read_rapid_tools,
    tools_in_words="a tooldata (RAPID)",
)
