"""Compare a program with the one that wpcal's own templates would make: every other line of the user's is named.

wpcal checks its own moves. What a template of the user adds, leaves out or changes may move the robot in ways that
nobody followed: an offset, another frame, a register, a call. Lines without effect on motion are known by the grammar
of the language; the speed of a move may be another one; all else is not checked, and the program says so.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from pathlib import Path
from typing import TypeVar

from wpcal.controllers.judge.written import WrittenWrongError, not_followed, programs_of
from wpcal.controllers.language.grammar import ENCODING, Grammar
from wpcal.controllers.language.post import blocks_of
from wpcal.controllers.program import WeldProgram
from wpcal.controllers.program.touch_program import TouchProgram
from wpcal.controllers.registry import grammar_of_file
from wpcal.core.errors import InputError

MOST_PLACES = 3  #: Of one text that are told; a template is used for every seam.
_NUMBERED = re.compile(r"^\s*\d+:")  #: Number before an instruction.
_APART = re.compile(r"[\s,;()]+")
_SPEED = re.compile(r"(?:v[jr]?=?)?[\d.]+(?:mm/sec|cm/min|%)?|v\w+", re.IGNORECASE)

Files = Mapping[str, str | bytes]
Writer = Callable[[WeldProgram], Files]
P = TypeVar("P", WeldProgram, TouchProgram)


@dataclass(frozen=True, slots=True, eq=False)
class Written:
    """The files of a program, what it says of itself, and which lines of templates were not checked."""

    files: Files
    program: WeldProgram
    not_checked: tuple[str, ...] = ()


def write_with_templates(name: str, write: Writer, program: WeldProgram) -> Written:
    """Write a program in the format `name`; with lines that wpcal does not know, it is not called checked.

    Raises `InputError` when the language cannot hold the program, or a template has a fault.
    """
    files = write(program)
    if program.controller.templates is None or not blocks_of(name):
        return Written(files, program)
    if not _unjudged(name, files, write, program):
        return Written(files, program)
    unchecked = replace(program, checked=())  # its header has other lines: the places are found anew
    files = write(unchecked)
    return Written(files, unchecked, _unjudged(name, files, write, unchecked))


def _unjudged(name: str, files: Files, write: Writer, program: WeldProgram) -> tuple[str, ...]:
    """Say which lines of templates were not judged: those that nobody followed, or all of an unknown language."""
    foreign = lines_of_templates(files, write, program)
    if not foreign or not programs_of(files):
        return foreign
    try:
        lines = not_followed(files, program, name=name)
    except WrittenWrongError as error:
        raise InputError(f"{program.controller.templates}: the templates break the program: {error}") from None
    if lines is None:
        return foreign
    by_file: dict[str, list[tuple[str, int, str]]] = {}
    for file, number, line in lines:
        by_file.setdefault(file, []).append(("", number, line))
    return tuple(told for file, found in by_file.items() for told in _told(file, found))


def lines_of_templates(files: Mapping[str, str | bytes], write: Callable[[P], Files], program: P) -> tuple[str, ...]:
    """Say which lines of the files only templates of the user make, or leave out; none if the program has none."""
    if program.controller.templates is None:
        return ()
    ours = write(replace(program, controller=replace(program.controller, templates=None)))
    found = list[str]()
    for name, data in files.items():
        grammar = grammar_of_file(Path(name))
        if grammar is not None:
            found += _told(name, list(_other_lines(_lines(ours[name]), _lines(data), grammar)))
    return tuple(found)


def _lines(data: str | bytes) -> list[str]:
    text = data if isinstance(data, str) else data.decode(ENCODING)
    return [" ".join(_NUMBERED.sub("", line).split()) for line in text.splitlines()]


def _other_lines(ours: Sequence[str], given: Sequence[str], grammar: Grammar) -> Iterator[tuple[str, int, str]]:
    """Yield what is wrong, the line and its text: for lines that only one of two programs has."""
    for tag, start, end, first, last in SequenceMatcher(None, ours, given, autojunk=False).get_opcodes():
        if tag == "equal":
            continue
        missing = [line for line in ours[start:end] if not grammar.is_harmless(line)]
        for number, line in enumerate(given[first:last], first + 1):
            if grammar.is_harmless(line):
                continue
            at = next((row for row, one in enumerate(missing) if _differs_in_speed(one, line)), None)
            if at is None:
                yield "", number, line
            else:
                yield from (("without ", number, one) for one in missing[:at])
                missing = missing[at + 1 :]
        yield from (("without ", first + 1, one) for one in missing)


def _differs_in_speed(one: str, other: str) -> bool:
    """Tell whether two lines are the same but for speeds; a frame, a point or a zone is not a speed."""
    pairs = list(zip(_APART.split(one), _APART.split(other), strict=False))
    same_count = len(_APART.split(one)) == len(_APART.split(other))
    return same_count and all(a == b or (_SPEED.fullmatch(a) and _SPEED.fullmatch(b)) for a, b in pairs)


def _told(file: str, found: Sequence[tuple[str, int, str]]) -> Iterator[str]:
    """Yield one sentence for each text, with the first places."""
    places: dict[tuple[str, str], list[int]] = {}
    for what, number, line in found:
        places.setdefault((what, line), []).append(number)
    for (what, line), numbers in places.items():
        more = f" and {len(numbers) - MOST_PLACES} more" if len(numbers) > MOST_PLACES else ""
        where = f"line{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers[:MOST_PLACES]))}{more}"
        yield f"{file}, {where}: {what}{line[:80]!r}, as a template has it"
