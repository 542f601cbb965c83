"""Kawasaki AS: one file ``NAME.as`` with a program per seam, one that calls them all, and the transformation values.

O, A, T in degrees with ``R = Rz(O) Ry(A) Rz(T)``; lengths in mm. Points are relative to ``wp_part``, the part as
calibrated, which every program makes its ``BASE``. A transformation value has no configuration: the arm keeps the one
that it comes with. Joint moves of a plan go to precision points (``#wpj0001`` in ``.JOINTS``), which state all axes: a
seam then keeps the configuration of the move before it. Axes of a positioner follow the six of the arm, in both kinds.

References
----------
The form of files, ``BASE``, ``TOOL``, ``SPEED … MM/S ALWAYS``, ``ACCURACY``, ``BREAK``, ``LMOVE``, ``C1MOVE`` and
``C2MOVE`` follow public programs of Kawasaki robots (docs/how-to/kawasaki.md).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from wpcal.controllers.kawasaki.arc import Conditions, conditions, weld_moves
from wpcal.controllers.language.naming import NameRules, comment_lines, own_name, safe_name, safe_names
from wpcal.controllers.language.post import Post
from wpcal.controllers.language.rounding import rounded, zyz_degrees
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe, describe_path, part_frame
from wpcal.controllers.program.planned import JointMoves, PlannedMoves, angle_texts
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.rotations import rotation_from_zyz
from wpcal.core.transform import RigidTransform

KEYWORDS = (
    "abort above accel accuracy always and any base below bits break call case cp decel delay do drive dwrist else end "
    "false fine for forward frame goto here home if jmove lefty lmove lock null off on or pause point print pulse "
    "return righty scase shift signal speed stable step stop swait then timer to tool trans true twait until uwrist "
    "value wait weld while wp_part wp_safe"
)
NAMES = NameRules("AS", 15, KEYWORDS)
"""Names have up to 15 characters: controllers cut longer ones."""
MM_DECIMALS = 5
DEG_DECIMALS = 6
"""As for the other controllers with 32-bit numbers, which resolve 1e-4 mm and 1e-5 deg."""
LONGEST_COMMENT = 76
JOINT_PERCENT = 5
"""Of the only joint move. Slow, because the arm can come from anywhere."""
ACCURACY_MM = 1
"""Distance from a corner at which the tool may leave the path: the default least step of seams."""
PROGRAM = "weld_"
"""The name of a program is this and the name of its seam."""
PART, SAFE_POINT = "wp_part", "wp_safe"
JOINTS = "#wpj"
"""The name of a precision point of a plan is this and its number."""


def write_as(program: WeldProgram) -> dict[str, str]:
    """Write an AS file. ``NAME.as``, with lines ended by CR LF.

    Raises
    ------
    InputError
        When AS does not allow the tool's name, has no condition for a weld, or external axes move along a seam.
    """
    _refuse_coordination(program.planned)
    width = program.label_width
    main = safe_name(program.controller.program_name, NAMES)
    rules = NameRules(NAMES.language, NAMES.longest, f"{KEYWORDS} {main.lower()}")
    names = safe_names([path.seam.name for path in program.paths], rules, room=max(width + 1, len(PROGRAM)))
    own = conditions(program)
    T_base_frame = frame_as_written(program.T_base_part)
    frame = transformations(T_base_frame.t_mm[None], zyz_degrees(T_base_frame.R, decimals=DEG_DECIMALS)[None])[0]
    points = [f"{PART} {frame}"]
    if program.safe_point is not None:
        points += _points([SAFE_POINT], program.safe_point, T_base_frame)
    between = _between(program)
    lines = _main(program, main, names, own, between)
    for (_, first), path in zip(between, program.paths, strict=False):
        stem = names[path.seam.name]
        labels = path.labels(stem, width=width)
        lines += [f".PROGRAM {PROGRAM}{stem}()", *_seam(program, path, labels, own.get(path.seam.name), first), ".END"]
        points += _points(labels, path, T_base_frame, program.planned)
    joints = _precision_points(program.planned)
    return {f"{main}.as": "\r\n".join([*lines, ".TRANS", *points, ".END", *joints, ""])}


def _refuse_coordination(planned: PlannedMoves | None) -> None:
    if planned is None:
        return
    if planned.follows:
        raise InputError(
            "AS: the positioner turns along a seam, and no public source states such moves of AS; plan with "
            "--position any to weld with the positioner at rest, or write RAPID, KRL, INFORM or FANUC"
        )
    if planned.rail is not None:
        raise InputError(
            f"AS: no public source states whether positions move with a rail ({planned.rail}); write RAPID, KRL, "
            "INFORM or FANUC"
        )


def _precision_points(planned: PlannedMoves | None) -> list[str]:
    """Return the section of the joints that a plan goes to: the axes of the arm, then those of the positioner."""
    if planned is None:
        return []
    lines = []
    for moves, numbers in planned.numbered():
        for row, number in zip(_axis_texts(planned, moves), numbers, strict=True):
            lines.append(f"{JOINTS}{number:04d} {' '.join(row)}")
    return [".JOINTS", *lines, ".END"]


def _axis_texts(planned: PlannedMoves, moves: JointMoves) -> list[list[str]]:
    outer = planned.external_texts(moves.external, DEG_DECIMALS)
    return [[*row, *axes] for row, axes in zip(angle_texts(moves.joints, DEG_DECIMALS), outer, strict=True)]


def _between(program: WeldProgram) -> list[tuple[list[str], list[str]]]:
    """Return the joint moves before each seam and after the last; the last move before a seam is apart.

    It belongs to the program of the seam, so that the seam can be run alone.
    """
    planned = program.planned
    if planned is None:
        return [([], []) for _ in range(len(program.paths) + 1)]
    post, speed, found = Post("as", program), f"{planned.joint_percent:.0f}", []
    for row, (_, numbers) in enumerate(planned.numbered()):
        moves = [post.joint_move(f"{JOINTS}{number:04d}", speed=speed) for number in numbers]
        cut = len(moves) if row == len(program.paths) else -1
        before, last = ([line for move in part for line in move] for part in (moves[:cut], moves[cut:]))
        found.append((before, last))
    return found


def _main(
    program: WeldProgram,
    main: str,
    names: dict[str, str],
    own: Mapping[str, Conditions],
    between: list[tuple[list[str], list[str]]],
) -> list[str]:
    post = Post("as", program)
    lines = [f".PROGRAM {main}()", *post.header(_about(program, names, own))]
    calls = [f"  CALL {PROGRAM}{stem}" for stem in names.values()]
    if program.safe_point is not None:
        first = post.air_move(SAFE_POINT, speed=f"{JOINT_PERCENT}", joint=True)
        last = [*post.air_move(SAFE_POINT, speed=as_speed(program.motion.air_speed_mm_s)), "  BREAK", "  BASE NULL"]
        calls = [*_frames(program), *first, "  BREAK", *calls, f"  BASE {PART}", *last]
    if program.planned is not None:
        ways = zip(between, [*calls, "  BASE NULL"], strict=True)
        calls = [*_frames(program), *(line for (way, _), call in ways for line in (*way, call))]
    return [*lines, *calls, *post.footer(), ".END"]


def _frames(program: WeldProgram) -> list[str]:
    tool = own_name(program.controller.tool_name, NAMES, what="tool")
    return [f"  BASE {PART}", f"  TOOL {tool}", "  CP ON", f"  ACCURACY {ACCURACY_MM} ALWAYS"]


def _about(program: WeldProgram, names: dict[str, str], own: Mapping[str, Conditions]) -> list[str]:
    planned = program.planned
    text = [
        *describe(program),
        f"points are relative to {PART}, {part_frame(program)}; mm; R = Rz(O) Ry(A) Rz(T), deg",
        f"written with {MM_DECIMALS} and {DEG_DECIMALS} decimals: within 0.00001 mm and 0.000001 deg",
        "the configuration is not known: the arm keeps the one it comes with"
        if planned is None
        else "the configuration is that of the joint move before each seam: the arm keeps it",
        *_outer_axes(planned),
        f"the transformation {program.controller.tool_name} (the torch) must be on the controller",
        *_about_arc(own),
        "seam -> name here",
        *(f"  {path.seam.name} -> {names[path.seam.name]}: {describe_path(path)}" for path in program.paths),
    ]
    return comment_lines(text, mark="", longest=LONGEST_COMMENT)


def _outer_axes(planned: PlannedMoves | None) -> list[str]:
    if planned is None or not planned.turning:
        return []
    axes = ", ".join(f"JT{row} = {name}" for row, name in enumerate(planned.turning, start=7))
    return [f"external axes: {axes}; each is after the six values of a point, deg"]


def _about_arc(own: Mapping[str, Conditions]) -> list[str]:
    """Say which conditions of the controller the program sets, and which it needs."""
    if not own:
        return ["the arc burns from ARC ON to ARC OFF"]
    told = []
    if written := sorted({each.weld for each in own.values() if each.lines}):
        told.append(f"W1SET and W2SET replace weld conditions of the controller: {', '.join(map(str, written))}")
    if needed := sorted({each.weld for each in own.values() if not each.lines}):
        told.append(f"weld conditions that must be on the controller: {', '.join(map(str, needed))}")
    return [*told, "gas, and the delay before the torch moves, are those of the controller"]


def _seam(
    program: WeldProgram, path: WeldPath, labels: list[str], own: Conditions | None, to_start: list[str]
) -> list[str]:
    post, air = Post("as", program), as_speed(program.motion.air_speed_mm_s)
    rows, is_joint = path.weld_rows, program.safe_point is None
    lines = comment_lines([path.seam.name, describe_path(path)], mark="; ", longest=LONGEST_COMMENT)
    lines += _frames(program)
    first = f"{JOINT_PERCENT}" if is_joint else air
    lines += to_start if program.planned is not None else post.air_move(labels[0], speed=first, joint=is_joint)
    for label in labels[1 : rows.start]:
        lines += post.air_move(label, speed=air)
    speed = as_speed(program.weld_speed_mm_s(path))
    along = labels[rows]
    lines += post.weld_start(path, partial(list, own.lines if own else ()), point=along[0], speed=speed)
    lines += weld_moves(path, along, path.stops(ACCURACY_MM), own)
    lines += post.weld_end(path, list)
    for label in labels[rows.stop :]:
        lines += post.air_move(label, speed=air)
    return without_repeats([*lines, "  BREAK"])


def without_repeats(lines: list[str]) -> list[str]:
    """Leave out every ``SPEED … ALWAYS`` that is in force already."""
    kept, now = [], ""
    for line in lines:
        if line.startswith("  SPEED ") and line.endswith(" ALWAYS"):
            if line == now:
                continue
            now = line
        kept.append(line)
    return kept


def as_speed(mm_s: float) -> str:
    """Write a speed."""
    return f"{mm_s:g} MM/S"


def frame_as_written(T: RigidTransform) -> RigidTransform:
    """Return the frame with the written digits: its rounding then does not move the points in the base."""
    o, a, t = np.radians(zyz_degrees(T.R, decimals=DEG_DECIMALS))
    return RigidTransform(rotation_from_zyz(o, a, t), rounded(T.t_mm, MM_DECIMALS), T.target, T.source)


def _points(
    labels: list[str], poses: WeldPath | SafePoint, T_base_frame: RigidTransform, planned: PlannedMoves | None = None
) -> list[str]:
    p, R = poses.poses_in(T_base_frame)
    texts = transformations(p, zyz_degrees(R, decimals=DEG_DECIMALS))
    if planned is None or not isinstance(poses, WeldPath) or poses.external is None:
        return [f"{label} {text}" for label, text in zip(labels, texts, strict=True)]
    outer = planned.external_texts(poses.external, DEG_DECIMALS)
    rows = [" ".join([label, text, *axes]) for label, text, axes in zip(labels, texts, outer, strict=True)]
    return rows[poses.before :]  # a plan goes to joints before a seam


def transformations(p: FloatArray, angles: FloatArray) -> list[str]:
    """Write poses as six numbers: p of shape (n, 3), mm, in any one frame, and angles O, A, T, deg."""
    m, k = MM_DECIMALS, DEG_DECIMALS
    return [
        f"{x:.{m}f} {y:.{m}f} {z:.{m}f} {o:.{k}f} {a:.{k}f} {t:.{k}f}"
        for (x, y, z), (o, a, t) in zip(rounded(p, m).tolist(), angles.tolist(), strict=True)
    ]
