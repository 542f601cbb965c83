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

    def inside(self, faces: IntArray, points: FloatArray, uv: FloatArray) -> tuple[BoolArray, FloatArray]:
        """Tell which points of surfaces lie on the trimmed faces, and how far from the boundary.

        Parameters
        ----------
        faces : ndarray of int, shape (m,)
        points : ndarray, shape (m, 3)
            Feet on the faces' surfaces (`project_to_faces`), in `part`, mm.
        uv : ndarray, shape (m, 2)
            Their parameters.

        Returns
        -------
        inside : ndarray of bool, shape (m,)
        distance_mm : ndarray, shape (m,)
            To the nearest piece of boundary; infinite for a face without one (a whole sphere: all of it is inside).
        """
        inside, distance = self.covers(faces, uv), np.full(len(faces), np.inf)
        for rows in self._chunks(faces):
            row, piece = self._pairs(faces[rows])
            off = distance_to_segments(points[rows[row]], self.p0[piece], self.p1[piece])
            np.minimum.at(distance, rows[row], off)
        return inside, distance

    def covers(self, faces: IntArray, uv: FloatArray) -> BoolArray:
        """Tell which points of surfaces lie on the trimmed faces: `inside` without the distance.

        Parameters
        ----------
        faces : ndarray of int, shape (m,)
        uv : ndarray, shape (m, 2)
            Parameters of the points (`project_to_faces`).

        Returns
        -------
        ndarray of bool, shape (m,)
        """
        covered = np.zeros(len(faces), dtype=bool)
        for rows in self._chunks(faces):
            covered[rows] = self._covers(faces[rows], uv[rows])
        return covered

    def _chunks(self, faces: IntArray) -> Iterator[IntArray]:
        """Yield rows of `faces`, sorted by face, that make at most about `MOST_PAIRS` pairs."""
        order = np.argsort(faces, kind="stable")
        load = np.cumsum((self.start[faces + 1] - self.start[faces])[order])
        if len(load):
            yield from np.split(order, np.flatnonzero(np.diff(load // MOST_PAIRS)) + 1)

    def _pairs(self, faces: IntArray) -> tuple[IntArray, IntArray]:
        """Return every pair of a row of `faces` and a piece of that face's boundary."""
        counts = self.start[faces + 1] - self.start[faces]
        row = np.repeat(np.arange(len(faces)), counts)
        return row, self.start[faces][row] + np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)

    def _covers(self, faces: IntArray, uv: FloatArray) -> BoolArray:
        kind = self.graph.face_kind[faces]
        row, piece = self._pairs(faces)
        u0, u1 = self._relative(0, np.isin(kind, PERIODIC_U)[row], piece, uv[row, 0])
        crosses = np.flatnonzero((u0 <= 0) != (u1 <= 0))
        row, piece, u0, u1 = row[crosses], piece[crosses], u0[crosses], u1[crosses]
        v0, v1 = self._relative(1, (kind == SurfaceKind.TORUS)[row], piece, uv[row, 1])
        v = v0 - u0 / (u1 - u0) * (v1 - v0)
        v = np.where(kind[row] == SurfaceKind.TORUS, np.mod(v, 2 * np.pi), v)
        whole = self.start[faces + 1] == self.start[faces]
        return _below_nearest(row, v, u1 < u0, whole)

    def _relative(self, axis: int, turns: BoolArray, piece: IntArray, own: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return one parameter of the ends of pieces relative to points, the nearest way round where it turns."""
        a0, a1 = self.uv0[piece, axis] - own, self.uv1[piece, axis] - own
        if turns.any():
            run = wrap_angle(a1[turns] - a0[turns])
            a0[turns] = wrap_angle(a0[turns])
            a1[turns] = a0[turns] + run
        return a0, a1


def _below_nearest(row: IntArray, v: FloatArray, towards_minus: BoolArray, whole: BoolArray) -> BoolArray:
    """Decide by the piece of boundary next above each point, or next below where none is above.

    A face lies to the left of its boundary: below a piece that runs to -u, above one that runs to +u. Where no
    piece crosses the point's meridian at all, a surface without boundary is taken as a whole and any other as missed.

    Parameters
    ----------
    row : ndarray of int, shape (k,)
        The point whose meridian a piece crosses.
    v : ndarray, shape (k,)
        How far above the point it crosses.
    towards_minus : ndarray of bool, shape (k,)
        Which way the piece runs.
    whole : ndarray of bool, shape (n,)
        Of every point, whether its face has no boundary.
    """
    found = whole.copy()
    for above in (False, True):  # the piece above has the last word
        hit = np.flatnonzero(v > 0 if above else v <= 0)
        hit = hit[np.lexsort((np.abs(v[hit]), row[hit]))]
        rows, first = np.unique(row[hit], return_index=True)
        found[rows] = towards_minus[hit[first]] == above
    return found


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
    square = np.einsum("mi,mi->m", d, d)
    share = np.clip(np.einsum("mi,mi->m", r, d) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    r -= share[:, None] * d
    return np.asarray(np.sqrt(np.einsum("mi,mi->m", r, r)), dtype=np.float64)
