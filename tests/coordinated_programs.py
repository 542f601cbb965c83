"""What controllers do in coordinated motion with written programs: read from the text alone, without the writers.

Each reader takes the files of one language and returns the common moves of both robots, and what it found wrong while
reading. `followed` interpolates both robots as the controllers do: the torch on lines and arcs in the frame of the held
part, robot 2 by joints or on lines (`coordinated_faults` judges that). The kinematics of the arms are products of plain
matrices. Sources of what the languages do: the writers (`coordinated.py` of each maker).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from tests.moves_of_programs import circle_through
from tests.program_text import numbers

Array = np.ndarray[Any, Any]
WRITTEN_MM = 5e-3  #: Rounding of the files: four decimals of a degree at 2 m in twelve joints are some micrometres.


class Step(NamedTuple):
    """One move: the torch in the part, and robot 2 (its joints, or the part in its base), at the middle and the end."""

    via: Array | None
    to: Array
    held_via: Array | None
    held: Array
    burns: bool


@dataclass
class Coordinated:
    """What was read: where both robots begin, their moves, how robot 2 moves, and what is wrong with the text."""

    start: Array
    held: Array
    steps: list[Step]
    by_joints: bool
    uses_via: bool = False
    wrong: list[str] = field(default_factory=list)


def frame(p: Array, R: Rotation) -> Array:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R.as_matrix(), p
    return T


def flange(arm: Any, joints: Array) -> Array:
    theta, d, a, alpha, _ = arm.chain.table
    T = arm.chain.T_base_dh0.matrix
    for i, angle in enumerate(arm.model_angles(joints) + theta):
        turn, twist = Rotation.from_euler("z", angle), Rotation.from_euler("x", alpha[i])
        T = T @ frame(np.array([0, 0, d[i]]), turn) @ frame(np.array([a[i], 0, 0]), twist)
    return T @ arm.chain.T_dhn_flange.matrix


def tool_in_world(cell: Any, joints1: Array) -> Array:
    return cell.T_world_base.matrix @ flange(cell.arm, joints1) @ cell.T_flange_tool.matrix


def part_in_world(cell: Any, held: Array) -> Array:
    """The part in the world: from joints of robot 2 (6,), or from the part in its base (4, 4)."""
    in_base = flange(cell.arm2, held) @ cell.T_part.matrix if held.ndim == 1 else held
    return cell.T_world_base2.matrix @ in_base


def in_part(cell: Any, tool: Array, held: Array) -> Array:
    return np.linalg.inv(part_in_world(cell, held)) @ tool


def both_marks(lines: list[str], on: str, off: str, wrong: list[str]) -> tuple[int, int]:
    """The numbers of the lines with the two comments around a seam; each must be there once."""
    for mark in (on, off):
        if sum(line.strip(" ;!'") == mark for line in lines) != 1:
            wrong.append(f"the mark {mark} is not there once")
            return 0, len(lines)
    at = {line.strip(" ;!'"): number for number, line in enumerate(lines)}
    return at[on], at[off]


def marks_of(lines: list[str], wrong: list[str]) -> tuple[int, int]:
    is_dry = any(line.strip(" ;!'") in ("ARC ON", "ARC OFF") for line in lines)
    return both_marks(lines, *(("ARC ON", "ARC OFF") if is_dry else ("SEAM START", "SEAM END")), wrong)


# ------------------------------------------------------------------------------------------------------------- ABB


def rapid_pose(p: str, q: str) -> Array:
    return frame(numbers(p), Rotation.from_quat(numbers(q)[[1, 2, 3, 0]]))


RAPID_TORCH = re.compile(r"(Move|Arc)([LC])(\w*) ((?:\w+,)?\w+)\\ID:=(\d+),(.*),(fine|z1),(\w+)\\WObj:=(\w+);")
RAPID_HELD = re.compile(r"(?:Arc)?MoveAbsJ (\w+)\\ID:=(\d+),(\w+),(fine|z1),(\w+);")


def rapid(files: dict[str, str], cell: Any) -> Coordinated:
    one, two = (next(text for name, text in files.items() if name.endswith(f"_R{k}.mod")) for k in (1, 2))
    wrong: list[str] = []
    joints = [
        {name: np.radians(numbers(q)) for name, q in re.findall(r"jointtarget (\w+):=\[\[(.*?)\]", text)}
        for text in (one, two)
    ]
    wobj = re.search(r'wobjdata (\w+):=\[(\w+),(\w+),"(\w*)",\[\[(.*?)\],\[(.*?)\]\],\[\[(.*?)\],\[(.*?)\]\]\]', one)
    if wobj.group(2, 3, 4) != ("FALSE", "FALSE", "ROB_2"):
        wrong.append("the work object is not in the hand of robot 2")
    held_at = rapid_pose(*wobj.group(5, 6)) @ rapid_pose(*wobj.group(7, 8))
    T_part_object = np.linalg.inv(cell.T_part.matrix) @ held_at
    poses = {
        name: T_part_object @ rapid_pose(p, q)
        for name, p, q in re.findall(r"robtarget (\w+):=\[\[(.*?)\],\[(.*?)\],", one)
    }
    bodies = [re.search(r"PROC \w+\(\)(.*?)ENDPROC", text, re.DOTALL)[1].splitlines() for text in (one, two)]
    first = [re.search(r"MoveAbsJ (\w+),vFirst,fine,(\w+);", "\n".join(body)) for body in bodies]
    if [found[2] for found in first] != ["tTorch", "tool0"]:
        wrong.append(f"tools of the first moves: {first[0][2]}, {first[1][2]}")
    held = {row[1]: (row[0], row[3], row[4]) for row in RAPID_HELD.findall("\n".join(bodies[1]))}
    on, off = marks_of(bodies[0], wrong)
    is_dry = any("! ARC ON" in line for line in bodies[0])
    steps, zones, is_on = [], [], False
    for number, line in enumerate(bodies[0]):
        match = RAPID_TORCH.search(line)
        if match is None:
            wrong += [f"not read: {line.strip()}"] if re.search(r"(Move|Arc)[LCJ]", line) else []
            continue
        word, _, part, names, mark, _, zone, tool, own = match.groups()
        if tool != "tTorch" or own != wobj[1]:
            wrong.append(f"mark {mark}: tool {tool} in {own}")
        if mark not in held:
            wrong.append(f"mark {mark} is missing in the program of robot 2")
            continue
        name, _, to = names.rpartition(",")
        burns = (is_on and word == "Arc") or (is_dry and on < number < off)
        is_on = part != "End" and (is_on or part == "Start")
        steps.append(Step(poses[name] if name else None, poses[to], None, joints[1][held[mark][0]], burns))
        zones.append((mark, zone))
    if is_on:
        wrong.append("the arc does not end")
    if [(mark, zone) for mark, (_, zone, tool) in held.items() if tool == "tool0"] != zones:
        wrong.append("robot 2 has other marks, zones or tools than robot 1")
    order = [re.findall(r"(SyncMoveO\w+) (\w+)", "\n".join(body)) for body in bodies]
    if order[0] != order[1] or [word for word, _ in order[0]] != ["SyncMoveOn", "SyncMoveOff"]:
        wrong.append("the robots do not wait for each other")
    if any(step.via is not None for step in steps) and not any(
        "CirPathMode\\ObjectFrame" in line for line in bodies[0]
    ):
        wrong.append("the tool turns with the tangent of arcs")
    start2 = joints[1][first[1][1]]
    start = in_part(cell, tool_in_world(cell, joints[0][first[0][1]]), start2)
    return Coordinated(start, start2, steps, by_joints=True, wrong=wrong)


# --------------------------------------------------------------------------------------------------------- Yaskawa


def inform(files: dict[str, str], cell: Any) -> Coordinated:
    (text,) = files.values()
    wrong: list[str] = []
    head, body = text.split("//INST")
    if not re.search(r"///GROUP1 RB1\s+///GROUP2 RB2\s", body):
        wrong.append("the groups are not the torch and the part")
    joints, tool = {}, ""
    for line in head.splitlines():
        tool = line.split()[-1] if line.startswith("///TOOL") else tool
        if found := re.fullmatch(r"C(\d{5})=(.*)", line):
            number = int(found[1])
            arm = (cell.arm, cell.arm2)[number % 2]
            values = numbers(found[2])
            joints[number] = arm.angles_from_pulses(values) if "PULSE" in head else np.radians(values)
            if tool != ("1", "0")[number % 2]:
                wrong.append(f"position {number} has tool {tool}")
    first = re.search(r"MOVJ C(\d+) VJ=[\d.]+ PL=0  \+MOVJ C(\d+) VJ=[\d.]+", body)
    pose = {n: in_part(cell, tool_in_world(cell, joints[n]), joints[n + 1]) for n in joints if n % 2 == 0}
    start, held = int(first[1]), int(first[2])
    steps = list(inform_steps(body.splitlines(), start, pose, joints, wrong))
    return Coordinated(pose[start], joints[held], steps, by_joints=True, uses_via=True, wrong=wrong)


def inform_steps(
    lines: list[str], at: int, pose: dict[int, Array], joints: dict[int, Array], wrong: list[str]
) -> Iterator[Step]:
    on, off = marks_of(lines, wrong)
    is_dry, is_on, waiting = "'ARC ON" in lines, False, list[int]()
    for number, line in enumerate(lines):
        is_on = (is_on or line.startswith("ARCON")) and not line.startswith("ARCOF")
        if line.startswith("MOV") and number > on:
            wrong.append(f"not coordinated: {line}")
        match = re.fullmatch(r"SMOV([LC]) C(\d+) V=[\d.]+ PL=[01]  \+MOVJ C(\d+)", line)
        if match is None:
            continue
        own, held = int(match[2]), int(match[3])
        if held != own + 1:
            wrong.append(f"line {number}: robot 2 goes to position {held}")
        burns = on < number < off if is_dry else is_on
        if match[1] == "C":
            waiting.append(own)
            if waiting[0] != at:
                wrong.append(f"line {number}: the arc does not begin where the torch is")
            if len(waiting) < 3:
                continue
            yield Step(pose[waiting[1]], pose[own], joints[waiting[1] + 1], joints[held], burns)
            waiting = []
        elif own != at:
            yield Step(None, pose[own], None, joints[held], burns)
        at = own
    if is_on or waiting:
        wrong.append("the arc does not end")


# ----------------------------------------------------------------------------------------------------------- FANUC


def fanuc(files: dict[str, str], cell: Any) -> Coordinated:
    (text,) = files.values()
    wrong: list[str] = []
    body, positions = text.split("/POS")
    if "DEFAULT_GROUP = 1,1,*,*,*;" not in body:
        wrong.append("the program does not move both groups")
    poses: dict[str, tuple[Array, Array]] = {}
    for name, block in re.findall(r"^P\[(\d+)\]\{(.*?)\};", positions, re.DOTALL | re.MULTILINE):
        both = {}
        for group, own in re.findall(r"GP(\d):(.*?)(?=GP\d:|\Z)", block, re.DOTALL):
            used = re.search(r"UF : (\d+), UT : (\d+)", own).groups()
            if used != ("0", "1"):
                wrong.append(f"P[{name}] of group {group} is in frame {used[0]} with tool {used[1]}")
            v = [float(re.search(rf"\b{key} =\s*([-\d.]+)", own)[1]) for key in "XYZWPR"]
            both[group] = frame(np.array(v[:3]), Rotation.from_euler("ZYX", v[:2:-1], degrees=True))
        tool, part = both["1"], both["2"]
        poses[name] = in_part(cell, cell.T_world_base.matrix @ tool, part), part
    told = [float(re.search(rf"\d:  ! +{key} ([-\d.]+) ;", body)[1]) for key in "XYZWPR"]
    if np.abs(np.array(told[:3]) - cell.T_part.t_mm).max() > WRITTEN_MM:
        wrong.append("the tool of group 2 is not where the part is held")
    lines = [re.sub(r"^\s*\d+:\s*", "", line) for line in body.splitlines()]
    on, off = marks_of(lines, wrong)
    is_dry = any("ARC ON" in line for line in lines if line.startswith("!") and "comments" not in line)
    first = re.search(r"J P\[(\d+)\] \d+% FINE", body)[1]
    steps, is_on = [], False
    for number, line in enumerate(lines):
        is_on = (is_on or line.startswith("Weld Start")) and not line.startswith("Weld End")
        if match := re.match(r"([LC]) P\[(\d+)\] \S+ (?:FINE|CNT100)( COORD)?", line):
            if match[1] == "C" or not match[3]:
                wrong.append(f"not a coordinated line: {line}")
            T, part = poses[match[2]]
            steps.append(Step(None, T, None, part, on < number < off if is_dry else is_on))
    return Coordinated(*poses[first], steps, by_joints=False, uses_via=True, wrong=wrong)


# ------------------------------------------------------------------------------------------------------------ KUKA


def krl_frame(text: str) -> Array:
    v = numbers(re.sub(r"[A-Z]\d? ", "", text))
    return frame(v[:3], Rotation.from_euler("ZYX", v[3:6], degrees=True))


def krl(files: dict[str, str], cell: Any) -> Coordinated:
    texts = {name[-6:]: text for name, text in files.items()}
    source, data = ([texts[f"R{k}.{end}"] for k in (1, 2)] for end in ("src", "dat"))
    wrong: list[str] = []
    poses = [{n: krl_frame(v) for n, v in re.findall(r"E6POS (\w+)=\{(.*?)\}", text)} for text in data]
    axes = [np.radians(numbers(re.sub(r"A\d ", "", re.search(r"START=\{(.*?)\}", text)[1]))) for text in data]
    for text in data:
        held = krl_frame(re.search(r"FRAME PART_HELD=\{(.*?)\}", text)[1])
        if np.abs(held - cell.T_part.matrix).max() > WRITTEN_MM:
            wrong.append("PART_HELD is not where the part is held")
    tools = [re.search(r"\$TOOL=(\S+)", text)[1] for text in source]
    bases = [re.search(r"\$BASE=(\S+)", text)[1] for text in source]
    if tools != ["TOOL_DATA[1]", "PART_HELD"]:
        wrong.append(f"tools {tools}")
    if bases != ["SBASE(1)", "$NULLFRAME"]:
        wrong.append(f"bases {bases}")
    pattern = re.compile(
        r"(SLIN|SCIRC) (?:(\w+),)?(\w+) WITH \$VEL\.CP=[\d.]+,\$SYNC_ID\[\]=\"(\w+)\",\$SYNC_LIST='B0011'( C_SPL)?"
    )
    moves = [[pattern.fullmatch(line) for line in text.splitlines()] for text in source]
    held_moves = {m[4]: (poses[1][m[3]], m[5]) for m in moves[1] if m}
    if [(m[4], m[5]) for m in moves[0] if m] != [(m[4], m[5]) for m in moves[1] if m]:
        wrong.append("robot 2 has other marks than robot 1")
    lines = source[0].splitlines()
    on, off = marks_of(lines, wrong)
    is_dry = "; ARC ON" in lines
    steps, is_on = [], False
    for number, (line, match) in enumerate(zip(lines, moves[0], strict=True)):
        ends = line.startswith("ARC_END") or line.endswith("=FALSE")
        is_on = not ends and (is_on or line.startswith("ARC_START") or line.endswith("=TRUE"))
        if match is None or match[4] not in held_moves:
            continue
        via = poses[0][match[2]] if match[2] else None
        burns = on < number < off if is_dry else is_on
        steps.append(Step(via, poses[0][match[3]], None, held_moves[match[4]][0], burns))
    if is_on:
        wrong.append("the arc does not end")
    start2 = flange(cell.arm2, axes[1]) @ cell.T_part.matrix
    start = in_part(cell, tool_in_world(cell, axes[0]), start2)
    return Coordinated(start, start2, steps, by_joints=False, wrong=wrong)


READERS: dict[str, Callable[[dict[str, str], Any], Coordinated]] = {
    "rapid": rapid,
    "inform": inform,
    "fanuc": fanuc,
    "krl": krl,
}


# ------------------------------------------------------------------------------------------------------ the motion


def torch_between(before: Array, step: Step, t: Array, *, uses_via: bool) -> Array:
    """The torch in the part at shares t of a move, shape (m, 4, 4), as a controller has it."""
    p0, p1 = before[:3, 3], step.to[:3, 3]
    R0, R1 = (Rotation.from_matrix(T[:3, :3]) for T in (before, step.to))
    T, middle = np.tile(np.eye(4), (len(t), 1, 1)), None
    if step.via is None:
        T[:, :3, 3] = p0 + t[:, None] * (p1 - p0)
    else:
        centre, normal, sweep, middle = circle_through(p0, step.via[:3, 3], p1)
        T[:, :3, 3] = centre + Rotation.from_rotvec(np.outer(t * sweep, normal)).apply(p0 - centre)
    if middle is not None and uses_via:
        at = Rotation.concatenate([R0, Rotation.from_matrix(step.via[:3, :3]), R1])
        T[:, :3, :3] = Slerp([0.0, middle, 1.0], at)(t).as_matrix()
    else:
        T[:, :3, :3] = Slerp([0.0, 1.0], Rotation.concatenate([R0, R1]))(t).as_matrix()
    return T


def held_between(before: Array, step: Step, t: Array, middle: float, *, by_joints: bool) -> Iterator[Array]:
    """Robot 2 at the same shares: joints that move evenly, or the part on a line and about one axis."""
    if by_joints and step.held_via is not None:
        at = np.array([before, step.held_via, step.held])
        yield from (np.array([np.interp(x, [0, middle, 1], column) for column in at.T]) for x in t)
    elif by_joints:
        yield from (before + x * (step.held - before) for x in t)
    else:
        turns = Rotation.from_matrix(np.array([before[:3, :3], step.held[:3, :3]]))
        for x, R in zip(t, Slerp([0.0, 1.0], turns)(t), strict=True):
            yield frame(before[:3, 3] + x * (step.held[:3, 3] - before[:3, 3]), R)


def followed(read: Coordinated, cell: Any, count: int = 9) -> tuple[Array, Array, Array]:
    """Both robots at `count` places of every move.

    Returns the torch in the part and the part in the world, both (m, 4, 4), and whether the arc burns there.
    """
    t = np.linspace(0.0, 1.0, count)
    torch, part, burns = [], [], []
    before, held = read.start, read.held
    for step in read.steps:
        middle = 0.5
        if step.via is not None:
            middle = circle_through(before[:3, 3], step.via[:3, 3], step.to[:3, 3])[3]
        torch.append(torch_between(before, step, t, uses_via=read.uses_via))
        part += [part_in_world(cell, q) for q in held_between(held, step, t, middle, by_joints=read.by_joints)]
        burns += [step.burns] * count
        before, held = step.to, step.held
    return np.concatenate(torch), np.array(part), np.array(burns)
