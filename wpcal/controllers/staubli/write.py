"""Staubli VAL3: an application (``.pjx``, ``.dtx``, ``start.pgx``, ``stop.pgx``) with the part's frame and points.

rx, ry, rz in degrees are rotations about moving axes, ``R = Rx(rx) Ry(ry) Rz(rz)``; lengths in mm. Points are children
of the frame ``fPart``. The configuration is written as *same*: the arm keeps the present one. In a plan it is that of
the joint move before each seam. The tool is not declared: the application does not start until a person declares the
torch.

References
----------
Staubli, VAL3 Reference Manual (pointRx, jointRx, frame, mdesc; configuration ssame, esame, wsame).
"""

from __future__ import annotations

from functools import partial

import numpy as np

from wpcal.controllers.language.naming import NameRules, comment_lines, own_name, safe_name, safe_names
from wpcal.controllers.language.post import Post
from wpcal.controllers.language.rounding import rounded, zyx_degrees
from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe, describe_path, part_frame
from wpcal.controllers.program.planned import PlannedMoves, angle_texts
from wpcal.controllers.staubli.arc import SWITCH, how
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.robot.moves import Arc

KEYWORDS = (
    "and begin call case default do else elseif end endfor endif endswitch endwhile false for fpart global if link "
    "jplan local mair mjoint mweld not npoint or put return start stop step switch then to true until while wpsafe xor"
)
NAMES = NameRules("VAL3", 15, KEYWORDS)
"""Names of variables have up to 15 characters."""
MOST_POINTS = 9999
"""Elements of an array."""
MM_DECIMALS = 5
DEG_DECIMALS = 6
"""As for the other controllers with 32-bit numbers, which resolve 1e-4 mm and 1e-5 deg."""
COUNTER = ('    <Data name="nPoint" access="private" xsi:type="array" type="num" size="1" />',)
"""Of a loop over all points of a seam."""
BLEND_MM = 0.5
"""Half of the default least step of seams: blends of neighbours touch and do not overlap."""
PLANNED_MM_S = 500
"""Limit of the tip in the joint moves of a plan: the joints limit most of them."""
JOINT_PERCENT = 10
"""Of joint moves. Slow, because the arm can come from anywhere."""
MOTION = "m"
"""The name of the motion of a seam with a speed of its own is this and the name of the seam."""
JOINTS = "jPlan"
"""The joints that a plan goes to between seams, in one array."""
SAFE_POINT = "wpSafe"
"""The point above the part at which the program starts and ends."""
LONGEST_COMMENT = 100
XML = '<?xml version="1.0" encoding="utf-8"?>'
STAUBLI = "http://www.staubli.com/robotics/VAL3"
XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'


def write_val3(program: WeldProgram) -> dict[str, str]:
    """Write a VAL3 application. ``NAME.pjx``, ``NAME.dtx``, ``start.pgx``, ``stop.pgx``.

    Raises
    ------
    InputError : When a seam has too many points, or VAL3 does not allow the tool's name.
    """
    for path in program.paths:
        if len(path) > MOST_POINTS:
            raise InputError(f"VAL3: seam {path.seam.name} has {len(path)} points, an array at most {MOST_POINTS}")
    name = safe_name(program.controller.program_name, NAMES)
    room = 0 if all(path.run is None for path in program.paths) else len(MOTION)
    names = safe_names([path.seam.name for path in program.paths], NAMES, room=room)
    return {
        f"{name}.pjx": _project(name),
        f"{name}.dtx": _database(program, names),
        "start.pgx": _program("start", _start(program, names)),
        "stop.pgx": _program("stop", ["  resetMotion()"]),
    }


def _project(name: str) -> str:
    lines = [
        XML,
        f'<Project xmlns="{STAUBLI}/Project/3">',
        '  <Parameters version="s7.3.1" stackSize="5000" millimeterUnit="true" />',
        '  <Programs>\n    <Program file="start.pgx" />\n    <Program file="stop.pgx" />\n  </Programs>',
        f'  <Database>\n    <Data file="{name}.dtx" />\n  </Database>',
        "  <Libraries />",
        "</Project>",
        "",
    ]
    return "\n".join(lines)


def _database(program: WeldProgram, names: dict[str, str]) -> str:
    T_base_frame = _frame_as_written(program.T_base_part)
    frame = _coordinates(T_base_frame.t_mm[None], T_base_frame.R[None])[0]
    lines = [
        XML,
        f'<Database {XSI} xmlns="{STAUBLI}/Data/2">',
        "  <Datas>",
        *_data("fPart", "frame", [f'{frame} fatherId="world[0]"']),
        *_data("mAir", "mdesc", [_motion(program.motion.air_speed_mm_s, "off")]),
        *_data("mJoint", "mdesc", [_joint_motion(program)]),
        *_data("mWeld", "mdesc", [_motion(program.motion.speed_mm_s, "cartesian")]),
        *_motions_of_seams(program, names),
        *(COUNTER if any(path.moves is None for path in program.paths) else ()),
    ]
    same = 'shoulder="ssame" elbow="esame" wrist="wsame" fatherId="fPart[0]"'
    lines += _joint_targets(program.planned)
    if program.safe_point is not None:
        (text,) = _coordinates(*program.safe_point.poses_in(T_base_frame))
        lines += _data(SAFE_POINT, "pointRx", [f"{text} {same}"])
    for path in program.paths:
        points = [f"{text} {same}" for text in _coordinates(*path.poses_in(T_base_frame))]
        lines += _data(names[path.seam.name], "pointRx", points[_first_point(path, program) :])
    return "\n".join([*lines, "  </Datas>", "</Database>", ""])


def _joint_motion(program: WeldProgram) -> str:
    if program.planned is None:
        return _motion(program.motion.air_speed_mm_s, "off", percent=JOINT_PERCENT)
    return _motion(PLANNED_MM_S, "off", percent=round(program.planned.joint_percent))


def _joint_targets(planned: PlannedMoves | None) -> list[str]:
    """Declare the joints that a plan goes to."""
    if planned is None:
        return []
    rows = [row for moves in planned.air for row in angle_texts(moves.joints, DEG_DECIMALS)]
    return _data(JOINTS, "jointRx", [" ".join(f'j{n}="{v}"' for n, v in enumerate(row, start=1)) for row in rows])


def _first_point(path: WeldPath, program: WeldProgram) -> int:
    """Return the first pose of a path that is a point: a plan goes to joints before a seam."""
    return 0 if program.planned is None else path.before


def _motions_of_seams(program: WeldProgram, names: dict[str, str]) -> list[str]:
    """Declare the motion of every seam that has a speed of its own."""
    lines = []
    for path in program.paths:
        if path.run is not None:
            motion = _motion(program.weld_speed_mm_s(path), "cartesian")
            lines += _data(_motion_name(path, names[path.seam.name]), "mdesc", [motion])
    return lines


def _motion_name(path: WeldPath, name: str) -> str:
    return "mWeld" if path.run is None else f"{MOTION}{name}"


def _data(name: str, kind: str, values: list[str]) -> list[str]:
    return [
        f'    <Data name="{name}" access="public" xsi:type="array" type="{kind}" size="{len(values)}">',
        *(f'      <Value key="{key}" {value} />' for key, value in enumerate(values)),
        "    </Data>",
    ]


def _motion(speed_mm_s: float, blend: str, *, percent: int = 100) -> str:
    limits = f'accel="{percent}" vel="{percent}" decel="{percent}" tmax="{speed_mm_s:g}" rmax="100"'
    return f'{limits} blend="{blend}" leave="{BLEND_MM:g}" reach="{BLEND_MM:g}"'


def _angles(R: FloatArray) -> FloatArray:
    """Return rx, ry, rz: the transpose of Rx(a) Ry(b) Rz(c) is Rz(-c) Ry(-b) Rx(-a)."""
    return rounded(-zyx_degrees(np.swapaxes(R, -1, -2), decimals=DEG_DECIMALS), DEG_DECIMALS)


def _frame_as_written(T: RigidTransform) -> RigidTransform:
    """Return the frame with the written digits: its rounding then does not move the points in the base."""
    a, b, c = np.radians(_angles(T.R))
    return RigidTransform(rotation_from_zyx(-a, -b, -c).T, rounded(T.t_mm, MM_DECIMALS), T.target, T.source)


def _coordinates(p: FloatArray, R: FloatArray) -> list[str]:
    m, k = MM_DECIMALS, DEG_DECIMALS
    rows = zip(rounded(p, m).tolist(), _angles(R).tolist(), strict=True)
    return [
        f'x="{x:.{m}f}" y="{y:.{m}f}" z="{z:.{m}f}" rx="{a:.{k}f}" ry="{b:.{k}f}" rz="{c:.{k}f}"'
        for (x, y, z), (a, b, c) in rows
    ]


def _program(name: str, code: list[str]) -> str:
    lines = [
        XML,
        f'<Programs {XSI} xmlns="{STAUBLI}/Program/2">',
        f'  <Program name="{name}" access="public">',
        "    <Code><![CDATA[begin",
        *(line.replace("]]>", "]] >") for line in code),  # what would end the section
        "end]]></Code>",
        "  </Program>",
        "</Programs>",
        "",
    ]
    return "\n".join(lines)


def _start(program: WeldProgram, names: dict[str, str]) -> list[str]:
    tool, planned = own_name(program.controller.tool_name, NAMES, what="tool"), program.planned
    text = [
        *describe(program),
        *(planned.standing_axes("VAL3") if planned is not None else ()),
        f"points are children of fPart, {part_frame(program)}; mm; R = Rx(rx) Ry(ry) Rz(rz), deg",
        f"written with {MM_DECIMALS} and {DEG_DECIMALS} decimals: within 0.00001 mm and 0.000001 deg",
        "the configuration is not known: the arm keeps the one it comes with (same)"
        if planned is None
        else "the configuration is that of the joint move before each seam: the arm keeps it (same)",
        f"declare the tool {tool} in this application; {how(program.arc)}",
        "seam -> name here",
        *(f"  {path.seam.name} -> {names[path.seam.name]}: {describe_path(path)}" for path in program.paths),
    ]
    post = Post("val3", program)
    lines = post.header(comment_lines(text, mark="", longest=LONGEST_COMMENT))
    if program.safe_point is not None:
        lines += [*post.air_move(SAFE_POINT, speed="mJoint", joint=True), "  waitEndMove()"]
    between = _between(program, post)
    for way, path in zip(between, program.paths, strict=False):
        lines += [*way, *_moves(path, names[path.seam.name], tool, post)]
    lines += between[-1]
    if program.safe_point is not None:
        lines += [*post.air_move(SAFE_POINT, speed="mAir"), "  waitEndMove()"]
    return [*lines, *post.footer()]


def _between(program: WeldProgram, post: Post) -> list[list[str]]:
    """Return the joint moves of a plan before each seam and after the last; the arm stops at each of their ends."""
    if program.planned is None:
        return [[] for _ in range(len(program.paths) + 1)]
    return [
        [line for number in numbers for line in post.joint_move(f"{JOINTS}[{number - 1}]", speed="mJoint")]
        + ["  waitEndMove()"]
        for _, numbers in program.planned.numbered()
    ]


def _moves(path: WeldPath, name: str, tool: str, post: Post) -> list[str]:
    program = post.program
    skipped = _first_point(path, program)
    start, stop, count = path.weld_rows.start - skipped, path.weld_rows.stop - skipped, len(path) - skipped
    is_joint, arc = program.safe_point is None, program.arc
    lines = []
    if program.planned is None:
        lines += post.air_move(f"{name}[0]", speed="mJoint" if is_joint else "mAir", joint=is_joint)
    for row in range(1 - skipped, start + 1):
        lines += post.air_move(f"{name}[{row}]", speed="mAir")
    lines += [
        "  waitEndMove()",
        *post.weld_start(path, list if arc is None else partial(SWITCH.start_lines, path, arc)),
    ]
    lines += _weld_moves(path, name, tool, motion=_motion_name(path, name), first=start)
    lines += post.weld_end(path, list if arc is None else partial(SWITCH.end_lines, path, arc))
    for row in range(stop, count):
        lines += post.air_move(f"{name}[{row}]", speed="mAir")
    return [*lines, "  waitEndMove()"]


def _weld_moves(path: WeldPath, name: str, tool: str, *, motion: str, first: int) -> list[str]:
    last = first + path.weld_count - 1
    if path.moves is None:
        loop = f"  for nPoint={first + 1} to {last}", f"    movel({name}[nPoint],{tool},{motion})", "  endFor"
        return [*loop, "  waitEndMove()"]
    lines = []
    for move, stop in zip(path.weld_moves, path.stops(BLEND_MM), strict=True):
        to = f"{name}[{first + move.to}],{tool},{motion}"
        lines.append(f"  movec({name}[{first + move.via}],{to})" if isinstance(move, Arc) else f"  movel({to})")
        lines += ["  waitEndMove()"] if stop else []
    return lines
