"""How well a feature can be touched: sharp free corners and holes first, then what takes several touches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np

from wpcal.brep.concavity import LEAST_TURN_SIN, are_concave
from wpcal.brep.contact import CONTACT_GAP_MM
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.hits import START_MM, is_blocked
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray, numbered_rows
from wpcal.core.linked import near_tree
from wpcal.taught.features.corners import LEAST_SPREAD
from wpcal.taught.features.reference import POINT_KINDS, FeatureKind, ReferenceFeature

OPPOSITE_COS = 0.999  #: Two faces at a corner are against each other if their normals are opposite within 2.5 degrees.
LOOKING_OUT = (FeatureKind.HOLE, FeatureKind.BOSS, FeatureKind.SLOT)
"""Kinds whose direction points out of the part, towards the torch."""
LEAST_SUM = 1e-3  #: Normals whose sum is shorter than this cancel: they have no mean direction.
AT_VERTEX_MM = 1e-3  #: A feature is at a vertex if it is within this distance: the rounding for the names of features.


class Ease(IntEnum):
    """How well a feature can be touched; a smaller value is better."""

    SHARP = 0  #: A free convex corner or the free entry of a hole: one touch, or the tip centred by eye.
    ROUND = 1  #: The centre of a rim or a sphere: there is nothing to touch; several touches around it are necessary.
    HIDDEN = 2  #: A corner in a notch, against another solid, or behind one.
    VAGUE = 3
    """A point on an edge that nothing marks: the middle must be measured, and an end in a round cannot be felt."""
    INDIRECT = 4
    """Not a point of the part: a plane, an axis, or a place in the air that follows from touches on faces."""

    @property
    def word(self) -> str:
        """The ease in words, as in tables and JSON."""
        return self.name.lower()


@dataclass(frozen=True, slots=True, eq=False)
class Touchable:
    """A feature with the ease of touching it."""

    feature: ReferenceFeature
    ease: Ease


def judge_features(
    graph: BrepGraph, features: Sequence[ReferenceFeature], *, trimmed: TrimmedFaces | None = None
) -> tuple[Touchable, ...]:
    """Judge how well each feature of a part can be touched.

    A corner with fewer than three independent normals is vague. A corner in a notch or covered by the part is hidden,
    and so is the entry of a hole or slot, or the end of a boss, if the part is in front of it.

    Returns: In the order of the features.
    """
    trimmed = trimmed or TrimmedFaces.of(graph)
    ease = np.array([_usual_ease(feature.kind) for feature in features], dtype=np.int64)
    corners = [k for k, feature in enumerate(features) if feature.kind is FeatureKind.VERTEX]
    outward = [k for k, feature in enumerate(features) if feature.kind in LOOKING_OUT]
    p = np.array([feature.p_mm for feature in features]).reshape(-1, 3)
    if corners:
        vertex = _vertices(graph, [features[k] for k in corners])
        meetings = _Meetings.at(graph, vertex)
        free = _is_sharp(graph, vertex) & meetings.is_convex
        free &= ~_lies_on_another(graph, trimmed, vertex, meetings)
        free &= ~_is_covered(graph, trimmed, p[corners], meetings.outward)
        ease[np.array(corners)[~meetings.is_pointed]] = Ease.VAGUE
        ease[np.array(corners)[~free]] = Ease.HIDDEN
    if outward:
        out = np.array([features[k].direction for k in outward], dtype=np.float64)
        ease[np.array(outward)[_is_covered(graph, trimmed, p[outward], out)]] = Ease.HIDDEN
    return tuple(Touchable(feature, Ease(value)) for feature, value in zip(features, ease, strict=True))


def _usual_ease(kind: FeatureKind) -> Ease:
    """Return how well features of a kind can be touched if nothing is in the way."""
    if kind in (FeatureKind.VERTEX, FeatureKind.HOLE):
        return Ease.SHARP
    if kind not in POINT_KINDS:
        return Ease.INDIRECT
    return Ease.VAGUE if kind in (FeatureKind.EDGE_MIDPOINT, FeatureKind.EDGE_END) else Ease.ROUND


def _vertices(graph: BrepGraph, features: Sequence[ReferenceFeature]) -> IntArray:
    """Return the vertex of each corner: at its place, on its solid."""
    number = {name: k for k, name in enumerate(graph.solid_names)}
    solid = np.array([number.get(feature.solid, -1) for feature in features])
    p = np.array([feature.p_mm for feature in features])
    row, vertex = _within(graph.vertex_p, p, 2 * AT_VERTEX_MM)
    off = np.abs(graph.vertex_p[vertex] - p[row]).max(axis=1)
    off[graph.vertex_solid[vertex] != solid[row]] += AT_VERTEX_MM
    order = np.lexsort((vertex, off, row))
    first = np.searchsorted(row[order], np.arange(len(features)))
    return vertex[order][first]


def _within(points: FloatArray, places: FloatArray, radius: float) -> tuple[IntArray, IntArray]:
    """Return pairs of a place and a point within a distance of it, sorted by place, then point."""
    near = near_tree(places).query_ball_tree(near_tree(points), radius)
    row = np.repeat(np.arange(len(places)), [len(found) for found in near])
    return row, np.array([number for found in near for number in sorted(found)], dtype=np.int64)


def _is_sharp(graph: BrepGraph, vertex: IntArray) -> BoolArray:
    """Tell which vertices have no concave edge."""
    edges = np.flatnonzero((graph.edge_faces >= 0).all(axis=1) & ~graph.is_seam_edge)
    edges = edges[graph.edge_kind[edges] != CurveKind.DEGENERATE]
    at = graph.edge_vertices[edges[are_concave(graph, edges)]].ravel()
    return np.asarray(~np.isin(vertex, at))


@dataclass(frozen=True, eq=False)
class _Meetings:
    """The faces and edges that meet at each of n corners, including those of other solids with a corner there."""

    count: int  #: n.
    #: `face_corner`, `faces`: shape (f,). Sorted by corner; each face occurs once per corner.
    face_corner: IntArray
    faces: IntArray
    normals: FloatArray  #: shape (f, 3). Of these faces, outward, at the corner.
    end_corner: IntArray  #: shape (e,). Sorted.
    leaving: FloatArray  #: shape (e, 3). Unit directions of the edges away from the corner.

    @classmethod
    def at(cls, graph: BrepGraph, vertices: IntArray) -> _Meetings:
        """Collect the faces and edges at vertices, shape (n,)."""
        p = graph.vertex_p[vertices]
        is_end = (graph.edge_vertices >= 0) & (graph.edge_kind != CurveKind.DEGENERATE)[:, None]
        edge, end = np.nonzero(is_end)
        at, near = _within(graph.vertex_p, p, CONTACT_GAP_MM)
        pair, k = _joined(near, graph.edge_vertices[edge, end])
        corner, edge, end = at[pair], edge[k], end[k]
        _, slope = evaluate_edges(graph, edge, graph.edge_range[edge, end])
        leaving = slope * np.where(end == 0, 1.0, -1.0)[:, None]
        pair, coedge = _joined(edge, graph.coedge_edge)
        face_corner, faces = np.unique(np.stack([corner[pair], graph.coedge_face[coedge]]), axis=1)
        normals = project_to_faces(graph, faces, p[face_corner]).normal
        unit = leaving / np.linalg.norm(leaving, axis=1, keepdims=True)
        return cls(len(vertices), face_corner, faces, normals, corner, unit)

    @cached_property
    def is_free(self) -> BoolArray:
        """Whether each face has no other face against it."""
        one, other = _joined(self.face_corner, self.face_corner)
        against = np.einsum("ki,ki->k", self.normals[one], self.normals[other]) <= -OPPOSITE_COS
        return np.asarray(np.bincount(one[against], minlength=len(self.faces)) == 0)

    @property
    def is_convex(self) -> BoolArray:
        """Whether a face is free, and no edge rises above a free one."""
        free = np.flatnonzero(self.is_free)
        end, k = _joined(self.end_corner, self.face_corner[free])
        rises = np.einsum("ki,ki->k", self.leaving[end], self.normals[free[k]]) > LEAST_TURN_SIN
        convex = np.zeros(self.count, dtype=bool)
        convex[self.face_corner[free]] = True
        convex[self.end_corner[end[rises]]] = False
        return convex

    @property
    def is_pointed(self) -> BoolArray:
        """Whether the normals of the faces span space: a tip pressed into the corner stays there."""
        squares = np.zeros((self.count, 3, 3))
        np.add.at(squares, self.face_corner, self.normals[:, :, None] * self.normals[:, None, :])
        least = np.linalg.eigvalsh(squares)[:, 0]  # the square of the normals' least singular value
        return (np.bincount(self.face_corner, minlength=self.count) >= 3) & (least > LEAST_SPREAD**2)

    @property
    def outward(self) -> FloatArray:
        """Mean direction of the free faces' normals; zero where they cancel."""
        total = np.zeros((self.count, 3))
        np.add.at(total, self.face_corner[self.is_free], self.normals[self.is_free])
        return np.asarray(total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), LEAST_SUM))


def _joined(left: IntArray, right: IntArray) -> tuple[IntArray, IntArray]:
    """Return all pairs of a row of `left` and a row of `right` that hold the same number, in the order of `left`."""
    order = np.argsort(right, kind="stable")
    first = np.searchsorted(right[order], left, side="left")
    counts = np.searchsorted(right[order], left, side="right") - first
    row, step = numbered_rows(counts)
    return row, order[first[row] + step]


def _lies_on_another(graph: BrepGraph, trimmed: TrimmedFaces, vertex: IntArray, meetings: _Meetings) -> BoolArray:
    """Tell which vertices are on a face of another solid or its border, away from the corners of that solid."""
    p = graph.vertex_p[vertex]
    row, face = trimmed.box_tree.meeting(p - CONTACT_GAP_MM, p + CONTACT_GAP_MM)
    own = np.isin(row * graph.face_count + face, meetings.face_corner * graph.face_count + meetings.faces)
    other = ~own & (graph.face_solid[face] != graph.vertex_solid[vertex[row]])
    row, face = row[other], face[other]
    foot = project_to_faces(graph, face, p[row])
    close = np.linalg.norm(foot.p - p[row], axis=1) <= CONTACT_GAP_MM
    row, face, uv = row[close], face[close], foot.uv[close]
    on = trimmed.contains(face, uv) | (trimmed.boundary_distance(face, p[row]) <= CONTACT_GAP_MM)
    return np.isin(np.arange(len(vertex)), row[on])


def _is_covered(graph: BrepGraph, trimmed: TrimmedFaces, p: FloatArray, out: FloatArray) -> BoolArray:
    """Tell where the part itself is in the way outward, within the length of a torch."""
    return is_blocked(trimmed, p + START_MM * out, out)
