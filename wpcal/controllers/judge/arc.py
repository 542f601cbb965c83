"""Judge where the arc burns: on along every seam, off everywhere else.

A program with arc instructions has the comments SEAM START and SEAM END around the moves of every seam. Between them
the arc must be on for every move, but the one to where it is struck; outside of them it must be off. A program of a dry
run has the comments ARC ON and ARC OFF instead, and no arc instruction. Programs of others have neither, and are not
judged.

Of all digital outputs only that of the arc counts: the number that the program's header states, or a person.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.machine import Place
from wpcal.controllers.run.recorder import Trace

ALL_SWITCHES = frozenset({Does.START, Does.END, Does.ON, Does.OFF})
"""Beginning and end of a seam, start and end of the arc: with all of them a program can be judged."""

LEADS = [Does.START, Does.MOVE, Does.ON, Does.MOVE]
"""The first of the moves leads to where the arc is struck, as ``ArcLStart`` does."""


def arc_faults(trace: Trace) -> Iterator[tuple[Place, str]]:
    """Yield where the arc is on or off in the wrong place, and what is wrong."""
    kinds = {each.does for each in trace.events}
    if kinds & {Does.START, Does.END}:
        yield from _faults(trace)
    elif Does.DRY in kinds:
        what = "an arc instruction in a program of a dry run"
        yield from ((each.place, what) for each in trace.events if each.does in (Does.ON, Does.OFF))


def _faults(trace: Trace) -> Iterator[tuple[Place, str]]:
    is_on, in_seam, had_arc = False, False, False
    kinds = [each.does for each in trace.events]
    for event in (each for row, each in enumerate(trace.events) if kinds[max(row - 1, 0) : row + 3] != LEADS):
        does = event.does
        for is_wrong, what in _rules(does, is_on=is_on, in_seam=in_seam, had_arc=had_arc):
            if is_wrong:
                yield event.place, what
        if does in (Does.START, Does.END, Does.STOP):
            in_seam, is_on, had_arc = does is Does.START, is_on and does is Does.START, False
        elif does in (Does.ON, Does.OFF):
            is_on = does is Does.ON
            had_arc = had_arc or is_on


def _rules(event: Does, *, is_on: bool, in_seam: bool, had_arc: bool) -> tuple[tuple[bool, str], ...]:
    """Return what can be wrong at an event, and whether it is."""
    rules: Mapping[Does, tuple[tuple[bool, str], ...]] = {
        Does.START: ((in_seam, "a seam begins before the one before it has ended"),),
        Does.END: ((is_on, "the arc is still on at the end of a seam"), (not had_arc, "a seam without an arc")),
        Does.ON: ((is_on, "the arc is switched on while it burns"), (not in_seam, "arc on between seams")),
        Does.OFF: ((not is_on, "the arc is switched off while it is off"),),
        Does.MOVE: (
            (in_seam and not is_on, "a move along a seam without the arc"),
            (is_on and not in_seam, "the arc burns on a move between seams"),
        ),
        Does.STOP: ((is_on or in_seam, "the program ends within a seam"),),
    }
    return rules.get(event, ())
