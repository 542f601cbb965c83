"""Pairs of a rounded face and another one, their cross-sections, and balls between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.meeting import meet_surfaces
from wpcal.brep.surfaces import project_to_faces, unit
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray

LEAST_SIN = 1e-3  #: Two faces nearer to parallel than this sine under the ball have no groove.
WIDE_HOLE = 2.0
"""A rounded face lies in a hollow one with a groove beside it if the radius of the hollow is this many times its own. A
pin in its hole is nearer."""
PIPES = (SurfaceKind.CYLINDER, SurfaceKind.TORUS)
OTHERS = (SurfaceKind.PLANE, SurfaceKind.CYLINDER, SurfaceKind.TORUS, SurfaceKind.CONE)
May: TypeAlias = Callable[[IntArray, IntArray], BoolArray]
"""Tells which pairs of faces of one solid may be of two members that are welded to each other."""


@dataclass(frozen=True, slots=True, eq=False)
class FacePairs(Columns):
    """Pairs of a rounded face and a face of another member, each with one side of the root."""

    #: `pipe`, `other`: shape (k,). The rounded face, and the other face.
    pipe: IntArray
    other: IntArray
    #: shape (k,). +1 or -1: the groove is on the side ``side * cross(x, m)`` of the root, with m from the centre to the
    #: root.
    side: FloatArray

    def __len__(self) -> int:
        return len(self.pipe)

    def is_ring(self, graph: BrepGraph) -> BoolArray:
        """Tell which rounded faces are tori; shape (k,)."""
        return np.asarray(graph.face_kind[self.pipe] == SurfaceKind.TORUS, dtype=bool)


@dataclass(frozen=True, slots=True, eq=False)
class Roots(Columns):
    """Cross-sections of grooves, shape (n, 3) or (n,): centre of the rounded face, directions, gap."""

    #: `centre`, `x`, `m`, `t`: shape (n, 3). The centre; the direction along the rounded face; from the centre to the
    #: root; from the root out of the groove.
    centre: FloatArray
    x: FloatArray
    m: FloatArray
    t: FloatArray
    gap_mm: FloatArray  #: shape (n,). Between the two faces at the root; negative where they overlap.
    tilt: FloatArray  #: shape (n,). Sine between the other face and x.
    radius_mm: FloatArray  #: shape (n,).


def find_groove_roots(graph: BrepGraph, pairs: FacePairs, s: FloatArray) -> Roots:
    """Return cross-sections of grooves. `s`: shape (n,). A place along each rounded face (`pipe_ranges`)."""
    frame, param = graph.face_frame[pairs.pipe], graph.face_param[pairs.pipe]
    o, ex, ey, ez = np.moveaxis(frame, 1, 0)
    ring = (graph.face_kind[pairs.pipe] == SurfaceKind.TORUS)[:, None]
    cos, sin, along = np.cos(s)[:, None], np.sin(s)[:, None], s[:, None]
    centre = o + np.where(ring, param[:, :1] * (cos * ex + sin * ey), along * ez)
    x = np.where(ring, cos * ey - sin * ex, ez)
    radius = np.where(ring[:, 0], param[:, 1], param[:, 0])
    foot = project_to_faces(graph, pairs.other, centre)
    height = np.einsum("ki,ki->k", centre - foot.p, foot.normal)
    tilt = np.einsum("ki,ki->k", foot.normal, x)
    m = unit(-foot.normal + tilt[:, None] * x)
    return Roots(centre, x, m, pairs.side[:, None] * np.cross(x, m), height - radius, np.abs(tilt), radius)


def pipe_ranges(
    graph: BrepGraph, trimmed: TrimmedFaces, pairs: FacePairs, gap_mm: float
) -> tuple[FloatArray, FloatArray]:
    """Return the places along the rounded faces between which the other faces are near; two arrays (k,).

    A place is a height along the axis of a cylinder (mm), or an angle about the axis of a torus (rad).
    """
    low, high = np.zeros(len(pairs)), np.full(len(pairs), 2.0 * np.pi)
    rows = np.flatnonzero(graph.face_kind[pairs.pipe] == SurfaceKind.CYLINDER)
    o, z = graph.face_frame[pairs.pipe[rows], 0], graph.face_frame[pairs.pipe[rows], 3]
    ends = []
    for face in (pairs.pipe[rows], pairs.other[rows]):
        box_low, box_high = (corner[face] for corner in trimmed.face_box)
        middle = np.einsum("ki,ki->k", (box_low + box_high) / 2 - o, z)
        half = np.einsum("ki,ki->k", (box_high - box_low) / 2, np.abs(z))
        ends.append((middle - half - gap_mm, middle + half + gap_mm))
    low[rows] = np.maximum(ends[0][0], ends[1][0])
    high[rows] = np.minimum(ends[0][1], ends[1][1])
    return low, high


def face_pairs(graph: BrepGraph, trimmed: TrimmedFaces, gap_mm: float, may: May | None = None) -> FacePairs:
    """Return the pairs of faces that may have a groove between them, both sides of each.

    They are of different solids, or `may` be of different members of one.
    """
    convex = graph.face_outward > 0
    pipes = np.flatnonzero(np.isin(graph.face_kind, PIPES) & convex)
    low, high = trimmed.face_box
    row, other = trimmed.box_tree.meeting(low[pipes] - gap_mm, high[pipes] + gap_mm)
    pipe = pipes[row]
    kind = graph.face_kind[other]
    kept = np.isin(kind, OTHERS) & ((may is not None) | (graph.face_solid[pipe] != graph.face_solid[other]))
    twice = np.isin(kind, PIPES) & convex[other]
    own = graph.face_kind[pipe]
    kept &= ~twice | (own > kind) | ((own == kind) & (pipe < other))  # a torus has the centre line
    pipe, other = pipe[kept], other[kept]
    hollow = (graph.face_kind[other] == SurfaceKind.CYLINDER) & ~convex[other]
    radius = np.where(graph.face_kind[pipe] == SurfaceKind.TORUS, graph.face_param[pipe, 1], graph.face_param[pipe, 0])
    wide = ~hollow | (graph.face_param[other, 0] >= WIDE_HOLE * radius)
    hollow_ring = ~convex[other] & np.isin(graph.face_kind[other], (SurfaceKind.TORUS, SurfaceKind.CONE))
    kept = wide & ~hollow_ring
    pipe, other = pipe[kept], other[kept]
    if may is not None:
        kept = graph.face_solid[pipe] != graph.face_solid[other]
        kept[~kept] = may(pipe[~kept], other[~kept])
        pipe, other = pipe[kept], other[kept]
    side = np.repeat([1.0, -1.0], len(pipe))
    return FacePairs(np.tile(pipe, 2), np.tile(other, 2), side)


def other_radii(graph: BrepGraph, pairs: FacePairs) -> FloatArray:
    """Return radii of the other faces in the cross-section, mm, shape (k,): hollow ones below 0, flat ones infinite."""
    kind, param = graph.face_kind[pairs.other], graph.face_param[pairs.other]
    radius = np.where(kind == SurfaceKind.TORUS, param[:, 1], param[:, 0]) * graph.face_outward[pairs.other]
    return np.where(np.isin(kind, PIPES), radius, np.inf)


def _in_section(graph: BrepGraph, pairs: FacePairs, roots: Roots, ball_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where balls are in the cross-sections, along m and t from the centre: exact between parallel faces."""
    reach, other = roots.radius_mm + ball_mm, other_radii(graph, pairs)
    flat = ~np.isfinite(other)
    other = np.where(flat, 1.0, other)
    apart = roots.radius_mm + roots.gap_mm + other
    round_ = (reach**2 - (other + ball_mm) ** 2 + apart**2) / (2.0 * np.where(apart == 0, np.inf, apart))
    up = np.where(flat, roots.radius_mm + roots.gap_mm - ball_mm, round_)
    return up, np.sqrt(np.maximum(reach**2 - up**2, 0.0))


def ball_centres(graph: BrepGraph, pairs: FacePairs, roots: Roots, ball_mm: FloatArray) -> FloatArray:
    """Return the centres of balls that touch both faces of pairs, shape (n, 3). In `part`, mm; NaN where there is none.

    `ball_mm`: ndarray, shape (n,).
    """
    up, out = _in_section(graph, pairs, roots, ball_mm)
    p0 = roots.centre + up[:, None] * roots.m + out[:, None] * roots.t
    p = meet_surfaces(graph, np.stack([pairs.pipe, pairs.other]), p0, roots.x, height_mm=ball_mm, least_sin=LEAST_SIN)
    beside = np.einsum("ki,ki->k", p - roots.centre, roots.t) > 0
    p[~beside] = np.nan
    return p
