"""What is left of joints that are no joints: in an assembly of castings and mouldings, or beside buried contacts.

A part whose joints are mostly between solids that were made in one piece is a machine, a device or a toy. Its few bars
and plates are screwed on like the rest. In a weldment with one casting on it, most joints are between members.
Members are cut to fit each other. Where most of the line in which two solids meet is inside a solid, they were put
into each other: a clamp in a bracket, a post in the corner of a case.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from wpcal.seam.judge.evidence import BETWEEN_TWO, Judge, weighed
from wpcal.seam.rules import Rule, confidence_of
from wpcal.seam.seam import Seam

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
