r"""ABB RAPID: one module with the work object of the calibrated part, the targets, and one procedure per seam.

Quaternions are written q1 to q4 = w, x, y, z; lengths in mm. Targets are relative to the work object, which is the part
frame as calibrated. `confdata` is computed where the arm's joints are known (`wpcal.controllers.abb.configuration`).
Otherwise it is written as zeros and not used: ``ConfJ\Off`` and ``ConfL\Off`` let the controller choose the
configuration nearest to the present one.

References: ABB, Technical reference manual: RAPID Instructions, Functions and Data types (robtarget, wobjdata,
confdata, ConfL, CirPathMode; MoveC, which uses no orientation of the middle, and refuses points nearer than 0.1 mm, a
middle less than a degree beside the end seen from the start, and 240 degrees).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wpcal.controllers.abb.arc import ArcData, arc_data
from wpcal.controllers.abb.configuration import confdata
from wpcal.controllers.language.emit import Around, WeldWriter
from wpcal.controllers.language.naming import NameRules, own_name, reserved_words, safe_name, safe_names
from wpcal.controllers.language.rounding import rounded, texts
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import part_frame
from wpcal.controllers.program.planned import ALONE
from wpcal.core.arrays import FloatArray
from wpcal.core.rotations import quaternion_from_rotation, rotation_from_quaternion
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.inverse import Posture

NAMES = NameRules("RAPID", 32, reserved_words(__file__))  #: Identifiers have up to 32 characters.
MM_DECIMALS = 5  #: A controller keeps 32-bit numbers: 1e-4 mm at 2 m. One more digit loses nothing.
QUATERNION_DECIMALS = 9  #: 1e-9 turns a point at 2 m by 4e-6 mm; the controller normalises what it reads.
DEG_DECIMALS = 5  #: Joints: 1.5e-5 degrees at 180 degrees is what a 32-bit number resolves.
LONGEST_COMMENT = 72  #: Old controllers cut source lines at 80 characters.
EXTERNAL_AXES = 6
NO_AXIS = "9E+09"  #: The robot does not have this external axis.
NO_EXTERNAL_AXES = f"[{','.join([NO_AXIS] * EXTERNAL_AXES)}]"
UNIT = "STN1"  #: The usual name of a positioner as a mechanical unit.
JOINT_TARGET = "wpJ"  #: The name of a joint target of a plan is this and its number.
PROCEDURE = "weld_"  #: The name of a procedure is this and the name of its seam.
SAFE_POINT = "wpSafe"  #: The target above the part at which the program starts and ends.
JOINT_SPEED = "v100"
"""The speed of the only joint move, that to the safe point: slow, because the arm can come from anywhere."""
OFF, ON = (tuple(f"    Conf{kind}\\{state};" for kind in "JL") for state in ("Off", "On"))
"""On as a controller starts; a caller of a procedure gets it back."""
CIRCLE, USUAL_CIRCLE = ("    CirPathMode\\ObjectFrame;",), ("    CirPathMode\\PathFrame;",)
"""On arcs the tool turns about one axis, and not with the tangent, as a controller starts."""
ZONE_MM = 1.0  #: The size of z1.
TURN_DEG_S = 500  #: As in the predefined speeds: rotation never limits the speed along a seam.


def speed_data(name: str, mm_s: float, deg_s: float = TURN_DEG_S) -> str:
    """Declare a speed."""
    return f"  LOCAL CONST speeddata {name}:=[{mm_s:g},{deg_s},{mm_s:g},{deg_s}];"


def zone_data(name: str, mm: float) -> str:
    """Declare a zone: the tool centre point, turns and external axes leave the path at the same distance."""
    return f"  LOCAL CONST zonedata {name}:=[FALSE,{mm:g},{mm:g},{mm:g},{mm / 10:g},{mm:g},{mm / 10:g}];"


def _zone(mm: float) -> str:
    return f"wpZ{mm:g}".replace(".", "_")


def rapid_frame(T: RigidTransform) -> tuple[str, RigidTransform]:
    """Return the frame's text and the frame with these digits: its rounding then does not move targets in the base."""
    q = rounded(quaternion_from_rotation(T.R), QUATERNION_DECIMALS)
    written = RigidTransform(rotation_from_quaternion(q), rounded(T.t_mm, MM_DECIMALS), T.target, T.source)
    return _pose_texts(T.t_mm[None], q[None])[0], written


def pose_texts(p: FloatArray, R: FloatArray) -> list[str]:
    """Return poses as ``[x,y,z],[q1,q2,q3,q4]``: p of shape (n, 3), mm, and R of shape (n, 3, 3), in any one frame."""
    return _pose_texts(p, quaternion_from_rotation(R))


def _pose_texts(p: FloatArray, q_xyzw: FloatArray) -> list[str]:
    turns = texts(np.roll(q_xyzw, 1, axis=1), QUATERNION_DECIMALS)
    return [f"[{','.join(at)}],[{','.join(q)}]" for at, q in zip(texts(p, MM_DECIMALS), turns, strict=True)]


def robtargets(
    labels: Sequence[str], p: FloatArray, R: FloatArray, forms: Posture | None, external: Sequence[str] | None = None
) -> list[str]:
    """Declare targets: p of shape (n, 3), mm, and R of shape (n, 3, 3), in the work object; `external` as texts."""
    confs = ["[0,0,0,0]"] * len(p) if forms is None else confdata(forms)
    rows = zip(labels, pose_texts(p, R), confs, external or [NO_EXTERNAL_AXES] * len(p), strict=True)
    return [f"  LOCAL CONST robtarget {label}:=[{text},{conf},{axes}];" for label, text, conf, axes in rows]


def jointtargets(labels: Sequence[str], joints: FloatArray, external: Sequence[str] | None = None) -> list[str]:
    """Declare joint targets: shown angles of shape (n, 6), rad."""
    rows = zip(
        labels, texts(np.degrees(joints), DEG_DECIMALS), external or [NO_EXTERNAL_AXES] * len(joints), strict=True
    )
    return [f"  LOCAL CONST jointtarget {label}:=[[{','.join(row)}],{axes}];" for label, row, axes in rows]


def _external(axes: list[str]) -> str:
    return f"[{','.join([*axes, *[NO_AXIS] * (EXTERNAL_AXES - len(axes))])}]"


class _Rapid(WeldWriter):
    format, names, longest_comment, zone_mm = "rapid", NAMES, LONGEST_COMMENT, ZONE_MM
    starts_in_air, sets_tool = False, True
    air = "vAir"

    def __init__(self, program: WeldProgram) -> None:
        super().__init__(program)
        self.frame, self.T_base_frame = rapid_frame(program.T_base_part)
        room = max(program.label_width + 1, len(PROCEDURE))
        self.stems = safe_names([path.seam.name for path in program.paths], NAMES, room=room)
        self.follows = self.planned is not None and self.planned.follows
        self.arcs = {name: self._arc(path) for name, path in zip(self.stems, program.paths, strict=True)}

    def _arc(self, path: WeldPath) -> ArcData | None:
        if self.program.arc is None:
            return None
        return arc_data(path, self.stems[path.seam.name], self.program.weld_speed_mm_s(path), NAMES)

    def files(self) -> dict[str, str]:
        program = self.program
        module = safe_name(program.controller.program_name, NAMES)
        head = [f"MODULE {module}", *self.post.header(self._about()), *self._data()]
        self.tool = own_name(program.controller.tool_name, NAMES, what="tool")
        off, on = ((), ()) if program.arm is not None else (OFF, ON)
        between, calls, procedures = self.between(), self._tool_lines(), list[str]()
        if self.follows:
            calls.append(f"    ActUnit {UNIT};")
        for (before, last), path in zip(between, program.paths, strict=False):
            name = f"{PROCEDURE}{self.stems[path.seam.name]}"
            mode, usual = (CIRCLE, USUAL_CIRCLE) if path.has_arcs else ((), ())
            procedures += ["", f"  PROC {name}()", *off, *mode, *last, *self._seam(path), *usual, *on, "  ENDPROC"]
            calls += [*before, f"    {name};"]
        calls += between[-1][0]
        if program.safe_point is not None:
            first = self.post.air_move(SAFE_POINT, speed=JOINT_SPEED, joint=True)
            calls = [*off, *first, *calls, *off, *self.air_moves([SAFE_POINT]), *on]
        alone = [line for row, path in enumerate(program.paths) for line in self._alone(row, path)]
        main = [
            f"  PROC {safe_name(f'run_{module}', NAMES)}()",
            *self.run(calls),
            "  ENDPROC",
            *alone,
            *self.post.footer(),
            "",
        ]
        return {f"{module}.mod": "\r\n".join([*head, *procedures, *main])}

    def _alone(self, row: int, path: WeldPath) -> list[str]:
        """Return the procedure that welds one seam from home."""
        stem = self.stems[path.seam.name]
        lines = self.alone(row, [f"    {PROCEDURE}{stem};"])
        lines = [*self._tool_lines(), *lines] if lines else []
        unit = [f"    ActUnit {UNIT};"] if self.follows else []
        return ["", f"  PROC {ALONE}{stem}()", *self.run([*unit, *lines]), "  ENDPROC"] if lines else []

    def _tool_lines(self) -> list[str]:
        tool = self.program.tool_data
        return [] if tool is None else [f"    {self.tool}.tframe:=[{rapid_frame(tool)[0]}];"]

    def _about(self) -> list[str]:
        program = self.program
        text = [
            f"targets are relative to wpPart, {part_frame(program)}; mm; q1..q4 = w,x,y,z",
            f"written with {MM_DECIMALS} and {QUATERNION_DECIMALS} decimals: within 0.00001 mm and 0.000001 deg",
            "confdata is not known: ConfJ, ConfL \\Off let the controller choose, and are On again at the end"
            if program.arm is None
            else "confdata is computed from the joints; cfx is that of an arm without a parallel rod",
            *self._external_in_words(),
            "the tool must be declared on the controller; the arc burns from ARC ON to ARC OFF"
            if program.arc is None
            else "the tool, and data without sm_, wd_ and wv_, must be declared on the controller; wire feed in mm/s",
        ]
        return self.about(text)

    def _external_in_words(self) -> list[str]:
        planned = self.planned
        if planned is None or not planned.axis_count:
            return []
        names = [name for name in (planned.rail, *planned.turning) if name]
        eax = [f"eax_{chr(97 + row)} = {name}" for row, name in enumerate(names)]  # letters from a
        unit = f"the positioner turns along seams: it must be the mechanical unit {UNIT}, and coordinated"
        return [f"external axes: {', '.join(eax)}", *([unit] if planned.follows else [])]

    def _data(self) -> list[str]:
        """Declare the work object, speeds, data of arcs and targets."""
        program, zero = self.program, "[[0,0,0],[1,0,0,0]]"
        held = (
            f'[FALSE,FALSE,"{UNIT}",{zero},[{self.frame}]]'
            if self.follows
            else f'[FALSE,TRUE,"",[{self.frame}],{zero}]'
        )
        lines = [
            f"  PERS wobjdata wpPart:={held};",
            speed_data("vWeld", program.motion.speed_mm_s),
            speed_data("vAir", program.motion.air_speed_mm_s),
        ]
        lines += self._planned_data()
        for path in program.paths:
            if path.run is not None:  # a seam with weld data has its own speed and data of the arc
                arc = self.arcs[path.seam.name]
                lines.append(speed_data(self._speed(path), program.weld_speed_mm_s(path)))
                lines += () if arc is None else arc.declared
        if program.safe_point is not None:
            lines += self._targets([SAFE_POINT], program.safe_point)
        for path in program.paths:
            targets = self._targets(self.labels(path), path)
            lines += targets[0 if self.planned is None else path.before :]  # a plan goes to joints before a seam
        return lines

    def _planned_data(self) -> list[str]:
        """Declare speed, zones and targets of the joint moves of a plan."""
        planned = self.planned
        if planned is None:
            return []
        lines = [speed_data("vJoint", TURN_DEG_S)]  # a limit of the tip: the joints limit most of these moves
        lines += [zone_data(_zone(mm), mm) for mm in planned.zones_mm]
        for moves, numbers in planned.numbered():
            external = [_external(row) for row in planned.external_texts(moves.external, DEG_DECIMALS)]
            lines += jointtargets([f"{JOINT_TARGET}{number:04d}" for number in numbers], moves.joints, external)
        return lines

    def _targets(self, labels: list[str], poses: WeldPath | SafePoint) -> list[str]:
        external = None
        if self.planned is not None and isinstance(poses, WeldPath) and poses.external is not None:
            external = [_external(row) for row in self.planned.external_texts(poses.external, DEG_DECIMALS)]
        return robtargets(labels, *poses.poses_in(self.T_base_frame), self.program.posture_of(poses), external)

    def joint_move(self, number: int) -> list[str]:
        mm, _ = self.zone(number)
        return self.post.joint_move(f"{JOINT_TARGET}{number:04d}", speed="vJoint", zone=_zone(mm) if mm else "")

    def _speed(self, path: WeldPath) -> str:
        return "vWeld" if path.run is None else f"v_{self.stems[path.seam.name]}"

    def _seam(self, path: WeldPath) -> list[str]:
        arc = self.arcs[path.seam.name]
        names = {"speed": self._speed(path), "arc": "" if arc is None else arc.text}
        return self.seam(path, self.labels(path), Around(start=names))

    def weld_move(self, path: WeldPath, via: str, to: str, *, stops: bool, is_last: bool) -> list[str]:
        arc, word, zone = self.arcs[path.seam.name], "C" if via else "L", "fine" if stops else "z1"
        what, data = (f"Move{word}", "") if arc is None else (f"Arc{word}{'End' if is_last else ''}", f",{arc.text}")
        points = f"{via},{to}" if via else to
        return [f"    {what} {points},{self._speed(path)}{data},{zone},{self.tool}\\WObj:=wpPart;"]


write_rapid = _Rapid.written
