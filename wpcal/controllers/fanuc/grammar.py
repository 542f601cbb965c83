"""What the text of a TP program says."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from wpcal.controllers.fanuc.read import read_fanuc
from wpcal.controllers.language.grammar import Complaint, Grammar

_LINE = r"^[ \t]*+(?:\d++:)?[ \t]*+"
_POSITION = re.compile(r"^P\[(\d{1,9}+)[^\]\n]*+\]\{([^{}]*+)\};", re.MULTILINE)


def _judge_step(lines: list[str], _path: Path) -> Iterator[Complaint]:
    """Yield positions without both groups, and moves in which the torch would not follow the part."""
    split = next((row for row, line in enumerate(lines) if line.startswith("/POS")), len(lines))
    found = _POSITION.findall("\n".join(lines[split:]))
    groups = {name: ("GP1:" in block, "GP2:" in block) for name, block in found}
    leader = {name: block.partition("GP2:")[2].split() for name, block in found}
    before: str | None = None
    if not any(re.match(r"DEFAULT_GROUP\s*=\s*1,1,", line) for line in lines[:split]):
        yield "the program does not move both groups: expected DEFAULT_GROUP = 1,1,*,*,*", None
    for number, line in enumerate(lines[:split], 1):
        match = re.match(r"\s*\d+:\s*([JLC]) P\[(\d+)", line)
        if match is None:
            continue
        if match[2] not in groups:
            yield f"there is no position P[{match[2]}]", number
        elif not all(groups[match[2]]):
            yield f"P[{match[2]}] does not hold both groups", number
        rests, before = before is not None and leader.get(before) == leader.get(match[2]), match[2]
        if match[1] == "L" and "COORD" not in line and not rests:
            yield "a move of both groups without COORD: the torch would not follow the part", number


GRAMMAR = Grammar(
    comment=f"{_LINE}!",
    harmless=r"(?:WAIT +[\d.]+\(sec\)|WAIT [DR]I\[\d+\]=(?:ON|OFF)|[DR]O\[\d+\]=(?:ON|OFF)|"
    r"MESSAGE\[[^\]]*\]|PAUSE|LINE_COUNT *= *\d+) *;?",
    read=read_fanuc,
    poses_in=(".ls",),
    touches={".ls": r"\bSkip,LBL\[\d+\],PR\[|\bSearch Start\["},
    in_step=r"^[ \t]*+\d++:[LC] [^\n;]*\bCOORD\b",
    judge_step=_judge_step,
    calls=r"^[ \t]*+(?:\d++:)?[ \t]*+CALL (?P<name>[\w.]++)",
)
