r"""The fewest lines and arcs that keep to a path: a shortest path over all moves that are allowed.

A move leads from one point of the path to a later one. It is allowed if it is within the tolerance at every checked
point between them. An arc goes through the point at half its length. The points are visited in layers: those that one
move reaches, those that two moves reach, and so on. The layer in which the last point is found is the least number of
moves: no choice of such moves has fewer. Among the paths with this number, the one with the fewest arcs is taken, and
among these the one whose largest deviation is least.

The turn about the wire is free. How the wire goes between two points depends only on the turn of the tool from one to
the other, not on the turn that it has at the first. So every move chooses its own turn, and the search needs no states
for it. Two turns are tried: as little as the wire allows, and the one that leads the wire through its direction at the
middle. On a circle the tool then turns about the axis of the circle.

All moves from a layer are tested in one array operation. For n points at most n² / 2 lines and as many arcs are tested
once. A straight path needs one test. The moves are tested at 18 of their points at most, and those of the best path
then at every point. If one of them fails there, the search is repeated with every point of every move. Either way the
moves that are returned were tested at every point, and their number is the least.

Between two points the torch may turn so fast, or so unevenly, that no move is allowed. Such a step is divided in two,
its pieces again, and so on: the course is known there, and on a short enough piece it is a line.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import BoolArray, FloatArray, IntArray, frozen, numbered_rows
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.options import opt
from wpcal.robot.moves.course import Course
from wpcal.robot.moves.interpolation import Moves, swings_between, turns_between, turns_through
from wpcal.robot.moves.move import Arc, Line, Move, MovePath

LINES_ONLY = 4.0  #: Lines alone may also end within a step where the chord of two steps, off four times as far, fails.
CHUNK = 200_000  #: Checked points in one array: some 50 MB.
MOST_PAIRS = 100_000  #: Moves in one array: some 100 MB.
FEW = 3  #: Points at which a move is tested first: most moves that leave the path do so there.
FEW_NODES = 64  #: Up to this many, all moves between nodes are tested at once: 2000 in one array.
MOST_SEARCHES = 13  #: Of a fit. Steps are divided in two before each but the first: half a turn into 0.04 deg.
SOME = 15
"""Points at which the moves that are left are tested next. On a circle of n points nearly all n² / 4 arcs are left, and
to test them at every point would take n³ / 16 operations."""


@dataclass(frozen=True, slots=True)
class PathTolerance:
    """How far moves may be from the path. Raises `InputError` when a value is not positive."""

    mm: float = opt(
        0.05,
        "A seam becomes as few lines and circular arcs as keep the wire within this distance, and within 0.5 deg.",
        "--path-tol-mm",
    )
    wire_rad: float = math.radians(0.5)  #: Of the direction of the wire.
    #: Of the direction across the wire, where it is given. Infinity: the turn about the wire is free.
    side_rad: float = math.inf

    def __post_init__(self) -> None:
        for name, value in (("path tolerance", self.mm), ("tolerance of the wire", self.wire_rad)):
            if not 0.0 < value < math.inf:
                raise InputError(f"{name}: expected a positive number, got {value:g}")

    def narrowed(self, share: float) -> PathTolerance:
        """Return a share of the tolerance. Less than all of it also bounds the turn about the wire."""
        side_rad = self.side_rad if share == 1.0 else min(self.side_rad, self.wire_rad)
        return PathTolerance(share * self.mm, share * self.wire_rad, share * side_rad)


USUAL_TOLERANCE = PathTolerance()
Condition = Callable[[FloatArray, FloatArray], BoolArray]
"""From the lengths along the path at which m moves begin and end, mm, to whether each is allowed; shapes (m,)."""


class _Steps(NamedTuple):
    """Moves between nodes: begin, end, point in the middle of an arc (-1: line), how far off, and rotation vector."""

    first: IntArray
    last: IntArray
    via: IntArray
    worst: FloatArray
    turn: FloatArray

    def select(self, rows: IntArray) -> _Steps:
        return _Steps._make(each[rows] for each in self)

    def joined(self, more: _Steps) -> _Steps:
        return _Steps._make(np.concatenate(both) for both in zip(self, more, strict=True))


def fit_moves(
    p: ArrayLike,
    R: ArrayLike,
    *,
    s_mm: ArrayLike | None = None,
    headings: ArrayLike | None = None,
    axis: int = 2,
    standoff_mm: float = 0.0,
    tolerance: PathTolerance = USUAL_TOLERANCE,
    spin_is_free: bool = True,
    arcs: bool = True,
    also: Condition | None = None,
) -> MovePath:
    """Return the fewest lines and arcs along a path.

    Raises `GeometryError` when there are fewer than two points, or no line is allowed on the shortest piece of a step.

    `p`: shape (n, 3). Tool centre points along the path, in any one frame, mm; at least two.
    `R`: shape (n, 3, 3). Axes of the tool there, in the same frame. Between two points the tool turns smoothly.
    `s_mm`: shape (n,). Lengths along the path, increasing; by default those of the chords.
    `headings`: shape (n, 3), optional. Directions of travel of the wire's tip. Without them the path is straight
    between two points.
    `spin_is_free`: Whether only the wire has to keep its direction. The turn about the wire is then as each move makes
    it, starting from the first pose. False: every move begins and ends with the given axes of the tool.
    Returns MovePath. Its first pose is the first of the path. Its last is the last of the path; with a free spin it may
    be turned about the wire.
    """
    p, R = np.asarray(p, dtype=np.float64), np.asarray(R, dtype=np.float64)
    if len(p) < 2:
        raise GeometryError(f"moves: expected at least 2 points, got {len(p)}")
    chords = np.linalg.norm(np.diff(p, axis=0), axis=1)
    s = np.concatenate([[0.0], np.cumsum(chords)]) if s_mm is None else np.asarray(s_mm, dtype=np.float64)
    along = partial(
        Course.along,
        p,
        R,
        s_mm=s,
        headings=None if headings is None else np.asarray(headings, dtype=np.float64),
        axis=axis,
        standoff_mm=standoff_mm,
        most_mm=tolerance.mm if arcs else tolerance.mm / LINES_ONLY,
    )
    search = _Search(along(), tolerance, _FREE if spin_is_free else _GIVEN, SOME, arcs=arcs, also=also)
    pieces = np.ones(len(p) - 1, dtype=np.int64)
    for _ in range(MOST_SEARCHES):
        path = search.path()
        if path is not None:
            return path
        pieces[search.uncovered()] *= 2
        search = replace(search, course=along(pieces=pieces))
    raise GeometryError(f"moves: no line keeps to the path between point {np.argmax(pieces) + 1} and the next")


class _Turn(Enum):
    """How a move turns the tool; in the order in which a search tries them."""

    GIVEN = "from the given axes to the given axes"
    SWING = "as little as the wire allows"
    CONE = "so that the wire passes its direction at the middle"


_GIVEN, _FREE = (_Turn.GIVEN,), (_Turn.SWING, _Turn.CONE)


@dataclass(frozen=True, eq=False)
class _Search:
    course: Course
    tolerance: PathTolerance
    kinds: tuple[_Turn, ...]
    most: int | None  #: Points at which a move is tested; None for all of them.
    arcs: bool
    also: Condition | None

    def path(self) -> MovePath | None:
        """Return the fewest moves; None if there is a step that no move covers."""
        whole = self.allowed(np.array([0]), np.array([len(self.course.nodes) - 1]))
        found = ([whole], [0]) if len(whole.first) else self.layers()
        if found is None:
            return None
        path = _path(self.course, *found, self.tolerance)
        is_within = path.off_mm <= self.tolerance.mm and path.off_rad <= self.tolerance.wire_rad
        return path if is_within or self.most is None else replace(self, most=None).path()

    def uncovered(self) -> IntArray:
        """Return the steps between given poses of which a piece is not an allowed move."""
        count = len(self.course.nodes) - 1
        pieces = replace(self, most=None).allowed(np.arange(count), np.arange(1, count + 1))
        return np.unique(np.delete(self.course.steps, pieces.first))

    def layers(self) -> tuple[list[_Steps], list[int]] | None:
        """Return the best steps into each layer, and in each the row of the one taken; None if the end fails."""
        count = len(self.course.nodes)
        arcs, worst = np.full(count, np.inf), np.full(count, np.inf)
        arcs[0] = worst[0] = 0.0
        layer, unreached = np.array([0]), np.ones(count, dtype=bool)
        unreached[0] = False
        layers: list[_Steps] = []
        while len(layer) and unreached[-1]:
            steps = self._from(layer, np.flatnonzero(unreached))
            many = arcs[steps.first] + (steps.via >= 0)
            most = np.maximum(worst[steps.first], steps.worst)
            order = np.lexsort((most, many, steps.last))
            layer, best = np.unique(steps.last[order], return_index=True)
            chosen = order[best]
            arcs[layer], worst[layer] = many[chosen], most[chosen]
            unreached[layer] = False
            layers.append(steps.select(chosen))
        if unreached[-1]:
            return None
        rows, node = [], count - 1
        for steps in reversed(layers):
            row = int(np.searchsorted(steps.last, node))
            rows.append(row)
            node = int(steps.first[row])
        return layers, rows[::-1]

    def _from(self, layer: IntArray, targets: IntArray) -> _Steps:
        """Return the allowed moves from a layer; those to the end only, if there are any."""
        end = np.full(len(layer), targets[-1])
        steps = self._known(layer, end)
        if len(steps.first):
            return steps
        for part in np.array_split(layer, math.ceil(len(layer) * len(targets) / MOST_PAIRS)):
            first, last = (x.ravel() for x in np.meshgrid(part, targets[:-1], indexing="ij"))
            steps = steps.joined(self._known(first[first < last], last[first < last]))
        return steps

    def _known(self, first: IntArray, last: IntArray) -> _Steps:
        """Return the allowed moves between nodes, out of all moves if there are few."""
        if len(self.course.nodes) > FEW_NODES:
            return self.allowed(first, last)
        steps, rows = self._every
        found = rows[first, last]
        return steps.select(found[found >= 0])

    @cached_property
    def _every(self) -> tuple[_Steps, IntArray]:
        """All allowed moves, and the row of each by its two nodes; -1 for a move that is not."""
        count = len(self.course.nodes)
        steps = self.allowed(*np.triu_indices(count, 1))
        rows = np.full((count, count), -1)
        rows[steps.first, steps.last] = np.arange(len(steps.first))
        return steps, rows

    def allowed(self, first: IntArray, last: IntArray) -> _Steps:
        """Return the allowed moves between nodes: a line where one is, else an arc; with the first turn that is."""
        count = len(first)
        worst, via, turn = np.full(count, np.inf), np.full(count, -1), np.zeros((count, 3))
        s = self.course.s_mm[self.course.nodes]
        may = np.ones(count, dtype=np.bool_) if self.also is None else self.also(s[first], s[last])
        for is_arc in (False, True)[: 1 + self.arcs]:
            for kind in self.kinds:
                left = np.flatnonzero(~np.isfinite(worst) & may)
                if not len(left):
                    break
                through = self._middles(first[left], last[left]) if is_arc else np.full(len(left), -1)
                turns = self._turns(first[left], last[left], kind)
                worst[left], via[left], turn[left] = (
                    self._worst(first[left], last[left], through, turns),
                    through,
                    turns,
                )
        found = np.isfinite(worst)
        return _Steps(first[found], last[found], via[found], worst[found], turn[found])

    def _middles(self, first: IntArray, last: IntArray) -> IntArray:
        """Return the checked points nearest to half the length between nodes."""
        s, nodes = self.course.s_mm, self.course.nodes
        both = s[nodes[first]] + s[nodes[last]]
        after = np.clip(np.searchsorted(s, both / 2.0), 1, len(s) - 1)
        return np.asarray(after - (s[after] + s[after - 1] > both), dtype=np.int64)

    def _turns(self, first: IntArray, last: IntArray, kind: _Turn) -> FloatArray:
        course, begin, end = self.course, self.course.nodes[first], self.course.nodes[last]
        if kind is _Turn.GIVEN:
            return turns_between(course.R[begin], course.R[end])
        if kind is _Turn.SWING:
            return swings_between(course.wire[begin], course.wire[end])
        return turns_through(course.wire[begin], course.wire[self._middles(first, last)], course.wire[end])

    def _worst(self, first: IntArray, last: IntArray, via: IntArray, turn: FloatArray) -> FloatArray:
        """Return the largest deviation of moves in shares of the tolerance; infinity where it is above 1."""
        course, begin, end = self.course, self.course.nodes[first], self.course.nodes[last]
        through = np.where((via >= 0)[:, None], course.p[via], np.nan)
        moves = Moves.between(course.p[begin], course.R[begin], course.p[end], turn, through)
        worst = np.where(moves.is_sound, 0.0, np.inf)
        inner = end - begin - 1
        for most in (FEW, self.most):
            left = np.flatnonzero(np.isfinite(worst) & (inner > 0))
            for rows, own, at in _points(begin, inner, left, most):
                tested = moves.select(rows[own])
                share = tested.shares(course.p[at])
                off_mm, off_rad = deviations(course, tested, share, at)
                off = np.maximum(off_mm / self.tolerance.mm, off_rad / self.tolerance.wire_rad)
                if math.isfinite(self.tolerance.side_rad):
                    off = np.maximum(off, self._side(tested, share, at) / self.tolerance.side_rad)
                np.maximum.at(worst, rows[own], off)
            worst[worst > 1.0] = np.inf
        return worst

    def _side(self, moves: Moves, share: FloatArray, at: IntArray) -> FloatArray:
        """Return the angle between the directions across the wire, rad."""
        across = (self.course.axis + 1) % 3
        side = moves.directions(share, across)
        apart = np.linalg.norm(side - self.course.R[at, :, across], axis=1)
        return np.asarray(2.0 * np.arcsin(np.minimum(apart / 2.0, 1.0)), dtype=np.float64)


def _points(
    begin: IntArray, inner: IntArray, rows: IntArray, most: int | None
) -> Iterator[tuple[IntArray, IntArray, IntArray]]:
    """Yield moves, and for each point to check the row of its move among them and its place on the course."""
    counts = inner[rows] if most is None else np.minimum(inner[rows], most)
    for part in np.array_split(np.arange(len(rows)), max(1, math.ceil(counts.sum() / CHUNK))):
        count, first, span = counts[part], begin[rows[part]], inner[rows[part]]
        own, number = numbered_rows(count)
        at = first[own] + ((number + 1) * (span[own] + 1)) // (count[own] + 1)
        yield rows[part], own, at


def deviations(course: Course, moves: Moves, share: FloatArray, at: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return how far moves are from points of a course, where they pass them.

    `share`: shape (k,). Where each move passes its point (`Moves.shares`).
    `at`: shape (k,). Rows of the course.
    Returns `off_mm, off_rad`: ndarray, shape (k,). Distance of the wire's tips, and angle between the wires.
    """
    wire = moves.directions(share, course.axis)
    tip = moves.positions(share) + course.standoff_mm * wire
    apart = np.linalg.norm(wire - course.wire[at], axis=1)
    return np.linalg.norm(tip - course.tip[at], axis=1), 2.0 * np.arcsin(np.minimum(apart / 2.0, 1.0))


def _path(course: Course, layers: list[_Steps], rows: list[int], tolerance: PathTolerance) -> MovePath:
    """Return the chosen moves; each arc gets the orientation that the tool has at its middle point."""
    at, R, moves = [0], [course.R[0]], list[Move]()
    for steps, row in zip(layers, rows, strict=True):
        begin, end, turn = at[-1], int(course.nodes[steps.last[row]]), steps.turn[row : row + 1]
        via = course.p[steps.via[row : row + 1]] if steps.via[row] >= 0 else np.full((1, 3), np.nan)
        move = Moves.between(course.p[begin : begin + 1], R[-1][None], course.p[end : end + 1], turn, via)
        if steps.via[row] >= 0:
            at.append(int(steps.via[row]))
            R.append(move.rotations(move.shares(via))[0])
            moves.append(Arc(len(at) - 1, len(at)))
        else:
            moves.append(Line(len(at)))
        at.append(end)
        R.append(move.rotations(np.ones(1))[0])
    chosen = np.array(at, dtype=np.int64)
    path = MovePath(course.p[chosen], np.array(R), tuple(moves), course.s_mm[chosen])
    ends = chosen[path.ends]
    own = np.repeat(np.arange(len(moves)), np.diff(ends))
    every = path.arrays.select(own)
    off_mm, off_rad = deviations(course, every, every.shares(course.p[: ends[-1]]), np.arange(ends[-1]))
    off = float(off_mm.max()), float(off_rad.max())
    return MovePath(frozen(path.p), frozen(path.R), path.moves, frozen(path.s_mm), *off, tolerance.mm)
