"""How the text of a language is understood: from lines to instructions, from which programs are read back and judged.

Each language has one `Grammar` beside its writer (`wpcal.controllers.registry.Controller.grammar`). What has none is
never called checked.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

from wpcal.controllers.program.arc import DRY_MARKS, SEAM_MARKS
from wpcal.core.input_file import read_bytes
from wpcal.core.transform import RigidTransform
from wpcal.taught.programs import ProgramPoints

ENCODING = "latin-1"
"""Controllers write one byte per character. Every byte is a character of Latin-1; only names can hold such bytes."""


class Does(Enum):
    """What an instruction does."""

    START = "start of a seam"
    END = "end of a seam"
    DRY = "mark of a dry run"
    MOVE = "move"
    POINT = "point of the move on the line before"
    ON = "arc on"
    OFF = "arc off"
    STOP = "end of a procedure"


MARKS = {**dict(zip(SEAM_MARKS, (Does.START, Does.END), strict=True)), **dict.fromkeys(DRY_MARKS, Does.DRY)}
"""Comments that say where seams are."""


def mark_of(comment: str) -> Does | None:
    """Return what a comment marks, without what begins it; None if nothing."""
    return MARKS.get(comment.strip(" ;"))


@dataclass(frozen=True, slots=True)
class Instruction:
    """What one line does. A line that does two things is two instructions; the points are those of the first."""

    line: int  #: From 1 on.
    does: Does
    kind: str = ""  #: ``J`` to joints or by joints, ``L`` line, ``V`` middle of an arc, ``C`` end of an arc.
    points: tuple[str, ...] = ()  #: Names of the points that it goes to: middle and end of an arc, or one.


Step = tuple[str, ...]
"""Names of poses: the end of a line; an empty name and the end of a joint move; or middle and end of an arc."""
Complaint = tuple[str, int | None]  #: What is wrong, and the line.


@dataclass(frozen=True, slots=True)
class LineRule:
    """A line of this pattern does this.

    The groups ``a`` and ``b`` are points, ``kind`` is the kind of a move, whose first letter counts.
    """

    pattern: re.Pattern[str]
    does: tuple[Does, ...]
    kind: str = ""  #: Where it is not in the text.
    prefix: str = ""  #: Before the names of points, as the reader names them.

    def instructions(self, match: re.Match[str], line: int) -> Iterator[Instruction]:
        """Yield what a line does."""
        groups = match.groupdict()
        kind = self.kind or (groups.get("kind") or "")[:1].upper()
        kind = {"P": "J"}.get(kind, kind)
        names = [groups.get("a"), groups.get("b") if kind == "C" else None]
        points = tuple(f"{self.prefix}{name}" for name in names if name)
        for number, does in enumerate(self.does):
            yield Instruction(line, does, kind, () if number else points)


def rule(pattern: str, *does: Does, kind: str = "", prefix: str = "") -> LineRule:
    """Return a rule; letters of a pattern match both cases."""
    return LineRule(re.compile(pattern, re.IGNORECASE), does, kind, prefix)


@dataclass(frozen=True)
class Grammar:
    """What the files of one language say."""

    comment: str  #: Pattern of what begins a comment.
    rules: tuple[LineRule, ...]  #: The first that fits decides.
    #: From a file's text and path (for messages) to its points. It raises `FormatError`.
    read: Callable[[str, str], ProgramPoints]
    poses_in: tuple[str, ...]  #: Suffixes of the files with points.
    moves_of: Callable[[Path], Path] | None = (
        None  #: From a file with points to that with the moves, where they differ.
    )
    three_on_arcs: bool = False  #: Whether an arc is three moves ``C``, the first of them at its start.
    stated_output: str = ""  #: Pattern of how a header states the number of the output that switches the arc.
    set_output: str = ""  #: Pattern of the instruction that sets ``{number}`` to ``{state}`` (TRUE, FALSE).
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
    tools: Callable[[str], dict[str, RigidTransform]] | None = None  #: From a text to ``T_flange_tool`` by name.
    tools_in_words: str = ""  #: What states a tool.
    #: From a text to its moves, where they are not one to a line; in each list one leads to the next.
    own_chains: Callable[[str], list[list[Step]]] | None = None

    def arc_output(self, text: str) -> int | None:
        """Return the number of the output that switches the arc, as a header states it."""
        stated = re.search(self.stated_output, text) if self.stated_output else None
        return None if stated is None else int(stated[1])

    def instructions(self, text: str, output: int | None = None) -> Iterator[Instruction]:
        """Yield the instructions of a text."""
        output = self.arc_output(text) if output is None else output
        rules = [LineRule(re.compile(rf"{self.comment} ?{mark}[ ;]*$"), (does,)) for mark, does in MARKS.items()]
        if output is not None and self.set_output:
            states = (("TRUE", Does.ON), ("FALSE", Does.OFF))
            rules += [rule(self.set_output.format(number=output, state=state), does) for state, does in states]
        rules += self.rules
        for number, line in enumerate(text.splitlines(), 1):
            for each in rules:
                if match := each.pattern.match(line):
                    yield from each.instructions(match, number)
                    break

    def is_harmless(self, line: str) -> bool:
        """Tell whether a line moves nothing: blank, a comment, an instruction `harmless`, or one that switches the arc.

        Where the arc is switched is judged by itself (`wpcal.controllers.audit.arc`).
        """
        if not line.strip() or re.match(self.comment, line) or re.fullmatch(self.harmless, line.strip(), re.IGNORECASE):
            return True
        does = {each.does for each in self.instructions(line)}
        return bool(does) and does <= {Does.ON, Does.OFF}

    def chains(self, text: str) -> list[list[Step]]:
        """Return the moves of a text; in each list one leads to the next."""
        if self.own_chains is not None:
            return self.own_chains(text)
        chains, middle, arc = [list[Step]()], "", list[str]()
        for each in self.instructions(text):
            if each.does is Does.STOP:
                chains.append([])
            if not each.points:
                continue
            name = each.points[-1]
            if each.kind == "C" and self.three_on_arcs:
                arc = [*arc, name][-3:] if len(arc) < 3 else [name]
                if len(arc) != 2:
                    chains[-1].append((name,) if len(arc) == 1 else (arc[1], name))
                continue
            arc = []
            if each.kind == "V":
                middle = name
            elif each.kind == "C":
                chains[-1].append(each.points if len(each.points) > 1 else (middle, name))
            else:
                chains[-1].append(("", name) if each.kind == "J" else (name,))
        return [chain for chain in chains if chain]

    def chains_of(self, raw: bytes, path: Path) -> list[list[Step]]:
        """Return the moves that belong to the points of a file; none if another file has them, and is not there."""
        if self.moves_of is None:
            return self.chains(raw.decode(ENCODING))
        beside = self.moves_of(path)
        return self.chains(read_bytes(beside).decode(ENCODING)) if beside.is_file() else []

    def is_in_step(self, raw: bytes, path: Path) -> bool:
        """Tell whether a program moves in step with another robot; a file of points by the program beside it."""
        if self.moves_of is not None and path.suffix.lower() in self.poses_in:
            beside = self.moves_of(path)
            return beside != path and beside.is_file() and self.is_in_step(read_bytes(beside), beside)
        return bool(self.in_step) and re.search(self.in_step, raw.decode(ENCODING), re.MULTILINE) is not None

    def is_touch_program(self, raw: bytes, path: Path) -> bool:
        """Tell whether a file is a touch program of wpcal, or holds its results."""
        mark = self.touches.get(path.suffix.lower())
        return mark is not None and re.search(mark, raw.decode(ENCODING)) is not None
