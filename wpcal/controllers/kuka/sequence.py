"""KUKA KRL for a weld sequence: ``PTP`` to axes through the air, ``LIN`` and ``CIRC`` with S and T on the seams.

The base is ``$NULLFRAME``; ``$TOOL`` is set to the tool centre point of the cell, with the wire along z. The axes of a
positioner are E1 and E2.
"""

from __future__ import annotations

from wpcal.controllers.kuka.configuration import status_and_turn
from wpcal.controllers.kuka.write import (
    ATTRIBUTES,
    BLEND_MM,
    CIRCLE,
    DEG_DECIMALS,
    LONGEST_COMMENT,
    MM_DECIMALS,
    NAMES,
    aggregates,
)
from wpcal.controllers.naming import comment_lines, safe_name
from wpcal.controllers.rounding import rounded_frame, zyx_degrees
from wpcal.controllers.sequence_program import ArcChange, SequenceProgram, SequenceStep, StepKind, degrees


def write_sequence_krl(program: SequenceProgram) -> dict[str, str]:
    """Write a KRL program.

    Parameters
    ----------
    program : SequenceProgram

    Returns
    -------
    dict of str to str
        ``NAME.src``, with lines ended by CR LF.

    Raises
    ------
    InputError
        When the wrist centre is in the overhead area at a pose, for which no source of S could be checked.
    """
    name = safe_name(program.controller.program_name, NAMES)
    tool = rounded_frame(program.T_flange_tool, mm_decimals=MM_DECIMALS, deg_decimals=DEG_DECIMALS)
    frame = aggregates(tool.t_mm[None], zyx_degrees(tool.R, decimals=DEG_DECIMALS)[None])[0]
    targets = _targets(program)
    lines = [
        *ATTRIBUTES,
        f"DEF {name}()",
        *comment_lines([*program.notes], mark="; ", longest=LONGEST_COMMENT),
        "BAS(#INITMOV,0)",
        f"BAS(#VEL_PTP,{program.joint_percent:.0f})",
        f"$TOOL={frame}",
        "$BASE=$NULLFRAME",
        "$IPO_MODE=#BASE",
        f"$APO.CDIS={BLEND_MM:g}",
        *CIRCLE,
    ]
    speed: float | None = None
    for step in program.steps:
        if step.speed_mm_s is not None and step.speed_mm_s != speed:
            speed = step.speed_mm_s
            lines.append(f"$VEL.CP={speed / 1000.0:.6g}")
        lines += _move(step, targets)
    return {f"{name}.src": "\r\n".join([*lines, "END", ""])}


def _targets(program: SequenceProgram) -> list[str]:
    joint_rows = {step.target for step in program.steps if step.kind is StepKind.JOINT}
    poses = aggregates(program.p, zyx_degrees(program.R, decimals=DEG_DECIMALS))
    both = status_and_turn(program.postures)
    joints, outer = degrees(program.joints, DEG_DECIMALS), degrees(program.external, DEG_DECIMALS)
    texts = []
    for row, (pose, (status, turn), angles, axes) in enumerate(zip(poses, both, joints, outer, strict=True)):
        external = "".join(f",E{number} {value}" for number, value in enumerate(axes, start=1))
        if row in joint_rows:
            texts.append(f"{{{','.join(f'A{number} {v}' for number, v in enumerate(angles, start=1))}{external}}}")
        else:
            texts.append(f"{pose[:-1]},S {status},T {turn}{external}}}")
    return texts


def _move(step: SequenceStep, targets: list[str]) -> list[str]:
    lines = [] if step.seam is None else [f"; {step.seam}"]
    end = targets[step.target]
    if step.kind is StepKind.JOINT:
        return [*lines, f"PTP {end}"]
    move = f"LIN {end}" if step.via is None else f"CIRC {targets[step.via]},{end}"
    lines.append(move if step.stops else f"{move} C_DIS")
    return [*lines, *({ArcChange.ON: ["; ARC ON"], ArcChange.OFF: ["; ARC OFF"], None: []}[step.arc])]
