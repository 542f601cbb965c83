"""Which part of a surface a face covers: is a point inside its boundary, and how far from it.

The boundary is a polyline (sag `curves.CHORD_MM`). A point of the surface is inside when the piece of boundary next
above it (along v at the same u) runs in the direction that has the face on its lower side. That holds on closed
surfaces, too, where counting crossings fails.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wpcal.brep.curves import edge_polylines
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

PERIODIC_U = (SurfaceKind.CYLINDER, SurfaceKind.CONE, SurfaceKind.SPHERE, SurfaceKind.TORUS)
AXIS_MM = 1e-6
"""A boundary point this near to the axis is the apex: kernels place vertices to 1e-7 mm."""
MOST_PAIRS = 2_000_000
"""Point and boundary-piece pairs handled in one array: about 200 MB."""


@dataclass(frozen=True, eq=False)
class TrimmedFaces:
    """The boundaries of all faces of a graph as pieces, sorted by face.

    Parameters
    ----------
    graph : BrepGraph
    start : ndarray of int, shape (F + 1,)
        The pieces of face f are ``start[f]:start[f + 1]``.
    uv0, uv1 : ndarray, shape (m, 2)
        Ends of each piece on the face's surface, the face to the left in (u, v) seen along the surface's own normal.
    p0, p1 : ndarray, shape (m, 3)
        The same in `part`, mm.
    piece_edge : ndarray of int, shape (m,)
        The edge that a piece stands for.
    t0, t1 : ndarray, shape (m,)
        Edge parameters at the ends of each piece.
    """

    graph: BrepGraph
    start: IntArray
    uv0: FloatArray
    uv1: FloatArray
    p0: FloatArray
    p1: FloatArray
    piece_edge: IntArray
    t0: FloatArray
    t1: FloatArray

    @classmethod
    def of(cls, graph: BrepGraph) -> TrimmedFaces:
        """Sample the boundaries of all faces of `graph`."""
        used = ~graph.is_seam_edge[graph.coedge_edge] & (graph.edge_kind[graph.coedge_edge] != CurveKind.DEGENERATE)
        order = np.flatnonzero(used)[np.argsort(graph.coedge_face[used], kind="stable")]
        face, edge, forward = graph.coedge_face[order], graph.coedge_edge[order], graph.coedge_forward[order]
        start, t, points = edge_polylines(graph)
        counts = np.diff(start)[edge] - 1
        coedge = np.repeat(np.arange(len(order)), counts)
        step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        low = start[edge[coedge]] + step
        flip = ~forward[coedge]
        first, second = np.where(flip, low + 1, low), np.where(flip, low, low + 1)
        of_face = face[coedge]
        p0, p1 = points[first], points[second]
        uv0, uv1 = project_to_faces(graph, of_face, p0).uv, project_to_faces(graph, of_face, p1).uv
        for here, there, p in ((uv0, uv1, p0), (uv1, uv0, p1)):
            apex = is_on_axis(graph, of_face, p)  # no angle of its own: the meridian of the other end leads there
            here[apex, 0] = there[apex, 0]
        swap = graph.face_outward[of_face] < 0  # left seen from outside is right seen along the surface's own normal
        uv0[swap], uv1[swap] = uv1[swap], uv0[swap].copy()
        face_start = np.searchsorted(of_face, np.arange(graph.face_count + 1))
        return cls(graph, face_start, uv0, uv1, p0, p1, edge[coedge], t[first], t[second])

    @cached_property
    def face_box(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest corner of each face's boundary and, where round, its bulge; two arrays (F, 3)."""
        low, high = np.full((self.graph.face_count, 3), np.inf), np.full((self.graph.face_count, 3), -np.inf)
        faces = np.repeat(np.arange(self.graph.face_count), np.diff(self.start))
        for p in (self.p0, self.p1):
            np.minimum.at(low, faces, p)
            np.maximum.at(high, faces, p)
        bulge = self._bulge()
        return low - bulge, high + bulge

    def _bulge(self) -> FloatArray:
        """How far a face may reach beyond the box of its boundary, mm, (F, 1)."""
        graph = self.graph
        reach = np.zeros(graph.face_count)
        closed = np.isin(graph.face_kind, (SurfaceKind.SPHERE, SurfaceKind.TORUS))
        reach[closed] = graph.face_param[closed].sum(axis=1)
        for face in np.flatnonzero(graph.face_kind == SurfaceKind.NURBS):
            poles = graph.nurbs_surfaces[graph.face_nurbs[face]].poles.reshape(-1, 3)
            reach[face] = float(np.ptp(poles, axis=0).max()) / 8.0  # a curved patch between its own boundary curves
        return reach[:, None]

    def contains(self, faces: IntArray, uv: FloatArray) -> BoolArray:
        """Tell which points of surfaces lie inside the trimmed faces.

        Parameters
        ----------
        faces : ndarray of int, shape (m,)
        uv : ndarray, shape (m, 2)
            Parameters of points on the faces' surfaces (`project_to_faces`).

        Returns
        -------
        ndarray of bool, shape (m,)
            True on a face without boundary (a whole sphere).
        """
        inside = np.asarray(self.start[faces + 1] == self.start[faces], dtype=bool)
        for row, piece in self._pairs(faces):
            _decide(inside, *self._crossings(faces, uv, row, piece))
        return inside

    def boundary_distance(self, faces: IntArray, points: FloatArray) -> FloatArray:
        """Return how far points are from the boundaries of faces, mm, shape (m,); infinite where there is none.

        Parameters
        ----------
        faces : ndarray of int, shape (m,)
        points : ndarray, shape (m, 3)
            In `part`, mm.
        """
        distance = np.full(len(faces), np.inf)
        for row, piece in self._pairs(faces):
            first = np.flatnonzero(np.diff(row, prepend=-1))
            off = distance_to_segments(points[row], self.p0[piece], self.p1[piece])
            distance[row[first]] = np.minimum.reduceat(off, first)
        return distance

    def _pairs(self, faces: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
        """Yield pairs of a row of `faces` and a piece of that face's boundary, rows ascending, in chunks."""
        counts = self.start[faces + 1] - self.start[faces]
        chunk = np.cumsum(counts) // MOST_PAIRS
        for rows in np.split(np.arange(len(faces)), np.flatnonzero(np.diff(chunk)) + 1):
            count = counts[rows]
            row = np.repeat(rows, count)
            before = np.cumsum(count) - count
            piece = np.arange(len(row)) + np.repeat(self.start[faces[rows]] - before, count)
            if len(row):
                yield row, piece

    def _crossings(
        self, faces: IntArray, uv: FloatArray, row: IntArray, piece: IntArray
    ) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return rows, relative v and run along u of the pieces that cross the meridian of their point."""
        kind = self.graph.face_kind[faces]
        u0, run = self.uv0[piece, 0] - uv[row, 0], self.uv1[piece, 0] - self.uv0[piece, 0]
        turning = np.isin(kind, PERIODIC_U)
        if turning.any():
            turn = turning[row]
            u0[turn], run[turn] = wrap_angle(u0[turn]), wrap_angle(run[turn])
        crosses = np.flatnonzero((u0 <= 0) != (u0 + run <= 0))
        row, piece, u0, run = row[crosses], piece[crosses], u0[crosses], run[crosses]
        v0, rise = self.uv0[piece, 1] - uv[row, 1], self.uv1[piece, 1] - self.uv0[piece, 1]
        torus = kind[row] == SurfaceKind.TORUS
        rise = np.where(torus, wrap_angle(rise), rise)
        v = v0 - u0 / run * rise
        return row, np.where(torus, np.mod(v, 2 * np.pi), v), run


def _decide(inside: BoolArray, row: IntArray, v: FloatArray, run: FloatArray) -> None:
    """Decide by the piece of boundary next above each point, or next below where none is above.

    A face lies to the left of its boundary: below a piece that runs towards -u, above one that runs towards +u. Where
    no piece crosses a point's meridian its value stays: a surface without boundary is whole, any other is missed.
    """
    for above in (False, True):  # the piece above has the last word
        hit = np.flatnonzero((v > 0) == above)
        hit = hit[np.lexsort((np.abs(v[hit]), row[hit]))]
        nearest = hit[np.flatnonzero(np.diff(row[hit], prepend=-1))]
        inside[row[nearest]] = (run[nearest] < 0) == above


def is_on_axis(graph: BrepGraph, faces: IntArray, points: FloatArray) -> BoolArray:
    """Tell which points lie on the axis of their cone or sphere: at its apex or pole; shape (m,)."""
    frame = graph.face_frame[faces]
    arm = points - frame[:, 0]
    height = np.einsum("mi,mi->m", arm, frame[:, 3])
    off = np.linalg.norm(arm - height[:, None] * frame[:, 3], axis=1)
    pointed = np.isin(graph.face_kind[faces], (SurfaceKind.CONE, SurfaceKind.SPHERE))
    return np.asarray(pointed & (off < AXIS_MM), dtype=bool)


def wrap_angle(angle: FloatArray) -> FloatArray:
    """Return angles in [-pi, pi), rad."""
    return np.asarray(np.mod(angle + np.pi, 2 * np.pi) - np.pi, dtype=np.float64)


def distance_to_segments(points: FloatArray, p0: FloatArray, p1: FloatArray) -> FloatArray:
    """Return the distance of each point to its own segment, all arrays (m, 3), mm."""
    d, r = p1 - p0, points - p0
    square = np.einsum("ki,ki->k", d, d)
    along = np.einsum("ki,ki->k", r, d)
    share = np.clip(along / np.where(square > 0, square, 1.0), 0.0, 1.0)
    off = r - share[:, None] * d
    return np.asarray(np.sqrt(np.einsum("ki,ki->k", off, off)), dtype=np.float64)
