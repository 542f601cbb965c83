"""The cross-section of a flare groove: how deep and how wide it is, and the ball that fits into its mouth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray
from wpcal.core.last_held import last_held
from wpcal.robot.torch.shape import USUAL_TORCH
from wpcal.seam.find.flare import FlareSearch
from wpcal.seam.find.flare_sections import FacePairs, Roots, ball_centres, other_radii

HALVINGS = 30  #: Of a depth or a radius: from 20 mm to 2e-8 mm.
ON_FACE_MM = 1e-7  #: A point nearer to the surface of a face is on it: the accuracy of vertices in kernels.
RAY_ROUNDS = 8  #: Steps of Newton's method from a point beside a surface onto it along a line.


@dataclass(frozen=True, slots=True, eq=False)
class GrooveShapes:
    """Cross-sections of n grooves."""

    #: shape (n,). Radius of the largest ball that touches both faces not farther from the wire's tip than the nozzle
    #: is. The torch points to its centre.
    mouth_mm: FloatArray
    depth_mm: FloatArray  #: shape (n,). From the root to where the first of the two faces ends.
    opening_mm: FloatArray  #: shape (n,). Distance between the faces there.
    #: `continues`, `pipe_continues`: shape (n,). Whether the other face, and the rounded face, goes on beyond the
    #: groove.
    continues: BoolArray
    pipe_continues: BoolArray


def measure_grooves(search: FlareSearch, pairs: FacePairs, roots: Roots, ball_mm: FloatArray) -> GrooveShapes:
    """Measure grooves at one cross-section each. `ball_mm`: shape (n,). Radii of balls that touch both faces."""
    sections = _Sections(search, pairs, roots)
    largest = sections.least_radius
    c = ball_centres(search.graph, pairs, roots, ball_mm)
    most = np.full(len(pairs), USUAL_TORCH.wire_mm)
    mouth = _largest(ball_mm, most, lambda row, ball: sections.select(row).holds_ball(ball, c[row]))
    reach = []
    for face, at in ((pairs.pipe, _Sections.on_pipe), (pairs.other, _Sections.on_other)):
        foot = project_to_faces(search.graph, face, c).p
        start = np.clip(np.einsum("ki,ki->k", foot - roots.centre, roots.t), 0.0, largest)
        reach.append(_largest(start, largest, partial(sections.reaches, face, at)))
    depth = np.minimum(*reach)
    opening = np.linalg.norm(sections.on_pipe(depth) - sections.on_other(depth), axis=1)
    step = 2.0 * search.gap_mm + 0.1  # beyond the tolerance for a flush edge
    continues = sections.is_on(pairs.other, sections.on_other(depth + step))
    beyond = depth + step
    pipe_continues = (beyond < roots.radius_mm) & sections.is_on(pairs.pipe, sections.on_pipe(beyond))
    return GrooveShapes(mouth, depth, opening, continues, pipe_continues)


def _largest(good: FloatArray, most: FloatArray, holds: Callable[[IntArray, FloatArray], BoolArray]) -> FloatArray:
    """Return the largest values from `good` up to `most` for which something is true."""
    low, _ = last_held(good, most, holds, halvings=HALVINGS)
    return np.where(holds(np.arange(len(most)), most), most, low)


@dataclass(frozen=True, slots=True, eq=False)
class _Sections(Columns):
    search: FlareSearch
    pairs: FacePairs
    roots: Roots

    @property
    def other_radius(self) -> FloatArray:
        """Radius of the other faces in the cross-section, mm; infinite if they are not rounded outwards."""
        radius = other_radii(self.search.graph, self.pairs)
        return np.where(radius > 0, radius, np.inf)

    @property
    def least_radius(self) -> FloatArray:
        """The smaller radius of two rounded faces, mm."""
        return np.minimum(self.other_radius, self.roots.radius_mm)

    def on_pipe(self, d: FloatArray) -> FloatArray:
        """Return the points of the rounded faces at distances out of the groove, mm."""
        at = self.roots
        up = np.sqrt(np.maximum(at.radius_mm**2 - d**2, 0.0))
        return np.asarray(at.centre + d[:, None] * at.t + up[:, None] * at.m, dtype=np.float64)

    def on_other(self, d: FloatArray) -> FloatArray:
        """Return the points of the other faces at distances out of the groove, mm."""
        at, graph = self.roots, self.search.graph
        p = at.centre + d[:, None] * at.t + (at.radius_mm + at.gap_mm)[:, None] * at.m
        round_ = self.other_radius
        rows = np.flatnonzero(np.isfinite(round_))
        back = round_[rows] - np.sqrt(np.maximum(round_[rows] ** 2 - d[rows] ** 2, 0.0))
        p[rows] += back[:, None] * at.m[rows]
        for _ in range(RAY_ROUNDS):
            foot = project_to_faces(graph, self.pairs.other, p)
            height = np.einsum("ki,ki->k", p - foot.p, foot.normal)
            down = np.einsum("ki,ki->k", at.m, foot.normal)
            height[rows] = 0.0
            p = p - (height / np.where(np.abs(down) > ON_FACE_MM, down, np.inf))[:, None] * at.m
        return p

    def reaches(
        self, face: IntArray, at: Callable[[_Sections, FloatArray], FloatArray], row: IntArray, d: FloatArray
    ) -> BoolArray:
        """Tell whether points of some of the sections at distances out of the groove are on faces."""
        return self.is_on(face[row], at(self.select(row), d))

    def holds_ball(self, ball_mm: FloatArray, c: FloatArray) -> BoolArray:
        """Tell whether balls touch both members, not farther from points c (n, 3) than a nozzle is."""
        p = ball_centres(self.search.graph, self.pairs, self.roots, ball_mm)
        held = np.asarray(np.linalg.norm(p - c, axis=1) <= USUAL_TORCH.wire_mm, dtype=bool)
        for face in (self.pairs.pipe, self.pairs.other):
            foot = project_to_faces(self.search.graph, face[held], p[held])
            held[held] = self.is_on(face[held], foot.p)
        return held

    def is_on(self, face: IntArray, points: FloatArray) -> BoolArray:
        """Tell whether points are on faces, or on others of the same solid that continue their surfaces; shape (n,)."""
        graph, trimmed = self.search.graph, self.search.trimmed
        foot = project_to_faces(graph, face, points)
        on = (np.linalg.norm(foot.p - points, axis=1) <= ON_FACE_MM) & trimmed.contains(face, foot.uv)
        rows = np.flatnonzero(~on)
        row, near = trimmed.box_tree.meeting(points[rows] - ON_FACE_MM, points[rows] + ON_FACE_MM)
        row = rows[row]
        same = graph.face_solid[near] == graph.face_solid[face[row]]
        row, near = row[same], near[same]
        foot = project_to_faces(graph, near, points[row])
        on[row[(np.linalg.norm(foot.p - points[row], axis=1) <= ON_FACE_MM) & trimmed.contains(near, foot.uv)]] = True
        return np.asarray(on, dtype=bool)
