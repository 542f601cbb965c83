"""FANUC TP for two robots in coordinated motion: one program for two groups, every move with ``COORD``.

Group 1 is the follower with the torch, group 2 the leader with the part. With ``COORD`` the follower moves on its line
relative to the leader, and the speed is that in the part. A position holds both groups, each in the base of its robot;
the tool of group 2 is the part. TP moves both groups in the same way, so the moves are lines only.

References: FANUC, Coordinated Motion Setup and Operations Manual (leader, follower, COORD), as quoted in public by
Lincoln Electric. The layout follows ``EXAMPLE_COOR.LS`` and the coordinated example of
rpiRobotics/fanuc_motion_program_exec: two robots, leader group 2, ``DEFAULT_GROUP = 1,1,*,*,*``, joint moves without
COORD.
"""

from __future__ import annotations

from wpcal.controllers.fanuc.arc import tp_arc_off, tp_arc_on
from wpcal.controllers.fanuc.configuration import config
from wpcal.controllers.fanuc.write import (
    DECIMALS,
    JOINT_PERCENT,
    LANGUAGE,
    NAMES,
    TWO_GROUPS,
    ZONE_MM,
    pose_bodies,
    remark_lines,
    tp_file,
    tp_speed_down,
)
from wpcal.controllers.language.naming import safe_name
from wpcal.controllers.language.rounding import zyx_degrees
from wpcal.controllers.program.coordinated_program import CoordinatedProgram

HOLDER_TOOL = 1  #: The tool of group 2: the part on the flange.


def write_coordinated_fanuc(program: CoordinatedProgram) -> dict[str, str]:
    """Write a TP program of two groups, ``NAME.ls``, with lines only.

    Raises `InputError` when TP cannot write the speed, the weld data or a CONFIG, or the program is too long.
    """
    name = safe_name(program.controller.program_name, NAMES).upper()
    lines = [*_head(program), *_moves(program)]
    return {f"{name.lower()}.ls": tp_file(name, lines, _positions(program), groups=TWO_GROUPS)}


def _head(program: CoordinatedProgram) -> list[str]:
    held = LANGUAGE.frame_as_written(program.cell.T_part)
    numbers = [*held.t_mm.tolist(), *zyx_degrees(held.R, decimals=DECIMALS).tolist()]
    text = [
        *program.notes,
        "group 1: torch, follower; group 2: part, leader; positions in the base of each robot",
        f"set UTOOL {HOLDER_TOOL} of group 2 to the part on the flange:",
        *(f" {key} {value:.{DECIMALS}f}" for key, value in zip("XYZWPR", numbers, strict=True)),
    ]
    return [
        *remark_lines(text, mark="  !"),
        *("  UFRAME_NUM[GP1]=0", "  UFRAME_NUM[GP2]=0"),
        f"  UTOOL_NUM[GP1]={program.controller.tool_number}",
        f"  UTOOL_NUM[GP2]={HOLDER_TOOL}",
    ]


def _moves(program: CoordinatedProgram) -> list[str]:
    start, *others = program.steps(ZONE_MM)
    air, weld = tp_speed_down(program.air_speed_mm_s), tp_speed_down(program.speed_mm_s)
    lines = [f"J P[1] {JOINT_PERCENT}% FINE", f"L P[{start.to + 1}] {air} FINE COORD", f"  !{program.marks[0]}"]
    lines += tp_arc_on(program.path, program.speed_mm_s) if program.arc is not None else []
    lines += [
        f"L P[{step.to + 1}] {weld} {'FINE' if step.stops else 'CNT100'} COORD" for step in others if step.on_seam
    ]
    lines += tp_arc_off(program.path) if program.arc is not None else []
    lines.append(f"  !{program.marks[1]}")
    return [*lines, *(f"L P[{step.to + 1}] {air} FINE COORD" for step in others if not step.on_seam)]


def _positions(program: CoordinatedProgram) -> list[str]:
    robots = ((program.controller.tool_number, program.tool_in_base1()), (HOLDER_TOOL, program.part_in_base2()))
    one, two = (
        pose_bodies(f"\tUF : 0, UT : {tool},", config(own), T[:, :3, 3], T[:, :3, :3])
        for (tool, T), own in zip(robots, program.postures, strict=True)
    )
    return [
        line
        for number, (first, second) in enumerate(zip(one, two, strict=True), 1)
        for line in (f"P[{number}]{{", "   GP1:", *first, "   GP2:", *second, "};")
    ]
