"""Seams of groups that a part holds several times: found once, then moved to the copies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.repeats import Copy
from wpcal.core.arrays import IntArray
from wpcal.seam.seam import NamedSolids, Seam, SeamFrames, SeamPieces


@dataclass(frozen=True, slots=True, eq=False)
class CopiedSeams:
    """Seams of a part, and which of them were copied.

    Parameters
    ----------
    seams : tuple of Seam, length n
        Those that were searched come first, then their copies.
    first : ndarray of int, shape (n,)
        The seam that each one was copied from; its own number if it was searched.
    movers : tuple of Mover
        The copies of the part.
    mover : ndarray of int, shape (n,)
        The copy to which a seam belongs; -1 if it was searched.
    """

    seams: tuple[Seam, ...]
    first: IntArray
    movers: tuple[Mover, ...] = ()
    mover: IntArray | None = None

    @classmethod
    def none(cls, seams: Sequence[Seam]) -> CopiedSeams:
        """Return seams that were all searched."""
        return cls(tuple(seams), np.arange(len(seams)))

    @classmethod
    def of(cls, graph: BrepGraph, seams: Sequence[Seam], copies: Sequence[Copy]) -> CopiedSeams:
        """Copy seams.

        Parameters
        ----------
        graph : BrepGraph
            The whole part, with the edges of all copies.
        seams : sequence of Seam
            Of the first groups, with faces and edges of this graph.
        copies : sequence of Copy
        """
        movers = tuple(Mover.of(graph, copy) for copy in copies)
        face = np.array([max(int(seam.pieces.wall[0]), int(seam.pieces.base[0])) for seam in seams], dtype=np.int64)
        solid = np.where(face < 0, -1, graph.face_solid[face]) if len(seams) else face
        rows = [np.flatnonzero(np.isin(solid, mover.copy.first.solids)) for mover in movers]
        moved = [mover.moved(seams[row]) for mover, own in zip(movers, rows, strict=True) for row in own.tolist()]
        own = np.arange(len(seams))
        mover = np.repeat(np.arange(-1, len(movers)), [len(seams), *(len(of) for of in rows)])
        return cls((*seams, *moved), np.concatenate([own, *rows]), movers, mover)

    def moved(self, row: int, seams: Sequence[Seam]) -> list[Seam]:
        """Return what was made of the first of a copied seam, moved to the copy."""
        if self.mover is None or self.mover[row] < 0:
            return list(seams)
        return [self.movers[self.mover[row]].moved(seam) for seam in seams]


@dataclass(frozen=True, slots=True, eq=False)
class Mover:
    """Moves seams of a group to its copy.

    Parameters
    ----------
    copy : Copy
    names : dict
        The name of each solid in the copy, by its name in the first group.
    """

    copy: Copy
    names: Mapping[str, str]

    @classmethod
    def of(cls, graph: BrepGraph, copy: Copy) -> Mover:
        """Prepare for moving to a copy."""
        solids = zip(copy.first.solids.tolist(), copy.group.solids.tolist(), strict=True)
        return cls(copy, {graph.solid_names[one]: graph.solid_names[other] for one, other in solids})

    def moved(self, seam: Seam) -> Seam:
        """Return the seam of the copy at the place of a seam of the first group."""
        pieces, frames, names = seam.pieces, seam.frames, self.names
        edge, wall, base = self.copy.edges_of(pieces.edge), *(self.copy.faces_of(f) for f in (pieces.wall, pieces.base))
        p = frames.p + self.copy.shift_mm
        return replace(
            seam,
            solids=tuple(names[solid] for solid in seam.solids),
            pieces=SeamPieces(edge, pieces.t0, pieces.t1, wall, base, pieces.gap_mm),
            frames=SeamFrames(frames.s_mm, p, frames.R, frames.angle_rad, frames.frame),
            reasons=tuple(text.told_of(names) if isinstance(text, NamedSolids) else text for text in seam.reasons),
            inside=tuple(names[solid] for solid in seam.inside),
            blocked_by=tuple(names[solid] for solid in seam.blocked_by),
        )


def renumbered(seam: Seam, faces: IntArray, edges: IntArray) -> Seam:
    """Return a seam with the numbers of its faces and edges in `faces`, shape (F,), and `edges`, shape (E,)."""
    own = seam.pieces
    wall, base = (np.where(face < 0, -1, faces[face]) for face in (own.wall, own.base))
    return replace(seam, pieces=SeamPieces(edges[own.edge], own.t0, own.t1, wall, base, own.gap_mm))
