"""Yaskawa INFORM for two robots in coordinated motion: one job that moves both, robot 2 the master.

``SMOVL`` and ``SMOVC`` move the torch on a line or an arc relative to robot 2, and ``+MOVJ`` on the same line moves
robot 2 by joints. Group 1 of the job is the torch, group 2 the master. Positions of both robots are joints, so that
their forms are fixed; ``V`` is the speed of the torch in the part.

References
----------
Yaskawa, DX200 Options: Instructions for Independent/Coordinated Control Function (SMOVL, SMOVC, master and slave). The
layout of a job of two groups, and ``SMOVL C… V=…  +MOVJ EC…``, follow the public jobs of
rpiRobotics/dx200_motion_progam_exec; there the master is a station.
"""

from __future__ import annotations

import math

from wpcal.controllers.language.naming import comment_lines, safe_name
from wpcal.controllers.program.coordinated_program import CoordinatedProgram, CoordinatedStep
from wpcal.controllers.yaskawa.arc import end_lines, start_lines
from wpcal.controllers.yaskawa.sync import joint_kind, joint_rows
from wpcal.controllers.yaskawa.write import JOINT_PERCENT, LONGEST_COMMENT, NAMES, ZONE_MM, inform_job
from wpcal.core.errors import InputError

ROUND_OFF = 1e-9
"""Of a speed that is a multiple of 0.1 mm/s."""
HOLDER_TOOL = 0
"""The tool of robot 2: its targets are joints, so the tool does not change where the arm goes."""


def write_coordinated_inform(program: CoordinatedProgram) -> dict[str, str]:
    """Write one INFORM job that moves both robots. ``NAME.jbi``, with lines ended by CR LF.

    Raises
    ------
    InputError : When INFORM cannot write the speed or the weld data, or the job would be too long.
    """
    name = safe_name(program.controller.program_name, NAMES).upper()
    head = comment_lines(
        [*program.notes, "RB1 has the torch, RB2 the part: calibrate both robots to each other"],
        mark="'",
        longest=LONGEST_COMMENT,
    )
    job = inform_job(name, _positions(program), [*head, *_moves(program)], group="RB1", station="RB2")
    return {f"{name}.jbi": job}


def _positions(program: CoordinatedProgram) -> list[str]:
    """Return the positions of both robots: even numbers are those of robot 1, odd ones those of robot 2."""
    cell = program.cell
    kind = joint_kind(cell.arm1, cell.arm2)
    rows = (joint_rows(cell.arm1, program.joints1, kind), joint_rows(cell.arm2, program.joints2, kind))
    lines = [f"///TOOL {program.controller.tool_number}", f"///POSTYPE {kind}", f"///{kind}"]
    for number, (one, two) in enumerate(zip(*rows, strict=True)):
        lines += [f"///TOOL {program.controller.tool_number}"] if number else []
        lines += [f"C{2 * number:05d}={one}", f"///TOOL {HOLDER_TOOL}", f"C{2 * number + 1:05d}={two}"]
    return lines


def _moves(program: CoordinatedProgram) -> list[str]:
    start, *others = program.steps(ZONE_MM)
    air, weld = _speed(program.air_speed_mm_s), _speed(program.speed_mm_s)
    joint = f"VJ={JOINT_PERCENT:.2f}"
    lines = [f"MOVJ C00000 {joint}  +MOVJ C00001 {joint}", _line("SMOVL", start.to, air, stops=True)]
    lines.append(f"'{program.marks[0]}")
    lines += start_lines(program.path) if program.arc is not None else []
    at, follows_arc = start.to, False
    for step in (one for one in others if one.on_seam):
        lines += _weld_move(step, at, weld, follows_arc=follows_arc)
        at, follows_arc = step.to, step.via is not None
    lines += end_lines(program.path) if program.arc is not None else []
    lines.append(f"'{program.marks[1]}")
    return [*lines, *(_line("SMOVL", step.to, air, stops=True) for step in others if not step.on_seam)]


def _weld_move(step: CoordinatedStep, at: int, speed: str, *, follows_arc: bool) -> list[str]:
    """Return a move along the seam; arcs as in programs of one robot (`wpcal.controllers.yaskawa.write`)."""
    if step.via is None:
        return [_line("SMOVL", step.to, speed, stops=step.stops)]
    between = [_line("SMOVL", at, speed)] if follows_arc else []
    arc = [_line("SMOVC", row, speed) for row in (at, step.via)]
    return [*between, *arc, _line("SMOVC", step.to, speed, stops=step.stops)]


def _line(word: str, row: int, speed: str, *, stops: bool = False) -> str:
    return f"{word} C{2 * row:05d} {speed}{' PL=0' if stops else ''}  +MOVJ C{2 * row + 1:05d}"


def _speed(mm_s: float) -> str:
    """Write a speed, rounded down to 0.1 mm/s: no joint has to be faster than planned."""
    tenths = math.floor(10.0 * mm_s + ROUND_OFF)
    if tenths < 1:
        raise InputError(f"INFORM: {mm_s:g} mm/s is less than 0.1 mm/s")
    return f"V={tenths / 10.0:.1f}"
