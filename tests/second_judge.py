"""A second judge of plans: it reads the TEXT of programs and knows neither wpcal's interpreters nor its collisions.

Joints become places by the URDF file, and poses joints by Newton steps on it. Links are the vertices of their meshes,
the torch is points on its capsules, the wire points on a line; a point is inside the part where the winding number of
its solids' triangles says so. `pytest -m deep -rP tests/e2e/test_second_judge.py` shows a row for each program.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation, Slerp

from tests.moves_of_programs import circle_through
from tests.second_readers import READERS, Step, posed
from tests.wire_judge import Array, off_surface, winding

STEP_MM, STEP_RAD = 5.0, 0.05  #: Between two judged states.
ALONG_MM = 5.0  #: Between points of the wire and of a capsule.
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
            name: points[rng.permutation(len(points))[:MOST_POINTS]] for name, (points, _) in self.chain.meshes.items()
        }
        capsules = [each for shape in robot["torch"] for each in shape["capsules"]]
        self.torch = np.concatenate([_on_capsule(each) for each in capsules])
        wire = min(float(np.linalg.norm(_nearest(each["p_mm"], each["q_mm"]))) - each["radius_mm"] for each in capsules)
        self.wire = np.zeros((int(wire / 1.0) + 1, 3))
        self.wire[:, 2] = -np.arange(len(self.wire))
        self.slopes: Array | None = None
        self.solids = _solids(corners)

    def tool(self, q: Array) -> Array:
        """Return T_base_tool at joints, rad."""
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
        J = np.empty((6, 6))
        for k in range(6):
            more = q.copy()
            more[k] += 1e-6
            at = self.tool(more)
            J[:, k] = np.concatenate([at[:3, 3] - now[:3, 3], 500.0 * _turn(now, at)]) / 1e-6
        return J

    def states(self, steps: list[Step]) -> Iterator[tuple[int, bool, Array]]:
        """Yield the number of the step, whether it is on a line, and the joints, rad."""
        q: Array | None = None
        for number, step in enumerate(steps):
            if step.kind == "J":
                goal = np.radians(step.joints)
                start = goal if q is None else q
                count = int(np.ceil(np.abs(goal - start).max() / STEP_RAD)) + 1
                yield from ((number, False, start + t * (goal - start)) for t in np.linspace(0.0, 1.0, count + 1))
                q = goal
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
        worst: dict[str, Contact] = {}
        into = np.linalg.inv(self.T_part)
        for number, on_line, q in states:
            tool = self.T_base @ self.tool(q)
            bodies = {"torch": self.torch, "wire": self.wire[int(TIP_MM) :] if on_line else self.wire}
            world = {name: p @ tool[:3, :3].T + tool[:3, 3] for name, p in bodies.items()}
            for name, points in self.links.items():
                if self.chain.moved_by(name) >= 2:
                    T = self.T_base @ self.chain.pose(name, q)
                    world[name] = points @ T[:3, :3].T + T[:3, 3]
            for name, p in world.items():
                below = self.floor - float(p[:, 2].min())
                if below > DEEP_MM and below > worst.get(f"{name} and floor", Contact("", 0.0, 0)).deep_mm:
                    worst[f"{name} and floor"] = Contact(f"{name} and floor", below, number)
                local = p @ into[:3, :3].T + into[:3, 3]
                for low, high, corners in self.solids:
                    near = local[((local > low) & (local < high)).all(axis=1)]
                    inside = near[winding(near, corners) > 0.5] if len(near) else near
                    deep = float(off_surface(inside, corners).max()) if len(inside) else 0.0
                    if deep > DEEP_MM and deep > worst.get(name, Contact("", 0.0, 0)).deep_mm:
                        worst[name] = Contact(name, deep, number)
        return list(worst.values())

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


def _nearest(p: Any, q: Any) -> Array:
    """Return the point of a segment that is nearest to the origin."""
    a, edge = np.array(p, float), np.array(q, float) - np.array(p, float)
    return a - np.clip(a @ edge / max(float(edge @ edge), 1e-12), -1.0, 0.0) * edge


def _on_capsule(capsule: dict[str, Any]) -> Array:
    """Return points on the shell of a capsule and on its axis."""
    p, q, r = np.array(capsule["p_mm"], float), np.array(capsule["q_mm"], float), capsule["radius_mm"]
    along = np.linspace(0.0, 1.0, int(np.linalg.norm(q - p) / ALONG_MM) + 2)[:, None]
    axis = p + along * (q - p)
    golden = np.arange(24) * np.pi * (3.0 - np.sqrt(5.0))
    z = 1.0 - 2.0 * (np.arange(24) + 0.5) / 24.0
    ball = r * np.stack([np.sqrt(1 - z**2) * np.cos(golden), np.sqrt(1 - z**2) * np.sin(golden), z], axis=1)
    thin = axis[:: max(1, len(axis) // 8)]
    return np.concatenate([axis, (thin[:, None] + ball).reshape(-1, 3), p + ball, q + ball])


def _turn(a: Array, b: Array) -> Array:
    return (Rotation.from_matrix(b[:3, :3]) * Rotation.from_matrix(a[:3, :3]).inv()).as_rotvec()


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
    routines = {name: list(READERS[name](texts_of(out / name))) for name in languages if (out / name).is_dir()}
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
        assert judge is not None
        states = [list(judge.states(steps)) for steps in routines]
        contacts = tuple(contact for own in states for contact in judge.contacts(own))
        yield Row(part, arm, name, sum(map(len, routines)), contacts, judge.welded_share(max(states, key=len), result))


def result_for(part: str | int, folder: Path) -> Path:
    """Return the result of a part of the fixtures, or of the bracket of a seed."""
    from tests.judgements import calibrated
    from tests.samples.brackets import write_bracket
    from tests.whole_table import result_of

    return result_of(part, folder) if isinstance(part, str) else calibrated(write_bracket(part, folder), folder)[0]
