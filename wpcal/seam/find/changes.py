"""Changes of the side along a run of contacts that a welder does not make: too short, or where a border only touches.

A ring on a plate may touch the border of the plate at one point. Near that point the plate goes on in front of the
ring by less than the tolerance for a flush edge. The weld is still one fillet round the ring. Where a border crosses
the run at an angle, the base runs out in the same way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from wpcal.brep.curves import arc_length
from wpcal.brep.graph import BrepGraph
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import IntArray
from wpcal.seam.chain import Chain, chain_pieces
from wpcal.seam.find.contact import EdgeContacts
from wpcal.seam.find.sides import CONTINUES, Sides, Stretches, find_sides, step_mm
from wpcal.seam.limits import LEAST_CHANGE_MM
from wpcal.seam.seam import SeamPieces

SMOOTH_RAD = float(np.radians(30.0))
"""Contacts go on in each other if the direction turns by at most this: a square corner begins another run."""
RUN_OUT_SHARE = 1 / 3
"""The base only runs out if the stretch without it is at most this share of what is beside the stretch."""
NEAR_SHARE = 0.1  #: Where the base runs out gradually, it is still there at this share of the stretch from its end …
LEDGE_SHARE = 0.25  #: … if this share of the usual ledge is asked for. At a notch in the base, nothing of it is there.


@dataclass(frozen=True, slots=True)
class _Part:
    """Consecutive pieces of a run with the weld on one side."""

    kind: int
    rows: tuple[int, ...]
    length_mm: float


def without_small_changes(
    graph: BrepGraph, trimmed: TrimmedFaces, contacts: EdgeContacts, stretches: Stretches, *, gap_mm: float
) -> Stretches:
    """Give stretches the side of their neighbours where the change is not one; join equal neighbours on one contact.

    `gap_mm`: The gap with which they were found, mm.
    Returns Stretches. A change of the side is at least `LEAST_CHANGE_MM` long, or another run begins there.
    """
    at = stretches.at
    edge, face = contacts.edge[at.contact], contacts.face[at.contact]
    key = graph.edge_solid[edge] * graph.face_count + face
    rows = np.flatnonzero(np.isin(key, key[stretches.is_cut]) & at.has_wall)
    if len(rows) == 0:
        return stretches
    gaps = contacts.gap_mm[at.contact[rows]]
    pieces = SeamPieces(edge[rows], stretches.t0[rows], stretches.t1[rows], at.wall[rows], face[rows], gaps)
    kind = at.kind[rows]
    like = np.arange(len(rows))
    for chain in chain_pieces(graph, pieces, key[rows], split_rad=SMOOTH_RAD):
        if len(chain.rows) > 1:
            run = _Run.of(trimmed, contacts, at.contact[rows], pieces, chain, gap_mm)
            for own, other in run.small_changes(kind):
                like[own] = other
    changed = np.flatnonzero(like != np.arange(len(rows)))
    sides = _like(graph, contacts, at, rows[changed], rows[like[changed]])
    return _merged(replace(stretches, at=sides))


@dataclass(frozen=True, slots=True, eq=False)
class _Run:
    """Pieces that continue each other."""

    #: `graph`, `trimmed`, `contacts`: The part and its contacts.
    graph: BrepGraph
    trimmed: TrimmedFaces
    contacts: EdgeContacts
    contact: IntArray  #: shape (k,). The contact of each piece.
    pieces: SeamPieces  #: k pieces, of this run and of others.
    chain: Chain  #: The run.
    flip: dict[int, bool]  #: Which of its pieces are reversed.
    length_mm: dict[int, float]  #: The length of each of its pieces.
    gap_mm: float

    @classmethod
    def of(
        cls,
        trimmed: TrimmedFaces,
        contacts: EdgeContacts,
        contact: IntArray,
        pieces: SeamPieces,
        chain: Chain,
        gap_mm: float,
    ) -> _Run:
        """Measure the pieces of a chain."""
        graph = trimmed.graph
        rows = chain.rows.tolist()
        length = {
            row: abs(arc_length(graph, int(pieces.edge[row]), float(pieces.t0[row]), float(pieces.t1[row])))
            for row in rows
        }
        flip = dict(zip(rows, chain.flip.tolist(), strict=True))
        return cls(graph, trimmed, contacts, contact, pieces, chain, flip, length, gap_mm)

    def small_changes(self, kind: IntArray) -> list[tuple[int, int]]:
        """Return the pieces that take their side from another one, each with that one."""
        parts = [_Part(int(kind[row]), (row,), self.length_mm[row]) for row in self.chain.rows.tolist()]
        found: dict[int, int] = {}
        while True:
            parts = _regrouped(parts, is_closed=self.chain.closed)
            ways = [(part.length_mm, i) for i, part in enumerate(parts) if self._is_small(parts, i)]
            if not ways:
                return list(found.items())
            _, i = min(ways)
            other = max(self._beside(parts, i), key=lambda one: one.length_mm)
            model = max(other.rows, key=lambda row: self.length_mm[row])
            model = found.get(model, model)
            found |= dict.fromkeys(parts[i].rows, model)
            parts[i] = replace(parts[i], kind=int(kind[model]))

    def _beside(self, parts: list[_Part], i: int) -> list[_Part]:
        """Return the parts before and after one."""
        before, after = self._neighbours(parts, i)
        return [part for part in (before, after) if part is not None]

    def _neighbours(self, parts: list[_Part], i: int) -> tuple[_Part | None, _Part | None]:
        if len(parts) == 1:
            return None, None
        before = parts[i - 1] if i or self.chain.closed else None
        after = parts[(i + 1) % len(parts)] if i + 1 < len(parts) or self.chain.closed else None
        return before, after

    def _is_small(self, parts: list[_Part], i: int) -> bool:
        """Tell whether the side of a part is that of its neighbours: it is short, or the base runs out there."""
        part, (before, after) = parts[i], self._neighbours(parts, i)
        beside = [other for other in (before, after) if other is not None]
        around = sum(other.length_mm for other in beside) / (2 if before is after and before is not None else 1)
        if not beside or part.length_mm > around:
            return False
        if part.length_mm <= LEAST_CHANGE_MM:
            return True
        runs_out = part.kind != CONTINUES and {other.kind for other in beside} == {CONTINUES}
        return (
            runs_out
            and part.length_mm <= RUN_OUT_SHARE * around
            and (before is None or _runs_out(self, part, at_end=False))
            and (after is None or _runs_out(self, part, at_end=True))
        )


def _regrouped(parts: list[_Part], *, is_closed: bool) -> list[_Part]:
    """Join neighbours of one kind, round the start of a loop as well."""
    grouped = []
    for kind, group in groupby(parts, key=lambda part: part.kind):
        own = list(group)
        grouped.append(
            _Part(kind, tuple(row for part in own for row in part.rows), sum(part.length_mm for part in own))
        )
    if is_closed and len(grouped) > 1 and grouped[0].kind == grouped[-1].kind:
        last = grouped.pop()
        grouped[0] = _Part(last.kind, last.rows + grouped[0].rows, last.length_mm + grouped[0].length_mm)
    return grouped


def _runs_out(run: _Run, part: _Part, *, at_end: bool) -> bool:
    """Tell whether the base runs out gradually where a part borders on its neighbour: it has no step there."""
    row = part.rows[-1 if at_end else 0]
    t0, t1 = float(run.pieces.t0[row]), float(run.pieces.t1[row])
    start, end = (t0, t1) if bool(run.flip[row]) == at_end else (t1, t0)
    share = min(NEAR_SHARE * part.length_mm / run.length_mm[row], 0.5)
    t = np.array([start + share * (end - start)])
    ledge_mm = LEDGE_SHARE * step_mm(run.gap_mm)
    contact = run.contact[[row]]
    return bool(find_sides(run.graph, run.trimmed, run.contacts, contact, t, ledge_mm=ledge_mm).continues[0])


def _like(graph: BrepGraph, contacts: EdgeContacts, at: Sides, rows: IntArray, model: IntArray) -> Sides:
    """Return sides of which those at `rows` have the base of those at `model`, or go on like them."""
    base, n_base, continues = at.base.copy(), at.n_base.copy(), at.continues.copy()
    goes_on = at.continues[model]
    base[rows] = np.where(goes_on, contacts.face[at.contact[rows]], at.base[model])
    n_base[rows] = project_to_faces(graph, base[rows], at.p[rows]).normal
    continues[rows] = goes_on
    return replace(at, base=base, n_base=n_base, continues=continues)


def _merged(stretches: Stretches) -> Stretches:
    """Join stretches that follow each other on one contact and no longer differ."""
    at = stretches.at
    first = np.ones(len(at.t), dtype=bool)
    same = [column[1:] == column[:-1] for column in (at.contact, at.kind, at.base, at.wall)]
    first[1:] = ~np.logical_and.reduce(same)
    group = np.cumsum(first) - 1
    begin = np.flatnonzero(first)
    last = np.append(begin[1:], len(first)) - 1
    longest = np.lexsort((np.abs(stretches.t0 - stretches.t1), group))[last] if len(group) else begin
    is_cut = np.bincount(at.contact[begin], minlength=1)[at.contact[begin]] > 1
    return Stretches(stretches.t0[begin], stretches.t1[last], at.select(longest), is_cut)
