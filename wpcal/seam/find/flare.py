"""Flare grooves: where a rounded face of one member runs smoothly onto a face of another, and the two open outwards.

A square tube has rounded edges. Its flat side touches another member, and beside the contact its radius leaves the
other face slowly: a plane against a radius is a *flare-bevel* groove, two radii are a *flare-V* groove. A round bar on
a plate has two such grooves. No edge need run along them.

The rounded face is a cylinder or a torus, so it has a centre line a(s) with the direction x(s) and a radius r. In the
plane across x the *root* of the groove is where the other face is nearest to a. A ball that rolls along the groove and
touches both faces gives the seam: its centre is at the height R above both (`brep.meeting`). A torch is pushed into the
groove until its wire touches both faces, so R is half a wire; or until its nozzle does, and then R is larger.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.meeting import meet_surfaces
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.limits import FLUSH_MM
from wpcal.seam.torch import USUAL_TORCH

BALLS_MM = (0.6, 1.0, 1.5)
"""Radii of balls: half of a wire of 1.2 mm, the usual one of robots, and larger ones. Those are needed where the wall
of a tube ends before the root, so that a thin wire would fall through. The largest one bridges 3 mm, the usual root gap
of a bevel groove."""
LEAST_SHARE = 0.5
"""The first of these balls is taken that touches both faces along this share of what the best one does: a thin wire
that falls into a tube still lies in the corners of the tube."""
MOST_BALL_MM = 3.0
"""Where a nozzle has no room, the wire ends farther out, in a ball of at most this radius: a bead bridges 6 mm."""
TILT_SIN = 0.02
"""The other face runs along the rounded one if the sine between the two is below this (1.1 degrees). Two bars that
cross touch at a point; there the sine is small over less than 1 mm."""
SAMPLES = 33
"""Places along a rounded face at which it is compared with another one, inside the box of the other face."""
TURN_SAMPLES = 129
"""The same round a whole torus."""
BISECTIONS = 40
"""Bisections of an end: from 31 mm between samples to 3e-11 mm."""
LEAST_SIN = 1e-3
"""Two faces nearer to parallel than this sine under the ball have no groove."""
WIDE_HOLE = 2.0
"""A rounded face lies in a hollow one with a groove beside it if the radius of the hollow is this many times its own. A
pin in its hole is nearer."""
CHUNK = 20_000
"""Points compared in one array: about 20 MB."""
PIPES = (SurfaceKind.CYLINDER, SurfaceKind.TORUS)
OTHERS = (SurfaceKind.PLANE, SurfaceKind.CYLINDER, SurfaceKind.TORUS, SurfaceKind.CONE)


@dataclass(frozen=True, slots=True, eq=False)
class FacePairs:
    """Pairs of a rounded face and a face of another solid, each with one side of the root.

    Parameters
    ----------
    pipe, other : ndarray of int, shape (k,)
        The rounded face, and the other face.
    side : ndarray, shape (k,)
        +1 or -1: the groove is on the side ``side * cross(x, m)`` of the root, with m from the centre to the root.
    """

    pipe: IntArray
    other: IntArray
    side: FloatArray

    def __len__(self) -> int:
        return len(self.pipe)

    def select(self, rows: IntArray | BoolArray) -> FacePairs:
        """Return the pairs at `rows`: integers, or a mask of shape (k,)."""
        return FacePairs(self.pipe[rows], self.other[rows], self.side[rows])

    def is_ring(self, graph: BrepGraph) -> BoolArray:
        """Tell which rounded faces are tori; shape (k,)."""
        return np.asarray(graph.face_kind[self.pipe] == SurfaceKind.TORUS, dtype=bool)


@dataclass(frozen=True, slots=True, eq=False)
class Roots:
    """Cross-sections of grooves, shape (n, 3) or (n,): centre of the rounded face, directions, gap.

    Parameters
    ----------
    centre, x, m, t : ndarray, shape (n, 3)
        The centre; the direction along the rounded face; from the centre to the root; from the root out of the groove.
    gap_mm : ndarray, shape (n,)
        Between the two faces at the root; negative where they overlap.
    tilt : ndarray, shape (n,)
        Sine between the other face and x.
    radius_mm : ndarray, shape (n,)
    """

    centre: FloatArray
    x: FloatArray
    m: FloatArray
    t: FloatArray
    gap_mm: FloatArray
    tilt: FloatArray
    radius_mm: FloatArray


def find_roots(graph: BrepGraph, pairs: FacePairs, s: FloatArray) -> Roots:
    """Return cross-sections of grooves.

    Parameters
    ----------
    graph : BrepGraph
    pairs : FacePairs
        n pairs.
    s : ndarray, shape (n,)
        A place along each rounded face (`pipe_ranges`).
    """
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
    m = -foot.normal + tilt[:, None] * x
    length = np.linalg.norm(m, axis=1, keepdims=True)
    m /= np.where(length > 0, length, 1.0)
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


def face_pairs(graph: BrepGraph, trimmed: TrimmedFaces, gap_mm: float) -> FacePairs:
    """Return the pairs of faces of different solids that may have a groove between them, both sides of each."""
    convex = graph.face_outward > 0
    pipes = np.flatnonzero(np.isin(graph.face_kind, PIPES) & convex)
    low, high = trimmed.face_box
    row, other = trimmed.box_tree.meeting(low[pipes] - gap_mm, high[pipes] + gap_mm)
    pipe = pipes[row]
    kind = graph.face_kind[other]
    kept = (graph.face_solid[pipe] != graph.face_solid[other]) & np.isin(kind, OTHERS)
    twice = np.isin(kind, PIPES) & convex[other]
    kept &= ~twice | (pipe < other)
    pipe, other = pipe[kept], other[kept]
    hollow = (graph.face_kind[other] == SurfaceKind.CYLINDER) & ~convex[other]
    radius = np.where(graph.face_kind[pipe] == SurfaceKind.TORUS, graph.face_param[pipe, 1], graph.face_param[pipe, 0])
    wide = ~hollow | (graph.face_param[other, 0] >= WIDE_HOLE * radius)
    hollow_ring = ~convex[other] & np.isin(graph.face_kind[other], (SurfaceKind.TORUS, SurfaceKind.CONE))
    kept = wide & ~hollow_ring
    pipe, other = pipe[kept], other[kept]
    side = np.repeat([1.0, -1.0], len(pipe))
    return FacePairs(np.tile(pipe, 2), np.tile(other, 2), side)


@dataclass(frozen=True, slots=True, eq=False)
class Grooves:
    """Stretches of grooves: pairs of faces, and from where to where along the rounded face.

    Parameters
    ----------
    pairs : FacePairs
        n pairs.
    s0, s1 : ndarray, shape (n,)
    closed : ndarray of bool, shape (n,)
        Whether the stretch goes once round a torus.
    ball_mm : ndarray, shape (n,)
        Radius of the ball that touches both faces.
    """

    pairs: FacePairs
    s0: FloatArray
    s1: FloatArray
    closed: BoolArray
    ball_mm: FloatArray

    @staticmethod
    def joined(parts: list[Grooves]) -> Grooves:
        """Return all stretches of `parts` in one."""
        pipe, other, side = (
            np.concatenate([getattr(part.pairs, name) for part in parts]) for name in FacePairs.__slots__
        )
        columns = [np.concatenate([getattr(part, name) for part in parts]) for name in Grooves.__slots__[1:]]
        return Grooves(FacePairs(pipe, other, side), *columns)


NO_GROOVES = Grooves(
    FacePairs(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0)),
    np.zeros(0),
    np.zeros(0),
    np.zeros(0, dtype=bool),
    np.zeros(0),
)


@dataclass(frozen=True, slots=True, eq=False)
class FlareSearch:
    """Finds the stretches along which a ball touches both faces of a pair.

    Parameters
    ----------
    graph, trimmed :
        The part.
    gap_mm : float
        Largest gap between the members at the root.
    """

    graph: BrepGraph
    trimmed: TrimmedFaces
    gap_mm: float

    def find(self) -> Grooves:
        """Return the grooves of a part, their ends on the polylines of the boundaries."""
        pairs = face_pairs(self.graph, self.trimmed, self.gap_mm)
        low, high = pipe_ranges(self.graph, self.trimmed, pairs, self.gap_mm)
        kept = high > low
        pairs, low, high = pairs.select(kept), low[kept], high[kept]
        ring = pairs.is_ring(self.graph)
        found = []
        for rows, count in ((~ring, SAMPLES), (ring, TURN_SAMPLES)):
            s = low[rows, None] + (high - low)[rows, None] * np.linspace(0.0, 1.0, count)
            found += self._among(pairs.select(rows), s)
        return Grooves.joined(found) if found else NO_GROOVES

    def _among(self, pairs: FacePairs, s: FloatArray) -> list[Grooves]:
        """Return the stretches of pairs (k,) among samples s (k, n), each with the ball that suits it."""
        step = max(1, CHUNK // s.shape[1])
        near = np.zeros(s.shape, dtype=bool)
        for own in (slice(first, first + step) for first in range(0, len(pairs), step)):
            rows = np.repeat(np.arange(len(pairs))[own], s.shape[1])
            roots = find_roots(self.graph, pairs.select(rows), s[own].ravel())
            near[own] = self._is_near(roots).reshape(near[own].shape)
        kept = np.flatnonzero(near.any(axis=1))
        pairs, s, near = pairs.select(kept), s[kept], near[kept]
        balls = sorted({max(ball, self.gap_mm) for ball in BALLS_MM})
        on = np.stack([self._held(pairs, s, near, np.full(len(pairs), ball)) for ball in balls])
        share = on.sum(axis=2)
        first = np.argmax(share >= LEAST_SHARE * share.max(axis=0), axis=0)
        rows = np.flatnonzero(share.max(axis=0, initial=0) > 1)
        if len(rows) == 0:
            return []
        pairs, s, near, first = pairs.select(rows), s[rows], near[rows], first[rows]
        middle = np.argmax(on[first, rows], axis=1) + (share[first, rows] - 1) // 2
        at = s[np.arange(len(rows)), middle]
        ball_mm = self.with_room(pairs, at, np.array(balls)[first])
        on = self._held(pairs, s, near, ball_mm)
        return [self._stretches(pairs, s, on, ball_mm)]

    def _held(self, pairs: FacePairs, s: FloatArray, near: BoolArray, ball_mm: FloatArray) -> BoolArray:
        """Tell at which samples s (k, n) a ball touches both faces of its pair; only the `near` ones are asked."""
        row, column = np.nonzero(near)
        on = np.zeros(s.shape, dtype=bool)
        for first in range(0, len(row), CHUNK):
            at = row[first : first + CHUNK], column[first : first + CHUNK]
            on[at] = self.holds(pairs.select(at[0]), s[at], ball_mm[at[0]])
        return on

    def _stretches(self, pairs: FacePairs, s: FloatArray, on: BoolArray, ball_mm: FloatArray) -> Grooves:
        """Return the stretches of pairs at whose samples s (k, n) a ball touches both faces."""
        is_turn = s.shape[1] == TURN_SAMPLES
        closed = on.all(axis=1) & is_turn
        if is_turn:
            on, s = _from_a_gap(on, s)
        row, first_on, last_on = _runs(on)
        own, ball = pairs.select(row), ball_mm[row]
        s0 = self._end(own, s[row], first_on, -1, ball)
        s1 = self._end(own, s[row], last_on, +1, ball)
        return Grooves(own, s0, s1, closed[row], ball)

    def with_room(self, pairs: FacePairs, s: FloatArray, ball_mm: FloatArray) -> FloatArray:
        """Return the balls (n,), made larger where a nozzle has no room: it touches both faces before the wire does.

        Parameters
        ----------
        pairs : FacePairs
            n pairs.
        s : ndarray, shape (n,)
            A place on each groove.
        ball_mm : ndarray, shape (n,)
            Radii of balls that touch both faces there.
        """
        roots = find_roots(self.graph, pairs, s)
        nozzle = self.centres(pairs, roots, np.full(len(pairs), USUAL_TORCH.nozzle_radius_mm))
        most = np.maximum(ball_mm, MOST_BALL_MM)

        def is_far(ball: FloatArray) -> BoolArray:
            c = self.centres(pairs, roots, ball)
            away = np.linalg.norm(nozzle - c, axis=1)
            return np.asarray(away > USUAL_TORCH.wire_mm, dtype=bool)  # false where there is no nozzle (NaN)

        low, high = ball_mm, np.where(is_far(ball_mm), most, ball_mm)
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            far = is_far(middle)
            low, high = np.where(far, middle, low), np.where(far, high, middle)
        fits = self.holds(pairs, s, high)
        return np.where(fits, high, ball_mm)

    def _end(self, pairs: FacePairs, s: FloatArray, at: IntArray, way: int, ball_mm: FloatArray) -> FloatArray:
        """Find where stretches end beyond their outermost sample at which a ball touches both faces."""
        good: FloatArray = s[np.arange(len(at)), at].copy()
        todo = np.flatnonzero((at + way >= 0) & (at + way < s.shape[1]))
        inner, outer, own, ball = good[todo], s[todo, at[todo] + way], pairs.select(todo), ball_mm[todo]
        for _ in range(BISECTIONS):
            middle = (inner + outer) / 2
            here = self.holds(own, middle, ball)
            inner, outer = np.where(here, middle, inner), np.where(here, outer, middle)
        good[todo] = inner
        return good

    def _is_near(self, roots: Roots) -> BoolArray:
        """Tell where the gap is not too wide, and the other face runs along the rounded one; shape (n,)."""
        return np.asarray((np.abs(roots.gap_mm) <= self.gap_mm) & (roots.tilt <= TILT_SIN), dtype=bool)

    def holds(self, pairs: FacePairs, s: FloatArray, ball_mm: FloatArray) -> BoolArray:
        """Tell at which places s (n,) balls touch both faces of pairs inside their boundaries; shape (n,)."""
        roots = find_roots(self.graph, pairs, s)
        p = self.centres(pairs, roots, ball_mm)
        held = self._is_near(roots) & np.isfinite(p).all(axis=1)
        for face in (pairs.pipe, pairs.other):
            rows = np.flatnonzero(held)
            foot = project_to_faces(self.graph, face[rows], p[rows])
            apart = np.abs(np.linalg.norm(p[rows] - foot.p, axis=1) - ball_mm[rows])
            held[rows] = (apart <= FLUSH_MM) & self.trimmed.contains(face[rows], foot.uv)
        return held

    def _in_section(self, pairs: FacePairs, roots: Roots, ball_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return where balls are in the cross-sections, along m and t from the centre: exact between parallel faces."""
        reach, other = roots.radius_mm + ball_mm, other_radii(self.graph, pairs)
        flat = ~np.isfinite(other)
        other = np.where(flat, 1.0, other)
        apart = roots.radius_mm + roots.gap_mm + other
        round_ = (reach**2 - (other + ball_mm) ** 2 + apart**2) / (2.0 * np.where(apart == 0, np.inf, apart))
        up = np.where(flat, roots.radius_mm + roots.gap_mm - ball_mm, round_)
        return up, np.sqrt(np.maximum(reach**2 - up**2, 0.0))

    def centres(self, pairs: FacePairs, roots: Roots, ball_mm: FloatArray) -> FloatArray:
        """Return the centres of balls that touch both faces of pairs; NaN where there is none, shape (n, 3)."""
        up, out = self._in_section(pairs, roots, ball_mm)
        p0 = roots.centre + up[:, None] * roots.m + out[:, None] * roots.t
        p = meet_surfaces(self.graph, pairs.pipe, pairs.other, p0, roots.x, height_mm=ball_mm, least_sin=LEAST_SIN)
        beside = np.einsum("ki,ki->k", p - roots.centre, roots.t) > 0
        p[~beside] = np.nan
        return p


def other_radii(graph: BrepGraph, pairs: FacePairs) -> FloatArray:
    """Return the radius of the other faces in the cross-section, mm, shape (k,): hollow ones below 0, flat ones infinite."""
    kind, param = graph.face_kind[pairs.other], graph.face_param[pairs.other]
    radius = np.where(kind == SurfaceKind.TORUS, param[:, 1], param[:, 0]) * graph.face_outward[pairs.other]
    return np.where(np.isin(kind, PIPES), radius, np.inf)


def _from_a_gap(on: BoolArray, s: FloatArray) -> tuple[BoolArray, FloatArray]:
    """Roll samples once round, whose last is the first again, so that each row begins where nothing is found."""
    first = np.argmin(on, axis=1)
    column = (np.arange(on.shape[1]) + first[:, None]) % (on.shape[1] - 1)
    turned = np.take_along_axis(on, column, axis=1)
    return turned, s + (s[:, 1] - s[:, 0])[:, None] * first[:, None]


def _runs(on: BoolArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return the row and the first and last column of every run of true values longer than one."""
    change = np.diff(np.pad(on, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, first = np.nonzero(change == 1)
    last = np.nonzero(change == -1)[1] - 1
    long = last > first
    return row[long], first[long], last[long]
