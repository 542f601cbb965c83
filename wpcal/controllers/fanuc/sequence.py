"""FANUC TP for a weld sequence: joint positions through the air, poses with CONFIG on the seams.

The user frame is 0, the base of the robot. The axes of a positioner are group 2 of every position.
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.fanuc.configuration import config
from wpcal.controllers.fanuc.write import DECIMALS, LONGEST_REMARK, NAMES, coordinates, tp_file, tp_speed
from wpcal.controllers.naming import comment_lines, safe_name
from wpcal.controllers.rounding import zyx_degrees
from wpcal.controllers.sequence_program import ArcChange, SequenceProgram, SequenceStep, StepKind, degrees
from wpcal.core.errors import InputError


def write_sequence_fanuc(program: SequenceProgram) -> dict[str, str]:
    """Write a TP program.

    Parameters
    ----------
    program : SequenceProgram

    Returns
    -------
    dict of str to str
        ``NAME.ls``, with lines ended by CR LF.

    Raises
    ------
    InputError
        When the arm's file does not say how J3 counts, a speed cannot be written, a CONFIG is not known, or the program
        is too long.
    """
    if not program.arm.couplings:
        raise InputError(
            "FANUC shows J3 against the horizontal: the arm's file needs a coupling of J3 to J2 with factor 1 "
            '("couplings"), and limits of J3 as the pendant shows it'
        )
    name = safe_name(program.controller.program_name, NAMES).upper()
    tool = program.controller.tool_number
    lines = [*_remarks([*program.notes]), "  UFRAME_NUM=0", f"  UTOOL_NUM={tool}"]
    for step in program.steps:
        lines += _move(step, program.joint_percent)
    return {f"{name.lower()}.ls": tp_file(name, lines, _positions(program))}


def _remarks(lines: list[str]) -> list[str]:
    clean = [line.replace(";", ",") for line in lines]  # a semicolon ends an instruction
    return comment_lines(clean, mark="  !", longest=LONGEST_REMARK)


def _move(step: SequenceStep, percent: float) -> list[str]:
    lines = [] if step.seam is None else _remarks([step.seam])
    if step.kind is StepKind.JOINT:
        return [*lines, f"J P[{step.target + 1}] {percent:.0f}% FINE"]
    assert step.speed_mm_s is not None
    # whole mm/s or cm/min: rounded down, so that no joint has to be faster than planned
    whole = np.floor(step.speed_mm_s * 6.0 + 1e-6) / 6.0
    end = f"P[{step.target + 1}] {tp_speed(float(whole))} {'FINE' if step.stops else 'CNT100'}"
    lines.append(f"L {end}" if step.via is None else f"C P[{step.via + 1}]\r\n    :  {end}")
    return [*lines, *({ArcChange.ON: ["  !ARC ON"], ArcChange.OFF: ["  !ARC OFF"], None: []}[step.arc])]


def _positions(program: SequenceProgram) -> list[str]:
    joint_rows = {step.target for step in program.steps if step.kind is StepKind.JOINT}
    head = f"\tUF : 0, UT : {program.controller.tool_number},"
    texts = coordinates(program.p, zyx_degrees(program.R, decimals=DECIMALS))
    confs = config(program.postures)
    joints, outer = degrees(program.joints, DECIMALS), degrees(program.external, DECIMALS)
    lines = []
    for row, (text, conf, angles, axes) in enumerate(zip(texts, confs, joints, outer, strict=True)):
        lines += [f"P[{row + 1}]{{", "   GP1:"]
        if row in joint_rows:
            first, second = (
                ",".join(f"\tJ{k}= {angles[k - 1]} deg" for k in numbers) for numbers in ((1, 2, 3), (4, 5, 6))
            )
            lines += [head, f"{first},", second]
        else:
            lines += [f"{head}\t\tCONFIG : '{conf}',", *text]
        if axes:
            turned = ",".join(f"\tJ{k}= {value} deg" for k, value in enumerate(axes, start=1))
            lines += ["   GP2:", head, turned]
        lines.append("};")
    return lines
