"""The part as triangles in the robot's base, and its distance from a straight torch.

The triangles are within their deflection (`PartMesh.deflection_mm`) of the part; whoever asks for a distance adds it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.brep.boxes import BoxTree
from wpcal.brep.mesh import PartMesh
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.segments import Segments, segment_distances

CHUNK = 200_000
"""Pairs of a torch and a triangle in one array: some 50 MB."""
FLAT = 1e-12
"""A triangle whose area is below this part of its squared edges is a line, and its edges are enough."""


@dataclass(frozen=True, slots=True, eq=False)
class PartTriangles:
    """Triangles of all solids of a part.

    Parameters
    ----------
    corners : ndarray, shape (m, 3, 3)
        The three corners of each triangle in `base`, mm.
    solid : ndarray of int, shape (m,)
        Number of each triangle's solid.
    names : tuple of str
        Of the solids.
    deflection_mm : float
        Largest distance of a triangle from the part, mm.
    tree : BoxTree
        Of the triangles' boxes.
    """

    corners: FloatArray
    solid: IntArray
    names: tuple[str, ...]
    deflection_mm: float
    tree: BoxTree

    @classmethod
    def of(cls, mesh: PartMesh, T_base_part: RigidTransform) -> PartTriangles:
        """Move a part's triangles into the base."""
        corners = [T_base_part.apply(solid.points)[solid.triangles] for solid in mesh.solids]
        counts = [len(found) for found in corners]
        every = np.concatenate([np.zeros((0, 3, 3)), *corners])
        names = tuple(solid.name for solid in mesh.solids)
        tree = BoxTree.of(every.min(axis=1), every.max(axis=1))
        return cls(every, np.repeat(np.arange(len(counts)), counts), names, mesh.deflection_mm, tree)

    def near(self, starts: FloatArray, ends: FloatArray, within: FloatArray) -> tuple[IntArray, IntArray]:
        """Find the triangles whose boxes come near segments.

        Parameters
        ----------
        starts, ends : ndarray, shape (n, 3)
            In `base`, mm.
        within : ndarray, shape (n,)
            How near, mm.

        Returns
        -------
        row, triangle : ndarray of int, shape (k,)
        """
        grow = within[:, None]
        return self.tree.meeting(np.minimum(starts, ends) - grow, np.maximum(starts, ends) + grow)

    def distances(self, starts: FloatArray, ends: FloatArray, within: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return the distance of each segment from the part, as far as it is within a bound.

        Parameters
        ----------
        starts, ends : ndarray, shape (n, 3)
            In `base`, mm.
        within : ndarray, shape (n,)
            Beyond this distance, mm, the answer is infinity.

        Returns
        -------
        distance : ndarray, shape (n,)
            mm; infinity where nothing is within the bound.
        triangle : ndarray of int, shape (n,)
            The nearest triangle; -1 where there is none.
        """
        row, triangle = self.near(starts, ends, within)
        best, nearest = np.full(len(starts), np.inf), np.full(len(starts), -1)
        for first in range(0, len(row), CHUNK):
            own, which = row[first : first + CHUNK], triangle[first : first + CHUNK]
            found = segment_triangle_distances(starts[own], ends[own], self.corners[which])
            order = np.argsort(-found, kind="stable")  # the nearest of each row is written last
            closer = order[found[order] < best[own[order]]]
            best[own[closer]], nearest[own[closer]] = found[closer], which[closer]
        far = best > within
        return np.where(far, np.inf, best), np.where(far, -1, nearest)

    def surrounds(self, points: FloatArray) -> IntArray:
        """Return the solid around each point, by the solid angle that its triangles fill; -1 for a point outside.

        Parameters
        ----------
        points : ndarray, shape (n, 3)
            In `base`, mm.

        Returns
        -------
        ndarray of int, shape (n,)
        """
        inside = np.full(len(points), -1)
        for row, point in enumerate(points):
            a, b, c = (self.corners[:, k] - point for k in range(3))
            la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
            volume = np.einsum("ij,ij->i", a, np.cross(b, c))
            ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
            angle = 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)
            turns = np.bincount(self.solid, angle, minlength=len(self.names)) / (4.0 * np.pi)
            if len(turns) and turns.max() > 0.5:  # 1 inside a solid, 0 outside
                inside[row] = int(np.argmax(turns))
        return inside

    def solid_of(self, triangle: int) -> str:
        """Return the name of a triangle's solid."""
        return self.names[int(self.solid[triangle])]


def segment_triangle_distances(starts: FloatArray, ends: FloatArray, corners: FloatArray) -> FloatArray:
    """Return the distances of segments from triangles, pair by pair.

    The nearest point is on an edge of the triangle, or at an end of the segment, or where the segment goes through.

    Parameters
    ----------
    starts, ends : ndarray, shape (k, 3)
        Any frame, mm.
    corners : ndarray, shape (k, 3, 3)
        Corners of the triangles in the same frame.

    Returns
    -------
    ndarray, shape (k,)
        mm.
    """
    segments = Segments(starts.T, (ends - starts).T)
    best = np.full(len(starts), np.inf)
    for k in range(3):
        edge = Segments(corners[:, k].T, (corners[:, (k + 1) % 3] - corners[:, k]).T)
        best = np.minimum(best, segment_distances(segments, edge))
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    real = length > FLAT * ((corners - corners[:, :1]) ** 2).sum(axis=(1, 2))
    normal = np.where(real[:, None], normal, 0.0) / np.where(real, length, 1.0)[:, None]
    heights = [np.einsum("ij,ij->i", point - corners[:, 0], normal) for point in (starts, ends)]
    for point, height in zip((starts, ends), heights, strict=True):
        over = real & _is_over(point, corners, normal)
        best = np.where(over, np.minimum(best, np.abs(height)), best)
    span = heights[0] - heights[1]
    crosses = real & (heights[0] * heights[1] <= 0.0) & (span != 0.0)
    share = heights[0] / np.where(span != 0.0, span, 1.0)
    through = crosses & _is_over(starts + share[:, None] * (ends - starts), corners, normal)
    return np.where(through, 0.0, best)


def _is_over(points: FloatArray, corners: FloatArray, normal: FloatArray) -> BoolArray:
    """Tell whether the projections of points on the planes of triangles are inside the triangles."""
    over = np.ones(len(points), dtype=bool)
    for k in range(3):
        edge = corners[:, (k + 1) % 3] - corners[:, k]
        over &= np.einsum("ij,ij->i", np.cross(normal, edge), points - corners[:, k]) >= 0.0
    return over


def tube_hits(
    part: PartTriangles, tips: FloatArray, back: FloatArray, low: FloatArray, high: FloatArray, radius_mm: float
) -> IntArray:
    """Find what a straight tube with flat ends meets: the triangle nearest to its axis.

    Each triangle is cut off at both ends of the tube; what remains is compared with the radius.

    Parameters
    ----------
    part : PartTriangles
    tips : ndarray, shape (n, 3)
        Points on the axes, in `base`, mm.
    back : ndarray, shape (n, 3)
        Unit vectors along the axes.
    low, high : ndarray, shape (n,)
        Where each tube begins and ends, mm from the tip.
    radius_mm : float

    Returns
    -------
    ndarray of int, shape (n,)
        The triangle; -1 for a tube that meets none.
    """
    starts, ends = tips + low[:, None] * back, tips + high[:, None] * back
    row, triangle = part.near(starts, ends, np.full(len(tips), radius_mm))
    best, nearest = np.full(len(tips), radius_mm), np.full(len(tips), -1)
    for first in range(0, len(row), CHUNK):
        own, which = row[first : first + CHUNK], triangle[first : first + CHUNK]
        found = _axis_distances(part.corners[which] - tips[own, None], back[own], low[own], high[own])
        order = np.argsort(-found, kind="stable")
        closer = order[found[order] < best[own[order]]]
        best[own[closer]], nearest[own[closer]] = found[closer], which[closer]
    return nearest


def _axis_distances(corners: FloatArray, axis: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return how near triangles come to axes through the origin, between two heights; infinity if not between."""
    side = np.cross(axis, np.where(np.abs(axis[:, :1]) < 0.6, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]]))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    z = np.einsum("kij,kj->ki", corners, axis)
    flat = np.stack([np.einsum("kij,kj->ki", corners, v) for v in (side, np.cross(axis, side))], axis=-1)
    best = np.full(len(corners), np.inf)
    cuts: list[tuple[FloatArray, BoolArray]] = []
    for k in range(3):
        a, b, za, zb = flat[:, k], flat[:, (k + 1) % 3], z[:, k], z[:, (k + 1) % 3]
        rise = np.where(za == zb, 1.0, zb - za)
        t = np.sort(np.stack([(low - za) / rise, (high - za) / rise]), axis=0)
        level = (za == zb) & (za >= low) & (za <= high)
        t0 = np.where(za == zb, np.where(level, 0.0, 2.0), np.maximum(t[0], 0.0))
        t1 = np.where(za == zb, np.where(level, 1.0, 1.0), np.minimum(t[1], 1.0))
        inside = t0 <= t1
        first, last = a + t0[:, None] * (b - a), a + t1[:, None] * (b - a)
        best = np.where(inside, np.minimum(best, _from_origin(first, last)), best)
        for height in (low, high):
            share = (height - za) / rise
            cuts.append((a + share[:, None] * (b - a), (za != zb) & (share >= 0.0) & (share <= 1.0)))
    for end in (0, 1):  # the chords in which the ends of the tube cut the triangle
        ends = cuts[end::2]
        for i, j in ((0, 1), (1, 2), (2, 0)):
            both = ends[i][1] & ends[j][1]
            best = np.where(both, np.minimum(best, _from_origin(ends[i][0], ends[j][0])), best)
    return np.where(_axis_goes_through(flat, z, low, high), 0.0, best)


def _from_origin(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the distances of plane segments from the origin, shape (k,)."""
    span = b - a
    squared = np.maximum((span**2).sum(axis=1), np.finfo(float).tiny)
    t = np.clip(-(a * span).sum(axis=1) / squared, 0.0, 1.0)
    return np.asarray(np.linalg.norm(a + t[:, None] * span, axis=1), dtype=np.float64)


def _axis_goes_through(flat: FloatArray, z: FloatArray, low: FloatArray, high: FloatArray) -> BoolArray:
    weights = np.stack(
        [
            flat[:, (k + 1) % 3, 0] * flat[:, (k + 2) % 3, 1] - flat[:, (k + 1) % 3, 1] * flat[:, (k + 2) % 3, 0]
            for k in range(3)
        ],
        axis=1,
    )
    total = weights.sum(axis=1)
    real = total != 0.0
    weights = weights / np.where(real, total, 1.0)[:, None]
    height = (weights * z).sum(axis=1)
    return np.asarray(real & (weights >= 0.0).all(axis=1) & (height >= low) & (height <= high), dtype=np.bool_)
