"""Plan a sequence: ways for every seam, cuts where a seam has none, the order, and the moves through the air.

Also here: what must be right before planning starts: the part above the floor, and home free of collision.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.progress import Progress, no_progress
from wpcal.core.same_bits import product
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_clearance import FLOOR, PART, CellClearance
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.cell.workplace import AIR_STEP_MM
from wpcal.planning.sequence.air_path import AirPath, AirPlanner
from wpcal.planning.sequence.cuts import Unwelded, cut_seam
from wpcal.planning.sequence.order import Order, Stop, find_order
from wpcal.planning.sequence.remedies import RemedySearch
from wpcal.planning.sequence.seam_search import SeamSearch
from wpcal.planning.sequence.seam_task import Candidate, SeamTask, seam_task
from wpcal.planning.sequence.sequence_input import PlannedSeam
from wpcal.planning.sequence.smooth import respun, tilted
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.planning.sequence.weld_sequence import (
    AIR_SHARE,
    SequenceValues,
    Way,
    WeldPiece,
    WeldSequence,
    air_seconds,
    sequence_values,
)

ON_FLOOR_MM = 1.0
"""A part that lies on the floor may be this far in it: corners of triangles, and touched points, are not exact."""
STEP_RAD = math.radians(15.0)  #: Of the axes in which another home is looked for.


def require_sound_start(cell: Cell, clearance: CellClearance) -> None:
    """Refuse a cell that no plan can start from.

    Raises `InputError` when the part is through the floor, or home is in collision: with a change that was tried.
    """
    _require_above_floor(cell, clearance)
    found = clearance.margins(cell.home[None])
    if found.is_clear[0]:
        return
    one, two = clearance.names(int(found.pair[0]))
    what = f"home is in collision: {one} and {two} miss their safety distance by {-found.margin_mm[0]:.0f} mm"
    raise InputError(f"{what}; {_other_home(cell, clearance, (one, two))}")


def _require_above_floor(cell: Cell, clearance: CellClearance) -> None:
    if clearance.part is None or cell.carrier is not None:
        return
    corners = clearance.part.corners.reshape(-1, 3)
    T = cell.part_places(cell.home[None])[0]
    lowest = float((product(corners, T[2, :3]) + T[2, 3]).min())
    if lowest < cell.floor_z_mm - ON_FLOOR_MM:
        raise InputError(
            f"the part is through the floor, by {cell.floor_z_mm - lowest:.0f} mm: its lowest place is at z = "
            f"{lowest:.0f} mm of world, the floor at {cell.floor_z_mm:g} mm; correct T_world_part of the cell, or "
            "T_world_base of torch_robot if the robot found the part"
        )


def _other_home(cell: Cell, clearance: CellClearance, pair: tuple[str, str]) -> str:
    """Return what to do: the nearest home that is free, with other axes of the positioner or another axis 1."""
    columns = list(range(cell.first_turning, len(cell.axis_names)))
    if not columns or set(pair) != {PART, FLOOR}:
        columns = [0, *columns]
    low, high = cell.limits
    grids = [np.arange(-180.0, 180.0, 15.0) * math.pi / 180.0 + cell.home[column] for column in columns]
    turned = np.stack(np.meshgrid(*grids, indexing="ij"), axis=-1).reshape(-1, len(columns))
    order = np.argsort(np.abs(turned - cell.home[columns]).max(axis=1), kind="stable")
    q = np.repeat(cell.home[None], len(order), axis=0)
    q[:, columns] = turned[order]
    q = q[((q >= low) & (q <= high)).all(axis=1)]
    clear = clearance.margins(q).is_clear if len(q) else np.zeros(0, dtype=bool)
    if clear.any():
        shown = np.round(np.degrees(q[int(np.argmax(clear))]), 1) + 0.0
        parts = shown[:JOINTS], shown[cell.first_turning :]
        arm, axes = (", ".join(f"{value:g}" for value in part) for part in parts)
        with_positioner = f", and home_deg [{axes}] in positioner" if cell.carrier is not None else ""
        return f"tried, and home is free with home_deg [{arm}] in torch_robot{with_positioner}"
    if set(pair) == {PART, FLOOR}:
        return "at every angle of the positioner: raise the positioner, or correct T_flange_part"
    return "write another home_deg in torch_robot of the cell"


REORDERS = 8  #: How often another order is tried when no free way leads from one seam to the next.
OUT_OF_POSITION_S = 1000.0  #: What a weld out of position costs in seconds: it is taken only where there is no other.


class SequencePreference(Enum):
    """What the choice among the ways of each seam prefers: seconds per degree of each value."""

    POSITION = "position"
    SMOOTH = "smooth"
    BALANCED = "balanced"

    @property
    def seconds_per_degree(self) -> tuple[float, float, float]:
        """Seconds per degree off the weld position, per degree of the torch, and per degree/mm of joint motion."""
        return {"position": (10.0, 1.0, 0.0), "smooth": (0.1, 0.2, 20.0), "balanced": (0.2, 0.2, 2.0)}[self.value]


@dataclass(frozen=True, slots=True, eq=False)
class SequenceChoice:
    """The chosen sequence, and the values of the plans that it was chosen from, by preference."""

    sequence: WeldSequence
    values: dict[SequencePreference, SequenceValues]
    chosen: SequencePreference


@dataclass(frozen=True, slots=True, eq=False)
class _Ways:
    """The ways to weld one stretch."""

    name: str
    candidates: tuple[Candidate, ...]
    search: SeamSearch  #: That found them: with the usual distances, or smaller ones at the seam or in the air.


def plan_sequence(
    cell: Cell,
    part: TriangleMaterial | None,
    seams: Sequence[PlannedSeam],
    targets: SequenceTargets,
    *,
    prefer: SequencePreference = SequencePreference.BALANCED,
    progress: Progress = no_progress,
) -> SequenceChoice:
    """Plan how one robot welds seams.

    Raises `GeometryError` when no seam can be welded, or no free way leads from one to another.
    Raises `InputError` when the part is through the floor, home is in collision, or an optional package is missing.
    """
    given, cell = cell, cell.with_joint_margin(targets.joint_margin_rad)
    more_wire_mm = max((seam.seam.more_wire_mm for seam in seams), default=0.0)
    search = SeamSearch(cell, CellClearance(cell, part), targets, more_wire_mm=more_wire_mm)
    require_sound_start(cell, search.air.clearance)
    remedies = RemedySearch(search.closer)
    stretches: list[_Ways] = []
    unwelded: list[Unwelded] = []
    for number, seam in enumerate(seams, start=1):
        progress(f"seam {seam.name}, {number} of {len(seams)}")
        ways, gaps = ways_of_seam(search, seam, remedies)
        stretches += ways
        unwelded += gaps
    if not stretches:
        more = f"; and {len(unwelded) - 1} more" if len(unwelded) > 1 else ""
        raise GeometryError(f"no seam can be welded: {unwelded[0].describe()}{more}")
    progress("the order of the seams")
    smoothed = _smoother()
    orders = {each: _order(cell, stretches, targets, each, ()) for each in SequencePreference}
    values = {each: _values(cell, stretches, targets, order, smoothed(each)) for each, order in orders.items()}
    work = _Work(search, stretches, smoothed(prefer), progress)
    sequence = _worked_out(work, unwelded, orders[prefer], prefer)
    sequence = replace(sequence, cell=given)  # with the limits of the arm itself
    return SequenceChoice(sequence, {**values, prefer: sequence.values}, prefer)


def ways_of_seam(search: SeamSearch, seam: PlannedSeam, remedies: RemedySearch) -> tuple[list[_Ways], list[Unwelded]]:
    """Return the ways to weld a seam whole, or in pieces with what is left out between them; no moves to the seam."""
    task = seam_task(seam.seam, seam.speed_mm_s, seam.rank, seam.run)
    for own in (search, search.closer, search.farther, search.tighter):
        found = _both_directions(own, task, own.whole(task))
        if found:
            return [_Ways(task.name, tuple(found), own)], []
    own = search.tighter
    pieces, gaps = cut_seam(own, task, remedies)
    one = len(pieces) == 1
    names = [task.name if one else f"{task.name}{_letters(row)}" for row in range(len(pieces))]
    return [
        _Ways(name, tuple(_both_directions(own, None, [piece])), own) for name, piece in zip(names, pieces, strict=True)
    ], gaps


def _letters(row: int) -> str:
    """Return a, b, …, z, aa, …."""
    return chr(97 + row) if row < 26 else _letters(row // 26 - 1) + chr(97 + row % 26)  # letters


def _both_directions(search: SeamSearch, task: SeamTask | None, found: list[Candidate]) -> list[Candidate]:
    """Add the ways in the other direction: the same poses, or a search of their own if the torch is pushed or drags."""
    targets = search.targets
    if targets.travel_rad == 0.0 and targets.work_rad == 0.0:
        return [*found, *(candidate.backwards() for candidate in found)]
    if task is None:
        return found
    back = [
        Candidate(c.task, c.q, c.angles, c.branch, c.off_position_rad, c.off_torch_rad, is_reversed=True)
        for c in search.whole(task.backwards())
    ]
    return [*found, *back]


def _order(
    cell: Cell,
    stretches: Sequence[_Ways],
    targets: SequenceTargets,
    prefer: SequencePreference,
    blocked: Sequence[tuple[int, int, int, int]],
) -> Order:
    position, torch, motion = prefer.seconds_per_degree
    stops = []
    for ways in stretches:
        found = ways.candidates
        off = np.degrees([candidate.off_position_rad for candidate in found])
        cost = position * off + OUT_OF_POSITION_S * (off > math.degrees(targets.position_tol_rad))
        cost = cost + torch * np.degrees([candidate.off_torch_rad for candidate in found])
        cost = cost + motion * np.degrees([candidate.motion_rad_mm for candidate in found])
        start, end = (np.array([candidate.q[row] for candidate in found]) for row in (0, -1))
        stops.append(Stop(start, end, cost, found[0].task.middle, found[0].task.rank))
    return find_order(stops, cell.home, AIR_SHARE * cell.speeds, targets.order, blocked)


Smooth = Callable[[_Ways, int], Candidate]
"""Returns one of the ways of a stretch, with joints that move less."""


def _smoother() -> Callable[[SequencePreference], Smooth]:
    """Return what smooths ways, each once; with the preference for the position the torch stays at its targets."""
    spun = cache(respun)

    @cache
    def smoothed(search: SeamSearch, way: Candidate, may_tilt: bool) -> Candidate:
        base = spun(search, way)
        found = tilted(search, way, base) if may_tilt else base
        return found if search.leaves_ends([found]).all() else way

    def of(prefer: SequencePreference) -> Smooth:
        may_tilt = prefer is not SequencePreference.POSITION
        return lambda ways, number: smoothed(ways.search, ways.candidates[number], may_tilt)

    return of


def _values(
    cell: Cell, stretches: Sequence[_Ways], targets: SequenceTargets, order: Order, smooth: Smooth
) -> SequenceValues:
    """Return the values of a plan that is not worked out: straight moves between the welds."""
    chosen = [smooth(stretches[stop], way) for stop, way in zip(order.stops, order.ways, strict=True)]
    ends = [cell.home, *(row for c in chosen for row in (c.q[0], c.q[-1])), cell.home]
    air = sum(float(air_seconds(cell, np.stack(ends[i : i + 2]))[0]) for i in range(0, len(ends), 2))
    air += sum(2.0 * targets.approach_mm / targets.air_speed_mm_s for _ in chosen)
    return sequence_values(cell, targets, chosen, air)


class _Work:
    """Works out orders: pieces and moves are found once, and what is not free is not taken again."""

    def __init__(self, search: SeamSearch, stretches: list[_Ways], smooth: Smooth, progress: Progress) -> None:
        self.search, self.cell, self.stretches = search, search.cell, stretches
        self.smooth, self.progress = smooth, progress
        seed, own = search.targets.seed, search.tighter
        closer = AirPlanner(self.cell, own.air, seed) if any(ways.search is own for ways in stretches) else None
        self.planner = AirPlanner(self.cell, search.air, seed, closer)
        self.pieces: dict[tuple[int, int], WeldPiece] = {}
        self.air: dict[Move, AirPath] = {}
        self.blocked: list[Move] = []

    def blocks(self, order: Order) -> tuple[Move, str] | None:
        """Find the pieces and moves of an order; return the first one that is not free, and why."""
        stops = list(zip(order.stops, order.ways, strict=True))
        for stop, way in stops:
            if (stop, way) not in self.pieces:
                found = self._piece(self.stretches[stop], way)
                if isinstance(found, str):
                    return (stop, way, stop, way), f"no way along it is free: {found}"
                self.pieces[stop, way] = found
        home = self.cell.home
        ends = [home, *(row for at in stops for row in (self.pieces[at].states[0], self.pieces[at].states[-1])), home]
        for row, key in enumerate(_moves(order)):
            self.progress(f"moves through the air, {row + 1} of {len(stops) + 1}")
            try:
                self.air[key] = self.air.get(key) or self.planner.path(ends[2 * row], ends[2 * row + 1])
            except GeometryError as error:
                return self._failed(key, ends[2 * row : 2 * row + 2], error)
        return None

    def _failed(self, key: Move, ends: Sequence[FloatArray], error: GeometryError) -> tuple[Move, str]:
        """Return a move that is not free, or the way of a stop that is shut in, and why."""
        shut = [at for at, q in zip((key[:2], key[2:]), ends, strict=True) if self.planner.shuts(q)]
        one, two = ("home" if stop < 0 else self.stretches[stop].name for stop in (key[0], key[2]))
        return ((*shut[0], *shut[0]) if shut else key), f"no free way leads from {one} to {two}: {error}"

    def on(self, stretches: list[_Ways]) -> _Work:
        """Return new work on other stretches."""
        return _Work(self.search, stretches, self.smooth, self.progress)

    def _piece(self, ways: _Ways, number: int) -> WeldPiece | str:
        """Return a way with approach and retract: smoothed, or as it was found; or why it cannot be welded."""
        search, why = ways.search, ""
        for candidate in dict.fromkeys((self.smooth(ways, number), ways.candidates[number])):
            before, after = (search.withdrawn(q) for q in candidate.q[[0, -1]])
            if (why := before.why or after.why or "") == "":
                speed, slowed_by = candidate.weld_speed(search.cell, search.targets.speed_mm_s)
                states = np.concatenate([before.states[::-1], candidate.q, after.states])
                check = search.checker.check(states, again=True)
                if check.is_free:
                    return WeldPiece(ways.name, candidate, before.states[::-1], after.states, check, speed, slowed_by)
                why = search.checker.nearest(check.states)
        return why


Move = tuple[int, int, int, int]  #: Stop and way of its start and of its end; home is stop -1.


def _moves(order: Order) -> list[Move]:
    stops = list(zip(order.stops, order.ways, strict=True))
    return [(*a, *b) for a, b in zip([(-1, 0), *stops], [*stops, (-1, 0)], strict=True)]


def _worked_out(work: _Work, unwelded: list[Unwelded], order: Order, prefer: SequencePreference) -> WeldSequence:
    """Return a sequence with all its moves.

    Where a piece or a move is not free, another order is tried, and at last the stretch is left out by name.
    """
    cell, targets, stretches = work.cell, work.search.targets, work.stretches
    while (failed := work.blocks(order)) is not None:
        key, why = failed
        work.blocked.append(key)
        order = _order(cell, stretches, targets, prefer, work.blocked)
        if len(work.blocked) > REORDERS or not math.isfinite(order.seconds):
            lost = Counter(at for move in work.blocked for at in (move[0], move[2]) if at >= 0).most_common(1)[0][0]
            task = stretches[lost].candidates[0].task
            ends = float(task.s_mm[0]), float(task.s_mm[-1])
            unwelded = [*unwelded, Unwelded(task.name, *ends, why, is_searched=False)]
            stretches = [ways for stop, ways in enumerate(stretches) if stop != lost]
            if not stretches:
                raise GeometryError(f"no seam can be welded: {unwelded[-1].describe()}")
            order = _order(cell, stretches, targets, prefer, ())
            return _worked_out(work.on(stretches), unwelded, order, prefer)
    chosen = [work.pieces[at] for at in zip(order.stops, order.ways, strict=True)]
    air = tuple(work.air[key] for key in _moves(order))
    moving = sum(float(air_seconds(cell, path.q).sum()) for path in air)
    moving += sum(AIR_STEP_MM * (len(each.before) + len(each.after)) / targets.air_speed_mm_s for each in chosen)
    values = sequence_values(cell, targets, [piece.candidate for piece in chosen], moving)
    work.progress("ways between home and each seam")
    found = work.planner.ways_from_home(np.array([piece.states[row] for row in (0, -1) for piece in chosen]))
    n = len(chosen)
    alone = tuple(Way(there, back[::-1]) for there, back in zip(found[:n], found[n:], strict=True))
    return WeldSequence(cell, targets, tuple(chosen), air, tuple(unwelded), values, alone)
