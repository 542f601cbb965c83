"""Yaskawa INFORM for a weld sequence: all positions are joints, so that the form of the arm is fixed.

``MOVJ`` through the air, ``MOVL`` and ``MOVC`` on the seams. The axes of a positioner are station axes (``EC``), in the
second group of the job.
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.naming import comment_lines, safe_name
from wpcal.controllers.sequence_program import ArcChange, SequenceProgram, StepKind, degrees
from wpcal.controllers.yaskawa.write import DEG_DECIMALS, LONGEST_COMMENT, NAMES, inform_job


def write_sequence_inform(program: SequenceProgram) -> dict[str, str]:
    """Write an INFORM job.

    Parameters
    ----------
    program : SequenceProgram

    Returns
    -------
    dict of str to str
        ``NAME.jbi``, with lines ended by CR LF.

    Raises
    ------
    InputError
        When the job has too many lines.
    """
    name = safe_name(program.controller.program_name, NAMES).upper()
    head = comment_lines([*program.notes], mark="'", longest=LONGEST_COMMENT)
    job = inform_job(
        name,
        _positions(program),
        [*head, *_moves(program)],
        group="RB1",
        station="ST1" if program.external_names else None,
    )
    return {f"{name}.jbi": job}


def _positions(program: SequenceProgram) -> list[str]:
    arm = program.arm
    if all(joint.pulses_per_deg is not None for joint in arm.joints) and not program.external_names:
        kind, rows = "PULSE", [[f"{v:.0f}" for v in row] for row in arm.pulses_from_angles(program.joints)]
    else:
        kind, rows = "ANGLE", [list(row) for row in degrees(program.joints, DEG_DECIMALS)]
    outer = degrees(program.external, DEG_DECIMALS) if program.external_names else []
    return [
        f"///TOOL {program.controller.tool_number}",
        f"///POSTYPE {kind}",
        f"///{kind}",
        *(f"C{number:05d}={','.join(row)}" for number, row in enumerate(rows)),
        *(f"EC{number:05d}={','.join(row)}" for number, row in enumerate(outer)),
    ]


def _moves(program: SequenceProgram) -> list[str]:
    lines: list[str] = []
    at = 0
    follows_arc = False
    for step in program.steps:
        lines += [] if step.seam is None else [f"'{step.seam}"]
        if step.kind is StepKind.JOINT:
            lines.append(f"MOVJ {_target(program, step.target)} VJ={program.joint_percent:.2f} PL=0")
            at, follows_arc = step.target, False
            continue
        assert step.speed_mm_s is not None
        speed = f"V={np.round(step.speed_mm_s, 1):.1f}"
        level = " PL=0" if step.stops else ""
        if step.via is None:
            lines.append(f"MOVL {_target(program, step.target)} {speed}{level}")
        else:
            lines += [f"MOVL {_target(program, at)} {speed}"] if follows_arc else []
            lines += [f"MOVC {_target(program, row)} {speed}" for row in (at, step.via)]
            lines.append(f"MOVC {_target(program, step.target)} {speed}{level}")
        at, follows_arc = step.target, step.via is not None
        lines += {ArcChange.ON: ["'ARC ON"], ArcChange.OFF: ["'ARC OFF"], None: []}[step.arc]
    return lines


def _target(program: SequenceProgram, row: int) -> str:
    return f"C{row:05d} EC{row:05d}" if program.external_names else f"C{row:05d}"
