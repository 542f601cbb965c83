"""Yaskawa INFORM (``.jbi``): a job a seam and one that calls them all.

Rx, Ry, Rz in degrees with ``R = Rz(Rz) Ry(Ry) Rx(Rx)``; lengths in mm. Positions are Cartesian (no pulses), relative to
the user frame that the part becomes. A job cannot carry a user frame: its six numbers stand in comments, rounded as
the pendant takes them, and the positions are relative to exactly these numbers. `RCONF` is what the user gave, or a
question mark that the controller refuses until it is filled in.

References
----------
Yaskawa, DX200 / YRC1000 Options: Instructions for Data Transmission Function (job data format: NPOS, POSTYPE, RCONF).
"""

from __future__ import annotations

import re

from wpcal.controllers.naming import NameRules, comment_lines, safe_name, safe_names
from wpcal.controllers.program import WeldPath, WeldProgram, describe, describe_path
from wpcal.controllers.rounding import rounded, rounded_frame, zyx_degrees
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform

NAMES = NameRules("INFORM", 32)
"""Names of jobs have up to 32 characters."""
MM_DECIMALS = 3
DEG_DECIMALS = 4
"""What the controller writes into its own jobs."""
LONGEST_COMMENT = 32
MOST_LINES = 9999
"""Of a job; the numbers of its positions have as many."""
UNKNOWN_CONFIG = "?"
CONFIG = re.compile(r"\d+(?:,\d+)+")
JOINT_PERCENT = 5.0
"""Of the first move to a seam, which comes from wherever the arm stands: slow."""
NO_DATE = "2000/01/01 00:00"
"""A job must have a date; the same input gives the same bytes."""


def write_inform(program: WeldProgram) -> dict[str, str]:
    """Write INFORM jobs.

    Parameters
    ----------
    program : WeldProgram

    Returns
    -------
    dict of str to str
        ``NAME.jbi`` and a file a seam, with lines ended by CR LF.

    Raises
    ------
    InputError
        When a seam has too many points or the configuration is no RCONF.
    """
    configuration = program.controller.configuration
    if configuration is not None and not CONFIG.fullmatch(configuration):
        raise InputError(f"configuration {configuration!r}: expected numbers with commas, as RCONF of a job has them")
    main = safe_name(program.controller.program_name, NAMES).upper()
    rules = NameRules(NAMES.language, NAMES.longest, main.lower())
    names = {k: v.upper() for k, v in safe_names([path.seam.name for path in program.paths], rules).items()}
    T_base_frame = rounded_frame(program.T_base_part, mm_decimals=MM_DECIMALS, deg_decimals=DEG_DECIMALS)
    calls = [f"CALL JOB:{name}" for name in names.values()]
    files = {f"{main}.jbi": inform_job(main, [], [*_header(program, names, T_base_frame), *calls])}
    for path in program.paths:
        name = names[path.seam.name]
        files[f"{name}.jbi"] = inform_job(name, _positions(path, program, T_base_frame), _moves(path, program))
    return files


def inform_job(name: str, positions: list[str], instructions: list[str], *, group: str | None = "RB1") -> str:
    """Put positions and instructions into the frame of a job.

    Parameters
    ----------
    name : str
        A name that the language takes, upper case.
    positions : list of str
        Lines of the section ``//POS`` after the counts.
    instructions : list of str
        Lines between NOP and END.
    group : str or None
        The robot that the job moves; None for a job that moves none.

    Raises
    ------
    InputError
        When the job has too many lines.
    """
    if len(instructions) + 2 > MOST_LINES:
        raise InputError(f"INFORM: {name} needs {len(instructions) + 2} lines, a job has at most {MOST_LINES}")
    count = sum(line.startswith("C") for line in positions)
    lines = [
        "/JOB",
        f"//NAME {name}",
        "//POS",
        f"///NPOS {count},0,0,0,0,0",
        *positions,
        "//INST",
        f"///DATE {NO_DATE}",
        "///ATTR SC,RW",
        *([] if group is None else [f"///GROUP1 {group}"]),
        "NOP",
        *instructions,
        "END",
        "",
    ]
    return "\r\n".join(lines)


def _header(program: WeldProgram, names: dict[str, str], T_base_frame: RigidTransform) -> list[str]:
    places = [f"{v:.{MM_DECIMALS}f}" for v in T_base_frame.t_mm]
    turns = [f"{v:.{DEG_DECIMALS}f}" for v in zyx_degrees(T_base_frame.R, decimals=DEG_DECIMALS)]
    text = [
        *describe(program),
        f"set USER {program.controller.frame_number} to the part:",
        *(f" {key} {v}" for key, v in zip(("X", "Y", "Z", "Rx", "Ry", "Rz"), places + turns, strict=True)),
        "points are relative to it, mm",
        "R = Rz(Rz) Ry(Ry) Rx(Rx), deg",
        "rounded within 0.001 mm, 0.0001 deg",
        "RCONF as given by the user"
        if program.controller.configuration
        else "RCONF is not known: put the arm's in place of ?",
        "seam -> job here",
        *(f" {path.seam.name} -> {names[path.seam.name]}: {describe_path(path)}" for path in program.paths),
    ]
    return comment_lines(text, mark="'", longest=LONGEST_COMMENT)


def _positions(path: WeldPath, program: WeldProgram, T_base_frame: RigidTransform) -> list[str]:
    p, R = path.poses_in(T_base_frame)
    return [
        f"///USER {program.controller.frame_number}",
        f"///TOOL {program.controller.tool_number}",
        "///POSTYPE USER",
        "///RECTAN",
        f"///RCONF {program.controller.configuration or UNKNOWN_CONFIG}",
        *_coordinates(p, zyx_degrees(R, decimals=DEG_DECIMALS)),
    ]


def _coordinates(p: FloatArray, angles: FloatArray) -> list[str]:
    m, k = MM_DECIMALS, DEG_DECIMALS
    rows = zip(rounded(p, m).tolist(), angles.tolist(), strict=True)
    return [
        f"C{number:05d}={x:.{m}f},{y:.{m}f},{z:.{m}f},{a:.{k}f},{b:.{k}f},{c:.{k}f}"
        for number, ((x, y, z), (a, b, c)) in enumerate(rows)
    ]


def _moves(path: WeldPath, program: WeldProgram) -> list[str]:
    weld, air = _speed(program.motion.speed_mm_s), _speed(program.motion.air_speed_mm_s)
    last = len(path) - 2
    return [
        *comment_lines([path.seam.name, describe_path(path)], mark="'", longest=LONGEST_COMMENT),
        f"MOVJ C00000 VJ={JOINT_PERCENT:.2f}",
        f"MOVL C00001 {air}",
        "'ARC ON",
        *(f"MOVL C{number:05d} {weld}" for number in range(2, last + 1)),
        "'ARC OFF",
        f"MOVL C{last + 1:05d} {air}",
    ]


def _speed(mm_s: float) -> str:
    """Write a speed, which INFORM knows to 0.1 mm/s."""
    if mm_s < 0.1 or abs(mm_s - round(mm_s, 1)) > 1e-9:  # a rest below that is round-off of the decimal
        raise InputError(f"INFORM: {mm_s:g} mm/s is not a multiple of 0.1 mm/s")
    return f"V={mm_s:.1f}"
