"""Seams of groups that a part holds several times: found once, then moved to the copies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.repeats import Copy
from wpcal.core.arrays import IntArray
from wpcal.seam.seam import NamedSolids, Seam, SeamFrames, SeamPieces


@dataclass(frozen=True, slots=True, eq=False)
class CopiedSeams:
    """Seams of a part, and which of its solids are copies."""

    seams: tuple[Seam, ...]  #: Those that were searched come first, then their copies.
    alike: IntArray | None = None  #: shape (S,). The solid that each one is a copy of, or itself. None: no copies.

    @classmethod
    def of(cls, graph: BrepGraph, seams: Sequence[Seam], copies: Sequence[Copy]) -> CopiedSeams:
        """Copy seams."""
        alike = np.arange(len(graph.solid_names))
        face = np.array([max(int(seam.pieces.wall[0]), int(seam.pieces.base[0])) for seam in seams], dtype=np.int64)
        solid = np.where(face < 0, -1, graph.face_solid[face]) if len(seams) else face
        found = list(seams)
        for copy in copies:
            alike[copy.group.solids] = copy.first.solids
            own = np.flatnonzero(np.isin(solid, copy.first.solids))
            found += _moved(graph, copy, [seams[row] for row in own.tolist()])
        return cls(tuple(found), alike)


def _moved(graph: BrepGraph, copy: Copy, seams: Sequence[Seam]) -> list[Seam]:
    """Return the seams of a copy at the places of seams of the first group."""
    if not seams:
        return []
    pairs = zip(copy.first.solids.tolist(), copy.group.solids.tolist(), strict=True)
    names = {graph.solid_names[one]: graph.solid_names[other] for one, other in pairs}
    pieces = SeamPieces.joined([seam.pieces for seam in seams])
    edge, wall, base = copy.edges_of(pieces.edge), *(copy.faces_of(f) for f in (pieces.wall, pieces.base))
    p = np.concatenate([seam.frames.p for seam in seams]) + copy.shift_mm
    of_piece = pairwise(accumulate((len(seam.pieces) for seam in seams), initial=0))
    of_frame = pairwise(accumulate((len(seam.frames) for seam in seams), initial=0))
    return [
        replace(
            seam,
            solids=_named(seam.solids, names),
            pieces=SeamPieces(edge[k0:k1], own.t0, own.t1, wall[k0:k1], base[k0:k1], own.gap_mm),
            frames=SeamFrames(at.s_mm, p[n0:n1], at.R, at.angle_rad, at.frame),
            reasons=tuple(text.told_of(names) if isinstance(text, NamedSolids) else text for text in seam.reasons),
            inside=_named(seam.inside, names),
        )
        for seam, (k0, k1), (n0, n1) in zip(seams, of_piece, of_frame, strict=True)
        for own, at in [(seam.pieces, seam.frames)]
    ]


def _named(solids: tuple[str, ...], names: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(names[solid] for solid in solids)


def renumbered(seam: Seam, faces: IntArray, edges: IntArray) -> Seam:
    """Return a seam with the numbers of its faces and edges in `faces`, shape (F,), and `edges`, shape (E,)."""
    own = seam.pieces
    wall, base = (np.where(face < 0, -1, faces[face]) for face in (own.wall, own.base))
    return replace(seam, pieces=SeamPieces(edges[own.edge], own.t0, own.t1, wall, base, own.gap_mm))
