"""A roadmap of free states: it grows from both ends of a question by batches of moves, and is kept for the next one.

The ends are joined as in RRT-Connect (Kuffner, LaValle, 2000): a tree at each end grows towards random states and
towards the other tree. Here the trees are parts of one graph that holds all states of all questions, many branches are
tried in one call of the collision check, and a branch keeps the length that is proved free. Random numbers are seeded,
and the search ends after a number of branches, never after a time.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.planning.cell.cell import Cell
from wpcal.planning.sequence.motion_check import MotionChecker

SCALE_MM = 1000.0  #: One unit of the scaled axes is this much motion of the outermost body.
RANGE = 0.9  #: Longest branch, in scaled axes.
LEAST = 0.03  #: Shorter branches are dropped: 30 mm of motion of the outermost body.
BRANCHES = 16  #: Branches of each tree per round.
LINKS = 1  #: Nearest states outside of its tree that a new state is linked to, if the way is free.
FIRST_LINKS = 12  #: The same for the two ends of a question.
MOST_ROUNDS = 150  #: Rounds before the search gives up.
FEW_ROUNDS = 10  #: The same between two trees that an earlier question did not join: one of them is shut in.
TRUST = 5.0
"""While the graph grows, bodies may move this much farther between measured states than is proved: the bound adds up
the motion of all axes, so little is wrong. The moves of the way that is found are then proved one by one."""
TOWARDS_OTHER = 4  #: Of this many branches one grows towards a state of the other tree.
SMALL = 400
"""A tree with fewer states may be shut in a narrow place: half of its branches are short ones around its own states."""


class Roadmap:
    """Free states and free straight moves between them."""

    def __init__(self, cell: Cell, checker: MotionChecker, seed: int) -> None:
        self.checker = checker
        self.scale = np.maximum(checker.per_axis, 1e-3) / SCALE_MM
        self._rng = np.random.default_rng(seed)
        self._limits = tuple(limit * self.scale for limit in cell.limits)
        self._x = np.zeros((0, len(self.scale)))  # scaled states
        self._tree = np.zeros(0, dtype=np.int64)  # the same number for states that are joined
        self._moves: list[tuple[int, int]] = []
        self._apart: list[tuple[int, int]] = []  # ends of questions without an answer

    def way(self, start: FloatArray, end: FloatArray) -> FloatArray | None:
        """Return a free way of straight moves, shape (m, k). None: none was found.

        `start`, `end`: shape (k,). Clear states, rad and mm.
        """
        ends = [self._known(q * self.scale) for q in (start, end)]
        self._link(np.array(ends), FIRST_LINKS)
        for _ in range(FEW_ROUNDS if self._is_apart(*ends) else MOST_ROUNDS):
            if self._tree[ends[0]] == self._tree[ends[1]]:
                rows = self._shortest(*ends)
                way = np.concatenate([start[None], self._x[rows[1:-1]] / self.scale, end[None]])
                proved = np.array([self.checker.is_free(a, b) for a, b in itertools.pairwise(way)])
                if proved.all():
                    return way
                wrong = {tuple(sorted(rows[k : k + 2].tolist())) for k in np.flatnonzero(~proved).tolist()}
                self._moves = [move for move in self._moves if tuple(sorted(move)) not in wrong]
                self._tree = connected_components(self._graph(), directed=False)[1].astype(np.int64)
            else:
                self._grow(*ends)
        self._apart.append((ends[0], ends[1]))
        return None

    def is_shut_in(self, q: FloatArray, home: FloatArray) -> bool:
        """Tell whether no way was found between the trees of two states, shape (k,) each: one of them is shut in."""
        self._link(np.array(ends := [self._known(each * self.scale) for each in (q, home)]), FIRST_LINKS)
        return self._is_apart(*ends)

    def _is_apart(self, one: int, other: int) -> bool:
        return {*self._tree[[one, other]].tolist()} in [{*self._tree[[*ends]].tolist()} for ends in self._apart]

    def _known(self, x: FloatArray) -> int:
        """Return the number of a state, which is added if it is new."""
        same = np.flatnonzero((self._x == x).all(axis=1))
        return int(same[0]) if len(same) else int(self._add(x[None])[0])

    def _add(self, x: FloatArray) -> IntArray:
        rows = np.arange(len(self._x), len(self._x) + len(x))
        free = self._tree.max(initial=-1) + 1
        self._x = np.concatenate([self._x, x])
        self._tree = np.concatenate([self._tree, np.arange(free, free + len(x))])
        return rows

    def _join(self, one: int, other: int) -> None:
        self._moves.append((one, other))
        a, b = sorted((self._tree[one], self._tree[other]))
        self._tree[self._tree == b] = a

    def _graph(self) -> Any:  # the types of SciPy's graphs do not fit those of its arrays
        n = len(self._x)
        i, j = np.array(self._moves, dtype=np.int64).reshape(-1, 2).T
        return csr_array((np.linalg.norm(self._x[i] - self._x[j], axis=1), (i, j)), shape=(n, n))

    def _grow(self, one: int, other: int) -> None:
        """Grow both trees by a batch of branches, and link what is new."""
        near, target = [], []
        for own, opposite in ((one, other), (other, one)):
            rows = np.flatnonzero(self._tree == self._tree[own])
            x = self._targets(own, opposite)
            away = ((self._x[rows][None] - x[:, None]) ** 2).sum(axis=2)
            near.append(rows[np.argmin(away, axis=1)])
            target.append(x)
        source, x = np.concatenate(near), np.concatenate(target)
        step = x - self._x[source]
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, RANGE / np.maximum(length, 1e-12))[:, None]
        share = self.checker.free_shares(
            self._x[source] / self.scale, (self._x[source] + step) / self.scale, whole=False, trust=TRUST
        )
        good = share * np.linalg.norm(step, axis=1) >= LEAST
        if not good.any():
            return
        new = self._add((self._x[source] + share[:, None] * step)[good])
        for row, before in zip(new.tolist(), source[good].tolist(), strict=True):
            self._join(before, row)
        self._link(new, LINKS)

    def _targets(self, own: int, opposite: int) -> FloatArray:
        """Return places to grow to: anywhere, with turns between those of both ends, and states of the other tree."""
        low, high = self._limits
        x = self._rng.uniform(low, high, (BRANCHES, len(low)))
        between = np.sort(self._x[[own, opposite]], axis=0)
        room = 0.25 * (high - low)
        near = self._rng.uniform(np.maximum(between[0] - room, low), np.minimum(between[1] + room, high), x.shape)
        x[1::2] = near[1::2]
        rows = np.flatnonzero(self._tree == self._tree[opposite])
        some = self._rng.integers(0, len(rows), len(x))
        x[::TOWARDS_OTHER] = self._x[rows[some]][::TOWARDS_OTHER]
        rows = np.flatnonzero(self._tree == self._tree[own])
        if len(rows) < SMALL:
            length = np.geomspace(LEAST, RANGE, len(x[::2]))[:, None]
            step = self._rng.normal(size=(len(length), len(low)))
            step *= length / np.linalg.norm(step, axis=1)[:, None]
            around = self._x[rows[self._rng.integers(0, len(rows), len(length))]] + step
            x[::2] = np.clip(around, low, high)
        return x

    def _link(self, new: IntArray, count: int) -> None:
        """Join states with the nearest ones of other trees, where the straight move is free."""
        pairs = []
        for row in new.tolist():
            others = np.flatnonzero(self._tree != self._tree[row])
            away = np.linalg.norm(self._x[others] - self._x[row], axis=1)
            pairs += [(row, int(others[k])) for k in np.argsort(away, kind="stable")[:count]]
        if not pairs:
            return
        a, b = (self._x[[pair[k] for pair in pairs]] / self.scale for k in (0, 1))
        for (one, other), share in zip(pairs, self.checker.free_shares(a, b, whole=True, trust=TRUST), strict=True):
            if share == 1.0:
                self._join(one, other)

    def _shortest(self, one: int, other: int) -> IntArray:
        """Return the states of the shortest way in the graph."""
        _, before = dijkstra(self._graph(), False, np.array([one]), True)
        way = [other]
        while way[-1] != one:
            way.append(int(before[0, way[-1]]))
        return np.array(way[::-1])
