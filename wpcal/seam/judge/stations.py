"""Where along seams the tip or the wire is inside material: intervals of arc length, with exact ends."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np

from wpcal.brep.crossing import heights
from wpcal.brep.curves import arc_length, evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.hits import START_MM
from wpcal.brep.material import ExactMaterial, find_solids_around
from wpcal.brep.near_groups import find_hits_near, find_near_faces, first_of_groups
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray
from wpcal.core.last_held import last_held
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape
from wpcal.seam.limits import LEAST_CANDIDATE_MM
from wpcal.seam.path.cut import by_number, parameters_at, points_at, spans_of
from wpcal.seam.path.direction import Runs
from wpcal.seam.seam import Seam, SeamFrames

BEAD_MM = 15.0
"""Rays out of a modelled bead start this far from its root, which is below its face: 14 mm for 20 mm legs."""
SAME_PLACE_MM = 1e-3  #: Places along a seam nearer than this are one. No stretch is shorter.
CUT_MM = 1e-8
"""The end of a stretch at which the wire touches a solid is found within this, on straight seams: round-off."""
SLANT = 2.0
"""The seam goes into a solid within this many distances of the place where a point outside the joint does: the face of
the solid may lean by 63 degrees."""
RAILS = 4
"""Points of the wire whose paths are felt, from its start to the nozzle: a rod along a seam is met from 6.3 mm on."""
SEARCH_MM, SEARCH_PLACES = 16.0, 32
"""How far beside a place where a point of the wire meets a solid a free place is looked for, and at how many places at
a time."""
STRAIGHT_MM = 1e-9  #: A seam is straight, and its frame does not turn, within this: round-off.
HALVINGS = 50  #: Of a parameter interval: to the last bit.


def start_mm(seam: Seam) -> float:
    """Return how far out of the joint the wire is felt first, mm: outside the joint, its gap and a modelled bead."""
    return BEAD_MM if seam.source.is_filled else START_MM


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """A part of a seam that is free of material, or inside material, from one end to the other."""

    #: `low_mm`, `high_mm`: Arc length from the start of the seam.
    low_mm: float
    high_mm: float
    solids: frozenset[int]  #: The solids in which the tip or the wire is; empty if the stretch is free.


def rails_mm(seam: Seam, torch: TorchShape = USUAL_TORCH) -> FloatArray:
    """Return how far out of the joint the felt points of the wire are, mm; shape (RAILS,)."""
    return np.linspace(start_mm(seam), max(start_mm(seam), torch.wire_mm), RAILS)


def find_stretches(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam]) -> list[list[Stretch]]:
    """Divide seams into stretches that are free and stretches inside material.

    The paths of points of the wire are sent through the part as rays from station to station, so no solid is too thin
    to be met. Between two crossings a point is inside the same solids throughout.

    Returns: list of list of Stretch, length n. From start to end; one for a seam that is free or inside everywhere.
    """
    if not seams:
        return []
    wires = _Wires.along(graph, seams)
    hits = _crossings(trimmed, wires)
    first = np.searchsorted(hits.seam, np.arange(len(seams) + 1))
    own = [hits.select(slice(a, b)) for a, b in pairwise(first.tolist())]
    rough = _rough_stretches(trimmed, wires, own)
    changes = [change for row, near in enumerate(own) for change in _changes_of(row, seams[row], rough[row], near)]
    cuts = iter(_cuts(trimmed, wires, changes))
    return [_cut_at(seam, every, [next(cuts) for _ in every[1:]]) for seam, every in zip(seams, rough, strict=True)]


def _rough_stretches(trimmed: TrimmedFaces, wires: _Wires, hits: Sequence[_Crossings]) -> list[list[Stretch]]:
    """Return the stretches of n seams from crossing to crossing.

    A point of the wire is felt once between two crossings of its own, in the longest interval: crossings are of chords.
    """
    bounds = [_bounds(seam, own.s_mm) for seam, own in zip(wires.seams, hits, strict=True)]
    start = np.cumsum([0, *(len(own) - 1 for own in bounds)])
    q, is_first = _between(wires, bounds).reshape(-1, 3), np.zeros((start[-1], RAILS), dtype=bool)
    is_first[start[:-1]] = True
    for row, (b, own) in enumerate(zip(bounds, hits, strict=True)):
        at = np.clip(np.searchsorted(b, own.s_mm, side="right") - 1, 0, len(b) - 2)
        hit, rail = np.nonzero(own.out_mm[:, None] == wires.rails[row])
        is_first[start[row] + at[hit], rail] = True
    run = (np.cumsum(is_first, axis=0) + np.arange(RAILS) * len(is_first)).ravel()
    order = np.lexsort((np.repeat(np.concatenate([np.diff(b) for b in bounds]), RAILS), run))
    felt = order[np.flatnonzero(np.diff(run[order], append=-1))]
    around: list[set[int]] = [set() for _ in felt]
    for point, solid in zip(*find_solids_around(ExactMaterial(wires.graph, trimmed), q[felt]), strict=True):
        around[point].add(int(solid))
    of_run = np.searchsorted(run[felt], run).reshape(-1, RAILS).tolist()
    inside = [frozenset().union(*(around[number] for number in own)) for own in of_run]
    return [_joined(seam, b, inside[a:]) for seam, b, a in zip(wires.seams, bounds, start.tolist(), strict=False)]


def _changes_of(row: int, seam: Seam, stretches: Sequence[Stretch], hits: _Crossings) -> Iterator[_Change]:
    begin = 0.0
    for after in stretches[1:]:
        limit = begin if after.solids else after.high_mm
        near = hits.select(np.abs(hits.s_mm - after.low_mm) <= SAME_PLACE_MM)
        yield (change := _Change(row, seam, after.low_mm, bool(after.solids), near, limit))
        begin = after.low_mm - (SLANT * start_mm(seam) if change.is_tip else 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class _Crossings(Columns):
    """Places where points of the wire go through faces: seam, face, arc length, and how far out of the joint."""

    seam: IntArray
    face: IntArray
    s_mm: FloatArray
    out_mm: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Change:
    """A place where a seam goes into material (or out of it), to be found exactly; with the crossings there."""

    row: int
    seam: Seam
    s_mm: float
    enters: bool
    hits: _Crossings
    limit_mm: float  #: The free stretch beside it ends there at the latest: places beyond say nothing.

    @property
    def is_tip(self) -> bool:
        return bool((self.hits.out_mm == start_mm(self.seam)).any())


@dataclass(frozen=True, slots=True, eq=False)
class _Wires:
    """The wires along n seams: where a wire is at any length from the start of its seam."""

    graph: BrepGraph
    seams: Sequence[Seam]
    paths: list[SeamFrames]  #: As of `_path`.
    runs: Runs
    rails: FloatArray  #: shape (n, RAILS). As of `rails_mm`.

    @classmethod
    def along(cls, graph: BrepGraph, seams: Sequence[Seam]) -> _Wires:
        paths, rails = [_path(seam.frames) for seam in seams], np.stack([rails_mm(seam) for seam in seams])
        return cls(graph, seams, paths, Runs.of([seam.pieces for seam in seams]), rails)

    def at(self, row: IntArray, s_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the points of seams at arc lengths and the directions of the wire there, two arrays (k, 3).

        `row`: shape (k,). The seam of each length.
        """
        wires = np.empty((len(row), 6))
        for number, own in by_number(row):
            path = self.paths[number]
            columns = np.concatenate([path.p, path.R[:, :, 2]], axis=1).T
            wires[own] = np.stack([np.interp(s_mm[own], path.s_mm, column) for column in columns], axis=1)
        p, z = np.split(wires, 2, axis=1)
        curved = np.flatnonzero(np.array([len(path) > 2 for path in self.paths])[row])
        p[curved] = points_at(self.graph, self.runs, row[curved], s_mm[curved])
        return p, z / np.linalg.norm(z, axis=1, keepdims=True)


def _crossings(trimmed: TrimmedFaces, wires: _Wires) -> _Crossings:
    """Return the crossings, sorted by seam."""
    frames, rails = SeamFrames.joined(wires.paths), wires.rails
    owner = np.repeat(np.arange(len(rails)), [len(path) for path in wires.paths])
    q = frames.p[:, None] + rails[owner][..., None] * frames.R[:, None, :, 2]
    here = np.flatnonzero(owner[1:] == owner[:-1])
    q0, q1 = q[here].reshape(-1, 3), q[here + 1].reshape(-1, 3)
    first = first_of_groups(owner[here], frames.R[here, :, 2])
    near = find_near_faces(trimmed, q0, q1, RAILS * first)
    group = np.repeat(np.arange(len(first)), RAILS * np.diff(first, append=len(here)))
    step = q1 - q0
    length = np.linalg.norm(step, axis=1)
    unit = step / np.where(length > 0, length, 1.0)[:, None]
    hits = find_hits_near(trimmed, near, group, q0, unit, length_mm=length)
    row, rail = here[hits.ray // RAILS], hits.ray % RAILS
    at = frames.s_mm[row] + hits.at_mm / length[hits.ray] * np.diff(frames.s_mm)[row]
    return _Crossings(owner[row], hits.face, at, rails[owner[row], rail])


def _path(frames: SeamFrames) -> SeamFrames:
    """Return the frames between which the wire moves evenly: of a straight seam that does not turn, the two ends."""
    x = frames.R[0, :, 0]
    off = frames.p - frames.p[0] - frames.s_mm[:, None] * x
    if np.abs(off).max() > STRAIGHT_MM or np.abs(frames.R - frames.R[0]).max() > STRAIGHT_MM:
        return frames
    return frames.select(np.array([0, -1]))


def _bounds(seam: Seam, s_mm: FloatArray) -> FloatArray:
    """Return the ends of a seam and the places between them, ascending, not nearer than `SAME_PLACE_MM`."""
    length = float(seam.frames.s_mm[-1])
    kept = [0.0]
    for s in np.sort(s_mm).tolist():
        if s - kept[-1] > SAME_PLACE_MM and length - s > SAME_PLACE_MM:
            kept.append(s)
    return np.array([*kept, length])


def _between(wires: _Wires, bounds: Sequence[FloatArray]) -> FloatArray:
    """Return the points of the wires between neighbouring bounds: at a station, or else half-way; (k, RAILS, 3)."""
    low, high = (np.concatenate([own[ends] for own in bounds]) for ends in (slice(None, -1), slice(1, None)))
    row, s = np.repeat(np.arange(len(bounds)), [len(own) - 1 for own in bounds]), (low + high) / 2
    frames = SeamFrames.joined([seam.frames for seam in wires.seams])
    first = np.cumsum([0, *(len(seam.frames) for seam in wires.seams)])
    near = [first[k] + np.abs(wires.seams[k].frames.s_mm - s[at][:, None]).argmin(axis=1) for k, at in by_number(row)]
    own = frames.select(np.concatenate(near))
    p, z = own.p, own.R[:, :, 2]
    odd = np.flatnonzero((own.s_mm <= low) | (own.s_mm >= high))
    p[odd], z[odd] = wires.at(row[odd], s[odd])
    return np.asarray(p[:, None] + wires.rails[row][..., None] * z[:, None])


def _parameters(graph: BrepGraph, seam: Seam, s_mm: FloatArray) -> tuple[int, FloatArray]:
    """Return the piece that holds the middle of arc lengths, and their parameters on it, which do not leave it."""
    starts, ends = spans_of(graph, seam.pieces)
    row = int(np.clip(np.searchsorted(ends, s_mm.mean()), 0, len(ends) - 1))
    own = np.clip(s_mm - starts[row], 0.0, ends[row] - starts[row])
    return row, parameters_at(graph, seam.pieces, np.full(len(own), row), own)


def _joined(seam: Seam, bounds: FloatArray, inside: Sequence[frozenset[int]]) -> list[Stretch]:
    """Join the intervals between bounds that are all free or all inside the solids `inside`."""
    found = []
    for _, run in groupby(zip(pairwise(bounds.tolist()), inside, strict=False), key=lambda own: bool(own[1])):
        ends, solids = zip(*run, strict=True)
        found.append(Stretch(ends[0][0], ends[-1][1], frozenset().union(*solids)))
    return _without_slivers(seam, found)


def _cut_at(seam: Seam, stretches: Sequence[Stretch], cuts: Sequence[float]) -> list[Stretch]:
    """Move the ends between stretches to exact ones."""
    ends = [stretches[0].low_mm]
    for stretch, cut in zip(stretches[1:], cuts, strict=True):
        ends.append(min(max(cut, ends[-1]), stretch.high_mm))
    ends.append(stretches[-1].high_mm)
    return _without_slivers(
        seam, [Stretch(*own, stretch.solids) for own, stretch in zip(pairwise(ends), stretches, strict=True)]
    )


def _without_slivers(seam: Seam, stretches: Sequence[Stretch]) -> list[Stretch]:
    """Give free stretches that are too short for a weld, and all below `SAME_PLACE_MM`, to their neighbours.

    What is free at the start of a closed seam may go on at its end.
    """
    kept: list[Stretch] = []
    for number, stretch in enumerate(stretches):
        low, is_last = stretch.low_mm if kept else stretches[0].low_mm, number == len(stretches) - 1
        least_mm = _least_mm(stretch, is_split=seam.closed and number in (0, len(stretches) - 1))
        if kept and (stretch.high_mm - low <= least_mm or bool(stretch.solids) == bool(kept[-1].solids)):
            last = kept.pop()
            kept.append(Stretch(last.low_mm, stretch.high_mm, last.solids and last.solids | stretch.solids))
        elif is_last or stretch.high_mm - low > least_mm:
            kept.append(Stretch(low, stretch.high_mm, stretch.solids))
    return kept


def _least_mm(stretch: Stretch, *, is_split: bool) -> float:
    return SAME_PLACE_MM if stretch.solids or is_split else LEAST_CANDIDATE_MM


def _cuts(trimmed: TrimmedFaces, wires: _Wires, changes: Sequence[_Change]) -> list[float]:
    """Return the arc lengths at which to cut: where the seam goes through a face, or else where the wire is free."""
    cuts = [_exact(wires.graph, c.seam, c.s_mm, c.hits, enters=c.enters) if c.is_tip else np.nan for c in changes]
    wire = [row for row, change in enumerate(changes) if not change.is_tip]
    for row, s in zip(wire, _where_wire_is_free(trimmed, wires, [changes[row] for row in wire]).tolist(), strict=True):
        cuts[row] = s
    return cuts


def _exact(graph: BrepGraph, seam: Seam, s_mm: float, hits: _Crossings, *, enters: bool) -> float:
    """Return where a seam or the start of the wire goes through faces, whichever leaves the shorter free stretch.

    On a modelled bead, where the wire starts far from the seam, the seam decides.
    """
    reach = SLANT * start_mm(seam)
    row, t = _parameters(graph, seam, np.array([s_mm - reach, s_mm + reach]))
    if t[0] == t[1]:  # on a bridge between two pieces
        return s_mm
    edge, first = int(seam.pieces.edge[row]), float(spans_of(graph, seam.pieces)[0][row])
    t0 = float(seam.pieces.t0[row])
    ends = np.array([first + abs(arc_length(graph, edge, t0, float(value))) for value in t])
    faces = hits.face[hits.out_mm == start_mm(seam)]
    found: list[float] = []
    for out in (0.0, start_mm(seam)):

        def is_above(row: IntArray, at: FloatArray, out_mm: float = out) -> BoolArray:
            p = evaluate_edges(graph, np.full(len(at), edge), at)[0]
            s = ends[0] + (at - t[0]) / (t[1] - t[0]) * (ends[1] - ends[0])
            z = np.stack([np.interp(s, seam.frames.s_mm, seam.frames.R[:, k, 2]) for k in range(3)], axis=1)
            return np.asarray(heights(graph, faces[row], p + out_mm * z) > 0, dtype=bool)

        at = _changes(is_above, t, len(faces))
        found += [first + abs(arc_length(graph, edge, t0, float(value))) for value in at]
        if found and seam.source.is_filled:
            break
    return (min(found) if enters else max(found)) if found else s_mm


def _where_wire_is_free(trimmed: TrimmedFaces, wires: _Wires, changes: Sequence[_Change]) -> FloatArray:
    """Return the places next to those where a point of the wire meets a solid at which the whole wire is free."""
    if not changes:
        return np.zeros(0)
    start = np.array([start_mm(change.seam) for change in changes])
    length = np.maximum(USUAL_TORCH.wire_mm - start, 0.0)
    bad, limit = np.array([(change.s_mm, change.limit_mm) for change in changes]).T
    end = np.array([0.0 if change.enters else change.seam.frames.s_mm[-1] for change in changes])
    good = bad + np.clip(end - bad, -SEARCH_MM, SEARCH_MM)
    seam, way = np.array([change.row for change in changes]), np.sign(good - bad)
    share = np.arange(1, SEARCH_PLACES + 1) / SEARCH_PLACES
    while True:
        rows = np.flatnonzero((np.abs(good - bad) > CUT_MM) & ((bad - limit) * way < 0.0))
        if len(rows) == 0:
            return np.asarray(good, dtype=np.float64)
        places = bad[rows, None] + (good - bad)[rows, None] * share
        is_asked = np.ones(places.shape, dtype=bool)
        is_asked[:, 1:] = (places[:, :-1] - limit[rows, None]) * way[rows, None] < 0.0
        own, at = np.nonzero(is_asked)
        p, z = wires.at(seam[rows][own], places[own, at])
        q, far_mm = p + start[rows][own, None] * z, length[rows][own]
        near = find_near_faces(trimmed, q, q + far_mm[:, None] * z, np.flatnonzero(np.diff(own, prepend=-1)))
        met = find_hits_near(trimmed, near, own, q, z, length_mm=far_mm).ray
        free = np.ones(places.shape, dtype=bool)
        free[own[met], at[met]] = False
        first = np.where(free.any(axis=1), free.argmax(axis=1), SEARCH_PLACES - 1)
        own = np.arange(len(rows))
        bad[rows] = np.where(first > 0, places[own, np.maximum(first - 1, 0)], bad[rows])
        good[rows] = places[own, first]


def _changes(is_above: Callable[[IntArray, FloatArray], BoolArray], t: FloatArray, count: int) -> FloatArray:
    """Return the parameters between two at which a point goes through `count` faces: where it is above them or not."""
    every = np.arange(count)
    side = is_above(every, np.full(count, t[0]))
    rows = np.flatnonzero(side != is_above(every, np.full(count, t[1])))
    low, high = (np.full(len(rows), end) for end in t)
    low, high = last_held(low, high, lambda row, at: is_above(rows[row], at) == side[rows[row]], halvings=HALVINGS)
    return np.asarray((low + high) / 2, dtype=np.float64)
