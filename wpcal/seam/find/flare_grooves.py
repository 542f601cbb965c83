"""From flare grooves to edges and pieces of seams: the path of the ball's centre as an exact curve."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wpcal.brep.extend import FreeEdge, add_edges, arc, interpolated, line
from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.flare import FlareSearch, Grooves
from wpcal.seam.find.flare_ends import along_rims, exact_ends
from wpcal.seam.find.flare_sections import FacePairs, May, ball_centres, find_groove_roots
from wpcal.seam.find.flare_shape import measure_grooves
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.limits import LEAST_CANDIDATE_MM
from wpcal.seam.options import SeamOptions
from wpcal.seam.seam import FlareGroove, JointType, Seam, SeamPieces, WeldType

EXACT_MM = 1e-8
"""A path this near to a line or a circle at all its points is one: ten times the round-off on a part of one metre."""
ROUGH_POINTS = 5  #: Points of a path by which its length and its gap are estimated, and whether it is straight.
CURVE_POINTS = 129  #: Points of the spline through any other path: within 1e-7 mm of it on a quarter turn of 100 mm.


@dataclass(frozen=True, slots=True, eq=False)
class FlareGrooves:
    """Flare grooves as pieces of seams."""

    joined: JoinedPieces  #: The wall is the rounded face.
    groove: dict[int, FlareGroove]  #: The cross-section in the middle of each piece, by edge.

    def measured(self, seams: list[Seam]) -> list[Seam]:
        """Return seams along these pieces with the cross-section in their middle."""
        return [replace(seam, groove=self.groove[int(seam.pieces.edge[len(seam.pieces) // 2])]) for seam in seams]


NONE_FOUND = FlareGrooves(JoinedPieces.together([]), {})


def add_grooves(
    graph: BrepGraph, trimmed: TrimmedFaces, options: SeamOptions, may: May | None = None
) -> tuple[BrepGraph, FlareGrooves]:
    """Add the paths of balls in the flare grooves between members, as edges without faces of their own.

    `may`: As in `face_pairs`.
    """
    search = FlareSearch(graph, trimmed, options.gap_for(graph), may)
    found = search.find()
    if len(found.s0) == 0:
        return graph, NONE_FOUND
    s0, s1 = (exact_ends(search, found.pairs, s, found.ball_mm) for s in (found.s0, found.s1))
    s0, s1 = np.where(found.closed, found.s0, s0), np.where(found.closed, found.s1, s1)
    found = Grooves(found.pairs, s0, s1, found.closed, found.ball_mm)
    edges, kept = _paths(search, found)
    pairs, ball = found.pairs.select(kept), found.ball_mm[kept]
    roots = find_groove_roots(graph, pairs, (s0 + s1)[kept] / 2)
    shapes = measure_grooves(search, pairs, roots, ball)
    centres = ball_centres(search.graph, pairs, roots, ball)
    to_root = np.einsum("ki,ki->k", centres - roots.centre, roots.t)
    edges = [
        FreeEdge(e.kind, e.frame, e.param, e.span, e.nurbs, float(r))
        for e, r in zip(edges, shapes.mouth_mm, strict=True)
    ]
    wider, numbers = add_edges(graph, edges)
    both_round = np.isin(graph.face_kind[pairs.other], (SurfaceKind.CYLINDER, SurfaceKind.TORUS, SurfaceKind.CONE))
    both_round &= graph.face_outward[pairs.other] > 0
    t0, t1 = wider.edge_range[numbers].T
    gap = _gaps(search, found, np.flatnonzero(kept))
    pieces = SeamPieces(numbers, t0, t1, pairs.pipe, pairs.other, gap)
    words = [_words(both, on) for both, on in zip(both_round.tolist(), shapes.continues.tolist(), strict=True)]
    joined = JoinedPieces(pieces, tuple(joint for joint, _ in words), tuple(weld for _, weld in words))
    own = Grooves(pairs, s0[kept], s1[kept], found.closed[kept], ball)
    joined = along_rims(search, own, joined, shapes)
    grooves = {
        int(edge): FlareGroove(float(depth), float(opening), float(root))
        for edge, depth, opening, root in zip(
            joined.pieces.edge, shapes.depth_mm, shapes.opening_mm, to_root, strict=True
        )
    }
    return wider, FlareGrooves(joined, grooves)


def _words(is_between_radii: bool, continues: bool) -> tuple[JointType, WeldType]:
    """Return the words of ISO 17659 for the joint, and those of AWS A3.0 for the weld."""
    if is_between_radii:
        return JointType.BUTT, WeldType.FLARE_V
    return (JointType.TEE if continues else JointType.CORNER), WeldType.FLARE_BEVEL


def _paths(search: FlareSearch, found: Grooves) -> tuple[list[FreeEdge], BoolArray]:
    """Return the paths of the balls' centres, and which of the grooves they belong to: those that are long enough."""
    kept, edges = np.zeros(len(found.s0), dtype=bool), []
    sparse = _centres(search, found, np.arange(len(kept)), ROUGH_POINTS)
    length = np.linalg.norm(np.diff(sparse, axis=1), axis=2).sum(axis=1)
    for row in np.flatnonzero(length >= LEAST_CANDIDATE_MM).tolist():
        kept[row] = True
        straight = _straight(sparse[row])
        if straight is None:
            (p,) = _centres(search, found, np.array([row]), CURVE_POINTS)
            straight = _curve(search.graph, found.pairs.select(np.array([row])), p)
        edges.append(straight)
    return edges, kept


def _centres(search: FlareSearch, found: Grooves, rows: IntArray, count: int) -> FloatArray:
    """Return points evenly along the paths of balls, by the place along the rounded face; shape (k, count, 3)."""
    s = found.s0[rows, None] + (found.s1 - found.s0)[rows, None] * np.linspace(0.0, 1.0, count)
    row = np.repeat(rows, count)
    pairs = found.pairs.select(row)
    p = ball_centres(search.graph, pairs, find_groove_roots(search.graph, pairs, s.ravel()), found.ball_mm[row])
    return p.reshape(len(rows), count, 3)


def _gaps(search: FlareSearch, found: Grooves, rows: IntArray) -> FloatArray:
    """Return the least, mean and largest gap at the root of grooves, shape (k, 3), mm."""
    s = found.s0[rows, None] + (found.s1 - found.s0)[rows, None] * np.linspace(0.0, 1.0, ROUGH_POINTS)
    pairs = found.pairs.select(np.repeat(rows, ROUGH_POINTS))
    gap = np.maximum(find_groove_roots(search.graph, pairs, s.ravel()).gap_mm, 0.0).reshape(s.shape)
    return np.stack([gap.min(axis=1), gap.mean(axis=1), gap.max(axis=1)], axis=1)


def _straight(p: FloatArray) -> FreeEdge | None:
    """Return the line through points of one path, or None if they are on no line."""
    x = (p[-1] - p[0]) / max(float(np.linalg.norm(p[-1] - p[0])), EXACT_MM)
    off = p - p[0] - ((p - p[0]) @ x)[:, None] * x
    return line(p[0], p[-1]) if np.abs(off).max() <= EXACT_MM else None


def _curve(graph: BrepGraph, pairs: FacePairs, p: FloatArray) -> FreeEdge:
    """Return the circle or spline through points of one path."""
    for face in (pairs.pipe[0], pairs.other[0]):
        o, z = graph.face_frame[face, 0], graph.face_frame[face, 3]
        height = (p - o) @ z
        radius = np.linalg.norm(p - o - height[:, None] * z, axis=1)
        if np.ptp(height) <= EXACT_MM and np.ptp(radius) <= EXACT_MM:
            return arc(o + height.mean() * z, z, p, float(radius.mean()))
    return interpolated(p)
