"""A part as triangles, and how far a piece of wire is from it. None of this comes from wpcal.

Faces are cut into triangles no further than `DEFLECTION_MM` from them, so plane faces are exact.
"""

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
DEFLECTION_MM = 2e-4  #: Of curved faces: below the last digit that any controller stores.
ANGLE_RAD = 0.3  #: Of neighbouring triangles; small rounds need no more.
NEAR_MM = 8.0  #: Faces that are further from a whole move than this are not looked at on it.
TINY = 1e-30  #: Keeps divisions by the squared length of an edge without length finite: its ends are measured anyway.


def triangles_of(step: Path) -> Array:
    """Return the triangles of a STEP file in its own coordinates, shape (n, 3, 3), mm."""
    return np.concatenate(triangles_of_solids(step))


@lru_cache(maxsize=8)
def triangles_of_solids(step: Path) -> tuple[Array, ...]:
    """Return the triangles of each solid of a STEP file, in their order in the file."""
    from build123d import import_step
    from OCP.BRepMesh import BRepMesh_IncrementalMesh

    shape = import_step(str(step))
    BRepMesh_IncrementalMesh(shape.wrapped, DEFLECTION_MM, False, ANGLE_RAD, False)
    return tuple(np.concatenate([_triangles(face) for face in solid.faces()]) for solid in shape.solids())


def _triangles(face: Any) -> Array:
    from OCP.BRep import BRep_Tool
    from OCP.TopLoc import TopLoc_Location

    place = TopLoc_Location()
    mesh = BRep_Tool.Triangulation_s(face.wrapped, place)
    if mesh is None:
        return np.empty((0, 3, 3))
    moved = place.Transformation()
    nodes = np.array(
        [(p.X(), p.Y(), p.Z()) for p in (mesh.Node(i).Transformed(moved) for i in range(1, mesh.NbNodes() + 1))]
    )
    corners = np.array([mesh.Triangle(i).Get() for i in range(1, mesh.NbTriangles() + 1)]) - 1
    return np.asarray(nodes[corners])


class Solid:
    """A part at its true place: triangles in the base."""

    def __init__(self, triangles: Array, T_base_part: Array) -> None:
        self.triangles = triangles @ T_base_part[:3, :3].T + T_base_part[:3, 3]
        self.low, self.high = self.triangles.min(axis=1), self.triangles.max(axis=1)
        self.lowest, self.highest = self.low.min(axis=0), self.high.max(axis=0)

    def beyond(self, low: Array, high: Array) -> float:
        """Return how far a box is from the box of the whole part."""
        apart = np.maximum(0.0, np.maximum(self.lowest - high, low - self.highest))
        return float(np.linalg.norm(apart))

    def near(self, low: Array, high: Array) -> Array:
        """Return the triangles whose boxes come within `NEAR_MM` of a box."""
        is_near = np.all((self.low < high + NEAR_MM) & (self.high > low - NEAR_MM), axis=1)
        return self.triangles[is_near]


def distance(near: Array, a: Array, b: Array) -> float:
    """Return the distance of the segment from `a` to `b` from triangles; infinite if there are none."""
    if len(near) == 0:
        return np.inf
    corners = [near[:, i] for i in range(3)]
    edges = [(corners[i], corners[(i + 1) % 3]) for i in range(3)]
    least = min(_points_to_triangles(a, near), _points_to_triangles(b, near))
    for start, end in edges:
        least = min(least, _segment_to_segments(a, b, start, end))
    return 0.0 if _pierces(a, b, near) else float(least)


def _points_to_triangles(p: Array, near: Array) -> float:
    """Return the least distance of a point from the insides of triangles; their edges are measured elsewhere."""
    origin, u, v = near[:, 0], near[:, 1] - near[:, 0], near[:, 2] - near[:, 0]
    normal = np.cross(u, v)
    size = np.einsum("ij,ij->i", normal, normal)
    w = p - origin
    s = np.einsum("ij,ij->i", np.cross(w, v), normal) / (size + TINY)
    t = np.einsum("ij,ij->i", np.cross(u, w), normal) / (size + TINY)
    inside = (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0) & (size > TINY)
    if not inside.any():
        return np.inf
    heights = np.abs(np.einsum("ij,ij->i", w, normal)[inside]) / np.sqrt(size[inside])
    return float(heights.min())


def _segment_to_segments(a: Array, b: Array, starts: Array, ends: Array) -> float:
    """Return the least distance of one segment from many (Ericson, Real-Time Collision Detection, 5.1.9)."""
    d1, d2, r = b - a, ends - starts, a - starts
    aa, ee = float(d1 @ d1), np.einsum("ij,ij->i", d2, d2)
    f, c, bb = np.einsum("ij,ij->i", d2, r), r @ d1, d2 @ d1
    denominator = aa * ee - bb * bb
    s = np.clip(np.where(denominator > TINY, (bb * f - c * ee) / (denominator + TINY), 0.0), 0.0, 1.0)
    t = (bb * s + f) / (ee + TINY)
    clipped = np.clip(t, 0.0, 1.0)
    s = np.where(t == clipped, s, np.clip((bb * clipped - c) / (aa + TINY), 0.0, 1.0))
    gaps = r + s[:, None] * d1 - clipped[:, None] * d2
    return float(np.sqrt(np.einsum("ij,ij->i", gaps, gaps).min()))


def _pierces(a: Array, b: Array, near: Array) -> bool:
    """Say whether the segment goes through the inside of a triangle."""
    origin, u, v = near[:, 0], near[:, 1] - near[:, 0], near[:, 2] - near[:, 0]
    normal = np.cross(u, v)
    size = np.einsum("ij,ij->i", normal, normal)
    ha = np.einsum("ij,ij->i", a - origin, normal)
    hb = np.einsum("ij,ij->i", b - origin, normal)
    across = (ha * hb < 0.0) & (size > TINY)
    if not across.any():
        return False
    origin, u, v, normal, size = origin[across], u[across], v[across], normal[across], size[across]
    share = ha[across] / (ha[across] - hb[across])
    w = a + share[:, None] * (b - a) - origin
    s = np.einsum("ij,ij->i", np.cross(w, v), normal) / size
    t = np.einsum("ij,ij->i", np.cross(u, w), normal) / size
    return bool(np.any((s >= 0.0) & (t >= 0.0) & (s + t <= 1.0)))
