"""The order of the searches, and the way through the air from each to the next.

The straight way from one approach to the next is taken where the torch is free on it. Elsewhere the torch rises to a
level above everything, crosses, and comes down; it turns on the level.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from wpcal.brep.material import Material
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.tangent import log_rotation
from wpcal.robot.moves.sweep import poses_between
from wpcal.robot.torch.shape import TorchShape
from wpcal.touch.plan.displaced import DisplacedPart
from wpcal.touch.plan.free import BIN_MM, torch_keeps_away

STEP_MM = 10.0  #: Places on a straight way are this far apart; the torch is felt wider by half of it.
STEP_RAD = math.radians(6.0)  #: And the torch turns by at most this between them.
MOST_EXACT = 11  #: Orders of up to this many searches are all compared (by subsets); of more, stretches are reversed.
LEVELS_MM = (0.0, 60.0, 150.0)  #: If the torch is not free on the safe level, it is tried this much higher.
NOT_FIRST = 1e12  #: What an order costs that begins elsewhere than it has to.
TURN_MM_PER_RAD = 100.0  #: A turn of the torch is weighed like this way.


@dataclass(frozen=True, slots=True, eq=False)
class Air:
    """Where the torch moves in the air."""

    materials: Sequence[Material]  #: The part and the bodies of the cell, in `part`.
    torch: TorchShape
    wire_mm: float
    up: FloatArray  #: shape (3,).
    safe_mm: float  #: Level along `up` above everything.
    clear_mm: float  #: Least distance of the torch.
    part: DisplacedPart

    def is_free(self, p: FloatArray, R: FloatArray) -> bool:
        """Tell whether the torch is free on straight ways.

        `p`: shape (m, 3). Places of the tip of the wire, in `part`, mm.
        `R`: shape (m, 3, 3). Axes of the tool there; it turns evenly between them.
        """
        tips, frames, _ = poses_between(p, R, STEP_MM, STEP_RAD, self.part.standoff_mm)
        clear = np.full(len(tips), math.ceil((self.clear_mm + STEP_MM / 2) / BIN_MM) * BIN_MM)
        felt_mm = max(self.wire_mm, STEP_MM)
        return bool(torch_keeps_away(self.materials, self.torch, tips, frames, clear, wire_mm=felt_mm).all())

    def over(self, a: FloatArray, b: FloatArray, higher_mm: float = 0.0) -> FloatArray:
        """Return the two corners of the way over the safe level, shape (2, 3)."""
        level = self.safe_mm + higher_mm
        return np.stack([p + max(level - float(p @ self.up), 0.0) * self.up for p in (a, b)])

    def way(self, a: FloatArray, Ra: FloatArray, b: FloatArray, Rb: FloatArray) -> FloatArray | None:
        """Return the points between two places on the way through the air, shape (k, 3); None if none is free."""
        if self.is_free(np.stack([a, b]), np.stack([Ra, Rb])):
            return np.empty((0, 3))
        below = self.over(a, b)  # the ways up to this level are free: each search was taken only with its own
        for higher in LEVELS_MM:
            via = self.over(a, b, higher)
            if self.is_free(np.stack([below[0], *via, below[1]]), np.stack([Ra, Ra, Rb, Rb])):
                return via
        return None

    def safe_way(
        self, way: FloatArray, a: FloatArray, Ra: FloatArray, b: FloatArray, Rb: FloatArray
    ) -> FloatArray | None:
        """Return the points of a way on which the torch passes the part wherever it stands.

        `way`: shape (k, 3). Points of the way between two approaches that is free of the part as planned.
        `a`, `b`: shape (2, 3). Approach and start of the two searches.
        `Ra`, `Rb`: shape (3, 3)

        Returns shape (k, 3), or None. The way itself, or one over the safe level; None if the torch passes on none.
        """
        for line, R_line in ((a, Ra), (b, Rb)):
            if not self.part.lets_pass(self.torch, self.wire_mm, line, np.stack([R_line] * 2), along_wire=True):
                return None
        for via in (way, *(self.over(a[0], b[0], higher) for higher in LEVELS_MM)):
            turned = len(via) // 2  # the torch turns in the middle: on the level
            p = np.concatenate([a[:1], via, b[:1]])
            R = np.stack([Ra] * (1 + turned) + [Rb] * (len(via) - turned + 1))
            if self.part.lets_pass(self.torch, self.wire_mm, p, R) and (via is way or self.is_free(p, R)):
                return via
        return None


def order_searches(approach: FloatArray, R: FloatArray, air: Air) -> tuple[IntArray, dict[tuple[int, int], FloatArray]]:
    """Return the shortest order, and the points on the way from each search to the next.

    Returns `order`: shape (n,).
    Returns `ways`: dict. By pairs of searches that follow each other; a pair without a free way is not there.

    `approach`: shape (n, 3).
    `R`: shape (n, 3, 3). Axes of the tool as columns.
    """
    n = len(approach)
    ways: dict[tuple[int, int], FloatArray] = {}
    cost = np.zeros((n, n))
    for i, j in combinations(range(n), 2):
        turn = float(np.linalg.norm(log_rotation(R[i].T @ R[j]))) * TURN_MM_PER_RAD
        found = air.way(approach[i], R[i], approach[j], R[j])
        if found is None:
            cost[i, j] = cost[j, i] = 1e9
            continue
        ways[i, j], ways[j, i] = found, found[::-1]
        points = np.concatenate([approach[i : i + 1], found, approach[j : j + 1]])
        cost[i, j] = cost[j, i] = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()) + turn
    return shortest_order(cost), ways


def shortest_order(cost: FloatArray, *, first: int | None = None) -> IntArray:
    """Return the shortest open way through all places, shape (n,).

    `cost`: shape (n, n). Of the way between two of them, the same in both directions.
    """
    return _by_subsets(cost, first) if len(cost) <= MOST_EXACT else _by_reversals(cost, first)


def _by_subsets(cost: FloatArray, first: int | None) -> IntArray:
    """Return the shortest open way through all (Held and Karp 1962)."""
    n = len(cost)
    best = {(1 << i, i): (0.0 if first in (None, i) else NOT_FIRST, -1) for i in range(n)}
    for size in range(2, n + 1):
        for some in combinations(range(n), size):
            mask = sum(1 << i for i in some)
            for last in some:
                before = mask & ~(1 << last)
                options = [(best[before, k][0] + cost[k, last], k) for k in some if k != last]
                best[mask, last] = min(options)
    mask = (1 << n) - 1
    last = min(range(n), key=lambda k: best[mask, k][0])
    order = list[int]()
    while last >= 0:
        order.append(last)
        mask, last = mask & ~(1 << last), best[mask, last][1]
    return np.array(order[::-1], dtype=np.int64)


def _by_reversals(cost: FloatArray, first: int | None) -> IntArray:
    n = len(cost)
    order = [first or 0]
    left = set(range(n)) - set(order)
    while left:
        order.append(min(left, key=lambda k: (cost[order[-1], k], k)))
        left.discard(order[-1])

    def length(one: list[int]) -> float:
        return float(cost[one[:-1], one[1:]].sum())

    improved = True
    while improved:
        improved = False
        for i, j in combinations(range(0 if first is None else 1, n), 2):
            other = order[:i] + order[i : j + 1][::-1] + order[j + 1 :]
            if length(other) < length(order) - 1e-9:
                order, improved = other, True
    return np.array(order, dtype=np.int64)
