"""What to do about a part on which no candidate is taken, although some are only doubted: one line with the options."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence

from wpcal.core.issue import Issue
from wpcal.core.wording import counted
from wpcal.seam.limits import Level
from wpcal.seam.member.note import plain_name
from wpcal.seam.seam import Seam

MOST_GROUPS = 3
"""Pairs of members that are named."""


def why_none_is_taken(seams: Sequence[Seam]) -> list[Issue]:
    """Tell what `--generous` would take on a part on which no candidate is taken, and why it is doubted.

    Parameters
    ----------
    seams : sequence of Seam
        All of the part, judged.

    Returns
    -------
    list of Issue
        Empty if a seam is taken, or if nothing more would be taken.
    """
    doubted = would_be_taken(seams)
    if not doubted or any(seam.accepted for seam in seams):
        return []
    groups: dict[tuple[tuple[str, ...], str], list[Seam]] = defaultdict(list)
    for seam in doubted:
        names = tuple(sorted({plain_name(name) for name in seam.solids}))
        groups[names, seam.against[0] if seam.against else "it is not sure enough"].append(seam)
    ordered = sorted(groups.items(), key=lambda item: (-_length(item[1]), item[0]))
    told = [
        f"{' + '.join(names)} ({counted(len(own), 'seam')}, {_length(own):.0f} mm): {why}"
        for (names, why), own in ordered[:MOST_GROUPS]
    ]
    more = f"; and {counted(len(ordered) - MOST_GROUPS, 'other pair')}" if len(ordered) > MOST_GROUPS else ""
    said = " ".join(f"--weld {_quoted(name)}" for name in ordered[0][0][0])
    found = f"no seam is taken, but {counted(len(doubted), 'candidate')} of {_length(doubted):.0f} mm might be welds"
    what = f"--generous takes all of them, {said} those of the first pair"
    text = f"{found}: {'; '.join(told)}{more}. If they are welded: {what}"
    return [Issue("only-doubted", text, tuple(seam.name for seam in doubted))]


def would_be_taken(seams: Iterable[Seam]) -> list[Seam]:
    """Return the candidates that are not taken, but would be with `--generous`."""
    return [
        seam
        for seam in seams
        if not (
            seam.accepted or seam.inside or seam.blocked_by or (seam.edit is not None and seam.edit.accept is False)
        )
        and seam.confidence >= Level.GENEROUS.value
    ]


def _length(seams: Sequence[Seam]) -> float:
    return sum(seam.length_mm for seam in seams)


def _quoted(name: str) -> str:
    return f"'{name}'" if set(name) & set(" *?'()&;") else name
