"""What the text of a language says before it is executed: comments, marks, points, and lines that move nothing.

Each language has one `Grammar` beside its writer (`wpcal.controllers.registry.Controller.grammar`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING

from wpcal.controllers.program.arc import DRY_MARKS, SEAM_MARKS
from wpcal.core.input_file import read_bytes
from wpcal.core.transform import RigidTransform

if TYPE_CHECKING:
    from wpcal.taught.programs import ProgramPoints

ENCODING = "latin-1"
"""Controllers write one byte per character. Every byte is a character of Latin-1; only names can hold such bytes."""


class Does(Enum):
    """What an instruction does."""

    START = "start of a seam"
    END = "end of a seam"
    DRY = "mark of a dry run"
    MOVE = "move"
    ON = "arc on"
    OFF = "arc off"
    STOP = "end of a procedure"


MARKS = {**dict(zip(SEAM_MARKS, (Does.START, Does.END), strict=True)), **dict.fromkeys(DRY_MARKS, Does.DRY)}
"""Comments that say where seams are."""


def mark_of(comment: str) -> Does | None:
    """Return what a comment marks, without what begins it; None if nothing."""
    return MARKS.get(comment.strip(" ;"))


Complaint = tuple[str, int | None]  #: What is wrong, and the line.


@dataclass(frozen=True)
class Grammar:
    """What the files of one language say."""

    comment: str  #: Pattern of what begins a comment.
    #: From a file's text and path (for messages) to its points. It raises `FormatError`.
    read: Callable[[str, str], ProgramPoints]
    poses_in: tuple[str, ...]  #: Suffixes of the files with points.
    #: From a file with points to that with the moves, where they differ.
    moves_of: Callable[[Path], Path] | None = None
    stated_output: str = ""  #: Pattern of how a header states the number of the output that switches the arc.
    #: By the suffix: what only touch programs of wpcal and their results have.
    touches: Mapping[str, str] = field(default_factory=dict)
    results: str = ""  #: Pattern of the names of points that a touch program stores.
    in_step: str = ""  #: Pattern of a line that shows that a program moves in step with another robot.
    mark: str = ""  #: Pattern of a mark that the programs of two robots share.
    #: From lines and path of a program of two robots to what is wrong with it.
    judge_step: Callable[[list[str], Path], Iterator[Complaint]] | None = None
    #: Pattern of a whole instruction, after its comments, without effect on motion: waits, messages, outputs.
    harmless: str = ""
    calls: str = ""  #: Pattern of a call of another program; its name is the group ``name``.
    #: From a text to ``T_flange_tool`` by name, or why one cannot be read.
    tools: Callable[[str], Mapping[str, RigidTransform | str]] | None = None
    tools_in_words: str = ""  #: What states a tool.

    def arc_output(self, text: str) -> int | None:
        """Return the number of the output that switches the arc, as a header states it."""
        stated = re.search(self.stated_output, text) if self.stated_output else None
        return None if stated is None else int(stated[1])

    def is_harmless(self, line: str) -> bool:
        """Tell whether a line moves nothing: blank, a comment, or an instruction `harmless`."""
        return (
            not line.strip()
            or re.match(self.comment, line) is not None
            or re.fullmatch(self.harmless, line.strip(), re.IGNORECASE) is not None
        )

    def has_poses(self, path: Path) -> bool:
        """Tell by the suffix whether a file holds poses."""
        return path.suffix.lower() in self.poses_in

    def is_in_step(self, raw: bytes, path: Path) -> bool:
        """Tell whether a program moves in step with another robot; a file of points by the program beside it."""
        if self.moves_of is not None and self.has_poses(path):
            beside = self.moves_of(path)
            return beside != path and beside.is_file() and self.is_in_step(read_bytes(beside), beside)
        return bool(self.in_step) and re.search(self.in_step, raw.decode(ENCODING), re.MULTILINE) is not None

    def is_touch_program(self, raw: bytes, path: Path) -> bool:
        """Tell whether a file is a touch program of wpcal, or holds its results."""
        mark = self.touches.get(path.suffix.lower())
        return mark is not None and re.search(mark, raw.decode(ENCODING)) is not None
