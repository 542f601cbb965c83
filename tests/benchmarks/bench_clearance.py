"""Clearances of two arms: capsules, hulls in the order of their bounds, every hull, raw meshes; and a whole path."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh
from rich.console import Console
from rich.table import Table

from tests.benchmarks.timing import least_seconds
from tests.saddle import changed
from wpcal.core.arrays import FloatArray
from wpcal.planning.cell.bodies import body_pairs
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_file import read_cell
from wpcal.planning.cell.clearance import capsule_clearance
from wpcal.planning.cell.hulls import fcl_objects, hull_clearance
from wpcal.planning.cell.shape import Shape
from wpcal.planning.plan.recheck import check_path
from wpcal.robot.kinematics.urdf_bodies import capsule_around

ROOT = Path(__file__).parents[2]
CELL = ROOT / "fixtures" / "cells" / "two-mh6.json"
MESHES = ROOT.parent / "shared" / "robots" / "irb1600_6_12" / "meshes"
STATES = 2000
FEW = 60  #: States for what takes milliseconds each.
REPEATS = 5


def main() -> None:
    """Print the tables."""
    console = Console(width=110)
    rng = np.random.default_rng(0)
    cell = read_cell(CELL)
    states = np.concatenate([rng.uniform(-1.2, 1.2, (STATES, 6)), rng.uniform(-1.2, 1.2, (STATES, 6))], axis=1)
    table = Table(title="Clearance of two arms, µs per state")
    for heading in ("", "asked", "measured"):
        table.add_column(heading, justify="right" if heading else "left")
    arms = replace(cell, torch=(), part=(), bench=())
    pairs = len(body_pairs(cell))
    rows: list[tuple[str, str, Callable[[], object], int]] = [
        ("capsules, the links of two arms", "about 12", lambda: capsule_clearance(arms, states), STATES),
        (f"capsules, the whole cell ({pairs} pairs of bodies)", "", lambda: capsule_clearance(cell, states), STATES),
    ]
    if MESHES.is_dir():
        rows += with_meshes(arms, states)
    else:
        console.print("meshes of arms lie beside the checkout and are not here")
    for name, asked, action, count in rows:
        table.add_row(name, asked, f"{1e6 * least_seconds(action, REPEATS) / count:.1f}")
    console.print(table)
    path = np.concatenate([np.linspace(states[0, :6], states[1, :6], 73), np.linspace(*states[:2, 6:], 73)], axis=1)
    seconds = least_seconds(lambda: check_path(path, np.arange(73.0), cell), REPEATS)
    console.print(f"a path of 73 points checked at ten times finer steps: {1e3 * seconds:.1f} ms")


def with_meshes(arms: Cell, states: FloatArray) -> list[tuple[str, str, Callable[[], object], int]]:
    """Hulls of real links, and their triangles, placed unchanged in the frames of links: enough to measure time."""
    points = [trimesh.load(file).vertices for file in sorted(MESHES.glob("*.stl"))]
    shapes = tuple(_hull_shape(f"link {link}", link, corners) for link, corners in enumerate(points))
    hulled = changed(arms, links=shapes, links2=shapes)
    few = np.concatenate([states[:FEW, :6], states[:FEW, 6:]], axis=1)
    corners = sum(len(trimesh.PointCloud(corners).convex_hull.vertices) for corners in points)
    every = _Every(hulled, [fcl_objects(shape)[0][0] for shape in (*shapes, *shapes)])
    raw = _Every(hulled, [_mesh(file) for file in sorted(MESHES.glob("*.stl"))] * 2)
    return [
        (
            f"hulls of real links ({corners} corners an arm), least margin",
            "400",
            lambda: hull_clearance(hulled, states),
            STATES,
        ),
        ("the same, every pair of links", "", lambda: every(few), FEW),
        ("their triangles, every pair of links", "30000", lambda: raw(few), FEW),
    ]


def _hull_shape(name: str, link: int, corners: FloatArray) -> Shape:
    hull = trimesh.PointCloud(corners * 1e3 if np.ptp(corners) < 10 else corners).convex_hull.vertices
    p, q, radius = capsule_around(hull)
    return Shape(name, p, q, np.array([radius]), link, hull=hull)


def _mesh(file: Path) -> object:
    import fcl

    mesh = trimesh.load(file)
    model = fcl.BVHModel()
    model.beginModel(len(mesh.vertices), len(mesh.faces))
    model.addSubModel(mesh.vertices * (1e3 if np.ptp(mesh.vertices) < 10 else 1.0), mesh.faces)
    model.endModel()
    return fcl.CollisionObject(model, fcl.Transform())


class _Every:
    """Distances of all pairs of links of two arms by FCL, without any bound."""

    def __init__(self, cell: Cell, objects: list[object]) -> None:
        self.cell, self.objects, self.pairs = cell, objects, body_pairs(cell)

    def __call__(self, states: FloatArray) -> float:
        import fcl

        frames = [(frame.rotations(), frame.p.T) for frame in self.cell.frames(states)]
        least = np.inf
        for i in range(len(states)):
            for body, placed in zip(self.pairs.bodies, self.objects, strict=True):
                R, p = frames[body.carrier]
                placed.setTransform(fcl.Transform(R[min(i, len(R) - 1)], p[min(i, len(p) - 1)]))
            for a, b in zip(self.pairs.first, self.pairs.second, strict=True):
                found = fcl.distance(self.objects[a], self.objects[b], fcl.DistanceRequest(), fcl.DistanceResult())
                least = min(least, found)
        return least
