"""What every solid of a part is taken for, whether it can be welded, and why."""

from __future__ import annotations

import difflib
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

from wpcal.brep.graph import BrepGraph
from wpcal.brep.solid_facts import SolidFacts, facts_of
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.errors import ErrorCode, InputError
from wpcal.seam.find.bead_bodies import bead_bodies
from wpcal.seam.find.covered import covered_by
from wpcal.seam.member.fasteners import Fastener, find_fasteners
from wpcal.seam.member.names import Hit, read_material, read_name
from wpcal.seam.member.words import IRON, METALS, NOT_METAL, Kind
from wpcal.seam.options import CAST, KINDS, Judging, Play
from wpcal.seam.rules import Rule
from wpcal.seam.seam import Finding, Seam

if TYPE_CHECKING:
    from wpcal.seam.member.listed import Listed

LIGHTEST_METAL_KG_M3 = 1600.0
"""Magnesium, the lightest metal that is welded, has 1740; glass-filled plastic may have 1600."""
NO_MATERIAL_KG_M3 = 1000.0  #: What programs write if nobody chose a material.
NEAREST_NAMES = 3  #: Names shown for a pattern that fits no solid.
ONE_PIECE_WORDS = "made in one piece"  #: What a solid is taken for that is cast, moulded, printed or milled.
BEAD_WORDS = "shape: it fills the corner between members, where its seam is"
_NUMBER = re.compile(r"#\d+$")


@dataclass(frozen=True, slots=True)
class Member:
    """What one solid is taken for."""

    solid: str
    taken_as: str  #: In words: ``steel``, ``a bolt or screw``, ``wood``.
    findings: tuple[Finding, ...]  #: What speaks against welding it; empty for a member.
    why: tuple[str, ...]  #: The evidence in words, also that for a member.
    metal: Kind | None = None  #: The metal, if it is known.
    said: bool | None = None  #: Whether a person said that it can be welded.

    @property
    def factor(self) -> float:
        """The score of each of its seams is multiplied by it."""
        product = 1.0
        for finding in self.findings:
            product *= finding.factor
        return product

    def to_record(self) -> dict[str, Any]:
        """Return the entry of a solid in ``seams.json``."""
        factor = round(self.factor, 4)
        return {
            "solid": self.solid,
            "taken_as": self.taken_as,
            "factor": factor,
            "why": list(self.why),
            "said": self.said,
        }


@dataclass(frozen=True, slots=True)
class MemberNotes:
    """What the solids of a part are taken for, and what a person said about them."""

    judging: Judging
    members: tuple[Member, ...]  #: In the order of the solids.
    play: tuple[Play, ...] = ()  #: The gaps that joints of the part have by design.
    listed: tuple[Listed, ...] = ()  #: The members of the solids, with sizes and weights, if somebody asked for them.
    unused: tuple[str, ...] = ()  #: Patterns of a person that decide about no solid of this part.

    def with_shapes(self, seams: Sequence[Seam]) -> MemberNotes:
        """Return the notes with what the seams of the part told about the shapes of solids (`Rule.ONE_PIECE`)."""
        found = {one.solid: one for seam in seams for one in seam.findings if one.rule == Rule.ONE_PIECE.key}
        members = tuple(
            one
            if one.solid not in found or one.findings
            else replace(one, taken_as=ONE_PIECE_WORDS, findings=(found[one.solid],), why=(found[one.solid].text,))
            for one in self.members
        )
        return replace(self, members=members)

    def with_whole(self, whys: Mapping[int, str]) -> MemberNotes:
        """Return the notes of a part whose solids were made in one piece, with the reasons by number of the solid."""
        members = tuple(
            replace(one, taken_as=ONE_PIECE_WORDS, findings=(Rule.ONE_PIECE.found(whys[row]),), why=(whys[row],))
            if row in whys and not one.findings and one.said is None
            else one
            for row, one in enumerate(self.members)
        )
        return replace(self, members=members)

    def to_record(self, seams: Sequence[Seam] = ()) -> dict[str, Any]:
        """Return the entries ``judging``, ``members`` and ``play`` of ``seams.json``, with the seams on members."""
        said, listed, on = self.judging, defaultdict[str, dict[str, Any]](dict), defaultdict[int, list[Seam]](list)
        words = [{"member": one.member, "is": one.word, "at_part_mm": one.at_mm} for one in said.members]
        for seam in (seam for seam in seams if self.listed and seam.accepted):
            for face in {*seam.pieces.wall.tolist(), *seam.pieces.base.tolist()}:
                on[face].append(seam)
        for one in self.listed:
            listed[self.members[one.solid].solid].setdefault("listed", []).append(one.to_record(on))
        return {
            "judging": {
                "weld": list(said.weld),
                "not": list(said.not_welded),
                **({"members": words} if words else {}),
                "level": said.level.name.lower(),
                "least_confidence": said.level.value,
            },
            "members": [{**one.to_record(), **listed[one.solid]} for one in self.members],
            "play": [{"gap_mm": one.gap_mm, "joints": one.joints} for one in self.play],
        }


@dataclass(frozen=True, slots=True, eq=False)
class Members:
    """The solids of a part, and which of them are fasteners by shape."""

    notes: MemberNotes
    fasteners: dict[int, Fastener]  #: By number of the solid.

    def __getitem__(self, solid: int) -> Member:
        return self.notes.members[solid]


def take_members(graph: BrepGraph, trimmed: TrimmedFaces, judging: Judging) -> Members:
    """Say of every solid what it is taken for.

    A pattern with a star may fit no solid, as one that a shop says for every part.

    Raises `InputError` if a name of `judging` is that of no solid.
    """
    facts = [facts_of(graph.solid_facts, solid) for solid in range(len(graph.solid_names))]
    named = zip(graph.solid_names, facts, strict=True)
    labels = [tuple(dict.fromkeys((name, plain_name(name), *fact.products, *fact.path))) for name, fact in named]
    said = _said(labels, judging)
    fasteners = find_fasteners(graph, trimmed)
    instead, beads = covered_by(graph, trimmed), set(bead_bodies(graph, trimmed).tolist())
    common = set.intersection(*(set(own) for own in labels)) if len(labels) > 1 else set()
    members = []
    for solid, name in enumerate(graph.solid_names):
        if solid in beads:
            members.append(Member(name, "a weld bead", (), (BEAD_WORDS,)))
            continue
        first = graph.solid_names[instead[solid]] if instead[solid] >= 0 else None
        own = _Evidence(name, facts[solid], common, fasteners.get(solid), first)
        members.append(own.member(said[solid]))
    used = {typed.partition(" ")[2] for _, typed in filter(None, said)}
    unused = tuple(one for one in (*judging.weld, *judging.not_welded) if one not in used)
    return Members(MemberNotes(judging, tuple(members), unused=unused), fasteners)


@dataclass(frozen=True, slots=True)
class _Evidence:
    """What is known about one solid."""

    name: str
    facts: SolidFacts
    common: set[str]  #: Names that belong to all solids of the part: they say nothing about one of them.
    fastener: Fastener | None
    copy_of: str | None = None  #: The solid that fills its room and counts instead of it.

    def member(self, said: tuple[bool, str] | None) -> Member:
        written = [hit for hit in (read_material(text) for text in self.facts.materials) if hit is not None][:1]
        named = read_name(plain_name(self.name)) if plain_name(self.name) not in self.common else ()
        metal = next((hit.kind for hit in (*written, *named) if hit.kind in METALS), None)
        if said is not None:
            can, typed = said
            words = f"you said so ({typed})"
            said_not = () if can else (Rule.SAID_NOT.found(f"{self.name} is not welded: {words}"),)
            return Member(self.name, "a member" if can else "not welded", said_not, (words,), metal, can)
        if named and named[0].kind is Kind.WELD_NUT and self.copy_of is None:
            return Member(self.name, Kind.WELD_NUT.value, (), (f"name: {named[0].word}",), metal)
        against = list(self._against(written, named))
        material = "; ".join(self.facts.materials)
        why = [f"material: {material}"] if written and written[0].kind in METALS else []
        why += [f"name: {hit.word}" for hit in named if not written and hit.kind in METALS]
        if not against:
            taken = metal.value if metal is not None else "a member"
            return Member(self.name, taken, (), tuple(why) or ("nothing speaks against welding it",), metal)
        findings = tuple(finding for finding, _, _ in against)
        return Member(self.name, against[0][1], findings, tuple(text for _, _, text in against), metal)

    def _against(self, written: list[Hit], named: tuple[Hit, ...]) -> Iterator[tuple[Finding, str, str]]:
        """Yield the findings against welding a solid, what it is then taken for, and the evidence in words."""
        if self.copy_of is not None:
            words = f"fills the same room as {self.copy_of}"
            yield Rule.SAME_ROOM.found(f"{self.name} {words}: only one of the two can be a member"), "a copy", words
        if self.fastener is not None:
            what = self.fastener.what
            yield Rule.FASTENER.found(f"{self.name} is {what}"), what, "shape and seat"
        yield from self._material(written, named)
        thing = next((hit for hit in named if hit.kind not in METALS | NOT_METAL), None)
        if thing is not None and self.fastener is None:
            rule = Rule.STANDARD_PART if thing.is_standard else Rule.NAMED_PART
            yield self._found(rule, thing, f"name: {thing.word}")
        elif thing is None and self.fastener is None:
            above = next(self._above(), None)
            if above is not None and not (written and written[0].kind in METALS and above[1].kind in NOT_METAL):
                yield self._found(Rule.NAMED_ABOVE, above[1], f"name above: {above[0]}")

    def _material(self, written: list[Hit], named: tuple[Hit, ...]) -> Iterator[tuple[Finding, str, str]]:
        density = self.facts.density_kg_m3
        stuff = next((hit for hit in named if hit.kind in NOT_METAL), None)
        if written:
            if written[0].kind in NOT_METAL:
                yield self._found(Rule.NOT_METAL_WRITTEN, written[0], f"material: {'; '.join(self.facts.materials)}")
        elif stuff is not None:
            yield self._found(Rule.NOT_METAL_NAMED, stuff, f"name: {stuff.word}")
        elif density is not None and density < LIGHTEST_METAL_KG_M3 and abs(density - NO_MATERIAL_KG_M3) > 0.5:
            text = f"density {density:.0f} kg/m³"
            finding = Rule.NOT_METAL_DENSITY.found(f"{self.name} is too light for a metal ({text})")
            yield finding, "wood, plastic or foam", text

    def _found(self, rule: Rule, hit: Hit, evidence: str) -> tuple[Finding, str, str]:
        return rule.found(f"{self.name} is taken for {hit.kind.value} ({evidence})"), hit.kind.value, evidence

    def _above(self) -> Iterator[tuple[str, Hit]]:
        """Yield the names above a solid, the nearest first, with what they say against welding it."""
        own = plain_name(self.name)
        for name in reversed(dict.fromkeys((*self.facts.products, *self.facts.path))):
            if name == own or name in self.common:
                continue
            hit = next((one for one in read_name(plain_name(name)) if one.kind not in METALS), None)
            if hit is not None and hit.kind is not Kind.WELD_NUT:
                yield name, hit


def plain_name(name: str) -> str:
    """Return the name of a solid without the number that tells it from others of the same name."""
    return _NUMBER.sub("", name)


def _said(labels: Sequence[tuple[str, ...]], judging: Judging) -> list[tuple[bool, str] | None]:
    """Return for each solid what a person said, with the words of a command."""
    found: list[tuple[bool, str] | None] = [None] * len(labels)
    patterns = [(name, True, f"--weld {name}") for name in judging.weld]
    patterns += [(name, False, f"--not {name}") for name in judging.not_welded]
    kinds = (one for one in judging.members if one.word in KINDS)
    patterns += [(one.member, one.word != CAST, f"--member {one.member}={one.word}") for one in kinds]
    for pattern, can, typed in sorted(patterns, key=lambda item: (_letters(item[0]), not item[1])):
        plain = pattern.casefold().replace("[", "[[]")
        fitting = [row for row, own in enumerate(labels) if any(fnmatchcase(one.casefold(), plain) for one in own)]
        if not fitting and _letters(pattern) == len(pattern) and not typed.startswith("--member"):
            raise InputError(_unknown(pattern, labels), code=ErrorCode.SOLID_UNKNOWN)
        for row in fitting:
            found[row] = (can, typed)
    return found


def _letters(pattern: str) -> int:
    return len(pattern.replace("*", "").replace("?", ""))


def _unknown(pattern: str, labels: Sequence[tuple[str, ...]]) -> str:
    names = {one.casefold(): one for own in labels for one in own}
    wanted = pattern.casefold().replace("*", "").replace("?", "")
    near = difflib.get_close_matches(wanted, names, NEAREST_NAMES, 0.3) or sorted(names)[:NEAREST_NAMES]
    return (
        f"no solid, product or instance has the name {pattern!r}; the nearest are {', '.join(names[k] for k in near)}"
    )


def are_welded(a: Kind, b: Kind) -> bool:
    """Tell whether two metals are welded to each other."""
    return a is b or {a, b} <= IRON
