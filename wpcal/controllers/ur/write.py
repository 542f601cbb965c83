"""Universal Robots: one URScript program with the frame of the calibrated part and the poses along its seams.

A pose is ``p[x, y, z, rx, ry, rz]`` in metres with a rotation vector in rad. Poses are relative to ``wp_part`` and
transformed into the base by `pose_trans`. `movej` to a pose lets the controller choose the solution nearest to the
present one. The joint moves of a plan are `movej` to six joints in rad. They also give the arm its configuration on the
seams, as linear moves keep it.

References
----------
Universal Robots, The URScript Programming Language (movej, movel, pose_trans).
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from wpcal.controllers.language.naming import NameRules, comment_lines, safe_name
from wpcal.controllers.language.post import Post
from wpcal.controllers.language.rounding import rounded
from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe, describe_path, part_frame
from wpcal.controllers.ur.arc import SWITCH, how
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import exp_rotation, log_rotation
from wpcal.core.transform import RigidTransform
from wpcal.robot.moves import Arc

NAMES = NameRules(
    "URScript",
    60,
    "and break continue def elif else end false for global halt if local not or return thread true while",
)
"""The length is our choice; the language sets no limit."""
DECIMALS = 9
"""1e-9 m is 1e-6 mm; 1e-9 rad moves a point at 2 m by 2e-6 mm."""
MM = 1e-3
BLEND_MM = 0.2
"""Blends of neighbours must not overlap: well below half of the default least step of seams (1 mm)."""
ACCELERATION_M_S2 = 0.5
"""Slow. A weld speed is reached within 0.1 mm."""
JOINT_LIMITS = "a=0.3, v=0.1"
"""rad/s² and rad/s of the only joint move. Slow, because the arm can come from anywhere."""
PLANNED_ACCELERATION_RAD_S2 = 0.8
"""Of the joint moves of a plan: little more than half of what the controller takes if nothing is stated (1.4)."""
USUAL_JOINT_RAD_S = 2.0
"""Largest speed of a joint where the arm's file states none: that of the slowest joints of these arms is 2.09."""
LONGEST_COMMENT = 100


def write_urscript(program: WeldProgram) -> dict[str, str]:
    """Write a URScript program. ``NAME.script``."""
    name = safe_name(program.controller.program_name, NAMES)
    planned = program.planned
    T_base_frame = frame_as_written(program.T_base_part)
    head = [
        *describe(program),
        *(planned.standing_axes("URScript") if planned is not None else ()),
        f"poses are relative to wp_part, {part_frame(program)}; m and rotation vectors in rad",
        f"written with {DECIMALS} decimals: within 0.000001 mm and 0.000001 deg",
        "set the tool centre point before this program; the arc burns from ARC ON to ARC OFF"
        if program.arc is None
        else f"set the tool centre point before this program; {how(program.arc)}",
    ]
    frame = poses_of(T_base_frame.t_mm[None], T_base_frame.R[None])[0]
    post = Post("urscript", program)
    about = comment_lines(head, mark="", longest=LONGEST_COMMENT)
    lines = [f"def {name}():", *post.header(about), f"  wp_part = {frame}"]
    safe = None
    if program.safe_point is not None:
        safe = f"pose_trans(wp_part, {poses_of(*program.safe_point.poses_in(T_base_frame))[0]})"
        lines += post.air_move(safe, speed=JOINT_LIMITS, joint=True)
    between = _between(program, post)
    for way, path in zip(between, program.paths, strict=False):
        lines += [*way, *_moves(path, T_base_frame, post)]
    lines += between[-1]
    if safe is not None:
        lines += post.air_move(safe, speed=limits(program.motion.air_speed_mm_s))
    return {f"{name}.script": "\n".join([*lines, *post.footer(), ""])}


def _between(program: WeldProgram, post: Post) -> list[list[str]]:
    """Return the joint moves of a plan before each seam and after the last."""
    planned = program.planned
    if planned is None:
        return [[] for _ in range(len(program.paths) + 1)]
    stated = [joint.speed_rad_s for joint in program.arm.joints if joint.speed_rad_s] if program.arm else []
    speed = min(stated, default=USUAL_JOINT_RAD_S) * planned.joint_percent / 100.0
    text = f"a={PLANNED_ACCELERATION_RAD_S2:g}, v={math.floor(1e3 * speed) / 1e3:g}"
    return [
        [
            line
            for joints in rounded(moves.joints, DECIMALS).tolist()
            for line in post.joint_move(f"[{', '.join(f'{q:.{DECIMALS}f}' for q in joints)}]", speed=text)
        ]
        for moves in planned.air
    ]


def limits(mm_s: float) -> str:
    """Write acceleration and speed of a linear move."""
    return f"a={ACCELERATION_M_S2:g}, v={mm_s * MM:g}"


def frame_as_written(T: RigidTransform) -> RigidTransform:
    """Return the frame with the written digits: its rounding then does not move the poses in the base."""
    turn = rounded(log_rotation(T.R), DECIMALS)
    return RigidTransform(exp_rotation(turn), rounded(T.t_mm * MM, DECIMALS) / MM, T.target, T.source)


def poses_of(p: FloatArray, R: FloatArray) -> list[str]:
    """Write poses: p of shape (n, 3), mm, and R of shape (n, 3, 3), in any one frame."""
    k = DECIMALS
    table = rounded(np.concatenate([p * MM, log_rotation(R)], axis=1), k).tolist()
    return [f"p[{x:.{k}f}, {y:.{k}f}, {z:.{k}f}, {a:.{k}f}, {b:.{k}f}, {c:.{k}f}]" for x, y, z, a, b, c in table]


def _moves(path: WeldPath, T_base_frame: RigidTransform, post: Post) -> list[str]:
    program = post.program
    poses = [f"pose_trans(wp_part, {pose})" for pose in poses_of(*path.poses_in(T_base_frame))]
    rows = path.weld_rows
    way_to, along, way_from = poses[: rows.start], poses[rows], poses[rows.stop :]
    weld, air = (limits(v) for v in (program.weld_speed_mm_s(path), program.motion.air_speed_mm_s))
    is_joint, arc = program.safe_point is None, program.arc
    lines = comment_lines([f"{path.seam.name}: {describe_path(path)}"], mark="  # ", longest=LONGEST_COMMENT)
    if program.planned is None:
        lines += post.air_move(way_to[0], speed=JOINT_LIMITS if is_joint else air, joint=is_joint)
    for pose in (*way_to[1:], along[0]):
        lines += post.air_move(pose, speed=air)
    lines += post.weld_start(path, list if arc is None else partial(SWITCH.start_lines, path, arc))
    lines += _weld_moves(path, along, weld)
    lines += post.weld_end(path, list if arc is None else partial(SWITCH.end_lines, path, arc))
    for pose in way_from:
        lines += post.air_move(pose, speed=air)
    return lines


def _weld_moves(path: WeldPath, along: list[str], speed: str) -> list[str]:
    """Return the moves along the seam. Mode 0 of an arc: the tool turns about one axis, and not with the tangent."""
    lines = []
    for move, stop in zip(path.weld_moves, path.stops(BLEND_MM), strict=True):
        blend = "" if stop else f", r={BLEND_MM * MM:g}"
        if isinstance(move, Arc):
            lines.append(f"  movec({along[move.via]}, {along[move.to]}, {speed}{blend}, mode=0)")
        else:
            lines.append(f"  movel({along[move.to]}, {speed}{blend})")
    return lines
