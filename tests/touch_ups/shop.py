"""A shop that plays a part with its errors and a welder who corrects points, in numbers only.

It shares no code with what it tests but the records: own motions, own smooth error of a robot, own rule of how a seam
follows the two bodies that it joins (with normals found by trimesh).
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

F = NDArray[np.float64]


@dataclass
class Part:
    """Seams of a result folder: middle and ends of every accepted one."""

    names: list[str]
    solids: list[tuple[str, ...]]
    frames: list[F]  #: (k, 4, 4) per seam, in base.
    normals: list[dict[str, F]]  #: Of each solid at the middle of the seam, in base.
    touchable: F  #: (m, 3) points of the part in base that can be touched.

    @property
    def middle(self) -> F:
        """Middle of all seams."""
        return np.concatenate([T[:, :3, 3] for T in self.frames]).mean(axis=0)


def load(folder: Path) -> Part:
    """Read a result folder."""
    record = json.loads((folder / "seams.json").read_text())
    calibration = json.loads((folder / "calibration.json").read_text())
    T = np.array(record["T_base_part"])
    scene = trimesh.load(folder / "part.glb")
    to_part = np.diag([1000.0, 1000.0, 1000.0, 1.0]) @ np.array(
        [[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]]
    )
    meshes = {}
    for node in scene.graph.nodes_geometry:
        place, geometry = scene.graph[node]
        if isinstance(scene.geometry[geometry], trimesh.Trimesh):
            mesh = scene.geometry[geometry].copy()
            mesh.apply_transform(T @ to_part @ place)
            meshes[geometry] = mesh
    part = Part([], [], [], [], np.array([point["p_base_mm"] for point in calibration["points"]]))
    for seam in record["seams"]:
        if not seam["accepted"]:
            continue
        frames = np.array([_matrix(frame) for frame in seam["frames"]])
        part.names.append(seam["name"])
        part.solids.append(tuple(seam["solids"]))
        part.frames.append(frames)
        middle = frames[len(frames) // 2]
        part.normals.append({s: _normal(meshes[s], middle) for s in seam["solids"] if s in meshes})
    return part


def _matrix(frame: dict[str, Any]) -> F:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = np.array(frame["R"]), frame["p_mm"]
    return T


def _normal(mesh: trimesh.Trimesh, at: F) -> F:
    """Normal of the face of a solid on which the seam lies: of those at the place the one that looks out most."""
    close = trimesh.triangles.closest_point(mesh.triangles, np.tile(at[:3, 3], (len(mesh.triangles), 1)))
    near = np.linalg.norm(close - at[:3, 3], axis=1) < 0.5
    normals = mesh.face_normals[near]
    normals = normals[np.abs(normals @ at[:3, 0]) < 0.3]
    return np.asarray(normals[np.argmax(normals @ at[:3, 2])])


@dataclass
class Truth:
    """Where things really are, in the robot's readings, against a model that stands at identity."""

    omega: F
    v: F
    centre: F
    knots: F
    weights: F
    length: float
    bodies: dict[str, tuple[F, F, F]]  #: omega, v and centre.

    @classmethod
    def draw(
        cls, rng: np.random.Generator, part: Part, *, field_mm: float, length: float, moved: int, plate_mm: float
    ) -> Truth:
        """Draw a pose, the robot's error, and plates that moved."""
        knots = part.middle + rng.uniform(-1500, 1500, (400, 3))
        truth = cls(
            rng.normal(0, 0.003, 3), rng.normal(0, 2.0, 3), part.middle, knots, rng.normal(0, 1, (400, 3)), length, {}
        )
        # variance of a sum of bumps exp(-d²/length²), 400 in a cube of 3 m: density times the integral of the square
        truth.weights *= field_mm / np.sqrt(400 / 3000.0**3 * (np.pi / 2.0 * length**2) ** 1.5)
        bodies = sorted({s for pair in part.solids if len(pair) == 2 for s in pair})
        for name in rng.permutation(bodies)[:moved]:
            own = [T[:, :3, 3] for T, pair in zip(part.frames, part.solids, strict=True) if name in pair]
            truth.bodies[str(name)] = (
                rng.normal(0, 0.002, 3),
                rng.normal(0, plate_mm, 3),
                np.concatenate(own).mean(axis=0),
            )
        return truth

    def field(self, x: F) -> F:
        """The robot's smooth error at places (n, 3)."""
        d2 = ((x[:, None] - self.knots[None]) ** 2).sum(axis=2)
        return np.asarray(np.exp(-d2 / self.length**2) @ self.weights)

    def rigid(self, x: F) -> F:
        """Displacement of points that move with the part."""
        return np.asarray(np.cross(self.omega, x - self.centre) + self.v)

    def point(self, x: F) -> F:
        """Displacement in the robot's readings of points of the part, on no body that moved."""
        return self.rigid(x) + self.field(x)

    def seam(self, part: Part, number: int) -> F:
        """Displacement of the frames of a seam in the robot's readings, across it."""
        T, pair, normals = part.frames[number], part.solids[number], part.normals[number]
        x = T[:, :3, 3]
        d = self.point(x)
        for row in range(len(x)):
            t = T[row, :3, 0]
            rows, wanted = [t], [0.0]
            for name in pair if len(pair) == 2 else ():
                omega, v, centre = self.bodies.get(name, (np.zeros(3), np.zeros(3), x[row]))
                rows.append(normals[name])
                wanted.append(float(normals[name] @ (np.cross(omega, x[row] - centre) + v)))
            d[row] += np.linalg.lstsq(np.array(rows), np.array(wanted), rcond=0.15)[0]
        return d
