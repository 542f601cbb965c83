"""How sure the rules are that a candidate is a weld: the findings for and against it, in words and as a number.

Each finding multiplies a score by the factor of its rule (`wpcal.seam.rules`).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wpcal.brep.curves import edge_lengths
from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.surfaces import off_axis
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.wording import short
from wpcal.seam.find.formed import are_bends, is_cut
from wpcal.seam.find.play import is_play, with_play
from wpcal.seam.find.tubes import THIN_WALL
from wpcal.seam.judge.hiding import hiding_words
from wpcal.seam.judge.rolling import find_rolling
from wpcal.seam.judge.shape_looks import ShapeLooks
from wpcal.seam.judge.stretches import in_material_words
from wpcal.seam.judge.unreached import blocked_words
from wpcal.seam.limits import GAP_ROUND_OFF_MM, LENGTH_ROUND_OFF_MM, Level
from wpcal.seam.member.clamped import BESIDE_MM, Clamp, Holes, find_bolt_holes, find_clamps
from wpcal.seam.member.member import MemberKind
from wpcal.seam.member.members import members_of
from wpcal.seam.member.note import Members, are_welded, take_members
from wpcal.seam.member.said import Said, said_about
from wpcal.seam.options import ConcaveEdges, Play, Reach, SeamOptions
from wpcal.seam.rules import GAP_SHARE_LOST, Rule, confidence_of
from wpcal.seam.seam import Finding, Seam, SeamSource

OF_WHOLE_PART = frozenset({Rule.BURIED.key, Rule.FIXES_BOLTED.key, Rule.LEFT_OVER.key, Rule.SHORT_END.key})
"""Findings that need all seams of the part: they stay when a part of them is judged again."""
INSIDE = frozenset({SeamSource.CONCAVE, SeamSource.BEAD, SeamSource.DRAWN})  #: Candidates inside a solid.
BETWEEN_TWO = frozenset({SeamSource.CONTACT, SeamSource.SECTION, SeamSource.FLARE})  #: Candidates that join two solids.
FELT_GAP = 0.1  #: Gaps below this fraction of the allowed gap do not lower the score.
AROUND = 0.1  #: A seam runs round an axis if the cosine between the two is below this everywhere (84 degrees).
MOSTLY_ROLLED = 0.9  #: A seam is the root of a rolled profile if this much of its length is.
STRAIGHT_WORDS, MISSED_WORDS = "are free for a torch that does not lean", "the torch does not get there at"
"""How the reasons about reach end and begin."""
WIRE_WORDS = "mm of wire are needed from its tip to the nozzle"  #: How the reason about a longer wire goes on.
ASSUMED_MARK = " (assumed: "  #: How the words about the assumed torch begin, at the end of a finding.


def judge_seams(
    graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], options: SeamOptions, judge: Judge
) -> tuple[Seam, ...]:
    """Compute the confidence of every candidate, with the reasons.

    Returns tuple of Seam. With `reachable`, `confidence`, `accepted`, `reasons` and `findings`.
    """
    if not seams:
        return ()
    concave = _concave_evidence(graph, trimmed, seams) if options.concave is ConcaveEdges.AUTO else {}
    found = []
    for row, seam in enumerate(seams):
        kept = (finding for finding in seam.findings if finding.rule in OF_WHOLE_PART)
        is_joint = row in concave and judge.said.are_joints(seam.pieces.wall, seam.pieces.base).all()
        found.append([*judge.evidence(seam), *(() if is_joint else concave.get(row, ())), *kept])
    judge.add_shape_evidence(seams, found)
    judged = []
    for seam, own in zip(seams, found, strict=True):
        reasons = (seam.source.value, *seam.reasons, *_reach_words(seam, judge.reach))
        reachable = not (seam.inside or seam.blocked_by)
        judged.append(replace(seam, reachable=reachable, reasons=reasons, **_weight(seam, own, judge.level)))
    return tuple(judged)


def weighed(seam: Seam, findings: Iterable[Finding], level: Level) -> Seam:
    """Return a seam with its findings, the confidence that follows from them, and whether it is accepted."""
    return replace(seam, **_weight(seam, findings, level))


def _weight(seam: Seam, findings: Iterable[Finding], level: Level) -> dict[str, Any]:
    """Return the fields of a seam that follow from its findings."""
    found = tuple(sorted(findings, key=lambda finding: finding.factor))
    confidence = confidence_of(seam.source, found)
    sure = confidence >= level.value or seam.source.is_chosen
    accepted = sure and not (seam.inside or seam.blocked_by)
    return {"findings": found, "confidence": confidence, "accepted": accepted}


def assumed_words(reach: Reach) -> str:
    """Say which torch a verdict about reach is for, and what would change it."""
    yours = "if yours is another one, state it with --torch, or accept the seam by an edit"
    return f"{ASSUMED_MARK}{reach.torch}; {yours})"


def _reach_words(seam: Seam, reach: Reach) -> tuple[str, ...]:
    """Say how a torch gets to a seam, with how much wire, and at how many of its frames it does not."""
    if seam.lean_rad is None or seam.blocked_by or seam.inside:
        return ()
    count = len(seam.lean_rad)
    missed = int(np.isnan(seam.lean_rad[:, 0]).sum())
    straight = int((seam.lean_rad == 0).all(axis=1).sum())
    words = [f"{straight} of {count} frames {STRAIGHT_WORDS}"]
    if missed:
        words.append(f"{MISSED_WORDS} {missed} of {count} frames")
    if seam.more_wire_mm:
        usual = reach.torch.wire_mm
        words.append(f"{usual + seam.more_wire_mm:g} {WIRE_WORDS}: {seam.more_wire_mm:g} mm more than usual")
    return tuple(words)


def is_judgement(text: str, source: SeamSource) -> bool:
    """Tell whether a reason was added by `judge_seams`, which is to judge again."""
    is_reach = text.endswith(STRAIGHT_WORDS) or text.startswith(MISSED_WORDS) or WIRE_WORDS in text
    return text == source.value or is_reach


@dataclass(frozen=True, slots=True, eq=False)
class Judge:
    """What is known about a part before its seams are judged."""

    graph: BrepGraph
    number: dict[str, int]  #: Numbers of the solids by their names.
    members: Members
    said: Said  #: What a person says about members.
    rolling: dict[int, str]  #: Solids that roll or lie loose, with the words for it.
    holes: Holes
    hole_of_face: dict[int, int]  #: The row of each face in `holes`.
    clamps: dict[tuple[int, int], list[Clamp]]  #: By the numbers of the two solids, ascending.
    #: `gap_mm`, `min_length_mm`: Largest gap between members, and least length of a seam, mm.
    gap_mm: float
    min_length_mm: float
    level: Level
    has_marks: bool  #: Whether edges of the part are marked as seams.
    reach: Reach  #: The torch with which the seams were felt.
    looks: ShapeLooks  #: What the shapes of solids say.
    play: tuple[Play, ...]  #: Gaps that several joints have: they are meant.

    @classmethod
    def of(
        cls,
        graph: BrepGraph,
        trimmed: TrimmedFaces,
        options: SeamOptions,
        *,
        has_marks: bool,
        like: IntArray | None = None,
    ) -> Judge:
        """Find the members, holes and bolts of a part.

        `like`: ndarray of int, shape (S,), optional. For each of the S solids, the one that is looked at in its place
        (`ShapeLooks.like`); by default itself.
        """
        number = {name: solid for solid, name in enumerate(graph.solid_names)}
        members, holes = take_members(graph, trimmed, options.judging), find_bolt_holes(graph, trimmed)
        hole_of_face = {int(face): row for row, own in enumerate(holes.face) for face in own}
        clamps: dict[tuple[int, int], list[Clamp]] = defaultdict(list)
        for clamp in find_clamps(holes, members.fasteners):
            clamps[clamp.solids].append(clamp)
        gap_mm, min_mm, level = options.gap_for(graph), options.min_length_mm, options.judging.level
        rolling = find_rolling(graph, trimmed, gap_mm)
        said = said_about(graph, trimmed, options.judging)
        known = (graph, number, members, said, rolling, holes, hole_of_face, dict(clamps))
        play = with_play(graph, trimmed, options).play or ()
        options_of = (gap_mm, min_mm, level, has_marks, options.reach)
        alike = np.arange(len(graph.solid_names)) if like is None else like
        looks = ShapeLooks(graph, trimmed, members, gap_mm, 2.0 * options.reach.torch.nozzle_radius_mm, alike)
        return cls(*known, *options_of, looks, play)

    def clamps_of(self, a: int, b: int) -> list[Clamp]:
        """Return the places at which two solids are clamped together."""
        return self.clamps.get((min(a, b), max(a, b)), [])

    def bolts_of(self, name: str) -> int:
        """Return the number of bolts that hold a solid, or of its holes that line up with those of others."""
        solid = self.number[name]
        own = (clamp for pair, clamps in self.clamps.items() if solid in pair for clamp in clamps)
        return len({tuple(np.round(clamp.o, 1).tolist()) for clamp in own})

    def both_said(self, seam: Seam) -> bool:
        """Tell whether a person said of both solids of a seam that they can be welded."""
        return len(seam.solids) == 2 and all(self.members[self.number[name]].said for name in seam.solids)

    def evidence(self, seam: Seam) -> Iterator[Finding]:
        """Yield the findings against a candidate."""
        solids = [self.number[name] for name in seam.solids]
        if seam.inside:
            yield Rule.IN_MATERIAL.found(f"{in_material_words(seam)}{hiding_words(seam)}")
        elif seam.blocked_by:
            yield Rule.NOT_REACHED.found(f"{blocked_words(seam)}{assumed_words(self.reach)}")
        of_solids = [finding for solid in solids for finding in self.members[solid].findings]
        yield from (one for one in self.said.against(seam.pieces) if one.rule not in {own.rule for own in of_solids})
        yield from of_solids
        for solid in solids:
            if seam.source is SeamSource.FLARE and solid in self.rolling and not self.members[solid].said:
                yield Rule.ROLLING.found(f"{self.graph.solid_names[solid]} {self.rolling[solid]}")
        if seam.length_mm < self.min_length_mm - LENGTH_ROUND_OFF_MM:
            least = f"the least length of a seam, {self.min_length_mm:g} mm"
            yield Rule.TOO_SHORT.found(f"{seam.length_mm:.1f} mm is shorter than {least}")
        if self.has_marks and not seam.source.is_chosen:
            yield Rule.NOT_MARKED.found("other edges are marked, and not this one")
        if len(solids) == 2:
            yield from self._pair_evidence(seam, *solids)
        if seam.source in (SeamSource.CONTACT, SeamSource.FLARE) and len(solids) == 2:
            yield from self._contact_evidence(
                seam, is_fastener=any(solid in self.members.fasteners for solid in solids)
            )

    def add_shape_evidence(self, seams: Sequence[Seam], found: Sequence[list[Finding]]) -> None:
        """Add what the shapes of two solids say against candidates that nothing else refuses.

        It takes time to look at a shape, so others are not asked.
        """
        asked = {}
        for row, (seam, own) in enumerate(zip(seams, found, strict=True)):
            between_two = seam.source in BETWEEN_TWO and len(seam.solids) == 2
            if between_two and confidence_of(seam.source, own) >= Level.GENEROUS.value:
                asked[row] = [self.number[name] for name in seam.solids]
        self.looks.look_at(asked.values())
        for row, solids in asked.items():
            found[row].extend(self.looks.findings(solids))

    def _pair_evidence(self, seam: Seam, a: int, b: int) -> Iterator[Finding]:
        """Yield what speaks against welding these two members to each other at this place."""
        one, other = self.members[a], self.members[b]
        if self.both_said(seam):
            return
        if one.metal is not None and other.metal is not None and not are_welded(one.metal, other.metal):
            words = f"{one.solid} is {one.metal.value} and {other.solid} is {other.metal.value}"
            yield Rule.OTHER_METAL.found(f"{words}: the two are not welded to each other")
        yield from self._clamp_evidence(seam, a, b)

    def _clamp_evidence(self, seam: Seam, a: int, b: int) -> Iterator[Finding]:
        beside = self.gap_mm + BESIDE_MM
        here = [clamp for clamp in self.clamps_of(a, b) if clamp.holds(seam.frames.p, beside)]
        if not here:
            return
        bolts, holes = sum(clamp.bolts for clamp in here), sum(clamp.holes for clamp in here)
        if bolts:
            yield Rule.BOLTED.found(
                f"{bolts} bolt{'s hold' if bolts > 1 else ' or pin holds'} the two members together here"
            )
        elif holes > 1:
            yield Rule.LINED_UP.found(f"{holes} holes of the two members line up here")
        elif any(clamp.far_walls for clamp in here):
            yield Rule.LINED_UP.found("a hole of both members lines up here and goes on through the far wall of a tube")

    def _contact_evidence(self, seam: Seam, *, is_fastener: bool) -> Iterator[Finding]:
        gaps = seam.pieces.gap_mm[:, 1]
        doubted = gaps[~is_play(self.play, gaps)] if self.play else gaps  # play is no doubt
        mean = float(doubted.sum() / len(gaps))
        if mean > FELT_GAP * self.gap_mm:
            lost = GAP_SHARE_LOST * min(mean / self.gap_mm, 1.0)
            text = f"a gap of {mean:.2f} mm on average, up to {seam.gap_mm[2]:.2f} mm"
            yield Rule.GAP.found(text, 1.0 - lost)
        if is_fastener:
            return
        rim = self._rim_mm(seam)
        if rim is not None:
            yield Rule.HOLE_RIM.found(f"it runs round inside a hole of {short(rim)} mm that the other member covers")
        if seam.closed and self._is_pin(seam):
            yield Rule.PIN_IN_HOLE.found("a round member in a hole: it may be pressed in, or turn there")

    def _rim_mm(self, seam: Seam) -> float | None:
        """Return the diameter of the hole inside which a seam runs along the rim; None if it does not."""
        wall, base = seam.pieces.wall, seam.pieces.base
        hole = self.hole_of_face.get(int(wall[0]))
        if hole is None:
            return None
        is_round = (self.graph.face_kind[base] == SurfaceKind.CYLINDER) & (self.graph.face_outward[base] > 0)
        if is_round.any() or not np.isin(wall, self.holes.face[hole]).all():
            return None
        return 2.0 * float(self.holes.radius[hole])

    def _is_pin(self, seam: Seam) -> bool:
        """Tell whether the seam runs round a cylinder that fits in a hole of the other member."""
        graph = self.graph
        faces = np.concatenate([seam.pieces.wall, seam.pieces.base])
        pins = faces[(graph.face_kind[faces] == SurfaceKind.CYLINDER) & (graph.face_outward[faces] > 0)]
        if len(pins) == 0:
            return False
        z, radius = graph.face_frame[pins[0], 3], graph.face_param[pins[0], 0]
        if self._is_tube(int(pins[0])):
            return False
        if np.abs(seam.frames.R[:, :, 0] @ z).max() > AROUND:
            return False
        other = [self.number[name] for name in seam.solids if self.number[name] != graph.face_solid[pins[0]]]
        bores = self._bores
        play = max(self.gap_mm, seam.gap_mm[2] + GAP_ROUND_OFF_MM)
        fits = np.abs(graph.face_param[bores, 0] - radius) <= play
        holes = bores[fits & np.isin(graph.face_solid[bores], other)]
        return bool((off_axis(graph.face_frame[holes, 0], *graph.face_frame[pins[0], [0, 3]]) <= play).any())

    @property
    def _bores(self) -> IntArray:
        """The round faces of holes."""
        return np.flatnonzero((self.graph.face_kind == SurfaceKind.CYLINDER) & (self.graph.face_outward < 0))

    def _is_tube(self, cylinder: int) -> bool:
        """Tell whether a round face is the outside of a tube, with thin walls and longer than it is wide: no pin."""
        graph, radius = self.graph, float(self.graph.face_param[cylinder, 0])
        bores = self._bores[graph.face_solid[self._bores] == graph.face_solid[cylinder]]
        bores = bores[(graph.face_param[bores, 0] >= THIN_WALL * radius) & (graph.face_param[bores, 0] < radius)]
        bores = bores[off_axis(graph.face_frame[bores, 0], *graph.face_frame[cylinder, [0, 3]]) <= self.gap_mm]
        edges = np.flatnonzero((graph.edge_faces == cylinder).any(axis=1))
        p = graph.vertex_p[graph.edge_vertices[edges].ravel()] @ graph.face_frame[cylinder, 3]
        return len(bores) > 0 and len(p) > 0 and bool(np.ptp(p) > 2.0 * radius)


def _corner(seam: Seam) -> tuple[tuple[int, int], FloatArray, FloatArray]:
    """Return the faces beside the first piece of a seam, the middle of the seam, mm, and the direction there."""
    middle = len(seam.frames) // 2
    return (int(seam.pieces.wall[0]), int(seam.pieces.base[0])), seam.frames.p[middle], seam.frames.R[middle, :, 0]


def _concave_evidence(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam]) -> dict[int, list[Finding]]:
    """Return, by row, the findings against seams that are concave edges inside a solid."""
    found: dict[int, list[Finding]] = defaultdict(list)
    number = {name: solid for solid, name in enumerate(graph.solid_names)}
    inner = [row for row, seam in enumerate(seams) if seam.source in INSIDE and len(seam.solids) == 1]
    for row in inner:
        pieces, name = seams[row].pieces, seams[row].solids[0]
        members = members_of(graph, trimmed, number[name])
        pairs = zip(pieces.wall.tolist(), pieces.base.tolist(), strict=True)
        way, length_mm = _corner(seams[row])[2], seams[row].length_mm
        is_sharp = seams[row].source is SeamSource.CONCAVE
        around = [members.around(pair, way, length_mm, is_sharp=is_sharp) for pair in pairs]
        rolled = [one for one in around if one is not None]
        mm = edge_lengths(graph)[pieces.edge]
        inside_mm = mm[[one is not None for one in around]].sum()
        if rolled and inside_mm >= MOSTLY_ROLLED * mm.sum():  # it may turn round the end of its member
            made = "bent" if rolled[0].kind is MemberKind.SHEET else "rolled"
            words = f"a corner inside one {rolled[0].in_words} of {name}, as if {made}"
            found[row].append(Rule.ROLLED.found(words))
        elif len(pieces) == 1 and is_cut(graph, trimmed, *_corner(seams[row])):
            found[row].append(Rule.CUT.found(f"the corner of a cut through a wall of {name}"))
    rows = [row for row in inner if seams[row].source is SeamSource.CONCAVE]
    if not rows:
        return found
    owner = np.repeat(rows, [len(seams[row].pieces) for row in rows])
    edges = np.concatenate([seams[row].pieces.edge for row in rows])
    bent = are_bends(graph, trimmed, edges)
    for row in rows:
        if bent[owner == row].all():
            found[row].append(Rule.BENT.found("the inner corner of one bent sheet, or of two of the same thickness"))
    return found
