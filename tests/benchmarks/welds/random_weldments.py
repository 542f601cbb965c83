"""Weldments nobody has seen, with their lists: `python -m tests.benchmarks.welds.random_weldments SEED FOLDER`.

Each is drawn as a job shop would: random sections, radii, copes, sizes from 50 mm to 3 m. It is written three times:
as bodies with gaps of 0 to 1 mm, as one fused body, and fused and turned. The list says where two members meet on the
surface. A hollow corner is a sure weld if a torch is free there by rays, and optional where the torch is nowhere or the
run is short. Where members are flush, a weld is probable, and optional if fused. Nothing of `wpcal.seam` takes part.
"""

import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import build123d as b
import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.gp import gp_Trsf
from OCP.TopLoc import TopLoc_Location
from scipy.spatial.transform import Rotation

from cad.kernel.to_brep import to_brep
from cad.step.new_file import plain_step_text
from tests.benchmarks.welds.lists import OPTIONAL, PROBABLE, SCHEMA, SURE, USUAL_TOL_MM, Weld, sha256, to_json
from wpcal.brep.material import ExactMaterial, find_solids_around
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray

NOZZLE_MM, WIRE_MM, FAR_MM = 11.0, 20.0, 300.0  #: Radius of the nozzle, wire before it, and length of the torch.
ALONG_DEG, ACROSS_DEG = (-30.0, -15.0, 0.0, 15.0, 30.0), (-15.0, 0.0, 15.0)  #: Leans.
SHORT_MM = 16.0  #: Shorter runs are ends of plates.
NARROW = 35  #: Of 36 points round an edge, so many are inside the material beside a corner that closes to nothing.
FLARE_MM = 12.5  #: From the bottom of a flare groove beside the largest radius to the seam in its mouth.
COUNT = 2  #: Weldments per family.
MADE = {"how": "by construction", "date": "2026-11-29"}
HOLLOW, FLUSH = 20, 17  #: Of 36 points round an edge, so many are in the material at a hollow corner, at flush faces.
PLACES, NEAR_MM = (0.25, 0.5, 0.75), 0.05  #: Where along an edge, and how far from it, these points are.
Rng = np.random.Generator
Drawn = tuple[str, Any, tuple[float, float, float]]  #: A member: name, shape, and the way in which a gap opens it.


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


def up(name: str, shape: Any) -> Drawn:
    return name, shape, (0, 0, 1)


def still(name: str, shape: Any) -> Drawn:
    return name, shape, (0, 0, 0)


def pick(rng: Rng, *choices: float) -> float:
    return float(rng.choice(choices))


def between(rng: Rng, low: float, high: float, step: float = 5.0) -> float:
    return float(round(rng.uniform(low, high) / step) * step)


def plate_holes(shape: Any, radius: float, *places: tuple[float, float, float]) -> Any:
    return cut(shape, *(cylinder(radius, 200, (x, y, z - 100), (0, 0, 1)) for x, y, z in places))


def hopper(rng: Rng) -> list[Drawn]:
    """Four sloping plates with a flange on top and a spout of tube below."""
    t, a, c, h = pick(rng, 3, 4, 5, 6), between(rng, 200, 500), between(rng, 60, 120), between(rng, 150, 350)
    slope = (a - c) / 2 / h
    k = t * math.hypot(1, slope)  # thickness of a wall, measured level

    def wedge(half: float, deep: float, least: float) -> Any:
        return prism([(half, 0), (half + slope * h, h), (half + slope * h - k, h), (half - k, 0)], 2 * deep,
                     b.Plane(origin=(0, deep, 0), x_dir=(1, 0, 0), z_dir=(0, -1, 0)))  # fmt: skip

    right = wedge(c / 2, a / 2 + 12, k)
    left = right.rotate(b.Axis.Z, 180)
    front = wedge(c / 2, a / 2 + 12, k).rotate(b.Axis.Z, 90)
    room = prism([(-c / 2 + k, 0), (c / 2 - k, 0), (a / 2 - k, h), (-a / 2 + k, h)], 4 * a,
                 b.Plane(origin=(0, 2 * a, 0), x_dir=(1, 0, 0), z_dir=(0, -1, 0)))  # fmt: skip
    front = front.intersect(room)
    front = front if isinstance(front, b.Solid) else front.solids()[0]
    back = front.rotate(b.Axis.Z, 180)
    rim = cut(
        box(a + 80, a + 80, 8, (-a / 2 - 40, -a / 2 - 40, h)), box(a - 2 * k, a - 2 * k, 8, (k - a / 2, k - a / 2, h))
    )
    rim = plate_holes(rim, 5.5, *((x, y, h) for x in (-a / 2 - 25, a / 2 + 25) for y in (-a / 2 - 25, 0, a / 2 + 25)))
    spout = cut(
        box(c + 20, c + 20, 80, (-c / 2 - 10, -c / 2 - 10, -80)), box(c + 12, c + 12, 80, (-c / 2 - 6, -c / 2 - 6, -80))
    )
    neck = cut(
        box(c + 60, c + 60, 6, (-c / 2 - 30, -c / 2 - 30, -6)), box(c - 2 * k, c - 2 * k, 6, (k - c / 2, k - c / 2, -6))
    )
    spout = spout.translate((0, 0, -6))
    return [still("right", right), still("left", left), still("front", front), still("back", back),
            up("rim", rim), ("neck", neck, (0, 0, -1)), ("spout", spout, (0, 0, -1))]  # fmt: skip


def tank_leg(rng: Rng) -> list[Drawn]:
    """A tank of rolled plate with a bottom, on legs of plate with feet, with a nozzle in its wall."""
    r, t, h = between(rng, 120, 300), pick(rng, 4, 5, 6), between(rng, 300, 600)
    shell = cut(cylinder(r, h, (0, 0, 0), (0, 0, 1)), cylinder(r - t, h, (0, 0, 0), (0, 0, 1)))
    q = pick(rng, 25, 35, 45)
    pipe, hole = (cylinder(x, r + 90, (0, 0, 0.7 * h), (0, -1, 0)) for x in (q, q - 4))
    core = cylinder(r, h, (0, 0, 0), (0, 0, 1))
    shell = cut(shell, cylinder(q - 4, r + 90, (0, 0, 0.7 * h), (0, -1, 0)))
    bottom = cylinder(r + 15, 8, (0, 0, -8), (0, 0, 1))
    members = [
        still("shell", shell),
        ("bottom", bottom, (0, 0, -1)),
        ("nozzle", cut(cut(pipe, hole), core), (0, -1, 0)),
    ]
    for k in range(3):
        outline = [(r - 5, 120), (r + 70, 60), (r + 70, -150), (r + 30, -150), (r + 30, -20), (r - 5, -20)]
        leg = prism(outline, 12, b.Plane(origin=(0, 6, 0), x_dir=(1, 0, 0), z_dir=(0, -1, 0)))
        leg = cut(leg, core, bottom)
        foot = plate_holes(box(90, 90, 10, (r + 5, -45, -160)), 7, (r + 18, 30, -160), (r + 18, -30, -160))
        turn = 90 + 120 * k + 60
        way = (math.cos(math.radians(turn)), math.sin(math.radians(turn)), 0)
        members += [(f"leg{k}", leg.rotate(b.Axis.Z, turn), way), (f"foot{k}", foot.rotate(b.Axis.Z, turn), (0, 0, -1))]
    return members


def box_beam(rng: Rng) -> list[Drawn]:
    """A trough of three plates with diaphragms that have snipped corners, now and then closed by a wider cover."""
    t, w, h, n = pick(rng, 6, 8, 10), between(rng, 120, 250), between(rng, 100, 200), int(rng.integers(1, 4))
    long, s = 200.0 * (n + 1), pick(rng, 0, 12, 15)
    web, floor = box(long, t, h), box(long, w + 60, t, (0, -30, -t))
    members = [still("floor", floor), up("web0", web.translate((0, 0, 0))), up("web1", web.translate((0, w - t, 0)))]
    for k in range(n):
        a, c = w - 2 * t, h - pick(rng, 15, 30)
        outline = [(s, 0), (a - s, 0), (a, s), (a, c), (0, c), (0, s)] if s else [(0, 0), (a, 0), (a, c), (0, c)]
        rib = prism(outline, pick(rng, 5, 6), b.Plane(origin=(200.0 * (k + 1), t, 0), x_dir=(0, 1, 0), z_dir=(1, 0, 0)))
        members.append(up(f"rib{k}", cut(rib, cylinder(a / 5, 20, (200.0 * (k + 1) - 5, w / 2, c / 2), (1, 0, 0)))))
    if rng.random() < 0.4:
        members.append(up("cover", box(long, w + 40, t, (0, -20, h))))
    return members


def grating(rng: Rng) -> list[Drawn]:
    """Flat bars on edge in a frame of flats."""
    n, d, t, f = int(rng.integers(4, 8)), pick(rng, 25, 30, 40), pick(rng, 3, 4, 5), pick(rng, 5, 6)
    a, w = between(rng, 300, 600, 10), between(rng, 200, 400, 10)
    members = [still(f"side{k}", box(a, f, d, (0, y, 0))) for k, y in enumerate((0, w - f))]
    members += [still(f"end{k}", box(f, w - 2 * f, d, (x, f, 0))) for k, x in enumerate((0, a - f))]
    at = ((f, f + (w - 2 * f) * (k + 1) / (n + 1) - t / 2, 0) for k in range(n))
    return members + [still(f"bar{k}", box(a - 2 * f, t, d - pick(rng, 0, 5), place)) for k, place in enumerate(at)]


FAMILIES: tuple[Callable[[Rng], list[Drawn]], ...] = (hopper, tank_leg, box_beam, grating)


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


def welds_of(members: list[Any], names: list[str]) -> Iterator[Weld]:
    """Yield where two members meet on the surface: both are round an edge of the fused body."""
    with b.SkipClean():  # faces of two members in one plane keep the line between them
        body = members[0].fuse(*members[1:])
    vertices, faces = body.tessellate(0.2, 0.2)
    triangles = np.array([tuple(v) for v in vertices])[np.array(faces)]
    edges = body.edges()
    p = np.array([[tuple(edge.position_at(share)) for share in PLACES] for edge in edges])
    way = np.array([[tuple(edge.tangent_at(share)) for share in PLACES] for edge in edges])
    u = np.cross(way, np.eye(3)[np.abs(way).argmin(axis=2)])
    u /= np.linalg.norm(u, axis=2, keepdims=True)
    turn = 0.04 + np.linspace(0, 2 * np.pi, 36, endpoint=False)[:, None]  # not along the faces
    around = np.cos(turn) * u[:, :, None] + np.sin(turn) * np.cross(way, u)[:, :, None]
    graph = to_brep([(name, member.wrapped) for name, member in zip(names, members, strict=True)])
    point, solid = find_solids_around(
        ExactMaterial(graph, TrimmedFaces.of(graph)), (p[:, :, None] + NEAR_MM * around).reshape(-1, 3)
    )
    inside = np.zeros((len(names), *around.shape[:3]), dtype=bool)
    inside.reshape(len(names), -1)[solid, point] = True
    for row, edge in enumerate(edges):
        pair = np.flatnonzero((inside[:, row].sum(axis=2) > 1).all(axis=1))
        full = inside[pair, row].any(axis=0)
        if len(pair) < 2 or full.all(axis=1).any():
            continue
        free = []
        for place in range(len(PLACES)):
            out = around[row, place][~full[place]].sum(axis=0)
            reached = full[place].sum() < NARROW and np.linalg.norm(out) > NEAR_MM
            free.append(reached and is_free(triangles, p[row, place], way[row, place], out / np.linalg.norm(out)))
        least, sides = full.sum(axis=1).min(), (full != np.roll(full, 1, axis=1)).sum(axis=1).max()
        is_flare, is_hollow = least >= NARROW or sides > 2, least >= HOLLOW
        kind = "flare groove" if is_flare else "hollow corner" if is_hollow else "flush" if least >= FLUSH else "edge"
        best = SURE if kind == "hollow corner" and all(free) else PROBABLE
        cls = OPTIONAL if edge.length < SHORT_MM or (not any(free) and not is_flare) or kind == "edge" else best
        count = 2 if edge.geom_type == b.GeomType.LINE else 61
        points = np.array([tuple(edge.position_at(s)) for s in np.linspace(0, 1, count)])
        tol_mm = FLARE_MM if is_flare else USUAL_TOL_MM
        yield Weld(f"W{row}", tuple(names[k] for k in pair[:2]), kind, cls, points, tol_mm)


def moved(shape: Any, R: FloatArray, t: FloatArray) -> Any:
    """Return the kernel's shape with a motion in its geometry; it may be larger then."""
    motion = gp_Trsf()
    motion.SetValues(*np.column_stack([R, t]).ravel().tolist())
    return BRepBuilderAPI_Transform(shape, motion, True).Shape()


def write(seed: int, folder: Path) -> None:
    """Write bodies and lists of all families."""
    folder.mkdir(parents=True, exist_ok=True)
    for row, family in enumerate(FAMILIES):
        for number in range(COUNT):
            rng = np.random.default_rng([seed, row, number])
            names, shapes, ways = (list(each) for each in zip(*family(rng), strict=True))
            whole = shapes[0].fuse(*shapes[1:]).clean()
            size = float(np.linalg.norm(tuple(whole.bounding_box().size)))
            scale = 1.0 if number == 0 else float(np.clip(rng.choice([0.25, 0.5, 2.0, 3.0]), 50 / size, 3000 / size))
            shapes = [b.Solid(moved(shape.wrapped, scale * np.eye(3), np.zeros(3))) for shape in shapes]
            welds = list(welds_of(shapes, names))
            gap = float(rng.choice([0.0, 0.0, 0.2, 0.5, 1.0]))
            apart = [s.translate(tuple(gap * x for x in way)) for s, way in zip(shapes, ways, strict=True)]
            R = Rotation.random(random_state=int(rng.integers(1 << 31))).as_matrix()
            t = rng.uniform(-500, 500, 3)
            one = [replace(w, cls=w.cls if w.kind in ("hollow corner", "flare groove") else OPTIONAL) for w in welds]
            turned = [replace(w, points=w.points @ R.T + t) for w in one]
            scaled = (moved(s.wrapped, scale * np.eye(3), np.zeros(3)) for s in whole.solids())
            bodies = [(f"{family.__name__}-{k}", s) for k, s in enumerate(scaled)]
            for variant, own, listed in (
                ("apart", [(n, s.wrapped) for n, s in zip(names, apart, strict=True)], welds),
                ("fused", bodies, one),
                ("moved", [(n, moved(s, R, t)) for n, s in bodies], turned),
            ):
                name = f"{family.__name__.replace('_', '-')}-{seed}-{number}-{variant}"
                path = folder / f"{name}.step"
                path.write_bytes(plain_step_text([(n, s, TopLoc_Location()) for n, s in own], name, pcurves=False))
                part = {"file": path.name, "sha256": sha256(path), "source": "generated", "licence": "MIT"}
                about = f"{family.__doc__} Scale {scale:.2f}, gap {gap:g} mm."
                record = {"schema": SCHEMA, "name": name, "about": about, "part": part, "made": MADE}
                record |= {"bodies": [{"name": n, "what": "member", "welded": True} for n, _ in own]}
                record |= {"welds": [w.to_record() for w in listed]}
                path.with_suffix(".json").write_text(to_json(record), encoding="utf-8")


if __name__ == "__main__":
    write(int(sys.argv[1]), Path(sys.argv[2]))
