r"""ABB RAPID: one module with the work object of the calibrated part, the targets, and one procedure per seam.

Quaternions are written q1 to q4 = w, x, y, z; lengths in mm. Targets are relative to the work object, which is the part
frame as calibrated. `confdata` is computed where the arm's joints are known (`wpcal.controllers.abb.configuration`).
Otherwise it is written as zeros and not used: ``ConfJ\Off`` and ``ConfL\Off`` let the controller choose the
configuration nearest to the present one.

References
----------
ABB, Technical reference manual: RAPID Instructions, Functions and Data types (robtarget, wobjdata, confdata, ConfL).
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.abb.arc import ArcData, arc_data
from wpcal.controllers.abb.configuration import confdata
from wpcal.controllers.language.naming import NameRules, comment_lines, own_name, safe_name, safe_names
from wpcal.controllers.language.post import Post
from wpcal.controllers.language.rounding import rounded
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe, describe_path, part_frame
from wpcal.controllers.program.planned import PlannedMoves, angle_texts
from wpcal.core.arrays import FloatArray
from wpcal.core.rotations import quaternion_from_rotation, rotation_from_quaternion
from wpcal.core.transform import RigidTransform
from wpcal.robot.moves import Arc

KEYWORDS = (
    "alias and backward case connect const default div do else elseif endfor endfunc endif endmodule endproc "
    "endrecord endtest endtrap endwhile error exit false for from func goto if inout local mod module nostepin not "
    "noview or pers proc raise readonly record retry return step sysmodule task test then to trap true trynext undo "
    "var viewonly while with xor"
)
NAMES = NameRules("RAPID", 32, KEYWORDS)
"""Identifiers have up to 32 characters."""
MM_DECIMALS = 5
"""A controller keeps 32-bit numbers: 1e-4 mm at 2 m. One more digit loses nothing."""
QUATERNION_DECIMALS = 9
"""1e-9 turns a point at 2 m by 4e-6 mm; the controller normalises what it reads."""
LONGEST_COMMENT = 72
"""Old controllers cut source lines at 80 characters."""
DEG_DECIMALS = 5
"""Of joints: 1.5e-5 degrees at 180 degrees is what a 32-bit number resolves."""
EXTERNAL_AXES = 6
NO_AXIS = "9E+09"
"""The robot does not have this external axis."""
NO_EXTERNAL_AXES = f"[{','.join([NO_AXIS] * EXTERNAL_AXES)}]"
UNIT = "STN1"
"""The usual name of a positioner as a mechanical unit."""
JOINT_TARGET = "wpJ"
"""The name of a joint target of a plan is this and its number."""
PLANNED_SPEED = "vJoint"
"""Of the joint moves of a plan. 500 mm/s is a limit of the tip: the joints limit most of them."""
PROCEDURE = "weld_"
"""The name of a procedure is this and the name of its seam."""
SAFE_POINT = "wpSafe"
"""The target above the part at which the program starts and ends."""
AIR_SPEED = "vAir"
JOINT_SPEED = "v100"
"""Of the only joint move, that to the safe point: slow, because the arm can come from anywhere."""
OFF = ("    ConfJ\\Off;", "    ConfL\\Off;")
ON = ("    ConfJ\\On;", "    ConfL\\On;")
"""As a controller starts; a caller of a procedure gets them back."""
CIRCLE = ("    CirPathMode\\ObjectFrame;",)
"""On arcs the tool turns about one axis, and not with the tangent."""
USUAL_CIRCLE = ("    CirPathMode\\PathFrame;",)
"""As a controller starts."""
ZONE_MM = 1.0
"""Of z1."""
TURN_DEG_S = 500
"""As in the predefined speeds: rotation never limits the speed along a seam."""


def write_rapid(program: WeldProgram) -> dict[str, str]:
    """Write a RAPID module. ``NAME.mod``, with lines ended by CR LF.

    Raises
    ------
    InputError : When RAPID does not allow the tool's name.
    """
    width = program.label_width
    module = safe_name(program.controller.program_name, NAMES)
    frame, T_base_frame = frame_as_written(program.T_base_part)
    names = safe_names([path.seam.name for path in program.paths], NAMES, room=max(width + 1, len(PROCEDURE)))
    post = Post("rapid", program)
    lines = [f"MODULE {module}", *post.header(_about(program, names)), *_data(program, frame)]
    lines += _joint_targets(program.planned)
    arcs = {path.seam.name: _arc_data(path, names[path.seam.name], program) for path in program.paths}
    for path in program.paths:
        lines += _data_of_seam(path, names[path.seam.name], program, arcs[path.seam.name])
    if program.safe_point is not None:
        lines += _targets([SAFE_POINT], program.safe_point, program, T_base_frame)
    for path in program.paths:
        targets = _targets(path.labels(names[path.seam.name], width=width), path, program, T_base_frame)
        lines += targets[0 if program.planned is None else path.before :]  # a plan goes to joints before a seam
    tool = own_name(program.controller.tool_name, NAMES, what="tool")
    off, on = ((), ()) if program.arm is not None else (OFF, ON)
    between = _between(program.planned, post)
    for number, path in enumerate(program.paths):
        moves = _moves(path, names[path.seam.name], tool, post, arcs[path.seam.name])
        moves = [*between[number][1], *moves] if between else moves
        mode, usual = (CIRCLE, USUAL_CIRCLE) if path.has_arcs else ((), ())
        name = f"{PROCEDURE}{names[path.seam.name]}"
        lines += ["", f"  PROC {name}()", *off, *mode, *moves, *usual, *on, "  ENDPROC"]
    calls = [f"    {PROCEDURE}{stem};" for stem in names.values()]
    if between:
        calls[:0] = [f"    ActUnit {UNIT};"] if _follows(program) else []
        between[:0] = [([], [])] if _follows(program) else []
        calls = [line for (way, _), call in zip(between, [*calls, ""], strict=True) for line in (*way, call) if line]
    if program.safe_point is not None:
        first = post.air_move(SAFE_POINT, speed=JOINT_SPEED, joint=True)
        calls = [*off, *first, *calls, *off, *post.air_move(SAFE_POINT, speed=AIR_SPEED), *on]
    main = safe_name(f"run_{module}", NAMES)
    lines += [f"  PROC {main}()", *calls, "  ENDPROC", *post.footer(), ""]
    return {f"{module}.mod": "\r\n".join(lines)}


def _about(program: WeldProgram, names: dict[str, str]) -> list[str]:
    text = [
        *describe(program),
        f"targets are relative to wpPart, {part_frame(program)}; mm; q1..q4 = w,x,y,z",
        f"written with {MM_DECIMALS} and {QUATERNION_DECIMALS} decimals: within 0.00001 mm and 0.000001 deg",
        "confdata is not known: ConfJ, ConfL \\Off let the controller choose, and are On again at the end"
        if program.arm is None
        else "confdata is computed from the joints; cfx is that of an arm without a parallel rod",
        *_planned_frame(program),
        "the tool must be declared on the controller; the arc burns from ARC ON to ARC OFF"
        if program.arc is None
        else "the tool, and data without sm_, wd_ and wv_, must be declared on the controller; wire feed in mm/s",
        "seam -> name here",
        *(f"  {path.seam.name} -> {names[path.seam.name]}: {describe_path(path)}" for path in program.paths),
    ]
    return comment_lines(text, mark="", longest=LONGEST_COMMENT)


def frame_as_written(T: RigidTransform) -> tuple[str, RigidTransform]:
    """Return the frame's text and the frame with these digits: its rounding then does not move targets in the base."""
    q = rounded(quaternion_from_rotation(T.R), QUATERNION_DECIMALS)
    written = RigidTransform(rotation_from_quaternion(q), rounded(T.t_mm, MM_DECIMALS), T.target, T.source)
    return _texts(T.t_mm[None], q[None])[0], written


def _data(program: WeldProgram, frame: str) -> list[str]:
    lines = [f'  PERS wobjdata wpPart:=[FALSE,TRUE,"",[{frame}],[[0,0,0],[1,0,0,0]]];']
    if _follows(program):
        lines = [f'  PERS wobjdata wpPart:=[FALSE,FALSE,"{UNIT}",[[0,0,0],[1,0,0,0]],[{frame}]];']
    for name, speed in (("vWeld", program.motion.speed_mm_s), ("vAir", program.motion.air_speed_mm_s)):
        lines.append(f"  LOCAL CONST speeddata {name}:=[{speed:g},{TURN_DEG_S},{speed:g},{TURN_DEG_S}];")
    return lines


def _arc_data(path: WeldPath, stem: str, program: WeldProgram) -> ArcData | None:
    return None if program.arc is None else arc_data(path, stem, program.weld_speed_mm_s(path), NAMES)


def _data_of_seam(path: WeldPath, stem: str, program: WeldProgram, arc: ArcData | None) -> list[str]:
    """Declare what a seam with weld data has of its own: its speed and its arc data."""
    if path.run is None:
        return []
    speed = program.weld_speed_mm_s(path)
    own = f"  LOCAL CONST speeddata {_speed_name(path, stem)}:=[{speed:g},{TURN_DEG_S},{speed:g},{TURN_DEG_S}];"
    return [own, *(() if arc is None else arc.declared)]


def _speed_name(path: WeldPath, stem: str) -> str:
    return "vWeld" if path.run is None else f"v_{stem}"


def pose_texts(p: FloatArray, R: FloatArray) -> list[str]:
    """Return poses as ``[x,y,z],[q1,q2,q3,q4]``.

    Parameters
    ----------
    p, R : shapes (n, 3) and (n, 3, 3). In any one frame, mm.
    """
    return _texts(p, quaternion_from_rotation(R))


def _texts(p: FloatArray, q_xyzw: FloatArray) -> list[str]:
    places = rounded(p, MM_DECIMALS).tolist()
    turns = rounded(np.roll(q_xyzw, 1, axis=1), QUATERNION_DECIMALS).tolist()
    m, k = MM_DECIMALS, QUATERNION_DECIMALS
    return [
        f"[{x:.{m}f},{y:.{m}f},{z:.{m}f}],[{w:.{k}f},{a:.{k}f},{b:.{k}f},{c:.{k}f}]"
        for (x, y, z), (w, a, b, c) in zip(places, turns, strict=True)
    ]


def _targets(
    labels: list[str], poses: WeldPath | SafePoint, program: WeldProgram, T_base_frame: RigidTransform
) -> list[str]:
    texts = pose_texts(*poses.poses_in(T_base_frame))
    postures = program.posture_of(poses)
    confs = ["[0,0,0,0]"] * len(texts) if postures is None else confdata(postures)
    outer = [NO_EXTERNAL_AXES] * len(texts)
    if program.planned is not None and isinstance(poses, WeldPath) and poses.external is not None:
        outer = [_external(row) for row in program.planned.external_texts(poses.external, DEG_DECIMALS)]
    return [
        f"  LOCAL CONST robtarget {label}:=[{text},{conf},{axes}];"
        for label, text, conf, axes in zip(labels, texts, confs, outer, strict=True)
    ]


def _external(axes: list[str]) -> str:
    return f"[{','.join([*axes, *[NO_AXIS] * (EXTERNAL_AXES - len(axes))])}]"


def _joint_targets(planned: PlannedMoves | None) -> list[str]:
    """Declare the joint targets of a plan, and their speed."""
    if planned is None:
        return []
    lines = [f"  LOCAL CONST speeddata {PLANNED_SPEED}:=[{TURN_DEG_S},{TURN_DEG_S},{TURN_DEG_S},{TURN_DEG_S}];"]
    for moves, numbers in planned.numbered():
        rows = zip(
            angle_texts(moves.joints, DEG_DECIMALS),
            planned.external_texts(moves.external, DEG_DECIMALS),
            numbers,
            strict=True,
        )
        for joints, axes, number in rows:
            at = f"[[{','.join(joints)}],{_external(axes)}]"
            lines.append(f"  LOCAL CONST jointtarget {JOINT_TARGET}{number:04d}:={at};")
    return lines


def _between(planned: PlannedMoves | None, post: Post) -> list[tuple[list[str], list[str]]]:
    """Return the joint moves before each seam and after the last; none without a plan.

    The last move before a seam is apart: it belongs to the procedure of the seam, so that the seam can be run alone.
    """
    if planned is None:
        return []
    found = []
    for row, (_, numbers) in enumerate(planned.numbered()):
        moves = [post.joint_move(f"{JOINT_TARGET}{number:04d}", speed=PLANNED_SPEED) for number in numbers]
        cut = len(moves) if row == len(planned.air) - 1 else -1
        before, last = ([line for move in part for line in move] for part in (moves[:cut], moves[cut:]))
        found.append((before, last))
    return found


def _follows(program: WeldProgram) -> bool:
    return program.planned is not None and program.planned.follows


def _planned_frame(program: WeldProgram) -> list[str]:
    planned = program.planned
    if planned is None or not planned.axis_count:
        return []
    names = [name for name in (planned.rail, *planned.turning) if name]
    eax = [f"eax_{chr(97 + row)} = {name}" for row, name in enumerate(names)]  # letters from a
    unit = f"the positioner turns along seams: it must be the mechanical unit {UNIT}, and coordinated"
    return [f"external axes: {', '.join(eax)}", *([unit] if planned.follows else [])]


def _moves(path: WeldPath, stem: str, tool: str, post: Post, arc: ArcData | None) -> list[str]:
    program, end = post.program, f"{tool}\\WObj:=wpPart;"
    labels, rows = path.labels(stem, width=program.label_width), path.weld_rows
    way_to, along, way_from = labels[: rows.start], labels[rows], labels[rows.stop :]
    moves = []
    if program.planned is None:
        moves += post.air_move(way_to[0], speed=AIR_SPEED, joint=program.safe_point is None)
    for label in way_to[1:]:
        moves += post.air_move(label, speed=AIR_SPEED)
    speed = _speed_name(path, stem)
    moves += post.weld_start(path, list, point=along[0], speed=speed, arc="" if arc is None else arc.text)
    moves += _weld_moves(path, along, end, speed=speed, arc=arc)
    moves += post.weld_end(path, list)
    for label in way_from:
        moves += post.air_move(label, speed=AIR_SPEED)
    return moves


def _weld_moves(path: WeldPath, along: list[str], end: str, *, speed: str, arc: ArcData | None) -> list[str]:
    lines = []
    moves = list(zip(path.weld_moves, path.stops(ZONE_MM), strict=True))
    for number, (move, stop) in enumerate(moves, 1):
        word = "C" if isinstance(move, Arc) else "L"
        to = f"{along[move.via]},{along[move.to]}" if isinstance(move, Arc) else along[move.to]
        zone = "fine" if stop else "z1"
        if arc is None:
            lines.append(f"    Move{word} {to},{speed},{zone},{end}")
        else:
            last = "End" if number == len(moves) else ""
            lines.append(f"    Arc{word}{last} {to},{speed},{arc.text},{zone},{end}")
    return lines
