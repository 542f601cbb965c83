"""Seams of groups that a part holds several times: found once, then moved to the copies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, islice, pairwise

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.repeats import Copy
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.seam import NamedSolids, Seam, SeamPieces


@dataclass(frozen=True, slots=True, eq=False)
class CopiedSeams:
    """Seams of a part, and which of them were copied."""

    seams: tuple[Seam, ...]  #: length n. Those that were searched come first, then their copies.
    first: IntArray  #: shape (n,). The seam that each one was copied from; its own number if it was searched.
    movers: tuple[Mover, ...] = ()  #: The copies of the part.
    mover: IntArray | None = None  #: shape (n,). The copy to which a seam belongs; -1 if it is judged by itself.
    alike: IntArray | None = None  #: shape (S,). The solid that each one is a copy of, or itself.

    @classmethod
    def none(cls, seams: Sequence[Seam]) -> CopiedSeams:
        """Return seams that were all searched."""
        return cls(tuple(seams), np.arange(len(seams)))

    @classmethod
    def of(
        cls, graph: BrepGraph, seams: Sequence[Seam], copies: Sequence[Copy], same: Sequence[int] | None = None
    ) -> CopiedSeams:
        """Copy seams.

        `same`: For each copy, the one that is judged for it (`brep.repeats.same_neighbourhoods`); -1, the default, for
        the first group.
        """
        alike = np.arange(len(graph.solid_names))
        for copy in copies:
            alike[copy.group.solids] = copy.first.solids
        places = SolidPlaces(graph.solid_names, alike, _middles(graph))
        movers = tuple(Mover.of(places, copy) for copy in copies)
        face = np.array([max(int(seam.pieces.wall[0]), int(seam.pieces.base[0])) for seam in seams], dtype=np.int64)
        solid = np.where(face < 0, -1, graph.face_solid[face]) if len(seams) else face
        rows = [np.flatnonzero(np.isin(solid, mover.copy.first.solids)) for mover in movers]
        moved = [
            seam
            for mover, own in zip(movers, rows, strict=True)
            for seam in mover.moved([seams[i] for i in own.tolist()])
        ]
        at = np.cumsum([len(seams), *(len(own) for own in rows)])
        first, of_mover, judging = [np.arange(len(seams))], [np.full(len(seams), -1)], list(movers)
        for number, own in enumerate(rows):
            judged = -1 if same is None else same[number]
            is_own = judged == number
            first.append(own if judged < 0 else at[judged] + np.arange(len(own)))
            of_mover.append(np.full(len(own), -1 if is_own else number))
            if judged >= 0 and not is_own:
                judging[number] = Mover.of(places, Copy(copies[judged].group, copies[number].group))
        return cls((*seams, *moved), np.concatenate(first), tuple(judging), np.concatenate(of_mover), alike)

    def like(self, count: int) -> IntArray:
        """Return, for each of `count` solids, the solid that it is a copy of, or itself; shape (count,)."""
        return np.arange(count) if self.alike is None else self.alike

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
class SolidPlaces:
    """Where the solids of a part are."""

    names: tuple[str, ...]  #: length S.
    alike: IntArray  #: shape (S,). The solid that each one is a copy of, or itself.
    middle: FloatArray  #: shape (S, 3). Of its vertices, mm.


class MovedNames(dict[str, str]):
    """The name of each solid at a copy, by its name at the first group; that of a solid around it is looked up."""

    def __init__(self, places: SolidPlaces, copy: Copy) -> None:
        pairs = zip(copy.first.solids.tolist(), copy.group.solids.tolist(), strict=True)
        super().__init__((places.names[one], places.names[other]) for one, other in pairs)
        self.places, self.shift_mm = places, copy.shift_mm

    def __missing__(self, name: str) -> str:
        own = self.places.names.index(name)
        alike = np.flatnonzero(self.places.alike == self.places.alike[own])
        off = self.places.middle[alike] - self.places.middle[own] - self.shift_mm
        self[name] = self.places.names[alike[np.argmin(np.linalg.norm(off, axis=1))]]
        return self[name]


def _middles(graph: BrepGraph) -> FloatArray:
    count, solid = len(graph.solid_names), graph.vertex_solid
    own = solid >= 0
    number = np.maximum(np.bincount(solid[own], minlength=count), 1)
    sums = [np.bincount(solid[own], weights=graph.vertex_p[own, k], minlength=count) for k in range(3)]
    return np.asarray(np.stack(sums, axis=1) / number[:, None])


@dataclass(frozen=True, slots=True, eq=False)
class Mover:
    """Moves seams of a group to its copy."""

    copy: Copy
    names: Mapping[str, str]  #: The name of each solid in the copy, by its name in the first group.

    @classmethod
    def of(cls, places: SolidPlaces, copy: Copy) -> Mover:
        """Prepare for moving to a copy."""
        return cls(copy, MovedNames(places, copy))

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
