"""What controllers do with written programs: the moves are read from the text and interpolated, without wpcal.

Each function reads the instructions between ARC ON and ARC OFF of a program with one seam, and the poses that they
name, in the frame of the part. Sources of what the languages do: `wpcal.robot.moves.interpolation`.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

Pose = tuple[np.ndarray[Any, Any], Rotation]
NUMBER = r"\s*([-+\d.eE]+)"
MARK = re.compile(r"^[ \t]*(?:\d+:)?[ \t]*(?:!|;|'|#|//) ?ARC (?:ON|OFF)[ \t;]*\r?$", re.MULTILINE)


class Step(NamedTuple):
    """One move: the pose in its middle (None for a line), and that at its end."""

    via: Pose | None
    to: Pose


class Weld(NamedTuple):
    """The moves along a seam; `uses_via`: the controller turns the tool through the pose in the middle of an arc."""

    start: Pose
    steps: list[Step]
    uses_via: bool


def numbers(text: str) -> np.ndarray[Any, Any]:
    return np.array([float(value) for value in re.findall(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?", text)])


def at_marks(text: str) -> tuple[str, str]:
    """Return what is before the line ARC ON of a program with one seam, and what is from there to ARC OFF."""
    before, along, _ = MARK.split(text)
    return before, along


def weld_of(order: list[tuple[str, list[Pose]]], start: Pose, *, uses_via: bool) -> Weld:
    steps = [Step(None, poses[0]) if len(poses) == 1 else Step(poses[0], poses[1]) for _, poses in order]
    return Weld(start, steps, uses_via)


def rapid(files: dict[str, str]) -> Weld:
    (text,) = files.values()
    poses = {}
    for name, values in re.findall(r"CONST robtarget (\w+):=\[(\[.*?\],\[.*?\]),", text):
        v = numbers(values)
        poses[name] = v[:3], Rotation.from_quat(v[[4, 5, 6, 3]])
    procedure = re.search(r"PROC weld_\w+\(\)(.*?)ENDPROC", text, re.DOTALL)[1]
    assert ("MoveC" in procedure) == (r"CirPathMode\ObjectFrame;" in procedure)  # else the tool turns with the tangent
    before, along = at_marks(procedure)
    start = poses[re.findall(r"MoveL (\w+),", before)[-1]]
    moves = re.findall(r"Move([LC]) (\w+),(?:(\w+),)?vWeld,", along)
    return weld_of([(kind, [poses[n] for n in (a, b) if n]) for kind, a, b in moves], start, uses_via=False)


def krl(files: dict[str, str]) -> Weld:
    source = next(text for name, text in files.items() if name.endswith(".src"))
    data = next(text for name, text in files.items() if name.endswith(".dat"))
    poses = {}
    for name, values in re.findall(r"DECL E6POS (\w+)=\{(.*?)\}", data):
        v = numbers(re.sub(r"[A-Z]\d? ", "", values))
        poses[name] = v[:3], Rotation.from_euler("ZYX", v[3:6], degrees=True)
    assert ("CIRC " in source) == ("$CIRC_TYPE=#BASE" in source)
    before, along = at_marks(source)
    start = poses[re.findall(r"^LIN (\w+)", before, re.MULTILINE)[-1]]
    moves = re.findall(r"^(LIN|CIRC) (\w+)(?:,(\w+))?", along, re.MULTILINE)
    return weld_of([(kind, [poses[n] for n in (a, b) if n]) for kind, a, b in moves], start, uses_via=False)


def fanuc(files: dict[str, str]) -> Weld:
    text = next(text for name, text in files.items() if name != "WPCAL.ls")
    poses = {}
    for name, body in re.findall(r"^P\[(\d+)\]\{(.*?)\};", text, re.DOTALL | re.MULTILINE):
        v = [float(re.search(rf"\b{key} ={NUMBER}", body)[1]) for key in "XYZWPR"]
        poses[name] = np.array(v[:3]), Rotation.from_euler("ZYX", v[:2:-1], degrees=True)
    before, along = at_marks(text)
    start = poses[re.findall(r"\d:L P\[(\d+)\]", before)[-1]]
    moves = re.findall(r"\d:([LC]) P\[(\d+)\](?:\s*:\s*P\[(\d+)\])? ", along)
    return weld_of([(kind, [poses[n] for n in (a, b) if n]) for kind, a, b in moves], start, uses_via=True)


def inform(files: dict[str, str]) -> Weld:
    text = next(text for name, text in files.items() if name != "WPCAL.jbi")
    poses = {}
    for name, values in re.findall(r"^(C\d+)=(.*)$", text, re.MULTILINE):
        v = numbers(values)
        poses[name] = v[:3], Rotation.from_euler("ZYX", v[:2:-1], degrees=True)
    before, along = at_marks(text)
    at = re.findall(r"^MOVL (C\d+)", before, re.MULTILINE)[-1]
    start, order, waiting = poses[at], [], []
    for kind, name in re.findall(r"^(MOV[LC]) (C\d+)", along, re.MULTILINE):
        if kind == "MOVL":
            assert not waiting, "a line before the arc has its three points"
            if name != at:  # a move without length only separates two arcs
                order.append((kind, [poses[name]]))
        else:
            waiting.append(name)
            assert waiting[0] == at, "an arc begins where the tool is"
            if len(waiting) == 3:
                order.append((kind, [poses[n] for n in waiting[1:]]))
                waiting = []
            else:
                continue
        at = name
    return weld_of(order, start, uses_via=True)


def urscript(files: dict[str, str]) -> Weld:
    (text,) = files.values()

    def pose(values: str) -> Pose:
        v = numbers(values)
        return 1000.0 * v[:3], Rotation.from_rotvec(v[3:])

    before, along = at_marks(text)
    start = pose(re.findall(r"movel\(pose_trans\(wp_part, p\[(.*?)\]\)", before)[-1])
    order = []
    for line in along.splitlines():
        if "move" in line:
            assert ("movec(" in line) == ("mode=0" in line)
            order.append((line, [pose(values) for values in re.findall(r"p\[(.*?)\]", line)]))
    return weld_of(order, start, uses_via=False)


def val3(files: dict[str, str]) -> Weld:
    data = next(text for name, text in files.items() if name.endswith(".dtx"))
    poses = {}
    for element in ET.fromstring(data).iter():
        if (element.get("type") or "") == "pointRx":
            for number, value in enumerate(element):
                v = np.array([float(value.get(key)) for key in ("x", "y", "z", "rx", "ry", "rz")])
                poses[f"{element.get('name')}[{number}]"] = v[:3], Rotation.from_euler("XYZ", v[3:], degrees=True)
    before, along = at_marks(files["start.pgx"])
    start = poses[re.findall(r"movel\((\w+\[\d+\]),", before)[-1]]
    moves = re.findall(r"move([lc])\((\w+\[\d+\]),(?:(\w+\[\d+\]),)?\w+,mWeld\)", along)
    return weld_of([(kind, [poses[n] for n in (a, b) if n]) for kind, a, b in moves], start, uses_via=True)


def kawasaki(files: dict[str, str]) -> Weld:
    (text,) = files.values()
    poses = {}
    for name, values in re.findall(r"^(\w+) ([-\d. ]+?)\r?$", text.split(".TRANS")[1], re.MULTILINE):
        v = numbers(values)
        poses[name] = v[:3], Rotation.from_euler("ZYZ", v[3:], degrees=True)
    before, along = at_marks(re.search(r"\.PROGRAM weld_\w+\(\)(.*?)\.END", text, re.DOTALL)[1])
    assert "  BASE wp_part" in before
    start, order, via = poses[re.findall(r"LMOVE (\w+)", before)[-1]], [], None
    for kind, name in re.findall(r"^  (LMOVE|C[12]MOVE) (\w+)", along, re.MULTILINE):
        if kind == "C1MOVE":
            assert via is None, "an arc has one point in its middle"
            via = poses[name]
            continue
        assert (via is None) == (kind == "LMOVE")
        order.append((kind, [poses[name]] if via is None else [via, poses[name]]))
        via = None
    return weld_of(order, start, uses_via=True)


READERS = {
    "rapid": rapid,
    "krl": krl,
    "fanuc": fanuc,
    "inform": inform,
    "urscript": urscript,
    "val3": val3,
    "as": kawasaki,
}


def followed(weld: Weld, count: int) -> Pose:
    """Return the tool at `count` places of every move: positions (m, 3), mm, and the rotations."""
    t, (p0, R0) = np.linspace(0.0, 1.0, count), weld.start
    places, turns = [], []
    for via, (p1, R1) in weld.steps:
        middle = 0.5
        if via is None:
            places.append(p0 + t[:, None] * (p1 - p0))
        else:
            centre, normal, sweep, middle = circle_through(p0, via[0], p1)
            places.append(centre + Rotation.from_rotvec(np.outer(t * sweep, normal)).apply(p0 - centre))
        if via is not None and weld.uses_via:
            slerp = Slerp([0.0, middle, 1.0], Rotation.concatenate([R0, via[1], R1]))
        else:
            slerp = Slerp([0.0, 1.0], Rotation.concatenate([R0, R1]))
        turns.append(slerp(t))
        p0, R0 = p1, R1
    return np.concatenate(places), Rotation.concatenate(turns)


def circle_through(a: Any, b: Any, c: Any) -> tuple[Any, Any, float, float]:
    """Return centre, axis, angle from a through b to c, and the share of it at b."""
    e1 = (c - a) / np.linalg.norm(c - a)
    e2 = (b - a) - ((b - a) @ e1) * e1
    e2 /= np.linalg.norm(e2)
    half, (u, v) = np.linalg.norm(c - a) / 2, ((b - a) @ e1, (b - a) @ e2)
    height = (u * u + v * v - 2 * u * half) / (2 * v)
    centre = a + half * e1 + height * e2
    normal = np.cross(e2, e1)  # from a over b, which is on the side of e2, to c

    def angle(q: Any) -> float:
        r = a - centre
        return float(np.arctan2((q - centre) @ np.cross(normal, r), (q - centre) @ r) % (2 * np.pi))

    return centre, normal, angle(c), angle(b) / angle(c)
