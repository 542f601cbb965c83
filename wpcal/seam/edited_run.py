"""What a person's decision makes of a candidate: its run, its frames, and what the rules say about them.

Nothing is taken over from the file of decisions but the decisions. Length, frames, material and reach are computed anew
on the part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.seam.judge.evidence import Judge, is_judgement, judge_seams
from wpcal.seam.judge.stations import find_stretches
from wpcal.seam.judge.stretches import FELT_CHORD_MM
from wpcal.seam.judge.unreached import with_reach
from wpcal.seam.limits import MEETING_MM
from wpcal.seam.options import SeamOptions
from wpcal.seam.path.build import CLOSED_MM, with_frames
from wpcal.seam.path.cut import cut_run
from wpcal.seam.path.direction import Runs
from wpcal.seam.path.turning import face_free_space
from wpcal.seam.seam import Seam, SeamPieces, SeamSource

SAME_PLACE_MM = 0.1  #: A range may end this far beyond its seam: files of other programs round.


def part_of(graph: BrepGraph, seam: Seam, range_mm: tuple[float, float] | None) -> SeamPieces:
    """Return the pieces of a candidate between two lengths from its start; all of them without a range.

    Raises `InputError` if the range is longer than the candidate.
    """
    if range_mm is None:
        return seam.pieces
    low, high = range_mm
    if high > seam.length_mm + SAME_PLACE_MM:
        ends = f"range_mm ends at {high:g}, but the seam at {seam.length_mm:.3f} mm"
        raise InputError(f"edit of seam {seam.name}: {ends}")
    return cut_run(graph, seam.pieces, low, min(high, seam.length_mm))


def joined_run(graph: BrepGraph, runs: Sequence[tuple[str, SeamPieces]], *, join_mm: float = MEETING_MM) -> SeamPieces:
    """Return several runs as one, which goes in the direction of the first.

    Raises `InputError` if the ends of a run do not meet those of the others within `join_mm`.

    `runs`: Names, for messages, and pieces. The first keeps its direction; the others are put before or after it, in
    any order, and are turned where their other end meets.
    `join_mm`: Largest straight bridge between two runs, mm.
    """
    (first, run), *left = runs
    while left:
        ways = [way for row, (_, other) in enumerate(left) for way in _ways(graph, run, other, row)]
        gap_mm, row, together = min(ways, key=lambda way: way[:2])
        if gap_mm > join_mm:
            what = f"{left[row][0]} does not meet {first}: their nearest ends are {gap_mm:.1f} mm apart"
            raise InputError(f"edit of seam {first}: {what}, expected at most {join_mm:g} mm")
        run = SeamPieces.joined(together)
        del left[row]
    return run


def _ways(graph: BrepGraph, run: SeamPieces, other: SeamPieces, row: int) -> list[tuple[float, int, list[SeamPieces]]]:
    """Return the four ways to put one run to another, each with the gap between the ends that meet."""
    (p0, p1), (q0, q1) = _ends(graph, run), _ends(graph, other)
    pairs = [
        (p1, q0, [run, other]),
        (p1, q1, [run, other.backwards()]),
        (p0, q1, [other, run]),
        (p0, q0, [other.backwards(), run]),
    ]
    return [(float(np.linalg.norm(p - q)), row, together) for p, q, together in pairs]


def _ends(graph: BrepGraph, run: SeamPieces) -> tuple[FloatArray, FloatArray]:
    p0, p1 = Runs.of([run]).ends(graph)
    return p0[0], p1[0]


def is_loop(graph: BrepGraph, run: SeamPieces) -> bool:
    """Tell whether a run ends where it starts."""
    p0, p1 = _ends(graph, run)
    return bool(np.linalg.norm(p1 - p0) <= CLOSED_MM)


def framed(graph: BrepGraph, trimmed: TrimmedFaces, seam: Seam, options: SeamOptions) -> Seam:
    """Return a seam with the length and the frames of its pieces; its edit says from which side the torch comes."""
    (framed,) = with_frames(graph, [seam], options)
    faced = face_free_space(graph, trimmed, framed)
    if seam.edit is None or not seam.edit.other_side:
        return faced
    R = faced.frames.R * np.array([1.0, -1.0, -1.0])
    return replace(faced, frames=replace(faced.frames, R=R))


def judged_anew(
    graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], options: SeamOptions, *, has_marks: bool
) -> list[Seam]:
    """Return edited seams with frames, and what the rules say about them: material, reach, confidence."""
    if not seams:
        return []
    finer = options
    if options.steps.chord_mm > FELT_CHORD_MM:
        finer = replace(options, steps=replace(options.steps, chord_mm=FELT_CHORD_MM))
    felt = find_stretches(graph, trimmed, [framed(graph, trimmed, seam, finer) for seam in seams])
    found = []
    for seam, stretches in zip(seams, felt, strict=True):
        solids = frozenset().union(*(stretch.solids for stretch in stretches))
        inside = tuple(graph.solid_names[solid] for solid in sorted(solids))
        own = tuple(text for text in seam.reasons if not is_judgement(text, seam.source))
        found.append(framed(graph, trimmed, replace(seam, inside=inside, reasons=own), options))
    judge = Judge.of(graph, trimmed, options, has_marks=has_marks)
    return list(judge_seams(graph, trimmed, with_reach(graph, trimmed, found, options.reach), options, judge))


def marks_in(seams: Sequence[Seam]) -> bool:
    """Tell whether edges of the part are marked as seams."""
    return any(seam.source is SeamSource.MARKED for seam in seams)
