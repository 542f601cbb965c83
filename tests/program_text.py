"""Programs as their controllers understand them: one reader per language, which knows nothing of the writers.

Each takes the files of a program and returns the frame of the part that it states, the poses relative to it and the
joints by their names, and its routines: moves to these names, and the comments around the seams. A program whose
positions are joints states no frame. Sources of the languages: the writers.
"""

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from tests.wire_judge import Array

Pose = tuple[Array, Rotation]
NOWHERE = np.zeros(3), Rotation.identity()  #: The frame of a program without one.
NUMBER = r"\s*([-+\d.eE]+)"
MARK = r"(?P<mark>ARC O\w+)"


class Event(NamedTuple):
    """A move (J, L or C) to a pose or to joints, on an arc over another one; or a comment, which is its kind."""

    kind: str
    names: tuple[str, ...] = ()


class Step(NamedTuple):
    """One move: to joints (deg), by the joints or on a line, or to a pose in the base, perhaps over another one."""

    kind: str
    joints: Array | None = None
    goal: Array | None = None
    via: Array | None = None
    via_joints: Array | None = None
    name: str = ""


class ProgramText(NamedTuple):
    """What was read; `poses` are in the order in which the program states them, routines begin with the main one."""

    frame: Pose
    poses: dict[str, Pose]
    joints: dict[str, Array]
    routines: list[list[Event]]

    def in_base(self) -> tuple[Any, Any]:
        p, R = self.frame
        return np.array([R.apply(q) + p for q, _ in self.poses.values()]), np.array(
            [(R * turn).as_matrix() for _, turn in self.poses.values()]
        )

    def order(self) -> list[int | str]:
        """Numbers of the poses that the moves end at, and the comments."""
        numbers = {name: number for number, name in enumerate(self.poses)}
        return [numbers[event.names[-1]] if event.names else event.kind for event in self.routines[0]]

    def steps(self) -> list[list[Step]]:
        """The moves of each routine."""
        return [[self._step(*event) for event in own if event.names] for own in self.routines]

    def _step(self, kind: str, names: tuple[str, ...]) -> Step:
        *via, to = names
        if to in self.joints:
            over = self.joints[via[0]] if via else None
            return Step("J" if kind == "J" else "L", self.joints[to], via_joints=over, name=to)
        T, *over = (posed(*self.frame) @ posed(*self.poses[name]) for name in (to, *via))
        return Step("L", goal=T, via=over[0] if over else None, name=to)


def posed(p: Any, R: Rotation) -> Array:
    T = np.eye(4)
    T[:3, 3], T[:3, :3] = p, R.as_matrix()
    return T


def numbers(text: str) -> Array:
    return np.array([float(value) for value in re.findall(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?", text)])


def lists(pattern: str, text: str) -> dict[str, list[Array]]:
    """The numbers of every group behind the first one, which is a name."""
    return {name: [numbers(own) for own in rest] for name, *rest in re.findall(pattern, text, re.MULTILINE)}


def events_of(pattern: str, lines: Iterable[str]) -> Iterator[Event]:
    """The moves of a pattern with the groups kind, a, b (the end of an arc) and mark, in their order."""
    for line in lines:
        if match := re.match(pattern, line.strip()):
            if match["mark"]:
                yield Event(match["mark"])
            else:
                kind = match["kind"][0].upper().replace("P", "J").replace("A", "J")
                yield Event(kind, tuple(name for name in (match["a"], match["b"]) if name))


def routines(bodies: Mapping[str, Iterable[str]], call: str) -> Iterator[list[str]]:
    """Yield the lines of each routine that no other one calls, with those of the routines that it calls."""
    known = {name.upper(): [line.strip() for line in lines] for name, lines in bodies.items()}

    def whole(name: str) -> Iterator[str]:
        for line in known[name]:
            found = re.fullmatch(call, line)
            yield from whole(found[1].upper()) if found and found[1].upper() in known else [line]

    called = {m[1].upper() for lines in known.values() for line in lines if (m := re.fullmatch(call, line))}
    yield from ([*whole(name)] for name in known if name not in called)


def quaternion(v: Iterable[float]) -> Rotation:
    return Rotation.from_quat(list(v), scalar_first=True)


def turned(axes: str, v: Any) -> Pose:
    """Three coordinates and three angles, deg."""
    return np.array(v[:3]), Rotation.from_euler(axes, v[3:6], degrees=True)


def rapid(files: dict[str, str]) -> ProgramText:
    (text,) = files.values()
    v = numbers(re.search(r"wobjdata wpPart:=(.*?);", text)[1])
    assert v[7:].tolist() == [0, 0, 0, 1, 0, 0, 0]
    bodies = {n: b.splitlines() for n, b in re.findall(r"PROC (\w+)\(\)(.*?)ENDPROC", text, re.DOTALL)}
    assert all(
        any("MoveC" in line for line in own) == any(r"CirPathMode\ObjectFrame;" in line for line in own)
        for own in bodies.values()
    )
    move = rf"(?:Move|Arc)(?P<kind>AbsJ|[JLC])\w* (?P<a>\w+),(?:(?P<b>\w+),)?v|! {MARK}\s*$"
    return ProgramText(
        (v[:3], quaternion(v[3:7])),
        {n: (p, quaternion(q)) for n, (p, q) in lists(r"robtarget (\w+):=\[\[(.*?)\],\[(.*?)\],", text).items()},
        {n: q for n, (q,) in lists(r"jointtarget (\w+):=\[\[(.*?)\]", text).items()},
        [[*events_of(move, own)] for own in routines(bodies, r"(\w+);")],
    )


def krl_pose(text: str) -> Pose:
    v = {key: float(x) for key, x in re.findall(r"\b([A-Z]\d?) (-?[\d.]+)", text)}
    return turned("ZYX", [v[key] for key in "XYZABC"])


def krl(files: dict[str, str]) -> ProgramText:
    source, data = (next(t for n, t in files.items() if n.endswith(end)) for end in (".src", ".dat"))
    assert re.search(r"^\$BASE=(\w+)", source, re.MULTILINE)[1] == "WP_PART"
    assert ("CIRC " in source) == ("$CIRC_TYPE=#BASE" in source)
    bodies = {n: b.splitlines() for n, b in re.findall(r"DEF (\w+)\(\)(.*?)\nEND\b", source, re.DOTALL)}
    move = rf"(?P<kind>PTP|LIN|CIRC) (?P<a>\w+)(?:,(?P<b>\w+))?|; {MARK}\s*$"
    return ProgramText(
        krl_pose(re.search(r"FRAME WP_PART=\{(.*?)\}", data)[1]),
        {name: krl_pose(values) for name, values in re.findall(r"DECL E6POS (\w+)=\{(.*?)\}", data)},
        {n: numbers(re.sub(r"[AE]\d ", "", q))[:6] for n, q in re.findall(r"E6AXIS (\w+)=\{(.*?)\}", data)},
        [[*events_of(move, own)] for own in routines(bodies, r"(\w+)\(\)")],
    )


def fanuc(files: dict[str, str]) -> ProgramText:
    main, keys = next(iter(files.values())), "XYZWPR"
    remarks = " ".join(re.findall(r"^\s*\d+:  !(.*?) ;", main.replace("\r", ""), re.MULTILINE))
    stated = "".join(rf"\s+{k} {NUMBER}" for k in keys)
    number, *frame = re.search(rf"UFRAME (\d+) to the part:{stated}", remarks).groups()
    poses, bodies = {}, {}
    for text in files.values():
        name = re.search(r"/PROG\s+(\S+)", text)[1]
        assert f"UFRAME_NUM={number} ;" in text or text is main
        for point, body in re.findall(r"^P\[(\d+)\]\{(.*?)\};", text, re.DOTALL | re.MULTILINE):
            assert re.search(rf"UF : {number},", body)
            values = [re.search(rf"\b{k} =\s*{NUMBER}\s+(?:mm|deg)", body)[1] for k in keys]
            poses[f"{name}:{point}"] = turned("xyz", [float(value) for value in values])
        body = re.sub(r"\r?\n +:", "", text.partition("/POS")[0])  # the end of an arc is on a line of its own
        bodies[name] = re.sub(r"P\[(\d+)\]", rf"{name}:\1", body).splitlines()
    move = rf"\d+:(?P<kind>[JLC]) (?P<a>\w+:\d+)(?: +(?P<b>\w+:\d+))? |\d+:  !{MARK} ;"
    found = [[*events_of(move, own)] for own in routines(bodies, r"\d+:\s*CALL (\w+) ;")]
    return ProgramText(turned("xyz", [float(value) for value in frame]), poses, {}, found)


def inform(files: dict[str, str]) -> ProgramText:
    main, keys = next(iter(files.values())), ("X", "Y", "Z", "Rx", "Ry", "Rz")
    comments = " ".join(re.findall(r"^'(.*)", main.replace("\r", ""), re.MULTILINE))
    stated = re.search(r"USER (\d+) to the part:" + "".join(rf"\s+{k} (\S+)" for k in keys), comments)
    number, *frame = stated.groups() if stated else ("", *"000000")
    rows, bodies = dict[str, Array](), {}
    for text in files.values():
        head, body = text.replace("\r", "").split("//INST")
        job = re.search(r"//NAME (\S+)", head)[1]
        own = {f"{job}:{n}": v for n, (v,) in lists(r"^(C\d{5})=(.*)$", head).items()}
        assert int(re.search(r"///NPOS (\d+),0,0,0,0,0", head)[1]) == len(own)
        if own:
            kind = f"///USER {number}\n///TOOL 1\n///POSTYPE USER\n///RECTAN\n" if stated else "///POSTYPE ANGLE\n"
            assert kind in head
        rows |= own
        bodies[job] = re.sub(r"(C\d{5})", rf"{job}:\1", body).splitlines()
    move = rf"MOV(?P<kind>[JLC]) (?P<a>\w+:C\d{{5}})(?P<b>)|'{MARK}"
    found = [with_three_on_arcs([*events_of(move, own)]) for own in routines(bodies, r"CALL JOB:(\S+)")]
    if stated is None:
        return ProgramText(NOWHERE, {}, rows, found)
    poses = {name: turned("xyz", v) for name, v in rows.items()}
    return ProgramText(turned("xyz", [float(value) for value in frame]), poses, {}, found)


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

    poses, joints, events = {}, {}, list[Event]()
    for number, line in enumerate(map(str.strip, text.splitlines())):
        if mark := re.fullmatch(rf"# {MARK}", line):
            events.append(Event(mark[1]))
        elif move := re.match(r"movej\(\[(.*?)\]", line):
            joints[str(number)] = np.degrees(numbers(move[1]))
            events.append(Event("J", (str(number),)))
        elif move := re.match(r"move([jlc])\(pose_trans", line):
            assert (move[1] == "c") == ("mode=0" in line)
            own = [pose(values) for values in re.findall(r"pose_trans\(wp_part, p\[(.*?)\]\)", line)]
            names = tuple(f"{number}.{k}" for k in range(len(own)))
            poses |= dict(zip(names, own, strict=True))
            events.append(Event(move[1].upper(), names))
    return ProgramText(pose(re.search(r"wp_part = p\[(.*?)\]", text)[1]), poses, joints, [events])


def val3(files: dict[str, str]) -> ProgramText:
    namespace = "{http://www.staubli.com/robotics/VAL3/%s/2}"
    database = ET.fromstring(next(text for name, text in files.items() if name.endswith(".dtx")).encode())
    data = {element.get("name"): element for element in database.iter(f"{namespace % 'Data'}Data")}
    code = ET.fromstring(files["start.pgx"].encode()).find(f".//{namespace % 'Program'}Code").text

    def values(element: ET.Element, keys: Iterable[str]) -> list[float]:
        return [float(element.get(key)) for key in keys]

    def pose(element: ET.Element) -> Pose:
        return turned("XYZ", values(element, ("x", "y", "z", "rx", "ry", "rz")))

    poses, joints = {}, {}
    for name in dict.fromkeys(re.findall(r"move[jl]\((\w+)\[", code)):
        assert int(data[name].get("size")) == len(data[name])
        for key, value in enumerate(data[name]):
            assert value.get("key") == str(key)
            if data[name].get("type") == "jointRx":
                joints[f"{name}[{key}]"] = np.array(values(value, (f"j{axis}" for axis in range(1, 7))))
            else:
                assert value.get("fatherId") == "fPart[0]"
                poses[f"{name}[{key}]"] = pose(value)
    loop = re.compile(r"for nPoint=(\d+) to (\d+)\n\s*(move.*?)\n\s*endFor")
    whole = loop.sub(
        lambda m: "\n".join(m[3].replace("nPoint", str(row)) for row in range(int(m[1]), int(m[2]) + 1)), code
    )
    point = r"\w+\[\d+\]"
    move = rf"move(?P<kind>[jlc])\((?P<a>{point}),(?:(?P<b>{point}),)?|// {MARK}$"
    return ProgramText(pose(data["fPart"][0]), poses, joints, [[*events_of(move, whole.splitlines())]])


def as_values(text: str, section: str = "TRANS") -> dict[str, Array]:
    """Values by name."""
    found = re.search(rf"^\.{section}\r?\n(.*?)^\.END", text, re.MULTILINE | re.DOTALL)
    rows = (row.split() for row in (found[1].splitlines() if found else ()))
    return {name: np.array([float(cell) for cell in cells]) for name, *cells in rows}


def kawasaki(files: dict[str, str]) -> ProgramText:
    (text,) = files.values()
    poses = {name: turned("ZYZ", v) for name, v in as_values(text).items()}
    bodies = {n: b.splitlines() for n, b in re.findall(r"^\.PROGRAM (\w+)\(\)(.*?)^\.END", text, re.S | re.M)}
    assert all("  BASE wp_part" in lines for lines in bodies.values() if any("LMOVE" in line for line in lines))
    move = rf"(?P<kind>[LJ]MOVE|C2MOVE) (?P<a>#?\w+)(?:,(?P<b>\w+))?|; {MARK}"
    found = []
    for lines in routines(bodies, r"CALL (\w+)"):
        whole = re.sub(r"C1MOVE (\w+)\nC2MOVE (\w+)", r"C2MOVE \1,\2", "\n".join(lines))
        assert "C1MOVE" not in whole, "an arc has one point in its middle"
        found.append([*events_of(move, whole.split("\n"))])
    joints = {name: v[:6] for name, v in as_values(text, "JOINTS").items()}
    return ProgramText(poses.pop("wp_part"), poses, joints, found)


def pdl2(files: dict[str, str]) -> ProgramText:
    (text,) = files.values()
    poses = {n: turned("ZYZ", v) for n, (v,) in lists(r"^  (\w+) := POS\((.*?), ''\)", text).items()}
    assert "  $UFRAME := wp_part" in text
    move = rf"MOVE(?:FLY)? (?P<kind>JOINT|LINEAR) TO (?P<a>\w+)(?P<b>)|-- {MARK}\s*$"
    events = [*events_of(move, text.split("BEGIN", 1)[1].splitlines())]
    return ProgramText(poses.pop("wp_part"), poses, {}, [events])


READERS: dict[str, Callable[[dict[str, str]], ProgramText]] = {
    "rapid": rapid, "krl": krl, "fanuc": fanuc, "inform": inform, "urscript": urscript, "val3": val3, "as": kawasaki,
    "pdl2": pdl2,
}  # fmt: skip
