"""The motions in the text of programs, for the second judge: readers of five languages that share nothing with ours."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from tests.moves_of_programs import numbers
from tests.program_text import as_values, krl_pose, quaternion
from tests.wire_judge import Array


class Step(NamedTuple):
    """One move: to joints (deg), by the joints or on a line, or to a pose in the base, perhaps over another one."""

    kind: str
    joints: Array | None = None
    goal: Array | None = None
    via: Array | None = None
    via_joints: Array | None = None
    name: str = ""  #: Of the target, in RAPID and KRL.


def posed(p: Any, R: Rotation) -> Array:
    T = np.eye(4)
    T[:3, 3], T[:3, :3] = p, R.as_matrix()
    return T


def _called(bodies: dict[str, list[str]], name: str, call: str) -> Iterator[str]:
    for line in bodies[name]:
        found = re.fullmatch(call, line.strip())
        if found and found[1].upper() in {each.upper() for each in bodies}:
            yield from _called(bodies, next(one for one in bodies if one.upper() == found[1].upper()), call)
        else:
            yield line.strip()


def _routines(bodies: dict[str, list[str]], call: str) -> Iterator[list[str]]:
    """Yield the lines of each routine that no other one calls."""
    called = {m[1].upper() for lines in bodies.values() for line in lines if (m := re.fullmatch(call, line.strip()))}
    yield from ([*_called(bodies, name, call)] for name in bodies if name.upper() not in called)


def rapid(files: dict[str, str]) -> Iterator[list[Step]]:
    (text,) = files.values()
    v = numbers(re.search(r"wobjdata wpPart:=(.*?);", text)[1])
    T = posed(v[:3], quaternion(v[3:7]))
    joints = {n: numbers(q) for n, q in re.findall(r"jointtarget (\w+):=\[\[(.*?)\]", text)}
    poses = {
        n: T @ posed(numbers(p), quaternion(numbers(q)))
        for n, p, q in re.findall(r"robtarget (\w+):=\[\[(.*?)\],\[(.*?)\],", text)
    }
    bodies = {n: b.splitlines() for n, b in re.findall(r"PROC (\w+)\(\)(.*?)ENDPROC", text, re.DOTALL)}
    for lines in _routines(bodies, r"(\w+);"):
        steps = []
        for line in lines:
            if m := re.match(r"MoveAbsJ (\w+),", line):
                steps.append(Step("J", joints[m[1]], name=m[1]))
            elif m := re.match(r"(?:Move|Arc)([LC])\w* (\w+),(?:(\w+),)?v", line):
                to = m[3] or m[2]
                steps.append(Step("L", goal=poses[to], via=poses[m[2]] if m[3] else None, name=to))
        yield steps


def krl(files: dict[str, str]) -> Iterator[list[Step]]:
    source, data = (next(t for n, t in files.items() if n.endswith(end)) for end in (".src", ".dat"))
    T = posed(*krl_pose(re.search(r"FRAME WP_PART=\{(.*?)\}", data)[1]))
    joints = {n: numbers(re.sub(r"[AE]\d ", "", q))[:6] for n, q in re.findall(r"E6AXIS (\w+)=\{(.*?)\}", data)}
    poses = {n: T @ posed(*krl_pose(v)) for n, v in re.findall(r"E6POS (\w+)=\{(.*?)\}", data)}
    bodies = {n: b.splitlines() for n, b in re.findall(r"DEF (\w+)\(\)(.*?)\nEND\b", source, re.DOTALL)}
    for lines in _routines(bodies, r"(\w+)\(\)"):
        steps = []
        for line in lines:
            m = re.match(r"(PTP|LIN|CIRC) (\w+)(?:,(\w+))?", line)
            if m and m[2] in joints:
                steps.append(Step("J", joints[m[2]], name=m[2]))
            elif m:
                to = m[3] or m[2]
                steps.append(Step("L", goal=poses[to], via=poses[m[2]] if m[3] else None, name=to))
        yield steps


def urscript(files: dict[str, str]) -> Iterator[list[Step]]:
    (text,) = files.values()

    def pose(v: Array) -> Array:
        return posed(1000.0 * v[:3], Rotation.from_rotvec(v[3:]))

    T = pose(numbers(re.search(r"wp_part = p\[(.*?)\]", text)[1]))
    steps = []
    for line in text.splitlines():
        if m := re.match(r"\s*movej\(\[(.*?)\]", line):
            steps.append(Step("J", np.degrees(numbers(m[1]))))
        elif m := re.match(r"\s*move([lc])\(", line):
            *via, goal = (T @ pose(numbers(p)) for p in re.findall(r"pose_trans\(wp_part, p\[(.*?)\]\)", line))
            steps.append(Step("L", goal=goal, via=via[0] if via else None))
    yield steps


def kawasaki(files: dict[str, str]) -> Iterator[list[Step]]:
    (text,) = files.values()
    text = text.replace("\r", "")
    rows = re.search(r"^\.JOINTS\n(.*?)^\.END", text, re.S | re.M)[1].splitlines()
    joints = {line.split()[0]: np.array(line.split()[1:7], float) for line in rows}
    poses = {n: posed(*pose) for n, pose in as_values(text).items()}
    T = poses.pop("wp_part")
    bodies = {n: b.splitlines() for n, b in re.findall(r"^\.PROGRAM (\w+)\(\)(.*?)^\.END", text, re.S | re.M)}
    for lines in _routines(bodies, r"CALL (\w+)"):
        steps, via = [], None
        for line in lines:
            if m := re.match(r"JMOVE (#\w+)", line):
                steps.append(Step("J", joints[m[1]]))
            elif m := re.match(r"C1MOVE (\w+)", line):
                via = T @ poses[m[1]]
            elif m := re.match(r"(LMOVE|C2MOVE) (\w+)", line):
                steps.append(Step("L", goal=T @ poses[m[2]], via=via if m[1] == "C2MOVE" else None))
        yield steps


def inform(files: dict[str, str]) -> Iterator[list[Step]]:
    points: dict[str, Array] = {}
    bodies: dict[str, list[str]] = {}
    for text in files.values():
        head, body = text.replace("\r", "").split("//INST")
        job = re.search(r"//NAME (\S+)", head)[1]
        assert "///POSTYPE ANGLE" in head
        points |= {f"{job}:{n}": np.array(v.split(","), float) for n, v in re.findall(r"^(C\d+)=(.*)$", head, re.M)}
        bodies[job] = [re.sub(r"^(MOV[JLC]) (C\d+)", rf"\1 {job}:\2", line) for line in body.splitlines()]
    for lines in _routines(bodies, r"CALL JOB:(\S+)"):
        steps, arc = [], list[Array]()
        for line in lines:
            m = re.match(r"MOV([JLC]) (\S+)", line)
            if m is None:
                continue
            q = points[m[2]]
            arc = [*arc, q] if m[1] == "C" else []
            if m[1] != "C":
                steps.append(Step(m[1], q))
            elif len(arc) == 3:
                steps.append(Step("L", arc[2], via_joints=arc[1]))
                arc = []
        yield steps


READERS: dict[str, Callable[[dict[str, str]], Iterator[list[Step]]]] = {
    "rapid": rapid, "krl": krl, "urscript": urscript, "as": kawasaki, "inform": inform,
}  # fmt: skip
