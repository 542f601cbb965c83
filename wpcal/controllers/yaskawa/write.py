"""Yaskawa INFORM (``.jbi``): one job per seam and one that calls them all.

Rx, Ry, Rz in degrees with ``R = Rz(Rz) Ry(Ry) Rx(Rx)``; lengths in mm. Positions are Cartesian, not pulses.
`wpcal.controllers.language.jobs` explains the user frame and the configuration.

References: Yaskawa, DX200 / YRC1000 Options: Instructions for Data Transmission Function (job data format: NPOS,
POSTYPE, RCONF).
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from functools import partial

import numpy as np

from wpcal.controllers.language.emit import Around
from wpcal.controllers.language.jobs import ConfigurationRule, JobLanguage, JobWriter
from wpcal.controllers.language.naming import NameRules
from wpcal.controllers.language.rounding import texts, zyx_degrees
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe_path
from wpcal.controllers.program.planned import JointMoves
from wpcal.controllers.yaskawa.arc import inform_arc_off, inform_arc_on
from wpcal.controllers.yaskawa.configuration import rconf
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.moves import Arc

NAMES = NameRules("INFORM", 32)  #: Names of jobs have up to 32 characters.
MM_DECIMALS = 3
DEG_DECIMALS = 4  #: What the controller writes into its own jobs.
LONGEST_COMMENT = 32
MOST_LINES = 9999  #: The lines of a job. It can have as many positions.
CONFIGURATION = ConfigurationRule(
    format_name="inform",
    word="RCONF",
    pattern=re.compile(r"\d+(?:,\d+)+"),
    expected="numbers with commas, as RCONF of a job has them",
    example="1,0,0,0,0,0,0,0",
    complete=rconf,
)
STOPS, FLOWS = " PL=0", " PL=1"
"""Position levels; without one the controller takes its own. Level 1 leaves the path the least of those that flow."""
ZONE_MM = 1.0  #: About how far from a corner level 1 leaves the path at a weld speed.
JOINT_PERCENT = 5.0  #: The speed of the first move to a seam. Slow, because the arm can come from anywhere.
FIRST = f"VJ={JOINT_PERCENT:.2f}"
NO_DATE = "2000/01/01 00:00"  #: A job must have a date; the same input gives the same bytes.
LANGUAGE = JobLanguage(
    names=NAMES,
    suffix=".jbi",
    job_word="job",
    mm_decimals=MM_DECIMALS,
    deg_decimals=DEG_DECIMALS,
    frame_word="USER",
    frame_keys=("X", "Y", "Z", "Rx", "Ry", "Rz"),
    rotation="R = Rz(Rz) Ry(Ry) Rx(Rx)",
    configuration=CONFIGURATION,
    coordinated="SMOVL, SMOVC: calibrate ST1 to RB1 (master: ST1)",
    plans_in_joints=True,
)


def write_inform(program: WeldProgram) -> dict[str, str]:
    """Write INFORM jobs: ``NAME.jbi`` and one file per seam.

    Raises `InputError` when a seam has too many points, INFORM cannot write a speed, or the configuration is missing or
    not an RCONF.
    """
    return _Inform(program).files()


def inform_job(
    name: str,
    positions: list[str],
    instructions: list[str],
    *,
    group: str | None = "RB1",
    user: int | None = None,
    station: str | None = None,
) -> str:
    """Return the text of a job."""
    if len(instructions) + 2 > MOST_LINES:
        raise InputError(f"INFORM: {name} needs {len(instructions) + 2} lines, a job has at most {MOST_LINES}")
    count, base, outer = (sum(line.startswith(mark) for line in positions) for mark in ("C", "BC", "EC"))
    lines = [
        "/JOB",
        f"//NAME {name}",
        "//POS",
        f"///NPOS {count},{base},{outer},0,0,0",
        *positions,
        "//INST",
        f"///DATE {NO_DATE}",
        *(["///ATTR SC,RW"] if user is None else ["///ATTR SC,RW,RJ", f"////FRAME USER {user}"]),
        *([] if group is None else [f"///GROUP1 {group}"]),
        *([] if station is None else [f"///GROUP2 {station}"]),
        "NOP",
        *instructions,
        "END",
        "",
    ]
    return "\r\n".join(lines)


def inform_speed(mm_s: float) -> str:
    """Write a speed; INFORM has steps of 0.1 mm/s."""
    if mm_s < 0.1 or abs(mm_s - round(mm_s, 1)) > 1e-9:  # a rest below that is round-off of the decimal
        raise InputError(f"INFORM: {mm_s:g} mm/s is not a multiple of 0.1 mm/s")
    return f"V={mm_s:.1f}"


def user_positions(user: int, tool: int, confs: Sequence[str], p: FloatArray, R: FloatArray) -> list[str]:
    """Return positions C00000, C00001, … in a user frame; an RCONF stands where it changes.

    `p`, `R`: shapes (n, 3) and (n, 3, 3), in the user frame, mm.
    """
    lines, before = [f"///USER {user}", f"///TOOL {tool}", "///POSTYPE USER", "///RECTAN"], None
    rows = zip(confs, texts(p, MM_DECIMALS), texts(zyx_degrees(R, decimals=DEG_DECIMALS), DEG_DECIMALS), strict=True)
    for number, (conf, at, turn) in enumerate(rows):
        lines += [f"///RCONF {conf}"] if conf != before else []
        lines.append(f"C{number:05d}={','.join([*at, *turn])}")
        before = conf
    return lines


def joint_kind(*arms: Arm | None) -> str:
    """Return how joints are written: ``PULSE`` if every arm states its pulses per degree, otherwise ``ANGLE``."""
    known = all(arm is not None and all(joint.pulses_per_deg is not None for joint in arm.joints) for arm in arms)
    return "PULSE" if known else "ANGLE"


def joint_rows(joints: FloatArray, arm: Arm | None, kind: str) -> list[str]:
    """Return positions in joints as a job has them: shown angles of shape (n, 6), rad; `kind` as of `joint_kind`."""
    if arm is not None and kind == "PULSE":
        return [",".join(f"{v:.0f}" for v in row) for row in arm.pulses_from_angles(joints)]
    return [",".join(row) for row in texts(np.degrees(joints), DEG_DECIMALS)]


def joint_positions(tool: int, kind: str, rows: Sequence[str]) -> list[str]:
    """Return positions C00000, C00001, … in joints."""
    head = [f"///TOOL {tool}", f"///POSTYPE {kind}", f"///{kind}"]
    return [*head, *(f"C{number:05d}={row}" for number, row in enumerate(rows))]


class _Inform(JobWriter):
    format, names, longest_comment, zone_mm, language = "inform", NAMES, LONGEST_COMMENT, ZONE_MM, LANGUAGE
    first = FIRST

    speed_of = staticmethod(inform_speed)

    @property
    def user(self) -> int:
        return self.program.controller.frame_number

    def main_job(
        self, name: str, header: list[str], calls: Sequence[str], air: Sequence[JointMoves] | None = None
    ) -> str:
        lines, footer, safe = [f"CALL JOB:{called}" for called in calls], self.post.footer(), self.program.safe_point
        if air is not None:
            lines, moves = self.planned_calls(air, lines)
            return self._planned_job(name, moves, [*header, *self.run(lines), *footer])
        if safe is None:
            return inform_job(name, [], [*header, *self.run(lines), *footer])
        first = self.post.air_move("C00000", speed=FIRST, joint=True)
        instructions = [*header, *self.run([*first, *lines, *self.air_moves(["C00000"])]), *footer]
        return inform_job(name, self._positions(safe), instructions, user=self.user)

    def seam_job(self, name: str, path: WeldPath) -> str:
        arc = Around(partial(inform_arc_on, path), partial(inform_arc_off, path))
        moves = [
            *self.comments([path.seam.name, describe_path(path)], mark="'"),
            *([] if self.planned is None else self.joint_move(1)),
            *self.seam(path, [self._point(number) for number in range(len(path))], arc),
        ]
        if self.planned is not None and path.joints is not None and path.external is not None:
            return self._planned_job(name, JointMoves(path.joints, path.external), moves)
        return inform_job(name, self._positions(path), moves, user=self.user)

    def _positions(self, poses: WeldPath | SafePoint) -> list[str]:
        confs, tool = CONFIGURATION.texts(self.program, poses), self.program.controller.tool_number
        return user_positions(self.user, tool, confs, *poses.poses_in(self.T_base_frame))

    def _planned_job(self, name: str, moves: JointMoves, instructions: list[str]) -> str:
        """Return a job whose positions are joints, so that the form of the arm is fixed."""
        planned = self.planned
        if self.program.arm is None or planned is None:
            return inform_job(name, [], instructions)
        outer, rails = planned.external_texts(moves.external, DEG_DECIMALS), int(planned.rail is not None)
        arm = None if planned.axis_count else self.program.arm
        kind = joint_kind(arm)
        positions = [
            *joint_positions(self.program.controller.tool_number, kind, joint_rows(moves.joints, arm, kind)),
            *(f"BC{number:05d}={row[0]}" for number, row in enumerate(outer) if rails),
            *(f"EC{number:05d}={','.join(row[rails:])}" for number, row in enumerate(outer) if planned.turning),
        ]
        group, station = "RB1,BS1" if rails else "RB1", "ST1" if planned.turning else None
        return inform_job(name, positions, instructions, group=group, station=station)

    def joint_move(self, number: int) -> list[str]:
        percent = 0.0 if self.planned is None else self.planned.joint_percent
        return self.post.joint_move(self._point(number - 1), speed=f"VJ={percent:.2f}")

    def _point(self, number: int, *, station: bool = True) -> str:
        """Return a position as a move names it, with its external axes, those of the positioner if `station`."""
        marks = ["C"]
        if self.planned is not None:
            marks += ["BC"] * (self.planned.rail is not None) + ["EC"] * (station and bool(self.planned.turning))
        return " ".join(f"{mark}{number:05d}" for mark in marks)

    def weld_moves(self, path: WeldPath, along: Sequence[str]) -> list[str]:
        """Return the moves along the seam.

        An arc has three MOVC, the first at its start. Between two arcs a MOVL to the point where they meet tells that
        the second is another circle.
        """
        mm_s = self.program.weld_speed_mm_s(path)
        if path.speed_mm_s is not None:
            mm_s = max(math.floor(mm_s * 10.0 + 1e-6), 1) / 10.0  # no joint has to be faster than planned
        speed = inform_speed(mm_s if path.run is None else max(round(mm_s, 1), 0.1))  # a rule does not know INFORM
        first = path.weld_rows.start
        lines, at, level, follows_arc = list[str](), first, STOPS, False
        for move, stops in zip(path.weld_moves, path.stops(ZONE_MM), strict=True):
            to, is_arc = first + move.to, isinstance(move, Arc)
            if isinstance(move, Arc):
                lines += [self._weld_move(path, "L", at, speed + level)] if follows_arc else []
                lines.append(self._weld_move(path, "C", at, speed + level))
                lines.append(self._weld_move(path, "C", first + move.via, speed + FLOWS))
            at, level, follows_arc = to, STOPS if stops else FLOWS, is_arc
            lines.append(self._weld_move(path, "C" if is_arc else "L", at, speed + level))
        return lines

    def _weld_move(self, path: WeldPath, kind: str, number: int, speed: str) -> str:
        """Return a move along a seam: coordinated with the positioner, the master, where this turns."""
        if not path.turns_along:
            return f"MOV{kind} {self._point(number)} {speed}"
        return f"SMOV{kind} {self._point(number, station=False)} {speed}  +MOVJ EC{number:05d}"
