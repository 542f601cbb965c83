"""How the torch leans at every station of a seam so that it meets nothing: straight where it can, tilted where it must.

Straight means along z of the seam's frame. Where a wall or a gusset is in the way of the nozzle, welders tilt the torch
along the seam or across it.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.strips import wrap_angle
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.ladder import cheapest_way
from wpcal.core.motion import APPROACH_MM
from wpcal.core.process import give_memory_back
from wpcal.robot.moves import sweep_moves
from wpcal.robot.moves.interpolation import swings_between, turns_between
from wpcal.robot.torch.shape import TorchShape
from wpcal.seam.judge.alike import find_alike
from wpcal.seam.judge.stations import start_mm
from wpcal.seam.judge.torch_neck import bend_directions, spin_of_bend, torch_axes
from wpcal.seam.judge.torch_poses import FeltPoses, find_solids_beside_neck, find_solids_met
from wpcal.seam.options import Reach
from wpcal.seam.seam import Seam

WORK_STEP_DEG, TRAVEL_STEP_DEG = 15.0, 20.0
"""Across the seam welders tilt the torch by about 15 degrees before they call a joint unreachable; along it 20 degrees
are usual. A wider range is tried in such steps. At the end of a seam against a wall the torch leans more: with a nozzle
of 22 mm and a stick-out of 20 mm only 29 degrees reach into the corner, and 35 degrees with a nozzle of 28 mm."""
SPIN_STEP_DEG = 45.0  #: Step of the turn about the wire that is tried with a bent neck.
SPIN_SHARE = 0.1
"""A turn about the wire costs this share of a lean: robots turn the torch readily, and welders look past it."""
STEP_MM = 1.0  #: Step of dense stations: where a free stretch begins or ends is known to this.
HALF = 0.5 - 1e-9  #: Of the way between two stations; less round-off.
MEETS = 1e3  #: Cost of a change that meets a solid, rad: more than all leans of a seam together.
CHANGE_MM = 40.0  #: Where a change of lean meets a solid, other changes are looked for this far before and after.
WINDOWS = 4  #: This many places are tried at which a lean may change evenly, the nearest to its change first.
ROUND_OFF_MM = 1e-6  #: A change may need this much more than it has.
ROUNDS = 6  #: So often other changes are chosen for those that meet a solid.


class FeltAt(Enum):
    """What the stations are at which seams are felt."""

    FRAMES = "frames"
    """Frames of the seams: the torch comes and goes at both ends, and is felt between them at the places at which a
    program is compared with the part (`wpcal.robot.moves.sweep`): what is free here is free there."""
    DENSE = "dense"
    """So near to each other that each may become the end of a seam: the torch is felt on its approach everywhere, and
    between stations only where its lean changes."""
    SOME = "some"  #: A few of the frames: the torch is felt there and nowhere else.


@dataclass(frozen=True, slots=True, eq=False)
class Leans:
    """The poses of a torch that are tried at a station: every lean with every spin, by rows."""

    rad: FloatArray  #: shape (k, 2). Work and travel angles, the smallest first.
    #: This many leans are straight or tilted one way, by 20 degrees at most. Others are for the ends of a seam: what
    #: is reached only with them from end to end is behind something.
    small: int
    spin_rad: FloatArray  #: shape (j,). Turns about the wire, the smallest first; only 0 for a torch without a neck.
    rate_rad_mm: float  #: The most by which lean and turn change together.

    @classmethod
    def of(cls, reach: Reach) -> Leans:
        """Return the leans within the ranges of `reach`."""
        work = _angles(reach.work_deg, WORK_STEP_DEG)
        travel = _angles(reach.travel_deg, TRAVEL_STEP_DEG)
        leans = sorted(
            ((a, b) for a in work for b in travel),
            key=lambda lean: (not _is_small(lean), abs(lean[0]) + abs(lean[1]), -lean[1], -lean[0]),
        )
        spin = _angles(reach.spin_deg, SPIN_STEP_DEG) if reach.torch.bends else [0.0]
        spin = sorted({180.0 if value == -180.0 else value for value in spin}, key=lambda value: (abs(value), -value))
        return cls(np.radians(leans), sum(map(_is_small, leans)), np.radians(spin), math.radians(reach.lean_deg_per_mm))

    @property
    def tiers(self) -> tuple[slice, slice]:
        """Larger leans are tried only where no smaller one is free, and not on a seam on which none of these is."""
        return slice(1, self.small), slice(self.small, len(self.rad))


def _angles(range_deg: tuple[float, float], step_deg: float) -> list[float]:
    """Return 0, the steps either way within a range, and its ends, in degrees."""
    low, high = range_deg
    steps = np.arange(-180.0 // step_deg, 180.0 // step_deg + 1) * step_deg
    return sorted({*(float(value) for value in steps if low <= value <= high), float(low), float(high)})


def _is_small(lean: tuple[float, float]) -> bool:
    return min(map(abs, lean)) == 0.0 and max(map(abs, lean)) <= TRAVEL_STEP_DEG


@dataclass(frozen=True, slots=True, eq=False)
class Felt:
    """What a torch meets along one seam of n stations."""

    #: shape (n, 2). Work and travel angle with which the torch meets nothing; NaN at a station where it always does.
    lean_rad: FloatArray
    spin_rad: FloatArray  #: shape (n,). How far a bent neck is turned about the wire there; 0 without a neck.
    solid: IntArray  #: shape (n,). The solid that a torch meets at a station without a lean; -1 at the others.
    solid_after: IntArray  #: shape (n - 1,). The solid that it meets on its way to the next station; -1 if none.
    fast: tuple[str, ...] = ()  #: Where it turns faster than asked, because no slower turn is free; for people.

    def lay_on(self, seam: Seam) -> Seam:
        """Return the seam with these leans, with the spin if any is not 0, and with the words about fast turns."""
        spin = self.spin_rad if np.nan_to_num(self.spin_rad).any() else None
        return replace(seam, lean_rad=self.lean_rad, spin_rad=spin, reasons=(*seam.reasons, *self.fast))

    def beside(self, solids: Mapping[int, int]) -> Felt:
        """Return the same at a seam that is alike: the solids there, by those here."""
        at, after = (
            np.array([solids.get(one, one) for one in own.tolist()]) if (own >= 0).any() else own
            for own in (self.solid, self.solid_after)
        )
        return Felt(self.lean_rad, self.spin_rad, at, after, self.fast)

    @property
    def is_free(self) -> bool:
        """Whether the torch gets along the whole seam."""
        return not self.solids

    @property
    def is_held(self) -> bool:
        """Whether the torch meets a solid at every station."""
        return bool((self.solid >= 0).all())

    @property
    def turns_into_a_solid(self) -> bool:
        """Whether the torch meets a solid while it changes its lean."""
        turns = (np.diff(self.lean_rad, axis=0) != 0).any(axis=1) | (np.diff(self.spin_rad) != 0)
        return bool((turns & (self.solid_after >= 0)).any())

    @property
    def solids(self) -> frozenset[int]:
        """All solids that a torch meets whatever its lean."""
        found = np.concatenate([self.solid, self.solid_after])
        return frozenset(found[found >= 0].tolist())


def back_directions(R: FloatArray, lean_rad: FloatArray) -> FloatArray:
    """Return the directions from the tip along the wire to a torch that leans, shape (n, 3). In the frame of `R`.

    `R`: shape (n, 3, 3). Seam frames.
    `lean_rad`: shape (n, 2) or (2,). Work and travel angle.
    """
    work, travel = np.moveaxis(np.asarray(lean_rad), -1, 0)
    back = np.stack([-np.sin(travel), -np.cos(travel) * np.sin(work), np.cos(travel) * np.cos(work)], axis=-1)
    return np.asarray(np.einsum("nij,nj->ni", R, np.broadcast_to(back, (len(R), 3))), dtype=np.float64)


def feel_seams(
    graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], reach: Reach, stations: FeltAt = FeltAt.FRAMES
) -> list[Felt]:
    """Find how a torch leans at every station of seams, and where it meets a solid whatever its lean.

    Returns: One per seam. A seam is reached nowhere if none of the small leans (`Leans.small`) is free at any station.
    """
    if not seams:
        return []
    leans = Leans.of(reach)
    own = _straight(seams, reach.torch, stations)
    alike = find_alike(graph, trimmed, own, leans.rad)
    firsts = np.unique(alike.first)
    rows = np.isin(own.owner, firsts)
    own = replace(own.select(rows), owner=np.searchsorted(firsts, own.owner[rows]))
    felt = dict(zip(firsts.tolist(), _felt_each(graph, trimmed, own, leans, stations), strict=True))
    return [
        felt[first].beside(alike.solids[row]) if first != row else felt[first]
        for row, first in enumerate(alike.first.tolist())
    ]


def _felt_each(graph: BrepGraph, trimmed: TrimmedFaces, own: FeltPoses, leans: Leans, stations: FeltAt) -> list[Felt]:
    """Feel seams whose straight poses are given, each by itself."""
    steps = _Steps(graph, trimmed, own, leans, stations)
    free, solid = steps.free, steps.feel_leans(np.arange(len(own)), slice(0, 1))
    cuts = np.flatnonzero(np.diff(own.owner)) + 1
    for tier in leans.tiers:
        is_felt = ~free.any(axis=(1, 2))
        if tier.start == 1 and own.torch.bends:  # a lean may be better than a turn of the neck
            same_spin = np.array([rows[:, 0].all(axis=0).any() for rows in np.split(free, cuts)])
            is_felt |= ~same_spin[own.owner]
        if tier.start >= leans.small and stations is not FeltAt.DENSE:
            has_small = np.array([rows.any() for rows in np.split(free, cuts)])
            is_felt &= has_small[own.owner]
        steps.feel_leans(np.flatnonzero(is_felt), tier)
    give_memory_back()  # of what was felt: as much again is felt now
    chosen = _chosen_with_free_steps(steps)
    if stations is FeltAt.FRAMES:
        steps.change_evenly(chosen)
    lean, spin, after = steps.felt(chosen)
    solid = np.where(chosen >= 0, -1, solid)
    columns = zip(*(np.split(values, cuts) for values in (lean, spin, solid, after)), strict=True)
    starts = [0, *cuts.tolist()]
    return [
        Felt(rows, turns, at, between[:-1], steps.too_fast(chosen, first) if stations is FeltAt.FRAMES else ())
        for first, (rows, turns, at, between) in zip(starts, columns, strict=True)
    ]


def _feel(
    graph: BrepGraph, trimmed: TrimmedFaces, own: FeltPoses, leans: Leans, tier: slice
) -> tuple[BoolArray, IntArray]:
    """Tell at which leans of a tier and which spins the torch meets nothing, and what it meets at the first lean.

    The first has the shape (n, k · j), j spins for each lean; the second (n,), -1 for none. Neck and body are felt only
    where wire and nozzle are free.
    """
    rad, spins = leans.rad[tier], leans.spin_rad
    n, k, j = len(own), len(rad), len(spins)
    poses = replace(_repeated(own, k), back=np.concatenate([back_directions(own.R, lean) for lean in rad]))
    solid = find_solids_met(graph, trimmed, poses, is_told=tier.start == 0)
    free = np.repeat((solid < 0)[:, None], j, axis=1)
    if own.torch.neck is not None:
        rows = np.flatnonzero(solid < 0)
        left = _repeated(poses.select(rows), j)
        left = replace(left, spin_rad=np.repeat(spins, len(rows)))
        met = find_solids_beside_neck(graph, trimmed, left).reshape(j, len(rows))
        free[rows] = (met < 0).T
        solid[rows] = np.where((met < 0).any(axis=0), -1, met.max(axis=0))
    return free.reshape(k, n, j).transpose(1, 0, 2).reshape(n, k * j), solid[:n]


def _repeated(own: FeltPoses, count: int) -> FeltPoses:
    """Return all poses this many times, one after the other; each time they belong to other owners, ascending."""
    n = len(own)
    owner = np.add.outer(np.arange(count) * (own.owner[-1] + 1), own.owner).ravel() if n else own.owner
    return replace(own.select(np.tile(np.arange(n), count)), owner=owner)


def _straight(seams: Sequence[Seam], torch: TorchShape, stations: FeltAt) -> FeltPoses:
    """Return the straight torch at all stations of seams."""
    counts = [len(seam.frames) for seam in seams]
    more = np.zeros(sum(counts))
    last = np.cumsum(counts) - 1
    if stations is FeltAt.DENSE:
        more[:] = APPROACH_MM
    elif stations is FeltAt.FRAMES:
        more[np.concatenate([last, last - np.array(counts) + 1])] = APPROACH_MM
    p = np.concatenate([seam.frames.p for seam in seams])
    R = np.concatenate([seam.frames.R for seam in seams])
    start = np.repeat([start_mm(seam) for seam in seams], counts)
    wire = np.repeat([torch.wire_mm + seam.more_wire_mm for seam in seams], counts)
    owner = np.repeat(np.arange(len(seams)), counts)
    return FeltPoses(torch, owner, p, R[:, :, 2], R, start, more, wire, np.zeros(len(p)))


def _chosen_with_free_steps(steps: _Steps) -> IntArray:
    """Choose a pose per station, and other ones where the torch meets a solid on its way from one to the next.

    More leans are felt for that. Where no change of lean is free, the first choice stays.
    """
    free, is_open = steps.free.reshape(len(steps.own), -1), np.zeros(len(steps.own), dtype=bool)
    first = chosen = _chosen(steps, free, is_open)
    rows = steps.blocked_changes(chosen)
    for _ in range(ROUNDS):
        if not len(rows):
            return chosen
        near = steps.near(rows)
        opened = np.flatnonzero(near.any(axis=0) & ~is_open)
        for tier in steps.leans.tiers:
            steps.feel_leans(opened, tier)
        is_open[opened] = True
        changes = {(row, *pair) for row, pair in steps.alike(near, chosen[rows], chosen[rows + 1], free)}
        if len(opened) == 0 and changes <= steps.known.keys():
            break
        steps.feel(changes)
        chosen = _chosen(steps, free, is_open)
        rows = steps.blocked_changes(chosen)
    for run in steps.runs(free, is_open):
        if np.isin(rows, run).any():
            chosen[run] = first[run]
    return chosen


def _chosen(steps: _Steps, free: BoolArray, is_open: BoolArray) -> IntArray:
    """Choose a pose per station, -1 where none is free: small leans, and small changes from station to station.

    `free` has the shape (n, k · j): j spins for each of k leans. Without a neck a station at which the torch is free
    without a lean stays straight unless it is open; with one, its spin is chosen along the whole run.
    """
    chosen = np.where(free.any(axis=1), 0, -1)
    rad, spin = steps.lean, steps.spin
    size = np.abs(rad).sum(axis=1) + SPIN_SHARE * np.abs(spin)
    change = np.abs(rad[:, None] - rad).sum(axis=2) + np.abs(wrap_angle(spin[:, None] - spin))
    for run in steps.runs(free, is_open):

        def step(i: int, now: IntArray, before: IntArray, run: IntArray = run) -> FloatArray:
            barred, total = steps.barred.get(int(run[i - 1]), ()), change
            if barred:
                total = change.copy()
                for begin, end in barred:
                    total[end, begin] += MEETS
            return np.asarray(total[np.ix_(now, before)], dtype=np.float64)

        chosen[run] = cheapest_way(list(np.where(free[run], size, np.inf)), step)
    return chosen


class _Steps:
    """What a torch meets between stations while it goes from one pose of `Leans` to another."""

    def __init__(self, graph: BrepGraph, trimmed: TrimmedFaces, own: FeltPoses, leans: Leans, stations: FeltAt) -> None:
        self.graph, self.trimmed, self.own, self.leans, self.stations = graph, trimmed, own, leans, stations
        self.lean = np.repeat(leans.rad, len(leans.spin_rad), axis=0)
        self.spin = np.tile(leans.spin_rad, len(leans.rad))
        self.step_mm = np.linalg.norm(np.diff(own.p, axis=0), axis=1)
        self.joined = own.owner[1:] == own.owner[:-1]
        #: shape (n, leans, spins). With which poses the torch meets nothing, as far as `is_felt`, shape (n, leans).
        self.free = np.zeros((len(own), len(leans.rad), len(leans.spin_rad)), dtype=bool)
        self.is_felt = np.zeros((len(own), len(leans.rad)), dtype=bool)
        #: The solid met between a station and the next one, -1 for none, by its row and the poses at both.
        self.known: dict[tuple[int, int, int], int] = {}
        self.untold: set[tuple[int, int, int]] = set()  #: Those of which it is known only that something is met.
        self.barred: dict[int, list[tuple[int, int]]] = {}  #: Changes of pose that meet a solid, by row.

    def feel_leans(self, rows: IntArray, tier: slice) -> IntArray:
        """Feel a tier of leans at the stations where it is not known yet; return the solids met at its first lean."""
        rows = rows[~self.is_felt[rows, tier].any(axis=1)]
        if not len(rows) or tier.stop <= tier.start:
            return np.zeros(0, dtype=np.int64)
        found, solid = _feel(self.graph, self.trimmed, self.own.select(rows), self.leans, tier)
        self.free[rows, tier] = found.reshape(len(rows), -1, len(self.leans.spin_rad))
        self.is_felt[rows, tier] = True
        return solid

    def felt(self, chosen: IntArray) -> tuple[FloatArray, FloatArray, IntArray]:
        """Return lean and spin at each station, NaN where none is chosen, and the solid met before the next, or -1.

        Between dense stations it is felt only where the lean changes.
        """
        held, some = chosen >= 0, np.maximum(chosen, 0)
        lean, spin = np.where(held[:, None], self.lean[some], np.nan), np.where(held, self.spin[some], np.nan)
        after = np.full(len(chosen), -1)
        if self.stations is FeltAt.SOME or len(chosen) < 2:
            return lean, spin, after
        is_asked = self.joined & held[1:] & held[:-1]
        if self.stations is FeltAt.DENSE:
            is_asked &= chosen[1:] != chosen[:-1]
        rows = np.flatnonzero(is_asked)
        asked = list(zip(rows.tolist(), chosen[rows].tolist(), chosen[rows + 1].tolist(), strict=True))
        self.feel(set(asked), is_told=True)
        after[rows] = [self.known[each] for each in asked]
        return lean, spin, after

    def change_evenly(self, chosen: IntArray) -> None:
        """Spread changes of pose that are too fast over as much of a seam as they need, where the torch is free there.

        `chosen` is changed: between the first and the last station of a change the poses are new ones. All seams are
        felt together, each with the way that it asks for.
        """
        changes = np.flatnonzero(self.joined & (chosen[1:] >= 0) & (chosen[:-1] >= 0) & (chosen[1:] != chosen[:-1]))
        fast = changes[self._needs_mm(chosen[changes], chosen[changes + 1]) > self.step_mm[changes]]
        seams = np.split(fast, np.flatnonzero(np.diff(self.own.owner[fast])) + 1)
        asked = [(one, ways) for one in (self._evened(rows.tolist(), chosen) for rows in seams) if (ways := next(one))]
        while asked:  # a seam that is told which of its ways are free answers with those of its next change
            free = iter(self._are_free_ways([way for _, ways in asked for way in ways]))
            asked = [(one, own) for one, ways in asked if (own := one.send([next(free) for _ in ways]))]

    def _evened(self, rows: Sequence[int], chosen: IntArray) -> Generator[list[tuple[IntArray, IntArray]], list[bool]]:
        """Ask for the ways of each change of one seam, by stations and their poses; the first free one is chosen."""
        for row in rows:
            ways = [
                (np.arange(first, last + 1), self._poses_between(int(chosen[first]), int(chosen[last]), share[1:-1]))
                for first, last, share in self._windows(row, chosen)
            ]
            free = (yield ways) if ways else []
            for stations, poses in [way for way, is_free in zip(ways, free, strict=True) if is_free][:1]:
                chosen[stations] = poses
        yield []

    def too_fast(self, chosen: IntArray, start: int) -> tuple[str, ...]:
        """Say where a torch turns faster than asked on the seam whose first station is `start`: the fastest turn."""
        own = np.flatnonzero(self.joined & (self.own.owner[:-1] == self.own.owner[start]))
        own = own[(chosen[own] >= 0) & (chosen[own + 1] >= 0)]
        needs = self._needs_mm(chosen[own], chosen[own + 1])
        over = needs - self.step_mm[own]
        if not (over > 0.0).any():
            return ()
        row, rate = int(own[np.argmax(over)]), math.degrees(self.leans.rate_rad_mm)
        turn, at_mm = rate * needs[np.argmax(over)], self.step_mm[start:row].sum()
        where = f"within {self.step_mm[row]:.1f} mm, {at_mm:.0f} mm from its start"
        return (f"the torch turns by {turn:.0f} deg {where}: it is not free there at {rate:g} deg per mm",)

    def _windows(self, row: int, chosen: IntArray) -> list[tuple[int, int, FloatArray]]:
        """Return between which stations the change after `row` may be spread, and the shares of the way at these."""
        s, own = np.append(0.0, np.cumsum(self.step_mm)), self.own.owner
        is_held = (own == own[row]) & (chosen >= 0) & (np.abs(s - s[row]) <= CHANGE_MM)
        firsts = row - np.arange(np.argmin(np.append(is_held[row::-1], False)))
        lasts = row + 1 + np.arange(np.argmin(np.append(is_held[row + 1 :], False)))
        found = []
        for first in firsts.tolist():
            long = lasts[s[lasts] - s[first] >= self._needs_mm(chosen[first], chosen[lasts])]
            if len(long):
                found.append((first, int(long[0]), (s[first : long[0] + 1] - s[first]) / (s[long[0]] - s[first])))
        middle = s[[row, row + 1]].mean()
        return sorted(found, key=lambda way: abs(s[[way[0], way[1]]].mean() - middle))[:WINDOWS]

    def _needs_mm(self, one: IntArray, other: IntArray) -> FloatArray:
        """Return how much of a seam changes of pose need, shape (n,), mm."""
        lean = np.linalg.norm(self.lean[other] - self.lean[one], axis=-1)
        turn = lean + np.abs(wrap_angle(self.spin[other] - self.spin[one]))
        return np.asarray(turn / self.leans.rate_rad_mm - ROUND_OFF_MM)

    def _poses_between(self, one: int, other: int, share: FloatArray) -> IntArray:
        """Return the numbers of new poses at shares of the change from a pose to another, with both."""
        first = len(self.spin)
        lean = self.lean[one] + share[:, None] * (self.lean[other] - self.lean[one])
        spin = self.spin[one] + share * wrap_angle(self.spin[other] - self.spin[one])
        self.lean, self.spin = np.concatenate([self.lean, lean]), np.concatenate([self.spin, wrap_angle(spin)])
        return np.array([one, *range(first, len(self.spin)), other])

    def _are_free_ways(self, ways: Sequence[tuple[IntArray, IntArray]]) -> list[bool]:
        """Tell with which poses at their stations, and between them, the torch meets nothing."""

        def every(column: int, begin: int, end: int) -> IntArray:
            return np.concatenate([way[column][begin : len(way[column]) - end] for way in ways])

        counts, is_free = np.array([len(rows) for rows, _ in ways]), np.ones(len(ways), dtype=bool)
        of_way, poses = np.repeat(np.arange(len(ways)), counts - 2), every(1, 1, 1)
        own = self.own.select(every(0, 1, 1))
        leant = replace(own, back=back_directions(own.R, self.lean[poses]), spin_rad=self.spin[poses])
        for find in (find_solids_met, find_solids_beside_neck):
            left = np.flatnonzero(is_free[of_way])
            is_free[of_way[left[find(self.graph, self.trimmed, leant.select(left)) >= 0]]] = False
        of_way = np.repeat(np.arange(len(ways)), counts - 1)
        left = np.flatnonzero(is_free[of_way])
        steps = list(map(tuple, np.stack([every(0, 0, 1), every(1, 0, 1), every(1, 1, 0)], axis=1)[left].tolist()))
        self.feel(set(steps))
        is_free[of_way[left[[self.known[step] >= 0 for step in steps]]]] = False
        return is_free.tolist()

    def alike(
        self, near: BoolArray, begin: IntArray, end: IntArray, free: BoolArray
    ) -> Iterator[tuple[int, tuple[int, int]]]:
        """Yield where changes from a pose to another, shape (r,), can be at the stations `near` (r, n) them."""
        for first, last, rows in zip(begin.tolist(), end.tolist(), near, strict=True):
            is_there = rows[:-1] & rows[1:] & self.joined & free[:-1, first] & free[1:, last]
            yield from ((row, (first, last)) for row in np.flatnonzero(is_there).tolist())

    def feel(self, asked: Set[tuple[int, int, int]], *, is_told: bool = False) -> None:
        """Feel steps: the row of a station, and the poses there and at the next one.

        Most that meet something meet it midway, so that is felt first; `is_told` asks for the solid, too.
        """
        is_known = self.known.keys() - self.untold if is_told else self.known.keys()
        new = np.array(sorted(asked - is_known)).reshape(-1, 3)
        if not len(new):
            return
        solid = np.full(len(new), -1) if is_told else self._met(*new.T, is_midway=True)
        is_free = solid < 0
        solid[is_free] = self._met(*new[is_free].T)
        half = set(map(tuple, new[~is_free].tolist()))
        self.untold = (self.untold | half) - (asked if is_told else set())
        for (row, first, last), met in zip(new.tolist(), solid.tolist(), strict=True):
            if met >= 0 and first != last and (row, first, last) not in self.known:
                self.barred.setdefault(row, []).append((first, last))
            self.known[row, first, last] = met

    def runs(self, free: BoolArray, is_open: BoolArray) -> list[IntArray]:
        """Return the rows of stations one after the other whose poses are chosen together."""
        is_held, owner = free.any(axis=1), self.own.owner
        if len(self.leans.spin_rad) == 1:
            is_held &= ~free[:, 0] | is_open
        held = np.flatnonzero(is_held)
        runs = np.split(held, np.flatnonzero((np.diff(held) > 1) | (np.diff(owner[held]) > 0)) + 1)
        return [run for run in runs if len(run)]

    def blocked_changes(self, chosen: IntArray) -> IntArray:
        """Return the stations after which the torch meets a solid while its lean changes."""
        _, _, after = self.felt(chosen)
        return np.flatnonzero((after[:-1] >= 0) & (chosen[1:] != chosen[:-1]))

    def near(self, rows: IntArray) -> BoolArray:
        """Tell which stations are within `CHANGE_MM` of the step after each of `rows`, shape (r, n)."""
        s, owner = np.append(0.0, np.cumsum(self.step_mm)), self.own.owner
        is_own = owner == owner[rows, None]
        return np.asarray(is_own & (s >= s[rows, None] - CHANGE_MM) & (s <= s[rows + 1, None] + CHANGE_MM))

    def _met(self, rows: IntArray, begin: IntArray, end: IntArray, *, is_midway: bool = False) -> IntArray:
        """Return the solid that is met between stations `rows` and the next ones, -1 for none; all of shape (k,).

        `begin`, `end`: numbers of the poses there. `is_midway`: felt at the pose in the middle only.
        """
        found, wires = np.full(len(rows), -1), self.own.wire_mm[rows]
        for wire_mm in np.unique(wires):
            moves = np.flatnonzero(wires == wire_mm)
            between, which = self._between(rows[moves], begin[moves], end[moves], wire_mm, is_midway=is_midway)
            solid = find_solids_met(self.graph, self.trimmed, between, is_between=True)
            solid = np.where(solid < 0, find_solids_beside_neck(self.graph, self.trimmed, between), solid)
            bad = np.flatnonzero(solid >= 0)
            found[moves[which[bad]]] = solid[bad]
        return found

    def _between(
        self, rows: IntArray, begin: IntArray, end: IntArray, wire_mm: float, *, is_midway: bool
    ) -> tuple[FeltPoses, IntArray]:
        """Return the torch at the places of `sweep` between stations, and the number of the move of each."""
        own, torch = self.own, self.own.torch
        back, other = (back_directions(own.R[at], self.lean[pose]) for at, pose in ((rows, begin), (rows + 1, end)))
        tool = torch_axes(back, bend_directions(back, own.R[rows], self.spin[begin]))
        turn = swings_between(back, other)
        if torch.bends:  # a controller turns the whole torch about one axis
            turn = turns_between(tool, torch_axes(other, bend_directions(other, own.R[rows + 1], self.spin[end])))
        reaching = torch.with_more_wire(wire_mm - torch.wire_mm).reaching
        swept = sweep_moves(own.p[rows], own.p[rows + 1] - own.p[rows], tool, turn, reaching, axis=2)
        inner = np.flatnonzero(swept.at % 1.0 > 0.0)
        if is_midway:
            inner = inner[swept.at[inner] % 1.0 >= HALF]
            inner = inner[np.unique(swept.at[inner].astype(int), return_index=True)[1]]
        which, R = swept.at[inner].astype(int), swept.R[inner]
        between = own.select(rows[which])
        return replace(
            between,
            owner=which,
            p=swept.p[inner],
            back=R[:, :, 2],
            more_mm=np.zeros(len(which)),
            spin_rad=spin_of_bend(R[:, :, 2], between.R, R[:, :, 0]),
        ), which


def at_stations(seam: Seam, rows: IntArray, most: int) -> Seam:
    """Return a seam with few of its frames: at most this many of `rows` (integers, shape (k,)), evenly."""
    few = rows[np.unique(np.linspace(0, len(rows) - 1, min(most, len(rows)) + 2).round().astype(int)[1:-1])]
    return replace(seam, frames=seam.frames.select(few))


def with_leans(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], reach: Reach) -> tuple[Seam, ...]:
    """Return seams of which all that are accepted have the torch's leans."""
    rows = [row for row, seam in enumerate(seams) if seam.accepted and seam.lean_rad is None]
    found = dict(zip(rows, feel_seams(graph, trimmed, [seams[row] for row in rows], reach), strict=True))
    return tuple(found[row].lay_on(seam) if row in found else seam for row, seam in enumerate(seams))
