"""Read the arc instructions of written programs back: the arc burns along every seam, and nowhere else.

A program with arc instructions has the comments SEAM START and SEAM END around the moves of every seam. Between them
the arc must be on for every move; outside of them it must be off. A program of a dry run has the comments ARC ON and
ARC OFF instead, and no arc instruction. Programs of others have neither, and are not judged.

Of all digital outputs only that of the arc counts: the number that the program's header states, or a person.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

from wpcal.controllers.audit.fault import Fault
from wpcal.controllers.language.grammar import ENCODING, Does, Instruction
from wpcal.controllers.registry import grammar_of_file


def arc_faults(raw: bytes, path: Path, output: int | None = None) -> list[Fault]:
    """Return where the arc is on or off in the wrong place; nothing of a file that no grammar knows."""
    found = _instructions(raw, path, output)
    kinds = {each.does for each in found}
    if Does.START in kinds or Does.END in kinds:
        return list(_faults(found))
    if Does.DRY in kinds:
        what = "an arc instruction in a program of a dry run"
        return [Fault(what, each.line) for each in found if each.does in (Does.ON, Does.OFF)]
    return []


def count_switches(raw: bytes, path: Path, output: int | None = None) -> Counter[str]:
    """Return how often a program has each of ``begin seam``, ``end seam``, ``start arc`` and ``end arc``."""
    names = {Does.START: "begin seam", Does.END: "end seam", Does.ON: "start arc", Does.OFF: "end arc"}
    return Counter(names[each.does] for each in _instructions(raw, path, output) if each.does in names)


def _instructions(raw: bytes, path: Path, output: int | None) -> list[Instruction]:
    grammar = grammar_of_file(path)
    return [] if grammar is None else list(grammar.instructions(raw.decode(ENCODING), output))


def _faults(found: list[Instruction]) -> Iterator[Fault]:
    is_on, in_seam, had_arc = False, False, False
    for each in found:
        line, event = each.line, each.does
        for is_wrong, what in _rules(event, is_on=is_on, in_seam=in_seam, had_arc=had_arc):
            if is_wrong:
                yield Fault(what, line)
        if event in (Does.START, Does.END, Does.STOP):
            in_seam, is_on, had_arc = event is Does.START, is_on and event is Does.START, False
        elif event in (Does.ON, Does.OFF):
            is_on = event is Does.ON
            had_arc = had_arc or is_on


def _rules(event: Does, *, is_on: bool, in_seam: bool, had_arc: bool) -> tuple[tuple[bool, str], ...]:
    """Return what can be wrong at an event, and whether it is."""
    rules: Mapping[Does, tuple[tuple[bool, str], ...]] = {
        Does.START: ((in_seam, "a seam begins before the one before it has ended"),),
        Does.END: (
            (is_on, "the arc is still on at the end of a seam"),
            (not had_arc, "a seam without an arc"),
        ),
        Does.ON: ((is_on, "the arc is switched on while it burns"), (not in_seam, "arc on between seams")),
        Does.OFF: ((not is_on, "the arc is switched off while it is off"),),
        Does.MOVE: (
            (in_seam and not is_on, "a move along a seam without the arc"),
            (is_on and not in_seam, "the arc burns on a move between seams"),
        ),
        Does.STOP: ((is_on or in_seam, "the program ends within a seam"),),
    }
    return rules.get(event, ())
