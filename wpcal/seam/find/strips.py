"""Strips of solids: faces that fill the hollow corner between two others, as beads and rounds do.

A round, and a bead that was drawn hollow, runs smoothly into the faces beside it. A bead that was drawn flat or bulging
meets them at corners, which are no welds by themselves.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wpcal.brep.concavity import LEAST_TURN_SIN, corner_turns, inner_edges
from wpcal.brep.curves import edge_lengths, evaluate_edges
from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.hits import find_hits
from wpcal.brep.meeting import meet_surfaces
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.built_up import SAME_THICKNESS, way_out
from wpcal.seam.limits import LEAST_SEAM_MM

WIDEST_MM = 30.0  #: Largest width of the face of a bead: a fillet with 20 mm legs, laid in many runs, is 28 mm wide.
LEAST_CORNER_COS = 0.87
"""Faces beside a strip at an angle of less than 30 degrees are one bent sheet, not two members."""
STRIPS = (SurfaceKind.CYLINDER, SurfaceKind.TORUS, SurfaceKind.CONE, SurfaceKind.NURBS)
ACROSS_POINTS = 513  #: Points along the other side of a strip, of which the nearest one is taken.
LEAST_RISE, MOST_RISE = 0.25, 0.97
"""Sines between the chord across a bead and its sides: 15 and 75 degrees. The floor of a channel has 90."""
MOST_UNEVEN, SLENDER = 3.0, 2.0  #: Ratio of the legs of a bead at most, and of its length to its width at least.
MOST_BULGE, MOST_HOLLOW = 0.5, 0.6
"""A bead bulges, or is hollow, by less than these shares of its throat: a quarter round bulges by 0.41, and a rod in a
corner by 2.4."""
MOST_END = 1.5  #: The faces at the end of a bead are no longer than this many of its widths.
WALL, WALL_COS, AS_FAR = 4.0, 0.98, 0.9
"""A strip of which the far side is parallel, within this many throats, is a wall of a folded sheet; a bead has material
for this share of the way to its root."""
BEND_SHARE, BEND_RADII = 0.15, (0.5, 0.6)
"""The wall of a bend is thicker than the sheet beside it by up to this share: its outer round is not always drawn about
the axis of the inner one. The inner and the outer radius are at least this many thicknesses: a bead has another one."""
SKIN_MM = 1e-3  #: Rays into the material start this far below the surface.


@dataclass(frozen=True, slots=True)
class Strip:
    """A strip between two faces."""

    face: int
    sides: tuple[int, int]  #: The faces beside it.
    edges: tuple[tuple[int, ...], tuple[int, ...]]  #: The edges between the strip and each of these, the shorter first.
    is_bead: bool  #: Whether it meets both at corners, as only a bead that was drawn does.
    width_mm: float = 0.0  #: From side to side.


def find_strips(
    graph: BrepGraph, trimmed: TrimmedFaces, solid: int | None = None, *, min_length_mm: float = LEAST_SEAM_MM
) -> list[Strip]:
    """Find the strips that fill a hollow corner between two other faces of their solid. By face.

    A strip runs smoothly into both faces, or meets both at hollow corners and has material as far as the corner that it
    fills. They are found once for all solids, and kept in `trimmed.known`.

    `solid`: Only its strips are returned; by default those of all.
    """
    key = f"strips of {min_length_mm} mm", -1
    if key not in trimmed.known:
        found = _find_strips(graph, trimmed, min_length_mm)
        trimmed.known[key] = found, graph.face_solid[[one.face for one in found]]
    found, solids = trimmed.known[key]
    return found if solid is None else [found[row] for row in np.flatnonzero(solids == solid).tolist()]


def _find_strips(graph: BrepGraph, trimmed: TrimmedFaces, min_length_mm: float) -> list[Strip]:
    edges = inner_edges(graph)
    sine = corner_turns(graph, edges)[0]
    rounds = _between_two(graph, edges[np.abs(sine) < LEAST_TURN_SIN], min_length_mm)
    beads = _between_two(graph, edges[sine <= -LEAST_TURN_SIN], min_length_mm, is_bead=True)
    corners = _Corners.of(graph, [*rounds, *beads])
    kept, width = corners.are_strips() & corners.have_material(trimmed), np.linalg.norm(corners.q - corners.p, axis=1)
    found = [replace(corners.strips[row], width_mm=float(width[row])) for row in np.flatnonzero(kept).tolist()]
    filled = {one.face for one in found if one.is_bead}  # and not the sides of a hole with many sides
    return sorted((one for one in found if not one.is_bead or filled.isdisjoint(one.sides)), key=lambda one: one.face)


def drawn_beads(graph: BrepGraph, strips: list[Strip]) -> BoolArray:
    """Tell which faces belong to beads that were drawn: strips with corners, and their ends, shape (F,)."""
    found, beads = np.zeros(graph.face_count, dtype=bool), [strip for strip in strips if strip.is_bead]
    longest = np.zeros(graph.face_count)
    if beads:
        inner = graph.edge_faces >= 0
        np.maximum.at(longest, graph.edge_faces[inner], np.repeat(edge_lengths(graph), inner.sum(axis=1)))
    for strip in beads:
        beside = graph.edge_faces[(graph.edge_faces == strip.face).any(axis=1)].ravel()
        found[strip.face] = True
        found[beside[(beside >= 0) & (longest[beside] <= MOST_END * strip.width_mm)]] = True
    return found


def _between_two(graph: BrepGraph, edges: IntArray, min_length_mm: float, *, is_bead: bool = False) -> list[Strip]:
    """Return the faces that have two others beside them along some edges, for at least this length."""
    lengths = edge_lengths(graph)
    beside: dict[int, dict[int, list[int]]] = {}
    for edge, (one, other) in zip(edges.tolist(), graph.edge_faces[edges].tolist(), strict=True):
        for face, next_to in ((one, other), (other, one)):
            if graph.face_kind[face] in STRIPS or is_bead:
                beside.setdefault(face, {}).setdefault(next_to, []).append(edge)
    found = []
    for face, others in sorted(beside.items()):
        mm = {other: float(lengths[rows].sum()) for other, rows in others.items()}
        long = sorted(mm, key=lambda other: (-mm[other], other))[:2][::-1]
        if len(long) == 2 and mm[long[0]] >= min_length_mm:
            found.append(Strip(face, (long[0], long[1]), (tuple(others[long[0]]), tuple(others[long[1]])), is_bead))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class _Corners:
    """The sections of n strips, each across the middle of an edge of its first side."""

    graph: BrepGraph
    strips: list[Strip]
    #: `p`, `q`: shape (n, 3). Where the strip meets its sides, mm.
    p: FloatArray
    q: FloatArray
    #: `n1`, `n2`: shape (n, 3). Outward normals of the sides there.
    n1: FloatArray
    n2: FloatArray
    foot: FloatArray  #: shape (n, 3). On the strip, next to the middle between p and q.
    outward: FloatArray  #: shape (n, 3). Normal of the strip there.
    root: FloatArray  #: shape (n, 3). Where the two sides would meet; not a number where they do not.

    @classmethod
    def of(cls, graph: BrepGraph, strips: list[Strip]) -> _Corners:
        first = np.array([strip.edges[0][0] for strip in strips], dtype=np.int64)
        second = np.array([edge for strip in strips for edge in strip.edges[1]], dtype=np.int64)
        owner = np.repeat(np.arange(len(strips)), [len(strip.edges[1]) for strip in strips])
        side = np.array([strip.sides for strip in strips], dtype=np.int64).reshape(-1, 2)
        p, slope = evaluate_edges(graph, first, graph.edge_range[first].mean(axis=1))
        at = np.linspace(graph.edge_range[second, 0], graph.edge_range[second, 1], ACROSS_POINTS, axis=1)
        across = evaluate_edges(graph, np.repeat(second, ACROSS_POINTS), at.ravel())[0]
        off = np.linalg.norm(across - np.repeat(p[owner], ACROSS_POINTS, axis=0), axis=1)
        nearest = np.lexsort((off, np.repeat(owner, ACROSS_POINTS)))
        q = across[nearest[np.searchsorted(np.repeat(owner, ACROSS_POINTS), np.arange(len(strips)))]]
        n1, n2 = project_to_faces(graph, side[:, 0], p).normal, project_to_faces(graph, side[:, 1], q).normal
        foot = project_to_faces(graph, np.array([strip.face for strip in strips], dtype=np.int64), (p + q) / 2)
        x = slope / np.linalg.norm(slope, axis=1, keepdims=True)
        root = meet_surfaces(graph, side.T, p, x, least_sin=LEAST_TURN_SIN)
        return cls(graph, strips, p, q, n1, n2, foot.p, foot.normal, root)

    def are_strips(self) -> BoolArray:
        """Tell which strips are narrow, with sides at an angle, and fill a hollow corner."""
        middle, chord = (self.p + self.q) / 2, self.q - self.p
        width = np.linalg.norm(chord, axis=1)
        is_bead = np.array([strip.is_bead for strip in self.strips], dtype=bool)
        bulge = np.einsum("ki,ki->k", self.foot - middle, self.outward)
        kept = (width > 0) & (width <= WIDEST_MM) & (np.einsum("ki,ki->k", self.n1, self.n2) < LEAST_CORNER_COS)
        with np.errstate(divide="ignore", invalid="ignore"):
            unit = chord / width[:, None]
            rise = np.stack([np.einsum("ki,ki->k", self.n1, unit), -np.einsum("ki,ki->k", self.n2, unit)])
            legs = np.linalg.norm(np.stack([self.root - self.p, self.root - self.q]), axis=2)
            deep = np.linalg.norm(np.cross(self.root - self.p, unit), axis=1)
            long = np.array([edge_lengths(self.graph)[list(strip.edges[0])].sum() for strip in self.strips])
            fills = (rise > LEAST_RISE).all(axis=0) & (rise < MOST_RISE).all(axis=0)
            fills &= (legs.max(axis=0) <= MOST_UNEVEN * legs.min(axis=0)) & (long >= SLENDER * width)
            fills &= (bulge <= MOST_BULGE * deep) & (bulge >= -MOST_HOLLOW * deep)
        return np.asarray(kept & np.where(is_bead, fills, bulge < 0), dtype=bool)

    def have_material(self, trimmed: TrimmedFaces) -> BoolArray:
        """Tell which strips have material as far as the corner, and are not the inside of a bend."""
        rows = np.flatnonzero(np.isfinite(self.root).all(axis=1))
        way = self.root[rows] - self.foot[rows]
        deep = np.linalg.norm(way, axis=1)
        way /= np.where(deep > 0, deep, 1.0)[:, None]
        sheet_mm = self._sheet_mm(trimmed)[rows]
        far_mm = np.maximum(WALL * deep, (1.0 + BEND_SHARE) * sheet_mm)
        hits = find_hits(trimmed, self.foot[rows] + SKIN_MM * way, way, length_mm=far_mm)
        first = np.flatnonzero(np.diff(hits.ray, prepend=-1))
        ray, face = hits.ray[first], hits.face[first]
        at = self.foot[rows[ray]] + (SKIN_MM + hits.at_mm[first])[:, None] * way[ray]
        normal = project_to_faces(self.graph, face, at).normal
        is_wall = np.abs(np.einsum("ki,ki->k", normal, way[ray])) > WALL_COS
        is_wall &= (hits.at_mm[first] <= WALL * deep[ray]) | self._are_bent(rows[ray], face, sheet_mm[ray])
        found = np.zeros(len(self.strips), dtype=bool)
        found[rows] = True
        found[rows[ray[is_wall | (hits.at_mm[first] < AS_FAR * deep[ray])]]] = False
        return found

    def _are_bent(self, rows: IntArray, far: IntArray, sheet_mm: FloatArray) -> BoolArray:
        """Tell which strips, with a face on the far side each, are round on both as a sheet is that was bent."""
        graph, near = self.graph, np.array([strip.face for strip in self.strips], dtype=np.int64)[rows]
        is_round = (graph.face_kind[near] == SurfaceKind.CYLINDER) & (graph.face_kind[far] == SurfaceKind.CYLINDER)
        inner, outer = (graph.face_param[face, 0] / np.where(sheet_mm > 0, sheet_mm, np.inf) for face in (near, far))
        return np.asarray(is_round & (inner >= BEND_RADII[0]) & (outer >= BEND_RADII[1]), dtype=bool)

    def _sheet_mm(self, trimmed: TrimmedFaces) -> FloatArray:
        """Return how thick the material is behind both sides, shape (n,), if it is the same; otherwise zero."""
        solid = self.graph.face_solid[[strip.face for strip in self.strips]]
        thick, other = (
            way_out(self.graph, trimmed, solid, p - SKIN_MM * n, -n)[0] + SKIN_MM
            for p, n in ((self.p, self.n1), (self.q, self.n2))
        )
        with np.errstate(invalid="ignore"):
            return np.where(np.abs(thick - other) <= SAME_THICKNESS * thick, thick, 0.0)
