"""Seams that cannot be welded whole: cut where one way ends and another begins, or told why a stretch is left out."""

from __future__ import annotations

from dataclasses import dataclass

from wpcal.planning.sequence.candidate import Candidate
from wpcal.planning.sequence.seam_search import SeamSearch
from wpcal.planning.sequence.seam_task import SeamTask
from wpcal.planning.sequence.why_not import Help, find_help, find_reason

LEAST_PIECE_MM = 15.0
"""A shorter piece is not worth a start and an end of the arc; a seam that is shorter itself is welded whole or not."""


@dataclass(frozen=True, slots=True)
class Unwelded:
    """A stretch of a seam that is not welded.

    Parameters
    ----------
    seam : str
    from_mm, to_mm : float
        Arc length along the seam.
    why : str
    help : tuple of Help
        What would help, the smallest change first; empty if nothing was found.
    """

    seam: str
    from_mm: float
    to_mm: float
    why: str
    help: tuple[Help, ...] = ()

    def describe(self) -> str:
        """Return one line for people."""
        more = "; ".join(each.text for each in self.help)
        where = f"seam {self.seam} from {self.from_mm:.0f} to {self.to_mm:.0f} mm is not welded: {self.why}"
        return f"{where}; what helps: {more}" if more else where


def cut_seam(search: SeamSearch, task: SeamTask) -> tuple[list[Candidate], list[Unwelded]]:
    """Weld as much of a seam as possible, in as few pieces as possible.

    From each start the piece that reaches farthest is taken: no other choice needs fewer pieces. If nothing starts at a
    point, the next rung is tried.

    Parameters
    ----------
    search : SeamSearch
    task : SeamTask
        A seam for which `SeamSearch.whole` found nothing.

    Returns
    -------
    pieces : list of Candidate
        In the order of the seam; neighbours share a point.
    unwelded : list of Unwelded
    """
    pieces: list[Candidate] = []
    gaps: list[tuple[int, int]] = []
    n, start = len(task), 0
    rungs = task.rungs().tolist()
    least = min(LEAST_PIECE_MM, task.length_mm)
    while start < n - 1:
        rest = task.part_of(start, n - 1)
        climb = search.longest(rest)
        found = climb.candidate
        if found is not None and found.task.length_mm >= least:
            pieces.append(found)
            start += climb.last
            continue
        end = next((rung for rung in rungs if rung > start), n - 1)
        if gaps and gaps[-1][1] == start:
            gaps[-1] = (gaps[-1][0], end)
        else:
            gaps.append((start, end))
        start = end
    return pieces, [_told(search, task, *gap) for gap in gaps]


def _told(search: SeamSearch, task: SeamTask, first: int, last: int) -> Unwelded:
    stretch = task.part_of(first, last)
    reason = find_reason(search, stretch)
    s = task.s_mm
    return Unwelded(task.name, float(s[first]), float(s[last]), reason, find_help(search, stretch))
