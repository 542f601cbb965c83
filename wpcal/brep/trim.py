"""Which part of a surface a face covers: whether a point is inside the boundary, and how far from the boundary.

The boundary is a polyline (sag `curves.CHORD_MM`). The test looks at the next piece of boundary above the point (along
v at the same u). The point is inside if this piece runs in the direction that has the face on its lower side. The test
also works on closed surfaces, where counting crossings fails.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, wraps
from typing import Any, TypeVar

import numpy as np

from wpcal.brep.boundaries import sample_boundaries
from wpcal.brep.boxes import FAR_MM, BoxTree, are_met
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.patch_boxes import PatchBoxes, patch_corners, ring_boxes, widest_gaps
from wpcal.brep.strips import Strips, items_in_chunks, wrap_angle
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

PERIODIC_U = (SurfaceKind.CYLINDER, SurfaceKind.CONE, SurfaceKind.SPHERE, SurfaceKind.TORUS)
CLOSED = (SurfaceKind.SPHERE, SurfaceKind.TORUS)
"""Surfaces on which a face may contain a whole meridian: the far side of a bored ball, the bend of a pipe."""
ON_MERIDIAN_RAD = 1e-9
"""A piece of boundary whose ends are this near to a meridian runs along the meridian: angles round off at 1e-13."""
SAME_PLACE = 1e-6  #: Crossings of a meridian that agree within this, mm or rad, are one place: two pieces meet there.
BLOCK = 16  #: Pieces of boundary that are told apart from a box together.
MOST_PAIRS = 500_000  #: Point and boundary-piece pairs handled in one array: about 50 MB.


@dataclass(frozen=True, eq=False)
class TrimmedFaces:
    """The boundaries of all faces of a graph as pieces, sorted by face."""

    graph: BrepGraph
    start: IntArray  #: shape (F + 1,). The pieces of face f are ``start[f]:start[f + 1]``.
    #: `uv0`, `uv1`: shape (m, 2). Ends of each piece on the face's surface, the face to the left in (u, v) seen along
    #: the surface's own normal.
    uv0: FloatArray
    uv1: FloatArray
    #: `p0`, `p1`: shape (m, 3). The same in `part`, mm.
    p0: FloatArray
    p1: FloatArray
    piece_edge: IntArray  #: shape (m,). The edge that a piece belongs to.
    #: `t0`, `t1`: shape (m,). Edge parameters at the ends of each piece.
    t0: FloatArray
    t1: FloatArray
    #: What somebody has found out about solids, by subject and solid. It stays with the faces if edges are added.
    known: dict[tuple[str, int], Any] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, graph: BrepGraph) -> TrimmedFaces:
        """Sample the boundaries of all faces of `graph`."""
        return cls(graph, *sample_boundaries(graph))

    def with_graph(self, graph: BrepGraph) -> TrimmedFaces:
        """Return the same faces in a graph with more edges, with all that was computed for the faces."""
        other = replace(self, graph=graph)
        vars(other).update({name: value for name, value in vars(self).items() if name not in _FIELDS})
        return other

    def without(self, solids: IntArray | int) -> TrimmedFaces:
        """Return the faces as if some solids, shape (k,), were not there: with empty boxes, so nothing meets them."""
        hidden = np.isin(self.graph.face_solid, solids)
        low, high = self.face_box
        boxes = np.where(hidden[:, None], FAR_MM, low), np.where(hidden[:, None], -FAR_MM, high)
        tree, patches = self.box_tree.without(hidden), self.patch_boxes.without(hidden)
        other = self.with_graph(self.graph)
        vars(other).update(face_box=boxes, box_tree=tree, patch_boxes=patches, _blocks=self._blocks)
        for name in ("solid_boxes", "solid_sides_mm"):
            vars(other).pop(name, None)
        return other

    def heights(self, face: int, way: FloatArray) -> FloatArray:
        """Return how far along a direction, shape (3,), the boundary of a face goes, shape (k,), mm."""
        return np.asarray(self.p0[self.start[face] : self.start[face + 1]] @ way)

    @cached_property
    def face_box(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest corner of a box around each face; two arrays (F, 3).

        The box holds boundary and apexes. For a sphere or a torus it holds the whole surface. For a NURBS face it holds
        the poles that act on the used part: a tube may bend far beyond the circles at its ends.
        """
        graph = self.graph
        low, high = np.full((graph.face_count, 3), np.inf), np.full((graph.face_count, 3), -np.inf)
        faces = np.repeat(np.arange(graph.face_count), np.diff(self.start))
        apex = np.flatnonzero(graph.edge_kind[graph.coedge_edge] == CurveKind.DEGENERATE)
        tips = graph.vertex_p[graph.edge_vertices[graph.coedge_edge[apex], 0]]
        for face, p in ((faces, self.p0), (faces, self.p1), (graph.coedge_face[apex], tips)):
            np.minimum.at(low, face, p)
            np.maximum.at(high, face, p)
        closed = np.isin(graph.face_kind, CLOSED)
        across = np.sqrt(np.maximum(1.0 - graph.face_frame[closed, 3] ** 2, 0.0))  # of the circle about the axis
        ring = (graph.face_kind[closed] == SurfaceKind.TORUS)[:, None]
        major, minor = graph.face_param[closed, :1], graph.face_param[closed, 1:2]
        reach = np.where(ring, major * across + minor, major)
        low[closed], high[closed] = graph.face_frame[closed, 0] - reach, graph.face_frame[closed, 0] + reach
        for number in np.flatnonzero(graph.face_kind == SurfaceKind.NURBS).tolist():
            corners = patch_corners(graph.nurbs_surfaces[graph.face_nurbs[number]])
            low[number] = np.minimum(low[number], corners[0].min(axis=0))
            high[number] = np.maximum(high[number], corners[1].max(axis=0))
        return low, high

    @cached_property
    def solid_boxes(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest corner of a box around each solid, two arrays (S, 3); of one without faces, ±infinite."""
        low, high = (np.full((len(self.graph.solid_names), 3), end) for end in (np.inf, -np.inf))
        np.minimum.at(low, self.graph.face_solid, self.face_box[0])
        np.maximum.at(high, self.graph.face_solid, self.face_box[1])
        return low, high

    @cached_property
    def solid_sides_mm(self) -> FloatArray:
        """The sides of the box around each solid, shape (S, 3), mm; zero if it has no faces."""
        return np.maximum(self.solid_boxes[1] - self.solid_boxes[0], 0.0)

    def _ring_ends(self, faces: IntArray, axis: int) -> FloatArray:
        """Return between which u (axis 0) or v (axis 1) faces on tori lie, shape (k, 2), rad.

        The widest gap in their boundary is left out, unless the face holds it.
        """
        owner, piece = np.concatenate(
            [np.zeros((2, 0), dtype=np.int64), *map(np.stack, items_in_chunks(self.start, faces, MOST_PAIRS))], axis=1
        )
        step = wrap_angle(self.uv1[piece] - self.uv0[piece])
        gaps = widest_gaps(self.uv0[piece, axis], step[:, axis], owner, len(faces))
        at = np.zeros((len(faces), 2))
        at[owner] = self.uv0[piece] + step / 2.0  # beside a piece of the boundary
        at[:, axis] = gaps.mean(axis=1)
        gaps[self.contains(faces, at)] = 0.0
        return np.stack([gaps[:, 1], gaps[:, 0] + 2.0 * np.pi], axis=1)

    @cached_property
    def box_tree(self) -> BoxTree:
        """The boxes of the faces in a tree."""
        return BoxTree.of(*self.face_box)

    @cached_property
    def patch_boxes(self) -> PatchBoxes:
        """Boxes of the faces, those of free-form faces divided into patches, and those on tori as tight as they are."""
        low, high = (corner.copy() for corner in self.face_box)
        ring = np.flatnonzero(self.graph.face_kind == SurfaceKind.TORUS)
        low[ring], high[ring] = ring_boxes(self.graph, ring, *(self._ring_ends(ring, axis) for axis in (0, 1)))
        return PatchBoxes.of(self.graph, low, high)

    def contains(self, faces: IntArray, uv: FloatArray) -> BoolArray:
        """Tell which points of surfaces lie inside the trimmed faces.

        `faces`: ndarray of int, shape (m,).
        `uv`: shape (m, 2). Parameters of points on the faces' surfaces (`project_to_faces`).
        Returns ndarray of bool, shape (m,). True on a face without boundary (a whole sphere).

        If no boundary crosses the meridian of a point, the point is outside. On a sphere or a torus, another meridian
        decides (`_holds_meridian`).
        """
        inside = np.asarray(self.start[faces + 1] == self.start[faces], dtype=bool)
        open_ = (
            np.isin(self.graph.face_kind[faces], CLOSED) & ~inside
        )  # undecided until a piece crosses the meridian of the point
        for row, piece in self._strips.pairs(faces, self._turned(faces, uv[:, 0]), MOST_PAIRS):
            crossed, v, run, away = self._crossings(faces, uv, row, piece)
            _decide(inside, crossed, v, run, away)
            open_[crossed] = False
        rows = np.flatnonzero(open_)
        inside[rows] = self._holds_meridian(faces[rows], uv[rows, 0])
        return inside

    def boundary_distance(
        self, faces: IntArray, points: FloatArray, *, within_mm: float = np.inf, group: IntArray | None = None
    ) -> FloatArray:
        """Return how far points are from the boundaries of faces, mm, shape (m,); infinite beyond `within_mm`.

        `faces`: shape (m,).
        `points`: shape (m, 3). In `part`, mm.
        `group`: shape (m,), optional. Points with the same number are consecutive and belong to one face, such as the
        samples of an edge. Pieces of boundary away from the box around such a group are skipped together.
        """
        distance = np.full(len(faces), np.inf)
        first = np.arange(len(faces)) if group is None else np.flatnonzero(np.diff(group, prepend=-1))
        if len(first) == 0:
            return distance
        size = np.diff(first, append=len(faces))
        low = np.minimum.reduceat(points, first) - within_mm
        high = np.maximum.reduceat(points, first) + within_mm
        box, near = self.pieces_meeting(faces[first], low, high)
        count = size[box]
        row = np.arange(count.sum()) + np.repeat(first[box] - (np.cumsum(count) - count), count)
        piece = np.repeat(near, count)
        for own in np.array_split(np.arange(len(row)), len(row) // MOST_PAIRS + 1):
            at, of_face = row[own], piece[own]
            np.minimum.at(distance, at, distance_to_segments(points[at], self.p0[of_face], self.p1[of_face]))
        distance[distance > within_mm] = np.inf
        return distance

    @cached_property
    def piece_mm(self) -> FloatArray:
        """The length of each piece, shape (m,), mm."""
        return np.asarray(np.linalg.norm(self.p1 - self.p0, axis=1), dtype=np.float64)

    def pieces_meeting(self, faces: IntArray, low: FloatArray, high: FloatArray) -> tuple[IntArray, IntArray]:
        """Return pairs of a row of `faces`, shape (m,), and a piece of its boundary that meets a box.

        The boxes have the corners `low` and `high`, shape (m, 3), in `part`, mm.
        """
        found, (first, begin, least, most) = [np.zeros((2, 0), dtype=np.int64)], self._blocks
        for row, block in items_in_chunks(first, faces, MOST_PAIRS):
            met = np.flatnonzero(are_met(least[:, block], most[:, block], low[row].T, high[row].T))
            for own, piece in items_in_chunks(begin, block[met], MOST_PAIRS):
                at, ends = row[met[own]], (self.p0[piece].T, self.p1[piece].T)
                near = are_met(np.minimum(*ends), np.maximum(*ends), low[at].T, high[at].T)
                found.append(np.stack([at[near], piece[near]]))
        row, piece = np.concatenate(found, axis=1)
        return row, piece

    @cached_property
    def _blocks(self) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
        """Blocks of pieces that follow each other: the first of each face, the first piece, and corners of each box."""
        counts = -(-np.diff(self.start) // BLOCK)
        first = np.concatenate([[0], np.cumsum(counts)])
        number = np.arange(first[-1]) - np.repeat(first[:-1], counts)
        begin = np.append(np.repeat(self.start[:-1], counts) + BLOCK * number, self.start[-1])
        least, most = (
            np.array([pick.reduceat(pick(self.p0[:, k], self.p1[:, k]), begin[:-1]) for k in range(3)])
            for pick in (np.minimum, np.maximum)
        )
        return first, begin, least, most

    def nearest_pieces(self, faces: IntArray, points: FloatArray) -> IntArray:
        """Return the piece of the boundary of each face, shape (m,), that is nearest to a point; -1 without a boundary.

        The points have shape (m, 3), in `part`, mm.
        """
        nearest = np.full(len(faces), -1)
        for row, piece in items_in_chunks(self.start, faces, MOST_PAIRS):
            off = distance_to_segments(points[row], self.p0[piece], self.p1[piece])
            order = np.lexsort((off, row))
            first = order[np.flatnonzero(np.diff(row[order], prepend=-1))]
            nearest[row[first]] = piece[first]
        return nearest

    def _crossings(
        self, faces: IntArray, uv: FloatArray, row: IntArray, piece: IntArray
    ) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
        """Return rows, relative v, run along u and rise away from the meridian of the pieces that cross it."""
        kind = self.graph.face_kind[faces]
        row, piece, u0, run = self._crossing(self._turning[faces], self._turned(faces, uv[:, 0]), row, piece)
        v0, rise = self.uv0[piece, 1] - uv[row, 1], self.uv1[piece, 1] - self.uv0[piece, 1]
        torus = kind[row] == SurfaceKind.TORUS
        rise = np.where(torus, wrap_angle(rise), rise)
        v = v0 - u0 / run * rise
        return row, np.where(torus, np.mod(v, 2 * np.pi), v), run, rise / run * np.sign(u0 + run / 2)

    def _crossing(
        self, turning: BoolArray, u: FloatArray, row: IntArray, piece: IntArray
    ) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
        """Return the pairs whose piece crosses the meridian u of its row, where it starts from there, and its run."""
        first, last = self._u
        at, a, b = u[row], first[piece], last[piece]
        flat = np.flatnonzero(((a <= at) != (b <= at)) & ~turning[row])
        round_ = np.flatnonzero(turning[row])
        u0, u1 = wrap_angle(a[round_] - at[round_]), wrap_angle(b[round_] - at[round_])
        crosses = ((u0 <= 0) != (u1 <= 0)) & (np.abs(u1 - u0) < np.pi)  # or it crosses the meridian on the far side
        kept = np.concatenate([flat, round_[crosses]])
        u0, u1 = u0[crosses], u1[crosses]
        return row[kept], piece[kept], np.append(a[flat] - at[flat], u0), np.append(b[flat] - a[flat], u1 - u0)

    @cached_property
    def _u(self) -> tuple[FloatArray, FloatArray]:
        """First parameters at the ends of each piece, each array in one block of memory."""
        faces = np.repeat(np.arange(self.graph.face_count), np.diff(self.start))
        return self._turned(faces, self.uv0[:, 0].copy()), self._turned(faces, self.uv1[:, 0].copy())

    @cached_property
    def _turning(self) -> BoolArray:
        """Whether the first parameter of each face goes round, shape (F,)."""
        return np.isin(self.graph.face_kind, PERIODIC_U) | (self._round[:, 1] > 0)

    @cached_property
    def _strips(self) -> Strips:
        """The pieces that may cross a meridian."""
        return Strips.of(self._turning, self.start, *self._u)

    def _turned(self, faces: IntArray, u: FloatArray) -> FloatArray:
        """Return first parameters as angles where a free-form face goes round, elsewhere as they are; shape (m,)."""
        low, whole = self._round[faces].T
        return np.where(whole > 0, (u - low) / np.where(whole > 0, whole, 1.0) * 2.0 * np.pi, u)

    @cached_property
    def _round(self) -> FloatArray:
        """Of free-form faces that are closed along u, where u begins and how far it goes; else 0 and 0; (F, 2)."""
        found = np.zeros((self.graph.face_count, 2))
        faces = np.flatnonzero(self.graph.face_kind == SurfaceKind.NURBS)
        if len(faces) == 0:
            return found
        of, nearest = self.graph.face_nurbs[faces], self.graph.nearest_on_nurbs
        low, whole = nearest.low[of, 0], nearest.high[of, 0] - nearest.low[of, 0]
        found[faces] = np.where(nearest.is_round[of], [low, whole], 0.0).T
        return found

    def _holds_meridian(self, faces: IntArray, u: FloatArray) -> BoolArray:
        """Tell which faces on closed surfaces contain the whole meridian at u, which their boundary does not cross.

        All points of such a meridian are on the same side, so one point is tested: that at the height of `_steepest`,
        against the next piece of boundary towards +u. The face lies to the left of a piece that runs towards +v. A
        meridian along which a piece runs does not count as contained.
        """
        inside, on_boundary = np.zeros(len(faces), dtype=bool), np.zeros(len(faces), dtype=bool)
        torus = self.graph.face_kind[faces] == SurfaceKind.TORUS
        for row, piece in items_in_chunks(self.start, faces, MOST_PAIRS):
            aside = (np.abs(wrap_angle(uv[piece, 0] - u[row])) for uv in (self.uv0, self.uv1))
            on_boundary[row[np.maximum(*aside) <= ON_MERIDIAN_RAD]] = True
            rise, v0 = self._rise[piece], self.uv0[piece, 1] - self._steepest[faces[row]]
            v0 = np.where(torus[row], wrap_angle(v0), v0)
            at = np.flatnonzero((v0 <= 0) != (v0 + rise <= 0))
            run = wrap_angle(self.uv1[piece[at], 0] - self.uv0[piece[at], 0])
            ahead = np.mod(self.uv0[piece[at], 0] - v0[at] / rise[at] * run - u[row[at]], 2 * np.pi)
            at = at[np.lexsort((ahead, row[at]))]
            nearest = at[np.flatnonzero(np.diff(row[at], prepend=-1))]
            inside[row[nearest]] = rise[nearest] > 0
        return inside & ~on_boundary

    @cached_property
    def _rise(self) -> FloatArray:
        """How far each piece runs along v, the nearest way round on a torus; shape (m,)."""
        rise = self.uv1[:, 1] - self.uv0[:, 1]
        torus = np.repeat(self.graph.face_kind == SurfaceKind.TORUS, np.diff(self.start))
        return np.where(torus, wrap_angle(rise), rise)

    @cached_property
    def _steepest(self) -> FloatArray:
        """Of each face on a closed surface, the v in the middle of the piece that runs farthest along v; shape (F,)."""
        v = np.zeros(self.graph.face_count)
        for face in np.flatnonzero(np.isin(self.graph.face_kind, CLOSED) & (np.diff(self.start) > 0)):
            piece = self.start[face] + int(np.argmax(np.abs(self._rise[self.start[face] : self.start[face + 1]])))
            v[face] = self.uv0[piece, 1] + self._rise[piece] / 2
        return v


_FIELDS = frozenset(one.name for one in fields(TrimmedFaces))
"""What a caller gives; all else on an object was computed from it."""


def _decide(inside: BoolArray, row: IntArray, v: FloatArray, run: FloatArray, away: FloatArray) -> None:
    """Decide by the next piece of boundary above each point; if there is none, by the next one below.

    A face lies to the left of its boundary: below a piece that runs towards -u, above a piece that runs towards +u. If
    no piece crosses the meridian of a point, the value of the point is left as it is.

    Where two pieces meet on the meridian and lie to one side of it (the leftmost point of a circle), the one that rises
    less on the way away from the meridian is the lower one.
    """
    for above in (False, True):  # a piece above overrides one below
        hit = np.flatnonzero((v > 0) == above)[::-1]  # of equally near ones the first is written last
        beside = v[hit] + SAME_PLACE * away[hit] / (1.0 + np.abs(away[hit]))
        beside, least = beside if above else -beside, np.full(len(inside), np.inf)
        np.minimum.at(least, row[hit], beside)
        nearest = hit[beside == least[row[hit]]]
        inside[row[nearest]] = (run[nearest] < 0) == above


def distance_to_segments(points: FloatArray, p0: FloatArray, p1: FloatArray) -> FloatArray:
    """Return the distance of each point to its own segment, shape (m,), mm.

    `points`, `p0`, `p1`: shape (m, 3). Points and ends of segments in one frame, mm.
    """
    d, r = p1 - p0, points - p0
    square = np.einsum("ki,ki->k", d, d)
    along = np.einsum("ki,ki->k", r, d)
    share = np.clip(along / np.where(square > 0, square, 1.0), 0.0, 1.0)
    off = r - share[:, None] * d
    return np.asarray(np.sqrt(np.einsum("ki,ki->k", off, off)), dtype=np.float64)


T = TypeVar("T")


def once_per_solid(find: Callable[[BrepGraph, TrimmedFaces, int], T]) -> Callable[[BrepGraph, TrimmedFaces, int], T]:
    """Let what is found about a solid be found once, and kept in `TrimmedFaces.known`."""

    @wraps(find)
    def found(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> T:
        key = (find.__qualname__, solid)
        if key not in trimmed.known:
            trimmed.known[key] = find(graph, trimmed, solid)
        known: T = trimmed.known[key]
        return known

    return found
