"""The order of the seams, and which way of welding is taken of each: the shortest time between them.

For one order the best choice of ways is found exactly (a shortest path through the layers of ways). The order starts
with the nearest next seam, and single seams are then moved to other places as long as that is shorter.
"""

from __future__ import annotations

import itertools
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import first_least, length
from wpcal.planning.sequence.targets import WeldOrder

MOST_MOVED = 60
"""With more seams the order of the nearest next seam is kept: moving single seams takes the square of their number."""
SWEEPS = 3  #: Rounds in which every seam is moved once at most.
LEAST_GAIN_S = 1e-9  #: A shorter time counts from here: round-off does not change an order.


@dataclass(frozen=True, slots=True, eq=False)
class Stop:
    """One stretch to weld, with its ways."""

    #: `start`, `end`: shape (c, k). All axes at the first and the last point of each way.
    start: FloatArray
    end: FloatArray
    cost_s: FloatArray  #: shape (c,). What a way costs by itself, in seconds.
    middle: FloatArray  #: shape (3,). Of the stretch, mm in `part`.
    rank: int = 1  #: All stops of a lower rank come first: tack welds before welds, and a bead before the one on it.


@dataclass(frozen=True, slots=True, eq=False)
class Order:
    """An order of stops: their numbers, the way of each, and the time between them, s."""

    stops: tuple[int, ...]
    ways: tuple[int, ...]
    seconds: float


def axis_seconds(a: FloatArray, b: FloatArray, speeds: FloatArray) -> FloatArray:
    """Return the time of the slowest axis between states of shapes (..., k), s."""
    return np.asarray((np.abs(b - a) / speeds).max(axis=-1), dtype=np.float64)


def find_order(
    stops: Sequence[Stop],
    home: FloatArray,
    speeds: FloatArray,
    rule: WeldOrder,
    blocked: Sequence[tuple[int, int, int, int]] = (),
) -> Order:
    """Return the order of stops and the way of each.

    `home`: shape (k,). Where the sequence starts and ends.
    `speeds`: shape (k,). Of the axes through the air.
    `blocked`: Moves that are not free: stop and way of both ends, -1 for home; a way itself from its stop to its stop.
    """
    seconds = _Seconds(stops, home, speeds, blocked)
    if rule is WeldOrder.LISTED:
        return seconds.best_ways(list(range(len(stops))))
    if rule is not WeldOrder.TIME:
        arrange = _apart if rule is WeldOrder.SKIP else _in_pairs
        ranks = sorted({stop.rank for stop in stops})
        groups = [[row for row, stop in enumerate(stops) if stop.rank == rank] for rank in ranks]
        return seconds.best_ways([group[row] for group in groups for row in arrange([stops[i] for i in group])])
    best = seconds.best_ways(seconds.nearest_next())
    for _ in range(SWEEPS if len(stops) <= MOST_MOVED else 0):
        before = best
        for stop in range(len(stops)):
            rest = [other for other in best.stops if other != stop]
            ranks = [stops[other].rank for other in rest]
            first, last = bisect_left(ranks, stops[stop].rank), bisect_right(ranks, stops[stop].rank)
            found = min(([*rest[:at], stop, *rest[at:]] for at in range(first, last + 1)), key=seconds.of)
            if seconds.of(found) < best.seconds - LEAST_GAIN_S:
                best = seconds.best_ways(found)
        if best is before:
            break
    return best


def _apart(stops: Sequence[Stop]) -> list[int]:
    """Return an order in which each stop is as far as possible from the two before it."""
    middles = np.array([stop.middle for stop in stops])
    order, rest = [0], list(range(1, len(stops)))
    while rest:
        last = middles[order[-2:]]
        far = [float(np.linalg.norm(middles[row] - last, axis=1).min()) for row in rest]
        order.append(rest.pop(int(first_least(-np.array(far)))))
    return order


def _in_pairs(stops: Sequence[Stop]) -> list[int]:
    """Return an order in which each stop is followed by the one opposite, and pairs are far from one another.

    Opposite is through the middle of all stops.
    """
    middles = np.array([stop.middle for stop in stops])
    opposite = 2.0 * middles.mean(axis=0) - middles
    rest, pairs = list(range(len(stops))), list[list[int]]()
    while rest:
        first = rest.pop(0)
        away = [length(middles[row] - opposite[first]) for row in rest]
        pairs.append([first, rest.pop(int(first_least(away)))] if rest else [first])
    order = pairs.pop(0)
    while pairs:
        last = middles[order[-2:]]
        far = [float(np.linalg.norm(middles[pair][:, None] - last, axis=2).min()) for pair in pairs]
        order += pairs.pop(int(first_least(-np.array(far))))
    return order


class _Seconds:
    """Times between all ways of all stops."""

    def __init__(
        self, stops: Sequence[Stop], home: FloatArray, speeds: FloatArray, blocked: Sequence[tuple[int, int, int, int]]
    ) -> None:
        count = [len(stop.cost_s) for stop in stops]
        self.rank = [stop.rank for stop in stops]
        self.first = np.concatenate([[0], np.cumsum(count)])
        start, end = (np.concatenate([getattr(stop, name) for stop in stops]) for name in ("start", "end"))
        self.cost = np.concatenate([stop.cost_s for stop in stops])
        self.between = axis_seconds(end[:, None], start[None], speeds)
        self.out = axis_seconds(home, start, speeds)
        self.back = axis_seconds(end, home, speeds)
        for a, way_a, b, way_b in blocked:
            row, column = self.first[a] + way_a, self.first[b] + way_b
            if a == b:
                self.cost[row] = np.inf
            elif a < 0:
                self.out[column] = np.inf
            elif b < 0:
                self.back[row] = np.inf
            else:
                self.between[row, column] = np.inf

    def _rows(self, stop: int) -> slice:
        return slice(int(self.first[stop]), int(self.first[stop + 1]))

    def nearest_next(self) -> list[int]:
        """Return the order in which the nearest stop is always next."""
        rest = list(range(len(self.first) - 1))
        reach, order = self.out, []
        while rest:
            least = min(self.rank[stop] for stop in rest)
            now = [stop for stop in rest if self.rank[stop] == least]
            found = [float((reach[self._rows(stop)] + self.cost[self._rows(stop)]).min()) for stop in now]
            stop = now[int(first_least(found))]
            rest.remove(stop)
            order.append(stop)
            rows = self._rows(stop)
            way = int(first_least(reach[rows] + self.cost[rows]))
            reach = self.between[rows.start + way]
        return order

    def of(self, stops: list[int]) -> float:
        """Return the least time of an order, s."""
        rows = self._rows(stops[0])
        total = self.out[rows] + self.cost[rows]
        for stop in stops[1:]:
            before, rows = rows, self._rows(stop)
            total = (total[:, None] + self.between[before, rows]).min(axis=0) + self.cost[rows]
        return float((total + self.back[rows]).min())

    def best_ways(self, stops: list[int]) -> Order:
        """Return the way of each stop with which an order takes the least time."""
        rows = self._rows(stops[0])
        total, came = self.out[rows] + self.cost[rows], []
        for before, stop in itertools.pairwise(stops):
            rows = self._rows(stop)
            every = total[:, None] + self.between[self._rows(before), rows]
            came.append(first_least(every, axis=0))
            total = every.min(axis=0) + self.cost[rows]
        last = total + self.back[rows]
        ways = [int(first_least(last))]
        for best in reversed(came):
            ways.append(int(best[ways[-1]]))
        return Order(tuple(stops), tuple(ways[::-1]), float(last.min()))
