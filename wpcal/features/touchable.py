"""How well a feature can be touched: sharp free corners and holes first, then what takes several touches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.features.reference import POINT_KINDS, FeatureKind, ReferenceFeature
from wpcal.seam.concave import LEAST_TURN_SIN, are_concave
from wpcal.seam.reach import START_MM, is_blocked

CONTACT_MM = 0.5
"""A corner this near to another solid is no corner to the eye: the gap that a fillet bridges."""
OPPOSITE = 0.999
"""Faces whose normals are opposite within 2.5 degrees lie against each other."""
LEAST_SPREAD = 0.1
"""Least singular value of the normals at a corner: below it (at 8 degrees off smooth) the tip slides along an edge."""
LOOKING_OUT = (FeatureKind.HOLE, FeatureKind.BOSS, FeatureKind.SLOT)
"""Kinds whose direction points out to where the torch stands."""
SAME_MM = 1e-3
"""A feature is at a vertex when it lies within this: the rounding by which features are named."""


class Ease(IntEnum):
    """How well a feature can be touched; smaller is better."""

    SHARP = 0
    """A free convex corner or the free entry of a hole: one touch, or the tip centred by eye."""
    ROUND = 1
    """The centre of a rim or a sphere: nothing is there to touch, it takes several touches around it."""
    HIDDEN = 2
    """A corner in a notch, against another solid, or behind one."""
    VAGUE = 3
    """A point on an edge that nothing marks: its middle has to be measured out, its end in a round cannot be felt."""
    INDIRECT = 4
    """No point of the part: a plane or an axis, or a place in the air that touches on faces give."""

    @property
    def word(self) -> str:
        """The ease in words, as in tables and JSON."""
        return self.name.lower()


@dataclass(frozen=True, slots=True, eq=False)
class Touchable:
    """A feature with the ease of touching it.

    Parameters
    ----------
    feature : ReferenceFeature
    ease : Ease
    """

    feature: ReferenceFeature
    ease: Ease


def judge_features(
    graph: BrepGraph, features: Sequence[ReferenceFeature], *, trimmed: TrimmedFaces | None = None
) -> tuple[Touchable, ...]:
    """Judge how well each feature of a part can be touched.

    Parameters
    ----------
    graph : BrepGraph
    features : sequence of ReferenceFeature
        Of that graph.
    trimmed : TrimmedFaces, optional
        Of the same graph, where a caller has it already.

    Returns
    -------
    tuple of Touchable
        In the order of the features.

    Notes
    -----
    A corner of fewer than three independent normals is vague; a corner in a notch or covered, and the entry of a hole,
    a boss's end or a slot with the part itself before it, is hidden.
    """
    trimmed = trimmed or TrimmedFaces.of(graph)
    ease = np.array([usual_ease(feature.kind) for feature in features], dtype=np.int64)
    corners = [k for k, feature in enumerate(features) if feature.kind is FeatureKind.VERTEX]
    outward = [k for k, feature in enumerate(features) if feature.kind in LOOKING_OUT]
    p = np.array([feature.p_mm for feature in features]).reshape(-1, 3)
    if corners:
        vertex = _vertices(graph, [features[k] for k in corners])
        meetings = [_Meeting.at(graph, int(v)) for v in vertex]
        free = _is_sharp(graph, vertex) & np.array([meeting.is_convex for meeting in meetings])
        free &= ~_lies_on_another(graph, trimmed, vertex, meetings)
        free &= ~_is_covered(graph, trimmed, p[corners], np.array([meeting.outward for meeting in meetings]))
        smooth = np.array([not meeting.is_pointed for meeting in meetings])
        ease[np.array(corners)[smooth]] = Ease.VAGUE
        ease[np.array(corners)[~free]] = Ease.HIDDEN
    if outward:
        out = np.array([features[k].direction for k in outward], dtype=np.float64)
        ease[np.array(outward)[_is_covered(graph, trimmed, p[outward], out)]] = Ease.HIDDEN
    return tuple(Touchable(feature, Ease(value)) for feature, value in zip(features, ease, strict=True))


def usual_ease(kind: FeatureKind) -> Ease:
    """Return how well features of a kind can be touched where nothing is in the way."""
    if kind in (FeatureKind.VERTEX, FeatureKind.HOLE):
        return Ease.SHARP
    if kind not in POINT_KINDS:
        return Ease.INDIRECT
    return Ease.VAGUE if kind in (FeatureKind.EDGE_MIDPOINT, FeatureKind.EDGE_END) else Ease.ROUND


def _vertices(graph: BrepGraph, features: Sequence[ReferenceFeature]) -> IntArray:
    """The vertex of the graph that each corner is: at its place, on its solid."""
    solid = np.array([graph.solid_names.index(f.solid) if f.solid in graph.solid_names else -1 for f in features])
    off = np.array([np.abs(graph.vertex_p - f.p_mm).max(axis=1) for f in features])
    off[graph.vertex_solid[None, :] != solid[:, None]] += SAME_MM
    return np.asarray(off.argmin(axis=1), dtype=np.int64)


def _is_sharp(graph: BrepGraph, vertex: IntArray) -> BoolArray:
    """Tell which vertices have no concave edge."""
    edges = np.flatnonzero((graph.edge_faces >= 0).all(axis=1) & ~graph.is_seam_edge)
    edges = edges[graph.edge_kind[edges] != CurveKind.DEGENERATE]
    at = graph.edge_vertices[edges[are_concave(graph, edges)]].ravel()
    return np.asarray(~np.isin(vertex, at))


@dataclass(frozen=True, slots=True, eq=False)
class _Meeting:
    """The faces and edges that meet at a corner, those of other solids with a corner at the same place as well.

    Parameters
    ----------
    faces : ndarray of int, shape (f,)
    normals : ndarray, shape (f, 3)
        Outward, at the corner.
    leaving : ndarray, shape (e, 3)
        Unit directions of the edges away from the corner.
    """

    faces: IntArray
    normals: FloatArray
    leaving: FloatArray

    @classmethod
    def at(cls, graph: BrepGraph, vertex: int) -> _Meeting:
        """Gather what meets at a vertex."""
        here = np.linalg.norm(graph.vertex_p - graph.vertex_p[vertex], axis=1) <= CONTACT_MM
        ends = (
            here[graph.edge_vertices] & (graph.edge_vertices >= 0) & (graph.edge_kind != CurveKind.DEGENERATE)[:, None]
        )
        edge, end = np.nonzero(ends)
        _, slope = evaluate_edges(graph, edge, graph.edge_range[edge, end])
        leaving = slope * np.where(end == 0, 1.0, -1.0)[:, None]
        faces = np.unique(graph.coedge_face[np.isin(graph.coedge_edge, edge)])
        normals = project_to_faces(graph, faces, np.tile(graph.vertex_p[vertex], (len(faces), 1))).normal
        return cls(faces, normals, leaving / np.linalg.norm(leaving, axis=1, keepdims=True))

    @property
    def free(self) -> FloatArray:
        """Normals of the faces that no other face lies against."""
        return self.normals[(self.normals @ self.normals.T > -OPPOSITE).all(axis=1)]

    @property
    def is_convex(self) -> bool:
        """Whether no edge rises above a free face."""
        return len(self.free) > 0 and bool((self.leaving @ self.free.T <= LEAST_TURN_SIN).all())

    @property
    def is_pointed(self) -> bool:
        """Whether the faces' normals span space: a tip that is pressed against them stays where it is."""
        return len(self.normals) >= 3 and bool(np.linalg.svd(self.normals, compute_uv=False)[-1] > LEAST_SPREAD)

    @property
    def outward(self) -> FloatArray:
        """Mean direction of the free faces' normals; zero where they cancel."""
        total = self.free.sum(axis=0)
        return np.asarray(total / max(float(np.linalg.norm(total)), SAME_MM))


def _lies_on_another(
    graph: BrepGraph, trimmed: TrimmedFaces, vertex: IntArray, meetings: Sequence[_Meeting]
) -> BoolArray:
    """Tell which vertices lie on a face of another solid, or on its border, away from that solid's own corners."""
    low, high = trimmed.face_box
    p = graph.vertex_p[vertex]
    near = np.array(((p[:, None] >= low - CONTACT_MM) & (p[:, None] <= high + CONTACT_MM)).all(axis=2), dtype=bool)
    for k, meeting in enumerate(meetings):
        near[k, meeting.faces] = False
    row, face = np.nonzero(near & (graph.face_solid != graph.vertex_solid[vertex][:, None]))
    foot = project_to_faces(graph, face, p[row])
    close = np.linalg.norm(foot.p - p[row], axis=1) <= CONTACT_MM
    row, face, uv = row[close], face[close], foot.uv[close]
    on = trimmed.contains(face, uv) | (trimmed.boundary_distance(face, p[row]) <= CONTACT_MM)
    return np.isin(np.arange(len(vertex)), row[on])


def _is_covered(graph: BrepGraph, trimmed: TrimmedFaces, p: FloatArray, out: FloatArray) -> BoolArray:
    """Tell where the part itself stands in the way outward, for the length of a torch."""
    return is_blocked(graph, trimmed, p + START_MM * out, out)
