"""Welds that would fix what bolts hold: of a panel that is bolted to a bracket, and touches the post of that bracket.

If A is bolted to B, and B is welded to the rest, a weld between A and the rest makes the bolts useless. One of the two
welds is not meant. The solid with more bolts is taken for the one that is bolted on; with as many, the one whose welds
are less than half as long. If neither, both stay. Only welds near the bolts are doubted: a brace may be bolted at one
end and welded at the other.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.seam.judge.evidence import Judge, weighed
from wpcal.seam.rules import Rule
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
    bolted = {pair for seam in seams if any(one.rule in CLAMPED for one in seam.findings) for pair in [_pair(seam)]}
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


def _pair(seam: Seam) -> tuple[str, str]:
    return min(seam.solids), max(seam.solids)


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
