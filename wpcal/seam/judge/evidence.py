"""How sure the rules are that a candidate is a weld: the findings for and against it, in words and as a number.

Each finding multiplies the confidence by a factor. The factors are a ranking, not probabilities. One strong finding (no
torch gets there; a bolt) brings any candidate below `LEAST_CONFIDENCE`; a weak one (a wide gap) does not.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.find.concave import are_cut_outs, are_deeper
from wpcal.seam.judge.fasteners import Fastener, find_fasteners, is_named_fastener
from wpcal.seam.judge.rolling import find_rolling
from wpcal.seam.judge.stretches import in_material_words
from wpcal.seam.judge.unreached import blocked_words
from wpcal.seam.limits import LEAST_CONFIDENCE
from wpcal.seam.options import ConcaveEdges, SeamOptions
from wpcal.seam.seam import Seam, SeamSource
from wpcal.seam.torch import USUAL_TORCH

PRIOR = {
    SeamSource.CONTACT: 0.95,
    SeamSource.SECTION: 0.9,
    SeamSource.CONCAVE: 0.7,
    SeamSource.BEAD: 0.7,
    SeamSource.FLARE: 0.85,
    SeamSource.MARKED: 1.0,
}
"""Confidence before any finding. Members in contact are meant to be joined; overlapping ones may be a mistake; a groove
beside a radius is often left open; a concave edge or a round may be just a shape. What a person marked is a weld,
whatever the findings."""
IN_MATERIAL, NOT_REACHED, FASTENER, TOO_SHORT, CUT_OUT, MASSIVE, NOT_MARKED = 0.01, 0.1, 0.05, 0.3, 0.2, 0.3, 0.4
ROLLING = 0.4
"""Each of these rejects a candidate by itself."""
NAMED, BOLTED, PIN_IN_HOLE = 0.7, 0.75, 0.8
"""Each of these lowers the confidence of a contact, but does not reject it by itself."""
GAP_SHARE_LOST = 0.4
"""Share of the confidence that is lost if the mean gap is as wide as allowed; a tee with a gap of 0.4 mm of 0.5 mm is
still accepted."""
THICKEST_MM = 60.0
"""Concave edges: if both members are thicker, the part is a casting or a building. Plates welded by robots are rarely
thicker than 40 mm."""
FELT_GAP = 0.1
"""Gaps below this fraction of the allowed gap do not lower the confidence."""
AROUND = 0.1
"""A seam runs round an axis if the cosine between the two is below this everywhere (84 degrees)."""
STRAIGHT_WORDS, MISSED_WORDS = "are free for a torch that does not lean", "no torch gets there at"
"""How the reasons about reach end and begin."""
ASSUMED = (
    f" (assumed: {USUAL_TORCH}; if yours is bent or smaller, or gets there at another weld angle, accept the seam by "
    "an edit)"
)
"""Which torch a verdict about reach is for, and what would change it."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """One finding about a candidate.

    Parameters
    ----------
    factor : float
        The confidence is multiplied by it.
    text : str
        The finding in words, for people.
    """

    factor: float
    text: str


def judge_seams(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    seams: Sequence[Seam],
    options: SeamOptions,
    *,
    has_marks: bool | None = None,
) -> tuple[Seam, ...]:
    """Compute the confidence of every candidate, with the reasons.

    Parameters
    ----------
    graph, trimmed :
        The part.
    seams : sequence of Seam
        With frames in `part`; where a torch was felt, with its leans or with the solids in its way.
    options : SeamOptions
    has_marks : bool, optional
        Whether edges of the part are marked as seams; as in `seams` if it is not given.

    Returns
    -------
    tuple of Seam
        With `reachable`, `confidence`, `accepted`, `reasons` and `against`.
    """
    if not seams:
        return ()
    if has_marks is None:
        has_marks = any(seam.source is SeamSource.MARKED for seam in seams)
    judge = _Judge.of(graph, trimmed, options, has_marks=has_marks)
    concave = _concave_evidence(graph, trimmed, seams) if options.concave is ConcaveEdges.AUTO else {}
    judged = []
    for row, seam in enumerate(seams):
        evidence = [*judge.evidence(seam), *concave.get(row, ())]
        against = sorted(evidence, key=lambda item: item.factor)
        confidence = PRIOR[seam.source] * float(np.prod([item.factor for item in evidence]))
        judged.append(
            replace(
                seam,
                reachable=not (seam.inside or seam.blocked_by),
                accepted=not (seam.inside or seam.blocked_by)
                and (confidence >= LEAST_CONFIDENCE or seam.source is SeamSource.MARKED),
                confidence=confidence,
                reasons=(seam.source.value, *seam.reasons, *_reach_words(seam)),
                against=tuple(item.text for item in against),
            )
        )
    return tuple(judged)


def _reach_words(seam: Seam) -> tuple[str, ...]:
    """Say how a torch gets to a seam, and at how many of its frames it does not."""
    if seam.lean_rad is None or seam.blocked_by:
        return ()
    count = len(seam.lean_rad)
    missed = int(np.isnan(seam.lean_rad[:, 0]).sum())
    straight = int((seam.lean_rad == 0).all(axis=1).sum())
    words = f"{straight} of {count} frames {STRAIGHT_WORDS}"
    return (words, f"{MISSED_WORDS} {missed} of {count} frames") if missed else (words,)


def is_judgement(text: str, source: SeamSource) -> bool:
    """Tell whether a reason was added by `judge_seams`, which is to judge again."""
    return text == source.value or text.endswith(STRAIGHT_WORDS) or text.startswith(MISSED_WORDS)


@dataclass(frozen=True, slots=True, eq=False)
class _Judge:
    graph: BrepGraph
    number: dict[str, int]
    holes: IntArray
    fasteners: dict[int, Fastener]
    rolling: dict[int, str]
    gap_mm: float
    min_length_mm: float
    has_marks: bool

    @classmethod
    def of(cls, graph: BrepGraph, trimmed: TrimmedFaces, options: SeamOptions, *, has_marks: bool) -> _Judge:
        number = {name: solid for solid, name in enumerate(graph.solid_names)}
        holes = np.flatnonzero((graph.face_kind == SurfaceKind.CYLINDER) & (graph.face_outward < 0))
        fasteners = find_fasteners(graph, trimmed)
        rolling = find_rolling(graph, trimmed, options.gap_for(graph))
        return cls(graph, number, holes, fasteners, rolling, options.gap_for(graph), options.min_length_mm, has_marks)

    def evidence(self, seam: Seam) -> Iterator[Evidence]:
        """Yield the findings against a candidate."""
        solids = [self.number[name] for name in seam.solids]
        held = [self.fasteners[solid] for solid in solids if solid in self.fasteners]
        if seam.inside:
            yield Evidence(IN_MATERIAL, in_material_words(seam))
        elif seam.blocked_by:
            yield Evidence(NOT_REACHED, f"{blocked_words(seam)}{ASSUMED}")
        for solid in solids:
            name = self.graph.solid_names[solid]
            if solid in self.fasteners:
                yield Evidence(FASTENER, f"{name} is {self.fasteners[solid].what}")
            elif is_named_fastener(name):
                yield Evidence(NAMED, f"{name} is named like a fastener")
            if solid in self.rolling and seam.source is SeamSource.FLARE:
                yield Evidence(ROLLING, f"{name} {self.rolling[solid]}")
        if seam.length_mm < self.min_length_mm:
            least = f"the least length of a seam, {self.min_length_mm:g} mm"
            yield Evidence(TOO_SHORT, f"{seam.length_mm:.1f} mm is shorter than {least}")
        if self.has_marks and seam.source is not SeamSource.MARKED:
            yield Evidence(NOT_MARKED, "other edges are marked, and not this one")
        if seam.source in (SeamSource.CONTACT, SeamSource.FLARE) and len(solids) == 2:
            yield from self._contact_evidence(seam, set(solids), bool(held))

    def _contact_evidence(self, seam: Seam, solids: set[int], is_fastener: bool) -> Iterator[Evidence]:
        mean = seam.gap_mm[1]
        if mean > FELT_GAP * self.gap_mm:
            lost = GAP_SHARE_LOST * min(mean / self.gap_mm, 1.0)
            yield Evidence(1.0 - lost, f"a gap of {mean:.2f} mm on average, up to {seam.gap_mm[2]:.2f} mm")
        if is_fastener:
            return
        count = sum(solids <= fastener.through for fastener in self.fasteners.values())
        if count:
            yield Evidence(BOLTED, f"the members are also held by {count} fasteners")
        if seam.closed and self._is_pin(seam):
            yield Evidence(PIN_IN_HOLE, "a round member in a hole: it may be pressed in, or turn there")

    def _is_pin(self, seam: Seam) -> bool:
        """Tell whether the seam runs round a cylinder that fits in a hole of the other member."""
        graph = self.graph
        faces = np.concatenate([seam.pieces.wall, seam.pieces.base])
        pins = faces[(graph.face_kind[faces] == SurfaceKind.CYLINDER) & (graph.face_outward[faces] > 0)]
        if len(pins) == 0:
            return False
        o, z, radius = graph.face_frame[pins[0], 0], graph.face_frame[pins[0], 3], graph.face_param[pins[0], 0]
        if np.abs(seam.frames.R[:, :, 0] @ z).max() > AROUND:
            return False
        other = [self.number[name] for name in seam.solids if self.number[name] != graph.face_solid[pins[0]]]
        fits = np.abs(graph.face_param[self.holes, 0] - radius) <= self.gap_mm
        holes = self.holes[fits & np.isin(graph.face_solid[self.holes], other)]
        arm: FloatArray = graph.face_frame[holes, 0] - o
        off = np.linalg.norm(arm - (arm @ z)[:, None] * z, axis=1)
        return bool((off <= self.gap_mm).any())


def _concave_evidence(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam]) -> dict[int, list[Evidence]]:
    """Return, by row, the findings against seams that are concave edges inside a solid."""
    rows = [row for row, seam in enumerate(seams) if seam.source is SeamSource.CONCAVE]
    found: dict[int, list[Evidence]] = defaultdict(list)
    if not rows:
        return found
    owner = np.repeat(rows, [len(seams[row].pieces) for row in rows])
    edges = np.concatenate([seams[row].pieces.edge for row in rows])
    cut_out = are_cut_outs(graph, trimmed, edges)
    massive = are_deeper(graph, trimmed, edges, np.full(len(edges), THICKEST_MM))
    for row in rows:
        if cut_out[owner == row].all():
            found[row].append(Evidence(CUT_OUT, "the corner of an opening in one member, not a joint of two"))
        if massive[owner == row].all():
            found[row].append(Evidence(MASSIVE, f"both members are thicker than {THICKEST_MM:g} mm"))
    return found
