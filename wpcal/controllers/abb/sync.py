r"""ABB RAPID for two robots of one MultiMove controller: one module per task, moved in step.

Between ``SyncMoveOn`` and ``SyncMoveOff`` every move has an ``\ID``, the number of the mark at its end. The controller
begins and ends moves of the same ``\ID`` together. Targets are joint angles in degrees (``MoveAbsJ``), so the
configuration is fixed. ``\T`` gives the time of each move.

References
----------
ABB, Application manual: MultiMove (SyncMoveOn, syncident, tasks, argument ID); Technical reference manual: RAPID
Instructions, Functions and Data types (MoveAbsJ, jointtarget).
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.abb.write import LONGEST_COMMENT, NAMES, NO_EXTERNAL_AXES, PROCEDURE
from wpcal.controllers.language.naming import comment_lines, safe_name, safe_names
from wpcal.controllers.language.rounding import rounded
from wpcal.controllers.program.coordinated_program import ROBOTS, SyncProgram
from wpcal.core.arrays import FloatArray

DEG_DECIMALS = 5
"""A controller keeps 32-bit numbers: 1.5e-5 degrees at 180 degrees. One more digit loses nothing."""
SECOND_DECIMALS = 4
"""A move takes some tenths of a second: 0.1 ms is 0.03 % of its speed."""
JOINT_DEG_S = 20
"""Of the first move. Slow, because the arm can come from anywhere."""
TASKS = ("T_ROB1", "T_ROB2")
"""Names of the motion tasks as delivered."""
WAIT_AT_START, WAIT_AT_END, TASK_LIST = "start_", "end_", "tasks_"
"""Before the name of a seam: names that both tasks must share, and that differ from those of another seam."""
NO_TOOL = "tool0"
"""The tool of robot 2. Its targets are joint angles, so the tool does not change where the arm goes."""


def write_sync_rapid(program: SyncProgram) -> dict[str, str]:
    """Write one RAPID module per robot. ``NAME_R1.mod`` and ``NAME_R2.mod``, with lines ended by CR LF."""
    stem = safe_names([program.controller.program_name], NAMES, room=len("_R1"))[program.controller.program_name]
    return {f"{stem}_R{robot}.mod": "\r\n".join(_module(program, f"{stem}_R{robot}", robot)) for robot in ROBOTS}


def _module(program: SyncProgram, module: str, robot: int) -> list[str]:
    width = program.label_width
    stem = safe_names([program.seam], NAMES, room=max(width + 1, len(TASK_LIST)))[program.seam]
    labels = [f"{stem}_{mark:0{width}d}" for mark in program.marks]
    tasks = ",".join(f'["{task}"]' for task in TASKS)
    return [
        f"MODULE {module}",
        *_header(program, robot),
        f"  PERS tasks {TASK_LIST}{stem}{{2}}:=[{tasks}];",
        f"  VAR syncident {WAIT_AT_START}{stem};",
        f"  VAR syncident {WAIT_AT_END}{stem};",
        f"  LOCAL CONST speeddata vStep:=[50,{JOINT_DEG_S},50,{JOINT_DEG_S}];",
        *jointtargets(labels, program.joints[robot - 1]),
        "",
        f"  PROC {PROCEDURE}{stem}()",
        *_moves(program, stem, labels, safe_name(program.controller.tool_name, NAMES) if robot == 1 else NO_TOOL),
        "  ENDPROC",
        "ENDMODULE",
        "",
    ]


def _header(program: SyncProgram, robot: int) -> list[str]:
    text = [
        f"robot {robot} ({program.arms[robot - 1].name}) of two, task {TASKS[robot - 1]}",
        *program.notes,
        f"seam {program.seam}: {len(program)} marks; joints in deg, rounded within 0.000005",
        "ID is the number of the mark; both modules have the same marks in the same order",
        "both modules must be of the same run: load and start both tasks together",
    ]
    return comment_lines(text, mark="  ! ", longest=LONGEST_COMMENT)


def jointtargets(labels: list[str], joints: FloatArray) -> list[str]:
    """Declare joint targets.

    Parameters
    ----------
    labels : n names.
    joints : shape (n, 6). Shown angles, rad.
    """
    rows = rounded(np.degrees(joints), DEG_DECIMALS).tolist()
    return [
        f"  LOCAL CONST jointtarget {label}:=[[{','.join(f'{v:.{DEG_DECIMALS}f}' for v in row)}],{NO_EXTERNAL_AXES}];"
        for label, row in zip(labels, rows, strict=True)
    ]


def _moves(program: SyncProgram, stem: str, labels: list[str], tool: str) -> list[str]:
    lines = [f"    MoveAbsJ {labels[0]},vStep,fine,{tool};", f"    SyncMoveOn {WAIT_AT_START}{stem},{TASK_LIST}{stem};"]
    for row, label in enumerate(labels):
        if row > 0:
            zone = "fine" if row in (program.arc_on, program.arc_off, len(labels) - 1) else "z1"
            seconds = f"{program.seconds[row - 1]:.{SECOND_DECIMALS}f}"
            lines.append(f"    MoveAbsJ {label}\\ID:={program.marks[row]},vStep\\T:={seconds},{zone},{tool};")
        lines += ["    ! ARC ON"] if row == program.arc_on else []
        lines += ["    ! ARC OFF"] if row == program.arc_off else []
    return [*lines, f"    SyncMoveOff {WAIT_AT_END}{stem};"]
