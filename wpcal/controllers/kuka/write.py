"""KUKA KRL: a pair ``NAME.src`` and ``NAME.dat`` with the base of the calibrated part and the points along its seams.

Angles are A, B, C in degrees with ``R = Rz(A) Ry(B) Rx(C)``; lengths in mm. Points are relative to the frame
``WP_PART``, which the program makes ``$BASE``. Status and turn (S, T) are written where the arm's joints are known and
`wpcal.controllers.kuka.configuration` defines them. Otherwise they are left out: the controller ignores them for LIN
and keeps the present ones for PTP.

References
----------
KUKA, System Software 8.x: Operating and Programming Instructions for System Integrators (E6POS, FRAME, $BASE, S and T).
"""

from __future__ import annotations

from functools import partial

from wpcal.controllers.kuka.arc import (
    LONGEST_PREFIX,
    fold_data,
    fold_moves,
    has_folds,
    how,
    plain_end,
    plain_start,
)
from wpcal.controllers.kuka.configuration import status_and_turn
from wpcal.controllers.language.naming import NameRules, comment_lines, safe_name, safe_names
from wpcal.controllers.language.post import Post
from wpcal.controllers.language.rounding import rounded, rounded_frame, zyx_degrees
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe, describe_path, part_frame
from wpcal.controllers.program.planned import PlannedMoves, angle_texts
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.moves import Arc

KEYWORDS = (
    "anin anout axis b_and b_exor b_not b_or begin bool brake case cast_from cast_to ccirc channel char circ "
    "circ_rel confirm const continue decl def default defdat deffct digin digout do e6axis e6pos else end enddat "
    "endfct endfold endfor endif endinterrupt endloop endspline endstruc endswitch endwhile enum exit exor ext "
    "extfct false fdat fold for frame function global goto halt if import int interrupt is ldat lin lin_rel loop "
    "maxi minimum not on or path pdat pos prio ptp ptp_rel public pulse real repeat resume return scirc seq signal "
    "slin spl spline step struc switch sync then to trigger true until wait when while with wp_part wp_safe"
)
NAMES = NameRules("KRL", 24, KEYWORDS)
"""Names have up to 24 characters; wp_part is the frame of the part, wp_safe the safe point."""
MM_DECIMALS = 5
"""A controller keeps 32-bit numbers: 1e-4 mm at 2 m. One more digit loses nothing."""
DEG_DECIMALS = 6
"""1e-6 deg moves a point at 2 m by 4e-5 mm."""
LONGEST_COMMENT = 76
"""Keeps lines on the pendant's screen."""
AXES = "WPJ"
"""The name of axes that a plan goes to is this and their number."""
JOINT_PERCENT = 10
"""Of PTP moves. Slow, because the arm can come from anywhere."""
CIRCLE = ("$ORI_TYPE=#VAR", "$CIRC_TYPE=#BASE")
"""On arcs the tool turns about one axis, and not with the tangent."""
BLEND_MM = 1.0
"""Distance from a corner at which LIN moves may leave it: the default least step of seams."""


def write_krl(program: WeldProgram) -> dict[str, str]:
    """Write a KRL program and its data list. ``NAME.src`` and ``NAME.dat``, with lines ended by CR LF."""
    width = program.label_width
    name = safe_name(program.controller.program_name, NAMES)
    folds = any(has_folds(path, program) for path in program.paths)
    if folds and program.planned is not None and program.planned.follows:
        raise InputError("KRL: the positioner turns along a seam, which ArcTech folds of a plan cannot state yet")
    room = width + 1 + (LONGEST_PREFIX if folds else 0)
    names = safe_names([path.seam.name for path in program.paths], NAMES, room=room)
    T_base_frame = rounded_frame(program.T_base_part, mm_decimals=MM_DECIMALS, deg_decimals=DEG_DECIMALS)
    points: list[str] = []
    vertical = 0
    known = _status_is_known(program)
    for path in program.paths:
        vertical += int((abs(zyx_degrees(path.poses_in(T_base_frame)[1], decimals=DEG_DECIMALS)[:, 1]) == 90.0).sum())
        labels = path.labels(names[path.seam.name], width=width)
        texts = _positions(path, program, T_base_frame, known=known)
        along = labels[path.weld_rows] if has_folds(path, program) else []
        points += [
            f"DECL E6POS {'X' if label in along else ''}{label}={text}"
            for label, text in zip(labels, texts, strict=True)
        ][0 if program.planned is None else path.before :]  # a plan goes to axes before a seam
        points += fold_data(along, program, blend_mm=BLEND_MM)
    post = Post("krl", program)
    header = post.header(_about(program, names, vertical, known=known))
    frame = aggregates(T_base_frame.t_mm[None], zyx_degrees(T_base_frame.R, decimals=DEG_DECIMALS)[None])[0]
    if program.safe_point is not None:
        points.insert(0, f"DECL E6POS WP_SAFE={_positions(program.safe_point, program, T_base_frame, known=known)[0]}")
    points = [*_axis_targets(program.planned), *points]
    data = [*ATTRIBUTES, f"DEFDAT {name} PUBLIC", *header, f"DECL FRAME WP_PART={frame}", *points, "ENDDAT", ""]
    source = [*ATTRIBUTES, f"DEF {name}()", *header, *_start(program)]
    between = _between(program.planned, post)
    for number, path in enumerate(program.paths):
        source += [*(between[number] if between else ()), *_moves(path, names[path.seam.name], post)]
    source += between[-1] if between else []
    if program.safe_point is not None:
        source += ["; back to the safe point", *post.air_move("WP_SAFE", speed=_air(program)), "PTP $H_POS"]
    return {f"{name}.src": "\r\n".join([*source, *post.footer(), ""]), f"{name}.dat": "\r\n".join(data)}


ATTRIBUTES = ("&ACCESS RVP", "&REL 1")
"""Visible to the programmer, first release."""


def _status_is_known(program: WeldProgram) -> bool:
    """Tell whether S and T of every pose are known; otherwise none is written."""
    try:
        for poses in program.groups:
            postures = program.posture_of(poses)
            if postures is None:
                return False
            status_and_turn(postures)
    except InputError:
        return False
    return True


def _positions(
    poses: WeldPath | SafePoint, program: WeldProgram, T_base_frame: RigidTransform, *, known: bool
) -> list[str]:
    p, R = poses.poses_in(T_base_frame)
    texts = aggregates(p, zyx_degrees(R, decimals=DEG_DECIMALS))
    postures = program.posture_of(poses)
    if known and postures is not None:
        both = status_and_turn(postures)
        texts = [f"{text[:-1]},S {status},T {turn}}}" for text, (status, turn) in zip(texts, both, strict=True)]
    if program.planned is None or not isinstance(poses, WeldPath) or poses.external is None:
        return texts
    axes = program.planned.external_texts(poses.external, DEG_DECIMALS)
    return [f"{text[:-1]}{_external(row)}}}" for text, row in zip(texts, axes, strict=True)]


def _external(axes: list[str]) -> str:
    return "".join(f",E{number} {value}" for number, value in enumerate(axes, start=1))


def _axis_targets(planned: PlannedMoves | None) -> list[str]:
    """Declare the axes that a plan goes to between seams."""
    if planned is None:
        return []
    lines = []
    for moves, numbers in planned.numbered():
        outer = planned.external_texts(moves.external, DEG_DECIMALS)
        for joints, axes, number in zip(angle_texts(moves.joints, DEG_DECIMALS), outer, numbers, strict=True):
            arm = ",".join(f"A{row} {value}" for row, value in enumerate(joints, start=1))
            lines.append(f"DECL E6AXIS {AXES}{number:04d}={{{arm}{_external(axes)}}}")
    return lines


def _between(planned: PlannedMoves | None, post: Post) -> list[list[str]]:
    """Return the moves to axes before each seam and after the last; none without a plan."""
    if planned is None:
        return []
    return [
        [line for number in numbers for line in post.joint_move(f"{AXES}{number:04d}", speed="")]
        for _, numbers in planned.numbered()
    ]


def _about(program: WeldProgram, names: dict[str, str], vertical: int, *, known: bool) -> list[str]:
    text = [
        *describe(program),
        f"points are relative to WP_PART, {part_frame(program)}; mm; R = Rz(A) Ry(B) Rx(C), deg",
        f"written with {MM_DECIMALS} and {DEG_DECIMALS} decimals: within 0.00001 mm and 0.000001 deg",
        "S and T are computed from the joints"
        if known
        else "S and T are not known and left out: LIN ignores them, PTP keeps the present ones",
        f"PTP moves run with {_joint_percent(program):.0f} % of the axes' speed",
        *_frame_in_words(program),
        *how(program.arc, folds=any(has_folds(path, program) for path in program.paths)),
    ]
    if vertical:
        text.append(f"{vertical} points have B = +-90, where A and C turn about one axis: C was fixed at 0")
    text += ["seam -> name here"]
    text += [f"  {path.seam.name} -> {names[path.seam.name]}: {describe_path(path)}" for path in program.paths]
    return comment_lines(text, mark="", longest=LONGEST_COMMENT)


def aggregates(p: FloatArray, angles: FloatArray) -> list[str]:
    """Write poses as ``{X …,Y …,Z …,A …,B …,C …}``.

    Parameters
    ----------
    p : shape (n, 3). In any one frame, mm.
    angles : shape (n, 3). About x, y and z, deg.
    """
    m, k = MM_DECIMALS, DEG_DECIMALS
    return [
        f"{{X {x:.{m}f},Y {y:.{m}f},Z {z:.{m}f},A {a:.{k}f},B {b:.{k}f},C {c:.{k}f}}}"
        for (x, y, z), (c, b, a) in zip(rounded(p, m).tolist(), angles.tolist(), strict=True)
    ]


def _joint_percent(program: WeldProgram) -> float:
    return JOINT_PERCENT if program.planned is None else program.planned.joint_percent


def _frame_in_words(program: WeldProgram) -> list[str]:
    planned = program.planned
    jog = [f"BASE_DATA[{program.controller.frame_number}] becomes WP_PART too: jog in this base"]
    if planned is None or not planned.axis_count:
        return jog
    jog = [] if planned.turning else jog
    names = [name for name in (planned.rail, *planned.turning) if name]
    axes = ", ".join(f"E{row} = {name}" for row, name in enumerate(names, start=1))
    unit = "the positioner turns along seams: it must be the external kinematic MACHINE_DEF[2]"
    return [*jog, f"external axes: {axes}", *([unit] if planned.follows else [])]


def _start(program: WeldProgram) -> list[str]:
    air = program.motion.air_speed_mm_s / 1000.0
    turns = program.planned is not None and program.planned.turning
    follows = program.planned is not None and program.planned.follows
    to_safe_point = ["PTP $H_POS", f"$VEL.CP={air:g}", "PTP WP_SAFE"]
    return [
        "BAS(#INITMOV,0)",
        f"BAS(#VEL_PTP,{_joint_percent(program):.0f})",
        f"$TOOL=TOOL_DATA[{program.controller.tool_number}]",
        *(() if turns else (f"BASE_DATA[{program.controller.frame_number}]=WP_PART",)),
        "$BASE=EK(MACHINE_DEF[2].ROOT,MACHINE_DEF[2].MECH_TYPE,WP_PART)" if follows else "$BASE=WP_PART",
        "$IPO_MODE=#BASE",
        f"$APO.CDIS={BLEND_MM:g}",
        *(CIRCLE if any(path.has_arcs for path in program.paths) else ()),
        *(to_safe_point if program.safe_point is not None else []),
    ]


def _air(program: WeldProgram) -> str:
    return f"{program.motion.air_speed_mm_s / 1000.0:g}"  # $VEL.CP is in m/s


def _moves(path: WeldPath, stem: str, post: Post) -> list[str]:
    program, air = post.program, _air(post.program)
    labels, rows = path.labels(stem, width=program.label_width), path.weld_rows
    way_to, along, way_from = labels[: rows.start], labels[rows], labels[rows.stop :]
    lines = [f"; {stem}", f"$VEL.CP={air}"]
    if program.planned is None:
        lines += post.air_move(way_to[0], speed=air, joint=program.safe_point is None)
    for label in way_to[1:]:
        lines += post.air_move(label, speed=air)
    folds, arc = has_folds(path, program), program.arc
    speed = f"{program.weld_speed_mm_s(path) / 1000.0:g}"
    start = list if folds or arc is None else partial(plain_start, path, arc)
    end = list if folds or arc is None else partial(plain_end, path, arc)
    lines += post.weld_start(path, start, point=along[0], speed=speed, folds=folds)
    lines += fold_moves(path, along, program, path.stops(BLEND_MM)) if folds else _weld_moves(path, along)
    lines += [*post.weld_end(path, end, folds=folds), f"$VEL.CP={air}"]
    for label in way_from:
        lines += post.air_move(label, speed=air)
    return lines


def _weld_moves(path: WeldPath, along: list[str]) -> list[str]:
    lines = []
    for move, stop in zip(path.weld_moves, path.stops(BLEND_MM), strict=True):
        to = f"CIRC {along[move.via]},{along[move.to]}" if isinstance(move, Arc) else f"LIN {along[move.to]}"
        lines.append(to if stop else f"{to} C_DIS")
    return lines
