"""Weld programs as their controllers understand them: one reader per language, which knows nothing of the writers.

Each takes the files of a program and returns the frame of the part that it states, the poses relative to it by their
names, and what it does: moves to these names, and the comments around the seams. Sources of the languages: the writers.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

Pose = tuple[np.ndarray[Any, Any], Rotation]
NUMBER = r"\s*([-+\d.eE]+)"
MARK = r"(ARC O\w+)"


class Event(NamedTuple):
    """A move (J, L or C) to a pose, on an arc over another one; or a comment, which is its kind."""

    kind: str
    names: tuple[str, ...] = ()


class ProgramText(NamedTuple):
    """What was read; `poses` are in the order in which the program states them."""

    frame: Pose
    poses: dict[str, Pose]
    events: list[Event]

    def in_base(self) -> tuple[Any, Any]:
        p, R = self.frame
        return np.array([R.apply(q) + p for q, _ in self.poses.values()]), np.array(
            [(R * turn).as_matrix() for _, turn in self.poses.values()]
        )

    def order(self) -> list[int | str]:
        """Numbers of the poses that the moves end at, and the comments."""
        numbers = {name: number for number, name in enumerate(self.poses)}
        return [numbers[event.names[-1]] if event.names else event.kind for event in self.events]


def numbers(text: str) -> np.ndarray[Any, Any]:
    return np.array([float(value) for value in re.findall(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?", text)])


def events_of(pattern: str, text: str, prefix: str = "") -> list[Event]:
    """The moves of a pattern with the groups kind, a, b (the end of an arc) and mark, in their order."""
    found = []
    for match in re.finditer(pattern, text, re.MULTILINE):
        if match["mark"]:
            found.append(Event(match["mark"]))
        else:
            kind = match["kind"][0].upper().replace("P", "J")
            found.append(Event(kind, tuple(prefix + name for name in (match["a"], match["b"]) if name)))
    return found


def quaternion(v: Iterable[float]) -> Rotation:
    return Rotation.from_quat(list(v), scalar_first=True)


def rapid(files: dict[str, str]) -> ProgramText:
    (text,) = files.values()
    v = numbers(re.search(r"wobjdata wpPart:=(.*?);", text)[1])
    assert v[7:].tolist() == [0, 0, 0, 1, 0, 0, 0]
    rows = re.findall(r"robtarget (\w+):=\[\[(.*?)\],\[(.*?)\],", text)
    bodies = re.findall(r"PROC weld_\w+\(\)(.*?)ENDPROC", text, re.DOTALL)
    assert all(("MoveC" in body) == (r"CirPathMode\ObjectFrame;" in body) for body in bodies)
    move = rf"Move(?P<kind>[JLC]) (?P<a>\w+),(?:(?P<b>\w+),)?v\w+,|! (?P<mark>{MARK})\s*$"
    events = [event for body in bodies for event in events_of(move, body)]
    return ProgramText(
        (v[:3], quaternion(v[3:7])), {n: (numbers(p), quaternion(numbers(q))) for n, p, q in rows}, events
    )


def krl_pose(text: str) -> Pose:
    v = {key: float(x) for key, x in re.findall(r"\b([A-Z]\d?) (-?[\d.]+)", text)}
    return np.array([v["X"], v["Y"], v["Z"]]), Rotation.from_euler("ZYX", [v["A"], v["B"], v["C"]], degrees=True)


def krl(files: dict[str, str]) -> ProgramText:
    source, data = (next(t for n, t in files.items() if n.endswith(end)) for end in (".src", ".dat"))
    assert re.search(r"^\$BASE=(\w+)", source, re.MULTILINE)[1] == "WP_PART"
    assert ("CIRC " in source) == ("$CIRC_TYPE=#BASE" in source)
    poses = {name: krl_pose(values) for name, values in re.findall(r"DECL E6POS (\w+)=\{(.*?)\}", data)}
    move = rf"^(?P<kind>PTP|LIN|CIRC) (?P<a>\w+)(?:,(?P<b>\w+))?|^; (?P<mark>{MARK})\s*$"
    return ProgramText(krl_pose(re.search(r"FRAME WP_PART=\{(.*?)\}", data)[1]), poses, events_of(move, source))


def xyz_pose(values: Iterable[str]) -> Pose:
    v = [float(value) for value in values]
    return np.array(v[:3]), Rotation.from_euler("xyz", v[3:], degrees=True)


def fanuc(files: dict[str, str]) -> ProgramText:
    main, keys = next(iter(files.values())), "XYZWPR"
    remarks = " ".join(re.findall(r"^\s*\d+:  !(.*?) ;", main.replace("\r", ""), re.MULTILINE))
    stated = "".join(rf"\s+{k} {NUMBER}" for k in keys)
    number, *frame = re.search(rf"UFRAME (\d+) to the part:{stated}", remarks).groups()
    poses, events = {}, list[Event]()
    for name in re.findall(r"CALL (\w+)", main):
        text = files[f"{name}.ls"]
        assert f"UFRAME_NUM={number} ;" in text
        for point, body in re.findall(r"^P\[(\d+)\]\{(.*?)\};", text, re.DOTALL | re.MULTILINE):
            assert re.search(rf"UF : {number},", body)
            values = [re.search(rf"\b{k} =\s*{NUMBER}\s+(?:mm|deg)", body)[1] for k in keys]
            poses[f"{name}:{point}"] = xyz_pose(values)
        move = rf"\d+:(?P<kind>[JLC]) P\[(?P<a>\d+)\](?:\s*:\s*P\[(?P<b>\d+)\])? |\d+:  !(?P<mark>{MARK}) ;"
        events += events_of(move, text, f"{name}:")
    return ProgramText(xyz_pose(frame), poses, events)


def inform(files: dict[str, str]) -> ProgramText:
    main, keys = next(iter(files.values())), ("X", "Y", "Z", "Rx", "Ry", "Rz")
    comments = " ".join(re.findall(r"^'(.*)", main.replace("\r", ""), re.MULTILINE))
    stated = "".join(rf"\s+{k} (\S+)" for k in keys)
    number, *frame = re.search(rf"USER (\d+) to the part:{stated}", comments).groups()
    poses, events = {}, list[Event]()
    for name in re.findall(r"CALL JOB:(\S+)", main):
        head, body = files[f"{name}.jbi"].replace("\r", "").split("//INST")
        assert f"///USER {number}\n" in head
        assert "///POSTYPE USER\n///RECTAN\n" in head
        rows = re.findall(r"^(C\d{5})=(.*)$", head, re.MULTILINE)
        assert int(re.search(r"///NPOS (\d+),0,0,0,0,0", head)[1]) == len(rows)
        poses |= {f"{name}:{point}": xyz_pose(values.split(",")) for point, values in rows}
        found = events_of(rf"^MOV(?P<kind>[JLC]) (?P<a>C\d{{5}})(?P<b>)|^'(?P<mark>{MARK})", body, f"{name}:")
        events += with_three_on_arcs(found)
    return ProgramText(xyz_pose(frame), poses, events)


def with_three_on_arcs(found: list[Event]) -> list[Event]:
    """An arc is three moves, the first of them at its start; a line without length only separates two arcs."""
    events, waiting, at = list[Event](), list[str](), ""
    for event in found:
        if event.kind != "C":
            assert not waiting, "a line before the arc has its three points"
            if event.names != (at,):
                events.append(event)
        else:
            waiting.append(event.names[0])
            assert waiting[0] == at, "an arc begins where the tool is"
            if len(waiting) < 3:
                continue
            events.append(Event("C", (waiting[1], waiting[2])))
            waiting = []
        at = event.names[0] if event.names else at
    return events


def urscript(files: dict[str, str]) -> ProgramText:
    (text,) = files.values()

    def pose(values: str) -> Pose:
        v = numbers(values)
        return 1000.0 * v[:3], Rotation.from_rotvec(v[3:])

    poses, events = {}, list[Event]()
    for number, line in enumerate(text.splitlines()):
        if mark := re.fullmatch(rf"  # {MARK}", line):
            events.append(Event(mark[1]))
        elif move := re.match(r"  move([jlc])\(pose_trans", line):
            assert (move[1] == "c") == ("mode=0" in line)
            own = [pose(values) for values in re.findall(r"pose_trans\(wp_part, p\[(.*?)\]\)", line)]
            names = tuple(f"{number}.{k}" for k in range(len(own)))
            poses |= dict(zip(names, own, strict=True))
            events.append(Event(move[1].upper(), names))
    return ProgramText(pose(re.search(r"wp_part = p\[(.*?)\]", text)[1]), poses, events)


def val3(files: dict[str, str]) -> ProgramText:
    namespace = "{http://www.staubli.com/robotics/VAL3/%s/2}"
    database = ET.fromstring(next(text for name, text in files.items() if name.endswith(".dtx")).encode())
    data = {element.get("name"): element for element in database.iter(f"{namespace % 'Data'}Data")}
    code = ET.fromstring(files["start.pgx"].encode()).find(f".//{namespace % 'Program'}Code").text

    def pose(element: ET.Element) -> Pose:
        v = [float(element.get(key)) for key in ("x", "y", "z", "rx", "ry", "rz")]
        return np.array(v[:3]), Rotation.from_euler("XYZ", v[3:], degrees=True)

    poses = {}
    for name in dict.fromkeys(re.findall(r"move[jl]\((\w+)\[", code)):
        assert int(data[name].get("size")) == len(data[name])
        for key, value in enumerate(data[name]):
            assert (value.get("key"), value.get("fatherId")) == (str(key), "fPart[0]")
            poses[f"{name}[{key}]"] = pose(value)
    loop = re.compile(r"for nPoint=(\d+) to (\d+)\n\s*(move.*?)\n\s*endFor")
    whole = loop.sub(
        lambda m: "\n".join(m[3].replace("nPoint", str(row)) for row in range(int(m[1]), int(m[2]) + 1)), code
    )
    point = r"\w+\[\d+\]"
    move = rf"move(?P<kind>[jlc])\((?P<a>{point}),(?:(?P<b>{point}),)?|// (?P<mark>{MARK})$"
    return ProgramText(pose(data["fPart"][0]), poses, events_of(move, whole))


def as_values(text: str) -> dict[str, Pose]:
    """Transformation values by name."""
    rows = re.search(r"^\.TRANS\r?\n(.*?)^\.END", text, re.MULTILINE | re.DOTALL)[1].splitlines()
    found = {}
    for name, *cells in (row.split() for row in rows):
        v = np.array([float(cell) for cell in cells])
        assert len(v) == 6
        found[name] = v[:3], Rotation.from_euler("ZYZ", v[3:], degrees=True)
    return found


def kawasaki(files: dict[str, str]) -> ProgramText:
    (text,) = files.values()
    values = as_values(text)
    programs = dict(re.findall(r"^\.PROGRAM (\w+)\(\)\r?\n(.*?)^\.END", text, re.MULTILINE | re.DOTALL))
    events, via = list[Event](), ""
    for name in re.findall(r"CALL (\w+)", next(iter(programs.values()))):
        assert "  BASE wp_part" in programs[name]
        move = rf"^  (?P<kind>[LJ]MOVE|C[12]MOVE) (?P<a>\w+)(?P<b>)|^; (?P<mark>{MARK})"
        for match, event in zip(
            re.finditer(move, programs[name], re.MULTILINE), events_of(move, programs[name]), strict=True
        ):
            if (match["kind"] or "").startswith("C1"):
                assert not via, "an arc has one point in its middle"
                via = match["a"]
                continue
            assert bool(via) == (event.kind == "C")
            events.append(Event("C", (via, *event.names)) if via else event)
            via = ""
    return ProgramText(values["wp_part"], {n: v for n, v in values.items() if n != "wp_part"}, events)


def pdl2(files: dict[str, str]) -> ProgramText:
    (text,) = files.values()
    poses = {}
    for name, values in re.findall(r"^  (\w+) := POS\((.*?), ''\)", text, re.MULTILINE):
        v = numbers(values)
        poses[name] = v[:3], Rotation.from_euler("ZYZ", v[3:], degrees=True)
    assert "  $UFRAME := wp_part" in text
    move = rf"^  MOVE(?:FLY)? (?P<kind>JOINT|LINEAR) TO (?P<a>\w+)(?P<b>)|^  -- (?P<mark>{MARK})\s*$"
    return ProgramText(poses.pop("wp_part"), poses, events_of(move, text.split("BEGIN", 1)[1]))


READERS: dict[str, Callable[[dict[str, str]], ProgramText]] = {
    "rapid": rapid,
    "krl": krl,
    "fanuc": fanuc,
    "inform": inform,
    "urscript": urscript,
    "val3": val3,
    "as": kawasaki,
    "pdl2": pdl2,
}
