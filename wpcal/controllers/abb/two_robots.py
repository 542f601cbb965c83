r"""ABB RAPID for two robots of one MultiMove controller: one module per task, moved in step.

Between ``SyncMoveOn`` and ``SyncMoveOff`` every move has an ``\ID``, the number of the mark at its end. The controller
begins and ends moves of the same ``\ID`` together.

In step, targets are joint angles (``MoveAbsJ``), so the configuration is fixed; ``\T`` gives the time of each move. In
coordinated motion the work object of the torch moves with the mechanical unit ``ROB_2`` (`ufprog` FALSE, `ufmec` its
name): its object frame is the part on the flange of robot 2. The torch keeps to its line or arc in the part. Robot 2
moves by joints: if both robots moved on arcs, their middles would have to be met at the same time.

References
----------
ABB, Application manual: MultiMove, 3HAC021272 (SyncMoveOn, syncident, tasks, argument ID; 6.3 Coordinated work objects;
6.7.2 Synchronization behavior; 6.7.4 Motion principles; 6.7.7 Tool orientation at circular movements). The order of
``\ID`` in ``ArcLStart`` and ``ArcCEnd`` follows public programs of MultiMove cells. Technical reference manual: RAPID
Instructions, Functions and Data types (MoveAbsJ, jointtarget).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wpcal.controllers.abb.arc import ArcData, arc_data
from wpcal.controllers.abb.write import (
    CIRCLE,
    LONGEST_COMMENT,
    NAMES,
    PROCEDURE,
    USUAL_CIRCLE,
    ZONE_MM,
    jointtargets,
    pose_texts,
    robtargets,
    speed_data,
)
from wpcal.controllers.language.naming import comment_lines, own_name, safe_name, safe_names
from wpcal.controllers.program.coordinated_program import ROBOTS, CoordinatedProgram, CoordinatedStep, SyncProgram

SECOND_DECIMALS = 4  #: A move takes some tenths of a second: 0.1 ms is 0.03 % of its speed.
FIRST_MM_S, JOINT_DEG_S = 50, 20  #: The speed of the first move. Slow, because the arm can come from anywhere.
TASKS = ("T_ROB1", "T_ROB2")  #: Names of the motion tasks as delivered.
LONGEST_PREFIX = len("tasks_")
"""Of the names of a seam that both tasks must share, and that differ from those of another seam."""
NO_TOOL = "tool0"  #: The tool of robot 2. Its targets are joint angles, so the tool does not change where the arm goes.
HOLDER_UNIT = "ROB_2"  #: The mechanical unit of robot 2 as delivered.
HELD = "held"  #: The end of the names of targets of robot 2.


def write_sync_rapid(program: SyncProgram) -> dict[str, str]:
    """Write one RAPID module per robot: ``NAME_R1.mod`` and ``NAME_R2.mod``."""
    width = program.label_width
    stem = safe_names([program.seam], NAMES, room=max(width + 1, LONGEST_PREFIX))[program.seam]
    labels, last = [f"{stem}_{mark:0{width}d}" for mark in program.marks], len(program) - 1
    files = dict[str, str]()
    for robot in ROBOTS:
        tool = safe_name(program.controller.tool_name, NAMES) if robot == 1 else NO_TOOL
        moves = []
        for row, label in enumerate(labels):
            if row > 0:
                zone = "fine" if row in (program.arc_on, program.arc_off, last) else "z1"
                seconds = f"{program.seconds[row - 1]:.{SECOND_DECIMALS}f}"
                moves.append(f"    MoveAbsJ {label}\\ID:={program.marks[row]},vStep\\T:={seconds},{zone},{tool};")
            moves += ["    ! ARC ON"] if row == program.arc_on else []
            moves += ["    ! ARC OFF"] if row == program.arc_off else []
        about = [
            f"robot {robot} ({program.arms[robot - 1].name}) of two, task {TASKS[robot - 1]}",
            *program.notes,
            f"seam {program.seam}: {len(program)} marks; joints in deg, rounded within 0.000005",
            "ID is the number of the mark; both modules have the same marks in the same order",
            "both modules must be of the same run: load and start both tasks together",
        ]
        first = [f"    MoveAbsJ {labels[0]},vStep,fine,{tool};"]
        speed = speed_data("vStep", FIRST_MM_S, JOINT_DEG_S)
        data = [speed, *jointtargets(labels, program.joints[robot - 1])]
        files |= _module(program, stem, robot, about=about, data=data, first=first, moves=moves)
    return files


def write_coordinated_rapid(program: CoordinatedProgram) -> dict[str, str]:
    """Write one RAPID module per robot: ``NAME_R1.mod`` and ``NAME_R2.mod``.

    Raises `InputError` when RAPID does not allow the name of the tool or of weld data.
    """
    room = max(program.label_width + 2 + len(HELD), LONGEST_PREFIX)
    stem = safe_names([program.seam], NAMES, room=room)[program.seam]
    return {**_torch(program, stem), **_holder(program, stem)}


def _module(
    program: SyncProgram | CoordinatedProgram, stem: str, robot: int, *, about: list[str], **lines: Sequence[str]
) -> dict[str, str]:
    """Return the module of one robot: `data`, then its `first` move, then `moves` in step, and what is `last`."""
    name = program.controller.program_name
    module = f"{safe_names([name], NAMES, room=len('_R1'))[name]}_R{robot}"
    tasks = ",".join(f'["{task}"]' for task in TASKS)
    text = [
        f"MODULE {module}",
        *comment_lines(about, mark="  ! ", longest=LONGEST_COMMENT),
        f"  PERS tasks tasks_{stem}{{2}}:=[{tasks}];",
        f"  VAR syncident start_{stem};",
        f"  VAR syncident end_{stem};",
        *lines["data"],
        "",
        f"  PROC {PROCEDURE}{stem}()",
        *lines["first"],
        f"    SyncMoveOn start_{stem},tasks_{stem};",
        *lines["moves"],
        f"    SyncMoveOff end_{stem};",
        *lines.get("last", ()),
        "  ENDPROC",
        "ENDMODULE",
        "",
    ]
    return {f"{module}.mod": "\r\n".join(text)}


def _about(program: CoordinatedProgram, robot: int, own: Sequence[str]) -> list[str]:
    arm = (program.cell.arm, program.cell.arm2)[robot - 1]
    together = "ID is the number of the mark, the same in both modules: load and start both tasks together"
    return [f"robot {robot} ({arm.name}) of two, task {TASKS[robot - 1]}", *program.notes, *own, together]


def _torch(program: CoordinatedProgram, stem: str) -> dict[str, str]:
    """Return the module of robot 1, whose targets are in the part."""
    path, held = program.path, program.cell.T_part
    arc = None if program.arc is None else arc_data(path, stem, program.speed_mm_s, NAMES)
    labels = path.labels(stem, width=program.label_width)
    frame, own = pose_texts(held.t_mm[None], held.R[None])[0], slice(path.before, None)  # the first is joints
    about = [
        f"targets are in the part, which {HOLDER_UNIT} holds; mm; q1..q4 = w,x,y,z; confdata from the joints",
        "the tool must be declared on the controller; its z is the wire",
    ]
    data = [
        speed_data("vFirst", FIRST_MM_S, JOINT_DEG_S),
        f'  PERS wobjdata part_{stem}:=[FALSE,FALSE,"{HOLDER_UNIT}",[[0,0,0],[1,0,0,0]],[{frame}]];',
        speed_data("vWeld", program.speed_mm_s),
        speed_data("vAir", program.air_speed_mm_s),
        *(() if arc is None else arc.declared),
        *jointtargets([f"{stem}_start"], program.joints1[:1]),
        *robtargets(labels, path.p_base, path.R_base, program.postures[0])[own],
    ]
    tool = own_name(program.controller.tool_name, NAMES, what="tool")
    return _module(
        program,
        stem,
        1,
        about=_about(program, 1, about),
        data=data,
        first=[f"    MoveAbsJ {stem}_start,vFirst,fine,{tool};", *(CIRCLE if path.has_arcs else ())],
        moves=_torch_moves(program, labels, f"{tool}\\WObj:=part_{stem};", arc),
        last=USUAL_CIRCLE if path.has_arcs else (),
    )


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


def _holder(program: CoordinatedProgram, stem: str) -> dict[str, str]:
    """Return the module of robot 2: one target for each mark, and one where it begins."""
    steps, width = program.steps(ZONE_MM), program.label_width
    rows = np.array([0, *(step.to for step in steps)])
    labels = [f"{stem}_{HELD}_{number:0{width}d}" for number in range(len(rows))]
    word = "MoveAbsJ" if program.arc is None else "ArcMoveAbsJ"
    about = [
        f"targets are joints in deg; {NO_TOOL} is the flange, with the load that is active",
        "the part is in the hand; its place on the flange is the object frame of robot 1's work object",
    ]
    moves = [
        f"    {word} {label}\\ID:={step.mark},vHeld,{'fine' if step.stops else 'z1'},{NO_TOOL};"
        for label, step in zip(labels[1:], steps, strict=True)
    ]
    speed = speed_data("vHeld", program.holder_speed_mm_s)  # both robots take the time of the slower one, the torch
    data = [speed_data("vFirst", FIRST_MM_S, JOINT_DEG_S), speed, *jointtargets(labels, program.joints2[rows])]
    first = [f"    MoveAbsJ {labels[0]},vFirst,fine,{NO_TOOL};"]
    return _module(program, stem, 2, about=_about(program, 2, about), data=data, first=first, moves=moves)
