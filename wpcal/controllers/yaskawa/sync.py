"""Yaskawa INFORM for two robots of one controller: one job per robot, and one that starts both.

Both jobs run at the same time (``PSTART``) and wait for each other at every mark (``TSYNC`` with ``SNUM=2``). Targets
are joint values: encoder pulses if the arm's file states the pulses per degree, otherwise degrees (``///POSTYPE
ANGLE``, which newer controllers read). In this language a joint move has no time but a speed ``VJ``, a percentage of
the largest joint speed. It is chosen so that the move takes the planned time, and rounded to the decimals of the
language.

References
----------
Yaskawa, DX200 / YRC1000 Options: Instructions for Independent/Coordinated Control Function (PSTART, PWAIT, TSYNC) and
for Data Transmission Function (job data format: NPOS, POSTYPE, PULSE).
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.language.naming import comment_lines, safe_names
from wpcal.controllers.language.rounding import rounded
from wpcal.controllers.program.coordinated_program import ROBOTS, SyncProgram
from wpcal.controllers.yaskawa.write import DEG_DECIMALS, JOINT_PERCENT, LONGEST_COMMENT, NAMES, inform_job
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.robot.kinematics.arm import Arm

PERCENT_DECIMALS = 2
LEAST_PERCENT = 0.01
"""The language has VJ from 0.01 to 100.00."""
ROUND_OFF = 1e-9
"""A percentage this little above one that can be written is that one."""
SYNC_NUMBERS = 8
"""TSYNC has few numbers. Neither job can be more than one mark ahead, so eight numbers in turn cannot be confused."""


def write_sync_inform(program: SyncProgram) -> dict[str, str]:
    """Write one INFORM job per robot, and one that starts both.

    Returns
    -------
    dict of str to str. ``NAME.jbi``, ``NAME_R1.jbi`` and ``NAME_R2.jbi``, with lines ended by CR LF.

    Raises
    ------
    InputError
        When an arm does not state the largest speeds of its joints, a move needs more than these, or a job would be
        too long.
    """
    name = program.controller.program_name
    main = safe_names([name], NAMES, room=len("_R1"))[name].upper()
    jobs = {robot: f"{main}_R{robot}" for robot in ROBOTS}
    notes = [*program.notes, f"seam {program.seam}", _timing_note(program)]
    start = [f"PSTART JOB:{job} SUB{robot}" for robot, job in jobs.items()]
    wait = [f"PWAIT SUB{robot}" for robot in ROBOTS]
    head = comment_lines(notes, mark="'", longest=LONGEST_COMMENT)
    files = {f"{main}.jbi": inform_job(main, [], [*head, *start, *wait], group=None)}
    for robot, job in jobs.items():
        files[f"{job}.jbi"] = inform_job(job, _positions(program, robot), _moves(program, robot), group=f"RB{robot}")
    return files


def _positions(program: SyncProgram, robot: int) -> list[str]:
    arm, joints = program.arms[robot - 1], program.joints[robot - 1]
    tool = program.controller.tool_number if robot == 1 else 0
    kind = joint_kind(arm)
    rows = joint_rows(arm, joints, kind)
    return [
        f"///TOOL {tool}",
        f"///POSTYPE {kind}",
        f"///{kind}",
        *(f"C{number:05d}={row}" for number, row in enumerate(rows)),
    ]


def joint_kind(*arms: Arm) -> str:
    """Return how joints are written: ``PULSE`` if every arm states its pulses per degree, otherwise ``ANGLE``."""
    return "PULSE" if all(joint.pulses_per_deg is not None for arm in arms for joint in arm.joints) else "ANGLE"


def joint_rows(arm: Arm, joints: FloatArray, kind: str) -> list[str]:
    """Return positions as a job has them.

    Parameters
    ----------
    joints : shape (n, 6). Shown angles, rad.
    kind : As `joint_kind` returns it.
    """
    if kind == "PULSE":
        return [",".join(f"{v:.0f}" for v in row) for row in arm.pulses_from_angles(joints)]
    degrees = rounded(np.degrees(joints), DEG_DECIMALS).tolist()
    return [",".join(f"{v:.{DEG_DECIMALS}f}" for v in row) for row in degrees]


def _moves(program: SyncProgram, robot: int) -> list[str]:
    text = [
        f"robot {robot} of two",
        f"seam {program.seam}",
        "targets are joints; both jobs wait",
        "for each other at each mark",
    ]
    lines = comment_lines(text, mark="'", longest=LONGEST_COMMENT)
    percents = joint_percents(program)[robot - 1]
    for row, mark in enumerate(program.marks):
        percent = JOINT_PERCENT if row == 0 else percents[row - 1]
        lines += [
            f"MOVJ C{row:05d} VJ={percent:.{PERCENT_DECIMALS}f}",
            f"'MARK {mark}",
            f"TSYNC {row % SYNC_NUMBERS + 1} SNUM=2",
        ]
        lines += ["'ARC ON"] if row == program.arc_on else []
        lines += ["'ARC OFF"] if row == program.arc_off else []
    return lines


def joint_percents(program: SyncProgram) -> FloatArray:
    r"""Return ``VJ`` of every move of both robots: percentages of the largest joint speeds that give the planned times.

    :math:`100 \max_j |\Delta q_j| / (\dot q_{j,max} \Delta t)`, rounded for the robot with the larger percentage and
    rounded up for the other. The other robot arrives early and waits, so its rounding does not slow the step.

    Returns
    -------
    ndarray, shape (2, N - 1). Percent.

    Raises
    ------
    InputError : When an arm does not state the speeds of its joints, or a percentage is more than 100.
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
