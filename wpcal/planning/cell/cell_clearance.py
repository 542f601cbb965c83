"""Distances between the bodies of a cell, with the part as its own triangles.

All pairs are first bounded from below: bodies by capsules around their hulls, the part by a grid
(`distance_field.DistanceField`). Only where a bound is not enough is the pair measured: hulls by FCL, capsules against
triangles exactly. The margin that results is a lower bound of the true one, and it is positive only where all is clear.

Beyond the pairs of `bodies`, the part is compared with links 1 to 6 and the torch; a part on a positioner also with the
base, the bench and the frame of the positioner. The floor is compared with the links 2 to 6, the torch, and a part on a
positioner. A part in the hand of robot 2 is compared with robot 1, the bench and links 0 to 3 of robot 2.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from wpcal.brep.material import TriangleMaterial
from wpcal.core.arrays import BoolArray, FloatArray, IntArray, blocks
from wpcal.core.same_bits import inverse_pose, product
from wpcal.planning.cell.bodies import JOINTS_BETWEEN, Body, Owner, body_pairs
from wpcal.planning.cell.cell import TOOL, WORLD, Cell
from wpcal.planning.cell.clearance import pair_margins, stacked
from wpcal.planning.cell.distance_field import DistanceField
from wpcal.planning.cell.hulls import HullMeasure, fcl_objects, import_fcl, some_planes
from wpcal.planning.cell.segments import part_distances
from wpcal.planning.cell.shape import JOINTS, corners_of_box
from wpcal.robot.kinematics.forward import Frames


@dataclass(frozen=True, slots=True, eq=False)
class PartCapsules:
    """The capsules that are compared with the part: their bodies, carriers, ends, radii and safety distances."""

    body: IntArray
    carriers: IntArray
    p: FloatArray
    q: FloatArray
    radius_mm: FloatArray
    needed_mm: FloatArray
    has_hull: BoolArray

    @classmethod
    def of(cls, cell: Cell, bodies: tuple[Body, ...]) -> PartCapsules:
        """Return the capsules of those of some bodies that can meet the part."""
        rows = [row for row, body in enumerate(bodies) if _meets_part(body, cell)]
        shapes = [bodies[row].shape for row in rows]
        count = [len(shape.radius_mm) for shape in shapes]
        needed = [
            cell.d1_mm if bodies[row].carrier != TOOL or shape.to_part_mm is None else shape.to_part_mm
            for row, shape in zip(rows, shapes, strict=True)
        ]
        body = np.repeat(np.array(rows, dtype=np.int64), count)
        p, q = (np.concatenate([np.zeros((0, 3)), *(getattr(shape, end) for shape in shapes)]) for end in ("p", "q"))
        radius = np.concatenate([np.zeros(0), *(shape.radius_mm for shape in shapes)])
        carriers = np.array([bodies[row].carrier for row in body], dtype=np.int64)
        hulled = np.repeat(np.array([len(shape.hull) > 0 for shape in shapes], dtype=bool), count)
        return cls(body, carriers, p, q, radius, np.repeat(np.array(needed, dtype=np.float64), count), hulled)

    def in_part(self, frames: tuple[Frames, ...], part_row: int) -> tuple[FloatArray, FloatArray]:
        """Return the ends of the axes in the frame of the part at n states, shapes (n, c, 3), mm."""
        n = max(frame.p.shape[1] for frame in frames)
        part = frames[part_row]
        R = np.broadcast_to(part.rotations(), (n, 3, 3))
        origin = np.broadcast_to(part.p, (3, n))
        ends = np.empty((2, n, len(self.body), 3))
        for carrier in sorted(set(self.carriers.tolist())):
            columns = np.flatnonzero(self.carriers == carrier)
            local = np.stack([self.p[columns], self.q[columns]])  # (2, c, 3)
            frame = frames[carrier]
            axes = np.stack([frame.x, frame.y, frame.z])  # (3, 3, n or 1)
            world = np.einsum("kxn,eck->encx", axes, local) + frame.p.T[:, None]
            ends[:, :, columns] = np.einsum("nji,encj->enci", R, world - origin.T[:, None])
        return ends[0], ends[1]


def _meets_part(body: Body, cell: Cell) -> bool:
    if body.owner.has_torch:
        return body.link > 0 or cell.carrier is not None
    if body.owner is Owner.ROBOT2:
        return body.link <= JOINTS + 1 - JOINTS_BETWEEN
    turns = cell.carrier is not None and len(cell.carrier.arm.joints) > 1
    return turns and body.link == 0


def tool_capsules(cell: Cell) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the torch's capsules: ends in `tool` (c, 3) twice, radii (c,) and distances from the part (c,), mm.

    Without those around hulls: such a capsule is only a bound, and the hull itself is measured at the end.
    """
    bodies = tuple(Body(shape, Owner.ROBOT, JOINTS + 1, TOOL) for shape in cell.torch if not len(shape.hull))
    found = PartCapsules.of(cell, bodies)
    return found.p, found.q, found.radius_mm, found.needed_mm


ROWS = 512  #: States per batch: arrays of all places on all capsules stay at some MB.
MOST_KNOWN = 100_000  #: States whose margins are kept: some 40 MB.
ENOUGH_MM = 5.0
"""A capsule that the grid calls too near is measured exactly up to this margin; beyond it, it is far enough."""
MOST_OUTLINE = 60
"""Corners of the part's convex hull; with more of them those of its box are compared with the faces of hulls."""
SPACING_MM = 20.0  #: Places on the axis of a capsule that are looked up in the grid are at most this far apart ...
LEAST_PLACES = 3  #: ... and at least this many.
PART, FLOOR = "part", "floor"
NOTHING: tuple[FloatArray, IntArray] = (np.zeros((0, 1)), np.zeros(0, dtype=np.int64))  #: Margins of no pairs.


@dataclass(frozen=True, slots=True, eq=False)
class Margins:
    """Lower bounds of margins (distance minus safety distance) of n states."""

    margin_mm: FloatArray  #: shape (n,). The least over all pairs; infinite if there are none.
    pair: IntArray  #: shape (n,). Number of the pair with the least margin, for `CellClearance.names`.
    by_carriers_mm: FloatArray  #: shape (n, c). The least over the pairs of each row of `CellClearance.carriers`.

    @property
    def is_clear(self) -> BoolArray:
        """Whether every pair keeps its safety distance, shape (n,)."""
        return np.asarray(self.margin_mm > 0.0)


class CellClearance:
    """Measures a cell with its part. Grids and hulls are made once."""

    def __init__(self, cell: Cell, part: TriangleMaterial | None, *, like: CellClearance | None = None) -> None:
        """Make the measures; what depends on the part alone is taken from one with the same part (`like`)."""
        self.cell, self.part = cell, part
        self.pairs = body_pairs(cell)
        self._measure = HullMeasure.of_pairs(self.pairs) if len(self.pairs) else None
        self._bodies = self.pairs.bodies
        self._capsules = PartCapsules.of(cell, self._bodies) if part is not None else None
        own = [body.owner is Owner.ROBOT and body.link > 1 for body in self._bodies]
        self._floor = np.flatnonzero(own).tolist()
        shapes = [self._bodies[row].shape for row in self._floor]
        count = [2 * len(shape.p) for shape in shapes]
        self._floor_ends = (
            np.concatenate([np.zeros((0, 3)), *(end for shape in shapes for end in (shape.p, shape.q))]),
            np.repeat(np.array([self._bodies[row].carrier for row in self._floor], dtype=np.int64), count),
            np.cumsum([0, *count])[:-1],
            np.array([shape.radius_mm.max() for shape in shapes]).reshape(-1, 1),
        )
        if like is None:
            self._field = None if part is None else DistanceField.of_triangles(part.corners)
            self._outline = np.zeros((0, 3)) if part is None else _outline(part)
        else:
            self._field, self._outline = like._field, like._outline
        self._known: dict[bytes, FloatArray] = {}  # of states, as bytes: margin, pair and least by carriers
        self._mesh: list[Any] = [] if like is None else like._mesh
        #: shape (c, 2). The pairs of frames (rows of `Cell.frames`) that carry bodies which are compared, each once.
        #: shape (c,). Least safety distance of the bodies of each of these, mm.
        self.carriers, self._row_of_pair, self.least_safety_mm = self._carriers()

    def _carriers(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Return the pairs of carriers, the row of each number of a pair in them, and their least safety distances."""
        own = np.array([body.carrier for body in self._bodies], dtype=np.int64)
        part, floor = self.cell.part_row, WORLD
        with_part = np.column_stack([own, np.full(len(own), part)])
        with_floor = np.column_stack([np.append(own, part), np.full(len(own) + 1, floor)])
        every = np.concatenate([own[np.column_stack([self.pairs.first, self.pairs.second])], with_part, with_floor])
        safety = np.full(len(every), self.cell.d1_mm)
        if self._capsules is not None:
            safety[len(self.pairs) + self._capsules.body] = self._capsules.needed_mm
        carriers, row = np.unique(every, axis=0, return_inverse=True)
        least = np.full(len(carriers), np.inf)
        np.minimum.at(least, row.ravel(), safety)
        return carriers, row.ravel(), least

    def standing_as(self, cell: Cell) -> CellClearance:
        """Return the same measures in a cell whose bodies stand elsewhere and are the same; no grid is made again."""
        other = copy(self)
        other.cell, other._known = cell, {}
        return other

    def names(self, pair: int) -> tuple[str, str]:
        """Return the names of the two bodies of a pair."""
        m, n = len(self.pairs), len(self._bodies)
        if pair < m:
            return self.pairs.names(pair)
        ours = [*(body.name for body in self._bodies), PART]
        return (ours[pair - m], PART) if pair < m + n else (ours[pair - m - n], FLOOR)

    def margins(self, q: FloatArray, *, moved: tuple[slice, FloatArray] | None = None) -> Margins:
        """Return lower bounds of the margins of n states; a search comes back to many, which are measured once.

        `q`: shape (n, k). All axes, rad and mm.
        `moved`: Rows of `Cell.frames` that stand elsewhere, and by how much in `world` at each state, (n, 3), mm.
        """
        if moved is not None:
            return self._measured(q, moved)
        if len(self._known) > MOST_KNOWN:
            self._known.clear()
        keys = [row.tobytes() for row in np.ascontiguousarray(q, dtype=np.float64)]
        new = [row for row, key in enumerate(keys) if key not in self._known]
        if new:
            found = self._measured(q[new], None)
            rows = np.column_stack([found.margin_mm, found.pair, found.by_carriers_mm])
            self._known.update(zip([keys[row] for row in new], rows, strict=True))
        every = np.reshape([self._known[key] for key in keys], (len(keys), 2 + len(self.carriers)))
        return Margins(every[:, 0], every[:, 1].astype(np.int64), every[:, 2:])

    def _measured(self, q: FloatArray, moved: tuple[slice, FloatArray] | None) -> Margins:
        least, pair = np.full(len(q), np.inf), np.full(len(q), -1, dtype=np.int64)
        by_carriers = np.full((len(self.carriers), len(q)), np.inf)
        for some in blocks(len(q), ROWS):
            frames = self.cell.frames(q[some])
            if moved is not None:
                first, last, _ = moved[0].indices(len(frames))
                shifted = (frame.shifted(moved[1][some].T) for frame in frames[first:last])
                frames = (*frames[:first], *shifted, *frames[last:])
            for measure in (self._pairs_margins, self._floor_margins, self._part_margins):
                found, numbers = measure(frames, least[some])
                if not len(numbers):
                    continue
                best = np.argmin(found, axis=0)
                rows = np.broadcast_to(np.take_along_axis(found, best[None], axis=0)[0], least[some].shape)
                better = rows < least[some]
                least[some] = np.where(better, rows, least[some])
                pair[some] = np.where(better, numbers[best], pair[some])
                own = self._row_of_pair[numbers]
                order = np.argsort(own, kind="stable")
                starts = np.flatnonzero(np.diff(own[order], prepend=-1))
                which = own[order[starts]]
                near = np.minimum.reduceat(found[order], starts, axis=0)
                by_carriers[which, some] = np.minimum(by_carriers[which, some], near)
        return Margins(least, pair, by_carriers.T)

    def _pairs_margins(self, frames: tuple[Frames, ...], _known: FloatArray) -> tuple[FloatArray, IntArray]:
        if self._measure is None:
            return NOTHING
        bounds = pair_margins(self._measure.bounded, frames)
        self._measure.raise_bounds(bounds, frames)
        return bounds, np.arange(len(bounds))

    def _part_margins(self, frames: tuple[Frames, ...], known: FloatArray) -> tuple[FloatArray, IntArray]:
        if self.part is None or self._capsules is None or not len(self._capsules.body):
            return NOTHING
        capsules = self._capsules
        p, q = capsules.in_part(frames, self.cell.part_row)
        margin = self._grid_margins(p, q, capsules.radius_mm, capsules.needed_mm)
        open_rows = np.broadcast_to(known > 0.0, len(margin)).copy()  # a state in collision anyway needs no more
        unknown = margin <= 0.0
        near = unknown & open_rows[:, None]
        unknown &= ~near
        self._measure_capsules(
            margin, np.argwhere(near & ~capsules.has_hull), p, q, capsules.radius_mm + capsules.needed_mm
        )
        open_rows &= ~((margin <= 0.0) & ~capsules.has_hull).any(axis=1)
        for column in np.flatnonzero((near & capsules.has_hull).any(axis=0)).tolist():
            rows = np.flatnonzero(near[:, column] & open_rows)
            unknown[:, column] |= near[:, column] & ~open_rows
            if not len(rows):
                continue
            margin[rows, column] = self._hull_margins(column, frames, rows)
            open_rows[rows] = margin[rows, column] > 0.0
        margin[unknown] = np.inf  # of a state where others are too near: a bound that names nobody
        return margin.T, len(self.pairs) + capsules.body

    def are_clear(self, p: FloatArray, q: FloatArray, radius: FloatArray, needed: FloatArray) -> BoolArray:
        """Tell at which of n states all of some capsules keep their distances from the part, shape (n,).

        `p`, `q`: shape (n, c, 3). Ends of the axes in the frame of the part, mm.
        `radius`, `needed`: shape (c,). Radii and safety distances, mm.
        """
        if self.part is None:
            return np.ones(len(p), dtype=bool)
        near = self._grid_margins(p, q, radius, needed) <= 0.0
        clear, out = np.ones(len(near), dtype=bool), radius + needed + self.part.deflection_mm
        for column in range(len(radius)):
            rows = np.flatnonzero(near[:, column] & clear)
            if len(rows):
                within = np.full(len(rows), out[column])
                clear[rows] = np.isinf(part_distances(self.part, p[rows, column], q[rows, column], within)[0])
        return clear

    def _grid_margins(self, p: FloatArray, q: FloatArray, radius: FloatArray, needed: FloatArray) -> FloatArray:
        """Return lower bounds of the margins of capsules from the part by the grid alone, shape (n, c), mm."""
        assert self._field is not None
        if not p.size:
            return np.full(p.shape[:2], np.inf)
        length = np.linalg.norm(q[0] - p[0], axis=1)
        count = np.where(length > 0.0, np.maximum(LEAST_PLACES, np.ceil(length / SPACING_MM).astype(int) + 1), 1)
        starts = np.concatenate([[0], np.cumsum(count)[:-1]])
        own = np.repeat(np.arange(len(count)), count)
        share = (np.arange(len(own)) - starts[own]) / np.maximum(count[own] - 1, 1)
        places = p[:, own] + share[:, None] * (q - p)[:, own]
        found = np.minimum.reduceat(self._field.least(places.reshape(-1, 3)).reshape(len(p), -1), starts, axis=1)
        margin = found - length / np.maximum(count - 1, 1) / 2 - radius - needed
        return np.asarray(margin, dtype=np.float64)

    def _measure_capsules(
        self, margin: FloatArray, which: IntArray, p: FloatArray, q: FloatArray, off_mm: FloatArray
    ) -> None:
        """Measure, in place, some capsules (state, column) against the triangles; `off_mm`: radii and distances."""
        assert self.part is not None
        if len(which):
            rows, columns = which.T
            out = off_mm[columns] + self.part.deflection_mm
            exact, _ = part_distances(self.part, p[rows, columns], q[rows, columns], out + ENOUGH_MM)
            margin[rows, columns] = np.minimum(exact - out, ENOUGH_MM)

    def _hull_margins(self, column: int, frames: tuple[Frames, ...], rows: IntArray) -> FloatArray:
        """Return the margins of the hull of one body from the part at some states, shape (len(rows),), mm."""
        assert self._capsules is not None
        assert self.part is not None
        fcl, body = import_fcl(), self._bodies[int(self._capsules.body[column])]
        ((hull, _, _),) = fcl_objects(body.shape)
        if not self._mesh:
            self._mesh.append(_mesh_object(self.part))
        T = product(
            inverse_pose(frames[self.cell.part_row].at(rows).matrices()), frames[body.carrier].at(rows).matrices()
        )
        needed = float(self._capsules.needed_mm[column]) + self.part.deflection_mm
        T = np.broadcast_to(T, (len(rows), 4, 4))
        margin = beyond_a_face(some_planes(body.shape), self._outline, T) - needed
        for row in np.flatnonzero(margin <= 0.0).tolist():
            place = T[row]
            hull.setTransform(fcl.Transform(place[:3, :3], place[:3, 3]))
            found = fcl.distance(hull, self._mesh[0], fcl.DistanceRequest(), fcl.DistanceResult())
            margin[row] = max(found, 0.0) - needed
        return np.asarray(margin, dtype=np.float64)

    def _floor_margins(self, frames: tuple[Frames, ...], _known: FloatArray) -> tuple[FloatArray, IntArray]:
        first = len(self.pairs) + len(self._bodies)
        level = self.cell.floor_z_mm + self.cell.d1_mm
        found, which = [], [first + row for row in self._floor]
        if self._floor:
            ends, carrier, starts, radius = self._floor_ends
            x, y, z, p = stacked(frames)[:, 2, carrier]
            at_ends = x * ends[:, :1] + y * ends[:, 1:2] + z * ends[:, 2:] + p
            found = list(np.minimum.reduceat(at_ends, starts, axis=0) - radius)
        for row, height in zip(self._floor, found, strict=True):
            shape, frame = self._bodies[row].shape, frames[self._bodies[row].carrier]
            low = np.flatnonzero(height <= level) if len(shape.hull) else np.zeros(0, dtype=np.int64)
            if len(low):  # the capsules are around the hull
                height[low] = _lowest(frame.at(low), shape.hull)
        if self.part is not None and self.cell.carrier is not None and not self.cell.has_two_robots:
            found.append(_lowest(frames[self.cell.part_row], _corners(self.part)))
            which.append(first + len(self._bodies))
        if not found:
            return NOTHING
        return np.stack(np.broadcast_arrays(*found)) - level, np.array(which)


def beyond_a_face(planes: FloatArray, outline: FloatArray, T: FloatArray) -> FloatArray:
    """Return lower bounds of the distances of points from a hull: all are beyond one of its faces by this, else 0.

    `planes`: shape (f, 4). Of faces of the hull.
    `outline`: shape (m, 3). Points in the frame of the surface, mm; the bound holds for their convex hull.
    `T`: shape (n, 4, 4). ``T_surface_body``, mm.
    Returns ndarray, shape (n,). mm.
    """
    normal = np.einsum("nij,fj->nfi", T[:, :3, :3], planes[:, :3])  # in the frame of the surface
    off = planes[:, 3] - np.einsum("nfi,ni->nf", normal, T[:, :3, 3])
    out = np.einsum("nfi,mi->mnf", normal, outline).min(axis=0) + off
    return np.asarray(np.maximum(out.max(axis=1), 0.0), dtype=np.float64)


def _corners(part: TriangleMaterial) -> FloatArray:
    """Return the corners of the part's box, shape (8, 3), mm."""
    return corners_of_box(part.corners.min(axis=(0, 1)), part.corners.max(axis=(0, 1)))


def _outline(part: TriangleMaterial) -> FloatArray:
    """Return the corners of the part's convex hull, shape (m, 3), mm; those of its box if it is flat or intricate."""
    points = part.corners.reshape(-1, 3)
    try:
        found = points[ConvexHull(points).vertices]
    except QhullError:
        return _corners(part)
    return np.asarray(found, dtype=np.float64) if len(found) <= MOST_OUTLINE else _corners(part)


def _lowest(frame: Frames, points: FloatArray) -> FloatArray:
    """Return the height of the lowest of m points in n frames, shape (n,), mm."""
    x, y, z = (axis[2][:, None] for axis in (frame.x, frame.y, frame.z))
    heights = x * points[:, 0] + y * points[:, 1] + z * points[:, 2]
    return np.asarray(heights.min(axis=1) + frame.p[2], dtype=np.float64)


def _mesh_object(part: TriangleMaterial) -> Any:
    """Return FCL's object of the part's triangles."""
    fcl = import_fcl()
    mesh = fcl.BVHModel()
    points = np.ascontiguousarray(part.corners.reshape(-1, 3))
    mesh.beginModel(len(points), len(part.corners))
    mesh.addSubModel(points, np.arange(len(points)).reshape(-1, 3))
    mesh.endModel()
    return fcl.CollisionObject(mesh, fcl.Transform())
