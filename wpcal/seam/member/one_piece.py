"""Solids that were cast, moulded, forged, printed or milled as one piece: neither cut from plate or bar, nor turned.

Members of a weldment are plates, bars, tubes, profiles and turned pieces. A solid is taken for one of these if it is
round about one axis, if it has one section from end to end apart from holes, or if most of its surface is on plates,
bars and tubes (`find.built_up`). What is none of these was made as one piece. Such a solid is rather bolted or clamped,
or the other one sits in it. A clevis that was milled from a block is welded now and then, so this is a doubt only.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from wpcal.brep.curves import edge_lengths
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.built_up import built_up_shares, is_turned

STRAIGHT = (SurfaceKind.PLANE, SurfaceKind.CYLINDER)  #: Surfaces of a bar.
LEAST_MEMBER = 0.8
"""A solid with less of its surface on plates, bars and tubes was made as one piece. Members of 40 parts with lists have
0.88 or more, apart from those with one section and those that are round; castings, mouldings and milled bodies have
0.00 to 0.81."""
LOOKS = ((100, 0.12), (400, 0.0))
"""Points on the surface that are looked at, and how far from `LEAST_MEMBER` a share of so many is sure (3 sigma)."""
FEWEST_POINTS = 50  #: Of fewer points nothing is said: the box around a thin bent solid holds too little of it.
ALONG_COS = 1e-6  #: A face is along a bar within this.
END_SHARE = 0.4  #: Each end of a bar, with mitre and cope, takes less than this share of its length.
LARGEST_ROUND = 0.35
"""Rounds of edges have a radius of at most this share of the thickness; what is rounder is an end of another shape."""
SAME_LENGTH_MM = 0.01
"""Edges whose lengths agree within this are equal. Solids with equal edges and faces are one body."""


@dataclass(slots=True, eq=False)
class OnePieces:
    """Which solids were made as one piece, found when somebody asks; equal solids are looked at once."""

    #: `graph`, `trimmed`: The part.
    graph: BrepGraph
    trimmed: TrimmedFaces
    _why: dict[int, str | None] = field(default_factory=dict)
    _equal: dict[bytes, str | None] = field(default_factory=dict)
    _signatures: dict[int, bytes] = field(default_factory=dict)
    _lengths: FloatArray | None = None

    def why(self, solid: int) -> str | None:
        """Tell why a solid looks as if made as one piece; None if it may be cut from plate, bar or tube, or turned."""
        if solid not in self._why:
            key = self.signature(solid)
            if key not in self._equal:
                self._equal[key] = self._look(solid)
            self._why[solid] = self._equal[key]
        return self._why[solid]

    def signature(self, solid: int) -> bytes:
        """Return what equal solids have in common: the kinds of their faces, and the lengths of their edges."""
        if solid not in self._signatures:
            self._signatures[solid] = self._signature(solid)
        return self._signatures[solid]

    def _signature(self, solid: int) -> bytes:
        if self._lengths is None:
            self._lengths = edge_lengths(self.graph)
        kinds = np.bincount(self.graph.face_kind[self.graph.face_solid == solid], minlength=len(SurfaceKind))
        lengths = np.sort(np.round(self._lengths[self.graph.edge_solid == solid] / SAME_LENGTH_MM))
        return kinds.astype(np.int64).tobytes() + lengths.astype(np.int64).tobytes()

    def _look(self, solid: int) -> str | None:
        graph, trimmed = self.graph, self.trimmed
        if is_turned(graph, solid, but=are_holes(graph)) or has_one_section(graph, trimmed, solid):
            return None
        share = 1.0
        looks = built_up_shares(graph, trimmed, solid, [hits for hits, _ in LOOKS])
        for (so_far, count), (_, clearly) in zip(looks, LOOKS, strict=True):
            share = so_far if count >= FEWEST_POINTS else 1.0
            if abs(share - LEAST_MEMBER) > clearly:
                break
        if share >= LEAST_MEMBER:
            return None
        return (
            f"only {share:.0%} of its surface is on plates, bars or tubes, and it is neither turned nor of one section:"
            " it looks cast, moulded or milled"
        )


def has_one_section(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> bool:
    """Tell whether a solid has one section from end to end, as if cut from plate, bar or profile.

    All faces run along one direction, apart from holes and ends. Ends may be mitred, coped, chamfered or rounded; their
    planes look outward, and they leave the middle of the solid alone. The end of a pocket looks inward.
    """
    faces = np.flatnonzero(graph.face_solid == solid)
    kind, hole = graph.face_kind[faces], are_holes(graph)[faces]
    plane = kind == SurfaceKind.PLANE
    if np.isin(kind, (SurfaceKind.NURBS, SurfaceKind.NONE)).any() or not (np.diff(trimmed.start)[faces] > 0).all():
        return False
    z = graph.face_frame[faces, 3]
    count = np.diff(trimmed.start)[faces]
    points = np.concatenate([trimmed.p0[trimmed.start[face] : trimmed.start[face + 1]] for face in faces.tolist()])
    first = np.cumsum(count) - count
    lines = (graph.edge_solid == solid) & (graph.edge_kind == CurveKind.LINE)
    ways = _ways(np.concatenate([z, graph.edge_frame[lines, 1]]))
    thin = np.ptp(points @ ways.T, axis=0).min()
    may_end = plane | (_radii(graph, faces) <= LARGEST_ROUND * thin)
    for way in ways:
        at, cos = points @ way, z @ way
        low, high = np.minimum.reduceat(at, first), np.maximum.reduceat(at, first)
        near_end = END_SHARE * (high.max() - low.min())
        looks = np.where(plane, cos * graph.face_outward[faces], 0.0)
        is_end = (looks <= 0) & (high < low.min() + near_end) | (looks >= 0) & (low > high.max() - near_end)
        along = np.where(plane, np.abs(cos) < ALONG_COS, np.abs(cos) > 1.0 - ALONG_COS) & np.isin(kind, STRAIGHT)
        if (along | hole | (may_end & is_end)).all():
            return True
    return False


def _radii(graph: BrepGraph, faces: IntArray) -> FloatArray:
    """Return the radii of rounds: of cylinders and spheres, of the bars of tori; of chamfers round an axis, zero."""
    kind, param = graph.face_kind[faces], graph.face_param[faces]
    radius = np.where(kind == SurfaceKind.TORUS, param[:, 1], param[:, 0])
    return np.where(kind == SurfaceKind.CONE, 0.0, radius)


def are_holes(graph: BrepGraph) -> BoolArray:
    """Tell which faces are walls of holes, or of round roots: hollow cylinders and cones; shape (F,)."""
    round_ = np.isin(graph.face_kind, (SurfaceKind.CYLINDER, SurfaceKind.CONE))
    return np.asarray(round_ & (graph.face_outward < 0), dtype=bool)


def _ways(z: FloatArray) -> FloatArray:
    """Return the different directions among unit vectors, opposite ones once."""
    turned = z * np.where(z[np.arange(len(z)), np.abs(z).argmax(axis=1)] < 0, -1.0, 1.0)[:, None]
    rows: IntArray = np.unique(np.round(turned, 6), axis=0, return_index=True)[1]
    return turned[rows]
