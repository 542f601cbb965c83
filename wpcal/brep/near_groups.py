"""Faces near groups of segments: one walk through the tree of boxes for a whole group, then only its own faces.

A group is what runs side by side: the wire along a seam, or all rays of a nozzle at neighbouring stations. Around each
group is an oriented box. A plane face that has this box on one side is not near.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.brep.boxes import are_met
from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.hits import THIN_MM, RayHits, passage, through_faces
from wpcal.brep.strips import items_of
from wpcal.brep.surfaces import square_to
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray

SAME_SIDE_MM = 1e-6  #: A box this near to a plane is not on one side of it: round-off of coordinates.
GROUP_ROWS, GROUP_RAD = 8, 0.35
"""Rows of a group: stations 10 mm apart make a box as wide as a few nozzles, which still holds few faces."""
PAIRS = 40_000  #: Pairs of a ray and a face handled in one array: some 20 MB.


def first_of_groups(owner: IntArray, way: FloatArray) -> IntArray:
    """Divide rows into groups that run side by side: of one owner, few, and turned little from the first to the last.

    `owner`: shape (n,). Ascending.
    `way`: shape (n, 3). Unit directions; a new group starts where they have turned by `GROUP_RAD`.
    Returns ndarray of int, shape (g,). The first row of each group.
    """
    start = np.flatnonzero(np.diff(owner, prepend=-1))
    number = np.arange(len(owner)) - np.repeat(start, np.diff(start, append=len(owner)))
    turn = np.cumsum(np.linalg.norm(np.diff(way, axis=0, prepend=way[:1]), axis=1))
    part = [owner, number // GROUP_ROWS, np.floor(turn / GROUP_RAD)]
    breaks = np.any([np.diff(values, prepend=-1) != 0 for values in part], axis=0)
    return np.flatnonzero(breaks)


@dataclass(frozen=True, slots=True, eq=False)
class NearFaces:
    """The faces near each of g groups, by their boxes (`TrimmedFaces.patch_boxes`)."""

    box: IntArray  #: shape (k,). The boxes of group i are ``box[start[i]:start[i + 1]]``.
    start: IntArray  #: shape (g + 1,).

    @property
    def counts(self) -> IntArray:
        """Number of boxes near each group, shape (g,)."""
        return np.diff(self.start)

    def pairs(self, group: IntArray) -> tuple[IntArray, IntArray]:
        """Return pairs of a row of `group` (shape (m,)) and a box near its group; two arrays (k,), by row."""
        row, item = items_of(self.start, group)
        return row, self.box[item]


def find_near_faces(
    trimmed: TrimmedFaces, p0: FloatArray, p1: FloatArray, first: IntArray, *, within_mm: float = 0.0
) -> NearFaces:
    """Find the faces that segments of groups may meet. A face that is not among them is met by no segment of the group.

    `p0`, `p1`: shape (m, 3). Ends of the segments in `part`, mm, sorted by group.
    `first`: shape (g,). The first segment of each group; every group has at least one.
    """
    if len(first) == 0:
        return NearFaces(np.zeros(0, dtype=np.int64), np.zeros(1, dtype=np.int64))
    boxes = _Boxes.around(p0, p1, first, within_mm)
    group, box = trimmed.patch_boxes.tree.search(len(first), boxes.meets)
    kept = ~boxes.is_beside_plane(trimmed.graph, group, trimmed.patch_boxes.face[box])
    group, box = group[kept], box[kept]
    return NearFaces(box, np.searchsorted(group, np.arange(len(first) + 1)))


@dataclass(frozen=True, slots=True, eq=False)
class _Boxes:
    """An oriented box around each group: its axes (g, 3, 3) in rows, its extent along them, and along x, y and z."""

    axes: FloatArray
    low: FloatArray
    high: FloatArray
    low_xyz: FloatArray
    high_xyz: FloatArray

    @classmethod
    def around(cls, p0: FloatArray, p1: FloatArray, first: IntArray, within_mm: float) -> _Boxes:
        counts = np.diff(first, append=len(p0))
        last = first + counts - 1
        along = _unit(np.add.reduceat(p1 - p0, first), np.array([0.0, 0.0, 1.0]))
        spread = p0[last] - p0[first]
        spread -= np.einsum("gi,gi->g", spread, along)[:, None] * along
        side = _unit(spread, np.zeros(3))
        lone = np.flatnonzero(~side.any(axis=1))
        if len(lone):
            side[lone] = square_to(along[lone])
        axes = np.stack([along, side, np.cross(along, side)], axis=1)
        frame = np.repeat(axes, counts, axis=0)
        ends = [np.einsum("mij,mj->mi", frame, p) for p in (p0, p1)]
        grow = THIN_MM + within_mm
        low = np.minimum.reduceat(np.minimum(*ends), first) - grow
        high = np.maximum.reduceat(np.maximum(*ends), first) + grow
        low_xyz = np.minimum.reduceat(np.minimum(p0, p1), first).T - grow
        high_xyz = np.maximum.reduceat(np.maximum(p0, p1), first).T + grow
        return cls(axes, low, high, np.ascontiguousarray(low_xyz), np.ascontiguousarray(high_xyz))

    def meets(self, group: IntArray, low: FloatArray, high: FloatArray) -> BoolArray:
        """Tell which groups may meet axis-parallel boxes (corners of shape (3, m)): six of the separating axes."""
        met = are_met(self.low_xyz[:, group], self.high_xyz[:, group], low, high)
        for k in range(3):
            rows = np.flatnonzero(met)
            own, axis = group[rows], self.axes[:, k].T[:, group[rows]]
            low_k, high_k = np.take(low, rows, axis=1), np.take(high, rows, axis=1)
            at, reach = (axis * (low_k + high_k)).sum(axis=0) / 2, (np.abs(axis) * (high_k - low_k)).sum(axis=0) / 2
            met[rows] = (at - reach <= self.high[own, k]) & (at + reach >= self.low[own, k])
        return met

    def is_beside_plane(self, graph: BrepGraph, group: IntArray, face: IntArray) -> BoolArray:
        """Tell which faces are planes with the whole box of the group on one side."""
        beside = np.zeros(len(face), dtype=bool)
        rows = np.flatnonzero(graph.face_kind[face] == SurfaceKind.PLANE)
        group, face = group[rows], face[rows]
        low, high = self.low[group] + THIN_MM, self.high[group] - THIN_MM
        axes, normal = self.axes[group], graph.face_frame[face, 3]
        height = np.einsum(
            "mi,mi->m", np.einsum("mji,mj->mi", axes, (low + high) / 2) - graph.face_frame[face, 0], normal
        )
        reach = np.einsum("mi,mi->m", np.abs(np.einsum("mij,mj->mi", axes, normal)), (high - low) / 2)
        beside[rows] = np.abs(height) > reach + SAME_SIDE_MM
        return beside


def _unit(v: FloatArray, otherwise: FloatArray) -> FloatArray:
    length = np.linalg.norm(v, axis=1, keepdims=True)
    return np.where(length > SAME_SIDE_MM, v / np.where(length > 0, length, 1.0), otherwise)


def find_hits_near(
    trimmed: TrimmedFaces,
    near: NearFaces,
    group: IntArray,
    origins: FloatArray,
    rays: FloatArray,
    *,
    length_mm: FloatArray,
) -> RayHits:
    """Find the places where rays go through the faces near their groups.

    `group`: shape (m,). The group of each ray.
    `origins`, `rays`: shape (m, 3). Starts (mm) and unit directions in `part`.
    `length_mm`: shape (m,). Where the rays end.
    """
    boxes, found = trimmed.patch_boxes, []
    o, d, low, high = (np.ascontiguousarray(values.T) for values in (origins, rays, boxes.low, boxes.high))
    chunk = np.cumsum(near.counts[group]) // PAIRS
    for rows in np.split(np.arange(len(group)), np.flatnonzero(np.diff(chunk)) + 1):
        row, box = near.pairs(group[rows])
        ray = rows[row]
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.take(low, box, axis=1), np.take(high, box, axis=1)
            enter, leave = passage(np.take(o, ray, axis=1), np.take(d, ray, axis=1), length_mm[ray], *ends)
        met = np.flatnonzero(leave > enter)
        ray, face, enter, leave = _joined(ray[met], boxes.face[box[met]], enter[met], leave[met])
        pair, at, way = through_faces(trimmed, face, origins[ray], rays[ray], length_mm[ray], (enter, leave))
        found.append(RayHits(ray[pair], face[pair], at, way))
    return RayHits.joined(found).in_order()


def _joined(
    ray: IntArray, face: IntArray, enter: FloatArray, leave: FloatArray
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Join intervals of one ray and one face that overlap, so that no crossing is found twice."""
    if ((np.diff(ray) > 0) | ((np.diff(ray) == 0) & (np.diff(face) > 0))).all():
        return ray, face, enter, leave
    order = np.lexsort((enter, face, ray))
    ray, face, enter, leave = ray[order], face[order], enter[order], leave[order]
    number = np.cumsum(np.append(False, (np.diff(ray) != 0) | (np.diff(face) != 0)))
    base = number * (2.0 * float(leave.max()) + 1.0)
    until = np.maximum.accumulate(base + leave)
    first = np.flatnonzero(np.append(True, base[1:] + enter[1:] > until[:-1]))
    return ray[first], face[first], enter[first], np.maximum.reduceat(leave, first)


@dataclass(frozen=True, slots=True, eq=False)
class NearBundles(Columns):
    """Which faces bundles of rays may meet: neighbours of one owner are searched together."""

    near: NearFaces
    group: IntArray  #: shape (n,). The group of each bundle.

    @classmethod
    def around(
        cls, trimmed: TrimmedFaces, owner: IntArray, p0: FloatArray, p1: FloatArray, *, within_mm: float = 0.0
    ) -> NearBundles:
        """Find the faces within a distance of the segments of n bundles.

        `owner`: shape (n,). What the bundles belong to, ascending.
        `p0`, `p1`: shape (n, k, 3). Ends of k segments of each bundle in `part`, mm. The first ones divide the groups.
        """
        n, k = p0.shape[:2]
        way = p1[:, 0] - p0[:, 0]
        first = first_of_groups(owner, way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), SAME_SIDE_MM))
        p0, p1 = p0.reshape(-1, 3), p1.reshape(-1, 3)
        near = find_near_faces(trimmed, p0, p1, k * first, within_mm=within_mm)
        return cls(near, np.repeat(np.arange(len(first)), np.diff(first, append=n)))

    def first_faces(
        self, trimmed: TrimmedFaces, origins: FloatArray, rays: FloatArray, length_mm: FloatArray
    ) -> IntArray:
        """Return the face that each bundle of rays meets first, or -1, shape (n,).

        `origins`, `rays`: shape (n, k, 3). Starts (mm) and unit directions in `part`.
        `length_mm`: shape (n, k). Where the rays end.
        """
        k = origins.shape[1]
        found = np.full(len(origins), -1)
        rows = np.flatnonzero(self.near.counts[self.group])
        if not len(rows):
            return found
        p, way, length = origins[rows].reshape(-1, 3), rays[rows].reshape(-1, 3), length_mm[rows].ravel()
        hits = find_hits_near(trimmed, self.near, np.repeat(self.group[rows], k), p, way, length_mm=length)
        order = np.argsort(-hits.at_mm, kind="stable")  # the nearest of each bundle is written last
        found[rows[hits.ray[order] // k]] = hits.face[order]
        return found
