"""What controllers do in coordinated motion with written programs: read from the text alone, without the writers.

Each reader takes the files of one language and returns the common moves of both robots, and what it found wrong while
reading. `followed` interpolates both robots as the controllers do: the torch on lines and arcs in the frame of the held
part, robot 2 by joints or on lines (`coordinated_faults` judges that). The kinematics of the arms are products of plain
matrices. Sources of what the languages do: the writers (`coordinated.py` of each maker).
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from tests.moves_of_programs import Step as Move
from tests.moves_of_programs import Weld, circle_through
from tests.moves_of_programs import followed as followed_alone
from tests.program_text import krl_pose, lists, numbers, posed, quaternion, turned

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


def flange(arm: Any, joints: Array) -> Array:
    theta, d, a, alpha, _ = arm.chain.table
    T = arm.chain.T_base_dh0.matrix
    for i, angle in enumerate(arm.model_angles(joints) + theta):
        turn, twist = Rotation.from_euler("z", angle), Rotation.from_euler("x", alpha[i])
        T = T @ posed([0, 0, d[i]], turn) @ posed([a[i], 0, 0], twist)
    return T @ arm.chain.T_dhn_flange.matrix


def tool_in_world(cell: Any, joints1: Array) -> Array:
    return cell.T_world_base.matrix @ flange(cell.arm, joints1) @ cell.T_flange_tool.matrix


def part_in_world(cell: Any, held: Array) -> Array:
    """The part in the world: from joints of robot 2 (6,), or from the part in its base (4, 4)."""
    in_base = flange(cell.arm2, held) @ cell.T_part.matrix if held.ndim == 1 else held
    return cell.T_world_base2.matrix @ in_base


def in_part(cell: Any, tool: Array, held: Array) -> Array:
    return np.linalg.inv(part_in_world(cell, held)) @ tool


def burning(lines: list[str], starts: str, ends: str, wrong: list[str]) -> Iterator[tuple[str, bool]]:
    """Yield lines, and whether the arc burns there: between the comments of a dry run, or two instructions."""
    bare = [line.strip(" ;!'") for line in lines]
    is_dry = "ARC ON" in bare or "ARC OFF" in bare
    marks = ("ARC ON", "ARC OFF") if is_dry else ("SEAM START", "SEAM END")
    wrong += [f"the mark {mark} is not there once" for mark in marks if bare.count(mark) != 1]
    is_on = False
    for number, line in enumerate(lines):
        seen = bare[:number]
        yield line, marks[0] in seen and marks[1] not in seen if is_dry else is_on
        is_on = (is_on or re.search(starts, line) is not None) and not re.search(ends, line)
    if is_on:
        wrong.append("the arc does not end")


def rapid(files: dict[str, str], cell: Any) -> Coordinated:
    one, two = (next(text for name, text in files.items() if name.endswith(f"_R{k}.mod")) for k in (1, 2))
    wrong: list[str] = []
    joints = [
        {name: np.radians(q) for name, (q,) in lists(r"jointtarget (\w+):=\[\[(.*?)\]", text).items()}
        for text in (one, two)
    ]
    wobj = re.search(r'wobjdata (\w+):=\[(\w+),(\w+),"(\w*)",\[\[(.*?)\],\[(.*?)\]\],\[\[(.*?)\],\[(.*?)\]\]\]', one)
    if wobj.group(2, 3, 4) != ("FALSE", "FALSE", "ROB_2"):
        wrong.append("the work object is not in the hand of robot 2")
    user, held_at, *_ = (posed(numbers(wobj[k]), quaternion(numbers(wobj[k + 1]))) for k in (5, 7))
    T_part_object = np.linalg.inv(cell.T_part.matrix) @ user @ held_at
    poses = {
        name: T_part_object @ posed(p, quaternion(q))
        for name, (p, q) in lists(r"robtarget (\w+):=\[\[(.*?)\],\[(.*?)\],", one).items()
    }
    bodies = [re.search(r"PROC \w+\(\)(.*?)ENDPROC", text, re.DOTALL)[1] for text in (one, two)]
    first = [re.search(r"MoveAbsJ (\w+),vFirst,fine,(\w+);", body) for body in bodies]
    if [found[2] for found in first] != ["tTorch", "tool0"]:
        wrong.append(f"tools of the first moves: {first[0][2]}, {first[1][2]}")
    moves = re.findall(r"(?:Arc)?MoveAbsJ (\w+)\\ID:=(\d+),\w+,(fine|z1),(\w+);", bodies[1])
    held, marks = {mark: name for name, mark, *_ in moves}, []
    pattern = re.compile(r"(Move|Arc)[LC](\w*) (?:(\w+),)?(\w+)\\ID:=(\d+),.*,(fine|z1),(\w+)\\WObj:=(\w+);")
    steps = []
    for line, burns in burning(bodies[0].splitlines(), "Arc[LC]Start", "Arc[LC]End", wrong):
        if (match := pattern.search(line)) is None:
            wrong += [f"not read: {line.strip()}"] if re.search(r"(Move|Arc)[LCJ]", line) else []
            continue
        via, to, mark, zone, tool, own = match.groups()[2:]
        if tool != "tTorch" or own != wobj[1] or mark not in held:
            wrong.append(f"mark {mark}: tool {tool} in {own}, and is it in the program of robot 2?")
            continue
        is_lit = burns and (match[1] == "Arc" or "! ARC ON" in bodies[0])
        steps.append(Step(poses[via] if via else None, poses[to], None, joints[1][held[mark]], is_lit))
        marks.append((mark, zone, "tool0"))
    if [row[1:] for row in moves] != marks:
        wrong.append("robot 2 has other marks, zones or tools than robot 1")
    order = [re.findall(r"(SyncMoveO\w+) (\w+)", body) for body in bodies]
    if order[0] != order[1] or [word for word, _ in order[0]] != ["SyncMoveOn", "SyncMoveOff"]:
        wrong.append("the robots do not wait for each other")
    if any(step.via is not None for step in steps) and "CirPathMode\\ObjectFrame" not in bodies[0]:
        wrong.append("the tool turns with the tangent of arcs")
    start2 = joints[1][first[1][1]]
    start = in_part(cell, tool_in_world(cell, joints[0][first[0][1]]), start2)
    return Coordinated(start, start2, steps, by_joints=True, wrong=wrong)


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
    at, steps, waiting = int(first[1]), [], list[int]()
    for line, burns in burning(body.splitlines(), "^ARCON", "^ARCOF", wrong):
        if line.startswith("MOV") and steps:
            wrong.append(f"not coordinated: {line}")
        match = re.fullmatch(r"SMOV([LC]) C(\d+) V=[\d.]+ PL=[01]  \+MOVJ C(\d+)", line)
        if match is None:
            continue
        own = int(match[2])
        if int(match[3]) != own + 1:
            wrong.append(f"{line}: robot 2 goes to another position")
        is_arc = match[1] == "C"
        wrong += ["an arc has three positions"] if waiting and not is_arc else []
        waiting = [*waiting, own] if is_arc else []
        wrong += [f"{line}: the arc does not begin where the torch is"] if len(waiting) == 1 and own != at else []
        if len(waiting) == 3:
            steps.append(Step(pose[waiting[1]], pose[own], joints[waiting[1] + 1], joints[own + 1], burns))
            waiting = []
        elif not is_arc and own != at:
            steps.append(Step(None, pose[own], None, joints[own + 1], burns))
        at = at if len(waiting) == 2 else own
    wrong += ["an arc has three positions"] if waiting else []
    return Coordinated(pose[int(first[1])], joints[int(first[2])], steps, by_joints=True, uses_via=True, wrong=wrong)


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
            both[group] = posed(*turned("xyz", v))
        tool, part = both["1"], both["2"]
        poses[name] = in_part(cell, cell.T_world_base.matrix @ tool, part), part
    told = [float(re.search(rf"\d:  ! +{key} ([-\d.]+) ;", body)[1]) for key in "XYZWPR"]
    if np.abs(np.array(told[:3]) - cell.T_part.t_mm).max() > WRITTEN_MM:
        wrong.append("the tool of group 2 is not where the part is held")
    lines = [re.sub(r"^\s*\d+:\s*", "", line) for line in body.splitlines()]
    first = re.search(r"J P\[(\d+)\] \d+% FINE", body)[1]
    steps = []
    for line, burns in burning(lines, "^Weld Start", "^Weld End", wrong):
        if match := re.match(r"([LC]) P\[(\d+)\] \S+ (?:FINE|CNT100)( COORD)?", line):
            if match[1] == "C" or not match[3]:
                wrong.append(f"not a coordinated line: {line}")
            T, part = poses[match[2]]
            steps.append(Step(None, T, None, part, burns))
    return Coordinated(*poses[first], steps, by_joints=False, uses_via=True, wrong=wrong)


def krl(files: dict[str, str], cell: Any) -> Coordinated:
    source, data = (
        [next(text for name, text in files.items() if name.endswith(f"_R{k}.{end}")) for k in (1, 2)]
        for end in ("src", "dat")
    )
    wrong: list[str] = []
    poses = [{n: posed(*krl_pose(v)) for n, v in re.findall(r"E6POS (\w+)=\{(.*?)\}", text)} for text in data]
    axes = [np.radians(numbers(re.sub(r"A\d ", "", re.search(r"START=\{(.*?)\}", text)[1]))) for text in data]
    for text in data:
        held = posed(*krl_pose(re.search(r"FRAME PART_HELD=\{(.*?)\}", text)[1]))
        if np.abs(held - cell.T_part.matrix).max() > WRITTEN_MM:
            wrong.append("PART_HELD is not where the part is held")
    used = [re.search(rf"\${what}=(\S+)", text)[1] for what in ("TOOL", "BASE") for text in source]
    if used != ["TOOL_DATA[1]", "PART_HELD", "SBASE(1)", "$NULLFRAME"]:
        wrong.append(f"tools and bases {used}")
    pattern = re.compile(
        r"S(?:LIN|CIRC) (?:(\w+),)?(\w+) WITH \$VEL\.CP=[\d.]+,\$SYNC_ID\[\]=\"(\w+)\",\$SYNC_LIST='B0011'( C_SPL)?"
    )
    moves = [[m for line in text.splitlines() if (m := pattern.fullmatch(line))] for text in source]
    if [m.group(3, 4) for m in moves[0]] != [m.group(3, 4) for m in moves[1]]:
        wrong.append("robot 2 has other marks than robot 1")
    held_at = {m[3]: poses[1][m[2]] for m in moves[1]}
    steps = []
    for line, burns in burning(source[0].splitlines(), "^ARC_START|=TRUE$", "^ARC_END|=FALSE$", wrong):
        if (match := pattern.fullmatch(line)) and match[3] in held_at:
            via = poses[0][match[1]] if match[1] else None
            steps.append(Step(via, poses[0][match[2]], None, held_at[match[3]], burns))
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
            yield posed(before[:3, 3] + x * (step.held[:3, 3] - before[:3, 3]), R)


def followed(read: Coordinated, cell: Any, count: int = 9) -> tuple[Array, Array, Array]:
    """Both robots at `count` places of every move.

    Returns the torch in the part and the part in the world, both (m, 4, 4), and whether the arc burns there.
    """
    pairs = [(each, Rotation.from_matrix(each[:3, :3])) for each in (read.start, *(step.to for step in read.steps))]
    start, *ends = ((T[:3, 3], R) for T, R in pairs)
    vias = (None if s.via is None else (s.via[:3, 3], Rotation.from_matrix(s.via[:3, :3])) for s in read.steps)
    torch = followed_alone(Weld(start, [Move(*each) for each in zip(vias, ends, strict=True)], read.uses_via), count)
    part, burns, before, held = list[Array](), list[bool](), read.start, read.held
    for step in read.steps:
        via = step.via
        middle = 0.5 if via is None else circle_through(before[:3, 3], via[:3, 3], step.to[:3, 3])[3]
        between = held_between(held, step, np.linspace(0.0, 1.0, count), middle, by_joints=read.by_joints)
        part += [part_in_world(cell, q) for q in between]
        burns += [step.burns] * count
        before, held = step.to, step.held
    return np.array([posed(p, R) for p, R in zip(*torch, strict=True)]), np.array(part), np.array(burns)
