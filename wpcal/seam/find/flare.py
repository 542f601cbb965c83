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

from wpcal.brep.graph import BrepGraph
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray
from wpcal.core.last_held import last_held
from wpcal.robot.torch.shape import USUAL_TORCH
from wpcal.seam.find.contact import find_runs
from wpcal.seam.find.flare_sections import (
    FacePairs,
    May,
    Roots,
    ball_centres,
    face_pairs,
    find_groove_roots,
    pipe_ranges,
)
from wpcal.seam.limits import FLUSH_MM, GAP_ROUND_OFF_MM

BALLS_MM = (0.6, 1.0, 1.5)
"""Radii of balls: half of a wire of 1.2 mm, the usual one of robots, and larger ones. Those are needed where the wall
of a tube ends before the root, so that a thin wire would fall through. The largest one bridges 3 mm, the usual root gap
of a bevel groove."""
LEAST_SHARE = 0.5
"""The first of these balls is taken that touches both faces along this share of what the best one does: a thin wire
that falls into a tube still lies in the corners of the tube."""
MOST_BALL_MM = 3.0
"""Where a nozzle has no room, the wire ends farther out, in a ball of at most this radius: a bead bridges 6 mm."""
THIN_STEPS = 8  #: Balls thinner than the wire are tried in this many steps: 0.525 mm, 0.45 mm, ….
INSIDE_SHARE = 0.99
"""A ball that just fits between two faces is made smaller by 1 %, so that it stays inside their borders."""
TILT_SIN = 0.02
"""The other face runs along the rounded one if the sine between the two is below this (1.1 degrees). Two bars that
cross touch at a point; there the sine is small over less than 1 mm."""
SAMPLES = 33  #: Places along a rounded face at which it is compared with another one, inside the box of the other face.
TURN_SAMPLES = 129  #: The same round a whole torus.
HALVINGS = 40  #: Of an end: from 31 mm between samples to 3e-11 mm.
CHUNK = 20_000  #: Points compared in one array: about 20 MB.


@dataclass(frozen=True, slots=True, eq=False)
class Grooves(Columns):
    """Stretches of grooves: pairs of faces, and from where to where along the rounded face."""

    pairs: FacePairs  #: n pairs.
    #: `s0`, `s1`: shape (n,).
    s0: FloatArray
    s1: FloatArray
    closed: BoolArray  #: shape (n,). Whether the stretch goes once round a torus.
    ball_mm: FloatArray  #: shape (n,). Radius of the ball that touches both faces.


NO_GROOVES = Grooves(
    FacePairs(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0)),
    np.zeros(0),
    np.zeros(0),
    np.zeros(0, dtype=bool),
    np.zeros(0),
)


@dataclass(frozen=True, slots=True, eq=False)
class FlareSearch:
    """Finds the stretches along which a ball touches both faces of a pair."""

    #: `graph`, `trimmed`: The part.
    graph: BrepGraph
    trimmed: TrimmedFaces
    gap_mm: float  #: Largest gap between the members at the root.
    may: May | None = None  #: Which faces of one solid are compared; none without it.

    def find(self) -> Grooves:
        """Return the grooves of a part, their ends on the polylines of the boundaries."""
        pairs = face_pairs(self.graph, self.trimmed, self.gap_mm + GAP_ROUND_OFF_MM, self.may)
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
            roots = find_groove_roots(self.graph, pairs.select(rows), s[own].ravel())
            near[own] = self._is_near(roots).reshape(near[own].shape)
        kept = np.flatnonzero(near.any(axis=1))
        pairs, s, near = pairs.select(kept), s[kept], near[kept]
        balls = sorted({max(ball, self.gap_mm) for ball in BALLS_MM})
        on = np.stack([self._held(pairs, s, near, np.full(len(pairs), ball)) for ball in balls])
        share = on.sum(axis=2)
        first = np.argmax(share >= LEAST_SHARE * share.max(axis=0), axis=0)
        is_held = share.max(axis=0, initial=0) > 1
        rows = np.flatnonzero(is_held)
        middle = np.argmax(on[first[rows], rows], axis=1) + (share[first[rows], rows] - 1) // 2
        ball_mm = np.zeros(len(pairs))
        ball_mm[rows] = self.with_room(pairs.select(rows), s[rows, middle], np.array(balls)[first[rows]])
        rows = np.flatnonzero(~is_held)
        middle = np.argmax(near[rows], axis=1) + (near[rows].sum(axis=1) - 1) // 2
        ball_mm[rows] = self.in_mouth(pairs.select(rows), s[rows, middle])
        rows = np.flatnonzero(ball_mm > 0)
        pairs, s, ball_mm = pairs.select(rows), s[rows], ball_mm[rows]
        return [self._stretches(pairs, s, self._held(pairs, s, near[rows], ball_mm), ball_mm)]

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
        row, first_on, last_on = find_runs(on)
        own, ball = pairs.select(row), ball_mm[row]
        s0 = self._end(own, s[row], first_on, -1, ball)
        s1 = self._end(own, s[row], last_on, +1, ball)
        return Grooves(own, s0, s1, closed[row], ball)

    def with_room(self, pairs: FacePairs, s: FloatArray, ball_mm: FloatArray) -> FloatArray:
        """Return the balls (n,), made larger where a nozzle has no room: it touches both faces before the wire does.

        `s`: shape (n,). A place on each groove.
        `ball_mm`: shape (n,). Radii of balls that touch both faces there.
        """
        roots = find_groove_roots(self.graph, pairs, s)
        nozzle = ball_centres(self.graph, pairs, roots, np.full(len(pairs), USUAL_TORCH.nozzle_radius_mm))
        most = np.maximum(ball_mm, MOST_BALL_MM)

        def is_far(row: IntArray, ball: FloatArray) -> BoolArray:
            c = ball_centres(self.graph, pairs.select(row), roots.select(row), ball)
            away = np.linalg.norm(nozzle[row] - c, axis=1)
            return np.asarray(away > USUAL_TORCH.wire_mm, dtype=bool)  # false where there is no nozzle (NaN)

        bad = np.where(is_far(np.arange(len(pairs)), ball_mm), most, ball_mm)
        high = last_held(ball_mm, bad, is_far, halvings=HALVINGS)[1]
        fits = self.holds(pairs, s, high)
        return np.where(fits, high, ball_mm)

    def in_mouth(self, pairs: FacePairs, s: FloatArray) -> FloatArray:
        """Return the largest balls thinner than a wire that touch both faces, 0 where there is none; shape (n,).

        In a shallow groove, or one beside a small radius, the wire stays in the mouth. A mouth that is not wider than
        the gap is a contact, which others find.

        `s`: shape (n,). A place on each groove.
        """
        low = np.zeros(len(pairs))
        for share in np.arange(THIN_STEPS, 0, -1) / THIN_STEPS:
            rows = np.flatnonzero(low == 0)
            ball = np.full(len(rows), share * BALLS_MM[0])
            low[rows] = np.where(self.holds(pairs.select(rows), s[rows], ball), ball, 0.0)
        kept = np.flatnonzero(low > 0)
        pairs, s, good = pairs.select(kept), s[kept], low[kept]
        good, _ = last_held(
            good,
            good + BALLS_MM[0] / THIN_STEPS,
            lambda row, ball: self.holds(pairs.select(row), s[row], ball),
            halvings=HALVINGS,
        )
        c = ball_centres(self.graph, pairs, find_groove_roots(self.graph, pairs, s), good)
        feet = [project_to_faces(self.graph, face, c).p for face in (pairs.pipe, pairs.other)]
        is_open = np.linalg.norm(feet[0] - feet[1], axis=1) > self.gap_mm
        low[kept] = np.where(is_open, INSIDE_SHARE * good, 0.0)
        return low

    def _end(self, pairs: FacePairs, s: FloatArray, at: IntArray, way: int, ball_mm: FloatArray) -> FloatArray:
        """Find where stretches end beyond their outermost sample at which a ball touches both faces."""
        good: FloatArray = s[np.arange(len(at)), at].copy()
        todo = np.flatnonzero((at + way >= 0) & (at + way < s.shape[1]))
        inner, outer, own, ball = good[todo], s[todo, at[todo] + way], pairs.select(todo), ball_mm[todo]
        good[todo], _ = last_held(
            inner, outer, lambda row, at: self.holds(own.select(row), at, ball[row]), halvings=HALVINGS
        )
        return good

    def _is_near(self, roots: Roots) -> BoolArray:
        """Tell where the gap is not too wide, and the other face runs along the rounded one; shape (n,)."""
        within = np.abs(roots.gap_mm) <= self.gap_mm + GAP_ROUND_OFF_MM
        return np.asarray(within & (roots.tilt <= TILT_SIN), dtype=bool)

    def holds(self, pairs: FacePairs, s: FloatArray, ball_mm: FloatArray) -> BoolArray:
        """Tell at which places s (n,) balls touch both faces of pairs inside their boundaries; shape (n,)."""
        roots = find_groove_roots(self.graph, pairs, s)
        p = ball_centres(self.graph, pairs, roots, ball_mm)
        held = self._is_near(roots) & np.isfinite(p).all(axis=1)
        for face in (pairs.pipe, pairs.other):
            rows = np.flatnonzero(held)
            foot = project_to_faces(self.graph, face[rows], p[rows])
            apart = np.abs(np.linalg.norm(p[rows] - foot.p, axis=1) - ball_mm[rows])
            held[rows] = (apart <= FLUSH_MM) & self.trimmed.contains(face[rows], foot.uv)
        return held


def _from_a_gap(on: BoolArray, s: FloatArray) -> tuple[BoolArray, FloatArray]:
    """Roll samples once round, whose last is the first again, so that each row begins where nothing is found."""
    first = np.argmin(on, axis=1)
    column = (np.arange(on.shape[1]) + first[:, None]) % (on.shape[1] - 1)
    turned = np.take_along_axis(on, column, axis=1)
    return turned, s + (s[:, 1] - s[:, 0])[:, None] * first[:, None]
