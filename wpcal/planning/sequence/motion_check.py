"""Straight moves in the axes, proved free between the checked states too.

Two bodies that are D apart at both ends of a step cannot touch on it if they approach each other by less than 2 D on
it; `motion_per_axis` bounds this. So a step is proved when the bound is at most the sum of the free distances at its
ends, for the bodies of every two carriers. Otherwise it is halved, and its middle is measured. Each two carriers
have their own bound: a part near the frame of its positioner asks for small steps of the positioner, not of the robot.

Also here: how far bodies can move towards each other per unit of each axis, from the lengths of the links alone.

A point turns about an axis with its distance from the axis. That distance is at most the distance of the next axis'
origin from the axis, plus the lengths of the links after it, plus the distance of the point from the last of these
origins, whatever the axes between them do. Two bodies move towards each other only by the axes that move one of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.core.arrays import BoolArray, FloatArray, IntArray, numbered_rows
from wpcal.core.same_bits import length, product
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.bodies import bodies_of
from wpcal.planning.cell.cell import CARRIER, TOOL, Cell
from wpcal.planning.cell.cell_clearance import CellClearance, Margins
from wpcal.planning.cell.clearance import stacked
from wpcal.planning.cell.segments import dot
from wpcal.planning.cell.shape import JOINTS, corners_of_box
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.forward import Frames


class _Axes(NamedTuple):
    """The lines about which a row of axes turns at home: points on them and directions, shape (a, 3), in `world`."""

    origin: FloatArray
    z: FloatArray


def motion_per_axis(cell: Cell, clearance: CellClearance) -> FloatArray:
    """Return bounds of how far the bodies of each pair of carriers move towards each other per unit of each axis.

    Returns ndarray, shape (c, k). mm per rad, and 1 for a rail; rows as in `CellClearance.carriers`.
    """
    frames = cell.frames(cell.home[None])
    reaches = [_reaches(cell, frames, carrier, balls) for carrier, balls in _balls(cell, clearance.part).items()]
    each = [(reaches[one], reaches[other]) for one, other in clearance.carriers]
    return np.array([np.where((a > 0.0) & (b > 0.0), 0.0, a + b) for a, b in each]).reshape(len(each), len(cell.home))


def _balls(cell: Cell, part: TriangleMaterial | None) -> dict[int, FloatArray]:
    """Return balls whose hull contains the bodies of each carrier: rows of centre in its frame and radius, mm."""
    found: dict[int, list[FloatArray]] = {row: [np.zeros((0, 4))] for row in range(cell.part_row + 1)}
    for body in bodies_of(cell):
        shape = body.shape
        for points, radius in ((shape.p, shape.radius_mm), (shape.q, shape.radius_mm), (shape.hull, 0.0)):
            found[body.carrier].append(np.column_stack([points, np.broadcast_to(radius, len(points))]))
    if part is not None:
        corners = part.corners.reshape(-1, 3)
        found[cell.part_row].append(np.column_stack([corners, np.zeros(len(corners))]))
    return {carrier: np.concatenate(rows) for carrier, rows in found.items()}


def _reaches(cell: Cell, frames: tuple[Frames, ...], carrier: int, balls: FloatArray) -> FloatArray:
    """Return how far the bodies of one carrier move per unit of each axis, shape (k,)."""
    found = np.zeros(len(cell.home))
    balls = np.column_stack([frames[carrier].point(balls[:, :3].T).T, balls[:, 3]])  # in `world`, at home
    if carrier <= TOOL:
        own = _distances(_axes(cell.arm, cell.base_places(cell.home[None])[0], frames), min(carrier, JOINTS), balls)
        found[: len(own)] = own
        if cell.rail_axis is not None:
            found[cell.rail_axis] = 1.0
    elif carrier >= CARRIER and cell.carrier is not None:
        arm, first = cell.carrier.arm, cell.first_turning
        axes = _axes(arm, cell.carrier.T_world_base.matrix, frames[CARRIER:])
        own = _distances(axes, min(carrier - CARRIER, len(arm.joints)), balls)
        found[first : first + len(own)] = own
    return found


def _axes(arm: Arm, T_world_base: FloatArray, frames: tuple[Frames, ...]) -> _Axes:
    """Return the lines of the joints of an arm: z of the frame before each link."""
    first: RigidTransform = arm.chain.T_base_dh0
    start = product(T_world_base, first.matrix)
    after = frames[1 : len(arm.joints)]
    origins = np.array([start[:3, 3], *(frame.p[:, 0] for frame in after)])
    return _Axes(origins, np.array([start[:3, 2], *(frame.z[:, 0] for frame in after)]))


def _distances(axes: _Axes, count: int, balls: FloatArray) -> FloatArray:
    """Return the largest distances of a body from the first `count` axes, which all move it, shape (count,), mm."""
    if not len(balls):
        return np.zeros(count)
    centres, radius = balls[:, :3], balls[:, 3]
    found = np.zeros(count)
    beyond = 0.0  # from the origin of the next axis to the farthest point, whatever the axes between do
    for axis in reversed(range(count)):
        origin, z = axes.origin[axis], axes.z[axis]
        if axis == count - 1:
            found[axis] = (np.linalg.norm(np.cross(centres - origin, z), axis=1) + radius).max()
            beyond = float((np.linalg.norm(centres - origin, axis=1) + radius).max())
        else:
            link = axes.origin[axis + 1] - origin
            found[axis] = length(np.cross(link, z)) + beyond
            beyond += length(link)
    return found


def _boxes(cell: Cell) -> dict[int, FloatArray]:
    """Return the corners (8, 3) of the box around the bodies of each carrier of the robot, in its frame, mm."""
    found = {}
    for carrier, balls in _balls(cell, None).items():
        if carrier <= TOOL and len(balls):
            low, high = balls[:, :3] - balls[:, 3:], balls[:, :3] + balls[:, 3:]
            found[carrier] = corners_of_box(low.min(axis=0), high.max(axis=0))
    return found


FIRST_STEP_MM = 150.0  #: Steps of the first round: most of a move is this far from everything.
LONG_STEP_MM = 800.0
"""The same where many moves are tried of which few are free: most are given up in the first round."""
ROUND_OFF_MM = 1e-6  #: A move that was free and is divided at other places has a margin that is less by round-off.
MOST_PARTS = 4  #: A step is divided into this many at once: fewer calls than by halving, hardly more states.
MOST_HALVINGS = 24  #: Of a triangle: its sides are then a thousandth of what they were.
LEAST_FREE_MM = 0.25
"""A step is also proved with this free distance at both ends where the safety distances are smaller, as at a corner
where the torch may touch the part: between two states it is in the part by this much at most."""


@dataclass(frozen=True, slots=True, eq=False)
class CheckedMove:
    """Result for a row of straight moves."""

    is_free: bool
    states: FloatArray  #: shape (m, k). The measured states in order, rad and mm.
    at: FloatArray  #: shape (m,). Their places, in moves from the start: 1.5 is half-way along the second move.
    margin_mm: FloatArray  #: shape (m,). Lower bounds of the margins.


class MotionChecker:
    """Checks straight moves in the axes of a cell."""

    def __init__(self, cell: Cell, clearance: CellClearance) -> None:
        self.cell, self.clearance = cell, clearance
        self._per_axis = motion_per_axis(cell, clearance)
        self.per_axis: FloatArray = self._per_axis.max(axis=0, initial=0.0)
        boxes = _boxes(cell)
        self._boxed, self._corners = list(boxes), np.moveaxis(np.reshape([*boxes.values()], (-1, 8, 3, 1)), 2, 0)
        pairs = list(enumerate(clearance.carriers.tolist()))
        self._chorded = [row for row, (one, other) in pairs if one in boxes and other > TOOL]
        self._boxed_one = [self._boxed.index(one) for one, other in clearance.carriers[self._chorded].tolist()]
        self._free_mm = np.maximum(clearance.least_safety_mm, LEAST_FREE_MM)

    def motion_mm(self, a: FloatArray, b: FloatArray) -> FloatArray:
        """Return bounds of how far any body moves towards another between states (..., k); shape (...), mm."""
        return np.asarray(product(np.abs(b - a), self._per_axis.T).max(axis=-1, initial=0.0), dtype=np.float64)

    def nearest(self, states: FloatArray) -> str:
        """Say which two bodies miss their safety distance most at any of some states, and by how much.

        `states`: shape (n, k). rad and mm.
        """
        found = self.clearance.margins(states)
        row = int(np.argmin(found.margin_mm))
        one, two = self.clearance.names(int(found.pair[row]))
        return f"{one} and {two} miss their safety distance by {-found.margin_mm[row]:.1f} mm"

    def _parts(self, a: FloatArray, b: FloatArray, free: FloatArray, trust: float = 1.0) -> IntArray:
        """Return into how many parts to divide steps between states (n, k), shape (n,).

        1: the step does not use up the free distances (n, c) of its ends.
        """
        share = product(np.abs(b - a), self._per_axis.T) / free
        rows = np.flatnonzero((share > trust).any(axis=1))
        if len(rows):
            share[rows] = self._chords_mm(a[rows], b[rows]) / free[rows]
        parts = np.ceil(share.max(axis=1, initial=0.0) / trust)
        return np.asarray(np.clip(parts, 1, MOST_PARTS), dtype=np.int64)

    def _chords_mm(self, a: FloatArray, b: FloatArray) -> FloatArray:
        """Return bounds as `motion_mm`, of a robot that moves alone from its places at both ends; shape (n, c).

        A way whose acceleration is at most C is longer than its chord by C / 2 at most. The second derivative of a
        point by two joints is that by the outer one, turned.
        """
        cell, n = self.cell, len(a)
        step = np.abs(b - a)
        turns = step.sum(axis=1) - (0.0 if cell.rail_axis is None else step[:, cell.rail_axis])
        found = product(step, self._per_axis.T)
        bend = found * turns[:, None] / 2.0
        still = ~step[:, cell.first_turning :].any(axis=1, keepdims=True)
        frames = stacked(cell.frames(np.concatenate([a, b])))[:, :, self._boxed]
        u, v, w, p = (frames[..., n:] - frames[..., :n])[:, :, :, None]  # (3, carriers, 1, n)
        x, y, z = self._corners
        gap = x * u + y * v + z * w + p
        chord, rows = np.sqrt(dot(gap, gap).max(axis=1))[self._boxed_one].T, self._chorded
        nearer = np.minimum(found[:, rows], chord + bend[:, rows])
        found[:, rows] = np.where(still, nearer, found[:, rows])
        return np.asarray(found, dtype=np.float64)

    def check(
        self, states: FloatArray, *, again: bool = False, known: Margins | None = None, gaps: BoolArray | None = None
    ) -> CheckedMove:
        """Check the straight moves from state to state. Where it is not free, the states measured so far.

        `states`: shape (n, k). Two or more, rad and mm.
        `again`: Whether they were found free one by one, so that a margin of zero is round-off.
        `known`: Margins of the states, and of more after them.
        `gaps`: shape (n - 1,). Where one row of moves ends and the next begins: nothing moves there.
        """
        gaps = np.zeros(len(states), dtype=bool) if gaps is None else np.append(gaps, False)
        least_mm = -ROUND_OFF_MM if again else 0.0
        at, q = self._divided(np.asarray(states, dtype=np.float64), gaps)
        margin, free = self._measured(q, known if len(q) == len(states) else None)
        first = np.flatnonzero(~gaps[at[:-1].astype(np.int64)])
        last = first + 1
        while True:
            parts = self._parts(q[first], q[last], free[first] + free[last])
            is_free = bool((margin > least_mm).all())
            if not (parts > 1).any() or not is_free:
                order = np.argsort(at, kind="stable")
                return CheckedMove(is_free, q[order], at[order], margin[order])
            (one, other, share), (first, last) = _parted(first, last, parts, len(q))
            new = q[one] + share[:, None] * (q[other] - q[one])
            at, q = np.concatenate([at, at[one] + share * (at[other] - at[one])]), np.concatenate([q, new])
            found, around = self._measured(new)
            margin, free = np.concatenate([margin, found]), np.concatenate([free, around])

    def _measured(self, q: FloatArray, known: Margins | None = None) -> tuple[FloatArray, FloatArray]:
        """Return margins (n,) and the free distances of the bodies of every two carriers (n, c), mm."""
        found, n = known or self.clearance.margins(q), len(q)
        return found.margin_mm[:n], np.maximum(found.by_carriers_mm[:n], 0.0) + self._free_mm

    def _divided(self, states: FloatArray, gaps: BoolArray) -> tuple[FloatArray, FloatArray]:
        """Return places and states at steps of `FIRST_STEP_MM` at most: one call measures them all."""
        parts = np.maximum(np.ceil(self.motion_mm(states[:-1], states[1:]) / FIRST_STEP_MM), 1.0).astype(int)
        parts[gaps[:-1]] = 1
        row, number = numbered_rows(parts)
        share = number / parts[row]
        q = states[row] + share[:, None] * (states[row + 1] - states[row])
        return np.append(row + share, float(len(parts))), np.concatenate([q, states[-1:]])

    def free_shares(self, a: FloatArray, b: FloatArray, *, whole: bool, trust: float = 1.0) -> FloatArray:
        """Return how much of each of many straight moves is free, all measured together.

        `a`, `b`: shape (n, k). Starts and ends, rad and mm.
        Returns ndarray, shape (n,). 0 where the start is not clear, 1 where the whole move is free.
        """
        motion = self.motion_mm(a, b)
        parts = np.maximum(np.ceil(motion / (LONG_STEP_MM if whole else FIRST_STEP_MM)), 1.0).astype(int) + 1
        move = np.repeat(np.arange(len(a)), parts)
        first = np.cumsum(parts) - parts
        t = (np.arange(len(move)) - first[move]) / (parts - 1)[move]
        margin, free = self._measured(a[move] + t[:, None] * (b - a)[move])
        first = np.flatnonzero(move[1:] == move[:-1])
        last = first + 1
        while True:
            hit = np.full(len(a), np.inf)
            np.minimum.at(hit, move[margin <= 0.0], -np.inf if whole else t[margin <= 0.0])
            keep = t[last] < hit[move[last]]
            first, last = first[keep], last[keep]
            ends = [a[move[row]] + t[row, None] * (b - a)[move[row]] for row in (first, last)]
            parts = self._parts(ends[0], ends[1], free[first] + free[last], trust)
            if not (parts > 1).any():
                break
            (one, other, share), (first, last) = _parted(first, last, parts, len(t))
            own, at = move[one], t[one] + share * (t[other] - t[one])
            new = own, at, *self._measured(a[own] + at[:, None] * (b - a)[own])
            move, t, margin, free = map(np.concatenate, zip((move, t, margin, free), new, strict=True))
        share, reached = np.zeros(len(a)), t < hit[move]
        np.maximum.at(share, move[reached], t[reached])
        return share

    def is_free_between(self, corners: FloatArray) -> bool:
        """Tell whether all states of a triangle of three states are free.

        From the middle of a triangle no body moves farther than to one of its corners. Where that is more than is free
        around the middle, the triangle is halved across its longest side.

        `corners`: shape (3, k). rad and mm.
        """
        triangles = corners[None]
        for _ in range(MOST_HALVINGS):
            middle = triangles.mean(axis=1)
            margin, free = self._measured(middle)
            if (margin <= 0.0).any():
                return False
            away = np.abs(triangles - middle[:, None])
            wide = (product(away, self._per_axis.T).max(axis=1) > free).any(axis=1)
            if not wide.any():
                return True
            a, b, c = triangles[wide].transpose(1, 0, 2)
            sides = np.array([self.motion_mm(b, c), self.motion_mm(c, a), self.motion_mm(a, b)])
            row, longest = np.arange(len(a)), sides.argmax(axis=0)
            turned = np.stack([a, b, c], axis=1)[row[:, None], (longest[:, None] + [0, 1, 2]) % 3]
            tip, one, other = turned.transpose(1, 0, 2)
            half = (one + other) / 2
            triangles = np.concatenate([np.stack([tip, one, half], axis=1), np.stack([tip, half, other], axis=1)])
        return False

    def is_free(self, a: FloatArray, b: FloatArray) -> bool:
        """Tell whether the straight move between two states of shape (k,) is free."""
        return self.check(np.stack([a, b])).is_free


def _parted(
    first: IntArray, last: IntArray, parts: IntArray, count: int
) -> tuple[tuple[IntArray, IntArray, FloatArray], tuple[IntArray, IntArray]]:
    """Divide steps between rows of states.

    `first`, `last`, `parts`: shape (n,). The rows of the ends of the steps, and into how many parts each is divided.
    `count`: How many rows there are; the new ones come behind them.
    Returns the rows of both ends and the share of the way of each new state, and the rows of the ends of the parts.
    """
    inner = parts - 1
    own, number = numbered_rows(inner)
    number = number + 1
    one, other, new = first[own], last[own], count + np.arange(len(own))
    is_last = number == inner[own]
    ends = np.concatenate([np.where(number == 1, one, new - 1), new[is_last]]), np.concatenate([new, other[is_last]])
    return (one, other, number / parts[own]), ends
