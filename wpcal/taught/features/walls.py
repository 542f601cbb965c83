"""Cylindrical walls and their ends: what holes, bosses, slots and axes are made of.

Words: a *line* is the axis of a cylinder of a solid. A *wall* is a set of faces of one cylinder that are connected
across edges. It is *hollow* if its outward normal points to the axis. Heights are measured along the axis from the
origin of `part`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.linked import linked_groups
from wpcal.taught.features.columns import AXIS_ROUND, NAMING_MM, first_rows, label_equal, positive_axes, sums

FULL_TURN_RAD = 2 * np.pi - 1e-3  #: Arcs whose sum is at least this make a whole circle.
EDGE_SAMPLES = 9
"""Samples per edge for its heights, at eighths of it: on a whole ellipse they include the ends of its axes."""
OPEN_LEAN = 0.1
"""A face beside an end opens or closes this end if its normal leans along the axis by more than this (6 degrees)."""
QUARTER_TURN_RAD = np.pi / 2
"""A border is all around if the gaps between its samples are narrower: a whole circle has a sample every eighth of a
turn."""


def sample_edges(graph: BrepGraph, edges: IntArray) -> FloatArray:
    """Return `EDGE_SAMPLES` parameters on each of m edges, ends included; shape (m, EDGE_SAMPLES)."""
    share = np.linspace(0.0, 1.0, EDGE_SAMPLES)
    return np.asarray(graph.edge_range[edges, :1] * (1 - share) + graph.edge_range[edges, 1:] * share)


@dataclass(frozen=True, eq=False)
class Coaxial:
    """Faces of revolution of some kinds, with the line of each one."""

    graph: BrepGraph
    faces: IntArray  #: shape (m,).
    line: IntArray  #: shape (m,). Equal for faces of one solid around one line.
    #: `foot`, `axis`: shape (m, 3). The point of the line nearest to the origin of `part`, and its direction as in
    #: `positive_axes`.
    foot: FloatArray
    axis: FloatArray

    @classmethod
    def of(cls, graph: BrepGraph) -> Coaxial:
        """Take the cylinders, cones and tori of a graph."""
        kinds = (SurfaceKind.CYLINDER, SurfaceKind.CONE, SurfaceKind.TORUS)
        faces = np.flatnonzero(np.isin(graph.face_kind, kinds))
        axis = positive_axes(graph.face_frame[faces, 3])
        origin = graph.face_frame[faces, 0]
        foot = origin - np.einsum("ki,ki->k", origin, axis)[:, None] * axis
        line = label_equal(graph.face_solid[faces], np.round(foot / NAMING_MM), np.round(axis / AXIS_ROUND))
        return cls(graph, faces, line, foot, axis)

    @cached_property
    def row(self) -> IntArray:
        """The row of each face of the graph, or -1; shape (F,)."""
        row = np.full(self.graph.face_count, -1, dtype=np.int64)
        row[self.faces] = np.arange(len(self.faces))
        return row


@dataclass(frozen=True, eq=False)
class Walls:
    """The cylindrical walls of a part."""

    coaxial: Coaxial
    of_face: IntArray  #: shape (F,). The wall of each face of the graph, or -1.
    first: IntArray  #: shape (w,). Row in `coaxial` of a wall's first face.

    @classmethod
    def of(cls, coaxial: Coaxial) -> Walls:
        """Join cylinder faces across the edges between them."""
        graph = coaxial.graph
        rows = np.flatnonzero(graph.face_kind[coaxial.faces] == SurfaceKind.CYLINDER)
        faces = coaxial.faces[rows]
        radius = np.round(graph.face_param[faces, 0] / NAMING_MM)
        same = np.full(graph.face_count, -1)
        same[faces] = label_equal(coaxial.line[rows], radius, graph.face_outward[faces])
        place = np.zeros(graph.face_count, dtype=np.int64)
        place[faces] = np.arange(len(faces))
        left, right = graph.edge_faces[(graph.edge_faces >= 0).all(axis=1)].T
        join = (same[left] >= 0) & (same[left] == same[right])
        label = linked_groups(len(faces), place[left[join]], place[right[join]])
        of_face = np.full(graph.face_count, -1, dtype=np.int64)
        of_face[faces] = label
        return cls(coaxial, of_face, rows[first_rows(label)])

    @cached_property
    def solid(self) -> IntArray:
        """The solid of each wall."""
        return self.coaxial.graph.face_solid[self.coaxial.faces[self.first]]

    @cached_property
    def line(self) -> IntArray:
        """The line of each wall."""
        return self.coaxial.line[self.first]

    @cached_property
    def foot(self) -> FloatArray:
        """The point of each wall's line nearest the origin."""
        return self.coaxial.foot[self.first]

    @cached_property
    def axis(self) -> FloatArray:
        """The direction of each wall's line."""
        return self.coaxial.axis[self.first]

    @cached_property
    def radius(self) -> FloatArray:
        """The radius of each wall, mm."""
        return np.asarray(self.coaxial.graph.face_param[self.coaxial.faces[self.first], 0], dtype=np.float64)

    @cached_property
    def is_hollow(self) -> BoolArray:
        """Whether the outward normal of each wall points to the axis."""
        return np.asarray(self.coaxial.graph.face_outward[self.coaxial.faces[self.first]] < 0)

    @cached_property
    def ends(self) -> WallEnds:
        """Where each wall begins and ends."""
        return WallEnds.of(self.coaxial.graph, self.of_face, self.axis)

    @cached_property
    def rims(self) -> Rims:
        """The whole circles that bound walls."""
        return Rims.of(self)

    @cached_property
    def turn(self) -> FloatArray:
        """How far each wall extends around its axis, rad: by its arcs, or a whole turn if its border is all around."""
        arcs = np.zeros(len(self.first))
        np.maximum.at(arcs, self.rims.all_wall, self.rims.all_turn)
        return np.where(self._widest_gap() < QUARTER_TURN_RAD, 2 * np.pi, arcs)

    def _widest_gap(self) -> FloatArray:
        """The widest angle about each wall's axis without a sample of its border, rad."""
        ends, graph = self.ends, self.coaxial.graph
        rows = np.flatnonzero(ends.is_border)
        t = sample_edges(graph, ends.edge[rows])
        p = evaluate_edges(graph, np.repeat(ends.edge[rows], EDGE_SAMPLES), t.ravel())[0]
        wall = np.repeat(ends.body[rows], EDGE_SAMPLES)
        frame = graph.face_frame[self.coaxial.faces[self.first]][wall]
        x, y = np.einsum("kai,ki->ak", frame[:, 1:3], p - frame[:, 0])
        angle = np.arctan2(y, x)
        order = np.lexsort((angle, wall))
        wall, angle = wall[order], angle[order]
        gap = np.full(len(self.first), 0.0)
        same = np.flatnonzero(np.diff(wall) == 0)
        np.maximum.at(gap, wall[same], np.diff(angle)[same])
        begin, end = np.flatnonzero(np.diff(wall, prepend=-1)), np.flatnonzero(np.diff(wall, append=-1))
        np.maximum.at(gap, wall[begin], angle[begin] + 2 * np.pi - angle[end])
        return gap


@dataclass(frozen=True, eq=False)
class WallEnds:
    """The edges of bodies, and what lies beyond their two ends; a body is a set of faces around one axis."""

    #: `body`, `edge`: shape (k,). One row per use of an edge by a body.
    body: IntArray
    edge: IntArray
    is_border: BoolArray  #: shape (k,). Whether the face on the other side does not belong to the body.
    beyond: IntArray  #: shape (k,). That face, or -1.
    #: shape (k,). Component along the axis of its outward normal at the middle of the edge; 0 without a face beyond.
    lean: FloatArray
    #: `middle`, `least`, `greatest`: shape (k,). Heights of each edge, mm.
    middle: FloatArray
    least: FloatArray
    greatest: FloatArray
    #: `low`, `high`: shape (n,). Heights of each body, mm.
    low: FloatArray
    high: FloatArray

    @classmethod
    def of(cls, graph: BrepGraph, body_of_face: IntArray, axis: FloatArray) -> WallEnds:
        """Measure bodies along their axes.

        `body_of_face`: shape (F,). -1 for a face without a body.
        `axis`: shape (n, 3). The axis of each body.
        """
        used = (body_of_face[graph.coedge_face] >= 0) & (graph.edge_kind[graph.coedge_edge] != CurveKind.DEGENERATE)
        face, edge = graph.coedge_face[used], graph.coedge_edge[used]
        body, faces = body_of_face[face], graph.edge_faces[edge]
        beyond = np.where(faces[:, 0] == face, faces[:, 1], faces[:, 0])
        is_border = (beyond < 0) | (body_of_face[beyond] != body)
        t = sample_edges(graph, edge)
        p = evaluate_edges(graph, np.repeat(edge, EDGE_SAMPLES), t.ravel())[0].reshape(-1, EDGE_SAMPLES, 3)
        height = np.einsum("ksi,ki->ks", p, axis[body])
        lean = np.zeros(len(edge))
        rows = np.flatnonzero(is_border & (beyond >= 0))
        normal = project_to_faces(graph, beyond[rows], p[rows, EDGE_SAMPLES // 2]).normal
        lean[rows] = np.einsum("ki,ki->k", normal, axis[body[rows]])
        least, greatest = height.min(axis=1), height.max(axis=1)
        low, high = np.full(len(axis), np.inf), np.full(len(axis), -np.inf)
        np.minimum.at(low, body, least)
        np.maximum.at(high, body, greatest)
        return cls(body, edge, is_border, beyond, lean, height[:, EDGE_SAMPLES // 2], least, greatest, low, high)

    def is_open(self) -> tuple[BoolArray, BoolArray]:
        """Tell whether each body is open below and above: a face beyond that end faces outward; two arrays (n,)."""
        at_low = self.is_border & (self.least <= self.low[self.body] + NAMING_MM) & (self.lean < -OPEN_LEAN)
        at_high = self.is_border & (self.greatest >= self.high[self.body] - NAMING_MM) & (self.lean > OPEN_LEAN)
        below, above = np.zeros(len(self.low), dtype=bool), np.zeros(len(self.low), dtype=bool)
        below[self.body[at_low]] = True
        above[self.body[at_high]] = True
        return below, above


@dataclass(frozen=True, eq=False)
class Rims:
    """Circles around the axes of walls, with the radius of the wall."""

    wall: IntArray  #: shape (r,). The wall of each whole circle.
    centre: FloatArray  #: shape (r, 3).
    #: `height`, `lean`: shape (r,). Along the axis of the wall; `lean` is that of the face beyond that leans most out
    #: of the wall, as in `WallEnds`.
    height: FloatArray
    lean: FloatArray
    is_upper: BoolArray  #: shape (r,). Whether the wall lies below the rim.
    #: shape (r,). Whether a torus follows beyond: its normal does not tell whether the end is open.
    meets_round: BoolArray
    #: `all_wall`, `all_turn`: The wall and the turn, rad, of every circle, whole or not.
    all_wall: IntArray
    all_turn: FloatArray

    @classmethod
    def of(cls, walls: Walls) -> Rims:
        """Collect the rims of walls."""
        graph, ends = walls.coaxial.graph, walls.ends
        centre, radius = graph.edge_frame[ends.edge, 0], walls.radius[ends.body]
        off = centre - walls.foot[ends.body]
        axis = walls.axis[ends.body]
        height = np.einsum("ki,ki->k", off, axis)
        aside = np.linalg.norm(off - height[:, None] * axis, axis=1)
        along = np.abs(np.einsum("ki,ki->k", graph.edge_frame[ends.edge, 3], axis))
        fits = ends.is_border & (graph.edge_kind[ends.edge] == CurveKind.CIRCLE) & (aside <= NAMING_MM)
        fits &= (along > 1 - AXIS_ROUND) & (np.abs(graph.edge_param[ends.edge, 0] - radius) <= NAMING_MM)
        rows = np.flatnonzero(fits)
        wall = ends.body[rows]
        label = label_equal(wall, np.round(height[rows] / NAMING_MM))
        first = first_rows(label)
        turn = sums(label, np.ptp(graph.edge_range[ends.edge[rows]], axis=1), len(first))
        whole = np.flatnonzero(turn >= FULL_TURN_RAD)
        is_upper = height[rows] >= (ends.low + ends.high)[wall] / 2 - NAMING_MM
        way = np.where(is_upper, 1.0, -1.0)
        most = np.full(len(first), -np.inf)
        np.maximum.at(most, label, way * ends.lean[rows])
        torus = (graph.face_kind[ends.beyond[rows]] == SurfaceKind.TORUS) & (ends.beyond[rows] >= 0)
        round_ = np.bincount(label, torus, minlength=len(first)) > 0
        at = rows[first[whole]]
        upper, lean = is_upper[first[whole]], most[whole]
        return cls(
            ends.body[at], centre[at], height[at], np.where(upper, lean, -lean), upper, round_[whole], wall[first], turn
        )

    @property
    def looks_out(self) -> BoolArray:
        """Whether a face beyond each rim faces away from its wall."""
        return np.asarray(np.where(self.is_upper, self.lean, -self.lean) > OPEN_LEAN)
