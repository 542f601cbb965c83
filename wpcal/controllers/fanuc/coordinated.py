"""FANUC TP for two robots in coordinated motion: one program for two groups, every move with ``COORD``.

Group 1 is the follower with the torch, group 2 the leader with the part. With ``COORD`` the follower moves on its line
relative to the leader, and the speed is that in the part. A position holds both groups, each in the base of its robot;
the tool of group 2 is the part. TP moves both groups in the same way, so the moves are lines only.

References
----------
FANUC, Coordinated Motion Setup and Operations Manual (leader, follower, COORD), as quoted in public by Lincoln
Electric. The layout follows ``EXAMPLE_COOR.LS`` and the coordinated example of
rpiRobotics/fanuc_motion_program_exec: two robots, leader group 2, ``DEFAULT_GROUP = 1,1,*,*,*``, joint moves without
COORD.
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.fanuc.arc import end_lines, start_lines
from wpcal.controllers.fanuc.configuration import ONE_TURN_DEG, config
from wpcal.controllers.fanuc.write import (
    DECIMALS,
    JOINT_PERCENT,
    LONGEST_REMARK,
    NAMES,
    TWO_GROUPS,
    ZONE_MM,
    coordinates,
    tp_file,
    tp_speed,
)
from wpcal.controllers.language.naming import comment_lines, safe_name
from wpcal.controllers.language.rounding import rounded_frame, zyx_degrees
from wpcal.controllers.program.coordinated_program import CoordinatedProgram
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError

HOLDER_TOOL = 1
"""Of group 2: the part on the flange."""


def write_coordinated_fanuc(program: CoordinatedProgram) -> dict[str, str]:
    """Write a TP program of two groups. ``NAME.ls``, with lines ended by CR LF.

    Parameters
    ----------
    program : With lines only.

    Raises
    ------
    InputError : When TP cannot write the speed, the weld data or a CONFIG, or the program is too long.
    """
    name = safe_name(program.controller.program_name, NAMES).upper()
    lines = [*_remarks(program), *_frames(program), *_moves(program)]
    return {f"{name.lower()}.ls": tp_file(name, lines, _positions(program), groups=TWO_GROUPS)}


def _remarks(program: CoordinatedProgram) -> list[str]:
    held = rounded_frame(program.cell.T_flange2_part, mm_decimals=DECIMALS, deg_decimals=DECIMALS)
    numbers = [*held.t_mm.tolist(), *zyx_degrees(held.R, decimals=DECIMALS).tolist()]
    text = [
        *program.notes,
        "group 1: torch, follower; group 2: part, leader; positions in the base of each robot",
        f"set UTOOL {HOLDER_TOOL} of group 2 to the part on the flange:",
        *(f" {key} {value:.{DECIMALS}f}" for key, value in zip("XYZWPR", numbers, strict=True)),
    ]
    clean = [line.replace(";", ",") for line in text]  # a semicolon ends an instruction
    return comment_lines(clean, mark="  !", longest=LONGEST_REMARK)


def _frames(program: CoordinatedProgram) -> list[str]:
    return [
        "  UFRAME_NUM[GP1]=0",
        "  UFRAME_NUM[GP2]=0",
        f"  UTOOL_NUM[GP1]={program.controller.tool_number}",
        f"  UTOOL_NUM[GP2]={HOLDER_TOOL}",
    ]


def _moves(program: CoordinatedProgram) -> list[str]:
    start, *others = program.steps(ZONE_MM)
    air, weld = _speed(program.air_speed_mm_s), _speed(program.speed_mm_s)
    lines = [f"J P[1] {JOINT_PERCENT}% FINE", f"L P[{start.to + 1}] {air} FINE COORD", f"  !{program.marks[0]}"]
    lines += start_lines(program.path, program.speed_mm_s) if program.arc is not None else []
    lines += [
        f"L P[{step.to + 1}] {weld} {'FINE' if step.stops else 'CNT100'} COORD" for step in others if step.on_seam
    ]
    lines += end_lines(program.path) if program.arc is not None else []
    lines.append(f"  !{program.marks[1]}")
    return [*lines, *(f"L P[{step.to + 1}] {air} FINE COORD" for step in others if not step.on_seam)]


def _speed(mm_s: float) -> str:
    """Write a speed, rounded down to whole cm/min: no joint has to be faster than planned."""
    return tp_speed(float(np.floor(mm_s * 6.0 + 1e-6)) / 6.0)


def _positions(program: CoordinatedProgram) -> list[str]:
    one, two = program.postures
    for robot, own in ((1, one), (2, two)):
        if np.abs(own.degrees[:, [0, 3, 4, 5]]).max() > ONE_TURN_DEG:
            raise InputError(
                f"robot {robot} turns joint 1, 4, 5 or 6 beyond {ONE_TURN_DEG:g} deg, where the turn numbers of CONFIG "
                "are not known"
            )
    groups = (
        (1, program.controller.tool_number, program.tool_in_base1(), config(one)),
        (2, HOLDER_TOOL, program.part_in_base2(), config(two)),
    )
    blocks = [_group(number, tool, T, confs) for number, tool, T, confs in groups]
    return [
        line
        for number, both in enumerate(zip(*blocks, strict=True), 1)
        for line in (f"P[{number}]{{", *both[0], *both[1], "};")
    ]


def _group(number: int, tool: int, T: FloatArray, confs: list[str]) -> list[list[str]]:
    texts = coordinates(T[:, :3, 3], zyx_degrees(T[:, :3, :3], decimals=DECIMALS))
    return [
        [f"   GP{number}:", f"\tUF : 0, UT : {tool},\t\tCONFIG : '{conf}',", *text]
        for conf, text in zip(confs, texts, strict=True)
    ]
