"""What is doubted once all joints of a part are known: welds that would fix bolts, and what is left of other joints.

If A is bolted to B, and B is welded to the rest, a weld between A and the rest makes the bolts useless. One of the two
welds is not meant. The solid with more bolts is taken for the one that is bolted on; with as many, the one whose welds
are less than half as long. If neither, both stay. Only welds near the bolts are doubted: a brace may be bolted at one
end and welded at the other.

A part whose joints are mostly between solids that were made in one piece is a machine, a device or a toy. Its few bars
and plates are screwed on like the rest. In a weldment with one casting on it, most joints are between members.
Members are cut to fit each other. Where most of the line in which two solids meet is inside a solid, they were put
into each other: a clamp in a bracket, a post in the corner of a case.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.seam.judge.evidence import BETWEEN_TWO, Judge, weighed
from wpcal.seam.rules import Rule, confidence_of
from wpcal.seam.seam import Seam

CLAMPED = frozenset({Rule.BOLTED.key, Rule.LINED_UP.key})
"""Findings that say that two members are bolted to each other."""
CLEARLY_SHORTER = 0.5  #: Of two welds the shorter one is doubted if its share of the other is below this.
NEAR = 0.5  #: A weld is near the bolts if it is nearer than this share of the size of the solid that is bolted on.

Lengths = dict[str, dict[str, float]]  #: Length of the accepted seams between two solids, mm, by both names.
Doubted = dict[tuple[str, str], list[str]]
"""To which solids bolts hold the first solid of a pair, the weld of which would fix them."""


def doubt_what_fixes_bolts(judge: Judge, trimmed: TrimmedFaces, seams: Sequence[Seam]) -> list[Seam]:
    """Return the seams of a part, those that would fix what bolts hold with a finding."""
    clamped = (seam.solids for seam in seams if any(one.rule in CLAMPED for one in seam.findings))
    bolted = {(min(solids), max(solids)) for solids in clamped}
    lengths: Lengths = defaultdict(lambda: defaultdict(float))
    for seam in seams:
        if seam.accepted and len(seam.solids) == 2 and not seam.source.is_chosen:
            a, b = seam.solids
            lengths[a][b] += seam.length_mm
            lengths[b][a] += seam.length_mm
    doubted: Doubted = defaultdict(list)
    for a, b in sorted(bolted):
        if b not in lengths.get(a, {}):
            for pair, holder in _doubted(judge, lengths, a, b):
                doubted[pair].append(holder)
    return [_with_doubt(judge, trimmed, seam, doubted) for seam in seams]


def _doubted(judge: Judge, lengths: Lengths, a: str, b: str) -> list[tuple[tuple[str, str], str]]:
    """Return the pairs whose weld would fix the bolts between a and b, and to which of the two the bolts hold it.

    In each pair the solid that is bolted on comes first.
    """
    ways = [(own, other, _group(lengths, other, without=own)) for own, other in ((a, b), (b, a))]
    of_own = [sum(lengths[own][c] for c in group if c in lengths[own]) for own, _, group in ways]
    if not all(of_own):
        return []
    bolts = [judge.bolts_of(own) for own, _, _ in ways]
    if bolts[0] != bolts[1]:
        row = int(bolts[1] > bolts[0])
    elif min(of_own) < CLEARLY_SHORTER * max(of_own):
        row = int(of_own[1] < of_own[0])
    else:
        return []
    own, other, group = ways[row]
    return [((own, c), other) for c in sorted(group) if c in lengths[own]]


def _group(lengths: Lengths, start: str, *, without: str) -> set[str]:
    """Return the solids that welds connect with one, if another one were not there."""
    found, left = {start}, [start]
    while left:
        for other in lengths[left.pop()]:
            if other not in found and other != without:
                found.add(other)
                left.append(other)
    return found


def _with_doubt(judge: Judge, trimmed: TrimmedFaces, seam: Seam, doubted: Doubted) -> Seam:
    if not seam.accepted or len(seam.solids) != 2:
        return seam
    for own, other in (seam.solids, seam.solids[::-1]):
        holders = () if judge.both_said(seam) else doubted.get((own, other), ())
        holder = next((one for one in holders if _is_near(judge, trimmed, seam.frames.p, own, one)), None)
        if holder is not None:
            words = f"{own} is bolted to {holder}, which is welded to {other}: a weld here would fix the bolts"
            return weighed(seam, (*seam.findings, Rule.FIXES_BOLTED.found(words)), judge.level)
    return seam


def _is_near(judge: Judge, trimmed: TrimmedFaces, p: FloatArray, own: str, holder: str) -> bool:
    """Tell whether points are near the bolts between two solids, measured by the size of the one that is bolted on."""
    solid = judge.number[own]
    faces = judge.graph.face_solid == solid
    low, high = trimmed.face_box
    size = float(np.linalg.norm(high[faces].max(axis=0) - low[faces].min(axis=0)))
    for clamp in judge.clamps_of(solid, judge.number[holder]):
        arm = p - clamp.o
        off = np.linalg.norm(arm - (arm @ clamp.z)[:, None] * clamp.z, axis=1)
        if float(off.min()) <= NEAR * size:
            return True
    return False


MOST = 0.8  #: Share of the length of all joints that has a solid made in one piece, from which on the rest is doubted.
MOST_BURIED = 0.55
"""Share of the length of all candidates between two solids that is inside a solid, from which on the rest is doubted.
Tubes that are welded have up to 0.51: their inner outline, and what another tube covers."""


def doubt_what_is_left(judge: Judge, seams: Sequence[Seam]) -> list[Seam]:
    """Return the seams of a part; if most joints are between solids made in one piece, the others with a finding."""
    left = [row for row, seam in enumerate(seams) if seam.accepted and seam.source in BETWEEN_TWO]
    left_mm = sum(seams[row].length_mm for row in left)
    whole_mm = sum(seam.length_mm for seam in seams if _is_refused_as_whole(judge, seam))
    if not left or whole_mm < MOST * (whole_mm + left_mm):
        return list(seams)
    words = (
        f"{whole_mm:.0f} of {whole_mm + left_mm:.0f} mm of the joints that could be welded have a solid made in one "
        "piece; this is one of the rest"
    )
    doubted = {row for row in left if not judge.both_said(seams[row])}
    return [
        weighed(seam, (*seam.findings, Rule.LEFT_OVER.found(words)), judge.level) if row in doubted else seam
        for row, seam in enumerate(seams)
    ]


def _is_refused_as_whole(judge: Judge, seam: Seam) -> bool:
    """Tell whether a seam would be accepted if its solids were not made in one piece."""
    others = [one for one in seam.findings if one.rule != Rule.ONE_PIECE.key]
    if seam.accepted or len(others) == len(seam.findings) or seam.inside or seam.blocked_by:
        return False
    return confidence_of(seam.source, others) >= judge.level.value


def doubt_what_is_buried(judge: Judge, seams: Sequence[Seam]) -> list[Seam]:
    """Return the seams of a part; what is left between two solids that meet mostly inside one has a finding."""
    mm: dict[tuple[str, ...], list[float]] = defaultdict(lambda: [0.0, 0.0])
    for seam in seams:
        if len(seam.solids) == 2:
            mm[seam.solids][bool(seam.inside)] += seam.length_mm
    found = list(seams)
    for row, seam in enumerate(seams):
        out, buried = mm[seam.solids] if seam.accepted and len(seam.solids) == 2 else (1.0, 0.0)
        if not _is_settled(judge, seam) and buried >= MOST_BURIED * (out + buried):
            words = f"{buried:.0f} of {out + buried:.0f} mm along which the two meet are inside a solid"
            found[row] = weighed(seam, (*seam.findings, Rule.BURIED.found(words)), judge.level)
    return found


def _is_settled(judge: Judge, seam: Seam) -> bool:
    """Tell whether a person chose a seam, or a ring is held: it lies in its groove by purpose."""
    held = any(one.rule == Rule.HELD_FAST.key for one in seam.findings)
    return held or judge.both_said(seam) or seam.source.is_chosen
