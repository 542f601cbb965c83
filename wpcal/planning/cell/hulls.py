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
from wpcal.planning.cell.bodies import Body, BodyPairs, Owner, body_pairs
from wpcal.planning.cell.cell import Cell, CellState
from wpcal.planning.cell.clearance import Clearance, pair_margins
from wpcal.planning.cell.shape import Shape
from wpcal.robot.kinematics.forward import Frames
from wpcal.robot.kinematics.urdf_bodies import capsule_around

PLANE_DIGITS = 9
"""Planes of triangles of one face are equal to this many decimals (mm for what is off by a kilometre)."""
FCL_MM = 1e-4
"""Subtracted from every distance by FCL: ten times the largest error of its iteration seen for capsules (1e-5 mm)."""


def hull_clearance(cell: Cell, state: CellState) -> Clearance:
    """Measure n states by the hulls of bodies (capsules where a body has no hull).

    Raises `GeometryError` when the corners of a hull are in one plane.
    Raises `InputError` when a body has a hull and `python-fcl` is not installed.
    """
    pairs = body_pairs(cell)
    return Clearance.of_states(cell, state, pairs, HullMeasure.of_pairs(pairs).least_margins)


@dataclass(frozen=True, slots=True, eq=False)
class HullMeasure:
    """The pairs of a cell, the same pairs with a capsule around every hull, and FCL's objects of bodies with hulls.

    `walls` has the planes of the second body of a pair if it is a hull in `world`: a flat one is far from its capsule.
    """

    pairs: BodyPairs
    bounded: BodyPairs
    has_hull: BoolArray
    objects: dict[int, list[tuple[Any, FloatArray, FloatArray]]]
    walls: dict[int, FloatArray]

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
        return cls(pairs, replace(pairs, bodies=bounded), has_hull, objects, _walls(pairs, bounded))

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
        for k, planes in self.walls.items():
            rows = np.flatnonzero(bounds[k] <= 0.0)
            if len(rows):
                shape = self.bounded.bodies[self.pairs.first[k]].shape
                frame = frames[self.pairs.bodies[self.pairs.first[k]].carrier].at(rows)
                off = np.minimum(*(product(planes[:, :3], frame.point(end)) for end in (shape.p[0], shape.q[0]))).T
                out = (off + planes[:, 3]).max(axis=1) - shape.radius_mm[0] - self.pairs.safety_mm[k]
                bounds[k, rows] = np.maximum(bounds[k, rows], out)
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
        objects = self.objects[body]
        if self.pairs.bodies[body].shape.hull.size:  # given in the frame of the body
            objects[0][0].setTransform(Transform(R, p))
            return [objects[0][0]]
        for shape, R_local, p_local in objects:
            shape.setTransform(Transform(product(R, R_local), product(R, p_local) + p))
        return [shape for shape, _, _ in objects]


def _walls(pairs: BodyPairs, bounded: tuple[Body, ...]) -> dict[int, FloatArray]:
    """Return the planes of the second body of each pair where it is a hull of the bench, and the first one capsule."""
    planes = {
        row: np.unique(np.round(ConvexHull(body.shape.hull).equations, PLANE_DIGITS), axis=0)
        for row, body in enumerate(pairs.bodies)
        if body.owner is Owner.BENCH and len(body.shape.hull)
    }
    return {
        k: planes[int(second)]
        for k, (first, second) in enumerate(zip(pairs.first, pairs.second, strict=True))
        if int(second) in planes and len(bounded[first].shape.radius_mm) == 1
    }


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
        return [(convex_hull_object(shape), np.eye(3), np.zeros(3))]
    objects = []
    for p, q, radius in zip(shape.p, shape.q, shape.radius_mm, strict=True):
        along = length(q - p)
        geometry = fcl.Capsule(radius, along) if along > 0 else fcl.Sphere(radius)
        objects.append((fcl.CollisionObject(geometry, fcl.Transform()), _rotation_to(q - p), (p + q) / 2))
    return objects


def convex_hull_object(shape: Shape) -> Any:
    """Return FCL's object of the hull of a body.

    Raises `GeometryError` when the corners of the hull lie in a plane.
    Raises `InputError` when `python-fcl` is not installed.
    """
    fcl = import_fcl()
    return fcl.CollisionObject(_fcl_hull(shape), fcl.Transform())


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
    """Return the module `fcl`.

    Raises `InputError` when `python-fcl` is not installed.
    """
    try:
        import fcl  # noqa: PLC0415  # an optional package, needed only where a body has a hull
    except ImportError:
        raise InputError(
            "distances of hulls need the package python-fcl: pip install 'wpcal[planning]' (or leave hulls out)"
        ) from None
    return fcl
