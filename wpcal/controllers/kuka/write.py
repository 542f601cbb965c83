"""KUKA KRL: a pair ``NAME.src`` and ``NAME.dat`` with the base of the calibrated part and the points along its seams.

Angles are A, B, C in degrees with ``R = Rz(A) Ry(B) Rx(C)``; lengths in mm. Points are relative to the frame
``WP_PART``, which the program makes ``$BASE``. Status and turn (S, T) are written where the arm's joints are known and
`wpcal.controllers.kuka.configuration` defines them. Otherwise they are left out: the controller ignores them for LIN
and keeps the present ones for PTP.

References: KUKA, System Software 8.x: Operating and Programming Instructions for System Integrators (E6POS, FRAME,
$BASE, S and T, orientation control for LIN and CIRC; the orientation of the middle of an arc is not used).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from wpcal.controllers.kuka.arc import LONGEST_PREFIX, SWITCH, fold_data, fold_moves, has_folds, how
from wpcal.controllers.kuka.configuration import status_and_turn
from wpcal.controllers.language.emit import WeldWriter
from wpcal.controllers.language.naming import NameRules, reserved_words, safe_name, safe_names
from wpcal.controllers.language.post import metres_per_second
from wpcal.controllers.language.rounding import rounded_frame, texts, zyx_degrees
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import part_frame
from wpcal.controllers.program.planned import ALONE
from wpcal.controllers.run.machine import WHOLE_ZONE
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.inverse import Posture

NAMES = NameRules("KRL", 24, reserved_words(__file__))
"""Names have up to 24 characters; wp_part is the frame of the part, wp_safe the safe point."""
MM_DECIMALS = 5  #: A controller keeps 32-bit numbers: 1e-4 mm at 2 m. One more digit loses nothing.
DEG_DECIMALS = 6  #: 1e-6 deg moves a point at 2 m by 4e-5 mm.
LONGEST_COMMENT = 76  #: Keeps lines on the pendant's screen.
SEAM = "WELD_"  #: The name of the routine of a seam of a plan is this and its name.
AXES = "WPJ"  #: The name of axes that a plan goes to is this and their number.
JOINT_PERCENT = 10  #: The speed of PTP moves. Slow, because the arm can come from anywhere.
CIRCLE = ("$ORI_TYPE=#VAR", "$CIRC_TYPE=#BASE")
"""On arcs the tool turns about one axis, and not with the tangent."""
BLEND_MM = 1.0  #: Distance from a corner at which LIN moves may leave it: the default least step of seams.
krl_frame = partial(rounded_frame, mm_decimals=MM_DECIMALS, deg_decimals=DEG_DECIMALS)
ATTRIBUTES = ("&ACCESS RVP", "&REL 1")  #: Visible to the programmer, first release.


def aggregates(p: FloatArray, R: FloatArray, known: Iterable[str] | None = None) -> list[str]:
    """Write poses as ``{X …,Y …,Z …,A …,B …,C …}``, and what is `known` of each.

    `p`, `R`: shapes (n, 3) and (n, 3, 3), in any one frame, mm.
    """
    turns = texts(zyx_degrees(R, decimals=DEG_DECIMALS)[..., ::-1], DEG_DECIMALS)
    rows = zip(texts(p, MM_DECIMALS), turns, known or [""] * len(p), strict=True)
    return [f"{{{_keyed('XYZABC', [*at, *turn])}{more}}}" for at, turn, more in rows]


def krl_frame_text(T: RigidTransform) -> str:
    """Write one frame."""
    return aggregates(T.t_mm[None], T.R[None])[0]


def axes_text(joints: FloatArray, external: Sequence[str] = ()) -> str:
    """Write shown angles, shape (6,), rad, and external axes."""
    (row,) = texts(np.degrees(joints)[None], DEG_DECIMALS)
    return f"{{{_keyed([f'A{axis}' for axis in range(1, 7)], row)}{_external(external)}}}"


def forms_of(postures: Sequence[Posture | None]) -> list[list[str]] | None:
    """Return S and T of every pose, as they follow its coordinates; None unless all of them are known."""
    try:
        known = [status_and_turn(each) for each in postures if each is not None]
    except InputError:
        return None
    if len(known) < len(postures):
        return None
    return [[f",S {status},T {turn}" for status, turn in each] for each in known]


def _keyed(keys: Iterable[str], values: Iterable[str]) -> str:
    return ",".join(f"{key} {value}" for key, value in zip(keys, values, strict=True))


def _external(axes: Sequence[str]) -> str:
    return "".join(f",E{number} {value}" for number, value in enumerate(axes, start=1))


class _Krl(WeldWriter):
    format, names, longest_comment, zone_mm = "krl", NAMES, LONGEST_COMMENT, BLEND_MM
    starts_in_air, sets_tool = False, True

    def __init__(self, program: WeldProgram) -> None:
        super().__init__(program)
        self.follows = self.planned is not None and self.planned.follows
        self.folds = any(has_folds(path, program) for path in program.paths)
        if self.folds and self.follows:
            raise InputError("KRL: the positioner turns along a seam, which ArcTech folds of a plan cannot state yet")
        room = program.label_width + 1 + (LONGEST_PREFIX if self.folds else 0)
        self.stems = safe_names([path.seam.name for path in program.paths], NAMES, room=room)
        self.T_base_frame = krl_frame(program.T_base_part)
        self.forms = forms_of([program.posture_of(poses) for poses in program.groups])

    speed_of = staticmethod(metres_per_second)

    @property
    def percent(self) -> float:
        return JOINT_PERCENT if self.planned is None else self.planned.joint_percent

    def files(self) -> dict[str, str]:
        program, name = self.program, safe_name(self.program.controller.program_name, NAMES)
        points = self._points()
        header = self.post.header(self._about())
        part = f"DECL {'GLOBAL ' if program.is_corrected else ''}FRAME WP_PART={krl_frame_text(self.T_base_frame)}"
        data = [*ATTRIBUTES, f"DEFDAT {name} PUBLIC", *header, part, *points, "ENDDAT", ""]
        source, between = [*ATTRIBUTES, f"DEF {name}()", *header, *self._start()], self.between()
        for (way, _), path in zip(between, program.paths, strict=False):
            source += [*way, *(self._seam(path) if self.planned is None else [self._call(path)])]
        source += between[-1][0]
        if program.safe_point is not None:
            source += ["; back to the safe point", *self.air_moves(["WP_SAFE"]), "PTP $H_POS"]
        alone = [line for row in range(len(between) - 1) for line in self._alone(row, between[row][1])]
        return {
            f"{name}.src": "\r\n".join([*source, *self.post.hook("after_run"), *self.post.footer(), *alone, ""]),
            f"{name}.dat": "\r\n".join(data),
        }

    def _call(self, path: WeldPath) -> str:
        return f"{SEAM}{self.stems[path.seam.name]}()"

    def _alone(self, row: int, last: Sequence[str]) -> list[str]:
        """Return the routine of a seam of a plan, and the one that welds it from home."""
        if self.planned is None:
            return []
        path = self.program.paths[row]
        seam = ["", f"DEF {self._call(path)}", *last, *self._seam(path), "END"]
        lines = self.alone(row, [self._call(path)])
        name = f"{ALONE.upper()}{self.stems[path.seam.name]}"
        alone = ["", f"GLOBAL DEF {name}()", *self._start(), *lines, *self.post.hook("after_run"), "END"]
        return [*seam, *(alone if lines else ())]

    def _points(self) -> list[str]:
        """Declare the axes that a plan goes to between seams, and the points."""
        lines = list[str]()
        if self.planned is not None:
            for moves, numbers in self.planned.numbered():
                outer = self.planned.external_texts(moves.external, DEG_DECIMALS)
                rows = zip(numbers, moves.joints, outer, strict=True)
                lines += [f"DECL E6AXIS {AXES}{number:04d}={axes_text(q, axes)}" for number, q, axes in rows]
        for row, poses in enumerate(self.program.groups):
            values = aggregates(*poses.poses_in(self.T_base_frame), self._known(row, poses))
            lines += self._along(poses, values) if isinstance(poses, WeldPath) else [f"DECL E6POS WP_SAFE={values[0]}"]
        return lines

    def _along(self, path: WeldPath, values: Sequence[str]) -> list[str]:
        """Declare the points of a seam, and what its folds need."""
        labels = self.labels(path)
        along = labels[path.weld_rows] if has_folds(path, self.program) else []
        names = [f"X{label}" if label in along else label for label in labels]
        points = [f"DECL E6POS {name}={value}" for name, value in zip(names, values, strict=True)]
        points = points[0 if self.planned is None else path.before :]  # a plan goes to axes before a seam
        return [*points, *fold_data(along, self.program, blend_mm=BLEND_MM)]

    def _known(self, row: int, poses: WeldPath | SafePoint) -> list[str]:
        """Return what follows the coordinates of poses: S and T, and external axes."""
        known = [""] * len(poses.p_base) if self.forms is None else self.forms[row]
        if self.planned is None or not isinstance(poses, WeldPath) or poses.external is None:
            return known
        outer = self.planned.external_texts(poses.external, DEG_DECIMALS)
        return [f"{form}{_external(axes)}" for form, axes in zip(known, outer, strict=True)]

    def _about(self) -> list[str]:
        program = self.program
        angles = [zyx_degrees(each.poses_in(self.T_base_frame)[1], decimals=DEG_DECIMALS) for each in program.paths]
        vertical = sum(int((abs(each[:, 1]) == 90.0).sum()) for each in angles)
        text = [
            f"points are relative to WP_PART, {part_frame(program)}; mm; R = Rz(A) Ry(B) Rx(C), deg",
            f"written with {MM_DECIMALS} and {DEG_DECIMALS} decimals: within 0.00001 mm and 0.000001 deg",
            forms_in_words(is_known=self.forms is not None),
            f"PTP moves run with {self.percent:.0f} % of the axes' speed",
            *self._frame_in_words(),
            *how(program.arc, folds=self.folds),
        ]
        if vertical:
            text.append(f"{vertical} points have B = +-90, where A and C turn about one axis: C was fixed at 0")
        return self.about(text)

    def _frame_in_words(self) -> list[str]:
        planned = self.planned
        jog = [f"BASE_DATA[{self.program.controller.frame_number}] becomes WP_PART too: jog in this base"]
        if planned is None or not planned.axis_count:
            return jog
        names = [name for name in (planned.rail, *planned.turning) if name]
        axes = ", ".join(f"E{row} = {name}" for row, name in enumerate(names, start=1))
        unit = "the positioner turns along seams: it must be the external kinematic MACHINE_DEF[2]"
        return [*([] if planned.turning else jog), f"external axes: {axes}", *([unit] if planned.follows else [])]

    def _start(self) -> list[str]:
        controller = self.program.controller
        turns, tool = self.planned is not None and self.planned.turning, self.program.tool_data
        return [
            "BAS(#INITMOV,0)",
            f"BAS(#VEL_PTP,{self.percent:.0f})",
            *(() if tool is None else (f"TOOL_DATA[{controller.tool_number}]={krl_frame_text(tool)}",)),
            f"$TOOL=TOOL_DATA[{controller.tool_number}]",
            *(() if turns else (f"BASE_DATA[{controller.frame_number}]=WP_PART",)),
            f"$BASE={'EK(MACHINE_DEF[2].ROOT,MACHINE_DEF[2].MECH_TYPE,WP_PART)' if self.follows else 'WP_PART'}",
            *self.post.hook("before_run"),
            "$IPO_MODE=#BASE",
            f"$APO.CDIS={BLEND_MM:g}",
            *(CIRCLE if any(path.has_arcs for path in self.program.paths) else ()),
            *(() if self.program.safe_point is None else ("PTP $H_POS", f"$VEL.CP={self.air}", "PTP WP_SAFE")),
        ]

    def joint_move(self, number: int) -> list[str]:
        percent = math.floor(100.0 * self.zone(number)[1] / WHOLE_ZONE)
        move = self.post.joint_move(f"{AXES}{number:04d}", speed="", zone=" C_PTP" if percent else "")
        return [*([f"$APO.CPTP={percent}"] if percent else []), *move]

    def _seam(self, path: WeldPath) -> list[str]:
        program, air, folds = self.program, f"$VEL.CP={self.air}", has_folds(path, self.program)
        around = replace(
            SWITCH.around(path, None if folds else program.arc),
            start={"speed": metres_per_second(program.weld_speed_mm_s(path)), "folds": folds},
            end={"folds": folds},
            after=[air],
        )
        return [f"; {self.stems[path.seam.name]}", air, *self.seam(path, self.labels(path), around)]

    def weld_moves(self, path: WeldPath, along: Sequence[str]) -> list[str]:
        if has_folds(path, self.program):
            return fold_moves(path, along, self.program, path.stops(BLEND_MM))
        return super().weld_moves(path, along)

    def weld_move(self, path: WeldPath, via: str, to: str, *, stops: bool, is_last: bool) -> list[str]:
        return [f"{f'CIRC {via},{to}' if via else f'LIN {to}'}{'' if stops else ' C_DIS'}"]


write_krl = _Krl.written


def forms_in_words(*, is_known: bool) -> str:
    """Say for a header where S and T come from."""
    if is_known:
        return "S and T are computed from the joints"
    return "S and T are not known and left out: LIN ignores them, PTP keeps the present ones"
