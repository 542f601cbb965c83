"""What the text of a TP program says."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from wpcal.controllers.fanuc.read import POSITION, read_fanuc
from wpcal.controllers.language.grammar import Complaint, Grammar

_LINE = r"^[ \t]*+(?:\d++:)?[ \t]*+"


def _judge_step(lines: list[str], _path: Path) -> Iterator[Complaint]:
    """Yield positions without both groups, and moves in which the torch would not follow the part."""
    split = next((row for row, line in enumerate(lines) if line.startswith("/POS")), len(lines))
    blocks = {found["number"]: found["body"] for found in POSITION.finditer("\n".join(lines[split:]))}
    if not any(re.match(r"DEFAULT_GROUP\s*=\s*1,1,", line) for line in lines[:split]):
        yield "the program does not move both groups: expected DEFAULT_GROUP = 1,1,*,*,*", None
    before: str | None = None
    for number, line in enumerate(lines[:split], 1):
        if match := re.match(r"\s*\d+:\s*([JLC]) P\[(\d+)", line):
            yield from ((what, number) for what in _complaints(line, match[1], match[2], before, blocks))
            before = match[2]


def _complaints(line: str, kind: str, name: str, before: str | None, blocks: dict[str, str]) -> Iterator[str]:
    """Yield what is wrong with a move to a position, which comes behind one to the position `before`."""
    if name not in blocks:
        yield f"there is no position P[{name}]"
    elif "GP1:" not in blocks[name] or "GP2:" not in blocks[name]:
        yield f"P[{name}] does not hold both groups"
    leader = {one: block.partition("GP2:")[2].split() for one, block in blocks.items() if one in (before, name)}
    rests = before is not None and leader.get(before) == leader.get(name)
    if kind == "L" and "COORD" not in line and not rests:
        yield "a move of both groups without COORD: the torch would not follow the part"


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
