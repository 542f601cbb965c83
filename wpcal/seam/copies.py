"""Seams of groups that a part holds several times: found once, then moved to the copies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, islice, pairwise

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.repeats import Copy
from wpcal.core.arrays import IntArray
from wpcal.seam.seam import NamedSolids, Seam, SeamPieces


@dataclass(frozen=True, slots=True, eq=False)
class CopiedSeams:
    """Seams of a part, and which of them were copied."""

    seams: tuple[Seam, ...]  #: length n. Those that were searched come first, then their copies.
    first: IntArray  #: shape (n,). The seam that each one was copied from; its own number if it was searched.
    movers: tuple[Mover, ...] = ()  #: The copies of the part.
    mover: IntArray | None = None  #: shape (n,). The copy to which a seam belongs; -1 if it was searched.

    @classmethod
    def none(cls, seams: Sequence[Seam]) -> CopiedSeams:
        """Return seams that were all searched."""
        return cls(tuple(seams), np.arange(len(seams)))

    @classmethod
    def of(cls, graph: BrepGraph, seams: Sequence[Seam], copies: Sequence[Copy]) -> CopiedSeams:
        """Copy seams."""
        movers = tuple(Mover.of(graph, copy) for copy in copies)
        face = np.array([max(int(seam.pieces.wall[0]), int(seam.pieces.base[0])) for seam in seams], dtype=np.int64)
        solid = np.where(face < 0, -1, graph.face_solid[face]) if len(seams) else face
        rows = [np.flatnonzero(np.isin(solid, mover.copy.first.solids)) for mover in movers]
        moved = [
            seam
            for mover, own in zip(movers, rows, strict=True)
            for seam in mover.moved([seams[i] for i in own.tolist()])
        ]
        own = np.arange(len(seams))
        mover = np.repeat(np.arange(-1, len(movers)), [len(seams), *(len(of) for of in rows)])
        return cls((*seams, *moved), np.concatenate([own, *rows]), movers, mover)

    def like(self, count: int) -> IntArray:
        """Return, for each of `count` solids, the solid that it is a copy of, or itself; shape (count,)."""
        like = np.arange(count)
        for mover in self.movers:
            like[mover.copy.group.solids] = mover.copy.first.solids
        return like

    def moved(self, rows: IntArray, of_first: Mapping[int, Sequence[Seam]]) -> dict[int, list[Seam]]:
        """Return, by row, what was made of the first of each copied seam, moved to its copy.

        `rows`: shape (k,). Copied seams.
        """
        found: dict[int, list[Seam]] = {}
        for number, mover in enumerate(self.movers):
            own = [] if self.mover is None else rows[self.mover[rows] == number].tolist()
            firsts = [of_first[int(self.first[row])] for row in own]
            moved = iter(mover.moved([seam for seams in firsts for seam in seams]))
            found |= {row: list(islice(moved, len(seams))) for row, seams in zip(own, firsts, strict=True)}
        return found


@dataclass(frozen=True, slots=True, eq=False)
class Mover:
    """Moves seams of a group to its copy."""

    copy: Copy
    names: Mapping[str, str]  #: The name of each solid in the copy, by its name in the first group.

    @classmethod
    def of(cls, graph: BrepGraph, copy: Copy) -> Mover:
        """Prepare for moving to a copy."""
        solids = zip(copy.first.solids.tolist(), copy.group.solids.tolist(), strict=True)
        return cls(copy, {graph.solid_names[one]: graph.solid_names[other] for one, other in solids})

    def moved(self, seams: Sequence[Seam]) -> list[Seam]:
        """Return the seams of the copy at the places of seams of the first group."""
        if not seams:
            return []
        names, pieces = self.names, SeamPieces.joined([seam.pieces for seam in seams])
        edge, wall, base = self.copy.edges_of(pieces.edge), *(self.copy.faces_of(f) for f in (pieces.wall, pieces.base))
        p = np.concatenate([seam.frames.p for seam in seams]) + self.copy.shift_mm
        of_piece = pairwise(accumulate((len(seam.pieces) for seam in seams), initial=0))
        of_frame = pairwise(accumulate((len(seam.frames) for seam in seams), initial=0))
        return [
            replace(
                seam,
                solids=_named(seam.solids, names),
                pieces=replace(seam.pieces, edge=edge[k0:k1], wall=wall[k0:k1], base=base[k0:k1]),
                frames=replace(seam.frames, p=p[n0:n1]),
                reasons=tuple(text.told_of(names) if isinstance(text, NamedSolids) else text for text in seam.reasons),
                inside=_named(seam.inside, names),
                blocked_by=_named(seam.blocked_by, names),
                hiding=tuple(replace(one, solid=names[one.solid]) for one in seam.hiding),
            )
            for seam, (k0, k1), (n0, n1) in zip(seams, of_piece, of_frame, strict=True)
        ]


def _named(solids: tuple[str, ...], names: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(names[solid] for solid in solids)


def renumbered(seam: Seam, faces: IntArray, edges: IntArray) -> Seam:
    """Return a seam with the numbers of its faces and edges in `faces`, shape (F,), and `edges`, shape (E,)."""
    own = seam.pieces
    wall, base = (np.where(face < 0, -1, faces[face]) for face in (own.wall, own.base))
    return replace(seam, pieces=SeamPieces(edges[own.edge], own.t0, own.t1, wall, base, own.gap_mm))
