"""The judge of written programs, as tests ask it."""

from collections.abc import Mapping
from pathlib import Path

from wpcal.controllers.audit.programs import Surroundings, arc_faults_of, executed
from wpcal.controllers.judge.written import Written, write_judged
from wpcal.controllers.program import WeldProgram
from wpcal.controllers.program.touch_program import TouchProgram
from wpcal.controllers.registry import controller_of_program


def judged(files: Mapping[str, str | bytes], program: WeldProgram | TouchProgram, name: str) -> Written:
    """Judge files as if a program had just been written so."""
    return write_judged(name, lambda _: files, program)


def arc_faults(raw: bytes, path: Path, output: int | None = None) -> list[str]:
    """What is wrong with the arc in one file; those of its language beside it are loaded as well."""
    controller = controller_of_program(path)
    if controller is None:
        return []
    beside = path.parent.iterdir() if path.parent.is_dir() else ()
    files = {one.name: one.read_bytes() for one in beside if one.suffix.lower() in controller.program_suffixes}
    trace, _ = executed({**files, path.name: raw}, Surroundings(arc_output=output))
    return [fault.message for _, fault in arc_faults_of(trace)]
