"""How a program runs and ends, in any language."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field

from wpcal.core.errors import FormatError, InputError

MOST_STEPS = 100_000  #: Instructions of one run: 30 seams have some 5000.
MOST_CALLS = 30  #: Calls in one another.
MOST_ELEMENTS = 100_000  #: Of an array.


def entries_of(calls: Mapping[str, Collection[str]]) -> list[str]:
    """Return the routines that no other one calls, then the first of those that only call each other, or themselves.

    `calls`: The names that each routine calls.
    """
    called = {one for name, others in calls.items() for one in others if one != name}
    found, reached = list[str](), set[str]()
    for name in sorted(calls, key=called.__contains__):
        if name not in reached:
            found.append(name)
            front = [name]
            while front:
                one = front.pop()
                front += [other for other in calls.get(one, ()) if other not in reached]
                reached.add(one)
    return found


class ProgramError(FormatError):
    """The program says what its controller would refuse, or what its interpreter does not know."""

    def at(self, file: str, line: int) -> ProgramError:
        """Return the error with its place, unless it has one."""
        return self if self.line is not None else ProgramError(self.what, path=file, line=line)


class EndlessError(InputError):
    """The program does not come to an end."""


class StoppedError(Exception):
    """The program ended itself, or was ended by its operator."""


@dataclass
class Run:
    """What a run of a program left: messages, stops, files, and whether it came to its end."""

    messages: list[str] = field(default_factory=list)
    stops: list[str] = field(default_factory=list)
    files: dict[str, str] = field(default_factory=dict)
    is_finished: bool = False
    outputs: dict[str, bool] = field(default_factory=dict)
    steps: int = 0

    def stop(self, message: str, on_stop: Callable[[str], bool]) -> None:
        """Stand with a message; the operator lets the program go on, or ends it."""
        self.stops.append(message)
        if not on_stop(message):
            raise StoppedError(message)

    def step(self, calls: int, file: str, line: int) -> None:
        """Count an instruction in so many calls; `EndlessError` when there are too many."""
        self.steps += 1
        if self.steps > MOST_STEPS or calls > MOST_CALLS:
            what = f"{MOST_STEPS} instructions" if self.steps > MOST_STEPS else f"{MOST_CALLS} calls in one another"
            raise EndlessError(f"{file}, line {line}: the program does not end within {what}")
