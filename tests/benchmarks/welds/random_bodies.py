"""Fused bodies nobody has seen, with their lists: `python -m tests.benchmarks.welds.random_bodies SEED FOLDER`.

Members of random sections are put together with copes, slots, gussets and holes, and fused. A weld is an edge of the
body at a hollow corner round which material of two members is: found by the kernel's classifier. One that closes to
nothing, as beside the radius of a flush tube, is a flare groove, and probable. Another one is sure where a
torch (nozzle of 22 mm, 20 mm of wire, leans up to 30 degrees) is free by rays, optional where it is nowhere or shorter
than 16 mm. Nothing of `wpcal.seam` takes part.
"""

import math
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import build123d as b
import numpy as np
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_State
from OCP.TopLoc import TopLoc_Location

from cad.step.new_file import plain_step_text
from tests.benchmarks.welds.lists import OPTIONAL, PROBABLE, SCHEMA, SURE, USUAL_TOL_MM, Weld, sha256, to_json
from wpcal.core.arrays import BoolArray, FloatArray

NOZZLE_MM, WIRE_MM, FAR_MM = 11.0, 20.0, 300.0  #: Radius of the nozzle, wire before it, and length of the torch.
ALONG_DEG, ACROSS_DEG = (-30.0, -15.0, 0.0, 15.0, 30.0), (-15.0, 0.0, 15.0)  #: Leans.
SHORT_MM = 16.0  #: Shorter runs are ends of plates.
NARROW = 35  #: Of 36 points round an edge, so many are inside the material beside a corner that closes to nothing.
FLARE_MM = 12.5  #: From the bottom of a flare groove beside the largest radius to the seam in its mouth.
COUNT = 6  #: Bodies per family.
Rng = np.random.Generator


def box(x: float, y: float, z: float, at: tuple[float, float, float] = (0, 0, 0)) -> Any:
    """Return a plate or bar whose least corner is at a place."""
    return b.Solid.make_box(x, y, z, b.Plane(origin=at))


def cylinder(radius: float, height: float, at: tuple[float, float, float], axis: tuple[float, float, float]) -> Any:
    return b.Solid.make_cylinder(radius, height, b.Plane(origin=at, z_dir=axis))


def cut(body: Any, *tools: Any) -> Any:
    """Return a body without the room of others; it stays one."""
    return max(body.cut(*tools).solids(), key=lambda solid: solid.volume) if tools else body


def prism(points: list[tuple[float, float]], length: float, plane: b.Plane) -> Any:
    """Return a polygon that is drawn out along the normal of a plane."""
    face = b.Face(b.Wire.make_polygon([plane.from_local_coords((x, y, 0)) for x, y in points], close=True))
    return b.Solid.extrude(face, plane.z_dir * length)


def section(rng: Rng, kind: str, length: float) -> tuple[Any, float, float]:
    """Return a member along z with its section in x from 0 and y from 0, and its width and height."""
    h, t = float(rng.integers(6, 20) * 10), float(rng.choice([4, 5, 6, 8, 10]))
    w = float(max(50, round(h * rng.uniform(0.5, 1.0))))
    f, r = t * float(rng.choice([1.0, 1.4])), float(rng.choice([0.0, 0.8, 1.2])) * t
    if kind == "pipe":
        outer, inner = (cylinder(radius, length, (h / 2, h / 2, 0), (0, 0, 1)) for radius in (h / 2, h / 2 - t))
        return cut(outer, inner), h, h
    if kind == "tube":
        outer, inner = box(w, h, length), box(w - 2 * t, h - 2 * t, length, (t, t, 0))
        if r:
            outer = outer.fillet(1.8 * t, outer.edges().filter_by(b.Axis.Z))
            inner = inner.fillet(0.8 * t, inner.edges().filter_by(b.Axis.Z))
        return cut(outer, inner), w, h
    if kind == "angle":
        outline, roots = [(0, 0), (w, 0), (w, t), (t, t), (t, h), (0, h)], [(t, t)]
    elif kind == "channel":
        outline, roots = [(0, 0), (w, 0), (w, f), (t, f), (t, h - f), (w, h - f), (w, h), (0, h)], [(t, f), (t, h - f)]
    elif kind == "beam":
        a, c = (w - t) / 2, (w + t) / 2
        right = [(w, 0), (w, f), (c, f), (c, h - f), (w, h - f), (w, h)]
        outline = [(0, 0), *right, (0, h), (0, h - f), (a, h - f), (a, f), (0, f)]
        roots = [(a, f), (c, f), (a, h - f), (c, h - f)]
    else:
        return box(t, h, length), t, h
    body = prism(outline, length, b.Plane.XY)
    if r:
        edges = body.edges().filter_by(b.Axis.Z)
        body = body.fillet(
            r, [e for e in edges if any(math.dist((e.center().X, e.center().Y), p) < 1e-6 for p in roots)]
        )
    return body, w, h


def column(rng: Rng) -> list[Any]:
    """Return a section on a plate with holes, now and then with gussets at one side."""
    body, w, h = section(
        rng, str(rng.choice(["tube", "pipe", "beam", "channel", "angle"])), float(rng.integers(15, 60) * 10)
    )
    t, edge = float(rng.choice([8, 10, 12, 15, 20])), float(rng.integers(20, 60))
    at = [(x, y) for x in (12 - edge, w + edge - 12) for y in (12 - edge, h + edge - 12)]
    foot = cut(
        box(w + 2 * edge, h + 2 * edge, t, (-edge, -edge, -t)), *(cylinder(5, t, (*p, -t), (0, 0, 1)) for p in at)
    )
    members = [foot, body]
    if rng.random() < 0.5:
        g, s, tg = edge - 4, float(rng.choice([0, 8, 12])), float(rng.choice([5, 6, 8]))
        outline = [(s, 0), (g, 0), (g, 6), (6, 1.5 * g), (0, 1.5 * g), (0, s)][: 6 if s else 5]
        members.append(prism(outline, tg, b.Plane(origin=(w / 2 + tg / 2, 0, 0), x_dir=(0, -1, 0), z_dir=(-1, 0, 0))))
    return members


def branch(rng: Rng) -> list[Any]:
    """Return a tube that is coped to another one, upright or at an angle."""
    kind = str(rng.choice(["tube", "pipe"]))
    main, w, h = section(rng, kind, 500.0)
    main = main.rotate(b.Axis.Y, 90).translate((-250, -h / 2, (w if kind == "tube" else h) / 2))
    scale, angle = float(rng.uniform(0.4, 0.85)), float(rng.choice([90, 90, 60, 50]))
    r, t = scale * h / 2, float(rng.choice([3, 4, 5]))
    if kind == "pipe":
        arm, hole = (cylinder(radius, 320, (0, 0, 0), (0, 0, 1)) for radius in (r, r - t))
        core = cylinder(h / 2, 600, (-300, 0, 0), (1, 0, 0))
    else:
        arm, hole = (box(2 * half, 2 * half, 320, (-half, -half, 0)) for half in (r, r - t))
        core = box(600, h, w, (-300, -h / 2, -w / 2))
    return [main, cut(cut(arm, hole).rotate(b.Axis.Y, 90 - angle), core)]


def slotted(rng: Rng) -> list[Any]:
    """Return plates that go through slots of another one, straight or askew."""
    t, s, n = float(rng.choice([6, 8, 10, 12])), float(rng.choice([5, 6, 8, 10])), int(rng.integers(1, 4))
    w, high, through = float(rng.integers(8, 15) * 10), float(rng.integers(6, 14) * 10), float(rng.integers(0, 3) * 15)
    members, tools, pitch = [], [], float(rng.integers(60, 110))
    for i in range(n):
        tab = box(s, w, high + t + through, (i * pitch - s / 2, -w / 2, -t - through)).rotate(
            b.Axis((i * pitch, 0, 0), (0, 0, 1)), float(rng.choice([0, 0, 20]))
        )
        members.append(tab)
        tools.append(tab)
    return [cut(box((n + 1) * pitch, w + 80, t, (-pitch, -w / 2 - 40, -t)), *tools), *members]


def coped(rng: Rng) -> list[Any]:
    """Return a beam whose ends are coped to fit between the flanges of another one."""
    main, w, h = section(rng, str(rng.choice(["beam", "channel"])), 500.0)
    main = main.rotate(b.Axis.X, 90).translate((0, 250, 0))  # along y, flanges below and above
    flanges = (box(600, 600, h * 0.6, (-300, -300, z)) for z in (h * 0.8, -h * 0.4))
    web_face = max(v.X for v in cut(main, *flanges).vertices())
    t, d = float(rng.choice([5, 6, 8])), h * float(rng.uniform(0.45, 0.65))
    low = (h - d) / 2
    web = box(350, t, d, (web_face, -t / 2, low))
    flange = box(350 - w, 70, t, (web_face + w, -35, low + d))
    return [main, web.fuse(flange, box(350 - w, 70, t, (web_face + w, -35, low - t))).clean().solid()]


def bracket(rng: Rng) -> list[Any]:
    """Return a plate, an upright with an eye or a slot, and ribs with snipped corners."""
    t, u = (float(x) for x in rng.choice([6, 8, 10, 12, 15], 2))
    w, d, h = (float(rng.integers(*span) * 10) for span in ((8, 25), (8, 20), (8, 18)))
    base = box(w, d, t, (0, 0, -t))
    base = base.fillet(10, base.edges().filter_by(b.Axis.Z))
    upright = box(w - 20, u, h, (10, d * 0.3, 0))
    upright = cut(
        upright,
        cylinder(h / 6, 3 * u, (w / 2, d * 0.3 - u, h * 0.7), (0, 1, 0)),
        *([box(20, 3 * u, 15, (w / 2 - 10, d * 0.3 - u, 0))] if rng.random() < 0.4 else []),
    )
    members, reach = [base, upright], d * 0.7 - u - 8
    for i in range(int(rng.integers(0, 4))):
        g, s = float(rng.choice([5, 6, 8])), float(rng.choice([0, 10, 15]))
        outline = [(s, 0), (reach, 0), (reach, 8), (8, h * 0.7), (0, h * 0.7), (0, s)][: 6 if s else 5]
        at = (22 + g + i * (w - 44 - g) / 3, d * 0.3 + u, 0)
        members.append(prism(outline, g, b.Plane(origin=at, x_dir=(0, 1, 0), z_dir=(-1, 0, 0))))
    return members


def crate(rng: Rng) -> list[Any]:
    """Return an open box of plates with one or two stiffeners that have mouse holes."""
    t = float(rng.choice([4, 5, 6, 8, 10]))
    w, d, h = (float(rng.integers(*span) * 10) for span in ((20, 50), (15, 30), (8, 18)))
    members = [
        box(w, d, t, (0, 0, -t)),
        *(box(w, t, h, (0, y, 0)) for y in (0, d - t)),
        *(box(t, d - 2 * t, h, (x, t, 0)) for x in (0, w - t)),
    ]
    for i in range(int(rng.integers(1, 3))):
        x = w * (i + 1) / 3
        holes = [cylinder(12, t, (x, y, 0), (1, 0, 0)) for y in (t, d - t)]
        members.append(cut(box(t, d - 2 * t, h * 0.7, (x, t, 0)), *holes))
    return members


def frame(rng: Rng) -> list[Any]:
    """Return a frame of tubes that are butted, with foot plates and a brace that is cut to fit."""
    w, t = float(rng.choice([40, 50, 60, 80])), float(rng.choice([3, 4, 5]))
    wide, high = (float(rng.integers(40, 90) * 10) for _ in range(2))

    def tube(length: float, at: tuple[float, float, float], axis: str) -> Any:
        body = cut(box(w, w, length), box(w - 2 * t, w - 2 * t, length, (t, t, 0)))
        return (body.rotate(b.Axis.Y, 90).translate((0, 0, w)) if axis == "x" else body).translate(at)

    posts = [tube(high, (x, 0, 0), "z") for x in (0, wide + w)]
    rails = [tube(wide, (w, 0, z), "x") for z in (high - w, float(rng.integers(10, 25) * 10))]
    feet = [box(w + 60, w + 60, 10, (x - 30, -30, -10)) for x in (0, wide + w)]
    long = 0.35 * wide
    brace = cut(box(0.6 * w, 0.6 * w, 3 * long), box(0.6 * w - 2 * t, 0.6 * w - 2 * t, 3 * long, (t, t, 0)))
    brace = brace.translate((-0.3 * w, 0.2 * w, -1.5 * long)).rotate(b.Axis.Y, 45)
    brace = brace.translate((w + long / 2, 0, high - w - long / 2))
    below = box(w + 4 * long, 3 * w, 9 * high, (-4 * long, -w, -high))
    brace = cut(brace, below, box(9 * wide, 3 * w, 9 * high, (-wide, -w, high - w)))
    return [*posts, *rails, *feet, brace] if rng.random() < 0.7 else [*posts, *rails, *feet]


def single(rng: Rng) -> list[Any]:
    """Return one body that nobody welds: a section, a bent sheet, a milled block, a turned shaft."""
    kind = int(rng.integers(4))
    if kind == 0:
        return [
            section(rng, str(rng.choice(["angle", "channel", "beam", "tube"])), float(rng.integers(20, 60) * 10))[0]
        ]
    if kind == 1:
        t, a, c = float(rng.choice([2, 3, 4])), *(float(x) for x in rng.integers(40, 120, 2))
        sheet = prism([(0, 0), (a, 0), (a, t), (t, t), (t, c), (0, c)], float(rng.integers(50, 200)), b.Plane.XY)
        corner = {(0.0, 0.0): 2 * t, (t, t): t}
        for place, radius in corner.items():
            sheet = sheet.fillet(
                radius,
                [e for e in sheet.edges().filter_by(b.Axis.Z) if math.dist((e.center().X, e.center().Y), place) < 1e-6],
            )
        return [sheet]
    x, y, z = (float(v) for v in rng.integers(60, 200, 3))
    if kind == 2:
        pocket = box(0.6 * x, 0.5 * y, z, (0.2 * x, 0.25 * y, 0.4 * z))
        pocket = pocket.fillet(6, pocket.edges().filter_by(b.Axis.Z))
        hole = cylinder(8, z, (0.1 * x, 0.1 * y, 0), (0, 0, 1))
        return [cut(box(x, y, z), pocket, box(0.3 * x, y, 0.3 * z, (0.7 * x, 0, 0.7 * z)), hole)]
    return [
        cylinder(x / 4, z, (0, 0, 0), (0, 0, 1))
        .fuse(cylinder(x / 2, z / 4, (0, 0, z / 3), (0, 0, 1)), cylinder(x / 6, z / 2, (0, 0, z), (0, 0, 1)))
        .clean()
        .solid()
    ]


FAMILIES: tuple[Callable[[Rng], list[Any]], ...] = (column, branch, slotted, coped, bracket, crate, frame, single)


def is_inside(body: Any, points: FloatArray) -> BoolArray:
    """Tell which points are inside a solid."""
    judge = BRepClass3d_SolidClassifier(body.wrapped)
    found = np.zeros(len(points), dtype=bool)
    for row, p in enumerate(points.tolist()):
        judge.Perform(gp_Pnt(*p), 1e-7)
        found[row] = judge.State() == TopAbs_State.TopAbs_IN
    return found


def is_free(triangles: FloatArray, p: FloatArray, way: FloatArray, out: FloatArray) -> bool:
    """Tell whether a torch gets to a place: nine rays as wide as its nozzle meet nothing in one of 15 leans."""
    side = np.cross(way, out)
    a, e, f = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    for along in np.radians(ALONG_DEG):
        for across in np.radians(ACROSS_DEG):
            d = out + math.tan(along) * way + math.tan(across) * side
            d /= np.linalg.norm(d)
            u = np.cross(d, way if abs(d @ way) < 0.9 else side)
            u /= np.linalg.norm(u)
            turn = np.linspace(0, 2 * np.pi, 9)[:, None]
            start = (
                p
                + WIRE_MM * d
                + np.where(np.arange(9)[:, None] < 8, NOZZLE_MM, 0) * (np.cos(turn) * u + np.sin(turn) * np.cross(d, u))
            )
            h = np.cross(d, f)
            det = np.einsum("ij,ij->i", e, h)
            with np.errstate(all="ignore"):
                s = start[:, None] - a
                x = np.einsum("kij,ij->ki", s, h) / det
                q = np.cross(s, e)
                y, far = q @ d / det, np.einsum("kij,ij->ki", q, f) / det
            if not ((np.abs(det) > 1e-12) & (x >= 0) & (y >= 0) & (x + y <= 1) & (far > 0) & (far < FAR_MM)).any():
                return True
    return False


def welds_between(members: list[Any], body: Any, name: str) -> Iterator[Weld]:
    """Yield the welds of a body: hollow corners with material of two members round them."""
    vertices, faces = body.tessellate(0.2, 0.2)
    triangles = np.array([tuple(v) for v in vertices])[np.array(faces)]
    for number, edge in enumerate(body.edges()):
        free = []
        for share in (0.25, 0.5, 0.75):
            p, way = (np.array(tuple(v)) for v in (edge.position_at(share), edge.tangent_at(share)))
            u = np.cross(way, np.eye(3)[np.argmin(np.abs(way))])
            u /= np.linalg.norm(u)
            turn = np.linspace(0, 2 * np.pi, 36, endpoint=False)[:, None]
            ring = np.cos(turn) * u + np.sin(turn) * np.cross(way, u)
            full = is_inside(body, p + 0.05 * ring)
            if full.sum() < 20 or sum(is_inside(one, p + 0.05 * ring).sum() > 1 for one in members) < 2:
                break
            out = ring[~full].sum(axis=0)
            free.append(full.sum() < NARROW and is_free(triangles, p, way, out / np.linalg.norm(out)))
        if len(free) == 3:
            is_flare = full.sum() >= NARROW
            cls = OPTIONAL if edge.length < SHORT_MM or not any(free) else SURE if all(free) else PROBABLE
            count = 2 if edge.geom_type == b.GeomType.LINE else 61
            points = np.array([tuple(edge.position_at(s)) for s in np.linspace(0, 1, count)])
            kind, tol_mm = ("flare groove", FLARE_MM) if is_flare else ("hollow corner", USUAL_TOL_MM)
            yield Weld(f"W{number}", (name,), kind, PROBABLE if is_flare else cls, points, tol_mm)


def write(seed: int, folder: Path) -> None:
    """Write bodies and lists of all families."""
    folder.mkdir(parents=True, exist_ok=True)
    for family in FAMILIES:
        for number in range(COUNT):
            name = f"{family.__name__}-{seed}-{number}"
            members = family(np.random.default_rng([seed, FAMILIES.index(family), number]))
            whole = members[0].fuse(*members[1:]).clean() if len(members) > 1 else members[0]
            body = max(whole.solids(), key=lambda solid: solid.volume)
            path = folder / f"{name}.step"
            path.write_bytes(plain_step_text([(name, body.wrapped, TopLoc_Location())], name, pcurves=False))
            part = {"file": path.name, "sha256": sha256(path), "source": "generated", "licence": "MIT"}
            welds = [weld.to_record() for weld in welds_between(members, body, name)] if len(members) > 1 else []
            made = {"how": "by construction", "date": "2026-11-27"}
            head = {"schema": SCHEMA, "name": name, "about": family.__doc__, "part": part, "made": made}
            record = head | {"bodies": [{"name": name, "what": "fused", "welded": bool(welds)}], "welds": welds}
            path.with_suffix(".json").write_text(to_json(record), encoding="utf-8")


if __name__ == "__main__":
    write(int(sys.argv[1]), Path(sys.argv[2]))
