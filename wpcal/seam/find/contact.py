"""Where an edge of one solid lies on a face of another: the contact edges along which two members can be welded."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from wpcal.brep.curves import edge_polylines, evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.strips import items_of
from wpcal.brep.surfaces import Foot, project_to_faces
from wpcal.brep.trim import TrimmedFaces, distance_to_segments
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray, blocks
from wpcal.core.last_held import last_held
from wpcal.seam.limits import FLUSH_MM, GAP_ROUND_OFF_MM, LEAST_CANDIDATE_MM

CONTACT_SAMPLES = 33
"""Points at which an edge is compared with a face, inside the box of the face: a contact over 1/32 of it is found."""
HALVINGS = 34  #: Of the end of a contact: from the 31 mm between samples of an edge of 1000 mm to 2e-9 mm.
INWARD = 3
"""A contact crosses the boundary of a face if one of this many samples behind its outermost one is well inside the
face. On an arc of 16 mm, one sample may be beyond the boundary by less than the gap, and the next one on it. A contact
along the boundary has many samples in a row that are not inside."""
PARAMETER_ROUND_OFF = 1e-12  #: Relative round-off of an interpolated parameter.
CHUNK = 100_000  #: Points compared with faces in one array: about 50 MB.


@dataclass(frozen=True, slots=True, eq=False)
class EdgeContacts(Columns):
    """Intervals of edges that lie on faces of other solids."""

    #: `edge`, `face`: shape (k,).
    edge: IntArray
    face: IntArray
    #: `t0`, `t1`: shape (k,). Parameters on the edge, t0 < t1.
    t0: FloatArray
    t1: FloatArray
    gap_mm: FloatArray  #: shape (k, 3). Least, mean and largest distance of the edge from the face.
    #: shape (k,). The face of the member that is the wall, where the members touch along a line only. By default the
    #: wall is the face that is not opposed to the touched one.
    wall: IntArray | None = None


def find_edge_contacts(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    *,
    gap_mm: float,
    edges: IntArray | None = None,
    pairs: tuple[IntArray, IntArray] | None = None,
) -> EdgeContacts:
    """Find every interval of an edge that lies on a face of another solid within a gap.

    `gap_mm`: Largest distance between edge and face, mm.
    `edges`: shape (n,). Only these edges; all by default.
    `pairs`: shape (k,). Only these edges and faces, some of `candidate_pairs`; all by default.

    Returns: EdgeContacts. Ends are refined by bisection on the exact edge; a flush contact ends at the corner of the
    face.

    Cost: the number of pairs whose boxes meet, times `CONTACT_SAMPLES` points, in array operations.
    """
    edge, face = candidate_pairs(graph, trimmed, gap_mm) if pairs is None else pairs
    if edges is not None:
        asked = np.isin(edge, edges)
        edge, face = edge[asked], face[asked]
    low, high = clipped_range(graph, trimmed, edge, face, gap_mm)
    keep = high > low
    edge, face, low, high = edge[keep], face[keep], low[keep], high[keep]
    t = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, CONTACT_SAMPLES)
    on = _Touching(graph, trimmed, gap_mm)
    touching, deep = on.states(edge, face, t)
    pair, first, last = find_runs(touching)
    t0 = on.refine_end(edge[pair], face[pair], t[pair], deep[pair], first, -1)
    t1 = on.refine_end(edge[pair], face[pair], t[pair], deep[pair], last, +1)
    e, f = edge[pair], face[pair]
    chord = np.linalg.norm(evaluate_edges(graph, e, t1)[0] - evaluate_edges(graph, e, t0)[0], axis=1)
    middle = np.linalg.norm(evaluate_edges(graph, e, (t0 + t1) / 2)[0] - evaluate_edges(graph, e, t0)[0], axis=1)
    long_enough = np.maximum(chord, middle) >= max(LEAST_CANDIDATE_MM, 2.0 * gap_mm)
    kept = long_enough | _joins_others(graph, e, f, t0, t1, long_enough)
    e, f, t0, t1 = e[kept], f[kept], t0[kept], t1[kept]
    return EdgeContacts(e, f, t0, t1, _gaps(graph, e, f, t0, t1))


def _joins_others(
    graph: BrepGraph, edge: IntArray, face: IntArray, t0: FloatArray, t1: FloatArray, others: BoolArray
) -> BoolArray:
    """Tell which contacts are whole edges both of whose vertices end one of the `others` between the same solids.

    Such a short edge (a sliver between two faces) continues a seam; by itself it would not be one.
    """
    low, high = graph.edge_range[edge].T
    reach = PARAMETER_ROUND_OFF * (1.0 + np.abs(graph.edge_range[edge]).max(axis=1))
    whole = (np.abs(t0 - low) <= reach) & (np.abs(t1 - high) <= reach)
    key = graph.edge_vertices[edge] * len(graph.solid_names) + graph.face_solid[face][:, None]
    both = np.isin(key, key[others]).all(axis=1)
    return np.asarray(whole & ~others & both, dtype=bool)


def candidate_pairs(
    graph: BrepGraph, trimmed: TrimmedFaces, gap_mm: float, *, seam_edges: bool = False, edges: IntArray | None = None
) -> tuple[IntArray, IntArray]:
    """Return pairs of an edge and a face of different solids whose boxes come nearer than the gap.

    `seam_edges` includes edges that close a face onto itself.
    `edges`: shape (n,). Only these edges; all by default.
    """
    real = (graph.edge_kind != CurveKind.DEGENERATE) & (graph.edge_solid >= 0)
    usable = np.flatnonzero(real if seam_edges else real & ~graph.is_seam_edge)
    usable = usable if edges is None else np.intersect1d(usable, edges)
    low, high = edge_boxes(graph)
    row, face = trimmed.box_tree.meeting(low[usable] - gap_mm, high[usable] + gap_mm)
    edge = usable[row]
    apart = graph.edge_solid[edge] != graph.face_solid[face]
    edge, face = edge[apart], face[apart]
    order = np.lexsort((face, edge, graph.edge_solid[edge]))
    return edge[order], face[order]


def edge_boxes(graph: BrepGraph) -> tuple[FloatArray, FloatArray]:
    """Return the least and greatest corner of the polyline of each edge, two arrays (E, 3), mm."""
    start, _, points = edge_polylines(graph)
    low, high = np.full((graph.edge_count, 3), np.inf), np.full((graph.edge_count, 3), -np.inf)
    edges = np.repeat(np.arange(graph.edge_count), np.diff(start))
    np.minimum.at(low, edges, points)
    np.maximum.at(high, edges, points)
    return low, high


def clipped_range(
    graph: BrepGraph, trimmed: TrimmedFaces, edge: IntArray, face: IntArray, gap_mm: float
) -> tuple[FloatArray, FloatArray]:
    """Return the parameter range of each edge; that of a straight edge is clipped to the box of the face.

    Clipping keeps the samples close, so that a short contact on a long edge is not missed.

    `edge`, `face`: shape (k,). Pairs.
    Returns `low, high`: ndarray, shape (k,). Parameters; low > high if the edge misses the box.
    """
    low, high = graph.edge_range[edge].T.copy()
    rows = graph.edge_kind[edge] == CurveKind.LINE
    box_low, box_high = (corner[face] for corner in trimmed.face_box)
    o, d = graph.edge_frame[edge, 0], graph.edge_frame[edge, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (box_low - gap_mm - o) / d, (box_high + gap_mm - o) / d
    a, b = np.where(d == 0, -np.inf, a), np.where(d == 0, np.inf, b)
    low = np.where(rows, np.maximum(low, np.minimum(a, b).max(axis=1)), low)
    high = np.where(rows, np.minimum(high, np.maximum(a, b).min(axis=1)), high)
    return low, high


def find_runs(on: BoolArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return the row and the first and last column of every run of true values longer than one; shape (m, n)."""
    change = np.diff(np.pad(on, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, first = np.nonzero(change == 1)
    last = np.nonzero(change == -1)[1] - 1
    long = last > first
    return row[long], first[long], last[long]


@dataclass(frozen=True, slots=True, eq=False)
class _Touching:
    """Tells whether points of edges touch faces, and where along an edge that ends."""

    graph: BrepGraph
    trimmed: TrimmedFaces
    gap_mm: float

    def states(self, edge: IntArray, face: IntArray, t: FloatArray) -> tuple[BoolArray, BoolArray]:
        """Compare points of edges, at parameters t (k, n), with one face per edge.

        Returns `touching`: ndarray of bool, shape (k, n). Within the gap of the trimmed face.
        Returns `deep`: ndarray of bool, shape (k, n). Within the gap, and the nearest point well inside the face.
        """
        touching, deep = np.zeros(t.shape, dtype=bool), np.zeros(t.shape, dtype=bool)
        rows = max(1, CHUNK // t.shape[1])
        for own in (slice(first, first + rows) for first in range(0, len(t), rows)):
            touching[own], deep[own] = self._states(edge[own], face[own], t[own])
        return touching, deep

    def _states(self, edge: IntArray, face: IntArray, t: FloatArray) -> tuple[BoolArray, BoolArray]:
        columns = t.shape[1]
        faces = np.repeat(face, columns)
        near, foot = self._near(np.repeat(edge, columns), faces, t.ravel())
        rows = np.flatnonzero(near)
        inside, close, flush = (np.zeros(t.size, dtype=bool) for _ in range(3))
        inside[rows] = self.trimmed.contains(faces[rows], foot.uv[rows])
        distance = self.trimmed.boundary_distance(
            faces[rows], foot.p[rows], group=rows // columns, within_mm=max(self.gap_mm, FLUSH_MM)
        )
        close[rows], flush[rows] = distance <= self.gap_mm, distance <= FLUSH_MM
        return (inside | close).reshape(t.shape), (inside & ~flush).reshape(t.shape)

    def _near(self, edge: IntArray, face: IntArray, t: FloatArray) -> tuple[BoolArray, Foot]:
        points = evaluate_edges(self.graph, edge, t)[0]
        foot = project_to_faces(self.graph, face, points)
        return np.linalg.norm(foot.p - points, axis=1) <= self.gap_mm + GAP_ROUND_OFF_MM, foot

    def refine_end(
        self, edge: IntArray, face: IntArray, t: FloatArray, deep: BoolArray, at: IntArray, way: int
    ) -> FloatArray:
        """Find where contacts end beyond their outermost touching sample.

        `edge`, `face`: ndarray of int, shape (k,)
        `t`: shape (k, CONTACT_SAMPLES). Parameters of the samples.
        `deep`: ndarray of bool, shape (k, CONTACT_SAMPLES)
        `at`: shape (k,). Column of the outermost touching sample.
        `way`: -1 for the start, +1 for the end.
        """
        rows = np.arange(len(edge))
        anchor = at.copy()
        for step in range(1, INWARD + 1):
            anchor = np.where(deep[rows, anchor], anchor, np.clip(at - step * way, 0, CONTACT_SAMPLES - 1))
        crosses = deep[rows, anchor]
        end: FloatArray = self.graph.edge_range[edge, (way + 1) // 2].copy()
        inner = np.abs(t[rows, at] - end) > PARAMETER_ROUND_OFF * (1.0 + np.abs(end))
        beyond = t[rows, np.clip(at + way, 0, CONTACT_SAMPLES - 1)]
        cut, flush = np.flatnonzero(inner & crosses), np.flatnonzero(inner & ~crosses)
        inside = partial(self._is_inside, edge[cut], face[cut])
        end[cut] = last_held(t[cut, anchor[cut]], beyond[cut], inside, halvings=HALVINGS)[0]
        end[flush] = self._flush_end(edge[flush], face[flush], t[flush, at[flush]], beyond[flush])
        end[flush] = self._at_corners(edge[flush], face[flush], end[flush])
        return end

    def _is_inside(self, edge: IntArray, face: IntArray, row: IntArray, t: FloatArray) -> BoolArray:
        near, foot = self._near(edge[row], face[row], t)
        return near & self.trimmed.contains(face[row], foot.uv)

    def _flush_end(self, edge: IntArray, face: IntArray, good: FloatArray, bad: FloatArray) -> FloatArray:
        """Find where edges along the boundaries of faces no longer touch them, between two parameters."""
        ends = np.stack([evaluate_edges(self.graph, edge, t)[0] for t in (good, bad)])
        room = self.gap_mm + np.linalg.norm(ends[1] - ends[0], axis=1)[:, None]  # an arc between them stays in it
        row, piece = self.trimmed.pieces_meeting(face, ends.min(axis=0) - room, ends.max(axis=0) + room)
        start = np.searchsorted(row, np.arange(len(face) + 1))
        p0, p1 = self.trimmed.p0[piece], self.trimmed.p1[piece]

        def touches(own: IntArray, t: FloatArray) -> BoolArray:
            near, foot = self._near(edge[own], face[own], t)
            of, at = items_of(start, own)
            off = np.full(len(t), np.inf)
            np.minimum.at(off, of, distance_to_segments(foot.p[of], p0[at], p1[at]))
            touching = near & (off <= self.gap_mm)
            other = np.flatnonzero(near & ~touching)
            touching[other] = self.trimmed.contains(face[own[other]], foot.uv[other])
            return touching

        return last_held(good, bad, touches, halvings=HALVINGS)[0]

    def _at_corners(self, edge: IntArray, face: IntArray, t: FloatArray) -> FloatArray:
        """Move the ends of flush contacts on straight edges to the nearest corner of the face, where they end."""
        t = t.copy()
        points = evaluate_edges(self.graph, edge, t)[0]
        for row in np.flatnonzero(self.graph.edge_kind[edge] == CurveKind.LINE):
            corners = self.trimmed.p0[self.trimmed.start[face[row]] : self.trimmed.start[face[row] + 1]]
            off = np.linalg.norm(corners - points[row], axis=1)
            nearest = int(np.argmin(off))
            if off[nearest] <= 2.0 * self.gap_mm:
                frame = self.graph.edge_frame[edge[row]]
                t[row] = float((corners[nearest] - frame[0]) @ frame[1])
        return t


def _gaps(graph: BrepGraph, edge: IntArray, face: IntArray, t0: FloatArray, t1: FloatArray) -> FloatArray:
    """Return the least, mean and largest distance of intervals of edges from faces, shape (k, 3), mm."""
    gaps = np.zeros((len(edge), 3))
    for own in blocks(len(edge), CHUNK // CONTACT_SAMPLES):
        t = t0[own, None] + (t1 - t0)[own, None] * np.linspace(0.0, 1.0, CONTACT_SAMPLES)
        points = evaluate_edges(graph, np.repeat(edge[own], CONTACT_SAMPLES), t.ravel())[0]
        foot = project_to_faces(graph, np.repeat(face[own], CONTACT_SAMPLES), points)
        off = np.linalg.norm(foot.p - points, axis=1).reshape(t.shape)
        gaps[own] = np.stack([off.min(axis=1), off.mean(axis=1), off.max(axis=1)], axis=1)
    return gaps
