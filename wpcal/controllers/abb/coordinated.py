r"""ABB RAPID for two robots in coordinated motion: robtargets in a work object that robot 2 holds.

The work object of the torch moves with the mechanical unit ``ROB_2`` (`ufprog` FALSE, `ufmec` its name): its object
frame is the part on the flange of robot 2. Between ``SyncMoveOn`` and ``SyncMoveOff`` every move of the torch has a
move of robot 2 with the same ``\ID``. The torch keeps to its line or arc in the part. Robot 2 moves by joints: if both
robots moved on arcs, their middles would have to be met at the same time.

References
----------
ABB, Application manual: MultiMove, 3HAC021272 (6.3 Coordinated work objects; 6.7.2 Synchronization behavior; 6.7.4
Motion principles; 6.7.7 Tool orientation at circular movements). The order of ``\ID`` in ``ArcLStart`` and ``ArcCEnd``
follows public programs of MultiMove cells.
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.abb.arc import ArcData, arc_data
from wpcal.controllers.abb.configuration import confdata
from wpcal.controllers.abb.sync import JOINT_DEG_S, NO_TOOL, TASK_LIST, TASKS, WAIT_AT_END, WAIT_AT_START, jointtargets
from wpcal.controllers.abb.write import (
    CIRCLE,
    LONGEST_COMMENT,
    NAMES,
    NO_EXTERNAL_AXES,
    PROCEDURE,
    TURN_DEG_S,
    USUAL_CIRCLE,
    ZONE_MM,
    pose_texts,
)
from wpcal.controllers.language.naming import comment_lines, own_name, safe_names
from wpcal.controllers.program.coordinated_program import CoordinatedProgram, CoordinatedStep

HOLDER_UNIT = "ROB_2"
"""The mechanical unit of robot 2 as delivered."""
WORK_OBJECT = "part_"
"""Before the name of a seam: the work object in the hand of robot 2."""
HOLDER_SPEED = "vHeld"
"""Of robot 2: both robots take the time of the slower one, which is the torch."""
START, HELD = "start", "held"
"""Ends of the names of targets by joints: where robot 1 begins, and of robot 2."""


def write_coordinated_rapid(program: CoordinatedProgram) -> dict[str, str]:
    """Write one RAPID module per robot. ``NAME_R1.mod`` and ``NAME_R2.mod``, with lines ended by CR LF.

    Raises
    ------
    InputError : When RAPID does not allow the name of the tool or of weld data.
    """
    name, width = program.controller.program_name, program.label_width
    module = safe_names([name], NAMES, room=len("_R1"))[name]
    stem = safe_names([program.seam], NAMES, room=max(width + 2 + len(HELD), len(TASK_LIST)))[program.seam]
    arc = None if program.arc is None else arc_data(program.path, stem, program.speed_mm_s, NAMES)
    tasks = ",".join(f'["{task}"]' for task in TASKS)
    bodies = {1: _torch(program, stem, arc), 2: _holder(program, stem)}
    files = {}
    for robot, (data, moves) in bodies.items():
        lines = [
            f"MODULE {module}_R{robot}",
            *_header(program, robot),
            f"  PERS tasks {TASK_LIST}{stem}{{2}}:=[{tasks}];",
            f"  VAR syncident {WAIT_AT_START}{stem};",
            f"  VAR syncident {WAIT_AT_END}{stem};",
            f"  LOCAL CONST speeddata vFirst:=[50,{JOINT_DEG_S},50,{JOINT_DEG_S}];",
            *data,
            "",
            f"  PROC {PROCEDURE}{stem}()",
            *moves,
            "  ENDPROC",
            "ENDMODULE",
            "",
        ]
        files[f"{module}_R{robot}.mod"] = "\r\n".join(lines)
    return files


def _header(program: CoordinatedProgram, robot: int) -> list[str]:
    arm = (program.cell.arm1, program.cell.arm2)[robot - 1]
    own = {
        1: [
            f"targets are in the part, which {HOLDER_UNIT} holds; mm; q1..q4 = w,x,y,z; confdata from the joints",
            "the tool must be declared on the controller; its z is the wire",
        ],
        2: [
            f"targets are joints in deg; {NO_TOOL} is the flange, with the load that is active",
            "the part is in the hand; its place on the flange is the object frame of robot 1's work object",
        ],
    }
    text = [
        f"robot {robot} ({arm.name}) of two, task {TASKS[robot - 1]}",
        *program.notes,
        *own[robot],
        "ID is the number of the mark, the same in both modules: load and start both tasks together",
    ]
    return comment_lines(text, mark="  ! ", longest=LONGEST_COMMENT)


def _torch(program: CoordinatedProgram, stem: str, arc: ArcData | None) -> tuple[list[str], list[str]]:
    """Return the data and the moves of robot 1."""
    path, held = program.path, program.cell.T_flange2_part
    labels = path.labels(stem, width=program.label_width)
    frame = pose_texts(held.t_mm[None], held.R[None])[0]
    texts, confs = pose_texts(path.p_base, path.R_base), confdata(program.postures[0])
    data = [
        f'  PERS wobjdata {WORK_OBJECT}{stem}:=[FALSE,FALSE,"{HOLDER_UNIT}",[[0,0,0],[1,0,0,0]],[{frame}]];',
        *(
            f"  LOCAL CONST speeddata {name}:=[{speed:.6g},{TURN_DEG_S},{speed:.6g},{TURN_DEG_S}];"
            for name, speed in (("vWeld", program.speed_mm_s), ("vAir", program.air_speed_mm_s))
        ),
        *(() if arc is None else arc.declared),
        *jointtargets([f"{stem}_{START}"], program.joints1[:1]),
        *(
            f"  LOCAL CONST robtarget {label}:=[{text},{conf},{NO_EXTERNAL_AXES}];"
            for label, text, conf in list(zip(labels, texts, confs, strict=True))[path.before :]  # the first is joints
        ),
    ]
    tool = own_name(program.controller.tool_name, NAMES, what="tool")
    moves = [f"    MoveAbsJ {stem}_{START},vFirst,fine,{tool};", *(CIRCLE if path.has_arcs else ())]
    moves.append(f"    SyncMoveOn {WAIT_AT_START}{stem},{TASK_LIST}{stem};")
    moves += _torch_moves(program, labels, f"{tool}\\WObj:={WORK_OBJECT}{stem};", arc)
    return data, [*moves, f"    SyncMoveOff {WAIT_AT_END}{stem};", *(USUAL_CIRCLE if path.has_arcs else ())]


def _torch_moves(program: CoordinatedProgram, labels: list[str], end: str, arc: ArcData | None) -> list[str]:
    start, *others = program.steps(ZONE_MM)
    seam, after = [step for step in others if step.on_seam], [step for step in others if not step.on_seam]
    first, last = (f"    ! {mark}" for mark in program.marks)
    if arc is None:
        lines = [_move("Move", start, labels, "vAir", end), first]
        lines += [_move("Move", step, labels, "vWeld", end) for step in seam]
    else:
        data = f",{arc.text}"
        lines = [first, _move("Arc", start, labels, f"vAir{data}", end, part="Start")]
        lines += [_move("Arc", step, labels, f"vWeld{data}", end) for step in seam[:-1]]
        lines.append(_move("Arc", seam[-1], labels, f"vWeld{data}", end, part="End"))
    return [*lines, last, *(_move("Move", step, labels, "vAir", end) for step in after)]


def _move(word: str, step: CoordinatedStep, labels: list[str], how: str, end: str, *, part: str = "") -> str:
    kind, via = ("L", "") if step.via is None else ("C", f"{labels[step.via]},")
    zone = "fine" if step.stops else "z1"
    return f"    {word}{kind}{part} {via}{labels[step.to]}\\ID:={step.mark},{how},{zone},{end}"


def _holder(program: CoordinatedProgram, stem: str) -> tuple[list[str], list[str]]:
    """Return the data and the moves of robot 2: one target for each mark, and one where it begins."""
    steps, width = program.steps(ZONE_MM), program.label_width
    rows = np.array([0, *(step.to for step in steps)])
    labels = [f"{stem}_{HELD}_{number:0{width}d}" for number in range(len(rows))]
    word = "MoveAbsJ" if program.arc is None else "ArcMoveAbsJ"
    moves = [f"    MoveAbsJ {labels[0]},vFirst,fine,{NO_TOOL};"]
    moves.append(f"    SyncMoveOn {WAIT_AT_START}{stem},{TASK_LIST}{stem};")
    for label, step in zip(labels[1:], steps, strict=True):
        zone = "fine" if step.stops else "z1"
        moves.append(f"    {word} {label}\\ID:={step.mark},{HOLDER_SPEED},{zone},{NO_TOOL};")
    speed = program.holder_speed_mm_s
    data = f"  LOCAL CONST speeddata {HOLDER_SPEED}:=[{speed:.6g},{TURN_DEG_S},{speed:.6g},{TURN_DEG_S}];"
    return [data, *jointtargets(labels, program.joints2[rows])], [*moves, f"    SyncMoveOff {WAIT_AT_END}{stem};"]
