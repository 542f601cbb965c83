"""FANUC TP as ASCII (``.ls``): one program per seam and one that calls them all.

W, P, R in degrees with ``R = Rz(R) Ry(P) Rx(W)``; lengths in mm. `wpcal.controllers.language.jobs` explains the user
frame and the configuration.

References
----------
FANUC, R-30iB HandlingTool Operator's Manual (position data, user frames, remarks of 32 characters).
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from functools import partial

from wpcal.controllers.fanuc.arc import end_lines, start_lines
from wpcal.controllers.fanuc.configuration import config
from wpcal.controllers.language.jobs import ConfigurationRule, JobLanguage, write_jobs
from wpcal.controllers.language.naming import NameRules, comment_lines
from wpcal.controllers.language.post import Post
from wpcal.controllers.language.rounding import rounded, zyx_degrees
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe_path
from wpcal.controllers.program.planned import PlannedMoves, angle_texts
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.moves import Arc

NAMES = NameRules("FANUC", 32, "aux com1 com2 con lpt1 lpt2 nul prn")
"""Names of programs have up to 36 characters. A file must not have the name of a device of the controller."""
DECIMALS = 3
"""As the controller prints mm and degrees."""
LONGEST_REMARK = 32
MOST_LINES = 9999
"""Line numbers have four digits."""
CONFIGURATION = ConfigurationRule(
    format_name="fanuc",
    word="CONFIG",
    pattern=re.compile(r"[NF] ?[LR]? ?[UD] ?[TB], ?-?\d+, ?-?\d+, ?-?\d+"),
    expected="it as the pendant shows it, as N U T, 0, 0, 0",
    example="N U T, 0, 0, 0",
    compute=config,
)
"""For example N U T, 0, 0, 0: flip, (left, right,) up, front, and the turns of three joints."""
ZONE_MM = 1.0
"""About how far from a corner CNT100 leaves the path at a weld speed: the way that it brakes in."""
ONE_GROUP, TWO_GROUPS = "1,*,*,*,*", "1,1,*,*,*"
"""Which groups a program moves."""
JOINT_PERCENT = 10
"""Of the first move to a seam. Slow, because the arm can come from anywhere."""
LANGUAGE = JobLanguage(
    names=NAMES,
    suffix=".ls",
    job_word="program",
    mm_decimals=DECIMALS,
    deg_decimals=DECIMALS,
    frame_word="UFRAME",
    frame_keys=("X", "Y", "Z", "W", "P", "R"),
    rotation="R = Rz(R) Ry(P) Rx(W)",
    configuration=CONFIGURATION,
    coordinated="COORD: set up coordinated motion, group 2 leads",
)


def write_fanuc(program: WeldProgram) -> dict[str, str]:
    """Write TP programs. ``NAME.ls`` and one file per seam, with lines ended by CR LF.

    Raises
    ------
    InputError
        When a seam has too many points, TP cannot write a speed, or the configuration is missing or not a CONFIG. In a
        plan, when the arm's file does not say how J3 counts.
    """
    if program.planned is not None and program.arm is not None and not program.arm.couplings:
        raise InputError(
            "FANUC shows J3 against the horizontal: the arm's file needs a coupling of J3 to J2 with factor 1 "
            '("couplings"), and limits of J3 as the pendant shows it'
        )
    return write_jobs(
        program, LANGUAGE, main_job=partial(_main_program, program), seam_job=partial(_seam_program, program)
    )


def _main_program(
    program: WeldProgram, name: str, comments: list[str], calls: Sequence[str], T_base_frame: RigidTransform
) -> str:
    post = Post("fanuc", program)
    lines, positions = [f"  CALL {called}" for called in calls], list[str]()
    if program.planned is not None:
        lines, positions = _between(program, program.planned, lines, post)
    if program.safe_point is not None:
        frame = _frame_lines(program)
        first = post.air_move("P[1]", speed=f"{JOINT_PERCENT}%", joint=True)
        last = post.air_move("P[1]", speed=tp_speed(program.motion.air_speed_mm_s))
        lines = [*frame, *first, *lines, *frame, *last]
        positions = _positions(program.safe_point, program, T_base_frame)
    return tp_file(name, [*post.header(wrapped(comments)), *lines, *post.footer()], positions, groups=_groups(program))


def _seam_program(program: WeldProgram, name: str, path: WeldPath, T_base_frame: RigidTransform) -> str:
    return tp_file(name, _moves(path, program), _positions(path, program, T_base_frame), groups=_groups(program))


def _groups(program: WeldProgram) -> str:
    turns = program.planned is not None and program.planned.turning
    return TWO_GROUPS if turns else ONE_GROUP


def tp_file(name: str, instructions: list[str], positions: list[str], *, groups: str = ONE_GROUP) -> str:
    """Return the text of a TP program.

    Parameters
    ----------
    name : Upper case.
    instructions, positions : Lines.
    groups : Which groups the program moves.

    Raises
    ------
    InputError : When it has too many lines.
    """
    if len(instructions) > MOST_LINES:
        raise InputError(f"FANUC: {name} needs {len(instructions)} lines, a program has at most {MOST_LINES}")
    lines = [
        f"/PROG  {name}",
        "/ATTR",
        "OWNER = MNEDITOR;",
        'COMMENT = "wpcal";',
        f"LINE_COUNT = {len(instructions)};",
        "PROTECT = READ_WRITE;",
        "TCD:  STACK_SIZE = 0, TASK_PRIORITY = 50, TIME_SLICE = 0,",
        "      BUSY_LAMP_OFF = 0, ABORT_REQUEST = 0, PAUSE_REQUEST = 0;",
        f"DEFAULT_GROUP = {groups};",
        "CONTROL_CODE = 00000000 00000000;",
        "/MN",
        *(f"{number:4d}:{text} ;" for number, text in enumerate(instructions, start=1)),
        "/POS",
        *positions,
        "/END",
        "",
    ]
    return "\r\n".join(lines)


def wrapped(lines: list[str]) -> list[str]:
    """Return remarks: lines of at most 32 characters without a semicolon."""
    clean = [line.replace(";", ",") for line in lines]  # a semicolon ends an instruction
    return comment_lines(clean, mark="", longest=LONGEST_REMARK)


def _moves(path: WeldPath, program: WeldProgram) -> list[str]:
    post, air = Post("fanuc", program), tp_speed(program.motion.air_speed_mm_s)
    first, last = path.weld_rows.start + 1, path.weld_rows.stop  # positions are counted from 1
    is_joint = program.safe_point is None
    lines = [*(f"  !{line}" for line in wrapped([path.seam.name, describe_path(path)])), *_frame_lines(program)]
    if program.planned is not None:
        lines += post.joint_move("P[1]", speed=f"{program.planned.joint_percent:.0f}%")
    else:
        lines += post.air_move("P[1]", speed=f"{JOINT_PERCENT}%" if is_joint else air, joint=is_joint)
    for number in range(2, first + 1):
        lines += post.air_move(f"P[{number}]", speed=air)
    lines += post.weld_start(path, partial(start_lines, path, program.weld_speed_mm_s(path)))
    lines += _weld_moves(path, first, _weld_speed(path, program))
    lines += post.weld_end(path, partial(end_lines, path))
    for number in range(last + 1, len(path) + 1):
        lines += post.air_move(f"P[{number}]", speed=air)
    return lines


def _weld_moves(path: WeldPath, first: int, speed: str) -> list[str]:
    lines = []
    for move, stop in zip(path.weld_moves, path.stops(ZONE_MM), strict=True):
        end = f"P[{first + move.to}] {speed} {'FINE' if stop else 'CNT100'}{' COORD' if path.turns_along else ''}"
        # the end of a circular move is on a line of its own, without a number
        lines.append(f"C P[{first + move.via}]\r\n    :  {end}" if isinstance(move, Arc) else f"L {end}")
    return lines


def _weld_speed(path: WeldPath, program: WeldProgram) -> str:
    """Write the speed along a seam. That of weld data is rounded to whole cm/min: a rule does not know TP."""
    mm_s = program.weld_speed_mm_s(path)
    if path.speed_mm_s is not None:
        return tp_speed(max(math.floor(mm_s * 6.0 + 1e-6), 1) / 6.0)  # no joint has to be faster than planned
    return tp_speed(mm_s if path.run is None else max(round(mm_s * 6.0), 1) / 6.0)


def _frame_lines(program: WeldProgram) -> list[str]:
    return [f"  UFRAME_NUM={program.controller.frame_number}", f"  UTOOL_NUM={program.controller.tool_number}"]


def tp_speed(mm_s: float) -> str:
    """Write a speed; TP has whole mm/sec and whole cm/min."""
    for value, unit in ((mm_s, "mm/sec"), (mm_s * 6.0, "cm/min")):
        if value >= 1 and abs(value - round(value)) < 1e-6:  # a rest below that is round-off of the factor 6
            return f"{round(value)}{unit}"
    nearest = max(round(mm_s * 6.0), 1) / 6.0
    raise InputError(f"FANUC: {mm_s:g} mm/s is neither whole mm/s nor whole cm/min; the nearest is {nearest:.4g} mm/s")


def _positions(poses: WeldPath | SafePoint, program: WeldProgram, T_base_frame: RigidTransform) -> list[str]:
    p, R = poses.poses_in(T_base_frame)
    texts = zip(CONFIGURATION.texts(program, poses), coordinates(p, zyx_degrees(R, decimals=DECIMALS)), strict=True)
    bodies: list[tuple[str, ...]] = [(f"{_head(program)}\t\tCONFIG : '{conf}',", *text) for conf, text in texts]
    if program.planned is None or not isinstance(poses, WeldPath) or poses.joints is None or poses.external is None:
        return numbered(bodies)
    outer = program.planned.external_texts(poses.external, DECIMALS)
    first = slice(0, poses.before)  # a plan goes to joints before a seam
    bodies[first] = joint_bodies(_head(program), poses.joints[first])
    return numbered([_with_axes(program, *each) for each in zip(bodies, outer, strict=True)])


def _head(program: WeldProgram) -> str:
    return f"\tUF : {program.controller.frame_number}, UT : {program.controller.tool_number},"


def numbered(bodies: Sequence[Sequence[str]]) -> list[str]:
    """Return the section of positions, P[1] first, from the lines of each."""
    return [line for number, body in enumerate(bodies, start=1) for line in (f"P[{number}]{{", "   GP1:", *body, "};")]


def joint_bodies(head: str, joints: FloatArray) -> list[tuple[str, ...]]:
    """Return the lines of positions that are joints; `head` names frame and tool, joints have shape (n, 6), rad."""
    texts = [
        [f"\tJ{number}= {v} deg" for number, v in enumerate(row, start=1)] for row in angle_texts(joints, DECIMALS)
    ]
    return [(head, f"{','.join(row[:3])},", ",".join(row[3:])) for row in texts]


def _with_axes(program: WeldProgram, body: tuple[str, ...], axes: list[str]) -> tuple[str, ...]:
    """Add the external axes: a rail is the extended axis E1 of the arm's group, a positioner is group 2."""
    planned = program.planned
    if planned is not None and planned.rail is not None:
        body = (*body[:-1], f"{body[-1]},", f"\tE1= {axes[0]}  mm")
        axes = axes[1:]
    if not axes:
        return body
    turned = ",".join(f"\tJ{number}= {value} deg" for number, value in enumerate(axes, start=1))
    return (*body, "   GP2:", _head(program), turned)


def _between(
    program: WeldProgram, planned: PlannedMoves, calls: Sequence[str], post: Post
) -> tuple[list[str], list[str]]:
    """Return the joint moves of a plan with the calls of the seams between them, and the positions of these moves.

    The last move before a seam is in the program of the seam.
    """
    lines, bodies = _frame_lines(program), list[tuple[str, ...]]()
    for row, moves in enumerate(planned.air):
        own = moves if row == len(calls) else moves.rows(0, -1)
        outer = planned.external_texts(own.external, DECIMALS)
        for body, axes in zip(joint_bodies(_head(program), own.joints), outer, strict=True):
            bodies.append(_with_axes(program, body, axes))
            lines += post.joint_move(f"P[{len(bodies)}]", speed=f"{planned.joint_percent:.0f}%")
        lines += calls[row : row + 1]
    return lines, numbered(bodies)


def coordinates(p: FloatArray, angles: FloatArray) -> list[tuple[str, str]]:
    """Return the two lines of every pose.

    Parameters
    ----------
    p : shape (n, 3). In any one frame, mm.
    angles : shape (n, 3). About x, y and z, deg.
    """
    k = DECIMALS
    return [
        (
            f"\tX = {x:9.{k}f}  mm,\tY = {y:9.{k}f}  mm,\tZ = {z:9.{k}f}  mm,",
            f"\tW = {a:9.{k}f} deg,\tP = {b:9.{k}f} deg,\tR = {c:9.{k}f} deg",
        )
        for (x, y, z), (a, b, c) in zip(rounded(p, k).tolist(), angles.tolist(), strict=True)
    ]
