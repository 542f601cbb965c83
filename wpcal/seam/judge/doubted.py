"""Why no candidate of a part is taken, and which option would change that: one line."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence

from wpcal.core.issue import Issue
from wpcal.core.wording import counted
from wpcal.seam.limits import Level
from wpcal.seam.member.note import plain_name
from wpcal.seam.rules import Rule
from wpcal.seam.seam import Seam

MOST_GROUPS = 3  #: Pairs of members that are named.


def why_none_is_taken(seams: Sequence[Seam]) -> list[Issue]:
    """Tell what `--generous` would take on a part on which no candidate is taken, and why it is doubted.

    Returns list of Issue. Empty if a seam is taken, or if nothing more would be taken.
    """
    doubted = would_be_taken(seams)
    if not doubted or any(seam.accepted for seam in seams):
        return []
    groups: dict[tuple[tuple[str, ...], str], list[Seam]] = defaultdict(list)
    for seam in doubted:
        names = tuple(sorted({plain_name(name) for name in seam.solids}))
        groups[names, seam.against[0] if seam.against else "it is not sure enough"].append(seam)
    ordered = sorted(groups.items(), key=lambda item: (-_length(item[1]), item[0]))
    told, said = list[str](), set[str]()
    for (names, why), own in ordered[:MOST_GROUPS]:
        reason = "the same" if why in said else why
        told.append(f"{' + '.join(names)} ({counted(len(own), 'seam')}, {_length(own):.0f} mm): {reason}")
        said.add(why)
    more = f"; and {counted(len(ordered) - MOST_GROUPS, 'other pair')}" if len(ordered) > MOST_GROUPS else ""
    options = " ".join(f"--weld {_quoted(name)}" for name in ordered[0][0][0])
    found = f"no seam is taken, but {counted(len(doubted), 'candidate')} of {_length(doubted):.0f} mm might be welds"
    what = f"--generous takes all of them, {options} those of the first pair"
    text = f"{found}: {'; '.join(told)}{more}. If they are welded: {what}"
    return [Issue("only-doubted", text, tuple(seam.name for seam in doubted))]


def why_nothing_is_found(seams: Sequence[Seam], solids: int, gap_mm: float) -> list[Issue]:
    """Tell why a part has no seam at all that any level would take.

    `gap_mm`: Largest gap with which they were found, mm.

    Returns: Empty if a seam is taken, if `why_none_is_taken` tells about it, or if the part is one solid without
    candidates: `one_piece.left_out` tells about that.
    """
    if any(seam.accepted for seam in seams) or would_be_taken(seams) or (solids == 1 and not seams):
        return []
    if not seams:
        text = f"no seam: no two of the {solids} solids touch (they count as touching up to {gap_mm:g} mm; --gap-mm)"
        return [Issue("no-seam", text)]
    groups: dict[str, list[Seam]] = defaultdict(list)
    for seam in seams:
        groups[_kind_of_reason(seam)].append(seam)
    ordered = sorted(groups.items(), key=lambda item: (-_length(item[1]), item[0]))
    told = [f"{counted(len(own), 'candidate')}, {_length(own):.0f} mm: {why}" for why, own in ordered[:MOST_GROUPS]]
    more = f"; and {counted(len(ordered) - MOST_GROUPS, 'other reason')}" if len(ordered) > MOST_GROUPS else ""
    return [Issue("no-seam", f"no seam is taken. {'; '.join(told)}{more}. {_what_helps(seams)}")]


def _kind_of_reason(seam: Seam) -> str:
    """Say in general what speaks most against a seam: seams with other names and numbers have the same reason."""
    rule = next((one for one in Rule if seam.findings and one.key == seam.findings[0].rule), None)
    if rule is None:
        return seam.against[0] if seam.against else "it is not sure enough"
    words = rule.value.finding.partition(". ")[0].rstrip(".")
    return words[0].lower() + words[1:]


def _what_helps(seams: Sequence[Seam]) -> str:
    """Say which option takes what is refused."""
    if all(seam.inside or seam.blocked_by for seam in seams):
        return (
            "Another torch may get there (--torch, wpcal torches); wpcal seams --explain NAME tells where it is stopped"
        )
    if all(len(seam.solids) == 1 for seam in seams):
        return "If they are welds: --concave always"
    names = " ".join(f"--weld {_quoted(name)}" for name in max(seams, key=lambda seam: seam.length_mm).solids)
    return f"If they are welded: {names}, or accept single ones in wpcal pick; --explain NAME tells more"


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
