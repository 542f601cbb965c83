"""Seams that cannot be welded whole: cut at the best places, and told where a stretch is left out.

Ways are searched forwards from every place where one is needed, and backwards from the end of each of them, so that
they overlap. Every part of a way is a way too. Among all cuts of these ways the one is taken that welds the most
length, then in the fewest pieces, then with the longest shortest piece.

Also here: why a stretch of a seam cannot be welded: torch, reach, a limit of a joint, a configuration, or a body.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.workplace import reach_shortage
from wpcal.planning.sequence.external import external_axes, values_along
from wpcal.planning.sequence.remedies import Help, RemedySearch
from wpcal.planning.sequence.seam_search import SeamSearch
from wpcal.planning.sequence.seam_task import Candidate, SeamTask, seam_task
from wpcal.planning.sequence.sequence_input import PlannedSeam
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.planning.sequence.torch_poses import TorchPoses, torch_poses

TRIED_AXES = 16  #: Positions of the external axes that a reason is looked for at: the most promising ones.
TESTED = 64  #: Joints whose clearance is measured for a reason.


def out_of_reach(cell: Cell, seams: Sequence[PlannedSeam], targets: SequenceTargets) -> tuple[str, ...]:
    """Return one line per seam that the arm does not reach whole, whatever the bodies: a look before the search."""
    cell = cell.with_joint_margin(targets.joint_margin_rad)
    search, found = SeamSearch(cell, CellClearance(cell, None), targets), []
    for seam in seams:
        task, why = seam_task(seam.seam), None
        for tilted in (False, True):
            poses = torch_poses(task, targets, search.clearance, tilted=tilted)
            why = _out_of_reach(search, task, poses)[0]
            if why is None:
                break
        if why is not None:
            found.append(f"seam {task.name} cannot be welded whole: {why}")
    return tuple(found)


def _out_of_reach(
    search: SeamSearch, stretch: SeamTask, poses: TorchPoses
) -> tuple[str | None, tuple[FloatArray, FloatArray, BoolArray]]:
    """Return why and where no branch reaches a stretch; and external axes along it, joints, and what is usable."""
    values = external_axes(search.cell, stretch, search.targets).values[:TRIED_AXES]
    joints, usable = search.states(stretch, poses, values)
    along = values_along(values, stretch, poses.rungs)
    reached = usable.any(axis=(2, 3)).any(axis=0)
    rung = int(np.argmin(reached))
    why = None if reached.all() else f"{_unreached(search, poses, along, joints, rung)}{_at(stretch, poses, rung)}"
    return why, (along, joints, usable)


def find_reason(search: SeamSearch, stretch: SeamTask) -> str:
    """Return why no way welds a stretch, and where on the seam, for people."""
    poses = torch_poses(stretch, search.targets, search.clearance, tilted=True)
    free = poses.is_free.any(axis=1)
    if not free.all():
        where = _at(stretch, poses, int(np.argmin(free)))
        return f"the torch meets the part at every angle within its range{where}"
    why, states = _out_of_reach(search, stretch, poses)
    return why or _body_in_the_way(search, stretch, poses, *states)


def _at(stretch: SeamTask, poses: TorchPoses, rung: int) -> str:
    return f", at {stretch.s_mm[poses.rungs[rung]]:.0f} mm"


def _unreached(search: SeamSearch, poses: TorchPoses, along: FloatArray, joints: FloatArray, rung: int) -> str:
    """Return why no branch reaches a rung."""
    free = poses.is_free[rung]
    q = joints[:, rung][:, free]  # (C, K', 8, 6)
    reached = np.isfinite(q).all(axis=-1)
    if not reached.any():
        at = np.repeat(along[:, rung : rung + 1], int(free.sum()), axis=1)
        T = search.flange_places(poses.T_part_tool[rung][free], at).reshape(-1, 4, 4)
        short = float(reach_shortage(search.cell.arm, T).min())
        return f"out of reach of {search.cell.arm.name}, by {short:.0f} mm at least"
    return _limit(search.cell, q[reached])


def _limit(cell: Cell, q: FloatArray) -> str:
    """Name the joint that is nearest to letting joints (r, 6) within its limits."""
    low, high = cell.arm.limits
    turned = q - 2 * np.pi * np.rint((q - (low + high) / 2) / (2 * np.pi))
    beyond = np.maximum(np.maximum(low - turned, turned - high), 0.0)
    row = int(np.argmin(beyond.max(axis=1)))
    joint = int(np.argmax(beyond[row]))
    if beyond[row, joint] == 0.0:
        return "only singular poses reach it (the wrist, the elbow or the arm is stretched)"
    least, most = np.degrees(cell.arm.limits[:, joint])
    at, name = np.degrees(turned[row, joint]), cell.arm.joints[joint].name
    return f"joint {name} would be at {at:.0f} deg, its limits are {least:g} and {most:g} deg"


def _body_in_the_way(
    search: SeamSearch, stretch: SeamTask, poses: TorchPoses, along: FloatArray, joints: FloatArray, usable: BoolArray
) -> str:
    """Name the two bodies that are too near at the best state of the worst rung."""
    worst: tuple[float, str, int] | None = None
    for rung in range(joints.shape[1]):
        c, k, b = np.nonzero(usable[:, rung])
        rows = np.linspace(0, len(c) - 1, min(TESTED, len(c))).astype(int)
        q = np.concatenate([joints[c[rows], rung, k[rows], b[rows]], along[c[rows], rung]], axis=1)
        found = search.clearance.margins(q)
        best = int(np.argmax(found.margin_mm))
        margin = float(found.margin_mm[best])
        if worst is None or margin < worst[0]:
            one, two = search.clearance.names(int(found.pair[best]))
            worst = (margin, f"{one} against {two}, which miss their safety distance by {-margin:.0f} mm at best", rung)
    if worst is None or worst[0] > 0.0:
        return _change_of_configuration(search, stretch, poses, joints, usable)
    return f"a body is in the way: {worst[1]}{_at(stretch, poses, worst[2])}"


def _change_of_configuration(
    search: SeamSearch, stretch: SeamTask, poses: TorchPoses, joints: FloatArray, usable: BoolArray
) -> str:
    """Say how far the best branch gets, and what ends it."""
    ways = np.asarray(usable.any(axis=2))  # (C, m, 8)
    m = ways.shape[1]
    prefix = np.where(ways.all(axis=1), m, np.argmin(ways, axis=1))
    c, b = np.unravel_index(int(np.argmax(prefix)), prefix.shape)
    rung = int(prefix[c, b])
    what = "the arm would have to change its configuration"
    if rung == m:  # it reaches every rung, but not along the seam, or has no way back
        whole = search.longest(stretch).candidate
        if whole is not None and len(whole) == len(stretch):
            found = [(search.withdrawn(whole.q[row]).why, row) for row in (0, -1)]
            if whys := [f"{why}{_at(stretch, poses, row)}" for why, row in found if why is not None]:
                return whys[0]
        return f"{what} on the way: its states at neighbouring points are too far apart, or a body is between them"
    q = joints[c, rung, poses.is_free[rung], b]
    q = q[np.isfinite(q).all(axis=-1)]
    end = _limit(search.cell, q) if len(q) else "the configuration it has does not reach it"
    return f"{what}{_at(stretch, poses, rung)}: {end}"


LEAST_PIECE_MM = 15.0
"""A shorter piece is not worth a start and an end of the arc; a seam that is shorter itself is welded whole or not."""
ROUND_OFF_MM = 1e-6  #: Lengths that differ by less are equal.


@dataclass(frozen=True, slots=True)
class Unwelded:
    """A stretch of a seam that is not welded."""

    seam: str
    #: `from_mm`, `to_mm`: Arc length along the seam.
    from_mm: float
    to_mm: float
    why: str
    help: tuple[Help, ...] = ()  #: Changes with which it is welded, as a trial showed; empty if none was found.
    is_searched: bool = True  #: Whether all kinds of changes were tried.

    def describe(self) -> str:
        """Return one line for people."""
        where = f"seam {self.seam} from {self.from_mm:.0f} to {self.to_mm:.0f} mm is not welded: {self.why}"
        if self.help:
            return f"{where}; tried, and it is welded with: {'; or '.join(each.text for each in self.help)}"
        if self.is_searched:
            return (
                f"{where}; no remedy was found: the part turned, raised, lowered or farther from its table, the robot "
                "moved up to 600 mm, a wider torch range, a slimmer torch"
            )
        return f"{where}; no remedy was searched, and those of other stretches do not help"


class Span(NamedTuple):
    """Points of a seam from one to another, both included."""

    first: int
    last: int

    def holds(self, other: Span) -> bool:
        """Tell whether the other is in it."""
        return self.first <= other.first and other.last <= self.last


class _Way(NamedTuple):
    span: Span
    candidate: Candidate


def cut_seam(search: SeamSearch, task: SeamTask, remedies: RemedySearch) -> tuple[list[Candidate], list[Unwelded]]:
    """Weld as much of a seam as possible, in as few pieces as possible."""
    ways = _ways(search, task)
    spans = best_cuts(task.s_mm, [way.span for way in ways], min(LEAST_PIECE_MM, task.length_mm))
    found = [_leaving(search, task, next(way for way in ways if way.span.holds(span)), span) for span in spans]
    spans, pieces = [each.span for each in found if each], [each.candidate for each in found if each]
    ends = [0, *(row for span in spans for row in span), len(task) - 1]
    gaps = [Span(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if b > a]
    return pieces, [_told(search, task, gap, remedies) for gap in gaps]


def best_cuts(s_mm: FloatArray, ways: Sequence[Span], least_mm: float) -> list[Span]:
    """Return the pieces that weld the most length, then the fewest, then those with the longest shortest piece.

    `s_mm`: shape (n,). Arc length of the points, increasing.
    """
    n = len(s_mm)
    s = np.rint(s_mm / ROUND_OFF_MM).astype(np.int64).tolist()  # whole numbers: pieces in a row add up exactly
    least = round(least_mm / ROUND_OFF_MM) - 1
    reach = np.full(n, -1)
    for first, last in ways:
        reach[first : last + 1] = np.maximum(reach[first : last + 1], last)
    # best from each point on: welded length, minus the number of pieces, length of the shortest
    best: list[tuple[int, int, float]] = [(0, 0, np.inf)] * n
    taken: list[int | None] = [None] * n
    for i in range(n - 2, -1, -1):
        best[i] = best[i + 1]
        for j in range(i + 1, int(reach[i]) + 1):
            length = s[j] - s[i]
            if length < least:
                continue
            welded, pieces, shortest = best[j]
            value = (welded + length, pieces - 1, min(shortest, length))
            if value > best[i]:
                best[i], taken[i] = value, j
    spans, at = [], 0
    while at < n - 1:
        to = taken[at]
        if to is None:
            at += 1
        else:
            spans.append(Span(at, to))
            at = to
    return spans


def _ways(search: SeamSearch, task: SeamTask) -> list[_Way]:
    """Return ways forwards from every place where one is needed, and backwards from their ends."""
    found: list[_Way] = []
    n, start = len(task), 0
    rungs = task.rungs().tolist()
    while start < n - 1:
        climb = search.longest(task.part_of(start, n - 1))
        if climb.candidate is not None:
            found.append(_Way(Span(start, start + climb.last), climb.candidate))
        is_long = bool(found) and task.s_mm[found[-1].span.last] - task.s_mm[start] >= LEAST_PIECE_MM
        if is_long and found[-1].span.first == start:
            start = found[-1].span.last
        else:
            start = next((rung for rung in rungs if rung > start), n - 1)
    if search.targets.work_rad or search.targets.travel_rad:
        return found  # a torch that is pushed or leans is another way in the other direction
    return [*found, *(way for one in found if (way := _backwards(search, task, one.span)) is not None)]


def _backwards(search: SeamSearch, task: SeamTask, span: Span) -> _Way | None:
    """Return the way that ends where another one ends, and begins as early as possible."""
    if span.first == 0:
        return None
    climb = search.longest(task.part_of(0, span.last).backwards())
    if climb.candidate is None or span.last - climb.last >= span.first:
        return None
    return _Way(Span(span.last - climb.last, span.last), replace(climb.candidate.backwards(), is_reversed=False))


def _part(search: SeamSearch, task: SeamTask, way: _Way, span: Span) -> Candidate:
    rows = slice(span.first - way.span.first, span.last - way.span.first + 1)
    whole = way.candidate
    return search.candidate(task.part_of(*span), whole.angles[rows], whole.q[rows], whole.branch)


def _leaving(search: SeamSearch, task: SeamTask, way: _Way, span: Span) -> _Way | None:
    """Return the longest part of a piece from whose ends the torch can go back along the wire; None if it is short."""
    s_mm, rows = task.s_mm, span.first + np.flatnonzero(search.leaves(_part(search, task, way, span).q))
    least_mm = min(LEAST_PIECE_MM, task.length_mm) - ROUND_OFF_MM
    if len(rows) == 0 or s_mm[rows[-1]] - s_mm[rows[0]] < least_mm:
        return None
    kept = Span(int(rows[0]), int(rows[-1]))
    return _Way(kept, _part(search, task, way, kept))


def _told(search: SeamSearch, task: SeamTask, gap: Span, remedies: RemedySearch) -> Unwelded:
    stretch = task.part_of(*gap)
    found, is_searched = remedies.find(stretch)
    s = task.s_mm
    why = find_reason(search, stretch)
    return Unwelded(task.name, float(s[gap.first]), float(s[gap.last]), why, found, is_searched)
