"""What the shapes of two solids, and of the whole part, say against a weld between them.

It takes time to look at shapes. So each solid and each pair is looked at once, and only if nothing else refuses a
candidate between them. What takes longest is looked at for all such pairs of a part together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import IntArray
from wpcal.seam.find.built_up import is_turned
from wpcal.seam.judge.closed_in import find_held
from wpcal.seam.judge.held_fast import is_gasket, is_held_fast, is_ring_in_ring
from wpcal.seam.judge.rolling import has_round_tread
from wpcal.seam.member.heavy_bars import find_bar, why_timber
from wpcal.seam.member.member import THINNEST_MM, MemberKind
from wpcal.seam.member.members import members_of
from wpcal.seam.member.note import Members
from wpcal.seam.member.one_piece import OnePieces, signature
from wpcal.seam.rules import Rule
from wpcal.seam.seam import Finding

SMALLEST = 0.5
"""A solid that is smaller than this share of the nozzle in all directions is a contact, a spring or a pin: the smallest
weld nut has 9 mm."""
THINNEST_TUBE_MM, THINNEST_BAR_MM = 0.5, 6.0
"""Tubes of furniture have walls of 1 mm. The pool is wider than such bars both ways."""

RINGS = (
    (is_held_fast, Rule.HELD_FAST, "one of the two is a ring between two shoulders of the other"),
    (is_gasket, Rule.GASKET, "one of the two is a thin ring flat on the other, inside a circle of its bolt holes"),
    (is_ring_in_ring, Rule.RING_IN_RING, "a ring fills the bore of the other and ends with it on both sides"),
)
"""What is looked for between a round solid and another one, the first that is found."""


@dataclass(slots=True, eq=False)
class ShapeLooks:
    """Findings by shape about solids, pairs of solids and the part; each is found when somebody asks."""

    #: `graph`, `trimmed`: The part.
    graph: BrepGraph
    trimmed: TrimmedFaces
    members: Members  #: What its solids are taken for by names, materials and seats.
    gap_mm: float  #: Solids nearer than this touch.
    nozzle_mm: float  #: Diameter of the torch's nozzle.
    #: shape (S,). For each solid of a group that the part holds several times, the same solid in the first such group,
    #: which is looked at for all of them (`wpcal.seam.copies`); for any other solid, itself.
    like: IntArray
    _one_pieces: OnePieces = field(init=False)
    _pairs: dict[tuple[int, int], tuple[Finding, ...]] = field(default_factory=dict)
    _known: dict[tuple[object, ...], Any] = field(default_factory=dict)
    _held: dict[tuple[int, int], bool] = field(default_factory=dict)
    _part: tuple[Finding, ...] | None = None

    def __post_init__(self) -> None:
        self._one_pieces = OnePieces(self.graph, self.trimmed)

    def look_at(self, pairs: Iterable[Sequence[int]]) -> None:
        """Look at all pairs of solids together; `findings` then has less to ask of each."""
        pairs = [*pairs]
        self._one_pieces.look_at({solid for solids in pairs for solid in solids if not self.members[solid].said})
        asked = {self._first_pair(*solids) for solids in pairs if not all(self.members[solid].said for solid in solids)}
        new = sorted(asked - self._held.keys())
        is_held = find_held(self.graph, self.trimmed, np.reshape(new, (-1, 2)).astype(np.int64), self.gap_mm)
        self._held.update(zip(new, is_held.tolist(), strict=True))

    def findings(self, solids: Sequence[int]) -> Iterator[Finding]:
        """Yield the findings against a weld between two solids, given by number, that were looked at."""
        said = [self.members[solid].said for solid in solids]
        for solid, is_said in zip(solids, said, strict=True):
            why = None if is_said else self._one_pieces.why(solid)
            if why is not None:
                name = self.graph.solid_names[solid]
                yield Rule.ONE_PIECE.found(f"{name}: {why}", solid=name)
        if not all(said):
            a, b = sorted(solids)
            if (a, b) not in self._pairs:
                self._pairs[a, b] = tuple(self._of_pair(a, b))
            yield from self._pairs[a, b]
            if self._part is None:
                self._part = tuple(self._of_part())
            yield from self._part

    def _of_pair(self, a: int, b: int) -> Iterator[Finding]:
        small, large = sorted(self.trimmed.solid_sides_mm[[a, b]].max(axis=1).tolist())
        if large < self.nozzle_mm or small < SMALLEST * self.nozzle_mm:
            words = (
                f"both solids fit in {large:.3g} mm" if large < self.nozzle_mm else f"one solid fits in {small:.3g} mm"
            )
            yield Rule.SMALLER_THAN_NOZZLE.found(f"{words}; the nozzle of the torch has {self.nozzle_mm:g} mm")
        for solid in (a, b):
            thin = self._of_equals(_why_thin, solid)
            if thin:
                yield Rule.TOO_THIN.found(f"{self.graph.solid_names[solid]} is {thin}: an arc burns through it")
        for solid in (a, b):
            if self._of_equals(has_round_tread, solid):
                yield Rule.ROLLING.found(f"{self.graph.solid_names[solid]} is a wheel: it has a bore and a round tread")
        orders = ((a, b), (b, a))
        rings = RINGS if any(self._of_equals(is_turned, solid) for solid in (a, b)) else ()
        found = (rule.found(words) for look, rule, words in rings if any(self._once(look, *own) for own in orders))
        closed_in = Rule.CLOSED_IN.found("no straight move takes the two apart: one was closed round the other")
        seat = next(found, closed_in if self._held[self._first_pair(a, b)] else None)
        if seat is not None:
            yield seat

    def _of_part(self) -> Iterator[Finding]:
        members = self.members.notes.members
        if any(one.metal is not None and not one.findings for one in members):
            return
        why = why_timber(self.graph, self.trimmed, [k for k, one in enumerate(members) if not one.findings])
        if why is not None:
            yield Rule.TIMBER.found(why)

    def _first_pair(self, a: int, b: int) -> tuple[int, int]:
        """Return the pair that is looked at for this one."""
        first, second = sorted((int(self.like[a]), int(self.like[b])))
        return first, second

    def _once(self, look: Callable[..., Any], *solids: int) -> Any:
        """Return what a look at one solid, or at two that touch, finds; asked once for all their copies."""
        first = tuple(self.like[list(solids)].tolist())
        if (look, *first) not in self._known:
            gap = (self.gap_mm,) if len(solids) == 2 else ()
            self._known[look, *first] = look(self.graph, self.trimmed, *first, *gap)
        return self._known[look, *first]

    def _of_equals(self, look: Callable[[BrepGraph, TrimmedFaces, int], Any], solid: int) -> Any:
        """Return what a look at one solid finds, however the solid lies; asked once for all equal solids."""
        key = look, signature(self.graph, self.trimmed, int(self.like[solid]))
        if key not in self._known:
            self._known[key] = look(self.graph, self.trimmed, solid)
        return self._known[key]


def _why_thin(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> str:
    """Say how thin a sheet or bar is that an arc burns through; empty for another solid."""
    found, bar = members_of(graph, trimmed, solid), find_bar(graph, trimmed, solid)
    (only,) = found.members if found.is_one and len(found.members) == 1 else (None,)
    is_tube = only is not None and only.kind in (MemberKind.TUBE, MemberKind.ROUND)
    if bar is not None and bar.thick < (THINNEST_TUBE_MM if is_tube else THINNEST_MM):
        return f"{bar.thick:.2g} mm thick"
    thick, wide = (0.0, np.inf) if only is None else sorted((*only.section.tolist(), only.length_mm))[:2]
    return f"a bar of {thick:.2g} x {wide:.2g} mm" if thick > 0.0 and wide < THINNEST_BAR_MM else ""
