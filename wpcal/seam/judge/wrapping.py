"""Runs round the corners of members (``--wrap``): accepted seams that meet there become one, with short ends between.

Two seams are joined where their ends meet, if they join the same solids with the same kind of weld, turn by at most
`MOST_TURN_RAD`, and the torch gets round the corner. The short end of a plate counts as accepted then, also if it is
shorter than a seam of its own must be. A run round a whole member starts in the middle of its longest side: nobody
starts a weld at a corner.

Without ``--wrap`` only the four grooves round a tab that ends flush in its slot become one: that is one plug weld. And
so do fillets round the foot of a small bar, all of whose sides are short: nobody strikes an arc for each of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.linked import near_pairs
from wpcal.seam.chain import Chain
from wpcal.seam.judge.evidence import Judge, is_judgement, judge_seams, weighed
from wpcal.seam.judge.leans import Felt, feel_seams
from wpcal.seam.judge.short_ends import MOST_END_MM, find_short_ends
from wpcal.seam.judge.stations import Stretch, find_stretches
from wpcal.seam.limits import LEAST_CHANGE_MM
from wpcal.seam.options import SeamOptions
from wpcal.seam.path.build import with_frames
from wpcal.seam.path.corners import CORNER_MM, find_corners
from wpcal.seam.path.cut import cut_run, spans_of
from wpcal.seam.path.direction import directed_runs
from wpcal.seam.path.turning import face_free_space
from wpcal.seam.rules import Rule
from wpcal.seam.seam import Seam, SeamPieces, WeldType

MOST_TURN_RAD = float(np.radians(150.0))
"""Largest turn at one corner: a sharper one leads back beside the seam, on the other side of a thin plate."""
SAME_PLANE_COS = 0.99  #: Cosine between the torch axes of grooves in one plane (8 degrees).
ROUNDS = 4  #: Corners that the torch does not get round are left open, and the rest is tried again, this many times.

Link = tuple[int, int]
"""Two ends that meet: 2 i is the start of the seam in row i, 2 i + 1 its end. The smaller number first."""


def weld_round_corners(
    graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], options: SeamOptions, judge: Judge
) -> list[Seam]:
    """Join accepted seams round the corners of members, with the short ends between them.

    Returns list of Seam. Joined seams replace those that they are made of.
    """
    if options.wrap:
        links = _links(seams, _eligible(graph, trimmed, seams, judge))
    else:
        links = _round_tabs(seams) | _round_feet(graph, trimmed, seams, judge)
    for _ in range(ROUNDS):
        runs = [run for run in _walks(links) if len(run.ends) > 1]
        joined = with_frames(graph, [_joined(graph, seams, run) for run in runs], options)
        built = [face_free_space(graph, trimmed, seam) for seam in joined]
        felt = feel_seams(graph, trimmed, built, options.reach)
        wrong = _unreached(seams, zip(built, runs, felt, find_stretches(graph, trimmed, built), strict=True))
        if not wrong:
            break
        links = links - wrong
    else:
        return list(seams)
    leant = [own.lay_on(seam) for seam, own in zip(built, felt, strict=True)]
    judged = judge_seams(graph, trimmed, leant, options, judge)
    kept = [(seam, run) for seam, run in zip(judged, runs, strict=True) if seam.accepted]
    taken = {end // 2 for _, run in kept for end in run.ends}
    return [*(seam for row, seam in enumerate(seams) if row not in taken), *(seam for seam, _ in kept)]


def _eligible(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], judge: Judge) -> list[int]:
    """Return the open seams that may be part of a run: the accepted ones, and short ends of these."""
    owner = find_short_ends(graph, trimmed, seams)

    def is_end(row: int) -> bool:
        others = (one for one in seams[row].findings if one.rule != Rule.TOO_SHORT.key)
        beside = int(owner[row])
        return beside >= 0 and seams[beside].accepted and weighed(seams[row], others, judge.level).accepted

    return [row for row, seam in enumerate(seams) if not seam.closed and (seam.accepted or is_end(row))]


def _round_tabs(seams: Sequence[Seam]) -> frozenset[Link]:
    """Return the links of closed runs of grooves in one plane, round the end of a plate in a slot."""
    grooves = [row for row, seam in enumerate(seams) if seam.accepted and seam.weld is WeldType.GROOVE]
    links = _links(seams, [row for row in grooves if not seams[row].closed])
    z = {end: seams[end // 2].frames.R[-(end % 2), :, 2] for link in links for end in link}
    runs = _walks(frozenset((a, b) for a, b in links if z[a] @ z[b] > SAME_PLANE_COS))
    round_tabs = [
        run for run in runs if run.closed and min(seams[end // 2].length_mm for end in run.ends) <= MOST_END_MM
    ]
    return frozenset(link for run in round_tabs for link in run.links)


def _round_feet(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], judge: Judge) -> frozenset[Link]:
    """Return the links of fillets round feet all of whose sides are short."""
    fillets = [row for row, seam in enumerate(seams) if seam.weld is WeldType.FILLET and not seam.closed]
    short = [row for row in fillets if seams[row].length_mm <= MOST_END_MM]
    if not any(seams[row].accepted for row in short):
        return frozenset()
    sides = [seams[row] for row in short]
    rows = [short[row] for row in _eligible(graph, trimmed, sides, judge)]
    return _links(seams, rows)


def _links(seams: Sequence[Seam], rows: list[int]) -> frozenset[Link]:
    """Return which ends meet at corners, the nearest first; each end meets one other."""
    if not rows:
        return frozenset()
    frames = [seams[row].frames for row in rows]
    p = np.concatenate([own.p[[0, -1]] for own in frames])
    out = np.concatenate([[-own.R[0, :, 0], own.R[-1, :, 0]] for own in frames])
    pairs = near_pairs(p, LEAST_CHANGE_MM)
    a, b = pairs.T
    turn = np.arccos(np.clip(-np.einsum("ki,ki->k", out[a], out[b]), -1.0, 1.0))
    apart = np.linalg.norm(p[a] - p[b], axis=1)
    order = np.lexsort((b, a, np.round(turn, 6), np.round(apart, 6)))
    links: set[Link] = set()
    used: set[int] = set()
    for i, j in pairs[order[turn[order] <= MOST_TURN_RAD]].tolist():
        one, other = 2 * rows[i // 2] + i % 2, 2 * rows[j // 2] + j % 2
        a, b = seams[one // 2], seams[other // 2]
        if not {one, other} & used and a is not b and set(a.solids) == set(b.solids) and a.weld is b.weld:
            links.add((min(one, other), max(one, other)))
            used |= {one, other}
    return frozenset(links)


@dataclass(frozen=True, slots=True)
class _Run:
    """Seams in order: the end at which each one is entered, and the links between them."""

    ends: tuple[int, ...]
    links: tuple[Link, ...]
    closed: bool


def _walks(links: frozenset[Link]) -> list[_Run]:
    """Return the runs that links make, in the order of their first seam."""
    beyond = dict(links) | {b: a for a, b in links}
    rows = sorted({end // 2 for end in beyond})
    open_ends = [end for row in rows for end in (2 * row, 2 * row + 1) if end not in beyond]
    runs: list[_Run] = []
    used: set[int] = set()
    for start in [*open_ends, *(2 * row for row in rows)]:
        ends, passed, end, closed = list[int](), list[Link](), start, False
        while end // 2 not in used:
            used.add(end // 2)
            ends.append(end)
            after = beyond.get(end ^ 1)
            if after is None:
                break
            passed.append((min(end ^ 1, after), max(end ^ 1, after)))
            end, closed = after, after == start
        if ends:
            runs.append(_Run(tuple(ends), tuple(passed), closed))
    return runs


def _joined(graph: BrepGraph, seams: Sequence[Seam], run: _Run) -> Seam:
    """Return the seam that goes along all seams of a run; its frames are still those of the longest one."""
    own = [seams[end // 2] for end in run.ends]
    ways = zip(own, run.ends, strict=True)
    pieces = SeamPieces.joined([seam.pieces.backwards() if end % 2 else seam.pieces for seam, end in ways])
    whole = Chain(np.arange(len(pieces)), np.zeros(len(pieces), dtype=bool), run.closed)
    pieces = directed_runs(graph, pieces, [whole]).pieces
    if run.closed:
        pieces = _from_longest_side(graph, pieces)
    wire = max(seam.more_wire_mm for seam in own)
    longest = max(own, key=lambda seam: seam.length_mm)
    corners = len(find_corners(graph, pieces).low_mm)
    words = f"{len(own)} seams in one run round {corners} corner{'s' if corners > 1 else ''}: "
    said = (text for seam in own for text in seam.reasons if not is_judgement(text, seam.source))
    reasons = tuple(dict.fromkeys([*said, f"{words}the torch turns on up to {CORNER_MM:g} mm before and after each"]))
    return replace(
        longest, pieces=pieces, closed=run.closed, reasons=reasons, groove=None, wrap_of=None, more_wire_mm=wire
    )


def _from_longest_side(graph: BrepGraph, pieces: SeamPieces) -> SeamPieces:
    """Return a closed run that starts in the middle of its longest side."""
    corners, length = find_corners(graph, pieces), float(spans_of(graph, pieces)[1][-1])
    begin = np.concatenate([[0.0], corners.high_mm])
    end = np.concatenate([corners.low_mm, [length]])
    longest = int(np.argmax(np.round(end - begin, 6)))
    middle = float(begin[longest] + end[longest]) / 2
    return SeamPieces.joined([cut_run(graph, pieces, middle, length), cut_run(graph, pieces, 0.0, middle)])


def _unreached(seams: Sequence[Seam], found: Iterable[tuple[Seam, _Run, Felt, list[Stretch]]]) -> frozenset[Link]:
    """Return the links at which a wire is inside material, or that no torch gets round.

    If that is not at a corner, all links of the run are returned.
    """
    wrong: set[Link] = set()
    for seam, run, felt, parts in found:
        if felt.is_free and not any(part.solids for part in parts):
            continue
        bad = np.flatnonzero((felt.solid >= 0) | (np.append(felt.solid_after, -1) >= 0))
        p = np.array([seams[a // 2].frames.p[-(a % 2)] for a, _ in run.links])
        apart = np.linalg.norm(p[:, None] - seam.frames.p[bad], axis=2)
        is_at_corners = len(bad) > 0 and (apart.min(axis=0) <= CORNER_MM + LEAST_CHANGE_MM).all()
        wrong |= {run.links[row] for row in np.argmin(apart, axis=0)} if is_at_corners else set(run.links)
    return frozenset(wrong)
