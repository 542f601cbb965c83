"""Judge files before they are written: they do what was asked; what templates add is followed, or named."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.brep.rays import START_MM
from wpcal.controllers.judge.asked import Asked, Compared, asked_of, compare
from wpcal.controllers.judge.execute import execute, is_executed, text_at
from wpcal.controllers.judge.swept import is_followed, meetings
from wpcal.controllers.program import WeldProgram
from wpcal.controllers.run.machine import Place
from wpcal.controllers.run.trace import Motion, Trace
from wpcal.core.errors import WpcalError
from wpcal.seam.judge.stations import start_mm

ROOM_MM = 1.0  #: A motion that was not asked for may leave the box of those that were by this.

Files = Mapping[str, str | bytes]


class WrittenWrongError(WpcalError):
    """A program that was written does other things than it should: a fault of wpcal."""

    exit_code = 70


def programs_of(files: Files) -> dict[str, str | bytes]:
    """Return the files whose language can be executed."""
    return {name: data for name, data in files.items() if is_executed(Path(name))}


def run_written(files: Files, program: WeldProgram, *, name: str) -> Trace:
    """Execute the files of a program; `WrittenWrongError` when one cannot be read."""
    output, arm = None if program.arc is None else program.arc.output, program.arm
    try:
        return execute(
            programs_of(files),
            tools=(program.controller.tool_name, program.controller.tool_number),
            arc_output=output,
            from_pulses=None if arm is None else lambda pulses: np.degrees(arm.angles_from_pulses(pulses)),
        )
    except WpcalError as error:
        what = f"{name}: the written program cannot be read back: {error}; nothing is written"
        raise WrittenWrongError(what) from None


def require_as_asked(files: Files, program: WeldProgram, *, name: str) -> int:
    """Return to how many places files lead; refuse those that lead elsewhere, or that cannot be followed."""
    trace, asked = run_written(files, program, name=name), asked_of(program)
    found = compare(trace, asked)
    for unknown in trace.unknowns:
        raise _wrong(name, unknown.place, unknown.text)
    if found.others:
        raise _wrong(name, found.others[0].place, _elsewhere(found.others[0]))
    if found.missing:
        raise WrittenWrongError(f"{name}: {_missing(asked, found)}; nothing is written")
    for motion in found.blended:
        raise _wrong(name, motion.place, "does not stop where it should")
    return len(asked.p)


def _wrong(name: str, place: Place, what: str) -> WrittenWrongError:
    return WrittenWrongError(f"{name}: {place.file}, line {place.line}: {what}; nothing is written")


def _elsewhere(motion: Motion) -> str:
    if motion.goal is None:
        return "a move to joints was not asked for"
    x, y, z = motion.goal[:3, 3]
    return f"the pose at base {x:.3f}, {y:.3f}, {z:.3f} mm was not asked for, but is in the written program, read back"


def _missing(asked: Asked, found: Compared) -> str:
    row = found.missing[0]
    x, y, z = asked.p[row]
    what = "a move to joints" if np.isnan(x) else f"the pose at base {x:.3f}, {y:.3f}, {z:.3f} mm"
    return f"{what} is missing in the written program, read back"


def not_followed(files: Files, program: WeldProgram, *, name: str) -> list[tuple[str, int, str]] | None:
    """Return what templates of the user add and nobody followed: file, line and text; None if they leave moves out.

    Raises `WrittenWrongError` when the program leads elsewhere, or what was added meets the part.
    """
    trace, asked = run_written(files, program, name=name), asked_of(program)
    found = compare(trace, asked)
    if found.missing and not trace.unknowns:
        if found.others:
            raise _wrong(name, found.others[0].place, _elsewhere(found.others[0]))
        return None
    added = [motion for motion in found.others if _is_near(motion, trace, asked)]
    if program.planned is None and program.part_glb is not None and added:
        _require_free(added, program, name)
    else:
        added = []
    places = [each.place for each in trace.unknowns]
    places += [motion.place for motion in (*found.blended, *found.others) if motion not in added]
    return [(place.file, place.line, text_at(place, files)) for place in dict.fromkeys(places)]


def _is_near(motion: Motion, trace: Trace, asked: Asked) -> bool:
    """Tell whether a motion is followed, stops, has the tool of the others, and stays between what was asked."""
    tool, _ = Counter(each.place.tool for each in trace.motions).most_common(1)[0]
    if not is_followed(motion) or motion.place.blends or motion.place.tool != tool or motion.goal is None:
        return False
    beyond = np.maximum(
        np.nanmin(asked.p, axis=0) - motion.goal[:3, 3], motion.goal[:3, 3] - np.nanmax(asked.p, axis=0)
    )
    return bool(beyond.max() <= ROOM_MM)


def _require_free(added: Sequence[Motion], program: WeldProgram, name: str) -> None:
    part = TriangleMaterial.of(read_part_glb(program.part_glb or b""), program.T_base_part)
    torch, start = program.torch, max((start_mm(path.seam) for path in program.paths), default=START_MM)
    found = meetings(added, part, program.shape, torch.tool_axis, standoff_mm=torch.standoff_mm, start_mm=start)
    for meeting in found:
        raise _wrong(name, meeting.motion.place, meeting.what)
