"""Yaskawa INFORM (``.jbi``): one job per seam and one that calls them all.

Rx, Ry, Rz in degrees with ``R = Rz(Rz) Ry(Ry) Rx(Rx)``; lengths in mm. Positions are Cartesian, not pulses.
`wpcal.controllers.language.jobs` explains the user frame and the configuration.

References
----------
Yaskawa, DX200 / YRC1000 Options: Instructions for Data Transmission Function (job data format: NPOS, POSTYPE, RCONF).
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from functools import partial

import numpy as np

from wpcal.controllers.language.jobs import ConfigurationRule, JobLanguage, write_jobs
from wpcal.controllers.language.naming import NameRules, comment_lines
from wpcal.controllers.language.post import Post
from wpcal.controllers.language.rounding import rounded, zyx_degrees
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe_path
from wpcal.controllers.program.planned import JointMoves, PlannedMoves, angle_texts
from wpcal.controllers.yaskawa.arc import end_lines, start_lines
from wpcal.controllers.yaskawa.configuration import rconf
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.moves import Arc

NAMES = NameRules("INFORM", 32)
"""Names of jobs have up to 32 characters."""
MM_DECIMALS = 3
DEG_DECIMALS = 4
"""What the controller writes into its own jobs."""
LONGEST_COMMENT = 32
MOST_LINES = 9999
"""Of a job. It can have as many positions."""
CONFIGURATION = ConfigurationRule(
    format_name="inform",
    word="RCONF",
    pattern=re.compile(r"\d+(?:,\d+)+"),
    expected="numbers with commas, as RCONF of a job has them",
    example="1,0,0,0,0,0,0,0",
    complete=rconf,
)
ZONE_MM = 1.0
"""About how far from a corner the usual position level leaves the path at a weld speed."""
JOINT_PERCENT = 5.0
"""Of the first move to a seam. Slow, because the arm can come from anywhere."""
NO_DATE = "2000/01/01 00:00"
"""A job must have a date; the same input gives the same bytes."""


LANGUAGE = JobLanguage(
    names=NAMES,
    suffix=".jbi",
    job_word="job",
    mm_decimals=MM_DECIMALS,
    deg_decimals=DEG_DECIMALS,
    frame_word="USER",
    frame_keys=("X", "Y", "Z", "Rx", "Ry", "Rz"),
    rotation="R = Rz(Rz) Ry(Ry) Rx(Rx)",
    configuration=CONFIGURATION,
    coordinated="SMOVL, SMOVC: calibrate ST1 to RB1 (master: ST1)",
    plans_in_joints=True,
)


def write_inform(program: WeldProgram) -> dict[str, str]:
    """Write INFORM jobs. ``NAME.jbi`` and one file per seam, with lines ended by CR LF.

    Raises
    ------
    InputError
        When a seam has too many points, INFORM cannot write a speed, or the configuration is missing or not an RCONF.
    """
    return write_jobs(program, LANGUAGE, main_job=partial(_main_job, program), seam_job=partial(_seam_job, program))


def _main_job(
    program: WeldProgram, name: str, comments: list[str], calls: Sequence[str], T_base_frame: RigidTransform
) -> str:
    post = Post("inform", program)
    head = post.header(comment_lines(comments, mark="", longest=LONGEST_COMMENT))
    lines = [f"CALL JOB:{called}" for called in calls]
    if program.planned is not None:
        lines, positions = _between(program, program.planned, lines, post)
        return _planned_job(program, name, positions, [*head, *lines, *post.footer()])
    if program.safe_point is None:
        return inform_job(name, [], [*head, *lines, *post.footer()])
    first = post.air_move("C00000", speed=f"VJ={JOINT_PERCENT:.2f}", joint=True)
    last = post.air_move("C00000", speed=inform_speed(program.motion.air_speed_mm_s))
    positions = _positions(program.safe_point, program, T_base_frame)
    instructions = [*head, *first, *lines, *last, *post.footer()]
    return inform_job(name, positions, instructions, user=program.controller.frame_number)


def _seam_job(program: WeldProgram, name: str, path: WeldPath, T_base_frame: RigidTransform) -> str:
    if program.planned is not None and path.joints is not None and path.external is not None:
        positions = _joint_positions(program, JointMoves(path.joints, path.external))
        return _planned_job(program, name, positions, _moves(path, program))
    positions = _positions(path, program, T_base_frame)
    return inform_job(name, positions, _moves(path, program), user=program.controller.frame_number)


def _planned_job(program: WeldProgram, name: str, positions: list[str], instructions: list[str]) -> str:
    planned = program.planned
    has_rail = planned is not None and planned.rail is not None
    turns = planned is not None and bool(planned.turning)
    group = "RB1,BS1" if has_rail else "RB1"
    return inform_job(name, positions, instructions, group=group, station="ST1" if turns else None)


def _between(
    program: WeldProgram, planned: PlannedMoves, calls: Sequence[str], post: Post
) -> tuple[list[str], list[str]]:
    """Return the joint moves of a plan with the calls of the seams between them, and the positions of these moves.

    The last move before a seam is in the job of the seam.
    """
    lines: list[str] = []
    ways: list[JointMoves] = []
    count = 0
    for row, moves in enumerate(planned.air):
        ways.append(moves if row == len(calls) else moves.rows(0, -1))
        for number in range(count, count + len(ways[-1])):
            lines += post.joint_move(_point(program, number), speed=f"VJ={planned.joint_percent:.2f}")
        count += len(ways[-1])
        lines += calls[row : row + 1]
    joints, external = (np.concatenate([getattr(way, name) for way in ways]) for name in ("joints", "external"))
    return lines, _joint_positions(program, JointMoves(joints, external))


def _joint_positions(program: WeldProgram, moves: JointMoves) -> list[str]:
    """Return positions as joints, so that the form of the arm is fixed: pulses if all of them are known."""
    planned = program.planned
    if program.arm is None or planned is None:
        return []
    outer = planned.external_texts(moves.external, DEG_DECIMALS)
    rails = int(planned.rail is not None)
    kind, rows = joint_rows(moves.joints, None if planned.axis_count else program.arm)
    return [
        f"///TOOL {program.controller.tool_number}",
        f"///POSTYPE {kind}",
        f"///{kind}",
        *(f"C{number:05d}={','.join(row)}" for number, row in enumerate(rows)),
        *(f"BC{number:05d}={row[0]}" for number, row in enumerate(outer) if rails),
        *(f"EC{number:05d}={','.join(row[rails:])}" for number, row in enumerate(outer) if planned.turning),
    ]


def joint_rows(joints: FloatArray, arm: Arm | None) -> tuple[str, list[list[str]]]:
    """Return the kind of joint positions and their numbers: pulses if the arm has them for all joints, else degrees.

    Parameters
    ----------
    joints : shape (n, 6). Shown angles, rad.
    """
    if arm is not None and all(joint.pulses_per_deg is not None for joint in arm.joints):
        return "PULSE", [[f"{v:.0f}" for v in row] for row in arm.pulses_from_angles(joints)]
    return "ANGLE", angle_texts(joints, DEG_DECIMALS)


def _point(program: WeldProgram, number: int, *, station: bool = True) -> str:
    """Return a position as a move names it, with its external axes, those of the positioner if `station`."""
    planned = program.planned
    marks = ["C"]
    if planned is not None:
        marks += ["BC"] * (planned.rail is not None) + ["EC"] * (station and bool(planned.turning))
    return " ".join(f"{mark}{number:05d}" for mark in marks)


def _weld_move(program: WeldProgram, path: WeldPath, kind: str, number: int, speed: str) -> str:
    """Return a move along a seam: coordinated with the positioner, the master, where this turns."""
    if not path.turns_along:
        return f"MOV{kind} {_point(program, number)} {speed}"
    return f"SMOV{kind} {_point(program, number, station=False)} {speed}  +MOVJ EC{number:05d}"


def inform_job(
    name: str,
    positions: list[str],
    instructions: list[str],
    *,
    group: str | None = "RB1",
    user: int | None = None,
    station: str | None = None,
) -> str:
    """Return the text of a job.

    Parameters
    ----------
    name : A name that the language allows, upper case.
    positions : Lines of the section ``//POS`` after the counts.
    instructions : Lines between NOP and END.
    group : The robot that the job moves; None for a job that moves none.
    user : The user frame that Cartesian positions are relative to: the job becomes a relative job. None for pulses.
    station : The positioner, or the second robot, that the job moves too.

    Raises
    ------
    InputError : When the job has too many lines.
    """
    if len(instructions) + 2 > MOST_LINES:
        raise InputError(f"INFORM: {name} needs {len(instructions) + 2} lines, a job has at most {MOST_LINES}")
    count, base, outer = (sum(line.startswith(mark) for line in positions) for mark in ("C", "BC", "EC"))
    lines = [
        "/JOB",
        f"//NAME {name}",
        "//POS",
        f"///NPOS {count},{base},{outer},0,0,0",
        *positions,
        "//INST",
        f"///DATE {NO_DATE}",
        *(["///ATTR SC,RW"] if user is None else ["///ATTR SC,RW,RJ", f"////FRAME USER {user}"]),
        *([] if group is None else [f"///GROUP1 {group}"]),
        *([] if station is None else [f"///GROUP2 {station}"]),
        "NOP",
        *instructions,
        "END",
        "",
    ]
    return "\r\n".join(lines)


def _positions(poses: WeldPath | SafePoint, program: WeldProgram, T_base_frame: RigidTransform) -> list[str]:
    p, R = poses.poses_in(T_base_frame)
    coordinates = coordinates_of(p, zyx_degrees(R, decimals=DEG_DECIMALS))
    lines = [
        f"///USER {program.controller.frame_number}",
        f"///TOOL {program.controller.tool_number}",
        "///POSTYPE USER",
        "///RECTAN",
    ]
    before = None
    for conf, text in zip(CONFIGURATION.texts(program, poses), coordinates, strict=True):
        lines += [f"///RCONF {conf}", text] if conf != before else [text]
        before = conf
    return lines


def coordinates_of(p: FloatArray, angles: FloatArray) -> list[str]:
    """Return positions C00000, C00001, …: p of shape (n, 3), mm, in any one frame, and angles about x, y, z, deg."""
    m, k = MM_DECIMALS, DEG_DECIMALS
    rows = zip(rounded(p, m).tolist(), angles.tolist(), strict=True)
    return [
        f"C{number:05d}={x:.{m}f},{y:.{m}f},{z:.{m}f},{a:.{k}f},{b:.{k}f},{c:.{k}f}"
        for number, ((x, y, z), (a, b, c)) in enumerate(rows)
    ]


def _moves(path: WeldPath, program: WeldProgram) -> list[str]:
    post, air, mm_s = (
        Post("inform", program),
        inform_speed(program.motion.air_speed_mm_s),
        program.weld_speed_mm_s(path),
    )
    if path.speed_mm_s is not None:
        mm_s = max(math.floor(mm_s * 10.0 + 1e-6), 1) / 10.0  # no joint has to be faster than planned
    weld = inform_speed(mm_s if path.run is None else max(round(mm_s, 1), 0.1))  # a rule does not know INFORM
    rows, is_joint = path.weld_rows, program.safe_point is None
    lines = comment_lines([path.seam.name, describe_path(path)], mark="'", longest=LONGEST_COMMENT)
    if program.planned is not None:
        lines += post.joint_move(_point(program, 0), speed=f"VJ={program.planned.joint_percent:.2f}")
    else:
        lines += post.air_move("C00000", speed=f"VJ={JOINT_PERCENT:.2f}" if is_joint else air, joint=is_joint)
    for number in range(1, rows.start + 1):
        lines += post.air_move(_point(program, number), speed=air)
    lines += post.weld_start(path, partial(start_lines, path))
    lines += _weld_moves(path, program, weld)
    lines += post.weld_end(path, partial(end_lines, path))
    for number in range(rows.stop, len(path)):
        lines += post.air_move(_point(program, number), speed=air)
    return lines


def _weld_moves(path: WeldPath, program: WeldProgram, speed: str) -> list[str]:
    """Return the moves along the seam.

    An arc has three MOVC, the first at its start. Between two arcs a MOVL to the point where they meet tells that the
    second is another circle.
    """
    first = path.weld_rows.start
    lines, at, follows_arc = [], first, False
    for move, stop in zip(path.weld_moves, path.stops(ZONE_MM), strict=True):
        to = first + move.to
        level = " PL=0" if stop and to != first + path.weld_count - 1 else ""
        if isinstance(move, Arc):
            lines += [_weld_move(program, path, "L", at, speed)] if follows_arc else []
            lines += [_weld_move(program, path, "C", number, speed) for number in (at, first + move.via)]
        lines.append(_weld_move(program, path, "C" if isinstance(move, Arc) else "L", to, f"{speed}{level}"))
        at, follows_arc = to, isinstance(move, Arc)
    return lines


def inform_speed(mm_s: float) -> str:
    """Write a speed; INFORM has steps of 0.1 mm/s."""
    if mm_s < 0.1 or abs(mm_s - round(mm_s, 1)) > 1e-9:  # a rest below that is round-off of the decimal
        raise InputError(f"INFORM: {mm_s:g} mm/s is not a multiple of 0.1 mm/s")
    return f"V={mm_s:.1f}"
