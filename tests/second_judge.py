"""A second judge of plans: it reads the TEXT of programs and knows neither wpcal's interpreters nor its collisions.

Joints become places by the URDF file, and poses joints by Newton steps on it. Links are the vertices of their meshes,
the nozzle is a cylinder, what follows it convex hulls, the wire points on a line. A point is inside the part where the
winding number of its solids' triangles says so; points on edges of the part are asked if nozzle or torch holds them.
`pytest -m deep -rP tests/e2e/test_second_judge.py` shows a row for each program.
"""

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, cKDTree
from scipy.spatial.transform import Rotation, Slerp

from tests.moves_of_programs import circle_through
from tests.program_text import READERS, Step, posed
from tests.wire_judge import Array, off_surface, winding

STEP_MM, STEP_RAD = 5.0, 0.05  #: Between two judged states, of the tip and of each joint.
ALONG_MM = 4.0  #: Between points of a shell, and of an edge of the part.
AT_ONCE = 256  #: States in one array.
TIP_MM = 3.0  #: So much of the wire is at the seam.
OPEN_MM2 = 1.0  #: The sum of all areas of a closed surface is no more, of triangles in single precision.
WELDED_MM = 2.6  #: A place on a seam is welded if a state is so near: half of a step, and the error of a program.
DEEP_MM = 0.3  #: A point that is less deep is on the surface.
MOST_DEG = 1.0
"""Joints of the text and those of its poses: near a singular pose they differ by more than their digits."""
MOST_POINTS = 150  #: Of one link.


class Contact(NamedTuple):
    """What is inside what, and how deep."""

    body: str
    deep_mm: float
    step: int


class SecondJudge:
    """An arm with its torch before a part that stands still."""

    def __init__(self, cell_json: Path, urdf: Path, corners: Array, T_world_part: Array) -> None:
        from tests.real_cells import Chain, of_record

        record = json.loads(cell_json.read_text(encoding="utf-8"))
        robot = record["torch_robot"]
        self.chain, self.T_part = Chain(urdf), T_world_part
        self.T_base, self.T_tool = of_record(robot["T_world_base"]), of_record(robot["T_flange_tool"])
        self.floor = float(record.get("floor_z_mm", 0.0))
        rng = np.random.default_rng(0)
        self.links = {
            name: points[rng.permutation(len(points))[:MOST_POINTS]]
            for name, (points, _) in self.chain.meshes.items()
            if self.chain.moved_by(name) >= 2
        }
        shape = robot["torch_shape"]
        assert shape["taper_mm"] == 0.0, "the nozzle of these cells is a cylinder"
        front, behind = shape["wire_mm"], shape["wire_mm"] + shape["neck"]["from_mm"]
        rest = [np.array(each.get("hull_mm") or _balls(each["capsules"])) for each in robot["torch"]]
        rim = shape["nozzle_radius_mm"] * np.exp(1j * np.arange(48) * np.pi / 24.0)
        hulls = [("nozzle", np.array([(each.real, each.imag, z) for z in (-front, -behind) for each in rim]))]
        hulls += [("torch", points) for points in rest if points[:, 2].min() < -behind - 1.0]
        self.hulls = [(name, points, ConvexHull(points).equations) for name, points in hulls]
        wire = np.outer(-np.arange(int(front)), [0.0, 0.0, 1.0])
        self.shells = [("wire", wire), *((name, _thinned(_on_edges(p[ConvexHull(p).simplices]))) for name, p in hulls)]
        self.slopes: Array | None = None
        self.solids = _solids(corners)
        self.edges = _thinned(_on_edges(corners))

    def tool(self, q: Array) -> Array:
        """Return T_base_tool at joints, rad, shape (..., 6)."""
        return self.chain.pose(self.chain.tip, q) @ self.T_tool

    def joints_at(self, T: Array, near: Array) -> Array:
        """Return the joints at a pose by Newton's method from joints nearby, with the slopes of the pose before."""
        q, before = near.copy(), np.inf
        for _ in range(24):
            now = self.tool(q)
            turn = T[:3, :3] @ now[:3, :3].T
            sine = (turn - turn.T)[[2, 0, 1], [1, 2, 0]] / 2.0  # of a small turn, its rotation vector
            off = np.concatenate([T[:3, 3] - now[:3, 3], 500.0 * sine])
            left = float(np.abs(off).max())
            if left < 1e-4:
                return q
            if self.slopes is None or left > before / 4.0:
                self.slopes = np.linalg.pinv(self._jacobian(q, now), rcond=1e-8)
            q, before = q + np.clip(self.slopes @ off, -0.2, 0.2), left
        raise AssertionError(f"no joints at {T[:3, 3].round(1)}")

    def _jacobian(self, q: Array, now: Array) -> Array:
        at = self.tool(q + 1e-6 * np.eye(6))
        return np.concatenate([at[:, :3, 3] - now[:3, 3], 500.0 * _turn(now, at)], axis=1).T / 1e-6

    def states(self, steps: list[Step]) -> Iterator[tuple[int, bool, Array]]:
        """Yield the number of the step, whether it is on a line, and the joints, rad."""
        q: Array | None = None
        for number, step in enumerate(steps):
            if step.kind == "J":
                goal = np.radians(step.joints)
                start = goal if q is None else q
                count = int(np.ceil(np.abs(goal - start).max() / STEP_RAD)) + 1
                tips = self.tool(start + np.linspace(0.0, 1.0, count + 1)[:, None] * (goal - start))[:, :3, 3]
                count = max(count, int(np.ceil(np.linalg.norm(np.diff(tips, axis=0), axis=1).max() / STEP_MM)) * count)
                yield from ((number, False, start + t * (goal - start)) for t in np.linspace(0.0, 1.0, count + 1))
                q, self.slopes = goal, None  # those of another posture would lead to another one
                continue
            assert q is not None
            goal_T = self.tool(np.radians(step.joints)) if step.joints is not None else step.goal
            via = step.via if step.via_joints is None else self.tool(np.radians(step.via_joints))
            for T in _along(self.tool(q), via, goal_T):
                q = self.joints_at(T, q)
                yield number, True, q
            if step.joints is not None:  # where the arm really goes on
                off = float(np.degrees(np.abs(q - np.radians(step.joints)).max()))
                assert off < MOST_DEG, f"the arm is {off:.2f} deg off the joints of the text"
                q = np.radians(step.joints)

    def contacts(self, states: Iterable[tuple[int, bool, Array]]) -> list[Contact]:
        """Return what is inside the part or below the floor, the deepest place of each body."""
        rows, worst = list(states), dict[str, Contact]()

        def found(body: str, deep: Array, numbers: Array) -> None:
            if len(deep) and deep.max() > max(DEEP_MM, worst[body].deep_mm if body in worst else 0.0):
                worst[body] = Contact(body, float(deep.max()), int(numbers[deep.argmax()]))

        for first in range(0, len(rows), AT_ONCE):
            own = rows[first : first + AT_ONCE]
            numbers, lines, q = (np.array(column) for column in zip(*own, strict=True))
            tool = self.T_base @ self.tool(q)
            links = [(n, self.T_base @ self.chain.pose(n, q), p) for n, p in self.links.items()]
            for name, places, points in [*((n, tool, p) for n, p in self.shells), *links]:
                near = self._is_near(places, points)
                on, which, T = places[near], numbers[near], np.linalg.inv(self.T_part) @ places[near]
                tip = np.ix_(lines[near], np.arange(int(TIP_MM) if name == "wire" else 0))  # is at the seam
                z = on[:, 2, :3] @ points.T + on[:, 2, 3:]
                z[tip] = np.inf
                found(f"{name} and floor", self.floor - z.min(axis=1), which)
                local = points @ T[:, :3, :3].transpose(0, 2, 1) + T[:, None, :3, 3]
                local[tip] = np.inf
                for low, high, corners in self.solids:
                    state, point = np.nonzero(((local > low) & (local < high)).all(axis=2))
                    within = winding(local[state, point], corners) > 0.5
                    found(name, off_surface(local[state, point][within], corners), which[state][within])
            for name, hull, faces in self.hulls:
                near = self._is_near(tool, hull)
                into = np.linalg.inv(tool[near]) @ self.T_part
                local = self.edges @ into[:, :3, :3].transpose(0, 2, 1) + into[:, None, :3, 3]
                state, point = np.nonzero(((local > hull.min(axis=0)) & (local < hull.max(axis=0))).all(axis=2))
                found(name, -(local[state, point] @ faces[:, :3].T + faces[:, 3]).max(axis=1), numbers[near][state])
        return list(worst.values())

    def _is_near(self, places: Array, points: Array) -> Array:
        """Return where the ball around points meets the box of the part or the floor."""
        middle = points.mean(axis=0)
        r = np.linalg.norm(points - middle, axis=1).max()
        world = places[:, :3, :3] @ middle + places[:, :3, 3]
        local = (world - self.T_part[:3, 3]) @ self.T_part[:3, :3]
        out = np.maximum(self.edges.min(axis=0) - local, local - self.edges.max(axis=0)).clip(0.0)
        return np.asarray((np.linalg.norm(out, axis=1) < r) | (world[:, 2] - r < self.floor))

    def welded_share(self, states: Iterable[tuple[int, bool, Array]], result: Path) -> float:
        """Return how much of the length of the accepted seams of a result the wire passes on lines and arcs."""
        tools = np.array([self.tool(q) for _, on_line, q in states if on_line])
        seams = json.loads((result / "seams.json").read_text(encoding="utf-8"))["seams"]
        found = []
        for seam in (each for each in seams if each["accepted"]):
            s, p = (np.array([frame[key] for frame in seam["frames"]]) for key in ("s_mm", "p_mm"))
            places = np.stack([np.interp(np.arange(0.0, s[-1]), s, column) for column in p.T], axis=1)
            tips = tools[:, :3, 3] + seam.get("more_wire_mm", 0.0) * tools[:, :3, 2]
            found += (cKDTree(tips).query(places)[0] < WELDED_MM).tolist()
        return float(np.mean(found))


def _solids(corners: Array) -> list[tuple[Array, Array, Array]]:
    """Return triangles that hang together, with the corners of their boxes."""
    _, at = np.unique(corners.reshape(-1, 3).round(4), axis=0, return_inverse=True)
    a, b, c = at.reshape(-1, 3).T
    links = coo_array((np.ones(2 * len(a)), (np.tile(a, 2), np.concatenate([b, c]))), shape=(at.max() + 1,) * 2)
    label = connected_components(links)[1][a]
    own = [corners[label == each] for each in np.unique(label)]
    areas = [np.cross(each[:, 1] - each[:, 0], each[:, 2] - each[:, 0]).sum(axis=0) for each in own]
    assert np.abs(areas).max() < OPEN_MM2, "a solid is not closed: what is inside it would not be seen"
    return [(each.min(axis=(0, 1)), each.max(axis=(0, 1)), each) for each in own]


def _balls(capsules: list[dict[str, Any]]) -> Array:
    """Return points of which the hull is nearly that of a capsule."""
    golden = np.arange(200) * np.pi * (3.0 - np.sqrt(5.0))
    z = 1.0 - 2.0 * (np.arange(200) + 0.5) / 200.0
    ball = np.stack([np.sqrt(1 - z**2) * np.cos(golden), np.sqrt(1 - z**2) * np.sin(golden), z], axis=1)
    return np.concatenate([np.array(each[p]) + each["radius_mm"] * ball for each in capsules for p in ("p_mm", "q_mm")])


def _on_edges(corners: Array) -> Array:
    """Return points on the edges of triangles (m, 3, 3)."""
    a, b = corners.reshape(-1, 3), np.roll(corners, -1, axis=1).reshape(-1, 3)
    counts = np.ceil(np.linalg.norm(b - a, axis=1) / ALONG_MM).astype(int) + 1
    edge = np.repeat(np.arange(len(a)), counts)
    t = (np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[edge]
    return np.asarray(a[edge] + t[:, None] * (b - a)[edge])


def _thinned(points: Array) -> Array:
    """Return one of the points in each cube."""
    return points[np.unique(np.floor(points / (ALONG_MM / 2.0)).astype(int), axis=0, return_index=True)[1]]


def _turn(a: Array, b: Array) -> Array:
    return (Rotation.from_matrix(b[..., :3, :3]) * Rotation.from_matrix(a[:3, :3]).inv()).as_rotvec()


def _along(a: Array, via: Array | None, b: Array) -> Iterator[Array]:
    """Yield poses on a line or an arc, with its end; the tool turns evenly."""
    turns = Slerp([0.0, 1.0], Rotation.from_matrix(np.stack([a[:3, :3], b[:3, :3]])))
    angle = float(np.linalg.norm(_turn(a, b)))
    if via is None:
        length, at = float(np.linalg.norm(b[:3, 3] - a[:3, 3])), lambda t: a[:3, 3] + t * (b[:3, 3] - a[:3, 3])
    else:
        centre, normal, sweep, _ = circle_through(a[:3, 3], via[:3, 3], b[:3, 3])
        arm = a[:3, 3] - centre
        length = float(np.linalg.norm(arm)) * sweep
        at = lambda t: centre + Rotation.from_rotvec(t * sweep * normal).apply(arm)  # noqa: E731
    for t in np.linspace(0.0, 1.0, int(max(length / STEP_MM, angle / STEP_RAD)) + 2)[1:]:
        yield posed(at(t), turns(t))


SAME_MM = 1e-6  #: Ends of stretches that meet.
LANGUAGES = ("rapid", "krl", "urscript", "as", "inform")  #: Of plans with joints as every arm has them.
ARMS = ("irb1600_6_12", "irb2600_12_165", "ma2010", "kr5_arc")
FIXED, BRACKETS = ("tee", "lap", "frame", "saddle"), 8  #: Parts, and how many brackets beside them.


class Row(NamedTuple):
    """What the second judge says of one program."""

    part: str
    arm: str
    language: str
    moves: int
    contacts: tuple[Contact, ...]
    welded: float = 0.0  #: Share of the accepted length.
    refused: str = ""


class Planned(NamedTuple):
    """A plan as a user makes it: the judge, the routines of each language, and why others have none."""

    judge: SecondJudge | None
    routines: dict[str, list[list[Step]]]
    refused: dict[str, str]


def planned(arm: str, result: Path, folder: Path, languages: tuple[str, ...]) -> Planned:
    """Plan all accepted seams of a result."""
    from tests.cluttered_cells import TOOL, urdf
    from tests.real_cells import of_record
    from tests.running import run_here
    from tests.whole_table import texts_of, triangles_of

    cell, out = folder / "cell.json", folder / "plan"
    made = run_here("cell", "new", "--torch-robot", urdf(arm), "--tool", ",".join(map(str, TOOL)), "-o", cell)
    assert made.returncode == 0, made.stderr
    done = run_here("plan", cell, result, *(word for name in languages for word in ("-f", name)), "-o", out)
    if not (out / "plan.json").exists():
        return Planned(None, {}, dict.fromkeys(languages, done.stderr.strip()[-160:]))
    plan = json.loads((out / "plan.json").read_text(encoding="utf-8"))
    assert uncovered(plan, result) == []
    assert all(min(each["before"], each["after"]) > 0 for each in plan["kept"]["pieces"]), "a joint move in the pool"
    judge = SecondJudge(cell, urdf(arm), triangles_of(result), of_record(plan["T_carrier_part"]))
    routines = {name: READERS[name](texts_of(out / name)).steps() for name in languages if (out / name).is_dir()}
    refused = {name: str(plan["no_program"].get(name, "?"))[:160] for name in languages if name not in routines}
    return Planned(judge, routines, refused)


def uncovered(plan: dict[str, Any], result: Path) -> list[str]:
    """Return which accepted seams a plan does not weld or leave out by name on every millimetre, each once."""
    seams = json.loads((result / "seams.json").read_text(encoding="utf-8"))["seams"]
    length = {seam["name"]: seam["frames"][-1]["s_mm"] for seam in seams if seam["accepted"]}
    told: dict[str, list[tuple[float, float]]] = {name: [] for name in length}
    for row in (*plan["seams"], *plan["unwelded"]):
        told.setdefault(row["seam"], []).append((row["from_mm"], row["to_mm"]))
    found = []
    for name, stretches in told.items():
        ends = [0.0, *np.array(sorted(stretches)).ravel(), length.get(name, np.nan)]
        if not np.allclose(ends[::2], ends[1::2], rtol=0.0, atol=SAME_MM):
            found.append(name)
    return found


def rows_of(part: str, arm: str, result: Path, folder: Path, languages: tuple[str, ...]) -> Iterator[Row]:
    """Yield what the second judge says of the text of every language."""
    judge, texts, refused = planned(arm, result, folder, languages)
    yield from (Row(part, arm, name, 0, (), refused=why) for name, why in refused.items())
    for name, routines in texts.items():
        states = [list(judge.states(steps)) for steps in routines]
        contacts = tuple(contact for own in states for contact in judge.contacts(own))
        yield Row(part, arm, name, sum(map(len, routines)), contacts, judge.welded_share(max(states, key=len), result))


PLACES = {"irb1600_6_12": (-150.0, -90.0, 600.0, 56.0), "ma2010": (-100.0, -90.0, 500.0, -34.0)}
"""How the frame, 600 mm long, is moved (mm) and turned about the vertical (deg), as `wpcal plan` advises where it was
touched, low before the arm: its far seams are out of reach there, or the elbow meets the floor."""


def result_for(part: str | int, arm: str, folder: Path) -> Path:
    """Return the result of a part of the fixtures, the frame moved to where an arm reaches it, or of a bracket."""
    from tests.judgements import calibrated
    from tests.running import run_here
    from tests.samples.brackets import write_bracket
    from tests.whole_table import FIXTURES, result_of

    if part != "frame":
        return result_of(part, folder) if isinstance(part, str) else calibrated(write_bracket(part, folder), folder)[0]
    head, *rows = (FIXTURES / part / "taught.csv").read_text(encoding="utf-8").splitlines()
    *move, turn = PLACES.get(arm, (-100.0, -90.0, 600.0, 56.0))
    p, out = np.array([row.split(",")[1:4] for row in rows], float), folder / "out"
    p = Rotation.from_euler("z", turn, degrees=True).apply(p - p.mean(axis=0)) + p.mean(axis=0) + move
    moved = [f"{row.split(',')[0]},{x:.3f},{y:.3f},{z:.3f},yes" for row, (x, y, z) in zip(rows, p, strict=True)]
    (folder / "taught.csv").write_text("\n".join([head, *moved]), encoding="utf-8")
    done = run_here("calibrate", FIXTURES / part / "frame.step", folder / "taught.csv", "-o", out)
    assert done.returncode in (0, 1), done.stderr
    return out
