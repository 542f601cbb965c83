"""Judge a finished program before it is put in place: only what its text does may become the word "checked".

The text is executed. It has to lead where it was asked to, in that order and with that tool, and nowhere else; on its
way nothing meets anything; the arc burns along the seams and nowhere else. What a template of the user adds is followed
and swept as well; a line that is not followed is named by file and line, and the program is not called checked.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from wpcal.brep.hits import START_MM
from wpcal.controllers.judge.arc import ALL_SWITCHES, arc_faults
from wpcal.controllers.judge.asked import Asked, Compared, asked_of, asked_of_touches, compare, contacts_of
from wpcal.controllers.judge.execute import Files, execute, programs_of, text_at, that_move
from wpcal.controllers.judge.swept import is_followed, meetings
from wpcal.controllers.language.grammar import Does
from wpcal.controllers.language.post import blocks_of, own_arc_templates
from wpcal.controllers.program import WeldProgram
from wpcal.controllers.program.air_moves import TorchAtTool
from wpcal.controllers.program.arc import SEAM_MARKS
from wpcal.controllers.program.checked_program import part_in_base
from wpcal.controllers.program.touch_program import TouchProgram
from wpcal.controllers.registry import find_controller
from wpcal.controllers.run.machine import Place
from wpcal.controllers.run.recorder import Motion, Recorder, Trace, Unknown, pulses_of
from wpcal.core.errors import InputError, WpcalError
from wpcal.seam.judge.stations import start_mm
from wpcal.seam.record_check import FARTHEST_MM

if TYPE_CHECKING:
    from wpcal.controllers.judge.in_cell import CellSweep

ROOM_MM = 1.0  #: A motion that was not asked for may leave the box of those that were by this.
MOST_PLACES = 3  #: Of one text that are told; a template is used for every seam.

P = TypeVar("P", WeldProgram, TouchProgram)


class WrittenWrongError(WpcalError):
    """A program that was written does other things than it should: a fault of wpcal."""

    exit_code = 70


class WrittenBlockedError(WrittenWrongError):
    """A motion of a written program is not free in its cell."""


@dataclass(frozen=True, slots=True, eq=False)
class Written(Generic[P]):
    """The files of a program, and what was not checked of them."""

    files: Files
    program: P  #: It says of itself that it was checked only if it was.
    not_checked: tuple[str, ...] = ()  #: By file and line.
    unjudged: tuple[str, ...] = ()  #: What no line stands for.


def write_judged(name: str, write: Callable[[P], Files], program: P, *, in_cell: CellSweep | None = None) -> Written[P]:
    """Write a program in the format `name`, and judge the text.

    `in_cell`: What sweeps the motions of a planned program.

    Raises `WrittenWrongError` when the program does other things than it should, and no template of the user made it.
    Raises `InputError` when the language cannot hold the program, or a template has a fault or makes the program do
    other things.
    """
    files, controller = write(program), find_controller(name)
    if controller is None:  # a table: it moves nothing
        return Written(files, program)
    if controller.run is None:
        unchecked = _unchecked(program)
        return Written(
            write(unchecked), unchecked, (), (f"the written program: {name} has no interpreter that could execute it",)
        )
    try:
        told, unjudged = _judged(files, program, name, in_cell)
        if not told:
            return Written(files, program, (), unjudged)
        unchecked = _unchecked(program)  # its header has other lines: the places are found anew
        files = write(unchecked)
        return Written(files, unchecked, *_judged(files, unchecked, name, in_cell))
    except WrittenWrongError as error:
        if program.controller.templates is None:
            raise
        raise InputError(f"{program.controller.templates}: the templates break the program: {error}") from None


def _unchecked(program: P) -> P:
    return replace(program, checked=()) if isinstance(program, WeldProgram) else program


def _judged(
    files: Files, program: WeldProgram | TouchProgram, name: str, in_cell: CellSweep | None
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return which lines were not followed, and what else was not judged."""
    trace, asked = run_written(files, program, name=name), _asked(program, name)
    found, unjudged, idle = compare(trace, asked), tuple[str, ...](), list[Place]()
    if isinstance(program, WeldProgram):
        _refuse_wrong_arcs(trace, program, name)
        unjudged, idle = tuple(_unjudged_arcs(trace, program, name)), list(that_move(trace.idle, files))
    _refuse_unasked(trace, asked, found, name, is_ours=_is_ours(program))
    strays = {id(motion) for motion in found.others}
    motions = [motion for motion in trace.motions if id(motion) not in strays]
    for meeting in () if in_cell is None else in_cell.meetings(motions):
        raise WrittenBlockedError(str(_wrong(name, meeting.motion.place, meeting.what)))
    added = _require_free(trace, found, asked, program, name) if isinstance(program, WeldProgram) else []
    strange: list[Unknown | Motion] = [*trace.unknowns]
    strange += [each for each in (*found.bent, *found.others) if each not in added]
    places = [*(each.place for each in strange), *_causes(trace, found, files, strange), *idle]
    lines = {(place.file, place.line): text_at(place, files) for place in places}
    return tuple(_told(lines)), unjudged


def _asked(program: WeldProgram | TouchProgram, name: str) -> Asked:
    controller = find_controller(name)
    if isinstance(program, WeldProgram):
        asked = asked_of(program, alone=controller is not None and controller.welds_alone)
    else:
        asked = asked_of_touches(program)
    if not np.nanmax(np.abs(asked.p), initial=0.0) < FARTHEST_MM:
        raise InputError(f"{name}: a pose is more than {FARTHEST_MM:g} mm away; nothing is written")
    return asked


def _is_ours(program: WeldProgram | TouchProgram) -> bool:
    """Tell whether every line is of wpcal, and known to it."""
    has_package = isinstance(program, TouchProgram) and program.setup.with_package
    return program.controller.templates is None and not has_package


def _refuse_unasked(trace: Trace, asked: Asked, found: Compared, name: str, *, is_ours: bool) -> None:
    for unknown in trace.unknowns if is_ours else ():
        raise _wrong(name, unknown.place, unknown.text)
    if is_ours or (found.missing and not trace.unknowns):
        _refuse_other_way(asked, found, name)


def run_written(files: Files, program: WeldProgram | TouchProgram, *, name: str) -> Trace:
    """Execute the files of a program; `WrittenWrongError` when one cannot be read."""
    output = None if program.arc is None else program.arc.output
    felt = {"feel": contacts_of(program.plan)} if isinstance(program, TouchProgram) else {}
    try:
        return execute(
            programs_of(files),
            tools=(program.controller.tool_name, program.controller.tool_number),
            recorder=Recorder(pulses_of(program.arm), arc_output=output, **felt),
        )
    except WpcalError as error:
        what = f"{name}: the written program cannot be read back: {error}; nothing is written"
        raise WrittenWrongError(what) from None


def _refuse_other_way(asked: Asked, found: Compared, name: str) -> None:
    if found.others:
        raise _wrong(name, found.others[0].place, _elsewhere(found.others[0]))
    if found.missing:
        x, y, z = asked.p[found.missing[0]]
        what = "a move to joints" if np.isnan(x) else f"the pose at base {x:.3f}, {y:.3f}, {z:.3f} mm"
        raise WrittenWrongError(f"{name}: {what} is missing in the written program, read back; nothing is written")
    for motion in found.bent:
        what = "does not stop" if motion.place.blends else "is not on a line"
        raise _wrong(name, motion.place, f"{what} where it should")


def _wrong(name: str, place: Place, what: str) -> WrittenWrongError:
    return WrittenWrongError(f"{name}: {place.file}, line {place.line}: {what}; nothing is written")


def _elsewhere(motion: Motion) -> str:
    if motion.goal is None:
        return "a move to joints was not asked for"
    x, y, z = motion.goal[:3, 3]
    return f"the pose at base {x:.3f}, {y:.3f}, {z:.3f} mm was not asked for, but is in the written program, read back"


def _causes(trace: Trace, found: Compared, files: Files, strange: Sequence[Unknown | Motion]) -> Iterator[Place]:
    """Yield what ran before what leads elsewhere, since the last motion as asked: a frame, a tool, a register."""
    others, first = {id(motion) for motion in found.others}, dict[int, int]()
    good = [motion.step for motion in trace.motions if id(motion) not in others]
    for step in sorted(each.step for each in strange):
        first.setdefault(max((one for one in good if one < step), default=0), step)
    for begin, end in first.items():
        yield from that_move(dict.fromkeys(trace.steps[begin : end - 1]), files)  # a loop runs a line many times


def _is_near(motion: Motion, trace: Trace, asked: Asked) -> bool:
    """Tell whether a motion is followed, stops, has the tool of the others, and stays between what was asked."""
    tool, _ = Counter(each.place.tool for each in trace.motions).most_common(1)[0]
    if not is_followed(motion) or motion.place.blends or motion.place.tool != tool or motion.goal is None:
        return False
    beyond = np.maximum(
        np.nanmin(asked.p, axis=0) - motion.goal[:3, 3], motion.goal[:3, 3] - np.nanmax(asked.p, axis=0)
    )
    return bool(beyond.max() <= ROOM_MM)


def _require_free(trace: Trace, found: Compared, asked: Asked, program: WeldProgram, name: str) -> list[Motion]:
    """Sweep every motion against the part; return those of templates that were followed and are free."""
    if program.planned is not None or program.part_glb is None:
        return []
    added = [motion for motion in found.others if _is_near(motion, trace, asked)]
    strange = {id(motion) for motion in found.others}.difference(map(id, added))
    part = part_in_base(program.part_glb, program.T_base_part)
    torch = TorchAtTool(program.shape, program.torch.tool_axis, program.torch.standoff_mm)
    start = max((start_mm(path.seam) for path in program.paths), default=START_MM)
    more = dict(enumerate((path.seam.more_wire_mm for path in program.paths), 1))
    motions = [motion for motion in trace.motions if id(motion) not in strange]
    own = [more.get(motion.seam, 0.0) for motion in motions]
    for meeting in meetings(motions, part, torch, own, start_mm=start):
        raise _wrong(name, meeting.motion.place, meeting.what)
    return added


def _refuse_wrong_arcs(trace: Trace, program: WeldProgram, name: str) -> None:
    """Refuse a program whose arc is on or off in the wrong place, unless templates switch it in their own words."""
    kinds = {each.does for each in trace.events} & ALL_SWITCHES
    if program.arc is not None and program.controller.templates is not None and 0 < len(kinds) < len(ALL_SWITCHES):
        return
    for place, what in arc_faults(trace):
        raise _wrong(name, place, what)


def _unjudged_arcs(trace: Trace, program: WeldProgram, name: str) -> Iterator[str]:
    """Say where templates switch the arc in their own words."""
    folder = program.controller.templates
    if folder is None or not blocks_of(name):
        return
    if program.arc is None:
        if own := own_arc_templates(name, folder):
            yield f"whether {' and '.join(own)} switch the arc in this dry run"
        return
    found = Counter(each.does for each in trace.events)
    if found[Does.START] != len(program.paths) or found[Does.END] != len(program.paths):
        yield f"where the arc burns: {folder / name} leaves out the comments {' and '.join(SEAM_MARKS)}"
    elif unknown := [what for what, does in (("starts", Does.ON), ("ends", Does.OFF)) if not found[does]]:
        yield f"where the arc burns: no instruction that wpcal knows {' or '.join(unknown)} it in {folder / name}"


def _told(lines: Mapping[tuple[str, int], str]) -> Iterator[str]:
    """Yield one sentence for each text, with the first places."""
    places: dict[tuple[str, str], list[int]] = {}
    for (file, number), text in lines.items():
        places.setdefault((file, text), []).append(number)
    for (file, text), numbers in places.items():
        more = f" and {len(numbers) - MOST_PLACES} more" if len(numbers) > MOST_PLACES else ""
        where = f"line{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers[:MOST_PLACES]))}{more}"
        yield f"{file}, {where}: {text[:80]!r}"
