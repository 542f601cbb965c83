"""Read the arc instructions of written programs back: the arc burns along every seam, and nowhere else.

A program with arc instructions has the comments SEAM START and SEAM END around the moves of every seam. Between them
the arc must be on for every move; outside of them it must be off. A program of a dry run has the comments ARC ON and
ARC OFF instead, and no arc instruction. Programs of others have neither, and are not judged.

Of all digital outputs only that of the arc counts: the number that the program's header states, or a person.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from wpcal.controllers.audit.fault import Fault
from wpcal.controllers.program.arc import SEAM_MARKS
from wpcal.controllers.taught_program import ENCODING


class _Event(Enum):
    """What a line does."""

    START = "start of a seam"
    END = "end of a seam"
    DRY = "mark of a dry run"
    MOVE = "move"
    ON = "arc on"
    OFF = "arc off"
    STOP = "end of a procedure"


@dataclass(frozen=True, slots=True)
class _Language:
    """How the lines of one language are recognised; the first pattern that fits decides."""

    #: Some events are two: a last arc move of RAPID is a move and ends the arc.
    patterns: tuple[tuple[re.Pattern[str], tuple[_Event, ...]], ...]
    #: How a header states the number of the output that switches the arc; empty for a language without one.
    stated: str = ""
    output: str = ""  #: The instruction that sets an output: its number, and its state as the group ``state``.

    def with_output(self, number: int | None) -> _Language:
        """Return the language with the output of this number as a switch of the arc."""
        if number is None or not self.output:
            return self
        switch = [
            (re.compile(self.output.format(number=number, state=state), re.IGNORECASE), (event,))
            for state, event in (("TRUE", _Event.ON), ("FALSE", _Event.OFF))
        ]
        return _Language((*switch, *self.patterns), self.stated, self.output)


def _language(comment: str, *, stated: str = "", output: str = "", **patterns: str) -> _Language:
    """Return a language from its mark of comments, and patterns by the names of events."""
    start, end = (re.escape(mark) for mark in SEAM_MARKS)
    marks = (
        (re.compile(rf"{comment} ?{start}[ ;]*$"), (_Event.START,)),
        (re.compile(rf"{comment} ?{end}[ ;]*$"), (_Event.END,)),
        (re.compile(rf"{comment} ?ARC (?:ON|OFF)[ ;]*$"), (_Event.DRY,)),
    )
    events = {
        "on": (_Event.ON,),
        "off": (_Event.OFF,),
        "move_off": (_Event.MOVE, _Event.OFF),
        "move": (_Event.MOVE,),
        "stop": (_Event.STOP,),
    }
    own = tuple((re.compile(text, re.IGNORECASE), events[name]) for name, text in patterns.items())
    return _Language((*marks, *own), stated, output)


_LINE = r"^[ \t]*+(?:\d++:)?[ \t]*+"
LANGUAGES: Mapping[str, _Language] = {
    ".mod": _language(
        r"^[ \t]*+!",
        on=r"^[ \t]*+Arc[LC]Start\b",
        move_off=r"^[ \t]*+Arc[LC]End\b",
        move=r"^[ \t]*+(?:Arc[LC]|Move[LCJ]|MoveAbsJ)\b",
        stop=r"^[ \t]*+ENDPROC\b",
    ),
    ".ls": _language(
        _LINE + "!", on=_LINE + r"Weld Start\[", off=_LINE + r"Weld End\[", move=_LINE + r"[JLCA] ?P\[", stop=r"^/POS"
    ),
    ".src": _language(
        r"^[ \t]*+;",
        stated=r"\$OUT\[(\d{1,9}+)\] switches the arc",
        output=r"^[ \t]*+\$OUT\[{number}\][ \t]*+=[ \t]*+{state}\b",
        on=r"^[ \t]*+(?:ArcMainNG\(#ArcOnBeforeMoveStd\b|ARC_START\()",
        off=r"^[ \t]*+(?:ArcMainNG\(#ArcOffAfterMoveStd\b|ARC_END\()",
        move=r"^[ \t]*+(?:LIN|CIRC|PTP|SLIN|SCIRC|SPTP)\b",
        stop=r"^[ \t]*+END\b[ \t]*+$",
    ),
    ".jbi": _language(r"^'", on=r"^ARCON\b", off=r"^ARCOF\b", move=r"^S?MOV[JLCS]\b", stop=r"^END\b"),
    ".script": _language(
        r"^[ \t]*+#",
        stated=r"standard digital output (\d{1,9}+) switches the arc",
        output=r"^[ \t]*+set_standard_digital_out\([ \t]*+{number}[ \t]*+,[ \t]*+{state}[ \t]*+\)",
        on=r"^[ \t]*+arc_start\(",
        off=r"^[ \t]*+arc_end\(",
        move=r"^[ \t]*+move[jlcp]\(",
        stop=r"^end\b",
    ),
    ".pgx": _language(
        r"^[ \t]*+//",
        on=r"^[ \t]*+(?:call arcStart\(|doArc=true)",
        off=r"^[ \t]*+(?:call arcEnd\(|doArc=false)",
        move=r"^[ \t]*+move[jlc]\(",
        stop=r"^end\]\]>",
    ),
    ".as": _language(
        r"^[ \t]*+;",
        on=r"^[ \t]*+[LJ]WS\b",
        move_off=r"^[ \t]*+[LJ]WE\b",
        move=r"^[ \t]*+(?:[LJ]MOVE|C[12]MOVE|[LJ]WC|C[12]WC|HOME)\b",
        stop=r"^\.END\b",
    ),
}
"""By suffix. A number of patterns that do not overlap; letters of marks are capital."""


def has_arc_language(path: Path) -> bool:
    """Tell by the suffix whether arc instructions of a file can be read back."""
    return path.suffix.lower() in LANGUAGES


def arc_faults(raw: bytes, path: Path, output: int | None = None) -> list[Fault]:
    """Return where the arc is on or off in the wrong place.

    Parameters
    ----------
    raw : Of the file.
    path : Its suffix tells the language.
    output : Number of the digital output that switches the arc; by default that which the file's header states.
    """
    events = _events_of(raw, path, output)
    kinds = {event for _, event in events}
    if _Event.START in kinds or _Event.END in kinds:
        return list(_faults(events))
    if _Event.DRY in kinds:
        return [
            Fault("an arc instruction in a program of a dry run", line)
            for line, event in events
            if event in (_Event.ON, _Event.OFF)
        ]
    return []


def count_switches(raw: bytes, path: Path, output: int | None = None) -> Counter[str]:
    """Return how often a program begins and ends a seam, and starts and ends the arc, in words that are known.

    Parameters
    ----------
    raw : Of the file.
    output : As for `arc_faults`.

    Returns
    -------
    Counter. By ``begin seam``, ``end seam``, ``start arc`` and ``end arc``.
    """
    names = {
        _Event.START: "begin seam",
        _Event.END: "end seam",
        _Event.ON: "start arc",
        _Event.OFF: "end arc",
    }
    return Counter(names[event] for _, event in _events_of(raw, path, output) if event in names)


def _events_of(raw: bytes, path: Path, output: int | None) -> list[tuple[int, _Event]]:
    language = LANGUAGES.get(path.suffix.lower())
    if language is None:
        return []
    text = raw.decode(ENCODING)
    if output is None and language.stated and (stated := re.search(language.stated, text)):
        output = int(stated[1])
    return list(_events(text.splitlines(), language.with_output(output)))


def _events(lines: list[str], language: _Language) -> Iterator[tuple[int, _Event]]:
    for number, line in enumerate(lines, 1):
        for pattern, events in language.patterns:
            if pattern.match(line):
                yield from ((number, event) for event in events)
                break


def _faults(events: list[tuple[int, _Event]]) -> Iterator[Fault]:
    is_on, in_seam, had_arc = False, False, False
    for line, event in events:
        for is_wrong, what in _rules(event, is_on=is_on, in_seam=in_seam, had_arc=had_arc):
            if is_wrong:
                yield Fault(what, line)
        if event in (_Event.START, _Event.END, _Event.STOP):
            in_seam, is_on, had_arc = event is _Event.START, is_on and event is _Event.START, False
        elif event in (_Event.ON, _Event.OFF):
            is_on = event is _Event.ON
            had_arc = had_arc or is_on


def _rules(event: _Event, *, is_on: bool, in_seam: bool, had_arc: bool) -> tuple[tuple[bool, str], ...]:
    """Return what can be wrong at an event, and whether it is."""
    rules: Mapping[_Event, tuple[tuple[bool, str], ...]] = {
        _Event.START: ((in_seam, "a seam begins before the one before it has ended"),),
        _Event.END: (
            (is_on, "the arc is still on at the end of a seam"),
            (not had_arc, "a seam without an arc"),
        ),
        _Event.ON: ((is_on, "the arc is switched on while it burns"), (not in_seam, "arc on between seams")),
        _Event.OFF: ((not is_on, "the arc is switched off while it is off"),),
        _Event.MOVE: (
            (in_seam and not is_on, "a move along a seam without the arc"),
            (is_on and not in_seam, "the arc burns on a move between seams"),
        ),
        _Event.STOP: ((is_on or in_seam, "the program ends within a seam"),),
    }
    return rules.get(event, ())
