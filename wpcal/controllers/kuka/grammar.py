"""What the text of a KRL program and of its data list says."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from wpcal.controllers.kuka.read import read_krl, read_krl_tools
from wpcal.controllers.language.grammar import ENCODING, Complaint, Grammar
from wpcal.core.input_file import read_bytes

_IN_STEP = re.compile(r"^[ \t]*+S(?:LIN|CIRC)[ \t]++(?:(\w++),)?(\w++)", re.IGNORECASE)


def _judge_step(lines: list[str], path: Path) -> Iterator[Complaint]:
    """Yield moves that do not wait for the other robot, and points that the data list does not have."""
    beside = path.with_suffix(".dat")
    names = set(re.findall(r"E6POS (\w+)=", read_bytes(beside).decode(ENCODING))) if beside.is_file() else None
    for number, line in enumerate(lines, 1):
        if re.match(r"[ \t]*+\$BASE=BASE_DATA", line, re.IGNORECASE):
            yield "the base does not move with robot 2: expected SBASE", number
        match = _IN_STEP.match(line)
        if match is None:
            continue
        if "$SYNC_ID" not in line.upper():
            yield "a move that does not wait for the other robot ($SYNC_ID)", number
        for name in (match[1], match[2]):
            if name and names is not None and name not in names:
                yield f"there is no point {name} in {beside.name}", number


GRAMMAR = Grammar(
    comment=r"^[ \t]*+;",
    harmless=r"(?:WAIT SEC [\d.]+|WAIT FOR \$IN\[\d+\]|\$OUT\[\d+\] ?= ?(?:TRUE|FALSE)|"
    r'MsgNotify\("[^"]*"\)|HALT)(?: ?;.*)?',
    read=read_krl,
    poses_in=(".dat",),
    moves_of=lambda path: path.with_suffix(".src"),
    stated_output=r"\$OUT\[(\d{1,9}+)\] switches the arc",
    touches={".src": r"\bWPFIND\(|\bTS_Search\(XWPT_", ".dat": r"\bWPO_\w+"},
    results=r"WPR_|WPPLACE\b|XWPT_\w+_M$",  # the last are between start and end of a search of TouchSense
    in_step=r"(?i)\$SYNC_ID\[\]",
    mark=r"(?i)\$SYNC_ID\[\]=\"(\w{1,40}+)\"",
    judge_step=_judge_step,
    tools=read_krl_tools,
    tools_in_words="TOOL_DATA or $TOOL (KRL)",
)
