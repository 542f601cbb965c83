"""FANUC TP as ASCII (``.ls``): one program per seam and one that calls them all.

W, P, R in degrees with ``R = Rz(R) Ry(P) Rx(W)``; lengths in mm. `wpcal.controllers.language.jobs` explains the user
frame and the configuration.

References: FANUC, R-30iB HandlingTool Operator's Manual (position data, user frames, remarks of 32 characters).
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from functools import partial

import numpy as np

from wpcal.controllers.fanuc.arc import tp_arc_off, tp_arc_on
from wpcal.controllers.fanuc.configuration import config
from wpcal.controllers.language.emit import Around
from wpcal.controllers.language.jobs import ConfigurationRule, JobLanguage, JobWriter
from wpcal.controllers.language.naming import NameRules, comment_lines
from wpcal.controllers.language.rounding import rounded, texts, zyx_degrees
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe_path
from wpcal.controllers.program.planned import JointMoves
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm

NAMES = NameRules("FANUC", 32, "aux com1 com2 con lpt1 lpt2 nul prn")
"""Names of programs have up to 36 characters. A file must not have the name of a device of the controller."""
DECIMALS = 3  #: As the controller prints mm and degrees.
LONGEST_REMARK = 32
MOST_LINES = 9999  #: Line numbers have four digits.
CONFIGURATION = ConfigurationRule(
    format_name="fanuc",
    word="CONFIG",
    pattern=re.compile(r"[NF] ?[LR]? ?[UD] ?[TB], ?-?\d+, ?-?\d+, ?-?\d+"),
    expected="it as the pendant shows it, as N U T, 0, 0, 0",
    example="N U T, 0, 0, 0",
    compute=config,
)
"""For example N U T, 0, 0, 0: flip, (left, right,) up, front, and the turns of three joints."""
ZONE_MM = 1.0  #: About how far from a corner CNT100 leaves the path at a weld speed: the way that it brakes in.
ONE_GROUP, TWO_GROUPS = "1,*,*,*,*", "1,1,*,*,*"  #: Which groups a program moves.
JOINT_PERCENT = 10  #: The speed of the first move to a seam. Slow, because the arm can come from anywhere.
LANGUAGE = JobLanguage(
    names=NAMES,
    suffix=".ls",
    job_word="program",
    mm_decimals=DECIMALS,
    deg_decimals=DECIMALS,
    frame_word="UFRAME",
    frame_keys=("X", "Y", "Z", "W", "P", "R"),
    rotation="R = Rz(R) Ry(P) Rx(W)",
    configuration=CONFIGURATION,
    coordinated="COORD: set up coordinated motion, group 2 leads",
    lines_to_joints=True,
    sets_frame="sets",
)
Body = tuple[str, ...]  #: The lines of a position of group 1.


def write_fanuc(program: WeldProgram) -> dict[str, str]:
    """Write TP programs: ``NAME.ls`` and one file per seam.

    Raises `InputError` when a seam has too many points, TP cannot write a speed, or the configuration is missing or not
    a CONFIG. In a plan, when the arm's file does not say how J3 counts.
    """
    require_coupling(program.arm if program.planned is not None else None)
    return _Tp(program).files()


def require_coupling(arm: Arm | None) -> None:
    """Refuse an arm whose file does not say how J3 counts."""
    if arm is not None and not arm.couplings:
        raise InputError(
            "FANUC shows J3 against the horizontal: the arm's file needs a coupling of J3 to J2 with factor 1 "
            '("couplings"), and limits of J3 as the pendant shows it'
        )


def tp_file(name: str, instructions: list[str], positions: list[str], *, groups: str = ONE_GROUP) -> str:
    """Return the text of a TP program of lines; `name` is upper case, `groups` are those that it moves."""
    if len(instructions) > MOST_LINES:
        raise InputError(f"FANUC: {name} needs {len(instructions)} lines, a program has at most {MOST_LINES}")
    lines = [
        f"/PROG  {name}",
        "/ATTR",
        "OWNER = MNEDITOR;",
        'COMMENT = "wpcal";',
        f"LINE_COUNT = {len(instructions)};",
        "PROTECT = READ_WRITE;",
        "TCD:  STACK_SIZE = 0, TASK_PRIORITY = 50, TIME_SLICE = 0,",
        "      BUSY_LAMP_OFF = 0, ABORT_REQUEST = 0, PAUSE_REQUEST = 0;",
        f"DEFAULT_GROUP = {groups};",
        "CONTROL_CODE = 00000000 00000000;",
        "/MN",
        *(f"{number:4d}:{text} ;" for number, text in enumerate(instructions, start=1)),
        "/POS",
        *positions,
        "/END",
        "",
    ]
    return "\r\n".join(lines)


def remark_lines(lines: Sequence[str], mark: str = "") -> list[str]:
    """Return remarks: lines of at most 32 characters without a semicolon, which ends an instruction."""
    return comment_lines([line.replace(";", ",") for line in lines], mark=mark, longest=LONGEST_REMARK)


def tp_speed(mm_s: float) -> str:
    """Write a speed; TP has whole mm/sec and whole cm/min."""
    for value, unit in ((mm_s, "mm/sec"), (mm_s * 6.0, "cm/min")):
        if value >= 1 and abs(value - round(value)) < 1e-6:  # a rest below that is round-off of the factor 6
            return f"{round(value)}{unit}"
    nearest = max(round(mm_s * 6.0), 1) / 6.0
    raise InputError(f"FANUC: {mm_s:g} mm/s is neither whole mm/s nor whole cm/min; the nearest is {nearest:.4g} mm/s")


def tp_speed_down(mm_s: float, least: int = 0) -> str:
    """Write a speed, rounded down to whole cm/min: no joint has to be faster than planned."""
    return tp_speed(max(math.floor(mm_s * 6.0 + 1e-6), least) / 6.0)


def numbered(bodies: Sequence[Sequence[str]]) -> list[str]:
    """Return the section of positions, P[1] first, from the lines of each."""
    return [line for number, body in enumerate(bodies, start=1) for line in (f"P[{number}]{{", "   GP1:", *body, "};")]


def pose_bodies(head: str, confs: Sequence[str], p: FloatArray, R: FloatArray) -> list[Body]:
    """Return the lines of positions that are poses. `p`, `R`: shapes (n, 3) and (n, 3, 3), in any one frame, mm."""
    rows = zip(rounded(p, DECIMALS).tolist(), zyx_degrees(R, decimals=DECIMALS).tolist(), confs, strict=True)
    return [
        (
            f"{head}\t\tCONFIG : '{conf}',",
            ",".join(f"\t{key} = {v:9.{DECIMALS}f}  mm" for key, v in zip("XYZ", at, strict=True)) + ",",
            ",".join(f"\t{key} = {v:9.{DECIMALS}f} deg" for key, v in zip("WPR", turn, strict=True)),
        )
        for at, turn, conf in rows
    ]


def joint_bodies(head: str, joints: FloatArray) -> list[Body]:
    """Return the lines of positions that are joints; `head` names frame and tool, joints have shape (n, 6), rad."""
    rows = [
        [f"\tJ{number}= {v} deg" for number, v in enumerate(row, start=1)]
        for row in texts(np.degrees(joints), DECIMALS)
    ]
    return [(head, f"{','.join(row[:3])},", ",".join(row[3:])) for row in rows]


FRAME_REGISTER = 51  #: The position register by which a program sets its user frame, as touch programs do by default.


def set_frame(number: int, register: int, T: RigidTransform, *, what: str = "UFRAME") -> list[str]:
    """Return what sets a user frame or a tool: X Y Z W P R, mm and deg. LPOS makes the register one of six numbers."""
    values = [*T.t_mm.tolist(), *zyx_degrees(T.R, decimals=DECIMALS).tolist()]
    texts = [f"({v:.{DECIMALS}f})" if v < 0.0 else f"{v:.{DECIMALS}f}" for v in values]  # TP wants brackets
    return [
        f"  PR[{register}]=LPOS",
        *(f"  PR[{register},{row}]={text}" for row, text in enumerate(texts, 1)),
        f"  {what}[{number}]=PR[{register}]",
    ]


class _Tp(JobWriter):
    format, names, longest_comment, zone_mm, language = "fanuc", NAMES, LONGEST_REMARK, ZONE_MM, LANGUAGE
    sets_tool = True
    first = f"{JOINT_PERCENT}%"

    def __init__(self, program: WeldProgram) -> None:
        super().__init__(program)
        controller = program.controller
        self.head = f"\tUF : {controller.frame_number}, UT : {controller.tool_number},"
        self.frame = [f"  UFRAME_NUM={controller.frame_number}", f"  UTOOL_NUM={controller.tool_number}"]
        own, tool = list[str](), program.tool_data
        if tool is not None:
            own = [*set_frame(controller.tool_number, FRAME_REGISTER, tool, what="UTOOL"), self.frame[1]]
        if controller.frame_number and not self.in_joints:
            own += set_frame(controller.frame_number, FRAME_REGISTER, self.T_base_frame)
        self.start = [self.frame[1], *own, self.frame[0]]
        self.groups = TWO_GROUPS if self.planned is not None and self.planned.turning else ONE_GROUP

    def _frame_in_words(self) -> list[str]:
        by = [f"by PR[{FRAME_REGISTER}], which it overwrites"] if self.program.controller.frame_number else []
        return [*super()._frame_in_words(), *by]

    speed_of = staticmethod(tp_speed)

    def remarks(self, lines: Sequence[str]) -> list[str]:
        return remark_lines(lines)

    def main_job(
        self, name: str, header: list[str], calls: Sequence[str], air: Sequence[JointMoves] | None = None
    ) -> str:
        lines, positions, safe = [f"  CALL {called}" for called in calls], list[str](), self.program.safe_point
        if air is not None:
            lines, moves = self.planned_calls(air, lines)
            lines = [*self.start, *lines]
            positions = numbered(self._with_axes(joint_bodies(self.head, moves.joints), moves.external))
        elif safe is None:
            lines = [*self.start, *lines]
        if safe is not None:
            first = self.post.air_move("P[1]", speed=self.first, joint=True)
            lines = [*self.start, *first, *lines, *self.frame, *self.air_moves(["P[1]"])]
            positions = numbered(self._bodies(safe))
        return tp_file(name, [*header, *self.run(lines), *self.post.footer()], positions, groups=self.groups)

    def seam_job(self, name: str, path: WeldPath) -> str:
        if self.planned is None or path.joints is None or path.external is None:
            bodies = self._bodies(path)
        else:  # a plan goes to joints before a seam
            in_joints = len(path) if self.in_joints else path.before
            bodies = joint_bodies(self.head, path.joints[:in_joints])
            bodies += [] if self.in_joints else self._bodies(path)[in_joints:]
            bodies = self._with_axes(bodies, path.external)
        start = partial(tp_arc_on, path, self.program.weld_speed_mm_s(path))
        points = [f"P[{number}]" for number in range(1, len(path) + 1)]
        moves = [
            *remark_lines([path.seam.name, describe_path(path)], mark="  !"),
            *self.frame,
            *([] if self.planned is None else self.joint_move(1)),
            *self.seam(path, points, Around(start, partial(tp_arc_off, path))),
        ]
        return tp_file(name, moves, numbered(bodies), groups=self.groups)

    def joint_move(self, number: int) -> list[str]:
        percent = 0.0 if self.planned is None else self.planned.joint_percent
        return self.post.joint_move(f"P[{number}]", speed=f"{percent:.0f}%")

    def weld_move(self, path: WeldPath, via: str, to: str, *, stops: bool, is_last: bool) -> list[str]:
        coordinated = " COORD" if path.turns_along else ""
        end = f"{to} {self._weld_speed(path)} {'FINE' if stops else 'CNT100'}{coordinated}"
        # the end of a circular move is on a line of its own, without a number
        return [f"C {via}\r\n    :  {end}" if via else f"L {end}"]

    def _weld_speed(self, path: WeldPath) -> str:
        """Write the speed along a seam. That of weld data is rounded to whole cm/min: a rule does not know TP."""
        mm_s = self.program.weld_speed_mm_s(path)
        if path.speed_mm_s is not None:
            return tp_speed_down(mm_s, 1)
        return tp_speed(mm_s if path.run is None else max(round(mm_s * 6.0), 1) / 6.0)

    def _bodies(self, poses: WeldPath | SafePoint) -> list[Body]:
        confs = CONFIGURATION.texts(self.program, poses)
        return pose_bodies(self.head, confs, *poses.poses_in(self.T_base_frame))

    def _with_axes(self, bodies: Sequence[Body], external: FloatArray) -> list[Body]:
        """Add the external axes: a rail is the extended axis E1 of the arm's group, a positioner is group 2."""
        planned, found = self.planned, list[Body]()
        if planned is None:
            return list(bodies)
        rails = int(planned.rail is not None)
        for body, axes in zip(bodies, planned.external_texts(external, DECIMALS), strict=True):
            with_rail = (*body[:-1], f"{body[-1]},", f"\tE1= {axes[0]}  mm") if rails else body
            turned = ",".join(f"\tJ{number}= {value} deg" for number, value in enumerate(axes[rails:], start=1))
            found.append((*with_rail, "   GP2:", self.head, turned) if turned else with_rail)
        return found
