"""What is inside the material of a part's solids, from its exact faces or from its triangles.

A point is inside a solid if a ray from it leaves the solid once more often than it enters it. A ray through an edge or
along a face may count wrong, so three rays in general directions vote.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from wpcal.brep.boxes import BoxTree
from wpcal.brep.graph import BrepGraph
from wpcal.brep.hits import CHUNK, RayHits, boxes_met, find_hits
from wpcal.brep.mesh import PartMesh
from wpcal.brep.trim import TrimmedFaces
from wpcal.brep.tubes import Radius, tube_lines, tube_triangles
from wpcal.core.arrays import FloatArray, IntArray, blocks
from wpcal.core.transform import RigidTransform

VOTERS = np.array([[0.8301, 0.2713, 0.4871], [-0.3119, 0.8923, 0.3263], [0.1987, -0.4409, 0.8753]])
"""Directions of the rays that vote: along no axis, plane or diagonal in which parts are modelled."""
FAR_MM = 1e9  #: Length of a ray that leaves every part.
BEYOND_MM = 1.0  #: Rays end this far beyond the boxes that they leave.
FLAT = 1e-12  #: A ray whose direction has less than this share across a triangle runs along it.


@dataclass(frozen=True, slots=True, eq=False)
class SolidHits:
    """Places where rays enter or leave solids, sorted by ray, then by distance."""

    #: `ray`, `solid`: shape (k,).
    ray: IntArray
    solid: IntArray
    at_mm: FloatArray  #: shape (k,). Distance from the start of the ray.
    way: IntArray  #: shape (k,). +1 where the ray leaves the solid, -1 where it enters it.


class Material(Protocol):
    """The solids of a part, which rays can be sent through."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the solids."""

    @property
    def boxes(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest corners of a box around each solid, two arrays (s, 3), mm."""

    def hits(self, origins: FloatArray, rays: FloatArray, length_mm: FloatArray | float) -> SolidHits:
        """Find where rays enter and leave solids.

        `origins`, `rays`: shape (m, 3). Starts (mm) and unit directions in `part`.
        `length_mm`: shape (m,). Where the rays end.
        """

    def tube_solids(
        self, tips: FloatArray, back: FloatArray, low: FloatArray, high: FloatArray, radius_mm: Radius
    ) -> IntArray:
        """Find the solid that each straight tube or cone meets first, from its axis outwards or along its lines.

        `tips`: shape (n, 3). Points on the axes, in the frame of the solids, mm.
        `back`: shape (n, 3). Unit vectors along the axes.
        `low`, `high`: shape (n,). Where each tube begins and ends, mm from the tip.

        Returns
        -------
        ndarray of int, shape (n,)
            -1 for a tube through whose surface and inside no face goes.
        """


@dataclass(frozen=True, slots=True, eq=False)
class ExactMaterial:
    """The solids of a `BrepGraph`."""

    graph: BrepGraph
    trimmed: TrimmedFaces  #: Of the same graph.

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the solids."""
        return self.graph.solid_names

    @property
    def boxes(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest corners of a box around each solid, two arrays (s, 3), mm."""
        return self.trimmed.solid_boxes

    def hits(self, origins: FloatArray, rays: FloatArray, length_mm: FloatArray | float) -> SolidHits:
        """Find where rays enter and leave solids; shapes as in `Material`."""
        found = find_hits(self.trimmed, origins, rays, length_mm=length_mm)
        return SolidHits(found.ray, self.graph.face_solid[found.face], found.at_mm, found.way)

    def tube_solids(
        self, tips: FloatArray, back: FloatArray, low: FloatArray, high: FloatArray, radius_mm: Radius
    ) -> IntArray:
        """Find the solid that the lines of each tube meet first, exactly; shapes as in `Material`.

        What fits between lines (`tubes.LINES_MM`) is not met.
        """
        first, last = radius_mm if isinstance(radius_mm, tuple) else (radius_mm, radius_mm)
        wide = max(first, last)
        lines = tube_lines(back, wide)
        k = lines.shape[1]
        origins = (tips + low[:, None] * back)[:, None] + first / wide * lines
        length = np.repeat(np.maximum(high - low, 0.0), k)
        ways = np.repeat(back, k, axis=0)
        if first != last:
            slant = length[:, None] * ways + ((last - first) / wide * lines).reshape(-1, 3)
            length = np.linalg.norm(slant, axis=1)
            ways = slant / np.where(length > 0.0, length, 1.0)[:, None]
        found = self.hits(origins.reshape(-1, 3), ways, length)
        solids = np.full(len(tips), -1)
        order = np.argsort(-found.at_mm, kind="stable")  # the nearest of each tube is written last
        solids[found.ray[order] // k] = found.solid[order]
        return solids


@dataclass(frozen=True, slots=True, eq=False)
class TriangleMaterial:
    """The solids of a part as triangles."""

    #: shape (m, 3, 3). The three corners of each triangle, mm, counter-clockwise seen from outside; the triangles of
    #: each solid close.
    corners: FloatArray
    solid: IntArray  #: shape (m,). Number of each triangle's solid.
    names: tuple[str, ...]  #: Of the solids.
    deflection_mm: float  #: Largest distance of a triangle from the part, mm.
    tree: BoxTree  #: Of the triangles' boxes.

    @classmethod
    def of(cls, mesh: PartMesh, T_frame_part: RigidTransform | None = None) -> TriangleMaterial:
        """Take the triangles of a part, in `part` or moved into another frame."""
        placed = [s.points if T_frame_part is None else T_frame_part.apply(s.points) for s in mesh.solids]
        corners = [points[s.triangles] for points, s in zip(placed, mesh.solids, strict=True)]
        every = np.concatenate([np.zeros((0, 3, 3)), *corners])
        solid = np.repeat(np.arange(len(corners)), [len(own) for own in corners])
        names = tuple(s.name for s in mesh.solids)
        return cls(every, solid, names, mesh.deflection_mm, BoxTree.of(every.min(axis=1), every.max(axis=1)))

    def of_solids(self, solids: IntArray) -> TriangleMaterial:
        """Return the material of some solids, shape (s,), which keep their numbers."""
        rows = np.flatnonzero(np.isin(self.solid, solids))
        own = self.corners[rows]
        tree = BoxTree.of(own.min(axis=1), own.max(axis=1))
        return TriangleMaterial(own, self.solid[rows], self.names, self.deflection_mm, tree)

    @property
    def boxes(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest corners of a box around each solid, two arrays (s, 3), mm."""
        low, high = np.full((len(self.names), 3), np.inf), np.full((len(self.names), 3), -np.inf)
        np.minimum.at(low, self.solid, self.corners.min(axis=1))
        np.maximum.at(high, self.solid, self.corners.max(axis=1))
        return low, high

    def hits(self, origins: FloatArray, rays: FloatArray, length_mm: FloatArray | float) -> SolidHits:
        """Find where rays enter and leave solids; shapes as in `Material`."""
        length = np.broadcast_to(np.asarray(length_mm, dtype=np.float64), len(origins))
        some = blocks(len(origins), CHUNK)
        found = RayHits.joined([self._hits(origins[own], rays[own], length[own], own.start) for own in some]).in_order()
        return SolidHits(found.ray, self.solid[found.face], found.at_mm, found.way)

    def tube_solids(
        self, tips: FloatArray, back: FloatArray, low: FloatArray, high: FloatArray, radius_mm: Radius
    ) -> IntArray:
        """Find the solid of the nearest triangle that each tube meets; shapes as in `Material`."""
        nearest = tube_triangles(self.corners, self.tree, tips, back, (low, high), radius_mm)
        return np.where(nearest < 0, -1, np.append(self.solid, -1)[nearest])

    def _hits(self, origins: FloatArray, rays: FloatArray, length: FloatArray, first: int) -> RayHits:
        """Return the hits of rays, numbered from `first` on, with triangles for faces (Möller and Trumbore 1997)."""
        ray, triangle = boxes_met(self.tree, origins, rays, length)
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b, c = np.moveaxis(self.corners[triangle], 1, 0)
            e1, e2, r = b - a, c - a, origins[ray] - a
            across, side = np.cross(rays[ray], e2), np.cross(r, e1)
            det = np.einsum("ki,ki->k", e1, across)
            u = np.einsum("ki,ki->k", r, across) / det
            v = np.einsum("ki,ki->k", rays[ray], side) / det
            at = np.einsum("ki,ki->k", e2, side) / det
            size = np.linalg.norm(np.cross(e1, e2), axis=1)
            hit = (np.abs(det) > FLAT * size) & (u >= 0) & (v >= 0) & (u + v <= 1) & (at > 0) & (at <= length[ray])
        rows = np.flatnonzero(hit)
        return RayHits(ray[rows] + first, triangle[rows], at[rows], np.where(det[rows] > 0, -1, 1))


def find_solids_around(material: Material, points: FloatArray) -> tuple[IntArray, IntArray]:
    """Find the solids that points are inside of.

    `points`: shape (m, 3). In `part`, mm. On a face the answer is either.

    Returns `point`, `solid`: shape (k,). Pairs of a point and a solid around it, sorted by point, then solid.
    """
    low, high = material.boxes
    asked, solid = BoxTree.of(low, high).meeting(points, points)
    row, first = np.unique(asked, return_index=True)
    if len(row) == 0:
        return row, row
    rays = VOTERS / np.linalg.norm(VOTERS, axis=1, keepdims=True)
    side = np.where(rays > 0.0, high[solid][:, None], low[solid][:, None])
    leaves = ((side - points[asked][:, None]) / rays).min(axis=2)
    far = np.zeros((len(points), 3))
    far[row] = np.maximum.reduceat(leaves, first) + BEYOND_MM  # there a ray has left every box that is around its point

    def left(own: IntArray, ray: int) -> IntArray:
        """Return pairs of a point and a solid that a ray leaves more often than it enters it, each as one number."""
        found = material.hits(points[own], np.broadcast_to(rays[ray], (len(own), 3)), far[own, ray])
        pairs, of = np.unique(own[found.ray] * len(low) + found.solid, return_inverse=True)
        return np.asarray(pairs[np.bincount(of, found.way, minlength=len(pairs)) > 0])

    one, other = left(row, 0), left(row, 1)
    inside, doubted = np.intersect1d(one, other), np.setxor1d(one, other)
    if len(doubted):
        third = left(np.unique(doubted // len(low)), 2)
        inside = np.union1d(inside, np.intersect1d(doubted, third))
    return inside // len(low), inside % len(low)
