"""Ways between seams: up to a plane above the part, across, and down, as linear moves that are compared with the part.

The torch leaves a seam with its orientation unchanged: straight up, or first farther back along the wire, or first
sideways out of the part's box. From a narrow place it first goes a little aside, to where it has room all around, and
from there straight out in any direction. It turns only at the height of the plane. A move is compared with the part at
places that are chosen so that nothing can be hit between two of them: halfway through a stretch of the move no point of
the torch is farther from its place anywhere on the stretch than m. If the torch is farther from the part than m and the
margin, the whole stretch is free; otherwise it is halved.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import chain, pairwise, product

import numpy as np

from wpcal.brep.hits import START_MM
from wpcal.brep.material import TriangleMaterial
from wpcal.core.arrays import FloatArray, numbered_rows
from wpcal.core.errors import ErrorCode, GeometryError, InputError
from wpcal.core.options import opt
from wpcal.core.tangent import exp_rotation, log_rotation
from wpcal.planning.cell.segments import part_distances
from wpcal.robot.torch.attitude import ToolAxis, neck_directions, wire_directions
from wpcal.robot.torch.shape import TorchShape
from wpcal.seam.judge.material import find_poses_in_material
from wpcal.seam.judge.reach import sweep_torch
from wpcal.seam.judge.stations import start_mm
from wpcal.seam.seam import Seam

MARGIN_MM = 3.0
"""Least distance of the nozzle from the part on the way: above the errors of a calibration and of a path in the air."""
ABOVE_MM = 50.0  #: By default the lowest point of the torch is this far above the part on the way across.
FIRST_STRETCH_MM = 24.0  #: A move is first divided into stretches of at most this length: few longer ones are free.
LEAST_STRETCH_MM = 0.02  #: A stretch of a move is not halved further: it counts as too near.
BACK_MM = (0.0, 25.0, 50.0, 100.0, 200.0, 400.0)
"""How far back along the wire the torch goes before it goes up, the shortest free one."""
NEAREST_MM = 5.0  #: The torch comes and goes this far along the wire at least.
MOST_NEARER = 3  #: This many places on the wire's line that are free are tried until a way leads on from one.
SIDES = 8  #: Directions in which the torch leaves the part's box if it cannot go up.
WAYS = np.array([way for way in product(range(-3, 4), repeat=3) if max(map(abs, way)) == 3], dtype=np.float64)
WAYS /= np.linalg.norm(WAYS, axis=1, keepdims=True)
"""Directions in which the torch leaves a narrow place, 15 degrees apart: straight up needs no room beside a wall."""
ASIDE_MM = (0.0, 10.0, 20.0)  #: How far aside it goes there as near to the part as a weld is: a gap of 3 mm opens soon.
MOST_ASIDE = 2  #: This many places aside are tried at each distance, those with the most room.
MOST_OUT = 12  #: This many directions are tried from each place, of those that seem to be free.
LOOK_MM = (10.0, 20.0, 40.0, 80.0, 160.0, 320.0)  #: Where it is felt first whether a direction is free.
LARGEST_TURN_RAD = math.radians(90.0)
"""A linear move with a larger turn gets poses in between: near 180 degrees controllers turn one way or the other."""
SAFE_POINT = "the safe point"  #: Where a program starts and ends, in messages.
NO_LENGTH_MM = 1e-6  #: Shorter moves are left out: they are round-off.


@dataclass(frozen=True, slots=True)
class AirSettings:
    """How the torch goes from one seam to the next.

    Raises `InputError` when the clearance is not positive, or the direction is not three numbers that differ from zero.
    """

    clearance_mm: float | None = opt(
        None, "Height of the tool above the part between seams.  [default: the torch is 50 mm above the part]"
    )
    up_base: tuple[float, float, float] = opt(
        (0.0, 0.0, 1.0), "Direction away from the support of the part, in the base.", "--up", metavar="X,Y,Z"
    )

    def __post_init__(self) -> None:
        if self.clearance_mm is not None and not 0.0 < self.clearance_mm < math.inf:
            raise InputError(f"clearance: expected a positive number of mm, got {self.clearance_mm:g}")
        length = math.dist(self.up_base, (0.0, 0.0, 0.0))
        if not 0.0 < length < math.inf:
            raise InputError(f"up: expected a direction of three numbers, got {self.up_base}")

    @property
    def up(self) -> FloatArray:
        """The unit vector up, in `base`."""
        up = np.array(self.up_base, dtype=np.float64)
        return np.asarray(up / np.linalg.norm(up), dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class Ends:
    """The first and the last pose of the torch at a seam: its approach and its retract."""

    seam: Seam
    p: FloatArray  #: shape (2, 3). Tool centre points in `base`, mm.
    R: FloatArray  #: shape (2, 3, 3). Axes of the tool in `base`.
    weld: FloatArray  #: shape (2, 3). Where the weld begins and ends, mm: an end may be moved towards it.


@dataclass(frozen=True, slots=True, eq=False)
class AirWay:
    """Poses that are joined by linear moves: p of shape (k, 3), mm, and R of shape (k, 3, 3), in `base`."""

    p: FloatArray
    R: FloatArray
    near_mm: float = 0.0  #: How far it goes aside from a narrow place, nearer to the part than the margin.

    def __len__(self) -> int:
        return len(self.p)

    def __getitem__(self, rows: slice) -> AirWay:
        return AirWay(self.p[rows], self.R[rows], self.near_mm)

    def then(self, way: AirWay) -> AirWay:
        """Return the poses of both ways."""
        return AirWay(np.concatenate([self.p, way.p]), np.concatenate([self.R, way.R]))


@dataclass(frozen=True, slots=True, eq=False)
class AirPlan:
    """The checked ways of a program."""

    safe: AirWay  #: One pose above the part, at which the program starts and ends.
    ends: tuple[FloatArray, ...]  #: shape (2, 3). Per seam: approach and retract, nearer to the weld where it must be.
    #: `to_seam`, `from_seam`: Per seam: from the end of the way before to the approach (without it), and from the
    #: retract (without it) up.
    to_seam: tuple[AirWay, ...]
    from_seam: tuple[AirWay, ...]
    clearance_mm: float  #: Height of the tool centre point above the part on the way across.
    near_mm: dict[str, float]  #: By name of a seam how far its ways go aside, nearer to the part than the margin.


class NoWayError(GeometryError):
    """No checked way leads to some seams, or from them: `seams` says why by name."""

    code = ErrorCode.NO_FREE_WAY

    def __init__(self, seams: dict[str, str]) -> None:
        self.seams = seams
        super().__init__(
            f"{'; '.join(seams.values())}; no program is written. Turn the part (--up), use a longer --approach-mm or "
            "--retract-mm, tilt the torch, or leave the seam out with --only"
        )


@dataclass(frozen=True, eq=False)
class TorchAtTool:
    """Where the torch is when the tool is at a pose."""

    shape: TorchShape
    axis: ToolAxis
    standoff_mm: float  #: From the tool centre point to the tip of the wire.
    more_wire_mm: float = 0.0  #: How far the wire sticks out beyond that.

    @cached_property
    def pieces(self) -> tuple[FloatArray, FloatArray]:
        """Straight pieces around the torch, from the tip on: ends in the frame of the tool, and radii, mm.

        Shapes (2, k, 3) and (k,).
        """
        long = self.shape.with_more_wire(self.more_wire_mm)
        tubes, tool = (*long.nozzle_tubes, *self.shape.tubes), np.eye(3)
        back, bend = -wire_directions(tool, self.axis), neck_directions(tool, self.axis)
        ends = np.array([[tube.start for tube in tubes], [tube.end for tube in tubes]])
        mouth = (self.shape.wire_mm - self.standoff_mm) * back
        radii = np.array([tube.radius_mm for tube in tubes])
        return mouth + ends @ np.stack([bend, np.cross(back, bend), back]), radii

    def segments(self, p: FloatArray, R: FloatArray) -> FloatArray:
        """Return the ends of every piece at poses, shape (2, k, n, 3), mm.

        `p`, `R`: shapes (n, 3), and (n, 3, 3) or, for one orientation, (1, 3, 3).
        """
        return np.asarray(p + np.einsum("nij,ekj->ekni", R, self.pieces[0]), dtype=np.float64)

    @cached_property
    def reach_mm(self) -> float:
        """Largest distance of a point of the torch's axis from the tool centre point."""
        return float(np.linalg.norm(self.pieces[0], axis=2).max())

    @property
    def widest_mm(self) -> float:
        """Radius of the widest piece of the torch."""
        return float(self.pieces[1].max())

    def lowest(self, R: FloatArray, up: FloatArray) -> FloatArray:
        """Return how far the torch reaches below the tool centre point, shape (n,), mm."""
        heights = self.segments(np.zeros((1, 3)), R) @ up
        return np.asarray((self.pieces[1][:, None] - heights.min(axis=0)).max(axis=0), dtype=np.float64)


def plan_air_moves(part: TriangleMaterial, ends: Sequence[Ends], torch: TorchAtTool, air: AirSettings) -> AirPlan:
    """Find the ways from a safe point to the first seam, between the seams, and back.

    Raises `GeometryError` when no checked way leads from a seam to the next; the message names both.
    """
    up = air.up
    home_R = ends[0].R[0]
    leaving, coming = [home_R, *(end.R[1] for end in ends)], [*(end.R[0] for end in ends), home_R]
    turns = [_turn_between(a, b, torch.axis) for a, b in zip(leaving, coming, strict=True)]
    torch = replace(torch, more_wire_mm=max(end.seam.more_wire_mm for end in ends))
    clearance = _clearance(air, torch, turns)
    top = float((part.corners @ up).max())
    height = max(top, *(float((end.p @ up).max()) for end in ends)) + clearance
    search = _Search(part, torch, up, height)
    rises = search.rises(ends)
    middle, _ = search.ball
    home = middle + (height - float(middle @ up)) * up
    starts, goals = [home, *(away.p[-1] for _, away in rises)], [*(down.p[-1] for down, _ in rises), home]
    names = map(" to ".join, pairwise([SAFE_POINT, *(end.seam.name for end in ends), SAFE_POINT]))
    *across, back = [search.across(*each) for each in zip(starts, goals, turns, names, strict=True)]
    to_seam = [way.then(down[-2:0:-1]) for way, (down, _) in zip(across, rises, strict=True)]
    from_seam = [away[1:] for _, away in rises]
    from_seam[-1] = from_seam[-1].then(back[:-1])
    moved = tuple(np.stack([down.p[0], away.p[0]]) for down, away in rises)
    near = {end.seam.name: max(way.near_mm for way in ways) for end, ways in zip(ends, rises, strict=True)}
    return AirPlan(AirWay(home[None], home_R[None]), moved, tuple(to_seam), tuple(from_seam), clearance, near)


def _clearance(air: AirSettings, torch: TorchAtTool, turns: Sequence[FloatArray]) -> float:
    if air.clearance_mm is not None:
        return air.clearance_mm
    first, last = np.concatenate(turns), np.concatenate([np.concatenate([turn[1:], turn[-1:]]) for turn in turns])
    share = np.linspace(0.0, 1.0, 19)[:, None, None]
    between = first @ exp_rotation(share * log_rotation(np.swapaxes(first, -1, -2) @ last))
    return float(np.ceil(ABOVE_MM + torch.lowest(between.reshape(-1, 3, 3), air.up).max()))


def _turn_between(a: FloatArray, b: FloatArray, axis: ToolAxis) -> FloatArray:
    """Return orientations from a to b, both included, between which each turn is small.

    The wire swings the short way from one direction to the other, and the rest is a turn about the wire.
    """
    if np.linalg.norm(log_rotation(a.T @ b)) <= LARGEST_TURN_RAD:
        return np.stack([a, b])
    first, last = (wire_directions(R, axis) for R in (a, b))
    normal = np.cross(first, last)
    sine, cosine = float(np.linalg.norm(normal)), float(first @ last)
    normal = normal / sine if sine > 1e-9 else a[:, 1]  # opposite wires: about an axis across, the tool's y
    swing = normal * math.atan2(sine, cosine)
    twist = log_rotation((exp_rotation(swing) @ a).T @ b)
    angle = max(float(np.linalg.norm(swing)), float(np.linalg.norm(twist)), 0.0)
    steps = max(2, math.ceil((angle + 1e-9) / (LARGEST_TURN_RAD / 2)))
    t = np.linspace(0.0, 1.0, steps + 1)[:, None]
    turn = exp_rotation(t * swing) @ a @ exp_rotation(t * twist)
    turn[0], turn[-1] = a, b
    return np.asarray(turn, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class _Search:
    part: TriangleMaterial
    torch: TorchAtTool
    up: FloatArray
    height: float

    def rises(self, ends: Sequence[Ends]) -> list[tuple[AirWay, AirWay]]:
        """Return the ways from the approach and the retract of every seam. Raises `NoWayError` for all without one."""
        ways = dict(chain.from_iterable(self._rises(ends, mm) for mm in {end.seam.more_wire_mm for end in ends}))
        found = [(name, *ways[name]) for name in (end.seam.name for end in ends)]
        if held := {name: way for name, *both in found for way in reversed(both) if isinstance(way, str)}:
            raise NoWayError(held)
        return [(down, away) for _, down, away in found if isinstance(down, AirWay) and isinstance(away, AirWay)]

    def _rises(self, ends: Sequence[Ends], more_mm: float) -> Iterator[tuple[str, tuple[AirWay | str, AirWay | str]]]:
        """Yield the ways, or why there are none, of the seams with a wire that is this much longer."""
        own = [end for end in ends if end.seam.more_wire_mm == more_mm]
        search = replace(self, torch=replace(self.torch, more_wire_mm=more_mm))
        starts = search._starts(own)
        for end, come, go in zip(own, starts[::2], starts[1::2], strict=True):
            yield end.seam.name, (search.rise(end, 0, come), search.rise(end, 1, go))

    def rise(self, end: Ends, which: int, starts: FloatArray) -> AirWay | str:
        """Return the shortest free way from an end of a seam up to the plane; or why there is none.

        Where there is none the end is moved towards the weld; where none leads on from there, the torch goes aside.
        """
        R = end.R[which]
        if not len(starts):
            return (
                f"seam {end.seam.name}: the torch is in material wherever it stands on the line of the wire, from "
                f"{NEAREST_MM:g} mm on, {('before', 'after')[which]} it ({self.torch.shape})"
            )
        usual = ((p, way) for p in starts for way in self._candidates(p, R))
        narrow = ((p, way) for p in starts for way in self._ways_aside(p, R, end.seam.more_wire_mm))
        is_free_back = cache(lambda a, b: a == b or self._is_outside_material(np.array([a, b]), R))
        for p, (free_from, corners) in chain(usual, narrow):
            points = np.array([p, *corners])
            is_free = all(self.is_free(a, b, R, R) for a, b in pairwise(points[free_from:]))
            if is_free and is_free_back(*map(tuple, points[:2])):
                near_mm = math.dist(points[1], points[free_from])
                points = points[np.append(True, np.linalg.norm(np.diff(points, axis=0), axis=1) > NO_LENGTH_MM)]
                return AirWay(points, np.repeat(R[None], len(points), axis=0), near_mm)
        where = ("to", "from")[which]
        return (
            f"seam {end.seam.name}: no checked way leads {where} it: up, back along the wire, sideways and askew, the "
            f"torch comes nearer to the part than {MARGIN_MM:g} mm ({self.torch.shape})"
        )

    def _starts(self, ends: Sequence[Ends]) -> list[FloatArray]:
        """Return from where the torch may come, and to where it may go, along the wire; two of shape (k, 3) per seam.

        As far as was asked, half as far and so on; nothing is in its way between there and the weld.
        """
        p, weld, R = (np.concatenate([getattr(end, name) for end in ends]) for name in ("p", "weld", "R"))
        away, torch = p - weld, self.torch
        wire, far_mm = wire_directions(R, torch.axis), np.linalg.norm(away, axis=1)
        count = 1 + np.floor(np.log2(np.maximum(far_mm, NEAREST_MM) / NEAREST_MM)).astype(np.int64)
        row, number = numbered_rows(count)
        share = 0.5**number
        found = find_poses_in_material(
            self.part,
            (weld + (torch.standoff_mm + torch.more_wire_mm) * wire)[row],
            -wire[row],
            torch.shape.with_more_wire(torch.more_wire_mm),
            start_mm=np.repeat([start_mm(end.seam) for end in ends], 2)[row],
            more_mm=np.asarray(share * far_mm[row], dtype=np.float64),
            bend=neck_directions(R, torch.axis)[row],
        )
        row, share = np.delete(row, found.row), np.delete(share, found.row)
        free = np.split(share, np.searchsorted(row, np.arange(1, len(weld))))
        return [weld[k] + own[:MOST_NEARER, None] * away[k] for k, own in enumerate(free)]

    def _candidates(self, p: FloatArray, R: FloatArray) -> Iterator[tuple[int, list[FloatArray]]]:
        """Yield corners of ways up to the plane, the shortest first: the point farther back, one outside, one above."""
        yield 1, [p, self._above(p)]
        side = np.cross(self.up, [1.0, 0.0, 0.0] if abs(self.up[0]) < 0.6 else [0.0, 1.0, 0.0])
        side /= np.linalg.norm(side)
        other, found = np.cross(self.up, side), list[tuple[float, int, list[FloatArray]]]()
        places = p - np.array(BACK_MM)[:, None] * wire_directions(R, self.torch.axis)
        for row, q in enumerate(places):
            ways = [[q, self._above(q)]] if row else []
            for angle in np.arange(SIDES) * (2.0 * math.pi / SIDES):
                out = self._outside(q, math.cos(angle) * side + math.sin(angle) * other)
                ways += [[q, out, self._above(out)]] if out is not q else []
            found += [(sum(map(math.dist, [p, *way], way)), row, way) for way in ways]
        has_room = self._room(places, R, 0.0) >= 0.0
        yield from ((1, way) for _, row, way in sorted(found, key=lambda way: way[0]) if has_room[row])

    def _ways_aside(self, p: FloatArray, R: FloatArray, more_mm: float) -> Iterator[tuple[int, list[FloatArray]]]:
        """Yield corners of ways out of a narrow place: first aside, as near to the part as the weld is, then straight.

        Of each way the number of the first corner from which it keeps the margin.
        """
        for q in (p - back * wire_directions(R, self.torch.axis) for back in BACK_MM[:2]):
            for aside in ASIDE_MM:
                places = q + aside * (WAYS if aside else WAYS[:1])
                room = self._room(places, R, max(ASIDE_MM))
                rows = np.argsort(-room, kind="stable")[:MOST_ASIDE]
                for place in places[rows[room[rows] >= 0.0]]:
                    if self._is_outside_material(np.array([q, place]), R, more_mm):
                        yield from ((2, [q, place, *way]) for way in self._ways_out(place, R))

    def _ways_out(self, p: FloatArray, R: FloatArray) -> Iterator[list[FloatArray]]:
        """Yield corners of straight ways out of the part that may be free, the steepest first."""
        ways = WAYS[np.argsort(-WAYS @ self.up, kind="stable")]
        for far in LOOK_MM:
            ways = ways[self._room(p + far * ways, R, 0.0) >= 0.0]
        for way in ways[:: 1 + len(ways) // MOST_OUT]:
            out, rise = self._outside(p, way), float(way @ self.up)
            if rise > 0.0 and (self.height - float(p @ self.up)) / rise < math.dist(p, out):
                out = p + (self.height - float(p @ self.up)) / rise * way
            yield [out, self._above(out)]

    def _outside(self, p: FloatArray, way: FloatArray) -> FloatArray:
        """Return where the torch is outside the part's box on its way in a direction; the place itself if it is."""
        middle, radius = self.ball
        reach = radius + self.torch.reach_mm + self.torch.widest_mm + MARGIN_MM - float((p - middle) @ way)
        return p + reach * way if reach > 0.0 else p

    @cached_property
    def ball(self) -> tuple[FloatArray, float]:
        """Middle and radius of the ball around the part's box, mm."""
        low, high = self.part.corners.min(axis=(0, 1)), self.part.corners.max(axis=(0, 1))
        return (low + high) / 2, float(np.linalg.norm(high - low)) / 2

    def _above(self, p: FloatArray) -> FloatArray:
        return np.asarray(p + max(self.height - float(p @ self.up), 0.0) * self.up, dtype=np.float64)

    def _is_outside_material(self, points: FloatArray, R: FloatArray, more_mm: float | None = None) -> bool:
        """Tell whether nozzle and neck, and a wire that is this much longer, stay out of the material on a move."""
        shape, wire = self.torch.shape.with_more_wire(more_mm or 0.0), wire_directions(R, self.torch.axis)
        nozzle_mm, mouth_mm = (own + self.part.deflection_mm for own in (shape.nozzle_radius_mm, shape.mouth_mm))
        wide = replace(shape, nozzle_radius_mm=nozzle_mm, mouth_radius_mm=shape.mouth_radius_mm and mouth_mm)
        tips = points + (self.torch.standoff_mm + (more_mm or 0.0)) * wire
        start = shape.wire_mm if more_mm is None else START_MM
        _, found = sweep_torch(self.part, [(tips, np.stack([R, R]))], wide, axis=self.torch.axis, start_mm=start)
        return len(found) == 0

    def _room(self, p: FloatArray, R: FloatArray, most_mm: float) -> FloatArray:
        """Return by how much more than its margin the torch is away from the part, shape (n,), mm, up to a limit."""
        starts, ends = self.torch.segments(p, R.reshape(-1, 3, 3)).reshape(2, -1, 3)
        need = np.repeat(self.torch.pieces[1], len(p)) + MARGIN_MM + self.part.deflection_mm
        distance, _ = part_distances(self.part, starts, ends, need + most_mm)
        return np.asarray((distance - need).reshape(-1, len(p)).min(axis=0, initial=most_mm), dtype=np.float64)

    def across(self, a: FloatArray, b: FloatArray, turn: FloatArray, names: str) -> AirWay:
        """Return poses from a to b (both included) with the orientations of a turn, spread along the move."""
        p = a + np.linspace(0.0, 1.0, len(turn))[:, None] * (b - a)
        for i in range(len(p) - 1):
            if not self.is_free(p[i], p[i + 1], turn[i], turn[i + 1]):
                raise GeometryError(
                    f"{names}: the torch comes nearer to the part than {MARGIN_MM:g} mm on the way across at this "
                    f"clearance ({self.torch.shape}); no program is written. Give a larger --clearance-mm",
                    code=ErrorCode.NO_FREE_WAY,
                )
        return AirWay(p[1:], turn[1:])

    def is_free(self, p0: FloatArray, p1: FloatArray, R0: FloatArray, R1: FloatArray) -> bool:
        """Tell whether a linear move keeps its distance from the part all along, and not only at samples."""
        omega = np.zeros(3) if R1 is R0 else log_rotation(R0.T @ R1)
        travel = float(np.linalg.norm(p1 - p0)) + float(np.linalg.norm(omega)) * self.torch.reach_mm
        count = 2 ** max(0, math.ceil(math.log2(max(travel, LEAST_STRETCH_MM) / FIRST_STRETCH_MM)))
        middle, half = (np.arange(count) + 0.5) / count, 0.5 / count
        while len(middle):
            moved = travel * half  # no point of the axis is farther from its place at the middle
            R = R0 @ exp_rotation(middle[:, None] * omega) if omega.any() else R0
            room = self._room(p0 + middle[:, None] * (p1 - p0), R, moved)
            if (room < 0.0).any() or (moved < LEAST_STRETCH_MM and (room < moved).any()):
                return False
            middle = middle[room < moved]
            middle = np.concatenate([middle - half / 2, middle + half / 2])
            half /= 2
        return True
