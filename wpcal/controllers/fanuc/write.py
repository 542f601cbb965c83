"""FANUC TP as ASCII (``.ls``): one program per seam and one that calls them all.

W, P, R in degrees with ``R = Rz(R) Ry(P) Rx(W)``; lengths in mm. `wpcal.controllers.user_frame_jobs` explains the user
frame and the configuration.

References
----------
FANUC, R-30iB HandlingTool Operator's Manual (position data, user frames, remarks of 32 characters).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import partial

from wpcal.controllers.describe import describe_path
from wpcal.controllers.fanuc.arc import end_lines, start_lines
from wpcal.controllers.fanuc.configuration import config
from wpcal.controllers.naming import NameRules, comment_lines
from wpcal.controllers.post import Post
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.rounding import rounded, zyx_degrees
from wpcal.controllers.user_frame_jobs import ConfigurationRule, JobLanguage, write_jobs
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.moves import Arc

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
)


def write_fanuc(program: WeldProgram) -> dict[str, str]:
    """Write TP programs.

    Parameters
    ----------
    program : WeldProgram

    Returns
    -------
    dict of str to str
        ``NAME.ls`` and one file per seam, with lines ended by CR LF.

    Raises
    ------
    InputError
        When a seam has too many points, TP cannot write a speed, or the configuration is missing or not a CONFIG.
    """
    return write_jobs(
        program, LANGUAGE, main_job=partial(_main_program, program), seam_job=partial(_seam_program, program)
    )


def _main_program(
    program: WeldProgram, name: str, comments: list[str], calls: Sequence[str], T_base_frame: RigidTransform
) -> str:
    post = Post("fanuc", program)
    lines, positions = [f"  CALL {called}" for called in calls], []
    if program.safe_point is not None:
        frame = _frame_lines(program)
        first = post.air_move("P[1]", speed=f"{JOINT_PERCENT}%", joint=True)
        last = post.air_move("P[1]", speed=tp_speed(program.motion.air_speed_mm_s))
        lines = [*frame, *first, *lines, *frame, *last]
        positions = _positions(program.safe_point, program, T_base_frame)
    return tp_file(name, [*post.header(_wrapped(comments)), *lines, *post.footer()], positions)


def _seam_program(program: WeldProgram, name: str, path: WeldPath, T_base_frame: RigidTransform) -> str:
    return tp_file(name, _moves(path, program), _positions(path, program, T_base_frame))


def tp_file(name: str, instructions: list[str], positions: list[str], *, groups: str = "1,*,*,*,*") -> str:
    """Return the text of a TP program.

    Parameters
    ----------
    name : str
        Upper case.
    instructions, positions : list of str
        Lines.
    groups : str
        Which groups the program moves.

    Raises
    ------
    InputError
        When it has too many lines.
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


def _wrapped(lines: list[str]) -> list[str]:
    clean = [line.replace(";", ",") for line in lines]  # a semicolon ends an instruction
    return comment_lines(clean, mark="", longest=LONGEST_REMARK)


def _moves(path: WeldPath, program: WeldProgram) -> list[str]:
    post, air = Post("fanuc", program), tp_speed(program.motion.air_speed_mm_s)
    first, last = path.weld_rows.start + 1, path.weld_rows.stop  # positions are counted from 1
    is_joint = program.safe_point is None
    lines = [*(f"  !{line}" for line in _wrapped([path.seam.name, describe_path(path)])), *_frame_lines(program)]
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
        end = f"P[{first + move.to}] {speed} {'FINE' if stop else 'CNT100'}"
        # the end of a circular move is on a line of its own, without a number
        lines.append(f"C P[{first + move.via}]\r\n    :  {end}" if isinstance(move, Arc) else f"L {end}")
    return lines


def _weld_speed(path: WeldPath, program: WeldProgram) -> str:
    """Write the speed along a seam. That of weld data is rounded to whole cm/min: a rule does not know TP."""
    mm_s = program.weld_speed_mm_s(path)
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
    controller = program.controller
    p, R = poses.poses_in(T_base_frame)
    head = f"\tUF : {controller.frame_number}, UT : {controller.tool_number},\t\tCONFIG : "
    texts = zip(CONFIGURATION.texts(program, poses), coordinates(p, zyx_degrees(R, decimals=DECIMALS)), strict=True)
    return [
        line
        for number, (conf, text) in enumerate(texts, start=1)
        for line in (f"P[{number}]{{", "   GP1:", f"{head}'{conf}',", *text, "};")
    ]


def coordinates(p: FloatArray, angles: FloatArray) -> list[tuple[str, str]]:
    """Return the two lines of every pose.

    Parameters
    ----------
    p : ndarray, shape (n, 3)
        In any one frame, mm.
    angles : ndarray, shape (n, 3)
        About x, y and z, deg.
    """
    k = DECIMALS
    return [
        (
            f"\tX = {x:9.{k}f}  mm,\tY = {y:9.{k}f}  mm,\tZ = {z:9.{k}f}  mm,",
            f"\tW = {a:9.{k}f} deg,\tP = {b:9.{k}f} deg,\tR = {c:9.{k}f} deg",
        )
        for (x, y, z), (a, b, c) in zip(rounded(p, k).tolist(), angles.tolist(), strict=True)
    ]
