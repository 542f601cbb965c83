"""Which of many boxes something meets: a tree of boxes as arrays, searched for many queries at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray, blocks

FAN = 8  #: Boxes in one node: with eight, 500 boxes make a tree of three levels, and a node costs eight tests.
MORTON_BITS = 10
"""Bits per coordinate for the order along the curve: 1024 cells per side, finer than the distance of neighbours."""
CHUNK = 1_000  #: Queries that go down the tree together: their data fits the processor's cache.
PAIRS = 50_000  #: Pairs of a query and a box that are compared together: more only take memory.
FAR_MM = 1e9  #: An empty box begins here, and ends here on the other side.

Meets = Callable[[IntArray, FloatArray, FloatArray], BoolArray]
"""Whether queries (numbers, shape (m,)) meet boxes (least and greatest corners, shape (3, m), a coordinate per row)."""


@dataclass(frozen=True, slots=True, eq=False)
class BoxTree:
    """Boxes, eight of them in a larger one, eight of those in a still larger one, and so on."""

    #: shape (n,). Numbers of the boxes in the order of the lowest level: along a Morton curve, which keeps neighbours
    #: together.
    order: IntArray
    #: Least and greatest corners of the boxes of each level, shapes (3, m), the lowest level first.
    levels: tuple[tuple[FloatArray, FloatArray], ...]

    @classmethod
    def of(cls, low: FloatArray, high: FloatArray) -> BoxTree:
        """Build the tree.

        `low`, `high`: shape (n, 3). Least and greatest corner of each box. A query never meets an empty box (low >
        high).
        """
        real = np.flatnonzero((low <= high).all(axis=1))
        order = real[np.argsort(_morton((low[real] + high[real]) / 2), kind="stable")]
        levels = [(np.ascontiguousarray(low[order].T), np.ascontiguousarray(high[order].T))]
        while levels[-1][0].shape[1] > FAN:
            below_low, below_high = levels[-1]
            start = np.arange(0, below_low.shape[1], FAN)
            level = np.minimum.reduceat(below_low, start, axis=1), np.maximum.reduceat(below_high, start, axis=1)
            levels.append(level)
        return cls(order, tuple(levels))

    def without(self, left_out: BoolArray) -> BoxTree:
        """Return the tree with some boxes empty (mask over all boxes, shape (n,)), so that no query meets them."""
        gone = left_out[self.order]
        low, high = self.levels[0]
        lowest = np.where(gone, FAR_MM, low), np.where(gone, -FAR_MM, high)
        return BoxTree(self.order, (lowest, *self.levels[1:]))

    def search(self, count: int, meets: Meets) -> tuple[IntArray, IntArray]:
        """Find all pairs of a query and a box that it meets.

        Returns `query`, `box`: ndarray of int, shape (k,). Sorted by query, then box.
        """
        rows = np.arange(count if len(self.order) else 0)
        found = [self._down(rows[some], meets) for some in blocks(len(rows), CHUNK)]
        query, box = (np.concatenate(column) for column in zip(*found, strict=True))
        order = np.lexsort((box, query))
        return query[order], box[order]

    def meeting(self, low: FloatArray, high: FloatArray) -> tuple[IntArray, IntArray]:
        """Find all pairs of a given box and a box of the tree that touch or overlap.

        `low`, `high`: shape (n, 3). Least and greatest corner of each given box.
        Returns `query`, `box`: ndarray of int, shape (k,). Sorted by query, then box.
        """
        low, high = np.ascontiguousarray(low.T), np.ascontiguousarray(high.T)
        return self.search(low.shape[1], lambda query, *of: are_met(low[:, query], high[:, query], *of))

    def _down(self, queries: IntArray, meets: Meets) -> tuple[IntArray, IntArray]:
        """Take queries from the top to the lowest level, where the nodes are the boxes."""
        top = self.levels[-1][0].shape[1]
        query, node = np.repeat(queries, top), np.tile(np.arange(top), len(queries))
        for number, (low, high) in reversed(list(enumerate(self.levels))):
            rows = blocks(len(query), PAIRS)
            ends = ((np.take(corner, node[some], axis=1) for corner in (low, high)) for some in rows)
            met = np.concatenate([meets(query[some], *of) for some, of in zip(rows, ends, strict=True)])
            query, node = query[met], node[met]
            if number:
                below = self.levels[number - 1][0].shape[1]
                query, node = np.repeat(query, FAN), (node[:, None] * FAN + np.arange(FAN)).ravel()
                query, node = query[node < below], node[node < below]
        return query, self.order[node]


def are_met(low: FloatArray, high: FloatArray, other_low: FloatArray, other_high: FloatArray) -> BoolArray:
    """Tell which boxes touch or overlap the others, shape (m,); corners of shape (3, m)."""
    met = [(low[k] <= other_high[k]) & (high[k] >= other_low[k]) for k in range(3)]
    return np.asarray(met[0] & met[1] & met[2])  # `all` along an axis of three takes five times as long


def _morton(points: FloatArray) -> IntArray:
    """Return each point's place on a Morton curve through the box around all of them."""
    if len(points) == 0:
        return np.zeros(0, dtype=np.int64)
    size = np.ptp(points, axis=0)
    cell = (points - points.min(axis=0)) / np.where(size > 0, size, 1.0) * (2**MORTON_BITS - 1)
    cells = cell.astype(np.int64)
    bits = (cells[:, :, None] >> np.arange(MORTON_BITS)) & 1
    place = 3 * np.arange(MORTON_BITS) + np.arange(3)[:, None]
    return np.asarray((bits << place).sum(axis=(1, 2)), dtype=np.int64)
