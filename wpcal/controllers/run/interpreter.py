"""What the interpreters of all languages do alike: count steps, name places, hand on what they do not know."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

from wpcal.controllers.language.grammar import Does, Grammar, mark_of
from wpcal.controllers.language.jobs import JobLanguage
from wpcal.controllers.run.machine import (
    WHOLE_ZONE,
    Machine,
    Matrix,
    Place,
    ProgramError,
    Run,
    StoppedError,
    about,
    entries_of,
    rigid,
    turns_of,
)

WORD = re.compile(r"[A-Za-z_][\w-]*+")  #: May be the name of a routine.
MOST_BLOCKS = 40  #: Blocks (IF, WHILE …) in one another.
T = TypeVar("T")


class Interpreter:
    """Runs the files of a program.

    `tools`, `bases`: T_flange_tool and T_base_frame, shape (4, 4), that the controller has, by name or number.
    `signals`: The touch input as the language calls it, and whether it is on or off at contact. None: as searches say.
    `on_stop`: Whether the operator lets the program go on after this message.
    """

    grammar: Grammar
    SIGNAL = ""  #: Pattern of a search with the `name` of its input; a group `off` matches where contact turns it off.
    #: Patterns of instructions, and of heads of blocks, of languages of lines, with what runs them.
    _INSTRUCTIONS: tuple[tuple[str, Callable[..., int | None]], ...] = ()
    _BLOCKS: tuple[tuple[str, Callable[..., int | None]], ...] = ()

    def __init__(
        self,
        files: Mapping[str, str],
        machine: Machine,
        *,
        tools: Mapping[object, Matrix] | None = None,
        bases: Mapping[object, Matrix] | None = None,
        signals: Mapping[str, bool] | None = None,
        on_stop: Callable[[str], bool] = lambda _: True,
    ) -> None:
        self.machine, self.run, self.on_stop = machine, Run(), on_stop
        self.tools = {str(name): T for name, T in (tools or {}).items()}
        self.bases = {str(name): T for name, T in (bases or {}).items()}
        self.tool = self.frame = self.file = ""
        self.external: tuple[float, ...] = ()  #: As in `Place`.
        self.leader: Machine | None = None  #: The robot that holds the part, where one program moves both.
        self.line = self.calls = 0
        self.signals = dict(signals or {})
        for file, text in files.items():
            self.load(file, text)
            if signals is None:
                self.signals |= self.signals_of(text)

    def load(self, file: str, text: str) -> None:
        """Read a file; `ProgramError` when the controller would not load it."""
        raise NotImplementedError

    def declare(self, name: str, file: str, known: Mapping[str, Any]) -> str:
        """Return the name of a routine of a file; `ProgramError` when another file has it."""
        if name in known:
            raise ProgramError(f"{name} is declared twice: {known[name].file} has it, too", path=file)
        return name

    def signals_of(self, text: str) -> dict[str, bool]:
        """Return the inputs for which the searches of a text wait, and their levels."""
        found = re.finditer(self.SIGNAL, text) if self.SIGNAL else ()
        return {match["name"]: match["off"] is None for match in found}

    def routine(self, name: str) -> None:
        """Run a routine to its end."""
        raise NotImplementedError

    def bodies(self) -> Mapping[str, str]:
        """Return the texts of the routines that take no values, by name."""
        raise NotImplementedError

    def entries(self) -> list[str]:
        """Return the routines that no other one calls."""
        bodies = {name: self._words(text) for name, text in self.bodies().items()}
        return entries_of({name: [one for one in bodies if one.upper() in words] for name, words in bodies.items()})

    def _words(self, text: str) -> set[str]:
        lines = (line for line in text.splitlines() if not re.match(self.grammar.comment, line))
        return {word.upper() for line in lines for word in WORD.findall(line)}

    def start(self, routine: str) -> Run:
        """Run a routine and what it calls, to the end or to a stop of the operator."""
        try:
            self.routine(routine)
            self.run.is_finished = True
        except StoppedError:
            pass
        finally:
            self.calls = 0  # also of those that did not come to their end
        return self.run

    def step(self, file: str, line: int, work: Callable[[], T]) -> T | None:
        """Run one instruction; the machine takes what is wrong with it."""
        self.run.step(self.calls, file, line)
        self.file, self.line = file, line
        self.machine.at = Place(file, line, self.tool, self.frame, external=self.external)
        try:
            return work()
        except ProgramError as error:
            self.machine.at = Place(file, line, self.tool, self.frame, external=self.external)
            self.machine.refuse(error.at(file, line))
            return None

    def matched(self, line: str, at: int) -> int | None:
        """Run a line by the first pattern that it matches; return the line to go to, or None for the next."""
        for pattern, function in self._INSTRUCTIONS:
            if found := re.fullmatch(pattern, line):
                return function(self, *found.groups())
        for pattern, block in self._BLOCKS:
            if found := re.fullmatch(pattern, line):
                return block(self, at, *found.groups())
        self.unknown(line)
        return None

    def unknown(self, text: str) -> None:
        """Pass an instruction that moves nothing; `ProgramError` for any other."""
        if not self.grammar.is_harmless(text):
            raise ProgramError(f"not followed: {text.strip()[:80]!r}")

    def part(self, value: Any, name: str) -> Any:
        """Refuse parts of values."""
        raise ProgramError(f"not followed: .{name}")

    def output(self, name: str, number: int, *, on: bool) -> None:
        """Set an output."""
        self.run.outputs[f"{name}{number}"] = on
        self.machine.output(number, on)

    def remark(self, text: str) -> None:
        """Tell the machine of a mark of a seam."""
        if (does := mark_of(text)) is not None:
            self.machine.switch(does)

    def is_on(self, name: str) -> bool:
        """Tell whether an input is on."""
        if name not in self.signals:
            raise ProgramError(f"nobody knows the input {name}")
        return self.machine.is_on() == self.signals[name]

    def T_tool(self) -> Matrix:
        """Return T_flange_tool of the present tool."""
        return _known(self.tools, self.tool, "tool")

    def T_frame(self) -> Matrix:
        """Return T_base_frame of the present frame."""
        return _known(self.bases, self.frame, "frame")

    def go(
        self,
        kind: str,
        goal: Matrix,
        *,
        via: Matrix | None = None,
        speed_mm_s: float | None = None,
        zone_mm: float | None = None,
    ) -> None:
        """Move the present tool to a pose in `base`: ``J`` by the joints, ``L`` on a line, ``C`` through `via`."""
        T_tool = self.T_tool()
        at = self.machine.at
        self.machine.at = replace(at, tool=self.tool, frame=self.frame, speed_mm_s=speed_mm_s, external=self.external)
        self.blend(zone_mm)
        if via is not None:
            self.machine.arc(via, goal, T_tool)
        else:
            self.machine.move(goal, T_tool, is_line=kind == "L")

    def bring(self, external: Sequence[float]) -> None:
        """Say where the next motion brings the external axes, mm and deg; without numbers they stay."""
        if external:
            self.external = tuple(external)
            self.machine.at = replace(self.machine.at, external=self.external)

    def blend(self, zone_mm: float | None) -> None:
        """Say that the tool does not stop, but leaves the corner within a zone; None: it stops."""
        if zone_mm is not None:
            self.machine.at = replace(self.machine.at, blends=True, zone=(zone_mm, WHOLE_ZONE))

    def stop(self, message: str = "") -> None:
        """Stand until the operator lets the program go on."""
        self.run.stop(message or (self.run.messages[-1] if self.run.messages else ""), self.on_stop)


class LineInterpreter(Interpreter):
    """Runs languages of numbered lines, in which blocks are found by their ends: IF … ELSE … ENDIF, FOR … NEXT."""

    LONGEST_MESSAGE: int
    REMARKS: Mapping[str, float]  #: What begins a remark, and how many characters it may have.
    BLOCK: tuple[str, str, str]  #: Patterns of IF, ELSE and ENDIF.
    LABELLED: str  #: How a label is shown.
    FOR: tuple[str, str]  #: Patterns of the head of a loop that counts, and of its end.
    LABEL = r"LBL\[|\*|END"  #: Patterns of a place to jump to, and of an end.
    jobs: dict[str, Any]  #: Programs by name, with their `file` and their `lines`: numbers and texts.
    job: Any = None  #: The one that runs.
    loops: list[tuple[int, str, Any, Any]]  #: Lines of the heads, what counts, the last value and the step.

    def bodies(self) -> Mapping[str, str]:
        """Return the programs."""
        return {name: "\n".join(line for _, line in one.lines) for name, one in self.jobs.items()}

    def lines(self) -> Iterator[tuple[str, int]]:
        """Yield file and number of each line that can run, without those that only bound blocks."""
        bounds = "|".join((*self.BLOCK, *self.FOR, self.LABEL))
        for job in self.jobs.values():
            yield from ((job.file, number) for number, line in job.lines if not re.match(bounds, line))

    def routine(self, name: str) -> None:
        """Run a program to its end."""
        if name.upper() not in self.jobs:
            raise ProgramError(f"CALL {name}: it is not there")
        before, loops = self.job, self.loops
        self.job, self.loops = job, _ = self.jobs[name.upper()], []
        self.calls += 1
        at = 0
        while 0 <= at < len(job.lines):
            number, line = job.lines[at]
            jump = self.step(job.file, number, partial(self.execute, line, at))
            at = at + 1 if jump is None else jump
        self.machine.switch(Does.STOP)
        self.calls -= 1
        self.job, self.loops = before, loops

    def execute(self, line: str, at: int) -> int | None:
        """Run one line; return the line to go to, -1 at the end, or None for the next."""
        for mark, longest in self.REMARKS.items():
            if line.startswith(mark):
                if len(line) > 1 + longest:
                    raise ProgramError(f"a remark has at most {longest} characters: {line!r}")
                self.remark(line[1:])
                return None
        return self.instruction(line, at)

    def instruction(self, line: str, at: int) -> int | None:
        """Run one line that is no remark."""
        raise NotImplementedError

    def number(self, name: str) -> Any:
        """Return the value of a variable."""
        raise NotImplementedError

    def set(self, name: str, value: Any) -> None:
        """Give a variable a value."""
        raise NotImplementedError

    def holds(self, condition: str) -> bool:
        """Tell whether a condition holds."""
        raise NotImplementedError

    def end_of(self, at: int, opens: str, *ends: str, by: int = 1) -> int:
        """Return the line of a block that is one of `ends`."""
        return matching([line for _, line in self.job.lines], at, opens, ends, by=by)

    def then(self, at: int, condition: str) -> int | None:
        """Go on in a block that holds, otherwise behind it or in its ELSE."""
        return None if self.holds(condition) else self.end_of(at, *self.BLOCK) + 1

    def otherwise(self, at: int) -> int:
        """Go to the end of a block whose first part has run."""
        opens, _, end = self.BLOCK
        return self.end_of(at, opens, end)

    def count_from(self, at: int, name: str, first: Any, last: Any, step: int = 1) -> int | None:
        """Begin a loop with a variable that counts, or pass it."""
        end = self.end_of(at, *self.FOR)
        self.set(name, first)
        if (last - first) * step < 0:
            return end + 1
        self.loops.append((at, name, last, step))
        return None

    def count_on(self, _at: int) -> int | None:
        """Go back to the head of a loop until its variable has counted to the end."""
        if not self.loops:
            raise ProgramError("the end of a loop without FOR")
        begin, name, last, step = self.loops[-1]
        if (last - self.number(name)) * step <= 0:
            self.loops.pop()
            return None
        self.set(name, self.number(name) + step)
        return begin + 1

    def jump(self, label: str, condition: str | None = None) -> int | None:
        """Go to a label if the condition holds."""
        if label not in self.job.labels:
            raise ProgramError(f"{self.LABELLED.format(label)} is not there")
        return int(self.job.labels[label]) if condition is None or self.holds(condition) else None

    def pause(self, condition: str | None = None) -> None:
        """Stand if the condition holds, until the operator lets the program go on."""
        if condition is None or self.holds(condition):
            self.stop()

    def message(self, text: str) -> None:
        """Show a message."""
        if len(text) > self.LONGEST_MESSAGE:
            raise ProgramError(f"a message has {self.LONGEST_MESSAGE} characters: {text!r}")
        self.run.messages.append(text)

    def abort(self) -> None:
        """End all programs."""
        raise StoppedError("ABORT")

    def wait(self, condition: str, seconds: str | None = None) -> None:
        """Wait for the touch, or for what the program itself knows; with a time for nothing."""
        is_judged = any(name in condition for name in self.signals) or not self.grammar.is_harmless(f"WAIT {condition}")
        if is_judged and not self.holds(condition) and seconds is None:
            self.stop(f"WAIT {condition}")


def _known(given: Mapping[str, Matrix], name: str, what: str) -> Matrix:
    if name not in given and "" in given:
        return given[""]
    if name not in given:
        raise ProgramError(f"the {what} {name} is not set" if name else f"a motion before a {what} is set")
    return given[name]


def matching(lines: Sequence[str], at: int, opens: str, ends: Sequence[str], *, by: int = 1) -> int:
    """Return the line of a block that is one of `ends`, from a line of the block on; blocks in it are passed.

    `ends` are patterns, the last of them that of the end of such a block; `by` -1 looks for the line that begins it.
    """
    depth, here = 0, at + by
    while 0 <= here < len(lines):
        if depth == 0 and any(re.match(end, lines[here]) for end in ends):
            return here
        depth += (re.match(opens, lines[here]) is not None) - (re.match(ends[-1], lines[here]) is not None)
        here += by
    raise ProgramError("a block has no end")


def matrix_of(values: Sequence[float]) -> Matrix:
    """Return X Y Z and angles about fixed x, y and z as a matrix, mm and deg: R = Rz Ry Rx."""
    return rigid(about("ZYX", values[5:2:-1]), values[:3])


def numbers_of(T: Matrix, mm_decimals: int, deg_decimals: int) -> list[float]:
    """Return X Y Z and angles about fixed x, y and z with this many digits."""
    at = [round(float(v), mm_decimals) + 0.0 for v in T[:3, 3]]
    return [*at, *(round(v, deg_decimals) + 0.0 for v in reversed(turns_of("ZYX", T)))]


def stated_frame(text: str, language: JobLanguage, what: str = "") -> dict[str, Matrix]:
    """Return the user frame that the remarks of a program ask the operator to set, or what else (a pattern)."""
    number = re.search(what or rf"set {language.frame_word} (\d++) to the part:", text)
    after = text[number.end() :] if number else ""
    values = [
        re.search(rf"[!'] {key} (-?\d[\d.]{{0,20}}+)[ ;\r]*+$", after, re.MULTILINE) for key in language.frame_keys
    ]
    found = [float(each[1]) for each in values if each is not None]
    return {number[1]: matrix_of(found)} if number is not None and len(found) == len(values) else {}
