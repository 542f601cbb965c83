"""Execute a finished program: from its files to where it moves the robot."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from wpcal.controllers.language.grammar import ENCODING
from wpcal.controllers.registry import Controller, controller_of_program, grammar_of_file
from wpcal.controllers.run.machine import EndlessError, Place, ProgramError, about, rigid
from wpcal.controllers.run.recorder import Recorder, Trace, Unknown
from wpcal.core.arrays import FloatArray

Files = Mapping[str, str | bytes]

NUMBERS = range(1, 64)  #: Of tools and frames.
UNDECLARED = ""  #: The name of the tool or frame that stands for all which the files do not declare.
TOOL_OF_CONTROLLER = rigid(about("ZYX", (11.0, -40.0, 17.0)), (101.0, 37.0, 411.0))
"""T_flange_tool of tools that only the controller knows: like no tool that a program sets."""


def interpreted(name: str | Path) -> Controller | None:
    """Return the controller whose interpreter executes a file; None without one."""
    controller = controller_of_program(Path(name))
    return None if controller is None or controller.run is None else controller


def programs_of(files: Files) -> dict[str, str | bytes]:
    """Return the files whose language can be executed."""
    return {name: data for name, data in files.items() if interpreted(name) is not None}


def texts_of(files: Files) -> dict[str, str]:
    """Return files as text."""
    return {name: data if isinstance(data, str) else data.decode(ENCODING) for name, data in files.items()}


def execute(
    files: Files,
    *,
    tools: Sequence[str | int] = (UNDECLARED,),
    T_flange_tool: FloatArray = TOOL_OF_CONTROLLER,
    T_base_frame: FloatArray | None = None,
    recorder: Recorder | None = None,
    leader: Recorder | None = None,
) -> Trace:
    """Execute every routine of some files of one language that no other one calls.

    `tools`: Names and numbers of tools that the controller has, and where they are: `T_flange_tool`, shape (4, 4).
    `recorder`: What knows pulses, the output of the arc and where searches find the part.
    `leader`: What writes down the robot that holds the part, where one program moves both.
    `T_base_frame`: shape (4, 4). Where frames are that the files do not declare; None: a move in one is not followed.

    Raises `ProgramError` when a file cannot be read.
    """
    texts = texts_of(files)
    controller = interpreted(next(iter(texts)))
    if controller is None:
        raise ProgramError(f"no interpreter for {', '.join(texts)}")
    bases = {} if T_base_frame is None else dict.fromkeys((UNDECLARED, *NUMBERS), T_base_frame)
    grammar = controller.load_grammar()
    recorder = recorder or Recorder()
    if recorder.arc_output is None and grammar is not None:
        stated = (found for text in texts.values() if (found := grammar.arc_output(text)) is not None)
        recorder.arc_output = next(stated, None)
    interpreter = controller.load_interpreter()(
        texts, recorder, tools=dict.fromkeys(tools, T_flange_tool), bases=bases, on_stop=lambda _: True
    )
    interpreter.leader = leader
    for routine in interpreter.entries():
        recorder.begin()
        _start(interpreter, routine, recorder)
    ran = {(place.file, place.line) for place in recorder.trace.steps}
    recorder.trace.idle = [Place(*one) for one in interpreter.lines() if one not in ran]
    return recorder.trace


def _start(interpreter: Any, routine: str, recorder: Recorder) -> None:
    interpreter.run.steps = 0  # each routine has its own share of steps
    try:
        interpreter.start(routine)
    except ProgramError as error:
        recorder.refuse(error)
    except EndlessError as error:
        recorder.trace.unknowns.append(Unknown(recorder.at, str(error), len(recorder.trace.steps)))


def text_at(place: Place, files: Files) -> str:
    """Return the text of the line of a place."""
    lines = texts_of({"": files.get(place.file, "")})[""].splitlines()
    return lines[place.line - 1].strip() if 0 < place.line <= len(lines) else ""


def that_move(places: Iterable[Place], files: Files) -> Iterator[Place]:
    """Yield the places of lines that may move something."""
    for place in places:
        grammar = grammar_of_file(Path(place.file))
        if grammar is None or not grammar.is_harmless(text_at(place, files)):
            yield place
