"""KUKA KRL for two robots of a RoboTeam: the slave's base is the part in the hand of the master.

Each controller has its own program. The torch (slave) moves on ``SLIN`` and ``SCIRC`` in the base of its number, which
must be coupled to the flange of the other robot in the configuration of the cell. Robot 2 (master) moves on ``SLIN``
with the part as its tool. Every move of both is synchronised: ``$SYNC_ID[]`` is the same text in both programs, and
``$SYNC_LIST`` has one bit for each robot.

References: ``$SYNC_ID[]``, ``$SYNC_LIST``, ``SBASE`` and that synchronised points are SLIN:
SatelliteApplicationsCatapult/Automate-Synch-KUKA-RoboTeam. No public program with a geometric coupling was found.
"""

from __future__ import annotations

from wpcal.controllers.kuka.arc import SWITCH, how
from wpcal.controllers.kuka.write import (
    ATTRIBUTES,
    BLEND_MM,
    CIRCLE,
    JOINT_PERCENT,
    LONGEST_COMMENT,
    NAMES,
    aggregates,
    axes_text,
    forms_of,
    krl_frame,
    krl_frame_text,
)
from wpcal.controllers.language.naming import comment_lines, safe_names
from wpcal.controllers.program.coordinated_program import CoordinatedProgram, CoordinatedStep
from wpcal.core.arrays import FloatArray
from wpcal.robot.kinematics.inverse import Posture, posture

BOTH = "'B0011'"  #: The robots that wait for each other: bits 1 and 2.
START = "START"  #: The axes at which a robot begins.


def write_coordinated_krl(program: CoordinatedProgram) -> dict[str, str]:
    """Write one KRL program and its data list per robot.

    Raises `InputError` when plain KRL cannot hold the weld data.
    """
    name = program.controller.program_name
    module = safe_names([name], NAMES, room=len("_R1"))[name]
    stem = safe_names([program.seam], NAMES, room=program.label_width + 1)[program.seam]
    labels = program.path.labels(stem, width=program.label_width)
    files = {}
    for robot, (data, moves) in ((1, _torch(program, labels)), (2, _holder(program, labels))):
        own = f"{module}_R{robot}"
        head = comment_lines(_about(program, robot), mark="; ", longest=LONGEST_COMMENT)
        start = ["BAS(#INITMOV,0)", f"BAS(#VEL_PTP,{JOINT_PERCENT})"]
        source = [*ATTRIBUTES, f"DEF {own}()", *head, *start, *moves, "END", ""]
        files[f"{own}.src"] = "\r\n".join(source)
        files[f"{own}.dat"] = "\r\n".join([*ATTRIBUTES, f"DEFDAT {own}", *data, "ENDDAT", ""])
    return files


def _about(program: CoordinatedProgram, robot: int) -> list[str]:
    frame, arm = program.controller.frame_number, (program.cell.arm, program.cell.arm2)[robot - 1]
    own = {
        1: f"BASE_DATA[{frame}] must be coupled to the flange of robot 2 (WorkVisual), with the numbers of PART_HELD",
        2: "the tool is the part on the flange, the base that of the robot",
    }
    arc = how(program.arc, folds=False) if program.arc is not None and robot == 1 else []
    return [f"robot {robot} ({arm.name}) of two, RoboTeam", *program.notes, own[robot], *arc]


def _torch(program: CoordinatedProgram, labels: list[str]) -> tuple[list[str], list[str]]:
    """Return the data and the moves of robot 1."""
    path, frame, around = program.path, program.controller.frame_number, SWITCH.around(program.path, program.arc)
    targets = _targets(labels, path.p_base, path.R_base, program.postures[0])
    data = _data(program, program.joints1, targets[path.before :])
    start, *others = program.steps(BLEND_MM)
    first, last = (f"; {mark}" for mark in program.marks)
    lines = [
        f"$TOOL=TOOL_DATA[{program.controller.tool_number}]",
        f"PTP {START}",
        f"$BASE=SBASE({frame})",
        "$IPO_MODE=#BASE",
        f"$APO.CDIS={BLEND_MM:g}",
        *(CIRCLE if path.has_arcs else ()),
        _move(start, labels, program.air_speed_mm_s),
        first,
        *around.on(),
        *(_move(step, labels, program.speed_mm_s) for step in others if step.on_seam),
        *around.off(),
        last,
    ]
    return data, [*lines, *(_move(step, labels, program.air_speed_mm_s) for step in others if not step.on_seam)]


def _holder(program: CoordinatedProgram, labels: list[str]) -> tuple[list[str], list[str]]:
    """Return the data and the moves of robot 2: a target for each mark."""
    T, steps = program.part_in_base2(), [step._replace(via=None) for step in program.steps(BLEND_MM)]
    rows = [step.to for step in steps]
    names = [labels[row] for row in rows]
    held = [names.index(labels[row]) for row in rows]
    joints = program.joints2[rows]
    targets = _targets(names, T[rows, :3, 3], T[rows, :3, :3], posture(program.cell.arm2, joints))
    data = _data(program, joints, targets)
    return data, [
        "$TOOL=PART_HELD",
        f"PTP {START}",
        "$BASE=$NULLFRAME",
        "$IPO_MODE=#BASE",
        f"$APO.CDIS={BLEND_MM:g}",
        "$ORI_TYPE=#VAR",
        *(
            _move(step._replace(to=row), names, program.holder_speed_mm_s)
            for step, row in zip(steps, held, strict=True)
        ),
    ]


def _move(step: CoordinatedStep, names: list[str], mm_s: float) -> str:
    to = f"SLIN {names[step.to]}" if step.via is None else f"SCIRC {names[step.via]},{names[step.to]}"
    how_fast = f'WITH $VEL.CP={mm_s / 1000.0:.6g},$SYNC_ID[]="M{step.mark}",$SYNC_LIST={BOTH}'
    return f"{to} {how_fast}{'' if step.stops else ' C_SPL'}"


def _targets(names: list[str], p: FloatArray, R: FloatArray, forms: Posture) -> list[str]:
    """Declare targets.

    S and T are left out where they are not known: SLIN and SCIRC ignore both, and go on from axes.
    """
    known = forms_of([forms])
    values = aggregates(p, R, None if known is None else known[0])
    return [f"DECL E6POS {name}={value}" for name, value in zip(names, values, strict=True)]


def _data(program: CoordinatedProgram, joints: FloatArray, targets: list[str]) -> list[str]:
    """Declare where the part is held, where the robot begins, and its targets."""
    return [
        f"DECL FRAME PART_HELD={krl_frame_text(krl_frame(program.cell.T_part))}",
        f"DECL E6AXIS {START}={axes_text(joints[0])}",
        *targets,
    ]
