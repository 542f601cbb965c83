"""FANUC TP as ASCII (``.ls``): a program a seam and one that calls them all.

W, P, R in degrees with ``R = Rz(R) Ry(P) Rx(W)``; lengths in mm. Positions are relative to the user frame that the part
becomes. The file cannot carry a user frame: its six numbers stand in remarks, rounded as the pendant takes them, and
the positions are relative to exactly these numbers. `CONFIG` cannot be left open either: it is what the user gave, or
question marks that the controller refuses until they are filled in.

References
----------
FANUC, R-30iB HandlingTool Operator's Manual (position data, user frames, remarks of 32 characters).
"""

from __future__ import annotations

import re

from wpcal.controllers.naming import NameRules, comment_lines, safe_name, safe_names
from wpcal.controllers.program import WeldPath, WeldProgram, describe, describe_path
from wpcal.controllers.rounding import rounded, rounded_frame, zyx_degrees
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform

NAMES = NameRules("FANUC", 32, "aux com1 com2 con lpt1 lpt2 nul prn")
"""Names of programs have up to 36 characters; a file's name keeps clear of the device names of its file system."""
DECIMALS = 3
"""What the controller prints, of mm and of degrees."""
LONGEST_REMARK = 32
MOST_LINES = 9999
"""Line numbers have four digits."""
UNKNOWN_CONFIG = "? ? ?, ?, ?, ?"
CONFIG = re.compile(r"[NF] ?[LR]? ?[UD] ?[TB], ?-?\d+, ?-?\d+, ?-?\d+")
"""For example N U T, 0, 0, 0: flip, (left, right,) up, front, and the turns of three joints."""
JOINT_PERCENT = 10
"""Of the first move to a seam, which comes from wherever the arm stands: slow."""


def write_fanuc(program: WeldProgram) -> dict[str, str]:
    """Write TP programs.

    Parameters
    ----------
    program : WeldProgram

    Returns
    -------
    dict of str to str
        ``NAME.ls`` and a file a seam, with lines ended by CR LF.

    Raises
    ------
    InputError
        When a seam has too many points, a speed is none that TP can write, or the configuration is no CONFIG.
    """
    configuration = program.controller.configuration
    if configuration is not None and not CONFIG.fullmatch(configuration):
        raise InputError(f"configuration {configuration!r}: expected it as the pendant shows it, as N U T, 0, 0, 0")
    main = safe_name(program.controller.program_name, NAMES).upper()
    rules = NameRules(NAMES.language, NAMES.longest, f"{NAMES.keywords} {main.lower()}")
    names = {k: v.upper() for k, v in safe_names([path.seam.name for path in program.paths], rules).items()}
    T_base_frame = rounded_frame(program.T_base_part, mm_decimals=DECIMALS, deg_decimals=DECIMALS)
    files = {f"{main}.ls": _file(main, [*_header(program, names, T_base_frame), *_calls(names)], [])}
    for path in program.paths:
        name = names[path.seam.name]
        files[f"{name}.ls"] = _file(name, _moves(path, program), _positions(path, program, T_base_frame))
    return files


def _file(name: str, instructions: list[str], positions: list[str]) -> str:
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
        "DEFAULT_GROUP = 1,*,*,*,*;",
        "CONTROL_CODE = 00000000 00000000;",
        "/MN",
        *(f"{number:4d}:{text} ;" for number, text in enumerate(instructions, start=1)),
        "/POS",
        *positions,
        "/END",
        "",
    ]
    return "\r\n".join(lines)


def _remarks(lines: list[str]) -> list[str]:
    clean = [line.replace(";", ",") for line in lines]  # a semicolon ends an instruction
    return comment_lines(clean, mark="  !", longest=LONGEST_REMARK)


def _header(program: WeldProgram, names: dict[str, str], T_base_frame: RigidTransform) -> list[str]:
    x, y, z = T_base_frame.t_mm
    w, p, r = zyx_degrees(T_base_frame.R, decimals=DECIMALS)
    text = [
        *describe(program),
        f"set UFRAME {program.controller.frame_number} to the part:",
        *(f" {key} {value:.{DECIMALS}f}" for key, value in zip("XYZWPR", (x, y, z, w, p, r), strict=True)),
        "points are relative to it, mm",
        "R = Rz(R) Ry(P) Rx(W), deg",
        "rounded within 0.001 mm, 0.001 deg",
        "CONFIG as given by the user"
        if program.controller.configuration
        else "CONFIG is not known: put the arm's in place of ? ? ?",
        "seam -> program here",
        *(f" {path.seam.name} -> {names[path.seam.name]}: {describe_path(path)}" for path in program.paths),
    ]
    return _remarks(text)


def _calls(names: dict[str, str]) -> list[str]:
    return [f"  CALL {name}" for name in names.values()]


def _moves(path: WeldPath, program: WeldProgram) -> list[str]:
    weld, air = _speed(program.motion.speed_mm_s), _speed(program.motion.air_speed_mm_s)
    last = len(path) - 1
    return [
        *_remarks([path.seam.name, describe_path(path)]),
        f"  UFRAME_NUM={program.controller.frame_number}",
        f"  UTOOL_NUM={program.controller.tool_number}",
        f"J P[1] {JOINT_PERCENT}% FINE",
        f"L P[2] {air} FINE",
        "  !ARC ON",
        *(f"L P[{number}] {weld} CNT100" for number in range(3, last)),
        f"L P[{last}] {weld} FINE",
        "  !ARC OFF",
        f"L P[{last + 1}] {air} FINE",
    ]


def _speed(mm_s: float) -> str:
    """Write a speed, which TP knows as whole mm/sec or whole cm/min."""
    for value, unit in ((mm_s, "mm/sec"), (mm_s * 6.0, "cm/min")):
        if value >= 1 and abs(value - round(value)) < 1e-6:  # a rest below that is round-off of the factor 6
            return f"{round(value)}{unit}"
    nearest = max(round(mm_s * 6.0), 1) / 6.0
    raise InputError(f"FANUC: {mm_s:g} mm/s is neither whole mm/s nor whole cm/min; the nearest is {nearest:.4g} mm/s")


def _positions(path: WeldPath, program: WeldProgram, T_base_frame: RigidTransform) -> list[str]:
    p, R = path.poses_in(T_base_frame)
    controller = program.controller
    head = f"\tUF : {controller.frame_number}, UT : {controller.tool_number},"
    head += f"\t\tCONFIG : '{controller.configuration or UNKNOWN_CONFIG}',"
    return [
        line
        for number, text in enumerate(_coordinates(p, zyx_degrees(R, decimals=DECIMALS)), start=1)
        for line in (f"P[{number}]{{", "   GP1:", head, *text, "};")
    ]


def _coordinates(p: FloatArray, angles: FloatArray) -> list[tuple[str, str]]:
    k = DECIMALS
    return [
        (
            f"\tX = {x:9.{k}f}  mm,\tY = {y:9.{k}f}  mm,\tZ = {z:9.{k}f}  mm,",
            f"\tW = {a:9.{k}f} deg,\tP = {b:9.{k}f} deg,\tR = {c:9.{k}f} deg",
        )
        for (x, y, z), (a, b, c) in zip(rounded(p, k).tolist(), angles.tolist(), strict=True)
    ]
