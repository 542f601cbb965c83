"""Judge programs of two robots: both have the same marks, every move is one of both robots, and the arc burns.

Beside the plan both arms are swept together in its cell. Elsewhere positions are not compared with the part or with the
reach of an arm: the audit says so.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import starmap
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.controllers.audit.fault import Fault
from wpcal.controllers.audit.off_line import OFF_MM, off_line_faults, planned_line, tools_in_part
from wpcal.controllers.audit.programs import (
    IN_TIME,
    NO_SPEEDS,
    Surroundings,
    arc_faults_of,
    executed,
    require_grammar,
    speed_faults,
    speeds_of,
    unknown_faults,
    untimed,
)
from wpcal.controllers.judge.execute import UNDECLARED, Files, texts_of
from wpcal.controllers.judge.in_step import in_step, is_second
from wpcal.controllers.language.grammar import ENCODING
from wpcal.controllers.run.recorder import Recorder
from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.errors import ErrorCode, WpcalError
from wpcal.core.input_file import read_bytes
from wpcal.core.records import parse_json, read_json
from wpcal.core.result_files import PART_FILE
from wpcal.planning.cell.cell_file import read_cell
from wpcal.planning.plan.run_record import PLAN_SCHEMA
from wpcal.planning.sequence.kept_plan import CELL_FILE, INPUT, PLAN_FILE, require_as_made

CHECKED = "of two robots, or of a robot and its positioner: the same marks in both, moves of both, what they name, arc"
SWEPT = f"of two robots: within {OFF_MM:g} mm of the plan, swept together in its cell, wire and held part included"


def checked_in_words(left: str, *, is_swept: bool) -> str:
    """Say what is compared in programs of two robots, and what is not: beside the rest, which speeds."""
    done = [SWEPT if is_swept else CHECKED, *([] if left == NO_SPEEDS else [IN_TIME])]
    return f"{', '.join(done)}; NOT CHECKED: {left}{'' if is_swept else ', the part, the reach of an arm'}"


def two_robot_faults(files: Files, path: Path, output: int | None) -> tuple[list[Fault], str]:
    """Return the faults of a program of two robots, and which speeds are not compared.

    `files`: It and those beside it. Robot 2 takes the time of the torch, however fast it is.
    """
    grammar, text, own = require_grammar(path), texts_of(files)[path.name], list[Fault]()
    lines = text.splitlines()
    if has_poses := grammar.has_poses(path):
        try:
            grammar.read(text, str(path))
        except WpcalError as error:
            return [Fault.of(error, str(path))], NO_SPEEDS
    if not has_poses or grammar.moves_of is None:
        own += _compared(lines, path, grammar.mark) if grammar.mark else ()
        own += starmap(Fault, grammar.judge_step(lines, path)) if grammar.judge_step else ()
    around, stated = Surroundings(arc_output=output), speeds_of(files)
    trace, unread = executed(files, around, leader=Recorder())
    if path.name in unread:  # a task with a memory of its own
        trace, unread = executed({path.name: files[path.name]}, around)
        own += unread.get(path.name, [])
    found = [*unknown_faults(trace), *arc_faults_of(trace), *(() if is_second(path) else speed_faults(trace, stated))]
    return [*own, *(fault for file, fault in found if file == path.name)], untimed(trace, stated)


def swept_faults(folder: Path, files: Files) -> list[tuple[str, Fault]] | None:
    """Return the files of programs in the folder of a plan, and their faults in its cell; None without such a plan.

    Raises `InputError` when the plan, or what it was made from, was changed.
    """
    path, source = folder / PLAN_FILE, folder / INPUT
    record = parse_json(read_bytes(path), path=str(path)) if path.is_file() else {}
    if record.get("schema") != PLAN_SCHEMA or not record.get("made_from"):
        return None
    record = read_json(path, schema=PLAN_SCHEMA)
    require_as_made(record, folder)
    cell, mesh = read_cell(source / CELL_FILE), source / PART_FILE
    q, is_on_seam = _states(record["points"])
    track = planned_line(record["seam"], cell, q[is_on_seam])
    part = TriangleMaterial.of(read_part_glb(read_bytes(mesh))) if mesh.is_file() else None
    found = in_step(files, cell, q[0], tools=[UNDECLARED], part=part)
    told = [(file, Fault(what, line)) for file, line, what in found.faults]
    for each, what in off_line_faults(tools_in_part(cell, found.legs()), [track]):
        told.append((each.place.file, Fault(f"{found.other(each)}{what}", each.place.line, code=ErrorCode.INPUT)))
    met = ((each.motion.place, each.what) for each in found.meetings())
    return told + [(at.file, Fault(what, at.line, code=ErrorCode.POSE_IN_MATERIAL)) for at, what in met]


def _states(points: Sequence[Mapping[str, Any]]) -> tuple[FloatArray, BoolArray]:
    """Return the joints of both robots at the points of a plan, shape (n, 12), rad, and which are on the seam."""
    q = np.radians([[*each["robot1_deg"], *each["robot2_deg"]] for each in points])
    return q, np.array([each["s_mm"] is not None for each in points])


def _marks_of(lines: list[str], pattern: str) -> list[tuple[str, int]]:
    return [(match[1], number) for number, line in enumerate(lines, 1) for match in re.finditer(pattern, line)]


def _compared(lines: list[str], path: Path, pattern: str) -> Iterator[Fault]:
    """Yield marks that are written twice, and those that the other robot does not have or has in another order."""
    marks = _marks_of(lines, pattern)
    first = dict(reversed(marks))
    for mark, count in Counter(mark for mark, _ in marks).items():
        if count > 1:
            yield Fault(f"mark {mark} is there {count} times", first[mark])
    if (other := _other(path)) is not None:
        yield from _against(other, marks, pattern)


def _against(other: Path, marks: list[tuple[str, int]], pattern: str) -> Iterator[Fault]:
    theirs = [mark for mark, _ in _marks_of(read_bytes(other).decode(ENCODING).splitlines(), pattern)]
    known, own = set(theirs), {mark for mark, _ in marks}
    missing = [(mark, line) for mark, line in marks if mark not in known]
    yield from (Fault(f"mark {mark} is not in {other.name}: this robot would wait", line) for mark, line in missing)
    common = [mark for mark, _ in marks if mark in known]
    if common != [mark for mark in theirs if mark in own]:
        yield Fault(f"the marks are in another order than in {other.name}", marks[0][1])


def _other(path: Path) -> Path | None:
    """Return the program of the other robot, if it is beside."""
    for own, their in (("_R1", "_R2"), ("_R2", "_R1")):
        if path.stem.endswith(own):
            other = path.with_name(f"{path.stem[: -len(own)]}{their}{path.suffix}")
            return other if other.is_file() else None
    return None
