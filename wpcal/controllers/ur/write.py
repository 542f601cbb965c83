"""Universal Robots: one URScript program with the frame of the calibrated part and the poses along its seams.

A pose is ``p[x, y, z, rx, ry, rz]`` in metres with a rotation vector in rad. Poses are relative to ``wp_part`` and
transformed into the base by `pose_trans`. `movej` to a pose lets the controller choose the solution nearest to the
present one. The joint moves of a plan are `movej` to six joints in rad. They also give the arm its configuration on the
seams, as linear moves keep it. Mode 0 of an arc: the tool turns about one axis, and not with the tangent.

The language has no arc instructions: a digital output switches the arc, or two functions that the user has
(`arc_start`, `arc_end`); the power source's URCap or interface decides what happens.

References: Universal Robots, The URScript Programming Language (movej, movel, pose_trans, set_standard_digital_out,
sleep; movec: "pose_via: path point (note: only position is used)"; mode 0 turns from the current pose to the target
pose).
"""

from __future__ import annotations

import math

import numpy as np

from wpcal.controllers.language.emit import ArcSwitch, WeldWriter
from wpcal.controllers.language.naming import NameRules, safe_name
from wpcal.controllers.language.rounding import rounded, texts
from wpcal.controllers.program import WeldPath
from wpcal.controllers.program.describe import describe, describe_path, part_frame
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import exp_rotation, log_rotation
from wpcal.core.transform import RigidTransform

NAMES = NameRules(
    "URScript",
    60,
    "and arc_end arc_start break continue def elif else end false for global halt if local movec movej movel not or "
    "pose_trans return set_standard_digital_out set_tcp sleep thread true while wp_part",
)
"""The length is our choice; the language sets no limit. What programs call and set is reserved, too."""
DECIMALS = 9  #: 1e-9 m is 1e-6 mm; 1e-9 rad moves a point at 2 m by 2e-6 mm.
MM = 1e-3
BLEND_MM = 0.2  #: Blends of neighbours must not overlap: well below half of the default least step of seams (1 mm).
ACCELERATION_M_S2 = 0.5  #: Slow. A weld speed is reached within 0.1 mm.
JOINT_LIMITS = "a=0.3, v=0.1"  #: rad/s² and rad/s of the only joint move. Slow, because the arm can come from anywhere.
PLANNED_ACCELERATION_RAD_S2 = 0.8
"""In the joint moves of a plan: little more than half of what the controller takes if nothing is stated (1.4)."""
USUAL_JOINT_RAD_S = 2.0
"""Largest speed of a joint where the arm's file states none: that of the slowest joints of these arms is 2.09."""
LONGEST_COMMENT = 100
SWITCH = ArcSwitch(
    language="URScript",
    start="arc_start({job})",
    end="arc_end()",
    on="set_standard_digital_out({output}, True)",
    off="set_standard_digital_out({output}, False)",
    wait="sleep({seconds})",
    by_output="standard digital output {output} switches the arc",
    by_calls="arc_start(job) and arc_end() are functions that you load before this program",
)


def limits(mm_s: float) -> str:
    """Write acceleration and speed of a linear move."""
    return f"a={ACCELERATION_M_S2:g}, v={mm_s * MM:g}"


def script_frame(T: RigidTransform) -> RigidTransform:
    """Return the frame with the written digits: its rounding then does not move the poses in the base."""
    turn = rounded(log_rotation(T.R), DECIMALS)
    return RigidTransform(exp_rotation(turn), rounded(T.t_mm * MM, DECIMALS) / MM, T.target, T.source)


def poses_of(p: FloatArray, R: FloatArray) -> list[str]:
    """Write poses: p of shape (n, 3), mm, and R of shape (n, 3, 3), in any one frame."""
    return [f"p[{', '.join(row)}]" for row in texts(np.concatenate([p * MM, log_rotation(R)], axis=1), DECIMALS)]


def poses_in_part(p: FloatArray, R: FloatArray) -> list[str]:
    """Write poses in the part: p of shape (n, 3), mm, and R of shape (n, 3, 3)."""
    return [f"pose_trans(wp_part, {pose})" for pose in poses_of(p, R)]


class _Script(WeldWriter):
    format, names, longest_comment, zone_mm = "urscript", NAMES, LONGEST_COMMENT, BLEND_MM
    calls_seams, sets_tool = False, True
    first = JOINT_LIMITS

    speed_of = staticmethod(limits)

    def files(self) -> dict[str, str]:
        program, self.T_base_frame = self.program, script_frame(self.program.T_base_part)
        if self.planned is not None:
            self.joints = np.concatenate([moves.joints for moves in self.planned.air])
        name, between, tool = safe_name(program.controller.program_name, NAMES), self.between(), program.tool_data
        frame = poses_of(self.T_base_frame.t_mm[None], self.T_base_frame.R[None])[0]
        lines = [
            f"def {name}():",
            *self.post.header(self._about()),
            f"  wp_part = {frame}",
            *(() if tool is None else (f"  set_tcp({poses_of(tool.t_mm[None], tool.R[None])[0]})",)),
            *self.post.hook("before_run"),
        ]
        safe = [] if program.safe_point is None else poses_in_part(*program.safe_point.poses_in(self.T_base_frame))
        for point in safe:
            lines += self.post.air_move(point, speed=JOINT_LIMITS, joint=True)
        for (way, _), path in zip(between, program.paths, strict=False):
            points = poses_in_part(*path.poses_in(self.T_base_frame))
            head = self.comments([f"{path.seam.name}: {describe_path(path)}"], mark="  # ")
            lines += [*way, *head, *self.seam(path, points, SWITCH.around(path, program.arc))]
        return {
            f"{name}.script": "\n".join(
                [*lines, *between[-1][0], *self.air_moves(safe), *self.post.hook("after_run"), *self.post.footer(), ""]
            )
        }

    def _about(self) -> list[str]:
        program = self.program
        text = [
            *describe(program),
            *(self.planned.standing_axes("URScript") if self.planned is not None else ()),
            f"poses are relative to wp_part, {part_frame(program)}; m and rotation vectors in rad",
            f"written with {DECIMALS} decimals: within 0.000001 mm and 0.000001 deg",
            f"set the tool centre point before this program; {SWITCH.in_words(program.arc)}",
        ]
        return self.comments(text)

    def joint_move(self, number: int) -> list[str]:
        arm, percent = self.program.arm, 0.0 if self.planned is None else self.planned.joint_percent
        stated = [joint.speed_rad_s for joint in arm.joints if joint.speed_rad_s] if arm else []
        speed = min(stated, default=USUAL_JOINT_RAD_S) * percent / 100.0
        how = f"a={PLANNED_ACCELERATION_RAD_S2:g}, v={math.floor(1e3 * speed) / 1e3:g}"
        (row,) = texts(self.joints[number - 1][None], DECIMALS)
        mm, _ = self.zone(number)
        return self.post.joint_move(f"[{', '.join(row)}]", speed=how, zone=f", r={mm * MM:g}" if mm else "")

    def weld_move(self, path: WeldPath, via: str, to: str, *, stops: bool, is_last: bool) -> list[str]:
        how = f"{to}, {limits(self.program.weld_speed_mm_s(path))}{'' if stops else f', r={BLEND_MM * MM:g}'}"
        return [f"  movec({via}, {how}, mode=0)" if via else f"  movel({how})"]


write_urscript = _Script.written
