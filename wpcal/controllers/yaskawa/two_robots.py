"""Yaskawa INFORM for two robots of one controller, in step or in coordinated motion.

In step there is one job per robot, and one that starts both (``PSTART``). Both run at the same time and wait for each
other at every mark (``TSYNC`` with ``SNUM=2``). Targets are joint values: encoder pulses if the arm's file states the
pulses per degree, otherwise degrees (``///POSTYPE ANGLE``, which newer controllers read). A joint move has no time but
a speed ``VJ``, a percentage of the largest joint speed. It is chosen so that the move takes the planned time, and
rounded to the decimals of the language.

In coordinated motion one job moves both robots, robot 2 the master. ``SMOVL`` and ``SMOVC`` move the torch on a line or
an arc relative to robot 2, and ``+MOVJ`` on the same line moves robot 2 by joints. Group 1 of the job is the torch,
group 2 the master. Positions of both robots are joints, so that their forms are fixed; ``V`` is the speed of the torch
in the part.

References: Yaskawa, DX200 / YRC1000 Options: Instructions for Independent/Coordinated Control Function (PSTART, PWAIT,
TSYNC, SMOVL, SMOVC, master and slave) and for Data Transmission Function (job data format: NPOS, POSTYPE, PULSE). The
layout of a job of two groups, and ``SMOVL C… V=…  +MOVJ EC…``, follow the public jobs of
rpiRobotics/dx200_motion_progam_exec; there the master is a station.
"""

from __future__ import annotations

import math

import numpy as np

from wpcal.controllers.language.naming import comment_lines, safe_name, safe_names
from wpcal.controllers.language.rounding import rounded
from wpcal.controllers.program.coordinated_program import ROBOTS, CoordinatedProgram, CoordinatedStep, SyncProgram
from wpcal.controllers.yaskawa.arc import inform_arc_off, inform_arc_on
from wpcal.controllers.yaskawa.write import (
    FIRST,
    FLOWS,
    JOINT_PERCENT,
    LONGEST_COMMENT,
    NAMES,
    STOPS,
    ZONE_MM,
    inform_job,
    joint_kind,
    joint_positions,
    joint_rows,
)
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError

PERCENT_DECIMALS = 2
LEAST_PERCENT = 0.01  #: The language has VJ from 0.01 to 100.00.
ROUND_OFF = 1e-9  #: A number this little above one that can be written is that one.
SYNC_NUMBERS = 8
"""TSYNC has few numbers. Neither job can be more than one mark ahead, so eight numbers in turn cannot be confused."""
HOLDER_TOOL = 0  #: The tool of robot 2: its targets are joints, so the tool does not change where the arm goes.


def write_sync_inform(program: SyncProgram) -> dict[str, str]:
    """Write one INFORM job per robot, and one that starts both: ``NAME.jbi``, ``NAME_R1.jbi`` and ``NAME_R2.jbi``.

    Raises `InputError` when an arm does not state the largest speeds of its joints, a move needs more than these, or a
    job would be too long.
    """
    name = program.controller.program_name
    main = safe_names([name], NAMES, room=len("_R1"))[name].upper()
    jobs = {robot: f"{main}_R{robot}" for robot in ROBOTS}
    start = [f"PSTART JOB:{job} SUB{robot}" for robot, job in jobs.items()]
    wait = [f"PWAIT SUB{robot}" for robot in ROBOTS]
    head = _comments([*program.notes, f"seam {program.seam}", _timing_note(program)])
    files = {f"{main}.jbi": inform_job(main, [], [*head, *start, *wait], group=None)}
    for robot, job in jobs.items():
        arm, kind = program.arms[robot - 1], joint_kind(program.arms[robot - 1])
        tool = program.controller.tool_number if robot == 1 else HOLDER_TOOL
        positions = joint_positions(tool, kind, joint_rows(program.joints[robot - 1], arm, kind))
        files[f"{job}.jbi"] = inform_job(job, positions, _steps(program, robot), group=f"RB{robot}")
    return files


def _comments(lines: list[str]) -> list[str]:
    return comment_lines(lines, mark="'", longest=LONGEST_COMMENT)


def _steps(program: SyncProgram, robot: int) -> list[str]:
    together = ["targets are joints; both jobs wait", "for each other at each mark"]
    lines = _comments([f"robot {robot} of two", f"seam {program.seam}", *together])
    percents = [JOINT_PERCENT, *joint_percents(program)[robot - 1]]
    for row, (mark, percent) in enumerate(zip(program.marks, percents, strict=True)):
        move = f"MOVJ C{row:05d} VJ={percent:.{PERCENT_DECIMALS}f}{STOPS}"
        lines += [move, f"'MARK {mark}", f"TSYNC {row % SYNC_NUMBERS + 1} SNUM=2"]
        lines += ["'ARC ON"] if row == program.arc_on else []
        lines += ["'ARC OFF"] if row == program.arc_off else []
    return lines


def joint_percents(program: SyncProgram) -> FloatArray:
    r"""Return ``VJ`` of every move of both robots: percentages of the largest joint speeds that give the planned times.

    :math:`100 \max_j |\Delta q_j| / (\dot q_{j,max} \Delta t)`, rounded for the robot with the larger percentage and
    rounded up for the other. The other robot arrives early and waits, so its rounding does not slow the step.

    Returns shape (2, N - 1). Percent.
    Raises `InputError` when an arm does not state the speeds of its joints, or a percentage is more than 100.
    """
    share = _shares(program)
    decides = share == share.max(axis=0)
    unit = 10.0**-PERCENT_DECIMALS
    percents = np.where(decides, rounded(share, PERCENT_DECIMALS), unit * np.ceil(share / unit - ROUND_OFF))
    if percents.max() > 100.0:
        robot, row = np.unravel_index(int(np.argmax(share)), share.shape)
        raise InputError(
            f"INFORM: robot {ROBOTS[robot]} would need {share[robot, row]:.0f} % of its joint speed to mark {row + 2}"
        )
    return np.asarray(np.maximum(percents, LEAST_PERCENT), dtype=np.float64)


def _shares(program: SyncProgram) -> FloatArray:
    """Return 100 max |Δq| / (largest speed · Δt) of every move, shape (2, N - 1)."""
    shares = []
    for robot, arm, joints in zip(ROBOTS, program.arms, program.joints, strict=True):
        missing = [joint.name for joint in arm.joints if joint.speed_rad_s is None]
        if missing:
            names = ", ".join(missing)
            raise InputError(f"INFORM: {arm.name} (robot {robot}) does not state the speed of joint {names}")
        most = np.array([joint.speed_rad_s for joint in arm.joints], dtype=np.float64)
        shares.append(100.0 * (np.abs(np.diff(joints, axis=0)) / most).max(axis=1) / program.seconds)
    return np.array(shares)


def _timing_note(program: SyncProgram) -> str:
    """Say how much the rounding of VJ changes the times between the marks of the weld."""
    taken = 100.0 * (_shares(program) / joint_percents(program)).max(axis=0)[program.arc_on : program.arc_off]
    times = f"a step of the weld takes {taken.min():.1f} to {taken.max():.1f} % of its time"
    return f"VJ has {PERCENT_DECIMALS} decimals: {times}"


def write_coordinated_inform(program: CoordinatedProgram) -> dict[str, str]:
    """Write one INFORM job that moves both robots, ``NAME.jbi``.

    Raises `InputError` when INFORM cannot write the speed or the weld data, or the job would be too long.
    """
    name = safe_name(program.controller.program_name, NAMES).upper()
    head = _comments([*program.notes, "RB1 has the torch, RB2 the part: calibrate both robots to each other"])
    job = inform_job(name, _positions(program), [*head, *_moves(program)], group="RB1", station="RB2")
    return {f"{name}.jbi": job}


def _positions(program: CoordinatedProgram) -> list[str]:
    """Return the positions of both robots: even numbers are those of robot 1, odd ones those of robot 2."""
    cell, tool = program.cell, f"///TOOL {program.controller.tool_number}"
    kind = joint_kind(cell.arm, cell.arm2)
    rows = joint_rows(program.joints1, cell.arm, kind), joint_rows(program.joints2, cell.arm2, kind)
    lines = [tool, f"///POSTYPE {kind}", f"///{kind}"]
    for number, (one, two) in enumerate(zip(*rows, strict=True)):
        lines += [tool] if number else []
        lines += [f"C{2 * number:05d}={one}", f"///TOOL {HOLDER_TOOL}", f"C{2 * number + 1:05d}={two}"]
    return lines


def _moves(program: CoordinatedProgram) -> list[str]:
    start, *others = program.steps(ZONE_MM)
    air, weld = _speed(program.air_speed_mm_s), _speed(program.speed_mm_s)
    lines = [f"MOVJ C00000 {FIRST}{STOPS}  +MOVJ C00001 {FIRST}", _line("SMOVL", start.to, air, stops=True)]
    lines.append(f"'{program.marks[0]}")
    lines += inform_arc_on(program.path) if program.arc is not None else []
    before = start
    for step in (one for one in others if one.on_seam):
        lines += _weld_move(step, before, weld)
        before = step
    lines += inform_arc_off(program.path) if program.arc is not None else []
    lines.append(f"'{program.marks[1]}")
    return [*lines, *(_line("SMOVL", step.to, air, stops=True) for step in others if not step.on_seam)]


def _weld_move(step: CoordinatedStep, before: CoordinatedStep, speed: str) -> list[str]:
    """Return a move along the seam; arcs as in programs of one robot (`wpcal.controllers.yaskawa.write`)."""
    if step.via is None:
        return [_line("SMOVL", step.to, speed, stops=step.stops)]
    words = ("SMOVC",) if before.via is None else ("SMOVL", "SMOVC")
    there = [_line(word, before.to, speed, stops=before.stops) for word in words]
    return [*there, _line("SMOVC", step.via, speed), _line("SMOVC", step.to, speed, stops=step.stops)]


def _line(word: str, row: int, speed: str, *, stops: bool = False) -> str:
    return f"{word} C{2 * row:05d} {speed}{STOPS if stops else FLOWS}  +MOVJ C{2 * row + 1:05d}"


def _speed(mm_s: float) -> str:
    """Write a speed, rounded down to 0.1 mm/s: no joint has to be faster than planned."""
    tenths = math.floor(10.0 * mm_s + ROUND_OFF)
    if tenths < 1:
        raise InputError(f"INFORM: {mm_s:g} mm/s is less than 0.1 mm/s")
    return f"V={tenths / 10.0:.1f}"
