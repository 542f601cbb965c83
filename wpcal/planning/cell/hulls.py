"""Distances between the convex hulls of bodies: slower than capsules, and decisive for the verdict on a path.

A body with a hull is measured by its hull, a body without by its capsules. For every state, a capsule around each hull
bounds the distances of all pairs from below. The hulls are then measured in the order of these bounds, until no bound
is below the least margin found. The result is the least margin over all pairs, although few pairs are measured.

The hulls are measured by FCL (Pan, Chitta, Manocha: FCL, a general purpose library for collision and proximity queries,
2012; BSD), the optional package `python-fcl`, which is imported when the first hull is met.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.same_bits import length, product
from wpcal.planning.cell.bodies import Body, BodyPairs, body_pairs
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.clearance import Clearance, pair_margins, stacked
from wpcal.planning.cell.segments import dot
from wpcal.planning.cell.shape import Shape
from wpcal.robot.kinematics.forward import Frames
from wpcal.robot.kinematics.urdf_bodies import capsule_around

FCL_MM = 1e-4
"""Subtracted from every distance by FCL: ten times the largest error of its iteration seen for capsules (1e-5 mm)."""


def hull_clearance(cell: Cell, q: FloatArray) -> Clearance:
    """Measure n states by the hulls of bodies (capsules where a body has no hull); `q`: shape (n, 12), rad.

    Raises `GeometryError` when the corners of a hull are in one plane.
    Raises `InputError` when a body has a hull and `python-fcl` is not installed.
    """
    pairs = body_pairs(cell)
    return Clearance.of_states(cell, q, pairs, HullMeasure.of_pairs(pairs).least_margins)


@dataclass(frozen=True, slots=True, eq=False)
class HullMeasure:
    """The pairs of a cell, the same pairs with a capsule around every hull, and FCL's objects of bodies with hulls.

    `faces` tell at once of most pairs that they are apart: a flat hull is far from its capsule.
    """

    pairs: BodyPairs
    bounded: BodyPairs
    has_hull: BoolArray
    objects: dict[int, list[tuple[Any, FloatArray, FloatArray]]]
    faces: _Faces

    @classmethod
    def of_pairs(cls, pairs: BodyPairs) -> HullMeasure:
        """Make FCL's objects of the bodies of some pairs."""
        hulled = np.array([len(body.shape.hull) > 0 for body in pairs.bodies], dtype=np.bool_)
        has_hull = np.asarray(hulled[pairs.first] | hulled[pairs.second])
        met = np.unique(np.concatenate([pairs.first[has_hull], pairs.second[has_hull]]))
        objects = {int(row): fcl_objects(pairs.bodies[row].shape) for row in met}
        bounded = tuple(
            replace(body, shape=_bounded(body.shape)) if hull else body
            for body, hull in zip(pairs.bodies, hulled, strict=True)
        )
        return cls(pairs, replace(pairs, bodies=bounded), has_hull, objects, _Faces.of(bounded))

    def least_margins(self, frames: tuple[Frames, ...]) -> tuple[FloatArray, IntArray]:
        """Return the least margin of every state and the row of its pair."""
        bounds = pair_margins(self.bounded, frames)
        exact = np.where(self.has_hull[:, None], np.inf, bounds)
        row = np.argmin(exact, axis=0)
        margin = exact[row, np.arange(exact.shape[1])]
        places = [(frame.rotations(), frame.p.T) for frame in frames]
        for i in np.flatnonzero((bounds < margin).any(axis=0)).tolist():
            here = [(R[min(i, len(R) - 1)], p[min(i, len(p) - 1)]) for R, p in places]
            for k in np.argsort(bounds[:, i], kind="stable").tolist():
                if bounds[k, i] >= margin[i]:
                    break
                if self.has_hull[k]:
                    found = self._distance(k, here) - self.pairs.safety_mm[k]
                    margin[i], row[i] = min((margin[i], row[i]), (found, k))
        return margin, row

    def raise_bounds(self, bounds: FloatArray, frames: tuple[Frames, ...]) -> None:
        """Measure, in place, the hulls of pairs whose lower bound is not positive, until one of a state is too near.

        The bounds of the pairs of that state that are not measured become infinite: they name nobody.

        `bounds`: shape (m, n). `pair_margins` of `bounded`, mm.
        """
        pair, state = np.nonzero((bounds <= 0.0) & self.has_hull[:, None])
        if len(pair):
            every, safety = stacked(frames), self.pairs.safety_mm[pair]
            carriers = np.array([body.carrier for body in self.pairs.bodies])
            one, two = self.pairs.first[pair], self.pairs.second[pair]
            for hull, other in ((one, two), (two, one)):
                at = every[:, :, carriers[hull], state], every[:, :, carriers[other], state]
                bounds[pair, state] = np.maximum(bounds[pair, state], self.faces.apart(hull, other, at) - safety)
        close = (bounds <= 0.0) & self.has_hull[:, None]
        states = np.flatnonzero(close.any(axis=0)).tolist()
        places = [(frame.rotations(), frame.p.T) for frame in frames] if states else []
        for i in states:
            here = [(R[min(i, len(R) - 1)], p[min(i, len(p) - 1)]) for R, p in places]
            near = np.flatnonzero(close[:, i])
            near = near[np.argsort(bounds[near, i], kind="stable")]
            for row, k in enumerate(near.tolist(), 1):
                bounds[k, i] = self._distance(k, here) - self.pairs.safety_mm[k]
                if bounds[k, i] <= 0.0:
                    bounds[near[row:], i] = np.inf
                    break

    def _distance(self, pair: int, places: list[tuple[FloatArray, FloatArray]]) -> float:
        a, b = (self._placed(int(rows[pair]), places) for rows in (self.pairs.first, self.pairs.second))
        return min(_fcl_distance(one, other) for one in a for other in b)

    def _placed(self, body: int, places: list[tuple[FloatArray, FloatArray]]) -> list[Any]:
        Transform = import_fcl().Transform
        R, p = places[self.pairs.bodies[body].carrier]
        for shape, R_local, p_local in self.objects[body]:
            shape.setTransform(Transform(product(R, R_local), product(R, p_local) + p))
        return [shape for shape, _, _ in self.objects[body]]


@dataclass(frozen=True, slots=True, eq=False)
class _Faces:
    """Planes of hulls and capsules around bodies, in tables of equal rows: one call compares many pairs."""

    normal: FloatArray  #: shape (b, f, 3). In the frames of b bodies.
    offset_mm: FloatArray  #: shape (b, f). Minus infinity where a body has fewer planes.
    ends: FloatArray  #: shape (b, c, 2, 3). Of the axes of the capsules; the first again where a body has fewer.
    radius_mm: FloatArray  #: shape (b, c).

    @classmethod
    def of(cls, bodies: tuple[Body, ...]) -> _Faces:
        """Make the tables; of planes that are nearly parallel one is kept."""
        planes = [some_planes(body.shape) for body in bodies]
        f = max((len(each) for each in planes), default=0)
        c = max((len(body.shape.radius_mm) for body in bodies), default=0)
        normal, offset = np.zeros((len(bodies), f, 3)), np.full((len(bodies), f), -np.inf)
        ends, radius = np.zeros((len(bodies), c, 2, 3)), np.zeros((len(bodies), c))
        for row, (body, each) in enumerate(zip(bodies, planes, strict=True)):
            normal[row, : len(each)], offset[row, : len(each)] = each[:, :3], each[:, 3]
            own = np.minimum(np.arange(c), len(body.shape.radius_mm) - 1)
            ends[row], radius[row] = np.stack([body.shape.p, body.shape.q], axis=1)[own], body.shape.radius_mm[own]
        return cls(normal, offset, ends, radius)

    def apart(self, hull: IntArray, other: IntArray, at: tuple[FloatArray, FloatArray]) -> FloatArray:
        """Return lower bounds of the distances of hulls from other bodies, shape (e,), mm: beyond one of their faces.

        `at`: shapes (4, 3, e). Axes and origins of both.
        """
        own, far = at
        best = np.full(len(hull), np.inf)
        nx, ny, nz = (axis[:, hull] for axis in self.normal.transpose(2, 1, 0))  # (f, e)
        off = self.offset_mm.T[:, hull]
        for c in range(self.radius_mm.shape[1]):
            local = []
            for end in self.ends[:, c].transpose(1, 2, 0):  # (3, b)
                p = far[3] - own[3]
                for axis, part in zip(far[:3], end[:, other], strict=True):
                    p = p + axis * part
                local.append([dot(axis, p) for axis in own[:3]])
            top = (np.minimum(*(nx * x + ny * y + nz * z for x, y, z in local)) + off).max(axis=0, initial=-np.inf)
            np.minimum(best, top - self.radius_mm[other, c], out=best)
        return best


APART = 1.0  #: Of planes whose normals are in one part of a grid of this size, one is compared: 26 at most.


@lru_cache(maxsize=256)
def some_planes(shape: Shape) -> FloatArray:
    """Return planes of a hull with outward normals, shape (f, 4); none of a body without."""
    if not len(shape.hull):
        return np.zeros((0, 4))
    planes = ConvexHull(shape.hull).equations
    _, some = np.unique(np.round(planes[:, :3] / APART), axis=0, return_index=True)
    return np.asarray(planes[np.sort(some)], dtype=np.float64)


@lru_cache(maxsize=256)
def _bounded(shape: Shape) -> Shape:
    p, q, radius = capsule_around(shape.hull)
    return replace(shape, p=p, q=q, radius_mm=np.array([radius + FCL_MM]))


def _fcl_distance(first: Any, second: Any) -> float:
    fcl = import_fcl()
    return max(0.0, float(fcl.distance(first, second, fcl.DistanceRequest(), fcl.DistanceResult())) - FCL_MM)


def fcl_objects(shape: Shape) -> list[tuple[Any, FloatArray, FloatArray]]:
    """Return FCL's objects of a body, each with its rotation and origin in the body's frame.

    Raises `GeometryError` when the corners of the hull lie in a plane.
    Raises `InputError` when `python-fcl` is not installed.
    """
    fcl = import_fcl()
    if len(shape.hull):
        return [(fcl.CollisionObject(_fcl_hull(shape), fcl.Transform()), np.eye(3), np.zeros(3))]
    objects = []
    for p, q, radius in zip(shape.p, shape.q, shape.radius_mm, strict=True):
        along = length(q - p)
        geometry = fcl.Capsule(radius, along) if along > 0 else fcl.Sphere(radius)
        objects.append((fcl.CollisionObject(geometry, fcl.Transform()), _rotation_to(q - p), (p + q) / 2))
    return objects


@lru_cache(maxsize=256)
def _fcl_hull(shape: Shape) -> Any:
    """Build FCL's convex body: corners and triangles with outward normals."""
    try:
        hull = ConvexHull(shape.hull)
    except QhullError:
        raise GeometryError(f"shape {shape.name}: the corners of its hull are in one plane or too few") from None
    number = np.zeros(len(shape.hull), dtype=np.int64)
    number[hull.vertices] = np.arange(len(hull.vertices))
    a, b, c = np.moveaxis(shape.hull[hull.simplices], 1, 0)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    triangles = np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices)
    faces = np.column_stack([np.full(len(triangles), 3), number[triangles]]).ravel()
    return import_fcl().Convex(np.ascontiguousarray(shape.hull[hull.vertices]), len(triangles), faces)


def _rotation_to(direction: FloatArray) -> FloatArray:
    """Return a rotation whose z is along a direction; the identity for a zero vector."""
    size = length(direction)
    if size == 0.0:
        return np.eye(3)
    z = direction / size
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= length(x)
    return np.column_stack([x, np.cross(z, x), z])


def import_fcl() -> Any:
    """Return the module `fcl`. Raises `InputError` when `python-fcl` is not installed."""
    try:
        import fcl  # noqa: PLC0415  # an optional package, needed only where a body has a hull
    except ImportError:
        raise InputError(
            "distances of hulls need the package python-fcl: pip install 'wpcal[planning]' (or leave hulls out)"
        ) from None
    return fcl
