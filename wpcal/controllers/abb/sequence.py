"""ABB RAPID for a weld sequence: ``MoveAbsJ`` through the air, ``MoveL`` and ``MoveC`` with `confdata` on the seams.

Robtargets are in ``wobj0``. The axes of a positioner are the first external axes (``eax_a``, ``eax_b``).
"""

from __future__ import annotations

from wpcal.controllers.abb.configuration import confdata
from wpcal.controllers.abb.write import LONGEST_COMMENT, NAMES, TURN_DEG_S, pose_texts
from wpcal.controllers.naming import comment_lines, own_name, safe_name
from wpcal.controllers.sequence_program import ArcChange, SequenceProgram, SequenceStep, StepKind, degrees

DEG_DECIMALS = 5
"""A controller keeps 32-bit numbers: 1.5e-5 degrees at 180 degrees."""
EXTERNAL_AXES = 6
NO_AXIS = "9E+09"
"""The robot does not have this external axis."""
JOINT_MM_S = 500
"""Limit of the tip in joint moves: v500; the joints limit most of them."""


def write_sequence_rapid(program: SequenceProgram) -> dict[str, str]:
    """Write a RAPID module.

    Parameters
    ----------
    program : SequenceProgram

    Returns
    -------
    dict of str to str
        ``NAME.mod``, with lines ended by CR LF.

    Raises
    ------
    InputError
        When RAPID does not allow the tool's name.
    """
    module = safe_name(program.controller.program_name, NAMES)
    tool = own_name(program.controller.tool_name, NAMES, what="tool")
    speeds = sorted({step.speed_mm_s for step in program.steps if step.speed_mm_s is not None})
    names = {speed: f"vSeq{number}" for number, speed in enumerate(speeds, start=1)}
    lines = [f"MODULE {module}", *comment_lines([*program.notes], mark="  ! ", longest=LONGEST_COMMENT)]
    lines.append(f"  LOCAL CONST speeddata vJoint:=[{JOINT_MM_S},{TURN_DEG_S},{JOINT_MM_S},{TURN_DEG_S}];")
    lines += [
        f"  LOCAL CONST speeddata {name}:=[{speed:.4g},{TURN_DEG_S},{speed:.4g},{TURN_DEG_S}];"
        for speed, name in names.items()
    ]
    lines += _targets(program)
    moves = [line for step in program.steps for line in _move(step, names, tool)]
    return {
        f"{module}.mod": "\r\n".join(
            [*lines, "", f"  PROC {safe_name(f'run_{module}', NAMES)}()", *moves, "  ENDPROC", "ENDMODULE", ""]
        )
    }


def _label(row: int) -> str:
    return f"wp{row + 1:04d}"


def _targets(program: SequenceProgram) -> list[str]:
    joint_rows = {step.target for step in program.steps if step.kind is StepKind.JOINT}
    joints, outer = degrees(program.joints, DEG_DECIMALS), degrees(program.external, DEG_DECIMALS)
    poses, confs = pose_texts(program.p, program.R), confdata(program.postures)
    lines = []
    for row, (angles, axes, pose, conf) in enumerate(zip(joints, outer, poses, confs, strict=True)):
        external = ",".join([*axes, *[NO_AXIS] * (EXTERNAL_AXES - len(axes))])
        if row in joint_rows:
            lines.append(f"  LOCAL CONST jointtarget {_label(row)}:=[[{','.join(angles)}],[{external}]];")
        else:
            lines.append(f"  LOCAL CONST robtarget {_label(row)}:=[{pose},{conf},[{external}]];")
    return lines


def _move(step: SequenceStep, names: dict[float, str], tool: str) -> list[str]:
    lines = [] if step.seam is None else [f"    ! {step.seam}"]
    zone = "fine" if step.stops else "z1"
    if step.kind is StepKind.JOINT:
        return [*lines, f"    MoveAbsJ {_label(step.target)},vJoint,{zone},{tool};"]
    assert step.speed_mm_s is not None
    end = f"{_label(step.target)},{names[step.speed_mm_s]},{zone},{tool}\\WObj:=wobj0;"
    lines.append(f"    MoveL {end}" if step.via is None else f"    MoveC {_label(step.via)},{end}")
    return [*lines, *({ArcChange.ON: ["    ! ARC ON"], ArcChange.OFF: ["    ! ARC OFF"], None: []}[step.arc])]
